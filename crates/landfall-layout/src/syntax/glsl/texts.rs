//! The texts that tokens refer to.

use std::sync::Arc;

use typed_arena::Arena;

/// Owns the texts that tokens refer to: files, pasted tokens, command-line macros.
pub type Texts = Arena<Arc<str>>;
