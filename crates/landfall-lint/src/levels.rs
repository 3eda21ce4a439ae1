//! The level of a lint under the settings of a run.

use landfall_layout::finding::{Finding, Level};

use super::definition::Lint;
use super::layout_warnings::UNIFORM_CONSTRAINTS;
use super::naga_disagrees;
use super::registry::lint;
use super::settings::{Settings, Target};
use landfall_layout::text::glob;

impl Lint {
    /// Returns the level under these settings before they set one for the lint's code.
    pub fn level_under(&self, settings: &Settings) -> Level {
        // For the target `webgpu`, what wgpu misreads is certainly wrong.
        if self.code == naga_disagrees::CODE && settings.targets.contains(&Target::WebGpu) {
            return Level::Deny;
        }
        // A target whose compilers take such blocks, and none that refuses them.
        let is_taken = !settings.targets.is_empty() && !settings.targets.contains(&Target::WebGpu);
        if self.code == UNIFORM_CONSTRAINTS.code && is_taken {
            return Level::Warn;
        }
        self.level
    }
}

/// Returns the highest level of a lint in any file; `warn` for codes that are not a lint's.
pub fn level(code: &str, settings: &Settings) -> Level {
    // Which rows a file matches is not known, so every set of rows is tried; there are few levels.
    let mut reached = vec![base(code, settings)];
    for row in &settings.path_levels {
        let more: Vec<Level> = reached.iter().map(|at| set(*at, code, &row.levels)).collect();
        reached.extend(more);
        reached.sort_unstable();
        reached.dedup();
    }
    let reached = reached.into_iter().map(|at| set(at, code, &settings.flag_levels));
    reached.max().unwrap_or(Level::Warn)
}

/// Returns the level of a lint in a file; `warn` for codes that are not a lint's.
pub fn level_in(code: &str, path: &str, settings: &Settings) -> Level {
    // The configuration first, then the rows of the file, then the flags.
    let rows = settings.path_levels.iter().filter(|row| glob::matches(&row.file, path));
    let level = rows.fold(base(code, settings), |level, row| set(level, code, &row.levels));
    set(level, code, &settings.flag_levels)
}

fn base(code: &str, settings: &Settings) -> Level {
    let level = lint(code).map_or(Level::Warn, |lint| lint.level_under(settings));
    set(level, code, &settings.levels)
}

/// Applies levels to that of a code.
fn set(level: Level, code: &str, levels: &[(String, Level)]) -> Level {
    levels.iter().fold(level, |level, (whose, said)| {
        let meant = match whose.as_str() {
            "all" => lint(code).is_some(),
            "warnings" => level == Level::Warn,
            whose => whose == code,
        };
        if meant { *said } else { level }
    })
}

/// Returns the findings with their levels under these settings, without those at `allow`.
pub fn at_levels(mut findings: Vec<Finding>, settings: &Settings) -> Vec<Finding> {
    findings.retain_mut(|finding| {
        let severity = level_in(&finding.code, &finding.place().path, settings).severity();
        finding.severity = severity.unwrap_or(finding.severity);
        severity.is_some()
    });
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::LINTS;
    use crate::settings::PathLevels;

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

    #[test]
    fn levels_of_files_stand_between_the_configuration_and_the_flags() {
        let row = |file: &str, levels: &[(&str, Level)]| PathLevels {
            file: file.to_string(),
            levels: settings(levels).levels,
        };
        let said = Settings {
            path_levels: vec![
                row("old/**", &[("warnings", Level::Allow)]),
                row("old/new/*", &[("stale-comment", Level::Deny)]),
            ],
            ..settings(&[("unused-allow", Level::Deny)])
        };
        let of = |code: &str, path: &str| level_in(code, path, &said);
        assert_eq!(of("stale-comment", "a.frag"), Level::Warn);
        assert_eq!(of("stale-comment", "old/a.frag"), Level::Allow);
        assert_eq!(of("stale-comment", "../old/new/a.frag"), Level::Deny);
        assert_eq!(of("unused-allow", "old/a.frag"), Level::Deny, "no warning by then");
        assert_eq!(level("stale-comment", &said), Level::Deny);
        let flags = settings(&[("all", Level::Warn), ("stale-comment", Level::Allow)]).levels;
        let said = Settings { flag_levels: flags, ..said };
        assert_eq!(level("stale-comment", &said), Level::Allow);
        assert_eq!(level_in("unused-allow", "old/a.frag", &said), Level::Warn);
        let off = Settings {
            path_levels: vec![row("a/*", &[("mat3-padding", Level::Warn)])],
            ..settings(&[("all", Level::Allow)])
        };
        assert_eq!(level("mat3-padding", &off), Level::Warn, "it has to run");
        assert_eq!(level_in("mat3-padding", "b/x.frag", &off), Level::Allow);
    }
}
