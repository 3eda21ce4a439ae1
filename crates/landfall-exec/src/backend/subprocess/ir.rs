//! A module in serialised form: only the parts needed to run it.

use std::io;

use landfall_ir::Module;
use landfall_layout::source::Files;

use super::frame::encode;

pub(super) fn write(module: &Module) -> io::Result<Vec<u8>> {
    let mut ir = module.ir.clone();
    // No run depends on them.
    ir.doc_comments = None;
    encode(&ir)
}

/// Parses a module of bare IR; wgpu validates it again.
pub(super) fn read(bytes: &[u8]) -> io::Result<Module> {
    // Each `else if` is one level of nesting; the reading thread's stack is large enough.
    let ir = postcard::from_bytes(bytes).map_err(io::Error::other)?;
    Ok(Module::unvalidated(ir, Files::default(), Vec::new()))
}
