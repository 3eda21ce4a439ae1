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
//! [`Buffer`] holds the bytes of a block and sets them by name:
//!
//! ```
//! use landfall::{Buffer, Options, Source, layout};
//!
//! let text = "struct Light { vec3 pos; float power; };
//!     layout(std140) uniform Lights { Light data[4]; int count; };";
//! let lights = &layout(&Source::new("lights.frag", text), &Options::default()).blocks[0];
//! let mut buffer = Buffer::new(lights)?;
//! buffer.set("data[2].power", 0.5_f32)?;
//! assert_eq!(buffer.bytes()[44..48], 0.5_f32.to_le_bytes());
//! # Ok::<(), landfall::BufferError>(())
//! ```
//!
//! [`Build`] generates Rust mirrors and C headers from a build script:
//!
//! ```no_run
//! fn main() -> Result<(), landfall::BuildError> {
//!     landfall::Build::new().shader("shaders/lights.frag").mirrors("lights.rs").run()
//! }
//! ```
//!
//! [`diff`](mod@diff) compares two layouts and tells which changes break an upload:
//!
//! ```
//! use landfall::diff::{Class, Side, diff, verdict};
//! use landfall::{Options, Source, layout};
//!
//! let light = |members: &str| {
//!     let text = format!("layout(std140) uniform Light {{ {members} }};");
//!     layout(&Source::new("light.frag", text), &Options::default())
//! };
//! let (old, new) = (light("vec3 pos; float power;"), light("float power; vec3 pos;"));
//! let changes = diff(Side::from_shader(&old), Side::from_shader(&new));
//! assert_eq!(verdict(&changes), Some(Class::Breaking));
//! ```
//!
//! [`lock`](mod@lock) reads and writes the lock files that `landfall check` compares shaders with.
//!
//! # Features
//!
//! | feature | adds |
//! |---|---|
//! | none (`default-features = false`) | layouts, locks, diffs, buffers, code generation, [`Build`] |
//! | `cli` (default) | the command and its lints of layouts |
//! | `port` | ports of old GLSL to Vulkan |
//! | `naga` | constant expressions beyond Landfall's own, naga's layout beside it, ports to WGSL |
//! | `analysis` | lints that follow the code of functions, of lighting above all |
//! | `exec` | commands that execute shaders on the interpreter |
//! | `gl`, `gpu` | the OpenGL and wgpu backends |
//! | `web` | reading blocks back through WebGL 2 and WebGPU in a browser |
//! | `serve` | the page of `landfall serve` |
//! | `full` | everything |
//!
//! # Types of other crates
//!
//! Public signatures name `serde_json::Value` (values of a buffer as JSON), `bytemuck::Pod` (values
//! that are copied into a buffer as bytes), and `serde::Serialize` and `serde::Deserialize` (what is
//! printed as JSON), and no other type of another crate.
//!
//! Enums that will grow are `#[non_exhaustive]`. The others are complete by their meaning, such as
//! the two orders of a matrix, or decide how every byte is laid out, as [`Type`] and [`Language`]: a
//! new variant of these is a new major version.

pub use landfall_layout::{
    AddressSpace, ArrayLen, BlockLayout, Buffer, BufferError, Diagnostic, Error, Files, Label,
    Language, Leaf, MemberLayout, Options, ReadOptions, Rules, Severity, ShaderLayout, Source,
    Span, Stage, Target, Type, layout,
};
pub use landfall_layout::{
    buffer, diagnostic, diff, error, file, format, interface, lock, shape, source,
};

#[cfg(feature = "port")]
pub use landfall_port as port;

pub use landfall_codegen::{Build, BuildError, build_script};

/// Code generated from layouts: mirrors of blocks in the languages of one
/// [table](codegen::languages).
pub mod codegen {
    pub use landfall_codegen::{CodeOptions, CodeOutput, OutputLanguage, c, languages, rust};
}

#[cfg(feature = "report")]
#[doc(hidden)]
pub mod report;
