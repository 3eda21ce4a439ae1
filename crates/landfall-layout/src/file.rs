//! Files written whole or not at all.
//!
//! For the command and the build script; nothing else touches the file system but
//! [`source`](crate::source).

use std::io;

mod write;

pub use write::{FileWriter, Written, write_whole};

/// The reason of a failure in the words of the operating system, without its number.
pub fn reason(cause: &io::Error) -> String {
    let text = cause.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_lowercase()
}
