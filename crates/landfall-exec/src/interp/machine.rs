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

use super::code::{Class, LANES, Op, Origin, Reg};
use super::counts::Tally;
use super::lanes::Lanes;
use super::program::Program;
use super::real::Real;
use control::Frame;
pub(super) use float::frexp;
pub(super) use integer::binary;
pub(super) use sanitizer::{Occurrences, Sanitizer};
pub(super) use trace::Tracer;

/// A scalar of all lanes.
pub(super) type Column<L> = Box<Aligned<L>>;

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
pub(super) struct Memory<'j> {
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
    reals: Vec<Option<Column<R::Lanes>>>,
    words: Vec<Option<Column<[u32; LANES]>>>,
    wides: Vec<Option<Column<[u64; LANES]>>>,
    pub buffers: Vec<Memory<'j>>,
    pub images: Vec<Image<'j>>,
    /// By image: its last samples.
    samples: Vec<Option<Box<memory::Samples<R::Lanes>>>>,
    /// The lanes that were started.
    started: u64,
    /// The active lanes.
    active: u64,
    /// The number of active lanes.
    count: u64,
    /// The lanes that were discarded.
    pub killed: u64,
    /// The lanes in which a comparison, or an integer converted from a float, may differ elsewhere.
    pub unsure: u64,
    frames: Vec<Frame>,
    /// The active lanes as words of ones, valid for `mask_of`.
    mask: [u32; LANES],
    mask_of: u64,
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
            started: 0,
            active: 0,
            count: 0,
            killed: 0,
            unsure: 0,
            frames: Vec::with_capacity(64),
            mask: [0; LANES],
            mask_of: 0,
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
        self.tally.calls[function as usize] += u64::from(lanes.count_ones());
        self.go(start, lanes)
    }

    fn go(&mut self, pc: u32, lanes: u64) -> Result<(), Stopped> {
        self.frames.clear();
        self.set(lanes);
        match self.watch {
            None => self.run::<false>(pc as usize),
            Some(_) => self.run::<true>(pc as usize),
        }
    }

    fn run<const WATCH: bool>(&mut self, mut pc: usize) -> Result<(), Stopped> {
        let program = self.program;
        loop {
            let inst = program.code[pc];
            let cost = program.costs[pc];
            self.tally.kinds[cost.kind as usize] += u64::from(cost.weight) * self.count;
            let from = inst.at as usize;
            let pool = &program.pool[from..from + cost.operands as usize];
            let (head, operands) = pool.split_at(usize::from(inst.head));
            if WATCH {
                self.inspect(pc, inst.op, head, operands);
                self.inspect_unset(pc, inst.op, operands);
            }
            let this = pc;
            pc += 1;
            match inst.op {
                Op::F1(f) => self.f1(f, operands),
                Op::F2(f) => self.f2(f, operands),
                Op::F3(f) => self.f3(f, operands),
                Op::FCmp(cmp) => self.compare_reals(cmp, operands),
                Op::FTest(test) => self.test_reals(test, operands),
                Op::Ldexp => self.ldexp(operands),
                Op::Dot(n) => self.dot(usize::from(n), operands),
                Op::Length(n) => self.length(usize::from(n), operands),
                Op::Distance(n) => self.distance(usize::from(n), operands),
                Op::Normalize(n) => self.normalize(usize::from(n), operands),
                Op::Cross => self.cross(operands),
                Op::I1(f) => self.i1(f, operands),
                Op::I2(f) => self.i2(f, operands),
                Op::CmpSint(cmp) => self.compare_words(cmp, true, operands),
                Op::CmpUint(cmp) => self.compare_words(cmp, false, operands),
                Op::ExtractSint => self.extract(true, operands),
                Op::ExtractUint => self.extract(false, operands),
                Op::Insert => self.insert(operands),
                Op::D1(_)
                | Op::DNeg
                | Op::DNot
                | Op::D2(_)
                | Op::D3(_)
                | Op::DCmp(_)
                | Op::DCmpSint(_)
                | Op::DCmpUint(_)
                | Op::DTest(_)
                | Op::DAbsSint
                | Op::DSignSint
                | Op::DDot(_) => self.wide(inst.op, operands),
                Op::Cast(cast) => self.cast(cast, operands),
                Op::Select(class) => self.select(class, operands),
                Op::Move(class) | Op::Blank(class) => self.shift(class, operands),
                Op::Store(class) => self.store(class, operands),
                Op::Load(access) => self.load::<WATCH>(access, head, operands),
                Op::Save(access) => self.save(access, head, operands),
                Op::Gather(class, access) => self.gather(class, access, head, operands),
                Op::Scatter(class, access) => self.scatter(class, access, head, operands),
                Op::Atomic(access) => self.atomic::<WATCH>(access, head, operands),
                Op::ArrayLength(access) => self.array_length(access, operands),
                Op::Sample => self.sample(operands),
                Op::Sampled => {}
                Op::Texel => self.texel(operands),
                Op::ImageSize => self.image_size(operands),
                Op::DerivativeFine(axis) => self.derivative(axis, true, operands),
                Op::DerivativeCoarse(axis) => self.derivative(axis, false, operands),
                Op::End => match self.end() {
                    Some(back) => pc = back,
                    None => return Ok(()),
                },
                Op::Call(function) => {
                    self.tally.calls[function as usize] += self.count;
                    self.call_tick(this)?;
                    self.frames.push(Frame::call(self.active, pc));
                    pc = program.starts[function as usize] as usize;
                }
                Op::Inlined(function) => {
                    self.tally.calls[function as usize] += self.count;
                    self.call_tick(this)?;
                }
                Op::Again(target) => {
                    if self.active != 0 {
                        self.tick(this, target)?;
                        pc = target as usize;
                    }
                }
                Op::Barrier => {
                    if !self.barriers || !self.all_lanes_active() {
                        return Err(Stopped::Barrier(program.origins[this]));
                    }
                }
                other => {
                    if let Some(target) = self.branch(other, head) {
                        pc = target as usize;
                    }
                }
            }
            if WATCH {
                self.check_results(this, inst.op, operands);
                self.trace(this, inst.op, head, operands);
                self.follow_unset(inst.op, head, operands);
            }
        }
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
        self.reals[reg.number() as usize].as_mut().expect(HELD)
    }

    pub fn words_of(&mut self, reg: Reg) -> &mut [u32; LANES] {
        self.words[reg.number() as usize].as_mut().expect(HELD)
    }

    pub fn wides_of(&mut self, reg: Reg) -> &mut [u64; LANES] {
        self.wides[reg.number() as usize].as_mut().expect(HELD)
    }
}

