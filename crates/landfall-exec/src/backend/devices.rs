//! The devices of this machine and their limits.
//!
//! Filled in by the drivers, printed by `landfall devices`.

use serde::{Deserialize, Serialize};

use crate::backend::{BackendKind, Device, Failure};

/// A backend, available or missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BackendEntry {
    /// The kind of backend.
    pub backend: BackendKind,
    /// The kind of context or of API, such as `core 4.5` or `vulkan`.
    pub kind: String,
    /// The device and its limits, or why it is missing.
    pub outcome: Result<(Device, Limits), Failure>,
}

impl BackendEntry {
    /// Returns the entry of a backend that this build lacks.
    pub fn not_built(backend: BackendKind) -> BackendEntry {
        let feature = match backend {
            BackendKind::WebGl | BackendKind::WebGpu => "web",
            BackendKind::Cpu | BackendKind::Gl | BackendKind::Gpu => backend.name(),
        };
        let message = format!(
            "this build has no backend `{backend}`: it lacks the cargo feature `{feature}`"
        );
        BackendEntry { backend, kind: String::new(), outcome: Err(Failure::missing(message, "")) }
    }
}

/// Returns the entry of the interpreter, which is always available.
pub fn cpu() -> BackendEntry {
    let device = Device {
        backend: BackendKind::Cpu,
        adapter: "evaluator".to_string(),
        driver: landfall_layout::format::NAME.to_string(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        software: true,
    };
    BackendEntry {
        backend: BackendKind::Cpu,
        kind: String::new(),
        outcome: Ok((device, Limits::default())),
    }
}

/// The limits of a device; `None` where it has no such feature or no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Limits {
    /// Size of a uniform block in bytes.
    pub uniform_block_size: Option<u64>,
    /// Size of a storage block in bytes.
    pub storage_block_size: Option<u64>,
    /// Number of uniform blocks per stage.
    pub uniform_blocks: Option<u64>,
    /// Number of storage blocks per compute shader.
    pub storage_blocks: Option<u64>,
    /// Size of push constants in bytes.
    pub push_constant_size: Option<u64>,
    /// Width and height of an image in pixels.
    pub image_side: Option<u64>,
    /// Number of invocations per workgroup.
    pub workgroup_invocations: Option<u64>,
    /// Number of workgroups per dispatch and dimension.
    pub workgroups: Option<u64>,
}
