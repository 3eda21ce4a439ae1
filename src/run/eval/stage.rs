//! Running over any number of invocations: batches, threads, resources, notes.
//!
//! Feeds the [`machine`](super::machine); used by [`call`](super::call) and
//! [`reader`](super::reader). Its public half runs an entry point over given inputs.

use std::borrow::Cow;
use std::time::Instant;

use super::call::{Numbers, Words};
use super::code::{Class, LANES, Reg};
use super::counts::{Counts, Tally};
use super::interface::Port;
use super::machine::{Image, Machine, Memory, Stopped, Watch};
use super::program::{BufferSpace, Program};
use super::real::{Real, Shadow};
use super::undefined::{Divergence, Undefined};
use crate::run::reader::{Failure, FailureKind, Resource, ResourceKind};

/// What a shader's `f32` is computed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// `f32`, rounded at each operation.
    #[default]
    Single,
    /// `f64`.
    Double,
    /// Both side by side; branches follow the `f32`.
    Both,
}

/// How to run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// What floats are computed in.
    pub precision: Precision,
    /// Whether to note undefined operations and the bytes that are read: several times slower.
    pub watch: bool,
    /// With [`Precision::Both`] and `watch`: how far `f32` may be from `f64`, relative to
    /// it, before the operation is named.
    pub tolerance: Option<f64>,
    /// Iterations of loops one invocation may take.
    pub budget: u32,
    /// When to give up.
    pub deadline: Option<Instant>,
    /// Threads to use; 0 for as many as there are.
    pub threads: usize,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            precision: Precision::Single,
            watch: false,
            tolerance: None,
            budget: 1 << 22,
            deadline: None,
            threads: 0,
        }
    }
}

/// What a run noted.
#[derive(Clone, Debug, Default)]
pub struct Notes {
    /// What it cost.
    pub counts: Counts,
    /// Operations without a defined value, in the order of the code; if watched.
    pub undefined: Vec<Undefined>,
    /// The first operation at which each invocation parted; if watched.
    pub divergences: Vec<Divergence>,
    /// By resource: which of its bytes were read; if watched. Empty for textures.
    pub read: Vec<Vec<bool>>,
}

/// Inputs of an entry point's invocations.
#[derive(Clone, Debug, Default)]
pub struct Invocations {
    /// How many.
    pub count: usize,
    /// Words of each input, by scalar and invocation; the others are zero.
    pub inputs: Vec<(Port, Words)>,
}

/// What an entry point's invocations gave.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// Each output.
    pub ports: Vec<(Port, Numbers)>,
    /// Which invocations were discarded.
    pub discarded: Vec<bool>,
    /// By resource: what is left in a buffer that the entry point writes.
    pub buffers: Vec<Option<Vec<u8>>>,
    /// Notes of the run.
    pub notes: Notes,
}

impl Program {
    /// Runs an entry point over invocations whose inputs are given. Quads of four in a
    /// row are what derivatives are taken in: left, right, and the same one row below.
    ///
    /// # Errors
    /// If there is no such entry point, it uses what is not supported, or does not end.
    pub fn run_entry(
        &self,
        entry: &str,
        invocations: &Invocations,
        resources: &[Resource],
        settings: &Settings,
    ) -> Result<Outputs, Failure> {
        match settings.precision {
            Precision::Single => self.entry_in::<f32>(entry, invocations, resources, settings),
            Precision::Double => self.entry_in::<f64>(entry, invocations, resources, settings),
            Precision::Both => self.entry_in::<Shadow>(entry, invocations, resources, settings),
        }
    }

    fn entry_in<R: Real>(
        &self,
        entry: &str,
        invocations: &Invocations,
        resources: &[Resource],
        settings: &Settings,
    ) -> Result<Outputs, Failure> {
        let number = self.entry(entry)?;
        let code = &self.functions[number as usize];
        let interface = code.interface.as_ref().expect("an entry point has an interface");
        let bound = self.bind(number, resources)?;
        let count = invocations.count;
        let outcome =
            self.drive::<R, Outputs>(&bound, count.div_ceil(LANES), settings, |m, b| {
                let from = b * LANES;
                let lanes = LANES.min(count - from);
                for plug in &interface.inputs {
                    let given = invocations.inputs.iter().find(|(port, _)| *port == plug.port);
                    for (i, &reg) in plug.regs.iter().enumerate() {
                        let words = given.and_then(|(_, words)| words.get(i));
                        put(
                            m,
                            reg,
                            words.map_or(&[], |w| w.get(from..from + lanes).unwrap_or(&[])),
                        );
                    }
                }
                m.invoke(number, self.starts[number as usize], mask(lanes))?;
                let ports: Vec<_> = interface
                    .outputs
                    .iter()
                    .map(|plug| (plug.port, Numbers::read(m, &plug.regs, lanes)))
                    .collect();
                let discarded = (0..lanes).map(|lane| m.killed >> lane & 1 == 1).collect();
                Ok(Outputs { ports, discarded, ..Outputs::default() })
            })?;
        let mut outputs =
            Outputs { notes: outcome.notes, buffers: outcome.left, ..Outputs::default() };
        for batch in outcome.results {
            outputs.discarded.extend(batch.discarded);
            if outputs.ports.is_empty() {
                outputs.ports = batch.ports;
                continue;
            }
            for ((_, all), (_, more)) in outputs.ports.iter_mut().zip(batch.ports) {
                all.append(more);
            }
        }
        Ok(outputs)
    }

