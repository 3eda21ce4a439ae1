//! `vec3-array`.

use super::{Check, Finding, Level, Lint, Settings, Subject};

pub(super) const LINT: Lint = Lint {
    code: "vec3-array",
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
