//! SHA-256 of files and settings, and checksums of caches.

use data_encoding::HEXLOWER;
use landfall_lint::digest::fnv;
use serde::{Deserialize, Serialize};

/// A SHA-256 in hexadecimal; empty for what could not be read.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Hash(String);

impl Hash {
    /// Returns the hash of bytes.
    pub fn from_bytes(bytes: &[u8]) -> Hash {
        Hash(HEXLOWER.encode(&hmac_sha256::Hash::hash(bytes)))
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Its first digits, for file names.
    pub fn short(&self) -> &str {
        self.0.get(..16).unwrap_or(&self.0)
    }
}

/// Returns a checksum, by which a cache that was cut off or damaged is told.
pub fn checksum(text: &str) -> String {
    format!("{:016x}", fnv(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vector of RFC 6234, section 8.5.
    #[test]
    fn hashes_are_those_of_the_standard() {
        assert_eq!(
            Hash::from_bytes(b"abc").as_str(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
