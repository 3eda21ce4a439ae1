//! Jobs for the tests of the backends: short ways to say what is bound and what runs.

#![allow(dead_code, reason = "each test file uses its own part")]

use std::sync::Arc;
use std::time::Duration;

use landfall_exec::backend::{Grid, Job, Resource, ResourceKind, StageCode};
use landfall_ir::Module;
use landfall_layout::Stage;

pub fn glsl(stage: Stage, text: &str) -> StageCode {
    StageCode::of_text(stage, text)
}

pub fn module(stage: Stage, entry: &str, module: &Arc<Module>) -> StageCode {
    StageCode::of_module(stage, entry, Arc::clone(module))
}

pub fn job(stages: Vec<StageCode>, resources: Vec<Resource>, grid: Grid) -> Job {
    Job { stages, resources, grid, limit: Duration::from_secs(60) }
}

pub fn bound(name: &str, binding: u32, kind: ResourceKind) -> Resource {
    Resource { name: name.to_string(), group: 0, binding, kind }
}

pub fn uniform(name: &str, binding: u32, words: &[u32]) -> Resource {
    bound(name, binding, ResourceKind::Uniform(bytes(words)))
}

/// A writable storage buffer of so many zeros.
pub fn output(name: &str, binding: u32, words: usize) -> Resource {
    storage(name, binding, &vec![0; words])
}

/// A writable storage buffer.
pub fn storage(name: &str, binding: u32, words: &[u32]) -> Resource {
    bound(name, binding, ResourceKind::Storage { bytes: bytes(words), writable: true })
}

pub fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

pub fn words(bytes: &[u8]) -> Vec<u32> {
    bytes
        .chunks_exact(4)
        .map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
        .collect()
}

/// Words that name themselves: word `i` is `1000 + i`.
pub fn counting(count: u32) -> Vec<u32> {
    (1000..1000 + count).collect()
}
