//! How to run, what a run notes, and an entry point run over given inputs.
//!
//! [`drive`](super::drive) runs the batches; [`call`](super::call) and
//! [`reader`](super::reader) use the same settings and notes.

use std::time::Instant;

use super::call::{Numbers, Words};
use super::code::{Cast, Class, Inst, LANES, Op, Reg};
use super::counts::Counts;
use super::interface::Port;
use super::machine::Machine;
use super::permitted::Permitted;
use super::program::Program;
use super::real::{Real, Shadow};
use super::trace::Trace;
use super::undefined::{Divergence, Undefined};
use crate::backend::{Failure, FailureKind, Resource};

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
    /// `f32`, and around it all that any conformant device may give for what is written:
    /// [`Numbers::permitted`]. Branches follow the `f32`; where they are not sure to elsewhere
    /// is in `unsure`. Not known: `f16`; what is stored in buffers is the `f32` alone.
    Permitted,
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
    /// With `watch`: whether to note each operation of the first invocation.
    pub trace: bool,
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
            trace: false,
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
    /// The operations of the first invocation; if asked for.
    pub trace: Option<Box<Trace>>,
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
    /// With [`Precision::Permitted`]: in which invocations a comparison, or an integer made of
    /// a float, may be another on another device.
    pub unsure: Vec<bool>,
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
            Precision::Permitted => {
                self.knows_permitted()?;
                self.entry_in::<Permitted>(entry, invocations, resources, settings)
            }
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
                let discarded = bits(m.killed, lanes);
                let unsure = if R::PERMITTED { bits(m.unsure, lanes) } else { Vec::new() };
                Ok(Outputs { ports, discarded, unsure, ..Outputs::default() })
            })?;
        let mut outputs =
            Outputs { notes: outcome.notes, buffers: outcome.left, ..Outputs::default() };
        for batch in outcome.results {
            outputs.discarded.extend(batch.discarded);
            outputs.unsure.extend(batch.unsure);
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

/// Each lane's bit.
pub(super) fn bits(of: u64, lanes: usize) -> Vec<bool> {
    (0..lanes).map(|lane| of >> lane & 1 == 1).collect()
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

impl Program {
    /// Whether the accuracy of every instruction is known.
    pub(super) fn knows_permitted(&self) -> Result<(), Failure> {
        let half = |inst: &Inst| inst.op == Op::Cast(Cast::RoundHalf);
        if self.code.iter().any(half) {
            return Err(refused_for("what is permitted of `f16`"));
        }
        Ok(())
    }
}
