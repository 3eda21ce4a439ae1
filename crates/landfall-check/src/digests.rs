//! The digests of a shader's blocks. Those of a cache are parsed when a lint over all shaders needs
//! them, which is not while no shader changes.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use landfall_lint::digest::BlockDigest;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The digests of one shader's blocks.
#[derive(Clone, Debug)]
pub enum Digests {
    Parsed(Vec<BlockDigest>),
    /// The digests at this index of a cache.
    Cached(Arc<CachedDigests>, usize),
}

/// The digests of all shaders of a cache.
#[derive(Debug)]
pub struct CachedDigests {
    file: String,
    json: Range<usize>,
    parsed: OnceLock<Vec<Vec<BlockDigest>>>,
}

impl CachedDigests {
    /// The digests at `json` in the text of a cache, which is kept rather than copied. Its checksum is right,
    /// so that this version of landfall has written it.
    pub fn new(file: String, json: Range<usize>) -> Arc<CachedDigests> {
        Arc::new(CachedDigests { file, json, parsed: OnceLock::new() })
    }
}

impl Digests {
    pub fn get(&self) -> &[BlockDigest] {
        match self {
            Digests::Parsed(digests) => digests,
            Digests::Cached(cached, index) => {
                let json = &cached.file[cached.json.clone()];
                let parse = || serde_json::from_str(json).unwrap_or_default();
                cached.parsed.get_or_init(parse).get(*index).map_or(&[], Vec::as_slice)
            }
        }
    }

    pub fn is_empty(&self) -> bool {
        self.get().is_empty()
    }
}

impl Default for Digests {
    fn default() -> Digests {
        Digests::Parsed(Vec::new())
    }
}

impl From<Vec<BlockDigest>> for Digests {
    fn from(digests: Vec<BlockDigest>) -> Digests {
        Digests::Parsed(digests)
    }
}

impl Serialize for Digests {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.get().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Digests {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Digests, D::Error> {
        Vec::deserialize(deserializer).map(Digests::Parsed)
    }
}
