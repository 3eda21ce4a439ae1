//! Byte layouts of GLSL and WGSL blocks: std140, std430, scalar and WGSL.
//!
//! [`layout()`] computes the layout of every block of a shader, in bytes:
//!
//! ```
//! use landfall::{Options, Source, layout};
//!
//! let text = "layout(std140) uniform Light { vec3 pos; float power; };";
//! let shader = layout(&Source::new("light.frag", text), &Options::default());
//! let power = &shader.blocks[0].leaves[1];
//! assert_eq!((power.path.as_str(), power.offset), ("power", Some(12)));
//! ```
//!
//! [`Build`] writes Rust mirrors and C headers from a build script, [`Buffer`] fills the bytes of
//! a block by name, [`lock`](mod@lock) and [`diff`](mod@diff) record and compare layouts.
//!
//! # Features
//!
//! | feature | adds |
//! |---|---|
//! | none (`default-features = false`) | layouts, locks, diffs, buffers, code generation, [`Build`] |
//! | `cli` (default) | the command and its lints |
//! | `exec` | commands that execute shaders on the interpreter |
//! | `gl`, `gpu` | the OpenGL and wgpu backends |
//! | `full` | everything |

pub use landfall_layout::{
    AddressSpace, ArrayLen, BlockLayout, Buffer, BufferError, Build, BuildError, Diagnostic, Error,
    Files, Label, Language, Leaf, MemberLayout, Options, ReadOptions, Rules, Severity,
    ShaderLayout, Source, Span, Stage, Target, Type, layout,
};
pub use landfall_layout::{
    buffer, build_script, codegen, diagnostic, diff, error, file, format, lock, port, shape, source,
};

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod report;
