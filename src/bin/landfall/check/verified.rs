//! Converts mismatches in reports of `landfall verify` to findings at the members.

use std::path::{Path, PathBuf};

use landfall_layout::finding::Finding;
use landfall_layout::{Error, ShaderLayout, layout};
use landfall_lint::driver_disagrees;

use super::basis::Basis;
use super::pass::{Pass, source};
use crate::config::Root;
use crate::read;

/// The findings of all reports for the shaders of this check.
pub fn findings(
    reports: &[PathBuf],
    pass: &Pass,
    basis: &Basis,
    root: &Root,
) -> Result<Vec<Finding>, Error> {
    let mut found = Vec::new();
    for path in reports {
        let report = driver_disagrees::read(&read::display_path(path), &read::text(path)?)?;
        let shaders: Vec<(String, ShaderLayout)> = report
            .paths()
            .filter_map(|path| {
                let shown = root.show(Path::new(path));
                let checked = pass.checked.iter().find(|c| c.path == shown && !c.failed)?;
                let source = source(basis, &checked.path)?;
                Some((path.to_string(), layout(&source, &basis.options())))
            })
            .collect();
        found.extend(report.findings(&|path| {
            shaders.iter().find(|(known, _)| known == path).map(|(_, shader)| shader)
        }));
    }
    Ok(found)
}
