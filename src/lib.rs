#![doc = include_str!("../README.md")]

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
