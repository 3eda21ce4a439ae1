//! Runs the enabled lints at their levels, and drops the findings that comments allow.
//!
//! Reads [`Subject`]s and [`Settings`]; the command renders the findings.

use super::allow::{allows, suppress};
use super::definition::{Check, Subject};
use super::levels::{at_levels, level};
use super::registry::LINTS;
use super::settings::Settings;
use landfall_layout::finding::{Finding, Level};

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
    for subject in subjects {
        suppress(&mut findings, &mut allows(&subject.shader.files, subject.shader.language));
    }
    findings
}

/// Returns the findings in one shader, including those that comments allow.
pub fn shader_unsuppressed(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    let mut findings = Vec::new();
    let wanted = || LINTS.iter().filter(|lint| level(lint.code, settings) > Level::Allow);
    for lint in wanted().filter(|lint| lint.is_built()) {
        if let Check::Shader(check) | Check::Naga(check) = lint.check {
            findings.extend(check(subject, settings));
        }
    }
    #[cfg(feature = "analysis")]
    {
        let kinds = wanted().filter_map(|lint| match lint.check {
            Check::Hazard(kind) => Some(kind),
            _ => None,
        });
        findings.extend(super::hazards::findings(subject, &kinds.collect::<Vec<_>>()));
    }
    at_levels(findings, settings)
}

/// Returns the findings of lints over all shaders, including those that comments allow.
pub fn tree_unsuppressed(subjects: &[Subject<'_>], settings: &Settings) -> Vec<Finding> {
    let mut findings = Vec::new();
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
