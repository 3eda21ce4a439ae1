//! `unused-allow`.

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;

pub(super) const LINT: Lint = Lint {
    code: "unused-allow",
    level: Level::Warn,
    what: "a `// landfall: allow(code)` comment that suppresses nothing, or names no lint",
    why: "What it once suppressed was mended or has moved away; left in place it hides the next \
          finding of that lint there, and a misspelt code hides nothing at all. Warned of, since \
          the comment itself breaks nothing; not for lints that the run does not ask.",
    example: "\
#version 450
// landfall: allow(stale-comment)
layout(std140, binding = 0) uniform Light {
    vec4 color;
};
void main() {}
",
    fix: "Remove the comment, or the code from its list; `--fix` does. A misspelt code becomes \
          the lint it is nearest to.",
    // Found by `allow::unused`, once every other lint has been asked.
    check: Check::Elsewhere,
};
