//! Runs a function on a driver over thousands of lanes a job: words in through one storage buffer,
//! words out through another.
//!
//! Takes a [`PureFunction`]; `module` builds an entry point around its caller for the interpreter
//! and wgpu, `text` adds a `main` to the user's GLSL for OpenGL. Backends cache compiled code, so
//! that one [`Kernel`] compiles once. Used by `landfall_accuracy::stress` and
//! [`call`](super::call()).

mod builder;
mod module;
mod packing;
mod pieces;
mod text;

use crate::backend::BackendKind;
use std::time::Duration;

use naga::{AddressSpace, Statement};

use super::effects::effects_of;
use super::pure::{CallPurpose, PureFunction};
use crate::backend::{
    Backend, Device, Failure, Grid, Job, Resource, ResourceKind, StageCode, Texel,
};
use landfall_interp::Words;
use landfall_ir::call_graph;
use landfall_layout::Diagnostic;
use packing::LaneWords;

/// A function in the form that a backend takes.
#[derive(Clone, Debug)]
pub struct Kernel<'p> {
    pure: &'p PureFunction,
    places: LaneWords,
    code: KernelCode,
}

/// The code to run, and the resources besides the two buffers.
#[derive(Clone, Debug)]
struct KernelCode {
    stages: Vec<StageCode>,
    resources: Vec<Resource>,
    /// The input and output buffers of words, without contents yet.
    buffers: [Resource; 2],
    lanes: LaneMap,
}

/// The assignment of lanes to invocations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LaneMap {
    /// Workgroups of this many invocations.
    Groups(u32),
    /// Pixels, [`ROW`] to a row.
    Pixels,
    /// [`TILE`] by [`TILE`] pixels for one lane, for derivatives.
    Tile,
    /// Vertices.
    Vertices,
}

/// Pixels in a row.
const ROW: u32 = 256;

/// Width and height of a tile for derivatives: in a partly drawn tile, llvmpipe (Mesa 22.3.6) reads
/// zeros for a neighbour's loads of a storage buffer.
const TILE: u32 = 64;

/// Maximum size of a job's buffers in bytes: every driver with storage buffers allows it (OpenGL
/// 4.3 table 23.64: 2^24), and jobs of this size show progress.
const MAX_BYTES: usize = 1 << 23;

/// Maximum number of lanes in a job: every driver allows an image of this many pixels in rows of
/// [`ROW`], and a row of this many points.
const MAX_LANES: usize = 1 << 16;
const MAX_VERTICES: usize = 1 << 12;

/// The results of a driver.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KernelResult {
    /// By result of [`PureFunction::results`]: words by scalar and lane, as [`PureFunction::call`]
    /// returns them; zeros in discarded lanes.
    pub results: Vec<Words>,
    /// The lanes that executed a `discard`.
    pub discarded: Vec<bool>,
}

impl PureFunction {
    /// Prepares the function for a backend. The module or text is built here, once; the driver
    /// compiles it at the first call.
    ///
    /// # Errors
    /// Fails if the backend cannot run it, such as WGSL on OpenGL.
    pub fn on(&self, device: &Device) -> Result<Kernel<'_>, Failure> {
        let places = LaneWords::new(self);
        let places = places.ok_or_else(|| Failure::refused("the call is too large", ""))?;
        let code = match device.backend {
            BackendKind::Gl => text::code(self, &places)?,
            BackendKind::Cpu | BackendKind::Gpu | BackendKind::WebGl | BackendKind::WebGpu => {
                module::code(self, &places)?
            }
        };
        Ok(Kernel { pure: self, places, code })
    }
}

