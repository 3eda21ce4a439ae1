//! `stale-assertions`: files of `[[assert]]` in the configuration that are not those of the shaders.
//!
//! The engine of `check` writes the assertions anew and gives what differs to [`finding`].

use super::definition::{Check, Lint};
use landfall_layout::finding::{Finding, Level, Place};

pub const LINT: Lint = Lint {
    code: "stale-assertions",
    // A program compiled with such a file is held to a layout that the shader no longer has.
    level: Level::Deny,
    what: "a file of assertions, listed in `landfall.toml`, that is not the one of the shaders",
    why: "The compiler of the program compares its structures with the numbers in the file. After a \
          change of the shader the file states the old numbers, so the program compiles and its \
          uploads land on the wrong members.",
    example: "\
#version 450
// [[assert]] with out = \"light.hpp\", which was written when `color` was not there
layout(std140, binding = 0) uniform Light { vec3 pos; float power; vec4 color; };
void main() {}
",
    fix: "Write the file with `landfall emit`, and commit it with the shader.",
    check: Check::Elsewhere,
};

/// The finding about a file that a row of the configuration names.
pub fn finding(file: &str, row: &Place, what: &str) -> Finding {
    let message = format!("`{file}` {what}");
    Finding::at(LINT.code, file, row.clone(), message).with_help("`landfall emit` writes it")
}
