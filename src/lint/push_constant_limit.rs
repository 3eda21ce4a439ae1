//! `push-constant-limit`.

use super::{Check, Finding, Level, Lint, Settings, Subject};

pub(super) const LINT: Lint = Lint {
    code: "push-constant-limit",
    level: Level::Warn,
    what: "",
    why: "",
    example: "",
    fix: "",
    check: Check::Shader(check),
};

fn check(_subject: &Subject<'_>, _settings: &Settings) -> Vec<Finding> {
    Vec::new()
}
