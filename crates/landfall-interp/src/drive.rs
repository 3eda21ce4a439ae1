//! Runs any number of invocations: binds resources, splits batches over threads, collects notes.
//!
//! Drives the [`machine`](super::machine); used by [`stage`](super::stage), [`call`](super::call)
//! and [`cpu`](super::cpu).

use std::borrow::Cow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use super::code::LANES;
use super::counts::Tally;
use super::machine::{BufferMemory, Image, Machine, Occurrences, Sanitizer, Stopped, Tracer};
use super::program::{BufferSpace, Program};
use super::real::Real;
use super::stage::{Notes, Precision, Settings, failure, refused_for};
use super::undefined::{Divergence, Undefined};
use crate::backend::{Failure, FailureKind, Resource, ResourceKind};
use landfall_ir::threads::{beside, in_order, number};

/// The batches that a thread takes at a time.
const CLAIM: usize = 4;

/// The batches that each thread is started for, at least: starting one takes as long as some of them.
const STARTED_FOR: usize = 16;

/// Resources as the program's buffers and images.
pub(super) struct BoundResources<'j> {
    buffers: Vec<(&'j [u8], Option<usize>)>,
    images: Vec<Image<'j>>,
    resources: usize,
    writes: bool,
}

impl<'j> BoundResources<'j> {
    /// Returns the contents of the buffers and the images.
    pub(super) fn contents(&self) -> (Vec<&'j [u8]>, Vec<Image<'j>>) {
        (self.buffers.iter().map(|(bytes, _)| *bytes).collect(), self.images.clone())
    }
}

/// Work that one thread does before its first batch; `None` once it has begun.
pub(super) type Other<'a> = Mutex<Option<&'a mut (dyn FnMut() + Send)>>;

/// Does it, if it has not begun.
pub(super) fn run_other(other: &Other) {
    let other = other.lock().ok().and_then(|mut other| other.take());
    if let Some(other) = other {
        other();
    }
}

/// The results of a thread by batch and its machine, or the failure of a batch.
type Done<'p, 'j, R, T> = Result<(Vec<(usize, T)>, Machine<'p, 'j, R>), (usize, Stopped)>;

/// The combined results of all batches.
pub(super) struct Outcome<T> {
    pub results: Vec<T>,
    /// By resource: the contents of a writable buffer after the run.
    pub left: Vec<Option<Vec<u8>>>,
    pub notes: Notes,
}

