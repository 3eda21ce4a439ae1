//! Every block of the shaders of this repository, from random bytes to JSON and back.

use std::fs;
use std::path::{Path, PathBuf};

use fastrand::Rng;
use landfall_layout::buffer::{Finding, decode};
use landfall_layout::{Options, Source, layout, source};
use serde_json::Value;

use crate::support::command::{landfall, with_stdin};
use crate::support::sample::{everything, sampled};

/// The shaders of this repository.
fn shaders(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            shaders(&path, found);
        } else if source::kind_of_path(&path).is_some() {
            found.push(path);
        }
    }
}

#[test]
fn every_block_of_our_shaders_comes_back_from_random_bytes() {
    let mut paths = Vec::new();
    shaders(Path::new("shaders"), &mut paths);
    paths.sort();
    let (mut blocks, mut nans) = (0, 0);
    for path in sampled(&paths, 4) {
        let shader = layout(&Source::read(path).unwrap(), &Options::default());
        let path = path.to_str().unwrap();
        for block in shader.blocks.iter().filter(|block| block.size.is_some()) {
            let named = |name: &str| shader.blocks.iter().filter(|b| *b.name == *name).count() == 1;
            let name = block.instance.as_deref().filter(|_| !named(&block.name));
            let name = name.unwrap_or(&block.name);
            let mut rng = Rng::with_seed(blocks);
            let mut bytes: Vec<u8> = (0..block.size.unwrap()).map(|_| rng.u8(..)).collect();
            for word in bytes.chunks_exact_mut(4).filter(|_| rng.u8(0..8) == 0) {
                // A NaN with a payload, or infinity, where it is a float.
                word[2..].copy_from_slice(&[0x80, 0x7f]);
            }
            let Ok(decoded) = decode(block, &bytes) else {
                continue; // Sized by an override without a value.
            };
            let json = serde_json::to_string(&decoded).unwrap();
            let found = &decoded.findings.list;
            nans += found.iter().filter(|f| matches!(f, Finding::Nan { .. })).count();

            let encode = ["encode", path, "-b", name, "--missing", "error"];
            let made = with_stdin(landfall(&encode), json.as_bytes());
            assert_eq!((made.code, made.err.contains("error")), (0, false), "{path}\n{}", made.err);
            let table = decode(block, &made.bytes).unwrap();
            let is_padding = |f: &Finding| matches!(f, Finding::Padding { .. });
            assert!(!table.findings.list.iter().any(is_padding), "{path} {name}");
            assert_eq!(serde_json::to_string(&table).unwrap(), json, "{path} {name}");

            let read = ["decode", path, "-", "-b", name, "-f", "json"];
            let back = with_stdin(landfall(&read), &made.bytes);
            assert!(back.code < 2, "{path}\n{}", back.err);
            let values: Value = serde_json::from_str(&back.out).unwrap();
            assert_eq!(values, serde_json::from_str::<Value>(&json).unwrap(), "{path} {name}");
            let again = with_stdin(landfall(&encode), &back.bytes);
            assert!(again.bytes == made.bytes, "{path} {name}");
            blocks += 1;
        }
    }
    let share = if everything() { 1 } else { 8 };
    assert!(blocks * share > 60 && nans as u64 * share > 100, "{blocks} blocks, {nans} NaNs");
}
