//! SHA-256 of files and settings, and seals of caches.

use std::hash::Hasher;

use data_encoding::HEXLOWER;
use serde::{Deserialize, Serialize};
use siphasher::sip128::{Hasher128, SipHasher24};

/// A SHA-256 in hexadecimal; empty for what could not be read.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Hash(String);

impl Hash {
    /// Returns the hash of bytes.
    pub fn of(bytes: &[u8]) -> Hash {
        Hash(HEXLOWER.encode(&hmac_sha256::Hash::hash(bytes)))
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

/// A message authentication code in hexadecimal: SipHash-2-4 of 128 bits, a tenth of the time of
/// HMAC-SHA256. Its key is the start of the SHA-256 of `key`.
pub fn seal<'a>(key: &[u8], parts: impl IntoIterator<Item = &'a str>) -> String {
    let digest = hmac_sha256::Hash::hash(key);
    let key: &[u8; 16] = digest.first_chunk().expect("32 bytes");
    let mut hasher = SipHasher24::new_with_key(key);
    for part in parts {
        hasher.write_usize(part.len());
        hasher.write(part.as_bytes());
    }
    HEXLOWER.encode(&hasher.finish128().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vector of RFC 6234, section 8.5.
    #[test]
    fn hashes_are_those_of_the_standard() {
        assert_eq!(
            Hash::of(b"abc").as_str(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    /// The first vectors of the reference implementation of SipHash-2-4 with 128 bits.
    #[test]
    fn the_hash_of_seals_is_that_of_its_authors() {
        let key: [u8; 16] = std::array::from_fn(|i| i as u8);
        let hash = |bytes: &[u8]| {
            let mut hasher = SipHasher24::new_with_key(&key);
            hasher.write(bytes);
            HEXLOWER.encode(&hasher.finish128().as_bytes())
        };
        assert_eq!(hash(b""), "a3817f04ba25a8e66df67214c7550293");
        assert_eq!(hash(b"\0"), "da87c1d86b99af44347659119b22fc45");
    }

    #[test]
    fn a_seal_changes_with_its_key_its_text_and_the_place_of_the_parts() {
        let seals = [
            seal(b"key", ["ab", "c"]),
            seal(b"kez", ["ab", "c"]),
            seal(b"key", ["a", "bc"]),
            seal(b"key", ["ab", "d"]),
        ];
        for (i, one) in seals.iter().enumerate() {
            assert!(seals[..i].iter().all(|other| other != one), "{seals:?}");
        }
    }
}
