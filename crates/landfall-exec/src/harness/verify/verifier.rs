//! Verifies one block on every backend: runs its probes and compares their results.
//!
//! Takes plans and code of probes; returns a [`BlockReport`].

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use super::code;
use super::request::{BoundBuffer, ProbeCode, ProbeRequest, ResultsPlace, gl_name};
use super::{
    BackendReport, BlockReport, ElementReport, Form, LeafCause, Outcome, ReadBy, VerifyOptions,
    reported,
};
use crate::backend::reflection::Reflection;
use crate::backend::{
    Backend, BackendKind, Failure, FailureKind, Grid, Job, Resource, ResourceKind,
};
use crate::harness::bindings::kind as buffer_of;
use crate::harness::probe::cause::OtherRules;
use crate::harness::probe::plan::{Access, LARGEST_BUFFER, Plan, Plans, TAIL, plans};
use crate::harness::probe::sentinel::{self, Grain};
use crate::harness::probe::{ProbeResult, ProbedLocation, cause, results};
use landfall_layout::buffer::Buffer;
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::{AddressSpace, ArrayLen, ScalarKind, Type};
use landfall_layout::source::{ExecutableStage, Source, Stage};

/// Maximum number of buffers bound per dimension of an array of blocks.
const MAX_BUFFERS: u32 = 64;

/// A block and the layout to verify.
pub(super) struct Verifier<'a> {
    pub source: &'a Source,
    pub options: &'a VerifyOptions,
    pub blocks: &'a [BlockLayout],
    pub block: &'a BlockLayout,
    pub expected: &'a BlockLayout,
    /// The access to each member.
    pub access: Vec<Access>,
}