/// Instructions between two checks of the deadline.
const CHECKED_EVERY: u32 = 1 << 13;

/// Calls of 64 invocations for each loop iteration that one invocation may run.
const CALLS_PER_STEP: u64 = 1 << 10;

/// The reason why a column exists: only the results of the current instruction are taken out of the
/// file, and an instruction never reads its own results.
const HELD: &str = "no instruction reads what it writes";

/// Returns the column of a register.
#[inline(always)]
fn column<L>(file: &[Option<Column<L>>], reg: u32) -> &L {
    file[reg as usize].as_ref().expect(HELD)
}

/// Returns the column of a register that is not read meanwhile.
#[inline(always)]
fn column_mut<L>(file: &mut [Option<Column<L>>], reg: u32) -> &mut L {
    file[reg as usize].as_mut().expect(HELD)
}

/// Takes a column out, to be written while others are read.
#[inline(always)]
fn take<L>(file: &mut [Option<Column<L>>], reg: u32) -> Column<L> {
    file[reg as usize].take().expect(HELD)
}

fn columns<L: Lanes<Item: Default>>(
    count: u32,
    constants: &[u64],
    value: impl Fn(u64) -> L::Item,
) -> Vec<Option<Column<L>>> {
    (0..count as usize)
        .map(|i| {
            let value = constants.get(i).map_or(L::Item::default(), |&bits| value(bits));
            Some(Box::new(Aligned(L::filled(value))))
        })
        .collect()
}
