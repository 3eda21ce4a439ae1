//! Coverage: the bytes of its blocks that a shader never reads.
//!
//! Bytes that no instruction could load are certain (`loads`); for the others, the interpreter runs
//! the shader's entry points over a small grid, with given or generated block contents, and records
//! the bytes read. Used by `landfall verify --coverage`.

pub(super) mod fill;
mod loads;

use std::time::{Duration, Instant};

use serde::Serialize;

use self::fill::{Filling, inputs};
use super::access;
use crate::backend::{Backend, Failure, Grid, Job, Resource, StageCode};
use crate::harness::bindings as bound;
use crate::harness::bindings::Data;
use crate::harness::probe::plan::{LARGEST_BUFFER, TAIL};
use landfall_interp::{Cpu, Invocations, Port, Program, Settings};
use landfall_ir::module::{EntryPoint, Module, ModuleBlock};
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::{ArrayLen, Type};
use landfall_layout::source::{ExecutableStage, Source, Stage};
use landfall_layout::{Diagnostic, Options};

/// Number of invocations of a vertex or fragment stage: 16 quads.
const INVOCATIONS: usize = 64;

/// Maximum loop iterations of one invocation.
const BUDGET: u32 = 1 << 16;

/// The coverage of one block.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BlockCoverage {
    /// The name of the block.
    #[serde(skip)]
    pub name: String,
    /// The instance name, if any.
    #[serde(skip)]
    pub instance: Option<String>,
    /// Size of the buffer in bytes.
    pub bytes: u64,
    /// Number of bytes read in some run.
    pub read: u64,
    /// Number of bytes in leaves that no instruction could read.
    pub never: u64,
    /// The leaves in order.
    pub leaves: Vec<LeafCoverage>,
    /// Runs that failed, with the reason.
    pub failures: Vec<String>,
}

/// The coverage of one leaf.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LeafCoverage {
    /// The path.
    pub path: String,
    /// Number of bytes of all elements, without padding.
    pub bytes: u64,
    /// Number of these read in some run.
    pub read: u64,
    /// Number of these that no instruction could read.
    pub never: u64,
    /// Number of elements over all dimensions.
    pub elements: u64,
    /// The elements read, at least in part: first and last of each range.
    pub elements_read: Vec<[u64; 2]>,
    /// The worst verdict on its bytes.
    pub verdict: Verdict,
}

/// The verdict on a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every byte was read.
    Read,
    /// Some bytes were read.
    Partly,
    /// No byte was read, though some instruction could read it.
    Unread,
    /// No instruction could read it; this is certain.
    Never,
}

/// Finds the bytes of its blocks that a shader reads.
///
/// # Errors
/// Fails if the shader cannot run, or data names a block that does not exist.
pub fn coverage(
    source: &Source,
    options: &Options,
    data: &Data,
    limit: Duration,
) -> Result<Vec<BlockCoverage>, Vec<Diagnostic>> {
    let options = options.clone().with_gather(true).with_naga(false);
    let module = Module::new(source, &options)?;
    let deadline = Instant::now().checked_add(limit);
    let mut failures = Vec::new();
    let mut read: Vec<Vec<bool>> = Vec::new();
    // Other contents take other branches; a byte that any run reads is read.
    for filling in Filling::ALL {
        let longest = fill::longest(&module);
        let bytes = bound::blocks(&module, data, |block| fill::fill(block, filling, longest))
            .map_err(|found| vec![*found])?;
        read.resize_with(bytes.len(), Vec::new);
        for (all, bytes) in read.iter_mut().zip(&bytes) {
            // Backends bind multiples of four bytes.
            all.resize(bytes.len().next_multiple_of(4).max(all.len()), false);
        }
        let files = module.files();
        let writable = |block: &BlockLayout| access::writable(block, files, source.language);
        let resources = bound::resources(&module, bytes, writable, &[]);
        for entry in module.entry_points() {
            let settings =
                Settings { watch: true, budget: BUDGET, deadline, ..Settings::default() };
            match run(&module, &entry, filling, &resources, &settings, limit) {
                Ok(more) => {
                    for (all, more) in read.iter_mut().zip(more) {
                        all.iter_mut().zip(more).for_each(|(all, more)| *all |= more);
                    }
                }
                Err(failure) => {
                    let why = format!(
                        "`{}` with {} in its blocks: {failure}",
                        entry.name,
                        filling.name()
                    );
                    if !failures.contains(&why) {
                        failures.push(why);
                    }
                }
            }
        }
    }
    let sizes: Vec<usize> = read.iter().map(Vec::len).collect();
    let loadable = loads::loadable(&module, &sizes);
    let blocks = module.blocks().iter().zip(read.into_iter().zip(loadable));
    Ok(merged(blocks).into_iter().map(|one| judged(one, &failures)).collect())
}

