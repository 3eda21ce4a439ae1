//! Findings over all shaders: lints over all of them, locks without a shader, and unused `allow`
//! comments.
//!
//! Works on the results of a [`Pass`].

use std::path::Path;

use landfall_layout::finding::{Finding, Level};
use landfall_layout::{ShaderLayout, Source, layout, lock};
use landfall_lint::allow::{Allow, suppress, unused};
use landfall_lint::digest::{BlockDigest, shaders_to_compare};
use landfall_lint::settings::Proof;
use landfall_lint::{Subject, levels, not_proved, run};

use crate::basis::Basis;
use crate::check_shader::{Checked, sort_by_path};
use crate::config::Root;
use crate::hash::checksum;
use crate::locks::{files_below, holds_lock};
use crate::missing_includes;
use crate::pass::{CheckRun, Pass};
use crate::walk::slashes;
pub use landfall_lint::run::sorted;

/// The findings of lints over all shaders before `allow` comments, cached while no shader changes.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Remembered {
    /// The checksum of everything that they depend on.
    pub depends_on: String,
    pub findings: Vec<Finding>,
}

/// All findings of a run in their final order; updates `memory`.
///
/// `elsewhere` are the findings from reports of `verify` and from proofs.
pub fn findings(
    check: &CheckRun<'_>,
    pass: &mut Pass,
    memory: &mut Option<Remembered>,
    elsewhere: &[Finding],
) -> Vec<Finding> {
    let mut all = findings_over_all(check, pass, memory, elsewhere);
    all.extend(findings_in_shaders(pass));
    sorted(all)
}

/// The findings that depend on more than one shader, and those of `elsewhere`; updates `memory`.
pub fn findings_over_all(
    check: &CheckRun<'_>,
    pass: &mut Pass,
    memory: &mut Option<Remembered>,
    elsewhere: &[Finding],
) -> Vec<Finding> {
    let basis = check.basis;
    let depends_on = over_all_depends_on(pass, basis);
    let over_all = match memory {
        Some(remembered) if remembered.depends_on == depends_on => remembered.findings.clone(),
        _ => {
            let findings = run_tree_lints(pass, check);
            *memory = Some(Remembered { depends_on, findings: findings.clone() });
            findings
        }
    };
    let mut more = over_all;
    more.extend(levels::at_levels(orphans(basis, &check.config.root), &basis.settings));
    more.extend(levels::at_levels(unmatched_proofs(pass, basis), &basis.settings));
    more.extend(levels::at_levels(elsewhere.to_vec(), &basis.settings));
    let mut allows: Vec<Allow> =
        pass.checked.iter().flat_map(|checked| checked.allows.iter().cloned()).collect();
    suppress(&mut more, &mut allows);
    // Only here is it known which comments allow nothing: those of single shaders were matched
    // before.
    more.extend(unused(&allows, &basis.settings, |code| has_run(code, basis)));
    more
}

/// The findings in single shaders.
pub fn findings_in_shaders(pass: &Pass) -> Vec<Finding> {
    let each = pass.checked.iter().flat_map(|checked| checked.findings.iter().cloned());
    let all = each.chain(pass.no_input.iter().chain(&pass.templates).cloned());
    missing_includes::joined(all.collect())
}

/// The checksum of everything that lints over all shaders depend on.
fn over_all_depends_on(pass: &Pass, basis: &Basis) -> String {
    let mut shaders: Vec<&Checked> = pass.checked.iter().filter(|c| !c.failed).collect();
    sort_by_path(&mut shaders);
    let files = shaders.into_iter().flat_map(|checked| {
        let includes = checked.includes.iter().map(|(path, hash)| (path, hash));
        std::iter::once((&checked.path, &checked.hash)).chain(includes)
    });
    let mut text: String =
        files.map(|(path, hash)| format!("{path}\0{}\n", hash.as_str())).collect();
    text.push_str(&basis.over_all());
    checksum(&text)
}

/// Runs the lints over all shaders.
fn run_tree_lints(pass: &mut Pass, check: &CheckRun<'_>) -> Vec<Finding> {
    let (basis, options) = (check.basis, &check.options());
    let checked = pass.checked.iter();
    let blocks: Vec<(&str, &[BlockDigest])> =
        checked.map(|c| (c.path.as_str(), c.blocks.get())).collect();
    let numbers = shaders_to_compare(&blocks, &basis.settings);
    let mut subjects: Vec<(Source, ShaderLayout)> = Vec::with_capacity(numbers.len());
    for number in numbers {
        // The pass keeps the layouts of the shaders that it laid out, up to a size; others are laid
        // out again.
        let laid_out = pass.laid_out.remove(&number).or_else(|| {
            let source = check.source(&pass.checked[number].path)?;
            let shader = layout(&source, options);
            Some((source, shader))
        });
        subjects.extend(laid_out.filter(|(_, shader)| !shader.has_errors()));
    }
    let subjects: Vec<Subject<'_>> =
        subjects.iter().map(|(source, shader)| Subject { source, options, shader }).collect();
    run::tree_unsuppressed(&subjects, &basis.settings)
}

/// Whether a lint ran, so that an `allow` comment for it can be reported as unused.
pub fn has_run(code: &str, basis: &Basis) -> bool {
    run::has_run(code, basis.scope.whole, basis.scope.locks.is_some())
}

/// Findings for rows of `[[prove]]` without a shader, in a check of all shaders.
fn unmatched_proofs(pass: &Pass, basis: &Basis) -> Vec<Finding> {
    let is_unmatched = |proof: &&Proof| {
        basis.scope.whole && !pass.checked.iter().any(|checked| proof.takes(&checked.path))
    };
    let unmatched = basis.settings.proofs.iter().filter(is_unmatched).map(|proof| {
        let message = format!("no shader matches `{}`", proof.file);
        let finding = not_proved::finding(&proof.function, None, &proof.place, message);
        finding.with_help("`file` is relative to the configuration, and may have `*` and `**`")
    });
    unmatched.collect()
}

/// Findings for locks without a shader in the searched directories.
fn orphans(basis: &Basis, root: &Root) -> Vec<Finding> {
    let scope = &basis.scope;
    let Some(locks) = scope.locks.as_deref().map(Path::new) else { return Vec::new() };
    if levels::level("lock-orphan", &basis.settings) == Level::Allow || scope.searched.is_empty() {
        return Vec::new();
    }
    let mut orphans = Vec::new();
    for path in files_below(locks).map(walkdir::DirEntry::into_path) {
        let Some(below) = path.strip_prefix(locks).ok().map(slashes) else { continue };
        let Some(shader) = below.strip_suffix(".json") else { continue };
        // Other files may be in the directory.
        let is_lock = lock::path_of(locks, Path::new(shader)) == path;
        let is_gone = || !root.shown.join(shader).exists();
        // A shader elsewhere was not looked for.
        if scope.is_searched(shader) && is_lock && is_gone() && holds_lock(&path) {
            orphans.push(landfall_lint::drift::orphan(&slashes(&path)));
        }
    }
    orphans
}