impl Kernel<'_> {
    /// Calls the function over lanes, as many a job as the buffers allow; `limit` is that of one
    /// job. The columns are those of [`PureFunction::call`].
    ///
    /// # Errors
    /// Fails if the backend rejects the function or the job; after
    /// [`Died`](crate::backend::FailureKind::Died) and
    /// [`TimedOut`](crate::backend::FailureKind::TimedOut) the backend may be unusable.
    pub fn call(
        &self,
        backend: &mut dyn Backend,
        columns: &[Vec<u64>],
        lanes: usize,
        limit: Duration,
    ) -> Result<KernelResult, Failure> {
        let scalars: usize = self.pure.parameters.iter().map(|p| p.scalars.len()).sum();
        if columns.len() != scalars || columns.iter().any(|column| column.len() != lanes) {
            let message = format!(
                "the arguments of `{}` are {scalars} scalars: give {scalars} columns of {lanes} \
                 values each",
                self.pure.shown
            );
            return Err(Failure::refused(message, ""));
        }
        let results = self.pure.results.iter().map(|r| vec![Vec::new(); r.ty.scalars().len()]);
        let mut called = KernelResult { results: results.collect(), discarded: Vec::new() };
        let mut job = Job {
            stages: self.code.stages.clone(),
            resources: self.code.buffers.iter().chain(&self.code.resources).cloned().collect(),
            grid: Grid::Groups([1, 1, 1]),
            limit,
        };
        let unit = self.code.lanes.unit();
        let most = self.lanes_a_job();
        let mut from = 0;
        while from < lanes {
            let count = most.min(lanes - from);
            // Fewer lanes than a row of pixels make a shorter row.
            let padded = match self.code.lanes {
                LaneMap::Pixels if count < unit => count,
                LaneMap::Pixels | LaneMap::Tile | LaneMap::Groups(_) | LaneMap::Vertices => {
                    count.next_multiple_of(unit)
                }
            };
            let bytes =
                packing::packed(self.pure, &self.places, columns, from..from + count, padded);
            job.resources[0].kind = ResourceKind::Storage { bytes, writable: false };
            // Zeros tell the lanes that do not return.
            let bytes = vec![0; padded * self.places.words_out as usize * 4];
            job.resources[1].kind = ResourceKind::Storage { bytes, writable: true };
            job.grid = self.code.lanes.grid(padded as u32);
            let mut answer = backend.run(&job)?;
            let bytes = answer.buffers.get_mut(1).and_then(Option::take);
            let bytes = bytes.ok_or_else(|| Failure::died("the results were not returned", ""))?;
            packing::unpacked(
                self.pure,
                &self.places,
                &bytes,
                count,
                &mut called.results,
                &mut called.discarded,
            );
            from += count;
        }
        Ok(called)
    }

    /// Returns the maximum number of lanes in one job, by its buffers, in whole groups or rows.
    fn lanes_a_job(&self) -> usize {
        let words = self.places.words_in.max(self.places.words_out) as usize;
        let most = match self.code.lanes {
            LaneMap::Groups(_) | LaneMap::Pixels => MAX_LANES,
            LaneMap::Vertices => MAX_VERTICES,
            LaneMap::Tile => 1,
        };
        let unit = self.code.lanes.unit();
        let fitting = (MAX_BYTES / (words * 4)).min(most);
        match self.code.lanes {
            // Less than a row makes a row of its own.
            LaneMap::Pixels if fitting < unit => fitting.max(1),
            LaneMap::Pixels | LaneMap::Tile | LaneMap::Groups(_) | LaneMap::Vertices => {
                (fitting / unit * unit).max(unit)
            }
        }
    }
}

impl LaneMap {
    /// Returns the assignment of lanes to the pixels of a fragment stage.
    fn pixels(pure: &PureFunction) -> Result<LaneMap, Failure> {
        let ir = &pure.module.ir;
        let caller = ir.functions.iter().last().expect("the caller was appended").1;
        let seen = effects_of(ir, caller);
        // Neighbours matter to derivatives alone.
        if pure.purpose == CallPurpose::Pure || !seen.derivatives {
            return Ok(LaneMap::Pixels);
        }
        let stored = seen.stored.iter().map(|at| ir.global_variables[*at].space);
        let buffer = |space| matches!(space, AddressSpace::Storage { .. } | AddressSpace::Handle);
        let image = |s: &Statement| {
            matches!(s, Statement::ImageStore { .. } | Statement::ImageAtomic { .. })
        };
        let functions = call_graph::functions(ir, caller);
        if stored.into_iter().any(buffer)
            || functions.iter().any(|function| call_graph::statements(&function.body).any(image))
        {
            let message = format!(
                "`{}` takes derivatives, so each sample runs on a quad of pixels, and each pixel \
                 would write its buffer or image; name the function that takes the derivatives",
                pure.shown
            );
            return Err(Failure::refused(message, ""));
        }
        Ok(LaneMap::Tile)
    }

    /// Returns the number that lanes are a multiple of.
    fn unit(self) -> usize {
        match self {
            LaneMap::Groups(size) => size.max(1) as usize,
            LaneMap::Pixels => ROW as usize,
            LaneMap::Vertices | LaneMap::Tile => 1,
        }
    }

    fn grid(self, lanes: u32) -> Grid {
        match self {
            LaneMap::Groups(size) => Grid::Groups([lanes / size.max(1), 1, 1]),
            LaneMap::Pixels => {
                let width = ROW.min(lanes);
                Grid::Image { width, height: lanes.div_ceil(width.max(1)), texel: Texel::Uint }
            }
            LaneMap::Tile => Grid::Image { width: TILE, height: TILE, texel: Texel::Uint },
            LaneMap::Vertices => Grid::Points { count: lanes, texel: Texel::Uint },
        }
    }
}

/// Returns the failure of a call that cannot be run, with the first of its errors.
pub(super) fn refused(first: Option<&Diagnostic>) -> Failure {
    let reason = first.map_or("no reason given", |first| first.message.as_str());
    Failure::refused(format!("the call cannot be run: {reason}"), "")
}

/// Returns a buffer without contents.
fn buffer(name: &str, (group, binding): (u32, u32)) -> Resource {
    let kind = ResourceKind::Storage { bytes: Vec::new(), writable: true };
    Resource { name: name.to_string(), group, binding, kind }
}
