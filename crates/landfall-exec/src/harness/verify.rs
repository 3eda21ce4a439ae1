//! Verifies layouts: uploads a buffer in which every word is different, lets the shader read it,
//! and reports the byte that each leaf was read from.
//!
//! Takes a shader's layout, generates [`probe`](super::probe)s from its text, runs them on a
//! [`Backend`], and returns a [`ShaderReport`].

mod code;
mod declared;
pub(super) mod partner;
pub mod report;
mod reported;
pub(super) mod request;
mod settled;
mod user_spirv;
mod verifier;
mod web;

use std::time::Duration;

use crate::backend::{Backend, Failure};
use crate::harness::access;
pub use crate::harness::probe::plan::Unprobed;
use crate::harness::spirv;
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::{Language, ReadOptions, Source, Stage};
use landfall_layout::syntax::glsl::sized;
use landfall_layout::{Diagnostic, Options, ShaderLayout, layout, linked};
pub use report::{
    BackendReport, BlockReport, CompiledRun, ElementReport, Form, LeafCause, Outcome, ReadBy,
    ShaderReport,
};
pub use user_spirv::run_compiled;

use verifier::Verifier;
pub(super) use verifier::all_buffers;

/// Options for verifying a shader.
#[derive(Clone, Debug)]
pub struct VerifyOptions {
    /// The layout options; loose uniforms are gathered into a block.
    pub layout: Options,
    /// The layout to verify instead of the computed one: blocks by name.
    pub given: Option<Vec<BlockLayout>>,
    /// The stages to probe in; the shader's own if empty.
    pub stages: Vec<Stage>,
    /// Whether to run the module of naga's front end instead of Landfall's.
    pub naga: bool,
    /// Verify only the block with this name or instance name.
    pub block: Option<String>,
    /// The time limit of one probe; a backend that exceeds it has failed.
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

/// A shader to verify: its text and its layout.
#[derive(Clone, Debug)]
pub struct Subject {
    shader: ShaderLayout,
    run: ProbedText,
}

/// The text that backends run, as the layout reads the user's.
#[derive(Clone, Debug)]
struct ProbedText {
    source: Source,
    read: ReadOptions,
    shader: ShaderLayout,
}

impl Subject {
    /// Lays out a shader, its loose uniforms gathered into a block. Arrays that are as long as
    /// their largest index have that length written, since probes read them by other indices.
    ///
    /// # Errors
    /// The errors that prevent a layout; the layout is returned for its files.
    pub fn new(
        source: &Source,
        options: &VerifyOptions,
    ) -> Result<Subject, (ShaderLayout, Vec<Diagnostic>)> {
        let options = options.layout.clone().with_gather(true).with_naga(true);
        let probed = |source: &Source, read: ReadOptions| {
            // Only GLSL has arrays without a length before other members.
            let open = source.language == Language::Glsl && source.text.contains('[');
            let sized = open.then(|| sized(source, &read)).flatten();
            let source = sized.unwrap_or_else(|| linked(source, &read).into_owned());
            let mut options = options.clone();
            options.read = read;
            let shader = layout(&source, &options);
            ProbedText { source, read: options.read, shader }
        };
        let own = probed(source, options.read.clone());
        let shader = own.shader.clone();
        if shader.has_errors() {
            let found = shader.diagnostics.clone();
            return Err((shader, found));
        }
        // Where backends might decide conditions in another way, the decided text is run.
        let settled = settled::settled(source, &options.read);
        let settled = settled.map(|(source, read)| probed(&source, read));
        // If that has errors, the user's own is run.
        let run = settled.filter(|run| !run.shader.has_errors()).unwrap_or(own);
        Ok(Subject { shader, run })
    }

    pub fn layout(&self) -> &ShaderLayout {
        &self.shader
    }
}

/// Probes every block of a shader on every backend.
pub fn verify(
    subject: &Subject,
    options: &VerifyOptions,
    backends: &mut [Box<dyn Backend>],
) -> ShaderReport {
    let Subject { shader, run } = subject;
    let source = &run.source;
    let mut own = options.clone();
    own.layout.read = run.read.clone();
    let options = &own;
    let verified = run.shader.blocks.iter().filter(|block| {
        let named = |name: &str| *block.name == *name || block.instance.as_deref() == Some(name);
        // A buffer needs a size.
        block.size.is_some() && options.block.as_deref().is_none_or(named)
    });
    let reports = verified.map(|block| {
        let expected = match &options.given {
            None => Some(block),
            Some(given) => given.iter().find(|other| other.name == block.name),
        };
        let access = access::member_accesses(block, &run.shader.files, source.language);
        let is_given = expected.is_some();
        let expected = expected.unwrap_or(block);
        let blocks = &run.shader.blocks;
        Verifier { source, options, blocks, block, expected, access }.block(backends, is_given)
    });
    ShaderReport {
        path: shader.path.clone(),
        language: shader.language.name(),
        assumed_target: shader.assumed_target,
        blocks: reports.collect(),
        compiled: None,
    }
}

/// Compares the decorations of SPIR-V that a third-party compiler made from the shader with its
/// layout, and adds the result to each block of the report.
///
/// # Errors
/// Fails if the words are no SPIR-V.
pub fn compare_spirv(
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
        reported.backends.push(BackendReport {
            backend: ReadBy::Spirv,
            stage: subject.run.source.stage.map_or("fragment", Stage::name),
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
