//! `lock-orphan`.

use super::{Check, Level, Lint};

pub(super) const LINT: Lint = Lint {
    code: "lock-orphan",
    level: Level::Warn,
    what: "",
    why: "",
    example: "",
    fix: "",
    check: Check::Elsewhere,
};
