//! `layout-drift`: a block is not what its lock says. Found by [`crate::drift`].

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;

pub(super) const LINT: Lint = Lint {
    code: "layout-drift",
    // Whoever committed a lock has asked to be told.
    level: Level::Deny,
    what: "a block is not laid out as the lock of its shader records",
    why: "Code that uploads the block was written for the recorded layout. A member that moved, \
          changed its type or is gone makes the shader read other bytes than were meant, and \
          nothing says so: a light turns black. Changes that old uploads survive (members added \
          in padding or at the end, renames) are reported as well, in words of their own, so \
          that the lock stays true.",
    example: "#version 330 core\n\
              // The lock has `count` at offset 12.\n\
              layout(std140) uniform Lights {\n    \
                  vec3 position;\n    \
                  vec3 color;\n    \
                  int count;\n\
              };\n\
              void main() {}\n",
    fix: "Undo the change, or change what uploads the block and renew the lock with \
          `landfall check --accept` or `landfall lock`; `landfall diff` shows both layouts side by \
          side.",
    check: Check::Elsewhere,
};
