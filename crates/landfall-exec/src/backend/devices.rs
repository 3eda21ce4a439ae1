//! What could run a shader here, and how much it takes at a time.
//!
//! Fed by the drivers; `landfall devices` prints it.

use serde::{Deserialize, Serialize};

use crate::backend::{BackendKind, Device, Failure};

/// One way to run shaders, there or missing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// What kind it is.
    pub reader: BackendKind,
    /// The kind of context or of backend, such as `core 4.5` or `vulkan`.
    pub kind: String,
    /// Who it is and what it takes, or why it is missing.
    pub outcome: Result<(Device, Limits), Failure>,
}

impl Found {
    /// A reader that this build was made without.
    pub fn not_built(reader: BackendKind) -> Found {
        let message =
            format!("this build has no reader `{reader}`: it lacks the cargo feature `{reader}`");
        Found { reader, kind: String::new(), outcome: Err(Failure::missing(message, "")) }
    }
}

/// The evaluator, which is always there.
pub fn cpu() -> Found {
    let device = Device {
        reader: BackendKind::Cpu,
        adapter: "evaluator".to_string(),
        driver: landfall_layout::format::NAME.to_string(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        software: true,
    };
    Found {
        reader: BackendKind::Cpu,
        kind: String::new(),
        outcome: Ok((device, Limits::default())),
    }
}

/// What a device takes at most; `None` where it has no such thing or sets no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Bytes of a uniform block.
    pub uniform_block_size: Option<u64>,
    /// Bytes of a storage block.
    pub storage_block_size: Option<u64>,
    /// Uniform blocks a stage.
    pub uniform_blocks: Option<u64>,
    /// Storage blocks a compute shader.
    pub storage_blocks: Option<u64>,
    /// Bytes of push constants.
    pub push_constant_size: Option<u64>,
    /// Pixels of an image, each way.
    pub image_side: Option<u64>,
    /// Invocations of a workgroup.
    pub workgroup_invocations: Option<u64>,
    /// Workgroups of a dispatch, each way.
    pub workgroups: Option<u64>,
}
