//! Runs the enabled lints at their levels, and drops the findings that comments allow.
//!
//! Reads [`Subject`]s and [`Settings`]; the command renders the findings.

use super::allow::{allows, suppress};
use super::definition::{Check, Subject};
use super::invalid_shader::Functions;
use super::levels::{at_levels, level};
use super::registry::{LINTS, lint};
use super::settings::Settings;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::source::Language;

/// The most errors that are reported of a shader.
pub const MAX_ERRORS: usize = 100;

/// Returns the findings in one shader, without those that its comments allow.
pub fn shader(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    let mut findings = shader_unsuppressed(subject, settings);
    suppress(&mut findings, &mut allows(&subject.shader.files, subject.shader.language));
    findings
}

/// Returns the findings of lints over all shaders of a run, without those that comments allow.
pub fn tree(subjects: &[Subject<'_>], settings: &Settings) -> Vec<Finding> {
    let mut findings = tree_unsuppressed(subjects, settings);
    if findings.is_empty() {
        return findings;
    }
    // A finding may be in a file of any of them.
    for subject in subjects {
        suppress(&mut findings, &mut allows(&subject.shader.files, subject.shader.language));
    }
    findings
}

/// The lints of one shader that are about SPIR-V modules as well; the others advise on a text.
const OF_MODULES: &[&str] = &["buffer-too-small", "over-limit", "push-constant-limit"];

/// Returns the findings in one shader, including those that comments allow.
pub fn shader_unsuppressed(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    let mut findings = Vec::new();
    let is_module = subject.shader.language == Language::SpirV;
    let applies = |code: &str| !is_module || OF_MODULES.contains(&code);
    let wanted = || {
        let wanted = LINTS.iter().filter(|lint| level(lint.code, settings) > Level::Allow);
        wanted.filter(|lint| applies(lint.code))
    };
    let functions = match wanted().any(|lint| matches!(lint.check, Check::Functions)) {
        true => Functions::read(subject.source, subject.options),
        false => Functions::default(),
    };
    for lint in wanted().filter(|lint| lint.is_built()) {
        match lint.check {
            Check::Shader(check) | Check::Naga(check) => findings.extend(check(subject, settings)),
            Check::Functions => findings.extend(functions.findings(subject)),
            Check::Tree(_) | Check::Hazard(..) | Check::Elsewhere => {}
        }
    }
    // What no compiler takes cannot be followed either: that is one finding.
    #[cfg(feature = "analysis")]
    if !is_module && functions.errors.is_empty() {
        let kinds = wanted().filter_map(|lint| match lint.check {
            Check::Hazard(kind, _) => Some(kind),
            _ => None,
        });
        let kinds: Vec<_> = kinds.collect();
        findings.extend(super::hazard_findings::findings(subject, functions.module, &kinds));
    }
    if is_module {
        let path = &subject.shader.path;
        findings = findings.into_iter().map(|finding| finding.of_binary(path)).collect();
    }
    at_levels(findings, settings)
}

/// Returns the findings of lints over all shaders, including those that comments allow.
pub fn tree_unsuppressed(subjects: &[Subject<'_>], settings: &Settings) -> Vec<Finding> {
    let mut findings = Vec::new();
    // A module repeats the blocks of the text that it was compiled from.
    let is_text = |subject: &&Subject<'_>| subject.shader.language != Language::SpirV;
    let texts: Vec<Subject<'_>> = subjects.iter().filter(is_text).copied().collect();
    let subjects = texts.as_slice();
    for lint in LINTS {
        match lint.check {
            Check::Tree(check) if level(lint.code, settings) > Level::Allow => {
                findings.extend(check(subjects, settings));
            }
            _ => {}
        }
    }
    at_levels(findings, settings)
}

/// Sorts findings by place and removes duplicates, as from an include of two shaders.
pub fn sorted(mut findings: Vec<Finding>) -> Vec<Finding> {
    fn order(f: &Finding) -> (&str, u32, u32, &str, &str, &str, u32) {
        let place = &f.place();
        (&place.path, place.line, place.column, &f.code, &f.about, &f.message, place.end)
    }
    findings.sort_by(|a, b| order(a).cmp(&order(b)));
    // A finding in an include comes from every shader, with the names of its own blocks.
    findings.dedup_by(|a, b| a == b || a.place().line > 0 && order(a) == order(b));
    findings
}

/// Whether a lint ran, so that an `allow` comment for it can be reported as unused: in a run over
/// all shaders (`whole`), and one that compares locks.
pub fn has_run(code: &str, whole: bool, locks: bool) -> bool {
    match lint(code).filter(|lint| lint.is_built()).map(|lint| lint.check) {
        Some(Check::Shader(_) | Check::Functions | Check::Naga(_) | Check::Hazard(..)) => true,
        // The other copy may be in a file that was not checked.
        Some(Check::Tree(_)) => whole,
        Some(Check::Elsewhere) => locks && (code == "layout-drift" || code == "lock-missing"),
        None => false,
    }
}
