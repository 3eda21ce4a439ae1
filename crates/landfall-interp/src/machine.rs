//! Runs a program over 64 invocations at a time in one precision.
//!
//! Reads a [`Program`]; used by [`call`](super::call) and [`stage`](super::stage). A mask holds the
//! lanes that a branch applies to. Values are computed for all lanes, active or not, except where
//! that is expensive; only stores look at the mask.

mod cast;
mod control;
mod expensive;
mod float;
mod integer;
mod interpret;
mod kernel;
mod memory;
mod sanitizer;
mod trace;
mod unset;
mod wide;

use std::borrow::Cow;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use pulp::Arch;

use super::code::{Class, LANES, Origin, Reg};
use super::counts::Tally;
use super::lanes::Lanes;
use super::program::Program;
use super::real::Real;
use control::ControlFrame;
pub(super) use float::frexp;
pub(super) use integer::binary;
pub(super) use memory::elements;
pub(super) use sanitizer::{Occurrences, Sanitizer};
pub(super) use trace::Tracer;

/// Lanes that begin where a line of the processor's cache does: no load crosses two lines.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Aligned<L>(L);

impl<L> Deref for Aligned<L> {
    type Target = L;

    fn deref(&self) -> &L {
        &self.0
    }
}

impl<L> DerefMut for Aligned<L> {
    fn deref_mut(&mut self) -> &mut L {
        &mut self.0
    }
}

/// A buffer during a run.
pub(super) struct BufferMemory<'j> {
    pub bytes: Cow<'j, [u8]>,
    /// The bytes that were read, as bits; empty unless they are recorded.
    pub read: Vec<u64>,
}

/// An image during a run.
#[derive(Clone, Copy)]
pub(super) struct Image<'j> {
    pub width: u32,
    pub height: u32,
    pub texels: &'j [[f32; 4]],
}

/// The reason why a run stopped before its end.
#[derive(Clone, Debug)]
pub(super) enum Stopped {
    /// A loop exceeded the budget of iterations.
    Budget(Origin),
    /// The invocations made too many calls.
    Calls(Origin),
    /// The deadline passed, or the caller aborted the run.
    Deadline(Origin),
    /// The deadline passed between two batches.
    Late,
    /// A barrier that some invocations do not reach, or in a workgroup larger than a batch.
    Barrier(Origin),
}

pub(super) struct Machine<'p, 'j, R: Real> {
    pub program: &'p Program,
    /// The registers of the processor.
    arch: Arch,
    reals: Vec<Aligned<R::Lanes>>,
    words: Vec<Aligned<[u32; LANES]>>,
    wides: Vec<Aligned<[u64; LANES]>>,
    pub buffers: Vec<BufferMemory<'j>>,
    pub images: Vec<Image<'j>>,
    /// By image: its last samples.
    samples: Vec<Option<Box<memory::SampledColours<R::Lanes>>>>,
    /// By instruction: whether a batch has computed its results, which are those of all batches.
    done: Vec<bool>,
    /// The lanes that were started.
    started: u64,
    active: u64,
    /// The number of active lanes.
    count: u64,
    /// The lanes that were discarded.
    pub killed: u64,
    /// The lanes in which a comparison, or an integer converted from a float, may differ elsewhere.
    pub unsure: u64,
    frames: Vec<ControlFrame>,
    /// Loop iterations of each lane, and those of the batch, which no lane exceeds.
    steps: [u32; LANES],
    batch_steps: u32,
    /// Calls of the batch.
    batch_calls: u64,
    /// Instructions, as an estimate, until the deadline is checked again.
    until_check: u32,
    /// Maximum loop iterations of one invocation.
    pub budget: u32,
    pub deadline: Option<Instant>,
    pub stop: Option<Arc<AtomicBool>>,
    /// Whether a batch holds all invocations of a workgroup.
    pub barriers: bool,
    pub tally: Tally,
    pub watch: Option<Box<Sanitizer>>,
}

impl<'p, 'j, R: Real> Machine<'p, 'j, R> {
    pub fn new(program: &'p Program) -> Machine<'p, 'j, R> {
        let [reals, words, wides] = program.registers;
        let [real, word, wide] = &program.constants;
        let number = |bits: u64| R::narrow(f32::from_bits(bits as u32));
        Machine {
            program,
            arch: Arch::new(),
            reals: columns(reals, real, number),
            words: columns(words, word, |bits| bits as u32),
            wides: columns(wides, wide, |bits| bits),
            buffers: Vec::new(),
            images: Vec::new(),
            samples: program.images.iter().map(|_| None).collect(),
            done: vec![false; program.code.len()],
            started: 0,
            active: 0,
            count: 0,
            killed: 0,
            unsure: 0,
            frames: Vec::with_capacity(64),
            steps: [0; LANES],
            batch_steps: 0,
            batch_calls: 0,
            until_check: CHECKED_EVERY,
            budget: u32::MAX,
            deadline: None,
            stop: None,
            barriers: false,
            tally: Tally::new(program.functions.len()),
            watch: None,
        }
    }