    pub(super) fn entry(&self, name: &str) -> Result<u32, Failure> {
        let found = self.functions.iter().position(|f| f.name == name && f.interface.is_some());
        if let Some(found) = found {
            return Ok(found as u32);
        }
        // Compiling stopped before its interface was known.
        let refused = self.functions.iter().rev().find(|f| f.name == name && f.state.is_err());
        match refused.map(|f| &f.state) {
            Some(Err(why)) => Err(refused_for(why)),
            _ => Err(failure(FailureKind::Refused, format!("there is no entry point `{name}`"))),
        }
    }
}

pub(super) fn failure(kind: FailureKind, message: String) -> Failure {
    Failure { kind, message, log: String::new() }
}

pub(super) fn refused_for(why: &str) -> Failure {
    failure(FailureKind::Refused, format!("the evaluator does not know {why}"))
}

/// The lowest lanes.
pub(super) fn mask(lanes: usize) -> u64 {
    if lanes >= LANES { u64::MAX } else { (1 << lanes) - 1 }
}

/// Puts words into a register; lanes that have none get the first lane's, or zero.
pub(super) fn put<R: Real>(m: &mut Machine<R>, reg: Reg, words: &[u64]) {
    let rest = words.first().copied().unwrap_or(0);
    let word = |lane: usize| words.get(lane).copied().unwrap_or(rest);
    match reg.class() {
        Class::Real => {
            let to = m.reals_of(reg);
            (0..LANES).for_each(|i| to[i] = R::narrow(f32::from_bits(word(i) as u32)));
        }
        Class::Word => {
            let to = m.words_of(reg);
            (0..LANES).for_each(|i| to[i] = word(i) as u32);
        }
        Class::Wide => {
            let to = m.wides_of(reg);
            (0..LANES).for_each(|i| to[i] = word(i));
        }
    }
}

/// Resources as the program's buffers and images.
pub(super) struct Bound<'j> {
    buffers: Vec<(&'j [u8], Option<usize>)>,
    images: Vec<Image<'j>>,
    resources: usize,
    writes: bool,
}

/// What comes out of all batches.
pub(super) struct Outcome<T> {
    pub results: Vec<T>,
    /// By resource: what is left in a writable buffer.
    pub left: Vec<Option<Vec<u8>>>,
    pub notes: Notes,
}

