//! A module as JSON: what a process needs to run it, and no more.

use std::io;

use naga::{Handle, PredeclaredType, Type};
use serde::{Deserialize, Serialize};

use landfall_ir::Module;
use landfall_layout::source::Files;

/// Types that naga keys by what JSON takes for no key.
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

/// The module, with no more known of it than its code: wgpu validates it again.
pub(super) fn read(json: &[u8]) -> io::Result<Module> {
    let mut reader = serde_json::Deserializer::from_slice(json);
    // Each `else if` is a level; the thread that reads has the stack for it.
    reader.disable_recursion_limit();
    let Wire { predeclared, module: mut ir } = Wire::<naga::Module>::deserialize(&mut reader)?;
    ir.special_types.predeclared_types = predeclared.into_iter().collect();
    Ok(Module::unvalidated(ir, Files::default(), Vec::new()))
}
