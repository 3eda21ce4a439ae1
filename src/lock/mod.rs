//! Locks: the committed record of a layout.

use std::path::{Path, PathBuf};

use crate::ShaderLayout;
use crate::emit::{EmitOptions, Format, document};
use crate::error::Error;
use crate::lint::{Finding, Place};

/// A lock that was read.
#[derive(Clone, Debug)]
pub struct Lock {
    text: String,
}

/// Where the lock of a shader is.
pub fn path_of(locks: &Path, shader: &Path) -> PathBuf {
    let mut path = locks.join(shader).into_os_string();
    path.push(".json");
    PathBuf::from(path)
}

/// The lock of a shader as text.
pub fn write(shader: &ShaderLayout) -> String {
    document(shader, &EmitOptions::new(Format::Json))
}

/// A lock from its text.
///
/// # Errors
/// It is no lock.
pub fn read(path: &str, text: &str) -> Result<Lock, Error> {
    if !text.ends_with("}\n") {
        return Err(Error::new(path, "is cut off").with_help("restore it, or write it again"));
    }
    Ok(Lock { text: text.to_string() })
}

/// What has drifted from the lock.
pub fn drift(shader: &ShaderLayout, lock_path: &str, lock: Option<&Lock>) -> Vec<Finding> {
    let place = Place::file(shader.path.clone());
    match lock {
        None => {
            let message = format!("`{}` has no lock `{lock_path}`", shader.path);
            vec![Finding::new("lock-missing", shader.path.clone(), place, message)]
        }
        Some(lock) if lock.text != write(shader) => {
            let message = format!("`{}` differs from `{lock_path}`", shader.path);
            vec![Finding::new("layout-drift", shader.path.clone(), place, message)]
        }
        Some(_) => Vec::new(),
    }
}

/// A lock without a shader.
pub fn orphan(lock_path: &str) -> Finding {
    let message = format!("`{lock_path}` is the lock of a shader that is gone");
    Finding::new("lock-orphan", lock_path, Place::file(lock_path), message)
}
