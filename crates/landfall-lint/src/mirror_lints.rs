//! `rust-mirror` and `rust-mirror-unknown`, which the feature `rust-mirrors` finds.

#[cfg(not(feature = "rust-mirrors"))]
use super::definition::Subject;
use super::definition::{Check, Lint};
#[cfg(feature = "rust-mirrors")]
use super::rust_mirror::of_code as of;
#[cfg(not(feature = "rust-mirrors"))]
use super::settings::Settings;
#[cfg(not(feature = "rust-mirrors"))]
use landfall_layout::finding::Finding;
use landfall_layout::finding::Level;

pub(super) const MIRROR: Lint = Lint {
    code: "rust-mirror",
    level: Level::Deny,
    what: "a hand-written Rust structure whose fields are not where the shader reads them",
    why: "A `#[repr(C)]` structure is uploaded byte by byte. If it lacks a padding field, or has \
          array elements 12 bytes apart where the shader reads them 16 apart, every byte after \
          that is misread, without any error. A structure is compared with a block when the \
          configuration names both, or a comment right above the structure does: `// landfall: \
          mirror(Light)`, `// landfall: mirror(shaders/sun.frag: Light)`. Fields are matched with \
          members by name, regardless of case; names that begin with `_` are padding. A structure \
          that derives encase's (or Bevy's) `ShaderType`, or crevice's `AsStd140` or `AsStd430`, \
          is compared as that library writes it, also where it derives bytemuck's `Pod` beside it. \
          The helps of one structure belong together: each assumes those above it.",
    example: "\
// landfall: mirror(Light)
#[repr(C)]
struct Light {
    direction: [f32; 3],
    color: [f32; 3], // at 12; a shader reads `vec3 color` at 16
}
",
    fix: "Put padding fields where the finding says, or let `landfall emit --lang rust` write the \
          structure.",
    check: Check::Tree(|subjects, settings| of(subjects, settings, MIRROR.code)),
};

pub(super) const UNKNOWN: Lint = Lint {
    code: "rust-mirror-unknown",
    // The comparison could not be made; nothing is known to be wrong.
    level: Level::Warn,
    what: "a mirror that could not be compared with its block",
    why: "A field has a type that Landfall does not know, or no checked shader has the block, so \
          that the mirror is not checked.",
    example: "\
// landfall: mirror(Light)
#[repr(C)]
struct Light {
    direction: my_math::Direction,
}
",
    fix: "Use primitives, arrays, structures of the same file or the types of a known math crate; \
          name the shader in the mirror when only a part of the tree is checked.",
    check: Check::Tree(|subjects, settings| of(subjects, settings, UNKNOWN.code)),
};

/// A build without a parser of Rust finds none.
#[cfg(not(feature = "rust-mirrors"))]
fn of(_: &[Subject<'_>], _: &Settings, _: &str) -> Vec<Finding> {
    Vec::new()
}
