//! Settings and notes of a run, and the execution of an entry point with given inputs.
//!
//! [`drive`](super::drive) runs the batches; [`call`](super::call) and [`cpu`](super::cpu) share
//! the settings and notes.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::code::{Cast, Class, Inst, LANES, Op, Reg};
use super::counts::Counts;
use super::interface::Port;
use super::lanes::Lanes;
use super::machine::Machine;
use super::numbers::{Numbers, Words};
use super::permitted::Permitted;
use super::program::Program;
use super::real::Real;
use super::shadow::Shadow;
use super::trace::Trace;
use super::undefined::{Divergence, Undefined};
use crate::backend::{Failure, FailureKind, Resource};

/// The precision in which a shader's `f32` are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// `f32`, rounded at each operation.
    #[default]
    Single,
    /// `f64`.
    Double,
    /// Both side by side; branches follow the `f32`.
    Both,
    /// `f32`, and around it the values that any conformant device may give for the expressions as
    /// written: [`Numbers::permitted`]. Branches follow the `f32`; invocations whose branches may
    /// differ elsewhere are in `unsure`. `f16` is unsupported; buffers store the `f32` alone.
    Permitted,
}

/// The settings of a run.
#[derive(Clone, Debug)]
pub struct Settings {
    pub precision: Precision,
    /// Whether to note undefined operations and the bytes that are read: several times slower.
    pub watch: bool,
    /// With [`Precision::Both`] and `watch`: the relative difference of `f32` from `f64` above
    /// which the operation is noted.
    pub tolerance: Option<f64>,
    /// With `watch`: whether to record each operation of the first invocation.
    pub trace: bool,
    /// Maximum loop iterations of one invocation; for each of them, 64 invocations together may
    /// make 1024 calls.
    pub budget: u32,
    /// The time at which the run is aborted.
    pub deadline: Option<Instant>,
    /// Set by the caller to abort the run at once.
    pub stop: Option<Arc<AtomicBool>>,
    /// The number of threads; 0 for the available parallelism.
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
            stop: None,
            threads: 0,
        }
    }
}

/// The notes of a run.
#[derive(Clone, Debug, Default)]
pub struct Notes {
    pub counts: Counts,
    /// Operations without a defined value, in code order, if watched.
    pub undefined: Vec<Undefined>,
    /// The first divergence of each invocation, if watched.
    pub divergences: Vec<Divergence>,
    /// The operations of the first invocation, if requested.
    pub trace: Option<Box<Trace>>,
    /// By resource: whether each byte was read, if watched. Empty for textures.
    pub read: Vec<Vec<bool>>,
}

/// Invocations of an entry point with their inputs.
#[derive(Clone, Debug, Default)]
pub struct Invocations {
    pub count: usize,
    /// The words of each input, by scalar and invocation; missing inputs are zero.
    pub inputs: Vec<(Port, Words)>,
}

/// The outputs of an entry point's invocations.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    pub ports: Vec<(Port, Numbers)>,
    /// Whether each invocation executed `discard`.
    pub discarded: Vec<bool>,
    /// With [`Precision::Permitted`]: the invocations in which a comparison, or an integer
    /// converted from a float, may differ on another device.
    pub unsure: Vec<bool>,
    /// By resource: the contents of a buffer that the entry point writes.
    pub buffers: Vec<Option<Vec<u8>>>,
    pub notes: Notes,
}

impl Program {
    /// Runs an entry point over invocations with given inputs. Derivatives are taken in quads of
    /// four consecutive invocations: left, right, and the same one row below.
    ///
    /// # Errors
    /// Fails if there is no such entry point, it uses unsupported features, or it does not end.
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
                // The last batch may have fewer.
                let lanes = LANES.min(count - from);
                for plug in &interface.inputs {
                    let given = invocations.inputs.iter().find(|(port, _)| *port == plug.port);
                    for (i, &reg) in plug.regs.iter().enumerate() {
                        let words = given.and_then(|(_, words)| words.get(i));
                        set_register(
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
        // Compilation stopped before the interface was known.
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
    failure(FailureKind::Refused, format!("the interpreter does not support {why}"))
}

/// Returns each lane's bit of a mask.
pub(super) fn bits(of: u64, lanes: usize) -> Vec<bool> {
    (0..lanes).map(|lane| of >> lane & 1 == 1).collect()
}

/// Returns the mask of the lowest lanes.
pub(super) fn mask(lanes: usize) -> u64 {
    // A shift by all bits would overflow.
    if lanes >= LANES { u64::MAX } else { (1 << lanes) - 1 }
}

/// Sets a register to words; lanes without a word get the first lane's, or zero.
pub(super) fn set_register<R: Real>(m: &mut Machine<R>, reg: Reg, words: &[u64]) {
    // Lanes without an invocation do what the first does, and agree with it.
    let rest = words.first().copied().unwrap_or(0);
    let word = |lane: usize| words.get(lane).copied().unwrap_or(rest);
    match reg.class() {
        Class::Real => {
            let to = m.reals_of(reg);
            to.set(|lane| R::narrow(f32::from_bits(word(lane) as u32)));
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
    /// Fails if the error bound of an instruction is unknown.
    pub(super) fn knows_permitted(&self) -> Result<(), Failure> {
        let half = |inst: &Inst| inst.op == Op::Cast(Cast::RoundHalf);
        if self.code.iter().any(half) {
            return Err(refused_for("error bounds of `f16`"));
        }
        Ok(())
    }
}
