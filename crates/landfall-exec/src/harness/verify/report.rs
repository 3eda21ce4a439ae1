//! The results of verifying a shader: by block and backend, the bytes that every leaf was read
//! from.
//!
//! Plain data, as `landfall schema verify` describes it; made by [`verify`](super::verify), printed
//! by the report of `landfall verify`.

use crate::backend::BackendKind;
use landfall_layout::Target;
use serde::Serialize;

use crate::backend::{Device, Failure};
use crate::harness::coverage::BlockCoverage;
use crate::harness::probe::plan::Unprobed;

/// The report of one shader.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShaderReport {
    /// The path as messages print it.
    pub path: String,
    /// `glsl` or `wgsl`.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["glsl", "wgsl"])))]
    pub language: &'static str,
    /// The API assumed for a shader that names none, if its blocks depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub assumed_target: Option<Target>,
    /// The blocks in declaration order.
    pub blocks: Vec<BlockReport>,
    /// The run of third-party SPIR-V, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compiled: Option<CompiledRun>,
}

/// Third-party SPIR-V run unchanged, compared with Landfall's module over the same buffers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CompiledRun {
    /// The backend that ran both.
    pub backend: BackendKind,
    /// Whether the results agree; skipped if the SPIR-V could not be run.
    pub outcome: Outcome,
    /// Number of words of images and buffers compared.
    pub compared: usize,
    /// Number of these that differ.
    pub differing: usize,
    /// The reason why it was not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// The report of one block.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BlockReport {
    /// The name of the block.
    pub name: String,
    /// The instance name, if any.
    pub instance: Option<String>,
    /// The layout rules: `std140`, …
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = ["std140", "std430", "scalar", "wgsl"]))
    )]
    pub rules: &'static str,
    /// The buffer's minimum size in bytes, with one element of a runtime-sized tail.
    pub size: u64,
    /// The number of leaves.
    pub leaves: usize,
    /// The results by backend.
    pub backends: Vec<BackendReport>,
    /// Leaves that no probe reads.
    pub unprobed: Vec<Unprobed>,
    /// The bytes that the shader's own code reads, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage: Option<BlockCoverage>,
}

/// The source of a block's actual layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ReadBy {
    /// The decorations of third-party SPIR-V, which is not run.
    Spirv,
    /// Probes on a backend.
    #[serde(untagged)]
    Backend(BackendKind),
}

impl ReadBy {
    /// Returns the name in reports: `cpu`, `gl`, `gpu`, `webgl`, `webgpu`, `spirv`.
    pub fn name(self) -> &'static str {
        match self {
            ReadBy::Backend(kind) => kind.name(),
            ReadBy::Spirv => "spirv",
        }
    }
}

/// The results of one backend for one block.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BackendReport {
    /// The backend.
    #[cfg_attr(
        feature = "schema",
        schemars(with = "String", extend("enum" = ["cpu", "gl", "gpu", "webgl", "webgpu", "spirv"]))
    )]
    pub backend: ReadBy,
    /// The stage of the probes.
    pub stage: &'static str,
    /// The form of code that was run.
    pub form: Form,
    /// The outcome.
    pub outcome: Outcome,
    /// The reason for a missing result.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The log of the driver or its compiler.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub log: String,
    /// Every element read or written.
    pub reads: Vec<ElementReport>,
    /// The likely cause for each leaf that was read elsewhere.
    pub causes: Vec<LeafCause>,
}

/// The form of code that a backend ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// The user's text with a probe instead of its `main`; with its macros expanded and its conditions
    /// decided where the backend could decide them in another way than the layout does.
    Original,
    /// The same, ported to GLSL 4.50 with its loose uniforms in one block; for WebGL, the
    /// declaration of that block.
    Ported,
    /// The block's own declaration in GLSL ES 3.00, with a probe.
    Declared,
    /// A module of the user's text with Landfall's offsets.
    Module,
    /// A module of naga's front end.
    Naga,
    /// The decorations of a third-party compiler's SPIR-V.
    Spirv,
}

/// The outcome of a block's probes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// Every read reached the expected byte.
    Confirmed,
    /// Some read reached another byte.
    Disagrees,
    /// The backend could not run a probe.
    Failed,
    /// Not applicable to this backend, such as WGSL on OpenGL and GLSL on WebGPU.
    Skipped,
}

/// The result of one element read or written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ElementReport {
    /// `data[63].pos.y`.
    pub path: String,
    /// The leaf's pattern: `data[].pos`.
    pub leaf: String,
    /// `constant`, `dynamic`, `copied`, `passed`, `written`, or `reported` by the driver.
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = [
            "constant", "dynamic", "copied", "passed", "written", "reported"
        ]))
    )]
    pub way: &'static str,
    /// The expected byte.
    pub expected_byte: u64,
    /// The byte reached; `None` if it is not in the upload.
    pub byte_read: Option<u64>,
}

/// The likely cause of a leaf being read elsewhere.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LeafCause {
    /// The leaf's pattern.
    pub leaf: String,
    /// The cause, as text.
    pub cause: String,
}

/// A backend that was requested, available or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BackendStatus {
    /// Available.
    Here(Device),
    /// Not available.
    Missing { backend: BackendKind, failure: Failure },
}

impl ShaderReport {
    /// Adds to each block the coverage by the shader's own code.
    pub fn cover(&mut self, found: Vec<BlockCoverage>) {
        for coverage in found {
            let block = self
                .blocks
                .iter_mut()
                .find(|block| block.name == coverage.name && block.instance == coverage.instance);
            if let Some(block) = block {
                block.coverage = Some(coverage);
            }
        }
    }

    /// Returns whether some backend read an unexpected byte.
    pub fn disagrees(&self) -> bool {
        let compiled = self.compiled.iter().map(|run| run.outcome);
        self.outcomes().chain(compiled).any(|outcome| outcome == Outcome::Disagrees)
    }

    /// Returns whether some backend could not run a probe.
    pub fn failed(&self) -> bool {
        self.outcomes().any(|outcome| outcome == Outcome::Failed)
    }

    fn outcomes(&self) -> impl Iterator<Item = Outcome> {
        self.blocks.iter().flat_map(|block| block.backends.iter().map(|backend| backend.outcome))
    }
}
