//! Byte layouts of GLSL, WGSL and SPIR-V blocks: parsing, layout rules, locks and buffers.
//!
//! # Types of other crates
//!
//! Public signatures name `serde_json::Value` (values of a buffer as JSON), `bytemuck::Pod` (values
//! that are copied into a buffer as bytes), and `serde::Serialize` and `serde::Deserialize` (what is
//! printed as JSON), and no other type of another crate. A new major version of one of these crates
//! is one of this crate.

pub mod buffer;
pub mod diagnostic;
pub mod diff;
pub mod error;
#[cfg(test)]
pub(crate) mod examples;
#[doc(hidden)]
pub mod file;
pub mod finding;
pub mod format;
pub mod interface;
pub mod layout;
pub mod lock;
#[doc(hidden)]
#[cfg(feature = "naga")]
pub mod naga_compare;
#[doc(hidden)]
#[cfg(feature = "naga")]
pub mod naga_front;
pub mod other_language;
#[doc(hidden)]
#[cfg(feature = "schema")]
pub mod schema;
mod shader;
pub mod shape;
pub mod source;
#[doc(hidden)]
pub mod syntax;
#[doc(hidden)]
pub mod text;

pub use buffer::{Buffer, BufferError};
pub use diagnostic::{Diagnostic, Label, Severity};
pub use error::Error;
pub use layout::{BlockLayout, Leaf, MemberLayout};
pub use shader::{
    Macros, Options, ShaderLayout, UnreachedBlock, Variant, VariantCondition, layout,
    layout_parsed, unreached_blocks, variant_name, variants,
};
pub use shape::{AddressSpace, ArrayLen, Rules, Type};
pub use source::{Files, Language, ReadOptions, Source, Span, Stage, Target};
pub use syntax::linked;