impl Verifier<'_> {
    pub fn block(&self, backends: &mut [Box<dyn Backend>], is_given: bool) -> BlockReport {
        let buffer = self.buffer();
        let refusal = self.refusal(is_given, &buffer);
        let own = [self.source.stage.unwrap_or(Stage::Fragment)];
        let stages: &[Stage] =
            if self.options.stages.is_empty() { &own } else { &self.options.stages };
        let mut reports = Vec::new();
        let mut unprobed = Vec::new();
        for backend in backends {
            let kind = backend.device().backend;
            let plans = plans(self.block, self.expected, &self.access, self.source.language, kind);
            for &stage in stages {
                reports.push(match (&refusal, &buffer) {
                    (None, Ok(buffer)) => self.backend(backend.as_mut(), stage, &plans, *buffer),
                    (Some(reason), _) => skipped(backend.as_ref(), stage, reason),
                    (None, Err(reason)) => skipped(backend.as_ref(), stage, reason),
                });
            }
            // The same on every backend.
            unprobed = plans.unprobed;
        }
        BlockReport {
            name: self.block.name.to_string(),
            instance: self.block.instance.as_ref().map(ToString::to_string),
            rules: self.block.rules.name(),
            size: self.block.size.unwrap_or(0),
            leaves: self.block.leaves.len(),
            backends: reports,
            unprobed,
            coverage: None,
        }
    }

    /// Returns the size of a buffer that holds either layout, with [`TAIL`] elements of a
    /// runtime-sized tail.
    fn buffer(&self) -> Result<u64, String> {
        let (own, expected) = (bytes(self.block)?, bytes(self.expected)?);
        // naga rounds the size of a structure with dvec4 up to 32 bytes, and wgpu requires that
        // size.
        Ok(own.max(expected).next_multiple_of(32))
    }

    /// Returns the other blocks, filled with zeros: OpenGL requires every active block to be bound,
    /// and counts those of a dead `main` as active.
    fn others(&self) -> Vec<Resource> {
        let resource = |(block, element): (&BlockLayout, Vec<u32>)| {
            let bytes = vec![0; bytes(block).ok()?.next_multiple_of(4) as usize];
            let kind = match block.space {
                AddressSpace::Uniform => ResourceKind::Uniform(bytes),
                AddressSpace::Storage => ResourceKind::Storage { bytes, writable: true },
                _ => return None,
            };
            let name = gl_name(&block.name, &element);
            Some(Resource { name, group: 0, binding: 0, kind })
        };
        self.blocks
            .iter()
            .flat_map(|block| all_buffers(&block.count).into_iter().map(move |at| (block, at)))
            .filter_map(resource)
            .collect()
    }

    /// Returns the reason why no backend can probe the block, if there is one.
    fn refusal(&self, is_given: bool, buffer: &Result<u64, String>) -> Option<String> {
        if !is_given {
            return Some(format!("the given layout has no block `{}`", self.block.name));
        }
        match self.block.space {
            AddressSpace::BufferReference => {
                return Some("it is a buffer reference, which shaders read through an address: it cannot be bound".to_string());
            }
            AddressSpace::ShaderRecord => {
                return Some(
                    "it is a shader record of a ray tracing pipeline, which no backend runs"
                        .to_string(),
                );
            }
            AddressSpace::Uniform
            | AddressSpace::Storage
            | AddressSpace::PushConstant
            | AddressSpace::TaskPayload
            | AddressSpace::Default => {}
            space => return Some(format!("no backend binds `{}` blocks", space.name())),
        }
        let unknown = |len: &ArrayLen| !matches!(len, ArrayLen::Fixed(_));
        if self.block.count.iter().any(unknown) {
            return Some("the number of its buffers is not known".to_string());
        }
        if self.block.members.iter().any(|member| has_address(&member.ty)) {
            return Some("it holds addresses of other buffers".to_string());
        }
        buffer.as_ref().err().cloned()
    }

    fn backend(
        &self,
        backend: &mut dyn Backend,
        stage: Stage,
        plans: &Plans,
        buffer: u64,
    ) -> BackendReport {
        let name = backend.device().backend;
        let fits = code::fits(name, self.source, self.block, stage);
        let mut report = BackendReport {
            backend: ReadBy::Backend(name),
            stage: fits.as_ref().map_or(stage, |runs| Stage::from(*runs)).name(),
            form: code::form(name, self.source, self.block, self.options.naga),
            outcome: Outcome::Confirmed,
            reason: None,
            log: String::new(),
            reads: Vec::new(),
            causes: Vec::new(),
        };
        let runs = match fits {
            Ok(runs) => runs,
            Err(reason) => {
                report.outcome = Outcome::Skipped;
                report.reason = Some(reason);
                return report;
            }
        };
        let mut probe_results = Vec::new();
        for element in elements(&self.block.count) {
            for plan in plans.reads.iter().chain(&plans.writes) {
                match self.run(backend, runs, &element, plan, buffer) {
                    Ok(seen) => probe_results.extend(seen),
                    Err(failure) => {
                        // Other probes would fail alike.
                        self.refused(backend, stage, failure, &mut report);
                        return report;
                    }
                }
            }
        }
        self.record_results(&probe_results, &mut report);
        self.reported(backend, stage, &mut report);
        report
    }

    /// Returns what the driver reports of the text without a probe; `None` if it reports nothing, or
    /// the form has no such text.
    fn reflected(
        &self,
        backend: &mut dyn Backend,
        stage: Stage,
        form: Form,
    ) -> Option<Result<Reflection, Failure>> {
        let kind = backend.device().backend;
        match (form, kind) {
            (Form::Original | Form::Declared, _) | (Form::Ported, BackendKind::WebGpu) => {}
            _ => return None,
        }
        let texts = code::texts_without_probe(kind, self.source, self.block, self.options, stage);
        let texts: Vec<(Stage, &str)> = texts.iter().map(|(at, text)| (*at, &**text)).collect();
        backend.reflect(&texts, self.options.limit)
    }

    /// Compares the driver's reflection of the text with the layout.
    fn reported(&self, backend: &mut dyn Backend, stage: Stage, report: &mut BackendReport) {
        let Some(Ok(reflection)) = self.reflected(backend, stage, report.form) else { return };
        for element in reported::elements(self.block, self.expected, &reflection) {
            if element.byte_read != Some(element.expected_byte) {
                report.outcome = Outcome::Disagrees;
            }
            report.reads.push(element);
        }
    }

    /// Records why a probe has no result. A shader the backend cannot take at all is no failure of
    /// the backend: a text that its compiler rejects without a probe too, or a shader without a
    /// module.
    fn refused(
        &self,
        backend: &mut dyn Backend,
        stage: Stage,
        failure: Failure,
        report: &mut BackendReport,
    ) {
        report.outcome = Outcome::Failed;
        report.reason = Some(failure.message);
        report.log = failure.log;
        if failure.kind == FailureKind::Unfit {
            report.outcome = Outcome::Skipped;
        }
        if failure.kind != FailureKind::Refused {
            return;
        }
        let alone = self.reflected(backend, stage, report.form);
        if let Some(Err(Failure { kind: FailureKind::Refused, log, .. })) = alone {
            report.outcome = Outcome::Skipped;
            report.reason = Some("its compiler rejects the shader".to_string());
            report.log = log;
        }
    }

    /// Runs a plan on one buffer of the block: once over sentinels, and once per bit for bools. For
    /// units other than words, each pass encodes some bits of their positions.
    fn run(
        &self,
        backend: &mut dyn Backend,
        stage: ExecutableStage,
        element: &[u32],
        plan: &Plan,
        buffer: u64,
    ) -> Result<Vec<ProbeResult>, Failure> {
        let need = ProbeRequest {
            backend: backend.device().backend,
            source: self.source,
            block: self.block,
            element,
            plan,
            stage,
            writable: self.access.iter().any(|access| access.write),
            options: self.options,
        };
        let code = code::code(&need)?;
        let writes =
            plan.reads.iter().any(|read| read.way == crate::harness::probe::AccessMode::Written);
        let mut ask = |bytes: Vec<u8>| self.ask(backend, &code, stage, plan, bytes);
        if plan.grain != Grain::Word {
            // Into zeros, so that what is there afterwards was written.
            if writes {
                return Ok(results::written_grains(plan, &ask(vec![0; buffer as usize])?.block));
            }
            let passes = (0..plan.grain.passes(buffer))
                .map(|pass| Ok(ask(sentinel::sentinel_buffer(buffer, plan.grain, pass))?.words));
            let passes = passes.collect::<Result<Vec<_>, Failure>>()?;
            return Ok(results::read_grains(plan, buffer, &passes));
        }
        let answer = ask(sentinel::buffer(buffer))?;
        if writes {
            return Ok(results::written(plan, &answer.block));
        }
        let mut passes = Vec::new();
        if plan.reads.iter().any(|read| read.scalar.kind == ScalarKind::Bool) {
            for bit in 0..sentinel::passes(buffer) {
                passes.push(ask(sentinel::pass(buffer, bit))?.words);
            }
        }
        Ok(results::read(plan, buffer, &answer.words, &passes))
    }

    fn ask(
        &self,
        backend: &mut dyn Backend,
        code: &ProbeCode,
        stage: ExecutableStage,
        plan: &Plan,
        bytes: Vec<u8>,
    ) -> Result<Words, Failure> {
        let mut results = Vec::with_capacity(plan.words as usize * 4);
        for index in &plan.indices {
            results.extend_from_slice(&index.to_le_bytes());
        }
        results.resize(plan.words as usize * 4, 0);
        let bound = |bound: &BoundBuffer, kind| Resource {
            name: bound.name.clone(),
            group: bound.group,
            binding: bound.binding,
            kind,
        };
        let block = buffer_of(self.block, bytes, code.writable);
        let mut resources = vec![bound(&code.block, block)];
        let mut grid = crate::backend::single_run(stage);
        // The answer has the block's buffer first, then the results'.
        match &code.results {
            ResultsPlace::Buffer(place) => {
                let kind = ResourceKind::Storage { bytes: results, writable: true };
                resources.push(bound(place, kind));
            }
            ResultsPlace::Pixels(indices) => {
                resources
                    .push(bound(&BoundBuffer::default(), ResourceKind::Loose(indices.clone())));
                grid = a_word_each(grid, plan.words);
            }
        }
        resources.extend(code.others.iter().cloned());
        if backend.device().backend == BackendKind::Gl {
            let others = self.others().into_iter();
            resources.extend(others.filter(|other| other.name != code.block.name));
        }
        let job = Job { stages: code.stages.clone(), resources, grid, limit: self.options.limit };
        let mut answer = backend.run(&job)?;
        if let ResultsPlace::Pixels(_) = code.results {
            let words = answer.pixels.iter().map(|pixel| pixel[0]).collect();
            return Ok(Words { words, block: Vec::new() });
        }
        let mut buffers = answer.buffers.drain(..);
        let (block, results) = (buffers.next().flatten(), buffers.next().flatten());
        let Some(results) = results else {
            return Err(Failure {
                kind: FailureKind::Died,
                message: "the results were not returned".to_string(),
                log: String::new(),
            });
        };
        let words = results.chunks_exact(4);
        let words = words.map(|b| u32::from_le_bytes(b.try_into().expect("chunks of four")));
        Ok(Words { words: words.collect(), block: block.unwrap_or_default() })
    }

    /// Adds the results to the report, with a cause for each leaf that was read elsewhere.
    fn record_results(&self, probe_results: &[ProbeResult], report: &mut BackendReport) {
        let mut wrong: BTreeMap<usize, Vec<&ProbeResult>> = BTreeMap::new();
        for probe_result in probe_results {
            report.reads.push(element_report(self.block, probe_result));
            if !probe_result.is_expected() {
                wrong.entry(probe_result.read.leaf).or_default();
            }
        }
        if wrong.is_empty() {
            return;
        }
        report.outcome = Outcome::Disagrees;
        for probe_result in probe_results {
            if let Some(seen) = wrong.get_mut(&probe_result.read.leaf) {
                seen.push(probe_result);
            }
        }
        let others = OtherRules::from_block(self.block);
        let expected: FxHashMap<&str, &Leaf> =
            self.expected.leaves.iter().map(|leaf| (leaf.path.as_str(), leaf)).collect();
        for (leaf, seen) in wrong {
            let path = &self.block.leaves[leaf].path;
            let leaf = expected.get(path.as_str());
            let cause = leaf.and_then(|leaf| cause::cause(&others, leaf, &seen));
            if let Some(cause) = cause {
                report.causes.push(LeafCause { leaf: path.clone(), cause });
            }
        }
    }
}

