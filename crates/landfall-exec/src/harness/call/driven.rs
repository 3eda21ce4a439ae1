//! A function called by a driver over thousands of lanes a job: words in by one storage buffer,
//! words out by another.
//!
//! Takes a [`Pure`]; `module` builds an entry point around its caller for whoever runs modules,
//! `text` adds a `main` to the user's GLSL for OpenGL. Readers keep what they compiled, so that
//! one [`Driven`] compiles once. Feeds `landfall_light::accuracy::stress` and
//! [`call`](super::call()).

mod builder;
mod module;
mod pieces;
mod text;
mod words;

use crate::backend::BackendKind;
use std::time::Duration;

use naga::{AddressSpace, Statement};

use super::effects::look;
use super::pure::{Asks, Pure};
use crate::backend::{
    Device, Failure, Grid, Job, Reader, Resource, ResourceKind, StageCode, Texel,
};
use crate::interp::Words;
use landfall_ir::reach;
use landfall_layout::Diagnostic;
use words::Places;

/// A function in the form a reader takes.
#[derive(Clone, Debug)]
pub struct Driven<'p> {
    pure: &'p Pure,
    places: Places,
    code: Code,
}

/// What runs, and what is bound besides the two buffers.
#[derive(Clone, Debug)]
struct Code {
    stages: Vec<StageCode>,
    resources: Vec<Resource>,
    /// The buffers of the words that go in and of those that come out; their bytes are not there
    /// yet.
    buffers: [Resource; 2],
    lanes: Lanes,
}

/// How lanes are laid over invocations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lanes {
    /// Workgroups of so many invocations in a row.
    Groups(u32),
    /// Pixels, [`ROW`] in a row.
    Pixels,
    /// [`TILE`] by as many pixels that are one lane, for derivatives.
    Tile,
    /// Vertices.
    Vertices,
}

/// Pixels of a row.
const ROW: u32 = 256;

/// Pixels of a side where neighbours are differed: in a tile of so many that is drawn in part,
/// llvmpipe (Mesa 22.3.6) takes what a neighbour reads of a storage buffer for zeros.
const TILE: u32 = 64;

/// Bytes of a buffer of one job at most: every driver with storage buffers takes as many
/// (OpenGL 4.3 table 23.64: 2^24), and a job of as many shows progress.
const MOST_BYTES: usize = 1 << 23;

/// Lanes of a job at most: what an image of [`ROW`] pixels a row has rows for on any driver, and
/// a row of vertices pixels.
const MOST_LANES: usize = 1 << 16;
const MOST_VERTICES: usize = 1 << 12;

/// What a driver gave.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DrivenCalled {
    /// By result of [`Pure::results`]: its words, by scalar and lane, as [`Pure::call`] gives
    /// them. Zeros in a lane that was discarded.
    pub results: Vec<Words>,
    /// Lanes that met a `discard`.
    pub discarded: Vec<bool>,
}

impl Pure {
    /// The function in the form that reader takes. Modules or text are made here, once; the
    /// driver compiles them at the first call.
    ///
    /// # Errors
    /// Why it cannot be run there, such as WGSL by OpenGL.
    pub fn on(&self, device: &Device) -> Result<Driven<'_>, Failure> {
        let places = Places::of(self);
        let places = places.ok_or_else(|| Failure::refused("too large a call", ""))?;
        let code = match device.reader {
            BackendKind::Gl => text::code(self, &places)?,
            _ => module::code(self, &places)?,
        };
        Ok(Driven { pure: self, places, code })
    }
}

