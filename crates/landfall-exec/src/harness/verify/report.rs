//! What verifying a shader found: for each block and reader, which bytes every leaf was read from.
//!
//! Plain data, as `landfall schema verify` describes it; made by
//! [`verify`](super::verify), printed by the report of `landfall verify`.

use crate::backend::BackendKind;
use serde::Serialize;

use crate::backend::{Device, Failure};
use crate::harness::coverage::BlockCoverage;

/// One shader.
#[derive(Clone, Debug, Serialize)]
pub struct ShaderReport {
    /// The path as messages print it.
    pub path: String,
    /// `glsl` or `wgsl`.
    pub language: &'static str,
    /// Its blocks, in the order of the text.
    pub blocks: Vec<BlockReport>,
    /// What a user's own SPIR-V gave when it was run, where that was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compiled: Option<CompiledRun>,
}

/// A user's own SPIR-V, run as it is beside landfall's module over the same buffers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CompiledRun {
    /// Who ran both.
    pub reader: BackendKind,
    /// Whether they gave the same; skipped where it could not be run.
    pub outcome: Outcome,
    /// Words of images and buffers that were compared.
    pub compared: usize,
    /// Of them, those that differ.
    pub differing: usize,
    /// Why it was not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// One block of a shader.
#[derive(Clone, Debug, Serialize)]
pub struct BlockReport {
    /// Its name.
    pub name: String,
    /// Its variable, where there is one.
    pub instance: Option<String>,
    /// `std140`, …
    pub rules: &'static str,
    /// Bytes a buffer must hold, a runtime-sized tail counted with one element.
    pub size: u64,
    /// How many leaves it has.
    pub leaves: usize,
    /// What each reader saw.
    pub readers: Vec<ReaderReport>,
    /// Leaves that no probe reads, and why.
    pub unprobed: Vec<Unprobed>,
    /// Which of its bytes the shader's own code reads, where that was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage: Option<BlockCoverage>,
}

/// A leaf that no probe reads.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unprobed {
    /// Its path.
    pub path: String,
    /// Why.
    pub reason: String,
}

/// What tells where a block's members are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadBy {
    /// A probe on a backend.
    Backend(BackendKind),
    /// The decorations of a user's own SPIR-V, which nothing ran.
    Spirv,
}

impl ReadBy {
    /// Returns the name in reports: `cpu`, `gl`, `gpu`, `spirv`.
    pub fn name(self) -> &'static str {
        match self {
            ReadBy::Backend(kind) => kind.name(),
            ReadBy::Spirv => "spirv",
        }
    }
}

impl Serialize for ReadBy {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// What one reader saw of one block.
#[derive(Clone, Debug, Serialize)]
pub struct ReaderReport {
    /// Which reader.
    pub reader: ReadBy,
    /// The stage that read.
    pub stage: &'static str,
    /// The text that was run.
    pub form: Form,
    /// What came of it.
    pub outcome: Outcome,
    /// Why there is no answer, or none from this reader.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What the driver or its compiler said.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub log: String,
    /// Every element that was read or written.
    pub reads: Vec<ElementReport>,
    /// For each leaf that was read elsewhere, the likely cause.
    pub causes: Vec<Cause>,
}

/// The text a reader ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// The user's text, a probe in place of its `main`.
    Original,
    /// The same ported to GLSL 4.50, its loose uniforms in one block.
    Ported,
    /// A module of the user's text with landfall's offsets.
    Module,
    /// A module as naga's own front end makes it.
    Naga,
    /// The decorations of a module that a compiler of the user's made.
    Spirv,
}

/// What came of a probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// Every read saw the byte it had to.
    Confirmed,
    /// Some read saw another.
    Disagrees,
    /// The reader could not run it.
    Failed,
    /// It is not for this reader: WGSL on OpenGL.
    Skipped,
}

/// One element that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ElementReport {
    /// `data[63].pos.y`.
    pub path: String,
    /// The leaf's pattern: `data[].pos`.
    pub leaf: String,
    /// `constant`, `dynamic`, `copied`, `passed`, `written`, or `reported` by the driver.
    pub way: &'static str,
    /// The byte it had to see.
    pub expected_byte: u64,
    /// The byte it saw; none where it saw nothing of the upload.
    pub byte_read: Option<u64>,
}

/// Why a leaf was read from elsewhere, as far as can be told.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Cause {
    /// The leaf's pattern.
    pub leaf: String,
    /// In words.
    pub cause: String,
}

/// A reader, whether it ran or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Attendance {
    /// It ran.
    Here(Device),
    /// It could not be had.
    Missing {
        /// `cpu`, `gl` or `gpu`.
        reader: BackendKind,
        /// Why.
        failure: Failure,
    },
}

impl ShaderReport {
    /// Adds to each block which of its bytes the shader's own code reads.
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

    /// Whether some reader read another byte than expected.
    pub fn disagrees(&self) -> bool {
        let compiled = self.compiled.iter().map(|run| run.outcome);
        self.outcomes().chain(compiled).any(|outcome| outcome == Outcome::Disagrees)
    }

    /// Whether some reader could not run a probe.
    pub fn failed(&self) -> bool {
        self.outcomes().any(|outcome| outcome == Outcome::Failed)
    }

    fn outcomes(&self) -> impl Iterator<Item = Outcome> {
        self.blocks.iter().flat_map(|block| block.readers.iter().map(|reader| reader.outcome))
    }
}
