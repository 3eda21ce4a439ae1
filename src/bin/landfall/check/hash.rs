//! SHA-256 of files and settings, and HMAC seals.

use serde::{Deserialize, Serialize};

/// A SHA-256 in hexadecimal; empty for what could not be read.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Hash(String);

impl Hash {
    /// Returns the hash of bytes.
    pub fn of(bytes: &[u8]) -> Hash {
        Hash(hex(&hmac_sha256::Hash::hash(bytes)))
    }

    /// Whether it is the hash of a file that could be read.
    pub fn is_known(&self) -> bool {
        !self.0.is_empty()
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Its first digits, for file names.
    pub fn short(&self) -> &str {
        self.0.get(..16).unwrap_or(&self.0)
    }
}

/// HMAC-SHA256 (RFC 2104) in hexadecimal.
pub fn seal(key: &[u8], bytes: &[u8]) -> String {
    hex(&hmac_sha256::HMAC::mac(bytes, key))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors of RFC 6234, section 8.5, and of RFC 4231, sections 4.3 and 4.7.
    #[test]
    fn hashes_and_seals_are_those_of_the_standards() {
        assert_eq!(
            Hash::of(b"abc").as_str(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(
            seal(b"Jefe", b"what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843"
        );
        assert_eq!(
            seal(&[0xaa; 131], b"Test Using Larger Than Block-Size Key - Hash Key First"),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54"
        );
    }
}