/// Returns the grid of a run with that many results, one in each pixel or vertex.
fn a_word_each(grid: Grid, words: u32) -> Grid {
    let words = words.max(1);
    match grid {
        Grid::Points { texel, .. } => Grid::Points { count: words, texel },
        Grid::Image { texel, .. } => Grid::Image { width: words, height: 1, texel },
        Grid::Groups(groups) => Grid::Groups(groups),
    }
}

/// The words and bytes returned by a run.
struct Words {
    words: Vec<u32>,
    /// The block's own buffer, if it was written.
    block: Vec<u8>,
}

fn has_address(ty: &Type) -> bool {
    match ty.innermost() {
        Type::Address(_) => true,
        Type::Struct(inner) => inner.members.iter().any(|member| has_address(&member.ty)),
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Matrix { .. }
        | Type::Array { .. } => false,
    }
}

/// Returns the size of a buffer for a block, with [`TAIL`] elements of a runtime-sized tail.
fn bytes(block: &BlockLayout) -> Result<u64, String> {
    if block.size.is_some_and(|size| size > LARGEST_BUFFER) {
        let size = block.size.unwrap_or(0);
        return Err(format!("it has {size} bytes, but probes fill {LARGEST_BUFFER} at most"));
    }
    let has_tail = block.members.iter().any(|member| member.dims.contains(&ArrayLen::Runtime));
    let buffer = match has_tail {
        true => Buffer::with_tail(block, TAIL as usize),
        false => Buffer::new(block),
    };
    buffer.map(|buffer| buffer.bytes().len() as u64).map_err(|error| error.to_string())
}

