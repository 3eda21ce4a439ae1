//! Converts mismatches in reports of `landfall verify` to findings at the members.

use std::path::{Path, PathBuf};

use landfall_layout::finding::Finding;
use landfall_layout::{Error, ShaderLayout, layout};
use landfall_lint::driver_disagrees;

use crate::files;
use crate::pass::{CheckRun, Pass};

/// The findings of all reports for the shaders of this check.
pub fn findings(
    reports: &[PathBuf],
    pass: &Pass,
    check: &CheckRun<'_>,
) -> Result<Vec<Finding>, Error> {
    let mut found = Vec::new();
    for path in reports {
        let report = driver_disagrees::read(&files::display_path(path), &files::text(path)?)?;
        let shaders: Vec<(String, ShaderLayout)> = report
            .paths()
            .filter_map(|path| {
                let shown = check.config.root.show(Path::new(path));
                // Without a layout free of errors, there is nothing to show.
                let checked = pass.checked.iter().find(|c| c.path == shown && !c.failed)?;
                let source = check.source(&checked.path)?;
                Some((path.to_string(), layout(&source, &check.options())))
            })
            .collect();
        found.extend(report.findings(&|path| {
            shaders.iter().find(|(known, _)| known == path).map(|(_, shader)| shader)
        }));
    }
    Ok(found)
}
