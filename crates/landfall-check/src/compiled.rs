//! Compares the modules of `[[compiled]]` with the texts that they were compiled from.

use landfall_layout::finding::{Finding, Level};
use landfall_layout::{Severity, ShaderLayout};
use landfall_lint::settings::CompiledShader;
use landfall_lint::{compiled_differs, levels};

use crate::basis::Basis;
use crate::pass::{CheckRun, Pass};

/// The findings for the rows whose text or module is checked; for all in a check of all shaders.
pub fn findings(pass: &Pass, check: &CheckRun<'_>) -> Vec<Finding> {
    let basis = check.basis;
    if levels::level(compiled_differs::LINT.code, &basis.settings) == Level::Allow {
        return Vec::new();
    }
    let is_checked = |row: &&CompiledShader| {
        let mut checked = pass.checked.iter().map(|checked| &checked.path);
        basis.scope.whole || checked.any(|path| *path == row.source || *path == row.spirv)
    };
    basis.settings.compiled.iter().filter(is_checked).flat_map(|row| of_row(row, basis)).collect()
}

fn of_row(row: &CompiledShader, basis: &Basis) -> Vec<Finding> {
    let layouts = laid_out(&row.source, basis)
        .map_err(|why| compiled_differs::not_compared(row, &row.source, &why))
        .and_then(|text| {
            let module = laid_out(&row.spirv, basis);
            let module =
                module.map_err(|why| compiled_differs::not_compared(row, &row.spirv, &why))?;
            Ok((text, module))
        });
    match layouts {
        Ok((text, module)) => compiled_differs::findings(row, &text, &module),
        Err(finding) => vec![finding],
    }
}

/// The layout of a file, or why it has none.
fn laid_out(path: &str, basis: &Basis) -> Result<ShaderLayout, String> {
    let source = basis.read(path.as_ref(), None).map_err(|error| error.message)?;
    let shader = basis.settings.layout(&source, &basis.options);
    match shader.diagnostics.iter().find(|found| found.severity == Severity::Error) {
        Some(error) => Err(error.message.clone()),
        None => Ok(shader),
    }
}
