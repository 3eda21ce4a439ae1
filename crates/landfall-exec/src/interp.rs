//! Our own evaluator of naga IR: many invocations at a time, f32 and f64.
//!
//! A [`Module`] is compiled once to a flat [`Program`] (`compile`), which the
//! `machine` runs over 64 invocations at a time. `call` runs one function,
//! `stage` an entry point, and [`Cpu`] is the [`Reader`](crate::backend::Reader).
//!
//! What is computed: `f32` is rounded at each operation; `sin`, `exp`, `pow` and the
//! like are computed in `f64` and rounded; what WGSL and GLSL define by a formula is
//! that formula in its order. In double precision every `f32` is an `f64`, except what
//! is stored in buffers and workgroup variables. Where the specifications leave a
//! result open, [`UndefinedKind`] lists what is noted.

pub mod accuracy;
mod body;
mod call;
mod code;
mod compile;
mod counts;
mod drive;
mod flatten;
mod interface;
mod interval;
mod machine;
mod permitted;
mod pixels;
mod program;
mod reader;
mod real;
mod stage;
mod tidy;
mod trace;
mod undefined;
mod value;

#[cfg(test)]
mod tests;

pub use call::{Call, Called, Numbers, Words};
pub use counts::Counts;
pub use interface::Port;
pub use program::{Floats, FunctionSignature, Parameter, Program};
pub use reader::Cpu;
pub use stage::{Invocations, Notes, Outputs, Precision, Settings};
pub use trace::{Number, Operand, Operation, Source, Step, Trace};
pub use undefined::{Divergence, Place, Undefined, UndefinedKind};
pub use value::{Value, ValueType};

use std::path::Path;

use landfall_ir::Module;
use landfall_layout::source::{Language, kind_of_path};

/// Bytes of stack for compiling.
const STACK: usize = 256 << 20;

impl Program {
    /// Compiles a module; `overrides` are values of its pipeline constants by name or id.
    ///
    /// A function that uses what is not supported (storage textures, cube maps, ray
    /// queries, subgroup operations) is refused where it is run, by what it uses.
    pub fn new(module: &Module, overrides: &[(String, f64)]) -> Program {
        Program::rounded(module, overrides, Floats::AsWritten)
    }

    /// The same with floats rounded to less than they are written as.
    pub fn rounded(module: &Module, overrides: &[(String, f64)], floats: Floats) -> Program {
        // Blocks may nest as deep as the text does; the stack is touched only as far.
        let compile = || compile::compile(module, overrides, floats);
        let mut program = std::thread::scope(|scope| {
            let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, compile);
            let thread = thread.expect("there is memory for a thread");
            thread.join().expect("compiling a validated module does not panic")
        });
        program.files = module.files.clone();
        program.bases = module.bases.clone();
        let kind = module.files.get(0).and_then(|file| kind_of_path(Path::new(&file.path)));
        program.language = kind.map_or(Language::Glsl, |(language, _)| language);
        program
    }
}