fn skipped(backend: &dyn Backend, stage: Stage, reason: &str) -> BackendReport {
    BackendReport {
        backend: ReadBy::Backend(backend.device().backend),
        stage: stage.name(),
        form: Form::Original,
        outcome: Outcome::Skipped,
        reason: Some(reason.to_string()),
        log: String::new(),
        reads: Vec::new(),
        causes: Vec::new(),
    }
}

/// Returns the indices of the buffers that are probed in an array of blocks: first and last of each
/// dimension.
fn elements(count: &[ArrayLen]) -> Vec<Vec<u32>> {
    combined(count, |length| {
        let mut ends = vec![0, length.saturating_sub(1)];
        ends.dedup();
        ends
    })
}

/// Returns the indices of every buffer of an array of blocks.
pub(crate) fn all_buffers(count: &[ArrayLen]) -> Vec<Vec<u32>> {
    combined(count, |length| (0..length.min(MAX_BUFFERS)).collect())
}

fn combined(count: &[ArrayLen], chosen: impl Fn(u32) -> Vec<u32>) -> Vec<Vec<u32>> {
    let mut all = vec![Vec::new()];
    for len in count {
        let ArrayLen::Fixed(length) = len else { continue };
        let chosen = chosen(*length);
        all = all
            .iter()
            .flat_map(|start: &Vec<u32>| {
                chosen.iter().map(|at| [start.as_slice(), &[*at]].concat())
            })
            .collect();
    }
    all
}

fn element_report(block: &BlockLayout, probe_result: &ProbeResult) -> ElementReport {
    let read = &probe_result.read;
    let leaf = &block.leaves[read.leaf].path;
    let mut path = String::new();
    let mut indices = read.element.iter();
    for (nth, part) in leaf.split("[]").enumerate() {
        if nth > 0 {
            path.push_str(&format!("[{}]", indices.next().copied().unwrap_or(0)));
        }
        path.push_str(part);
    }
    if let Some(column) = read.column {
        path.push_str(&format!("[{column}]"));
    }
    if let Some(row) = read.row {
        path.push('.');
        path.push_str(["x", "y", "z", "w"][usize::from(row)]);
    }
    ElementReport {
        path,
        leaf: leaf.clone(),
        way: read.way.name(),
        expected_byte: read.byte,
        byte_read: match probe_result.got {
            ProbedLocation::Byte(byte) => Some(byte),
            ProbedLocation::Other(_) => None,
        },
    }
}
