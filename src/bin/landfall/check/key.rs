//! The key that seals caches: without it, nobody who can write a cache can forge a clean result.
//!
//! It is generated per user on first use, or taken from `LANDFALL_CACHE_KEY` for machines that
//! share a cache.

use std::fs;
use std::hash::{BuildHasher, RandomState};
use std::path::PathBuf;

use landfall_layout::Error;
use landfall_layout::file::{create_private, read_whole, reason};

use super::hash::Hash;

const VARIABLE: &str = "LANDFALL_CACHE_KEY";

/// The maximum length of a key's file in bytes.
const LONGEST: u64 = 1 << 16;

/// The minimum length of a key in characters.
const SHORTEST: usize = 16;

/// The key of this run.
///
/// # Errors
///
/// The variable is too short for a key, or the user has no directory to store one.
pub fn key() -> Result<Vec<u8>, Error> {
    if let Some(given) = std::env::var_os(VARIABLE).filter(|given| !given.is_empty()) {
        let given = given.into_encoded_bytes();
        if given.len() < SHORTEST {
            let message =
                format!("is shorter than the {SHORTEST} characters that a key of caches needs");
            return Err(
                Error::new(VARIABLE, message).with_help("generate one with `openssl rand -hex 32`")
            );
        }
        return Ok(given);
    }
    let Some(file) = place() else {
        return Err(Error::new(
            "--cache-dir",
            "needs a key, which cannot be stored: there is no home directory",
        )
        .with_help(format!("set `{VARIABLE}`")));
    };
    let failed = |cause: std::io::Error| {
        let message = format!("cannot hold the key of caches: {}", reason(&cause));
        Error::new(file.display().to_string(), message).with_help(format!("set `{VARIABLE}`"))
    };
    for _ in 0..2 {
        match read_whole(&file, LONGEST) {
            Ok(key) if key.len() >= SHORTEST => return Ok(key),
            Ok(_) => fs::remove_file(&file).map_err(failed)?,
            Err(_) => {}
        }
        // Of two processes that create the key, the first wins.
        match create_private(&file, random().as_bytes()) {
            Err(cause) if cause.kind() != std::io::ErrorKind::AlreadyExists => {
                return Err(failed(cause));
            }
            Ok(()) | Err(_) => {}
        }
    }
    read_whole(&file, LONGEST)
}

/// The user's file of the key: in the XDG state directory, or `LOCALAPPDATA` on Windows.
fn place() -> Option<PathBuf> {
    let folder = |name: &str| {
        std::env::var_os(name).map(PathBuf::from).filter(|folder| folder.is_absolute())
    };
    let state = folder("XDG_STATE_HOME")
        .or_else(|| folder("LOCALAPPDATA"))
        .or_else(|| Some(folder("HOME")?.join(".local/state")))?;
    Some(state.join("landfall").join("cache-key"))
}

/// A random key of 64 characters, from the hash seeds that the standard library takes from the
/// operating system.
fn random() -> String {
    let numbers: Vec<u8> = (0..8u64)
        .flat_map(|n| RandomState::new().hash_one(n).to_le_bytes())
        .chain(std::process::id().to_le_bytes())
        .collect();
    Hash::of(&numbers).as_str().to_string()
}
