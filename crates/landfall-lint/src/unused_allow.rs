//! `unused-allow`.

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;

pub(super) const LINT: Lint = Lint {
    code: "unused-allow",
    level: Level::Warn,
    what: "a `// landfall: allow(code)` comment that suppresses nothing, or names no lint",
    why: "The finding that it suppressed was fixed or has moved. Left in place, the comment hides \
          the next finding of that lint there, and one with a misspelt code hides nothing at all. \
          A warning, because the comment itself breaks nothing. Not reported for lints that the \
          run does not include.",
    example: "\
#version 450
// landfall: allow(stale-comment)
layout(std140, binding = 0) uniform Light {
    vec4 color;
};
void main() {}
",
    fix: "Remove the comment, or the code from its list; `--fix` does. A misspelt code is replaced \
          by that of the nearest lint.",
    // Found by `allow::unused`, after every other lint has run.
    check: Check::Elsewhere,
};
