//! `layout-drift`.

use super::{Check, Level, Lint};

pub(super) const LINT: Lint = Lint {
    code: "layout-drift",
    level: Level::Warn,
    what: "",
    why: "",
    example: "",
    fix: "",
    check: Check::Elsewhere,
};
