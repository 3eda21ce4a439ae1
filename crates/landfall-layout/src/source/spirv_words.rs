//! The words of a SPIR-V module, in the byte order of this machine.

use std::path::Path;
use std::sync::Arc;

use crate::error::Error;

/// The first word of every module: SPIR-V 1.6 §2.3.
const MAGIC: u32 = 0x0723_0203;

/// Whether a path has the extension of SPIR-V binaries.
pub(super) fn has_extension(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("spv"))
}

/// Whether bytes begin as a module of either byte order does; no text does.
pub(super) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC.to_le_bytes()) || bytes.starts_with(&MAGIC.to_be_bytes())
}

/// Returns the words of a module; the byte order is that of its first word.
///
/// # Errors
/// The bytes do not begin with the magic number, or are no whole number of words.
pub(super) fn of_bytes(path: &str, bytes: &[u8]) -> Result<Arc<[u32]>, Error> {
    if !begins(bytes) {
        let message = match bytes {
            [a, b, c, d, ..] => {
                format!("is not SPIR-V: it begins with the bytes {a:02x} {b:02x} {c:02x} {d:02x}")
            }
            _ => format!("is not SPIR-V: it has {} bytes", bytes.len()),
        };
        let help = "a module begins with the bytes 03 02 23 07, or with these in reverse; a shader \
                    in text needs another extension, such as .frag or .wgsl";
        return Err(Error::new(path, message).with_help(help).unreadable());
    }
    let (words, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        let message = format!("is not a whole SPIR-V module: {} bytes are no words", bytes.len());
        let help = "compile it again: the file may have been cut off, or copied as text";
        return Err(Error::new(path, message).with_help(help).unreadable());
    }
    // The magic number tells the byte order (SPIR-V §2.3).
    let order = if bytes.starts_with(&MAGIC.to_le_bytes()) {
        |word: &[u8; 4]| u32::from_le_bytes(*word)
    } else {
        |word: &[u8; 4]| u32::from_be_bytes(*word)
    };
    Ok(words.iter().map(order).collect())
}
