//! `layout-drift`: a block whose layout differs from its lock. Found by [`crate::drift`].

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;

pub(super) const LINT: Lint = Lint {
    code: "layout-drift",
    // A committed lock states that the layout must not change unnoticed.
    level: Level::Deny,
    what: "a block whose layout differs from the one that its shader's lock records",
    why: "Code that uploads the block was written for the recorded layout. A member that moved, \
          changed its type or was removed makes the shader read the wrong bytes, without any \
          error: a light turns black. Changes that existing uploads survive (members added in \
          padding or at the end, renames) are reported too, with a message of their own, so that \
          the lock stays true.",
    example: "#version 330 core\n\
              // The lock has `count` at offset 12.\n\
              layout(std140) uniform Lights {\n    \
                  vec3 position;\n    \
                  vec3 color;\n    \
                  int count;\n\
              };\n\
              void main() {}\n",
    fix: "Undo the change, or change the code that uploads the block and renew the lock with \
          `landfall check --accept` or `landfall lock`; `landfall diff` shows both layouts side by \
          side.",
    check: Check::Elsewhere,
};
