//! The level of a lint under the settings of a run.

use landfall_layout::finding::{Finding, Level};

use super::definition::Lint;
use super::naga_disagrees;
use super::registry::lint;
use super::settings::{Settings, Target};

impl Lint {
    /// Returns the level under these settings before they set one for the lint's code.
    pub fn level_under(&self, settings: &Settings) -> Level {
        // For the target `webgpu`, what wgpu misreads is certainly wrong.
        if self.code == naga_disagrees::CODE && settings.targets.contains(&Target::WebGpu) {
            return Level::Deny;
        }
        self.level
    }
}

/// Returns the level of a lint under these settings; `warn` for codes that are not a lint's.
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

/// Returns the findings with their levels under these settings, without those at `allow`.
pub fn at_levels(mut findings: Vec<Finding>, settings: &Settings) -> Vec<Finding> {
    findings.retain_mut(|finding| {
        let severity = level(&finding.code, settings).severity();
        finding.severity = severity.unwrap_or(finding.severity);
        severity.is_some()
    });
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::LINTS;

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
