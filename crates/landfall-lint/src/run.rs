//! Asks the lints: which of them, at which level, and without what comments allow.
//!
//! Reads [`Subject`]s and [`Settings`]; the command renders what comes back.

use super::allow::{allows, suppress};
use super::settings::Settings;
use super::{Check, LINTS, Subject, lint};
use landfall_layout::finding::{Finding, Level};

/// The level a lint has under these settings; findings that are no lint's are warnings.
pub fn level(code: &str, settings: &Settings) -> Level {
    let lint = lint(code);
    let mut level = lint.map_or(Level::Warn, |lint| lint.level_under(settings));
    for (whose, said) in &settings.levels {
        let meant = match whose.as_str() {
            "all" => lint.is_some(),
            "warnings" => level == Level::Warn,
            whose => whose == code,
        };
        if meant {
            level = *said;
        }
    }
    level
}

/// What lints find in one shader, without what its comments allow.
pub fn shader(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    let mut findings = ask_shader(subject, settings);
    suppress(&mut findings, &mut allows(&subject.shader.files, subject.shader.language));
    findings
}

/// What lints find by looking at all shaders of a run, without what comments allow.
pub fn tree(subjects: &[Subject<'_>], settings: &Settings) -> Vec<Finding> {
    let mut findings = ask_tree(subjects, settings);
    if findings.is_empty() {
        return findings;
    }
    for subject in subjects {
        suppress(&mut findings, &mut allows(&subject.shader.files, subject.shader.language));
    }
    findings
}

/// What lints find in one shader, allowed by comments or not.
pub fn ask_shader(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut hazards = Vec::new();
    for lint in LINTS {
        match lint.check {
            Check::Shader(check) if level(lint.code, settings) > Level::Allow => {
                findings.extend(check(subject, settings));
            }
            Check::Hazard(kind) if level(lint.code, settings) > Level::Allow => hazards.push(kind),
            Check::Shader(_) | Check::Hazard(_) | Check::Tree(_) | Check::Elsewhere => {}
        }
    }
    findings.extend(super::hazards::findings(subject, &hazards));
    at_levels(findings, settings)
}

/// What lints find by looking at all shaders, allowed by comments or not.
pub fn ask_tree(subjects: &[Subject<'_>], settings: &Settings) -> Vec<Finding> {
    let mut findings = Vec::new();
    for lint in LINTS {
        match lint.check {
            Check::Tree(check) if level(lint.code, settings) > Level::Allow => {
                findings.extend(check(subjects, settings));
            }
            Check::Shader(_) | Check::Hazard(_) | Check::Tree(_) | Check::Elsewhere => {}
        }
    }
    at_levels(findings, settings)
}

/// Findings at the levels these settings give them, those at `allow` left out.
pub fn at_levels(mut findings: Vec<Finding>, settings: &Settings) -> Vec<Finding> {
    findings.retain_mut(|finding| {
        finding.level = level(&finding.code, settings);
        finding.level > Level::Allow
    });
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(levels: &[(&str, Level)]) -> Settings {
        let levels = levels.iter().map(|(code, level)| (code.to_string(), *level)).collect();
        Settings { levels, ..Settings::default() }
    }

    #[test]
    fn a_later_level_holds_over_an_earlier_one() {
        let said = settings(&[("unused-allow", Level::Deny), ("unused-allow", Level::Allow)]);
        assert_eq!(level("unused-allow", &said), Level::Allow);
        assert_eq!(level("unused-allow", &settings(&[])), Level::Warn);
    }

    #[test]
    fn warnings_are_the_lints_at_warn_by_then() {
        let denied = settings(&[("warnings", Level::Deny)]);
        assert_eq!(level("unused-allow", &denied), Level::Deny);
        let off = settings(&[("unused-allow", Level::Allow), ("warnings", Level::Deny)]);
        assert_eq!(level("unused-allow", &off), Level::Allow);
        let back = settings(&[("warnings", Level::Deny), ("unused-allow", Level::Warn)]);
        assert_eq!(level("unused-allow", &back), Level::Warn);
    }

    #[test]
    fn all_means_every_lint_and_findings_of_no_lint_are_warnings() {
        let all = settings(&[("all", Level::Deny)]);
        assert!(LINTS.iter().all(|lint| level(lint.code, &all) == Level::Deny));
        assert_eq!(level("offset-goes-back", &settings(&[])), Level::Warn);
    }
}