/// Runs an entry point and returns the bytes read of each resource.
fn run(
    module: &Module,
    entry: &EntryPoint,
    filling: Filling,
    resources: &[Resource],
    settings: &Settings,
    limit: Duration,
) -> Result<Vec<Vec<bool>>, Failure> {
    match ExecutableStage::from_stage(entry.stage) {
        Some(ExecutableStage::Compute) => {
            let mut cpu = Cpu::new(settings.clone());
            let stages = vec![StageCode::of_module(Stage::Compute, &entry.name, module.clone())];
            let resources = resources.to_vec();
            // Two groups, as a shader may depend on the group's number.
            cpu.run(&Job { stages, resources, grid: Grid::Groups([2, 1, 1]), limit })?;
            Ok(cpu.notes.read)
        }
        Some(ExecutableStage::Vertex | ExecutableStage::Fragment) | None => {
            let program = Program::new(module, &[]);
            let ports: Vec<(Port, Vec<bool>)> = program.inputs(&entry.name);
            let invocations =
                Invocations { count: INVOCATIONS, inputs: inputs(&ports, filling, INVOCATIONS) };
            Ok(program.run_entry(&entry.name, &invocations, resources, settings)?.notes.read)
        }
    }
}

/// A block, whether each byte was read, and whether some instruction could read it.
type ReadBytes<'m> = (&'m ModuleBlock, (Vec<bool>, Vec<bool>));

/// Returns one row per block: the buffers of an array of blocks are one, as they share their layout.
fn merged<'m>(blocks: impl Iterator<Item = ReadBytes<'m>>) -> Vec<ReadBytes<'m>> {
    let mut all: Vec<ReadBytes<'m>> = Vec::new();
    let add = |all: &mut Vec<bool>, more: Vec<bool>| {
        all.resize(all.len().max(more.len()), false);
        all.iter_mut().zip(more).for_each(|(all, more)| *all |= more);
    };
    for (block, (read, loadable)) in blocks {
        let layout = &block.layout;
        let known = all.iter_mut().find(|(known, _)| {
            (&known.layout.name, &known.layout.instance) == (&layout.name, &layout.instance)
                && known.layout.leaves.len() == layout.leaves.len()
        });
        match known {
            Some((_, known)) => {
                add(&mut known.0, read);
                add(&mut known.1, loadable);
            }
            None => all.push((block, (read, loadable))),
        }
    }
    all
}

fn judged((block, (read, loadable)): ReadBytes<'_>, failures: &[String]) -> BlockCoverage {
    let layout = &block.layout;
    let leaves: Vec<LeafCoverage> =
        layout.leaves.iter().map(|leaf| leaf_of(leaf, &read, &loadable)).collect();
    BlockCoverage {
        name: layout.name.to_string(),
        instance: layout.instance.as_ref().map(ToString::to_string),
        bytes: read.len() as u64,
        read: leaves.iter().map(|leaf| leaf.read).sum(),
        never: leaves.iter().map(|leaf| leaf.never).sum(),
        leaves,
        failures: failures.to_vec(),
    }
}

fn leaf_of(leaf: &Leaf, read: &[bool], loadable: &[bool]) -> LeafCoverage {
    let mut found = LeafCoverage {
        path: leaf.path.clone(),
        bytes: 0,
        read: 0,
        never: 0,
        elements: 0,
        elements_read: Vec::new(),
        verdict: Verdict::Never,
    };
    let spots = spots(leaf);
    for start in starts(leaf, read.len() as u64) {
        let before = found.read;
        for spot in &spots {
            for byte in spot.start..spot.end {
                let at = (start + byte) as usize;
                let (Some(read), Some(loadable)) = (read.get(at), loadable.get(at)) else {
                    continue;
                };
                found.bytes += 1;
                found.read += u64::from(*read);
                // What was read could be read, whatever the code seems to say.
                found.never += u64::from(!*loadable && !*read);
            }
        }
        if found.read > before {
            let at = found.elements;
            // Elements in a row are one range.
            match found.elements_read.last_mut() {
                Some([_, last]) if *last + 1 == at => *last = at,
                Some(_) | None => found.elements_read.push([at, at]),
            }
        }
        found.elements += 1;
    }
    found.verdict = match (found.read, found.never) {
        (0, never) if never == found.bytes => Verdict::Never,
        (0, _) => Verdict::Unread,
        (read, _) if read == found.bytes => Verdict::Read,
        (_, _) => Verdict::Partly,
    };
    found
}

/// Returns the offset of each element of a leaf in a buffer of that size.
fn starts(leaf: &Leaf, size: u64) -> Vec<u64> {
    let mut starts = vec![leaf.offset.unwrap_or(0)];
    for (len, stride) in leaf.dims.iter().zip(&leaf.strides) {
        let count = match len {
            ArrayLen::Fixed(count) => u64::from(*count),
            ArrayLen::Runtime | ArrayLen::Override(_) => u64::from(TAIL),
        };
        let most = size.min(LARGEST_BUFFER);
        let each = |start: u64| {
            // No more elements than the buffer has room for.
            let count = count.min(most.saturating_sub(start).div_ceil((*stride).max(1)));
            (0..count).map(move |index| start + index * stride)
        };
        starts = starts.into_iter().flat_map(each).collect();
    }
    starts
}

/// Returns the bytes of one element, without the gaps between columns.
fn spots(leaf: &Leaf) -> Vec<std::ops::Range<u64>> {
    match &leaf.ty {
        Type::Matrix { scalar, columns, rows } => {
            let (lines, each) = if leaf.row_major { (*rows, *columns) } else { (*columns, *rows) };
            let size = u64::from(each) * u64::from(scalar.width);
            let stride = leaf.matrix_stride.unwrap_or(size);
            (0..u64::from(lines)).map(|line| line * stride..line * stride + size).collect()
        }
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => std::iter::once(0..leaf.size.unwrap_or(0)).collect(),
    }
}
