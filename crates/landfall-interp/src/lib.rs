//! The interpreter of naga IR: many invocations at a time, in f32 and f64.
//!
//! A [`Module`] is compiled once to a flat [`Program`] (`compile`), which the `machine` runs over
//! 64 invocations at a time. `call` runs one function, `stage` an entry point, and [`Cpu`] is the
//! [`Backend`](backend::Backend).
//!
//! Results: `f32` is rounded at each operation; `sin`, `exp`, `pow` and the like are computed in
//! `f64` and rounded; functions that WGSL and GLSL define by a formula follow that formula in its
//! order. In double precision every `f32` is an `f64`, except for values stored in buffers and
//! workgroup variables. [`UndefinedKind`] lists the operations that are noted because the
//! specifications leave their result undefined.

// What other crates of the workspace call; users see the facade.
#![allow(missing_docs)]

pub mod accuracy;
pub mod backend;
mod body;
mod call;
mod code;
mod compile;
mod condition;
mod counts;
mod cpu;
mod drive;
mod elementary;
mod flatten;
pub mod graph;
mod interface;
#[doc(hidden)]
pub mod internals;
mod interval;
mod lanes;
mod machine;
mod numbers;
mod optimize;
mod outward;
mod permitted;
mod pixels;
mod program;
mod real;
pub mod reflection;
mod shadow;
mod stage;
mod trace;
mod undefined;
mod value;

pub use call::{Call, Called};
pub use code::{Cmp, Test};
pub use counts::Counts;
pub use cpu::{Cpu, Programs};
pub use interface::Port;
pub use numbers::{Numbers, Words};
pub use program::{Floats, FunctionSignature, Parameter, Program};
pub use stage::{Invocations, Notes, Outputs, Precision, Settings};
pub use trace::{
    Comparison, NonFinite, Number, Operand, Operation, Source, Trace, TracedOperation,
};
pub use undefined::{Divergence, SourceLocation, Undefined, UndefinedKind};
pub use value::{Value, ValueParts, ValueType};

use std::path::Path;

use landfall_ir::Module;
use landfall_ir::stack::on_a_large_stack;
use landfall_layout::source::{Language, kind_of_path};

impl Program {
    /// Compiles a module; `overrides` are values of its pipeline constants by name or id.
    ///
    /// A function that uses unsupported features (storage textures, cube maps, ray queries,
    /// subgroup operations) fails when it is run, with the name of the feature.
    pub fn new(module: &Module, overrides: &[(String, f64)]) -> Program {
        Program::rounded(module, overrides, Floats::AsWritten)
    }

    /// Compiles a module with its floats rounded to a lower precision.
    pub fn rounded(module: &Module, overrides: &[(String, f64)], floats: Floats) -> Program {
        let compile = || compile::compile(module, overrides, floats);
        // Statements may nest deeply.
        let compiled = on_a_large_stack(compile);
        let mut program = compiled.expect("there is memory, and a validated module compiles");
        program.files = module.files.clone();
        program.bases = module.bases.clone();
        let kind = module.files.get(0).and_then(|file| kind_of_path(Path::new(&file.path)));
        program.language = kind.map_or(Language::Glsl, |(language, _)| language);
        program
    }
}