    /// Runs a function over the lanes of a mask, with freshly initialised private variables.
    pub fn invoke(&mut self, function: u32, start: u32, lanes: u64) -> Result<(), Stopped> {
        (self.started, self.killed, self.unsure) = (lanes, 0, 0);
        self.steps = [0; LANES];
        self.batch_steps = 0;
        self.batch_calls = 0;
        if let Ok(code) = &self.program.start {
            if let Ok(globals) = code.state {
                self.go(globals, lanes)?;
            }
        }
        // No instruction calls the first function.
        self.tally.calls[function as usize] += u64::from(lanes.count_ones());
        self.go(start, lanes)
    }

    fn go(&mut self, pc: u32, lanes: u64) -> Result<(), Stopped> {
        self.frames.clear();
        self.set(lanes);
        self.interpret(pc as usize)
    }

    /// Checks an instruction about to run, for the notes.
    #[inline(never)]
    fn before(&mut self, pc: usize) {
        let (op, [head, operands]) = (self.program.code[pc].op, self.program.operands(pc));
        self.inspect(pc, op, head, operands);
        self.inspect_unset(pc, op, operands);
    }

    /// Checks what an instruction has computed, for the notes.
    #[inline(never)]
    fn after(&mut self, pc: usize) {
        let (op, [head, operands]) = (self.program.code[pc].op, self.program.operands(pc));
        self.check_results(pc, op, operands);
        self.trace(pc, op, head, operands);
        self.follow_unset(op, head, operands);
    }

    /// Sets the active lanes.
    #[inline]
    fn set(&mut self, lanes: u64) {
        self.active = lanes;
        self.count = u64::from(lanes.count_ones());
    }

    /// Returns the column of a packed register of a class.
    pub fn reals_of(&mut self, reg: Reg) -> &mut R::Lanes {
        debug_assert_eq!(reg.class(), Class::Real);
        &mut self.reals[reg.number() as usize]
    }

    pub fn words_of(&mut self, reg: Reg) -> &mut [u32; LANES] {
        &mut self.words[reg.number() as usize]
    }

    pub fn wides_of(&mut self, reg: Reg) -> &mut [u64; LANES] {
        &mut self.wides[reg.number() as usize]
    }
}

/// Instructions between two checks of the deadline.
const CHECKED_EVERY: u32 = 1 << 13;

/// Calls of 64 invocations for each loop iteration that one invocation may run.
// Functions that each call the next one twice make 2^n calls without a loop.
const CALLS_PER_STEP: u64 = 1 << 10;

/// Returns the column of a register.
#[inline(always)]
fn column<L>(file: &[Aligned<L>], reg: u32) -> &L {
    &file[reg as usize]
}

/// Returns the column of a register that is not read meanwhile.
#[inline(always)]
fn column_mut<L>(file: &mut [Aligned<L>], reg: u32) -> &mut L {
    &mut file[reg as usize]
}

/// Returns the column of a register, to be written while others are read: no instruction reads what
/// it writes.
#[inline(always)]
fn apart<L>(file: &mut [Aligned<L>], reg: u32) -> (&mut L, Others<'_, L>) {
    let (below, rest) = file.split_at_mut(reg as usize);
    let (column, above) = rest.split_first_mut().expect("the register is in the file");
    (column, Others { below, above })
}

/// The columns beside one.
#[derive(Clone, Copy)]
struct Others<'f, L> {
    below: &'f [Aligned<L>],
    above: &'f [Aligned<L>],
}

impl<'f, L> Others<'f, L> {
    #[inline(always)]
    fn column(self, reg: u32) -> &'f L {
        let reg = reg as usize;
        match reg < self.below.len() {
            true => &self.below[reg],
            false => &self.above[reg - self.below.len() - 1],
        }
    }
}

fn columns<L: Lanes<Item: Default>>(
    count: u32,
    constants: &[u64],
    value: impl Fn(u64) -> L::Item,
) -> Vec<Aligned<L>> {
    (0..count as usize)
        .map(|i| {
            // The first registers are those of constants; the others begin with zeros.
            let value = constants.get(i).map_or(L::Item::default(), |&bits| value(bits));
            Aligned(L::filled(value))
        })
        .collect()
}
