//! `lock-orphan`: a lock has no shader. Found by [`landfall_layout::lock::orphan`].

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;

pub(super) const LINT: Lint = Lint {
    code: "lock-orphan",
    // It guards nothing and harms nothing, until somebody takes it for the truth.
    level: Level::Warn,
    what: "a lock's shader does not exist",
    why: "The shader was removed or renamed and its lock was left behind: a rename without its \
          lock starts an unguarded layout, and a reader may take the record for a shader's.",
    example: "layouts/lights/old.frag.json is there, shaders/lights/old.frag is not.\n",
    fix: "Rename the lock with its shader, or remove it with `landfall lock --prune`.",
    check: Check::Elsewhere,
};
