//! `lock-missing`: a shader with blocks but without a lock. Found by [`crate::drift`].

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;

pub(super) const LINT: Lint = Lint {
    code: "lock-missing",
    // A new shader is not an error, but its layout is not guarded yet.
    level: Level::Warn,
    what: "a shader with blocks or loose uniforms but without a lock",
    why: "Without a lock there is nothing to compare the layout with: its next change is merged \
          unnoticed.",
    example: "#version 330 core\n\
              layout(std140) uniform View {\n    \
                  mat4 view;\n\
              };\n\
              void main() {}\n",
    fix: "Write the lock with `landfall lock` and commit it with the shader.",
    check: Check::Elsewhere,
};
