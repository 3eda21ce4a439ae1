//! Byte layouts of GLSL and WGSL blocks: parsing, layout rules, locks, buffers and code generation.

pub mod buffer;
pub mod build_script;
pub mod codegen;
pub mod diagnostic;
pub mod diff;
pub mod error;
#[cfg(test)]
pub(crate) mod examples;
#[doc(hidden)]
pub mod file;
pub mod finding;
pub mod format;
pub mod layout;
pub mod lock;
#[doc(hidden)]
#[cfg(feature = "naga")]
pub mod naga_compare;
#[doc(hidden)]
#[cfg(feature = "naga")]
pub mod naga_front;
pub mod other_language;
pub mod port;
mod shader;
pub mod shape;
pub mod source;
#[doc(hidden)]
pub mod syntax;
#[doc(hidden)]
pub mod text;

pub use buffer::{Buffer, BufferError};
pub use build_script::{Build, BuildError};
pub use diagnostic::{Diagnostic, Label, Severity};
pub use error::Error;
pub use layout::{BlockLayout, Leaf, MemberLayout};
pub use shader::{Options, ShaderLayout, layout, layout_parsed};
pub use shape::{AddressSpace, ArrayLen, Rules, Type};
pub use source::{Files, Language, ReadOptions, Source, Span, Stage, Target};
