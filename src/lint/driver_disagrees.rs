//! `driver-disagrees`.

use super::{Check, Level, Lint};

pub(super) const LINT: Lint = Lint {
    code: "driver-disagrees",
    level: Level::Warn,
    what: "",
    why: "",
    example: "",
    fix: "",
    check: Check::Elsewhere,
};
