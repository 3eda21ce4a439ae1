//! Structures of specialisation constants and overrides, and their values as wgpu takes them.

use std::fmt::Write as _;

use landfall_layout::diagnostic::{Code, Diagnostic};
use landfall_layout::shape::{Scalar, ScalarKind};
use landfall_layout::text::escape;

use super::super::names::{Scope, camel, snake};
use super::program::ProgramShader;
use super::text::{Module, PUB};

/// The Rust type of a constant; `None` for those that wgpu cannot set.
// A pipeline takes all constants as `f64`, which holds these exactly.
fn rust_type(scalar: Scalar) -> Option<&'static str> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => Some("bool"),
        (ScalarKind::Sint, 4) => Some("i32"),
        (ScalarKind::Uint, 4) => Some("u32"),
        (ScalarKind::Float, 2 | 4) => Some("f32"),
        _ => None,
    }
}

/// Prints the constants of a shader; those of one of several shaders are named after its stage. Returns
/// whether there are any.
pub(super) fn structure(
    shader: &ProgramShader<'_>,
    several: bool,
    scope: &mut Scope,
    out: &mut Module,
    found: &mut Vec<Diagnostic>,
) -> bool {
    let Some(interface) = &shader.layout.interface else { return false };
    let mut fields = String::new();
    let mut pushes = String::new();
    let mut names = Scope::default();
    let mut needed = false;
    for one in &interface.constants {
        let shown = escape::name(&one.name);
        let Some(ty) = one.scalar.and_then(rust_type) else {
            let message = format!("the type of constant `{shown}` is not one that wgpu can set");
            let error = Diagnostic::error(Code::NoBinding, one.span, message);
            let error = error.with_help("write its type: `f32`, `i32`, `u32` or `bool`");
            found.push(Diagnostic { path: Some(shader.layout.path.clone()), ..error });
            continue;
        };
        let name = names.take(&snake(&one.name));
        // WebGPU: a constant with a number is set by it, others by name.
        let key = one.id.map_or_else(|| one.name.to_string(), |id| id.to_string());
        if one.has_default {
            let _ = writeln!(
                fields,
                "    /// `{shown}`; `None` for the shader's default.\n    {PUB} {name}: Option<{ty}>,"
            );
            let _ = write!(
                pushes,
                "        if let Some({name}) = self.{name} {{\n            \
                 all.push(({key:?}, f64::from({name})));\n        }}\n"
            );
        } else {
            needed = true;
            let _ = writeln!(fields, "    /// `{shown}`.\n    {PUB} {name}: {ty},");
            let _ = writeln!(pushes, "        all.push(({key:?}, f64::from(self.{name})));");
        }
    }
    if fields.is_empty() {
        return false;
    }
    let stage = shader.entries.first().and_then(|entry| entry.stage).filter(|_| several);
    // Shaders of one program are in one module.
    let of = stage.map_or(String::new(), |stage| camel(stage.name()));
    let name = scope.take(&format!("{of}Constants"));
    let default = if needed { "" } else { "Default, " };
    out.item(
        "Values of constants that a pipeline sets.",
        &format!(
            "#[derive(Clone, Copy, Debug, {default}PartialEq)]\n{PUB} struct {name} {{\n{fields}}}"
        ),
    );
    out.item(
        "",
        &format!(
            "impl {name} {{\n    /// The values, as `PipelineCompilationOptions::constants` takes \
             them.\n    {PUB} fn entries(&self) -> Vec<(&'static str, f64)> {{\n        \
             let mut all = Vec::new();\n{pushes}        all\n    }}\n}}"
        ),
    );
    true
}
