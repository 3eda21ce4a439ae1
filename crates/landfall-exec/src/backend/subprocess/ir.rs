//! A module as JSON: only the parts needed to run it.

use std::io;

use naga::{Handle, PredeclaredType, Type};
use serde::{Deserialize, Serialize};

use landfall_ir::Module;
use landfall_layout::source::Files;

/// The types whose naga keys are not valid JSON keys.
#[derive(Serialize, Deserialize)]
struct Wire<M> {
    predeclared: Vec<(PredeclaredType, Handle<Type>)>,
    module: M,
}

pub(super) fn write(module: &Module) -> io::Result<Vec<u8>> {
    let mut ir = module.ir.clone();
    let predeclared = std::mem::take(&mut ir.special_types.predeclared_types);
    ir.doc_comments = None;
    let predeclared = predeclared.into_iter().collect();
    Ok(serde_json::to_vec(&Wire { predeclared, module: &ir })?)
}

/// Parses a module of bare IR; wgpu validates it again.
pub(super) fn read(json: &[u8]) -> io::Result<Module> {
    let mut backend = serde_json::Deserializer::from_slice(json);
    // Each `else if` is one level of nesting; the reading thread's stack is large enough.
    backend.disable_recursion_limit();
    let Wire { predeclared, module: mut ir } = Wire::<naga::Module>::deserialize(&mut backend)?;
    ir.special_types.predeclared_types = predeclared.into_iter().collect();
    Ok(Module::unvalidated(ir, Files::default(), Vec::new()))
}
