//! The texts that tokens refer to. They are in an arena, because includes and pasted tokens add
//! texts while tokens of earlier ones are in use.

use std::sync::Arc;

use typed_arena::Arena;

/// Owns the texts that tokens refer to: files, pasted tokens, command-line macros.
pub type Texts = Arena<Arc<str>>;