impl Program {
    /// Finds the resources a function uses.
    pub(super) fn bind<'j>(
        &self,
        function: u32,
        resources: &'j [Resource],
    ) -> Result<Bound<'j>, Failure> {
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
        Ok(Bound { buffers, images, resources: resources.len(), writes })
    }

    /// Runs batches: on all threads, or on one where they write what others read.
    pub(super) fn drive<R: Real, T: Send>(
        &self,
        bound: &Bound,
        batches: usize,
        settings: &Settings,
        each: impl Fn(&mut Machine<R>, usize) -> Result<T, Stopped> + Sync,
    ) -> Result<Outcome<T>, Failure> {
        let wanted = match settings.threads {
            0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
            given => given,
        };
        let threads = if bound.writes { 1 } else { wanted.min(batches.div_ceil(4)).max(1) };
        let share = batches.div_ceil(threads);
        let work = |thread: usize| {
            let mut machine = self.machine::<R>(bound, settings);
            let range = (thread * share).min(batches)..((thread + 1) * share).min(batches);
            let mut results = Vec::with_capacity(range.len());
            for batch in range {
                if let Some(watch) = &mut machine.watch {
                    watch.next_batch();
                }
                if settings.deadline.is_some_and(|deadline| Instant::now() > deadline) {
                    return Err(Stopped::Late);
                }
                let parted = machine.watch.as_ref().map_or(0, |w| w.parted.len());
                results.push(each(&mut machine, batch)?);
                if let Some(watch) = &mut machine.watch {
                    watch.parted[parted..].iter_mut().for_each(|p| p.lane += batch * LANES);
                }
            }
            Ok((results, machine))
        };
        let done: Vec<Result<_, Stopped>> = if threads == 1 {
            vec![work(0)]
        } else {
            std::thread::scope(|scope| {
                let handles: Vec<_> = (0..threads).map(|t| scope.spawn(move || work(t))).collect();
                handles.into_iter().map(|h| h.join().expect("the machine does not panic")).collect()
            })
        };
        let mut outcome = Outcome {
            results: Vec::with_capacity(batches),
            left: vec![None; bound.resources],
            notes: Notes::default(),
        };
        let mut tally = Tally::new(self.functions.len());
        let mut watch = Watch::default();
        let mut read = vec![Vec::new(); bound.resources];
        for done in done {
            let (results, machine) = done.map_err(|stopped| self.stopped(stopped))?;
            outcome.results.extend(results);
            tally.add(&machine.tally);
            for (i, memory) in machine.buffers.into_iter().enumerate() {
                let Some(resource) = bound.buffers[i].1 else { continue };
                if !memory.read.is_empty() {
                    let all: &mut Vec<bool> = &mut read[resource];
                    all.resize(memory.bytes.len(), false);
                    for (byte, read) in all.iter_mut().enumerate() {
                        *read |= memory.read[byte / 64] >> (byte % 64) & 1 == 1;
                    }
                }
                if self.buffers[i].space == (BufferSpace::Storage { writable: true }) {
                    outcome.left[resource] = Some(memory.bytes.into_owned());
                }
            }
            if let Some(more) = machine.watch {
                watch.merge(*more);
            }
        }
        let names = self.functions.iter().map(|f| f.name.clone());
        outcome.notes.counts = tally.counts(names);
        outcome.notes.read = read;
        self.note(watch, &mut outcome.notes);
        Ok(outcome)
    }

    fn machine<'p, 'j, R: Real>(
        &'p self,
        bound: &Bound<'j>,
        settings: &Settings,
    ) -> Machine<'p, 'j, R> {
        let mut machine = Machine::new(self);
        for (info, (bytes, _)) in self.buffers.iter().zip(&bound.buffers) {
            let read = if settings.watch { vec![0; bytes.len().div_ceil(64)] } else { Vec::new() };
            let bytes = match info.space {
                BufferSpace::Workgroup => Cow::Owned(vec![0; info.size as usize]),
                BufferSpace::Uniform | BufferSpace::PushConstant | BufferSpace::Storage { .. } => {
                    Cow::Borrowed(*bytes)
                }
            };
            machine.buffers.push(Memory { bytes, read });
        }
        machine.images = bound.images.clone();
        machine.budget = settings.budget;
        machine.deadline = settings.deadline;
        if settings.watch {
            let tolerance = settings.tolerance.filter(|_| settings.precision == Precision::Both);
            machine.watch = Some(Box::new(Watch { tolerance, ..Watch::default() }));
        }
        machine
    }

    fn note(&self, watch: Watch, notes: &mut Notes) {
        let mut seen: Vec<_> = watch.undefined.into_iter().collect();
        seen.sort_by_key(|((pc, kind), _)| (*pc, *kind));
        for ((pc, kind), seen) in seen {
            let place = self.place(self.origins[pc]);
            let same = |u: &&mut Undefined| u.kind == kind && u.place == place;
            // The components of one expression are several instructions.
            match notes.undefined.iter_mut().find(same) {
                Some(known) => known.count += seen.count,
                None => {
                    let (count, operands) = (seen.count, seen.operands);
                    notes.undefined.push(Undefined { kind, place, count, operands });
                }
            }
        }
        notes.divergences = watch
            .parted
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
                (FailureKind::TimedOut, "a loop did not end within the budget of steps", origin)
            }
            Stopped::Deadline(origin) => {
                (FailureKind::TimedOut, "a loop was still running when the time was up", origin)
            }
            Stopped::Late => {
                let message = "the time was up before all invocations had run".into();
                return failure(FailureKind::TimedOut, message);
            }
            Stopped::Barrier(origin) => (
                FailureKind::Refused,
                "the evaluator knows barriers only where all of a workgroup of at most 64 meet",
                origin,
            ),
        };
        let place = self.place(origin);
        let at = if place.shown.is_empty() { String::new() } else { format!(", {}", place.shown) };
        failure(kind, format!("{what}: in `{}`{at}", place.function))
    }
}
