//! Uploads a buffer in which every word is another, lets the shader read it, and says
//! for each leaf which byte was read.
//!
//! Takes the layout of a shader, makes [`probe`](super::probe)s of its text, has a
//! [`Reader`] run them, and gives a [`ShaderReport`].

pub(super) mod code;
mod compiled;
pub(super) mod partner;
pub mod report;
mod reported;
mod verifier;

use std::time::Duration;

use crate::backend::{Failure, Reader};
use crate::harness::access;
use crate::harness::spirv;
pub use compiled::run_compiled;
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::{Source, Stage};
use landfall_layout::{Diagnostic, Options, ShaderLayout, layout};
pub use report::{
    BlockReport, Cause, CompiledRun, ElementReport, Form, Outcome, ReadBy, ReaderReport,
    ShaderReport, Unprobed,
};

use verifier::Verifier;
pub(super) use verifier::every;

/// How a shader is verified.
#[derive(Clone, Debug)]
pub struct VerifyOptions {
    /// How it is read and laid out; loose uniforms are gathered.
    pub layout: Options,
    /// The layout that is to be proven, where it is not the computed one: blocks by name.
    pub given: Option<Vec<BlockLayout>>,
    /// The stages that read; a shader's own where there are none.
    pub stages: Vec<Stage>,
    /// Run the module that naga's own front end makes, not ours.
    pub naga: bool,
    /// Only the block of that name, by its own or its instance's.
    pub block: Option<String>,
    /// A reader that is not done with one probe by then has failed.
    pub limit: Duration,
}

impl Default for VerifyOptions {
    fn default() -> VerifyOptions {
        VerifyOptions {
            layout: Options::default(),
            given: None,
            stages: Vec::new(),
            naga: false,
            block: None,
            limit: Duration::from_secs(20),
        }
    }
}

/// A shader as [`verify`] takes it: its text and its layout.
#[derive(Clone, Debug)]
pub struct Subject {
    source: Source,
    shader: ShaderLayout,
}

impl Subject {
    /// Lays a shader out, its loose uniforms gathered.
    ///
    /// # Errors
    /// What makes it impossible to lay out; the layout is there for its files.
    pub fn new(
        source: &Source,
        options: &VerifyOptions,
    ) -> Result<Subject, (ShaderLayout, Vec<Diagnostic>)> {
        let options = Options { gather: true, naga: true, ..options.layout.clone() };
        let shader = layout(source, &options);
        if shader.has_errors() {
            let found = shader.diagnostics.clone();
            return Err((shader, found));
        }
        Ok(Subject { source: source.clone(), shader })
    }

    /// Its layout.
    pub fn layout(&self) -> &ShaderLayout {
        &self.shader
    }
}

/// Has every reader read every block of a shader.
pub fn verify(
    subject: &Subject,
    options: &VerifyOptions,
    readers: &mut [Box<dyn Reader>],
) -> ShaderReport {
    let Subject { source, shader } = subject;
    let blocks = shader.blocks.iter().filter(|block| {
        let named = |name: &str| *block.name == *name || block.instance.as_deref() == Some(name);
        block.size.is_some() && options.block.as_deref().is_none_or(named)
    });
    let blocks = blocks.map(|block| {
        let expected = match &options.given {
            None => Some(block),
            Some(given) => given.iter().find(|other| other.name == block.name),
        };
        let access = access::of(block, &shader.files, source.language);
        let is_given = expected.is_some();
        let expected = expected.unwrap_or(block);
        let blocks = &shader.blocks;
        Verifier { source, options, blocks, block, expected, access }.block(readers, is_given)
    });
    ShaderReport {
        path: shader.path.clone(),
        language: shader.language.name(),
        blocks: blocks.collect(),
        compiled: None,
    }
}

/// Holds the decorations of a SPIR-V module, which a compiler of the user's made of the shader,
/// against its layout: one more reader in each block of the report.
///
/// # Errors
/// The words are no SPIR-V.
pub fn hold_spirv(
    subject: &Subject,
    options: &VerifyOptions,
    words: &[u32],
    report: &mut ShaderReport,
) -> Result<(), Failure> {
    let reflection = spirv::reflect(words)?;
    for block in &subject.shader.blocks {
        let given = options.given.as_ref();
        let expected = given.and_then(|given| given.iter().find(|b| b.name == block.name));
        let expected = expected.unwrap_or(block);
        let instance = block.instance.as_deref();
        let reported = report
            .blocks
            .iter_mut()
            .find(|other| other.name == *block.name && other.instance.as_deref() == instance);
        let Some(reported) = reported else { continue };
        let mut reads = reported::elements(block, expected, &reflection);
        reads.extend(reported::matrices(block, expected, &reflection));
        let elsewhere = reads.iter().any(|read| read.byte_read != Some(read.expected_byte));
        let (outcome, reason) = match (reads.is_empty(), elsewhere) {
            (true, _) => (Outcome::Skipped, Some("the module has no such block".to_string())),
            (false, true) => (Outcome::Disagrees, None),
            (false, false) => (Outcome::Confirmed, None),
        };
        reported.readers.push(ReaderReport {
            reader: ReadBy::Spirv,
            stage: subject.source.stage.map_or("fragment", Stage::name),
            form: Form::Spirv,
            outcome,
            reason,
            log: String::new(),
            reads,
            causes: Vec::new(),
        });
    }
    Ok(())
}