impl Program {
    /// Finds the resources that a function uses.
    pub(super) fn bind<'j>(
        &self,
        function: u32,
        resources: &'j [Resource],
    ) -> Result<BoundResources<'j>, Failure> {
        let state = self.functions[function as usize].state.as_ref();
        state.map_err(|why| refused_for(why))?;
        let globals = self.start.as_ref();
        globals.map_err(|why| refused_for(why))?;
        let uses = self.uses(function);
        let missing = |name: &str, (group, binding): (u32, u32)| {
            let at = format!("`{name}` at group {group}, binding {binding}");
            failure(FailureKind::Refused, format!("nothing is bound to {at}"))
        };
        let mut writes = false;
        let mut buffers = Vec::new();
        // In the order of the program's buffers; what the function does not use may be unbound.
        for (info, used) in self.buffers.iter().zip(&uses.buffers) {
            let fits = |kind: &ResourceKind| match (kind, info.space) {
                (ResourceKind::Uniform(_), BufferSpace::Uniform)
                | (ResourceKind::PushConstant(_), BufferSpace::PushConstant)
                | (ResourceKind::Storage { .. }, BufferSpace::Storage { .. }) => true,
                (
                    ResourceKind::Texture { .. } | ResourceKind::Sampler | ResourceKind::Loose(_),
                    _,
                )
                | (ResourceKind::Uniform(_), _)
                | (ResourceKind::PushConstant(_), _)
                | (ResourceKind::Storage { .. }, _) => false,
            };
            // There is one range of push constants, and it has no binding.
            let push = info.space == BufferSpace::PushConstant;
            let found = resources
                .iter()
                .position(|r| fits(&r.kind) && (push || (r.group, r.binding) == info.bound));
            writes |= *used && matches!(info.space, BufferSpace::Storage { writable: true });
            match found.map(|i| &resources[i].kind) {
                Some(
                    ResourceKind::Uniform(bytes)
                    | ResourceKind::PushConstant(bytes)
                    | ResourceKind::Storage { bytes, .. },
                ) => buffers.push((bytes.as_slice(), found)),
                // Each machine has memory of its own for workgroups.
                _ if *used && info.space != BufferSpace::Workgroup => {
                    return Err(missing(&info.name, info.bound));
                }
                _ => buffers.push((&[][..], None)),
            }
        }
        let mut images = Vec::new();
        for info in &self.images {
            let found = resources.iter().find_map(|r| match &r.kind {
                ResourceKind::Texture { width, height, texels }
                    if (r.group, r.binding) == info.bound =>
                {
                    Some(Image { width: *width, height: *height, texels })
                }
                _ => None,
            });
            match found {
                Some(image) => images.push(image),
                None if uses.images => return Err(missing(&info.name, info.bound)),
                None => images.push(Image { width: 0, height: 0, texels: &[] }),
            }
        }
        Ok(BoundResources { buffers, images, resources: resources.len(), writes })
    }

    /// Runs batches on all threads, or on one thread if they write shared memory.
    pub(super) fn drive<R: Real, T: Send>(
        &self,
        bound: &BoundResources,
        batches: usize,
        settings: &Settings,
        each: impl Fn(&mut Machine<R>, usize) -> Result<T, Stopped> + Sync,
    ) -> Result<Outcome<T>, Failure> {
        self.drive_with(bound, batches, settings, &Other::default(), each)
    }

    /// The same; the second thread, or the only one, first does `other`: a thread of its own would
    /// compete with one of these for a processor.
    pub(super) fn drive_with<R: Real, T: Send>(
        &self,
        bound: &BoundResources,
        batches: usize,
        settings: &Settings,
        other: &Other,
        each: impl Fn(&mut Machine<R>, usize) -> Result<T, Stopped> + Sync,
    ) -> Result<Outcome<T>, Failure> {
        // Each machine writes a copy of its own, which no other thread would see.
        let useful = if bound.writes { 1 } else { batches.div_ceil(STARTED_FOR).max(1) };
        let threads = match settings.threads {
            // The system takes longer to say than a batch takes.
            _ if useful == 1 => 1,
            given => number(given).min(useful),
        };
        let share = batches.div_ceil(threads);
        let next = AtomicUsize::new(0);
        let work = |thread: usize| {
            if thread == 1 || threads == 1 {
                run_other(other);
            }
            let mut machine = self.machine::<R>(bound, settings);
            // With a watch, each thread runs one contiguous share, so that notes are in the order of
            // lanes. Without one, threads claim batches until none is left: one may be slower.
            let mut whole = settings.watch.then_some(thread * share..(thread + 1) * share);
            let claim = || match settings.watch {
                true => whole.take(),
                false => {
                    let first = next.fetch_add(CLAIM, Ordering::Relaxed);
                    (first < batches).then_some(first..first + CLAIM)
                }
            };
            let mut results = Vec::with_capacity(share);
            for batch in std::iter::from_fn(claim).flatten().take_while(|batch| *batch < batches) {
                if let Some(watch) = &mut machine.watch {
                    watch.next_batch(batch * LANES);
                }
                if settings.deadline.is_some_and(|deadline| Instant::now() > deadline) {
                    return Err((batch, Stopped::Late));
                }
                let diverged = machine.watch.as_ref().map_or(0, |w| w.diverged.len());
                let result = each(&mut machine, batch).map_err(|stopped| (batch, stopped))?;
                results.push((batch, result));
                // From lanes of the batch to lanes of the run.
                if let Some(watch) = &mut machine.watch {
                    watch.diverged[diverged..].iter_mut().for_each(|p| p.lane += batch * LANES);
                }
            }
            Ok((results, machine))
        };
        let (own, others) = beside(|| work(0), 1..threads, work);
        let done = std::iter::once(own).chain(others).collect();
        self.outcome(bound, batches, done)
    }

    /// Combines what the threads did.
    fn outcome<R: Real, T>(
        &self,
        bound: &BoundResources,
        batches: usize,
        done: Vec<Done<'_, '_, R, T>>,
    ) -> Result<Outcome<T>, Failure> {
        // Of several failures, that of the first batch.
        let failures = done.iter().filter_map(|done| done.as_ref().err());
        if let Some((_, stopped)) = failures.min_by_key(|(batch, _)| *batch) {
            return Err(self.stopped(stopped.clone()));
        }
        let (results, machines): (Vec<_>, Vec<_>) = done.into_iter().flatten().unzip();
        let results = in_order(batches, results.into_iter().flatten());
        let (left, notes) = self.left(bound, machines);
        Ok(Outcome { results, left, notes })
    }

    /// Returns the contents of writable buffers after the run, by resource, and what was noted.
    fn left<R: Real>(
        &self,
        bound: &BoundResources,
        machines: Vec<Machine<'_, '_, R>>,
    ) -> (Vec<Option<Vec<u8>>>, Notes) {
        let mut left = vec![None; bound.resources];
        let mut tally = Tally::new(self.functions.len());
        let mut watch = Sanitizer::default();
        let mut read = vec![Vec::new(); bound.resources];
        for machine in machines {
            tally.add(&machine.tally);
            for (i, memory) in machine.buffers.into_iter().enumerate() {
                let Some(resource) = bound.buffers[i].1 else { continue };
                if !memory.read.is_empty() {
                    let all: &mut Vec<bool> = &mut read[resource];
                    all.resize(memory.bytes.len(), false);
                    // A byte was read if some thread read it.
                    for (byte, read) in all.iter_mut().enumerate() {
                        *read |= memory.read[byte / 64] >> (byte % 64) & 1 == 1;
                    }
                }
                // Where a buffer is written, there is one thread only.
                if self.buffers[i].space == (BufferSpace::Storage { writable: true }) {
                    left[resource] = Some(memory.bytes.into_owned());
                }
            }
            if let Some(more) = machine.watch {
                watch.merge(*more);
            }
        }
        let names = self.functions.iter().map(|f| f.name.clone());
        let mut notes = Notes { counts: tally.counts(names), read, ..Notes::default() };
        self.note(watch, &mut notes);
        (left, notes)
    }

    fn machine<'p, 'j, R: Real>(
        &'p self,
        bound: &BoundResources<'j>,
        settings: &Settings,
    ) -> Machine<'p, 'j, R> {
        let mut machine = Machine::new(self);
        for (info, (bytes, _)) in self.buffers.iter().zip(&bound.buffers) {
            // One bit for each byte.
            let read = if settings.watch { vec![0; bytes.len().div_ceil(64)] } else { Vec::new() };
            let bytes = match info.space {
                BufferSpace::Workgroup => Cow::Owned(vec![0; info.size as usize]),
                BufferSpace::Uniform | BufferSpace::PushConstant | BufferSpace::Storage { .. } => {
                    Cow::Borrowed(*bytes)
                }
            };
            machine.buffers.push(BufferMemory { bytes, read });
        }
        machine.images = bound.images.clone();
        machine.budget = settings.budget;
        machine.deadline = settings.deadline;
        machine.stop = settings.stop.clone();
        if settings.watch {
            // Only two precisions side by side can diverge.
            let tolerance = settings.tolerance.filter(|_| settings.precision == Precision::Both);
            let tracer = settings.trace.then(Box::<Tracer>::default);
            machine.watch = Some(Box::new(Sanitizer { tolerance, tracer, ..Sanitizer::default() }));
        }
        machine
    }

    fn note(&self, watch: Sanitizer, notes: &mut Notes) {
        // In the order of the code; a map has none.
        let mut seen: Vec<_> = watch.undefined.into_iter().collect();
        seen.sort_by_key(|((pc, kind), _)| (*pc, *kind));
        for ((pc, kind), seen) in seen {
            let place = self.place(self.origins[pc]);
            let same = |u: &&mut Undefined| u.kind == kind && u.place == place;
            // The components of one expression are several instructions.
            match notes.undefined.iter_mut().find(same) {
                Some(known) => {
                    known.count += seen.count;
                    let new = seen.lanes.into_iter().filter(|lane| !known.lanes.contains(lane));
                    let new: Vec<usize> = new.collect();
                    known.lanes.extend(new);
                }
                None => {
                    let Occurrences { count, operands, lanes } = seen;
                    notes.undefined.push(Undefined { kind, place, count, operands, lanes });
                }
            }
        }
        notes.trace = watch.tracer.map(|tracer| Box::new(tracer.trace));
        notes.divergences = watch
            .diverged
            .into_iter()
            .map(|p| Divergence {
                lane: p.lane,
                place: self.place(self.origins[p.pc]),
                single: p.single,
                double: p.double,
                operands: p.operands,
            })
            .collect();
    }

    fn stopped(&self, stopped: Stopped) -> Failure {
        let (kind, what, origin) = match stopped {
            Stopped::Budget(origin) => {
                (FailureKind::TimedOut, "a loop ran for more iterations than its limit", origin)
            }
            Stopped::Calls(origin) => (
                FailureKind::Refused,
                "one invocation makes more function calls than the interpreter's limit",
                origin,
            ),
            Stopped::Deadline(origin) => {
                (FailureKind::TimedOut, "the code was still running at the time limit", origin)
            }
            Stopped::Late => {
                let message = "the time limit was reached before all invocations had run".into();
                return failure(FailureKind::TimedOut, message);
            }
            Stopped::Barrier(origin) => (
                FailureKind::Refused,
                "the interpreter supports barriers only in workgroups of at most 64 \
                 invocations that all reach them together",
                origin,
            ),
        };
        let place = self.place(origin);
        let at = if place.shown.is_empty() { String::new() } else { format!(", {}", place.shown) };
        failure(kind, format!("{what}: in `{}`{at}", place.function))
    }
}
