//! `lock-orphan`: a lock without a shader. Found by [`crate::drift`].

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;

pub(super) const LINT: Lint = Lint {
    code: "lock-orphan",
    // It guards nothing, and misleads whoever reads it.
    level: Level::Warn,
    what: "a lock whose shader does not exist",
    why: "The shader was removed or renamed without its lock. After a rename, changes of the \
          layout are no longer noticed, and the lock left behind may be taken for that of an \
          existing shader.",
    example: "layouts/lights/old.frag.json is there, shaders/lights/old.frag is not.\n",
    fix: "Rename the lock with its shader, or remove it with `landfall lock --prune`.",
    check: Check::Elsewhere,
};