impl Driven<'_> {
    /// Calls the function over lanes, as many a job as its buffers allow; `limit` is of one job.
    /// The columns are those of [`Pure::call`].
    ///
    /// # Errors
    /// What the reader says against the function or the job; after
    /// [`Died`](crate::backend::FailureKind::Died) and
    /// [`TimedOut`](crate::backend::FailureKind::TimedOut) it may be of no more use.
    pub fn call(
        &self,
        reader: &mut dyn Reader,
        columns: &[Vec<u64>],
        lanes: usize,
        limit: Duration,
    ) -> Result<DrivenCalled, Failure> {
        let scalars: usize = self.pure.parameters.iter().map(|p| p.scalars.len()).sum();
        if columns.len() != scalars || columns.iter().any(|column| column.len() != lanes) {
            let message = format!("a call wants {scalars} columns of {lanes} words");
            return Err(Failure::refused(message, ""));
        }
        let results = self.pure.results.iter().map(|r| vec![Vec::new(); r.ty.scalars().len()]);
        let mut called = DrivenCalled { results: results.collect(), discarded: Vec::new() };
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
            // Less than a row of pixels is no whole row.
            let padded = match self.code.lanes {
                Lanes::Pixels if count < unit => count,
                Lanes::Pixels | Lanes::Tile | Lanes::Groups(_) | Lanes::Vertices => {
                    count.next_multiple_of(unit)
                }
            };
            let bytes = words::packed(self.pure, &self.places, columns, from..from + count, padded);
            job.resources[0].kind = ResourceKind::Storage { bytes, writable: false };
            let bytes = vec![0; padded * self.places.words_out as usize * 4];
            job.resources[1].kind = ResourceKind::Storage { bytes, writable: true };
            job.grid = self.code.lanes.grid(padded as u32);
            let mut answer = reader.run(&job)?;
            let bytes = answer.buffers.get_mut(1).and_then(Option::take);
            let bytes = bytes.ok_or_else(|| Failure::died("the results did not come back", ""))?;
            words::unpacked(
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

    /// Lanes of one job at most: what its buffers hold, in whole groups or rows.
    fn lanes_a_job(&self) -> usize {
        let words = self.places.words_in.max(self.places.words_out) as usize;
        let most = match self.code.lanes {
            Lanes::Groups(_) | Lanes::Pixels => MOST_LANES,
            Lanes::Vertices => MOST_VERTICES,
            Lanes::Tile => 1,
        };
        let unit = self.code.lanes.unit();
        let fitting = (MOST_BYTES / (words * 4)).min(most);
        match self.code.lanes {
            // Less than a row is a row of its own.
            Lanes::Pixels if fitting < unit => fitting.max(1),
            Lanes::Pixels | Lanes::Tile | Lanes::Groups(_) | Lanes::Vertices => {
                (fitting / unit * unit).max(unit)
            }
        }
    }
}

impl Lanes {
    /// How lanes are laid over the pixels of a fragment stage.
    fn pixels(pure: &Pure) -> Result<Lanes, Failure> {
        let ir = &pure.module.ir;
        let caller = ir.functions.iter().last().expect("the caller was appended").1;
        let seen = look(ir, caller);
        if pure.asks == Asks::Pure || !seen.derivatives {
            return Ok(Lanes::Pixels);
        }
        let stored = seen.stored.iter().map(|at| ir.global_variables[*at].space);
        let buffer = |space| matches!(space, AddressSpace::Storage { .. } | AddressSpace::Handle);
        let image = |s: &Statement| {
            matches!(s, Statement::ImageStore { .. } | Statement::ImageAtomic { .. })
        };
        let functions = reach::functions(ir, caller);
        if stored.into_iter().any(buffer)
            || functions.iter().any(|function| reach::statements(&function.body).any(image))
        {
            let message = format!(
                "`{}` takes derivatives, which want several pixels, and each would write \
                 the buffer or image it writes; name the function that takes them",
                pure.shown
            );
            return Err(Failure::refused(message, ""));
        }
        Ok(Lanes::Tile)
    }

    /// Lanes come in multiples of so many.
    fn unit(self) -> usize {
        match self {
            Lanes::Groups(size) => size.max(1) as usize,
            Lanes::Pixels => ROW as usize,
            Lanes::Vertices | Lanes::Tile => 1,
        }
    }

    fn grid(self, lanes: u32) -> Grid {
        match self {
            Lanes::Groups(size) => Grid::Groups([lanes / size.max(1), 1, 1]),
            Lanes::Pixels => {
                let width = ROW.min(lanes);
                Grid::Image { width, height: lanes.div_ceil(width.max(1)), texel: Texel::Uint }
            }
            Lanes::Tile => Grid::Image { width: TILE, height: TILE, texel: Texel::Uint },
            Lanes::Vertices => Grid::Points { count: lanes, texel: Texel::Uint },
        }
    }
}

/// Why a call cannot be run, by the first of what was found.
pub(super) fn refused(first: Option<&Diagnostic>) -> Failure {
    let reason = first.map_or("no reason given", |first| first.message.as_str());
    Failure::refused(format!("the call cannot be run: {reason}"), "")
}

/// A buffer without its bytes.
fn buffer(name: &str, (group, binding): (u32, u32)) -> Resource {
    let kind = ResourceKind::Storage { bytes: Vec::new(), writable: true };
    Resource { name: name.to_string(), group, binding, kind }
}
