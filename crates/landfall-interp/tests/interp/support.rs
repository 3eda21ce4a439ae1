//! Modules from WGSL, and helpers that call their functions.

use landfall_interp::backend::Failure;
use landfall_interp::{Call, Called, Program, Settings};
use landfall_ir::Module;
use landfall_layout::Options;
use landfall_layout::source::Source;

pub fn module(text: &str) -> Module {
    let source = Source::new("test.wgsl", text);
    Module::new(&source, &Options::default()).unwrap_or_else(|found| panic!("{found:?}"))
}

pub fn program(text: &str) -> Program {
    Program::new(&module(text), &[])
}

pub fn single() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

pub fn watched() -> Settings {
    Settings { watch: true, ..single() }
}

/// Calls a function of floats.
pub fn run(
    program: &Program,
    function: &str,
    arguments: &[&[f32]],
    settings: &Settings,
) -> Result<Called, Failure> {
    let words = |list: &&[f32]| vec![list.iter().map(|x| u64::from(x.to_bits())).collect()];
    let lanes = arguments[0].len();
    let arguments = arguments.iter().map(words).collect();
    program.call(&Call { function, lanes, arguments, resources: &[] }, settings)
}

/// Words of one scalar for each argument.
pub fn call(program: &Program, function: &str, arguments: &[&[u32]]) -> Called {
    let arguments: Vec<Vec<Vec<u64>>> =
        arguments.iter().map(|words| vec![words.iter().map(|&w| u64::from(w)).collect()]).collect();
    let lanes = arguments.first().map_or(1, |words| words[0].len());
    let call = Call { function, lanes, arguments, resources: &[] };
    program.call(&call, &single()).unwrap_or_else(|failure| panic!("{failure:?}"))
}

/// The first scalar of the result.
pub fn words(program: &Program, function: &str, arguments: &[&[u32]]) -> Vec<u32> {
    call(program, function, arguments).result.words[0].iter().map(|&w| w as u32).collect()
}

/// The same with floats in and out.
pub fn floats(program: &Program, function: &str, arguments: &[&[f32]]) -> Vec<f32> {
    let bits: Vec<Vec<u32>> =
        arguments.iter().map(|xs| xs.iter().map(|x| x.to_bits()).collect()).collect();
    let bits: Vec<&[u32]> = bits.iter().map(Vec::as_slice).collect();
    words(program, function, &bits).into_iter().map(f32::from_bits).collect()
}
