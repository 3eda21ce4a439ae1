//! `buffer-too-small`.

use super::{Check, Finding, Level, Lint, Settings, Subject};

pub(super) const LINT: Lint = Lint {
    code: "buffer-too-small",
    level: Level::Warn,
    what: "",
    why: "",
    example: "",
    fix: "",
    check: Check::Tree(check),
};

fn check(_subjects: &[Subject<'_>], _settings: &Settings) -> Vec<Finding> {
    Vec::new()
}
