//! Notes of a watched run: operations whose value no specification defines, and the points where
//! `f32` and `f64` diverge.
//!
//! Operands are checked before an instruction and results after it; the instructions themselves are
//! unaffected.

use landfall_ir::analysis::undefined::condition::{conversion, direction};
use landfall_layout::source::Language;
use rustc_hash::FxHashMap;

use super::super::code::{
    Access, Cast, Class, Op, RealBinary, RealTernary, RealUnary, Stored, WideBinary,
};
use super::super::condition::{
    undefined_integer_at, undefined1_at, undefined2_at, undefined3_at, whole_range,
};
use super::super::lanes::{Lanes, lane_numbers};
use super::super::real::Real;
use super::super::undefined::UndefinedKind;
use super::memory::elements;
use super::trace::Tracer;
use super::unset::Unset;
use super::{Machine, column, integer};

/// The occurrences noted at one instruction.
#[derive(Clone, Debug)]
pub(crate) struct Occurrences {
    /// Number of occurrences over all invocations.
    pub count: u64,
    /// The operands of the first occurrence.
    pub operands: Vec<f64>,
    /// The first invocations in which it occurred.
    pub lanes: Vec<usize>,
}

/// Maximum number of invocations kept per note.
const LANES_KEPT: usize = 256;

/// The first operation after which `f32` and `f64` differ by more than the tolerance.
#[derive(Clone, Debug)]
pub(crate) struct Diverged {
    pub pc: usize,
    pub lane: usize,
    pub single: f32,
    pub double: f64,
    pub operands: Vec<(f32, f64)>,
}

/// The notes of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sanitizer {
    pub undefined: FxHashMap<(usize, UndefinedKind), Occurrences>,
    /// The relative tolerance between `f32` and `f64`, if both are computed.
    pub tolerance: Option<f64>,
    /// By lane: the first divergence.
    pub diverged: Vec<Diverged>,
    pub lanes_diverged: u64,
    /// The first invocation of the batch.
    pub base: usize,
    /// Records each operation of the first invocation.
    pub tracer: Option<Box<Tracer>>,
    /// Variables that were never written.
    pub(crate) unset: Unset,
}

impl Sanitizer {
    /// Starts a batch, whose lanes are other invocations.
    pub fn next_batch(&mut self, base: usize) {
        self.lanes_diverged = 0;
        self.base = base;
        self.unset.clear();
    }

    /// Adds the notes of another thread, whose batches come later.
    pub fn merge(&mut self, more: Sanitizer) {
        for (key, seen) in more.undefined {
            self.undefined
                .entry(key)
                .and_modify(|known| {
                    known.count += seen.count;
                    known.lanes.extend(&seen.lanes);
                    known.lanes.truncate(LANES_KEPT);
                })
                .or_insert(seen);
        }
        self.diverged.extend(more.diverged);
        self.tracer = self.tracer.take().or(more.tracer);
    }

    pub(super) fn see(
        &mut self,
        (pc, lane): (usize, usize),
        kind: UndefinedKind,
        operands: impl FnOnce() -> Vec<f64>,
    ) {
        let lane = self.base + lane;
        self.undefined
            .entry((pc, kind))
            .and_modify(|seen| {
                seen.count += 1;
                // One instruction may compute several undefined values in a lane.
                if seen.lanes.len() < LANES_KEPT && seen.lanes.last() != Some(&lane) {
                    seen.lanes.push(lane);
                }
            })
            .or_insert_with(|| Occurrences { count: 1, operands: operands(), lanes: vec![lane] });
    }
}

impl<R: Real> Machine<'_, '_, R> {
    /// Checks the operands of an instruction about to run.
    pub(super) fn inspect(&mut self, pc: usize, op: Op, head: &[u32], operands: &[u32]) {
        if !self.may_be_undefined(op, operands) {
            return;
        }
        // Taken out, as the checks borrow the machine.
        let Some(mut watch) = self.watch.take() else { return };
        let shape = op.shape();
        for lane in lane_numbers(self.active) {
            match op {
                Op::Load(access) | Op::StoreMemory(access) | Op::Atomic(access) => {
                    let access = &self.program.accesses[access as usize];
                    self.inspect_access(&mut watch, pc, access, head, lane);
                    let bytes = self.buffers[access.buffer as usize].bytes.len();
                    for group in operands.chunks_exact(shape.len()) {
                        let [offset, stored] = [group[shape.len() - 2], group[shape.len() - 1]];
                        let width = Stored::ALL[stored as usize].width();
                        let at = offset as usize + self.computed_offset(access, head, lane, 0);
                        if at + width > bytes {
                            let kind = UndefinedKind::PastEndOfBuffer;
                            watch.see((pc, lane), kind, || vec![at as f64, bytes as f64]);
                        }
                    }
                }
                Op::Gather(_, access) | Op::Scatter(_, access) => {
                    let access = &self.program.accesses[access as usize];
                    self.inspect_access(&mut watch, pc, access, head, lane);
                }
                _ if shape.len() > 0 => {
                    for group in operands.chunks_exact(shape.len()) {
                        let reads = &group[shape.writes..shape.writes + shape.reads];
                        self.inspect_group(&mut watch, pc, op, reads, lane);
                    }
                }
                _ => {}
            }
        }
        self.watch = Some(watch);
    }

    /// Returns whether operands of an instruction may be undefined, from its operation and, for
    /// products, a look at all lanes at once.
    fn may_be_undefined(&self, op: Op, operands: &[u32]) -> bool {
        match op {
            Op::RealUnary(f) => !matches!(
                f,
                RealUnary::Neg
                    | RealUnary::Abs
                    | RealUnary::Sign
                    | RealUnary::Floor
                    | RealUnary::Fract
            ),
            Op::RealBinary(RealBinary::Add | RealBinary::Sub)
            | Op::RealTernary(RealTernary::Fma | RealTernary::Mix) => false,
            // The product of finite numbers is defined, that of zero and infinity is not.
            Op::RealBinary(RealBinary::Mul) => operands.chunks_exact(3).any(|group| {
                group[1..].iter().any(|reg| {
                    let any = |any: bool, x: R| any | x.followed().is_infinite();
                    column(&self.reals, *reg).each().fold(false, any)
                })
            }),
            Op::Dot(_) | Op::Cross | Op::FCmp(_) | Op::Select(_) => false,
            Op::Move(_) | Op::Undefined(_) | Op::Store(_) | Op::CmpSint(_) | Op::CmpUint(_) => {
                false
            }
            _ => true,
        }
    }

    fn inspect_access(
        &self,
        watch: &mut Sanitizer,
        pc: usize,
        access: &Access,
        head: &[u32],
        lane: usize,
    ) {
        let bytes = self.buffers.get(access.buffer as usize).map_or(0, |b| b.bytes.len());
        for (reg, dynamic) in head.iter().zip(&access.dynamics) {
            let index = column(&self.words, *reg)[lane];
            let len = elements(dynamic.bound, bytes);
            if index >= len {
                let kind = UndefinedKind::IndexOutOfBounds;
                watch.see((pc, lane), kind, || vec![f64::from(index), f64::from(len)]);
            }
        }
    }

    fn inspect_group(&self, watch: &mut Sanitizer, pc: usize, op: Op, reads: &[u32], lane: usize) {
        if let Some((kind, operands)) = self.undefined_group(op, reads, lane) {
            watch.see((pc, lane), kind, || operands);
        }
    }

    /// Returns why an operation on registers has no defined value in a lane, with its operands.
    pub(super) fn undefined_group(
        &self,
        op: Op,
        reads: &[u32],
        lane: usize,
    ) -> Option<(UndefinedKind, Vec<f64>)> {
        use UndefinedKind as U;
        let real = |i: usize| column(&self.reals, reads[i]).lane(lane).followed();
        let word = |i: usize| column(&self.words, reads[i])[lane];
        let wide = |i: usize| column(&self.wides, reads[i])[lane];
        let double = |i: usize| f64::from_bits(wide(i));
        let reals = |n: u8| (0..usize::from(n)).map(real).collect::<Vec<f64>>();
        let components = |n: u8| -> Vec<R> {
            reads[..usize::from(n)].iter().map(|reg| column(&self.reals, *reg).lane(lane)).collect()
        };
        let has_negative_remainder = self.program.language == Language::Wgsl;
        let found = match op {
            Op::RealUnary(f) => (undefined1_at(f, real(0))?, reals(1)),
            Op::D1(f) => (undefined1_at(f, double(0))?, vec![double(0)]),
            Op::RealBinary(f) => (undefined2_at(f, real(0), real(1))?, reals(2)),
            Op::WideBinary(WideBinary::Float(f)) => {
                let [a, b] = [0, 1].map(double);
                (undefined2_at(f, a, b)?, vec![a, b])
            }
            Op::RealTernary(f) => (undefined3_at(f, [0, 1, 2].map(real))?, reals(3)),
            Op::Normalize(n) if reals(n).iter().all(|x| *x == 0.0) => {
                (direction(0.0.into())?, reals(n))
            }
            Op::Normalize(n) | Op::Length(n) if n > 1 => {
                (self.length_out_of_range(&components(n))?, reals(n))
            }
            Op::Distance(n) if n > 1 => {
                let of = components(2 * n);
                let (a, b) = of.split_at(usize::from(n));
                let apart: Vec<R> = a.iter().zip(b).map(|(a, b)| a.sub(*b)).collect();
                (self.length_out_of_range(&apart)?, reals(2 * n))
            }
            Op::WordBinary(f) => {
                let (a, b) = (word(0), word(1));
                let words = [u64::from(a), u64::from(b)];
                let kind = undefined_integer_at(f, words, 32, has_negative_remainder)?;
                (kind, [a, b].map(|x| integer::operand(op, x)).to_vec())
            }
            Op::WideBinary(WideBinary::Int(f)) => {
                let (a, b) = (wide(0), wide(1));
                let kind = undefined_integer_at(f, [a, b], 64, has_negative_remainder)?;
                (kind, vec![a as f64, b as f64])
            }
            Op::ExtractSint | Op::ExtractUint | Op::Insert => {
                let [offset, count] = [reads.len() - 2, reads.len() - 1].map(word);
                let both = vec![f64::from(offset), f64::from(count)];
                let is_past = u64::from(offset) + u64::from(count) > 32;
                (is_past.then_some(U::BitsOutOfRange)?, both)
            }
            // From half a unit above the largest `f16` on, the nearest one is infinity.
            Op::Cast(Cast::HalfToBits) => {
                let is_past = real(0).is_nan() || real(0).abs() >= 65520.0;
                (is_past.then_some(U::ConversionOutOfRange)?, reals(1))
            }
            Op::Cast(cast) => {
                let (from, low, high) = whole_range(cast)?;
                let x = if from == Class::Wide { double(0) } else { real(0) };
                (conversion(x.into(), low, high)?, vec![x])
            }
            _ => return None,
        };
        Some(found)
    }

    /// Returns the fault in a vector's length, if any: the sum of its squares, which devices
    /// compute, is above the largest number of the run's precision, or below the smallest normal
    /// one, where it loses digits or is flushed to zero.
    fn length_out_of_range(&self, components: &[R]) -> Option<UndefinedKind> {
        let any = components.iter().any(|x| x.double() != 0.0);
        let finite = components.iter().all(|x| x.double().is_finite() && !x.is_infinite());
        if !any || !finite {
            return None;
        }
        let sum = components.iter().fold(R::narrow(0.0), |sum, x| sum.add(x.mul(*x)));
        // A double has room for the square of every `f32`.
        let smallest = f64::from(f32::MIN_POSITIVE);
        let tiny = R::narrow(f32::MIN_POSITIVE);
        // In single precision alone the square of the smallest normal number is zero.
        let is_single = tiny.mul(tiny).whole() == 0.0;
        if sum.is_infinite() {
            Some(UndefinedKind::SquaresTooLarge)
        } else if is_single && sum.whole() < smallest {
            Some(UndefinedKind::SquaresTooSmall)
        } else {
            None
        }
    }

    /// Checks floats that were loaded.
    fn check_loaded(&mut self, pc: usize, operands: &[u32]) {
        let Some(mut watch) = self.watch.take() else { return };
        for group in operands.chunks_exact(3) {
            if Stored::ALL[group[2] as usize].class() != Class::Real {
                continue;
            }
            let loaded = column(&self.reals, group[0]);
            for (lane, x) in loaded.each().enumerate() {
                if self.active >> lane & 1 == 1 && x.single().is_nan() {
                    watch.see((pc, lane), UndefinedKind::NanFromBuffer, Vec::new);
                }
            }
        }
        self.watch = Some(watch);
    }

    /// Checks the results of an instruction: numbers that stopped being finite here, and `f32`
    /// values that are too far from their `f64`.
    pub(super) fn check_results(&mut self, pc: usize, op: Op, operands: &[u32]) {
        if let Op::Load(_) = op {
            self.check_loaded(pc, operands);
        }
        if !op.computes_reals() || self.watch.is_none() {
            return;
        }
        let Some(mut watch) = self.watch.take() else { return };
        let shape = op.shape();
        let takes = op.takes_reals();
        for group in operands.chunks_exact(shape.len()) {
            let reads = &group[shape.writes..shape.writes + shape.reads];
            let reads = if takes { reads } else { &[] };
            for &to in &group[..shape.writes] {
                let results = column(&self.reals, to);
                // All lanes at once, without a branch: most instructions are done here.
                if results.each().fold(true, |all, x| all & !is_noted(x, watch.tolerance)) {
                    continue;
                }
                for (lane, result) in results.each().enumerate() {
                    if self.active >> lane & 1 == 0 {
                        continue;
                    }
                    let operand = |reg: &u32| column(&self.reals, *reg).lane(lane);
                    let finite = |x: R| x.single().is_finite();
                    if !finite(result) && reads.iter().all(|reg| finite(operand(reg))) {
                        let kind = if result.single().is_nan() {
                            UndefinedKind::BornNan
                        } else {
                            UndefinedKind::BornInfinite
                        };
                        // The operands of the call that met it, of which `f64` is the reference.
                        let of = |reg: &u32| operand(reg).followed();
                        let all = || reads.iter().map(of).collect();
                        watch.see((pc, lane), kind, all);
                    }
                    // What diverges later follows from the first.
                    let Some(tolerance) = watch.tolerance else { continue };
                    if watch.lanes_diverged >> lane & 1 == 0 {
                        let (single, double) = (result.single(), result.double());
                        if diverges(single, double, tolerance) {
                            watch.lanes_diverged |= 1 << lane;
                            let operands = reads
                                .iter()
                                .map(|reg| (operand(reg).single(), operand(reg).double()))
                                .collect();
                            let diverged = Diverged { pc, lane, single, double, operands };
                            watch.diverged.push(diverged);
                        }
                    }
                }
            }
        }
        self.watch = Some(watch);
    }
}

/// Whether a result is noted where its operands are finite or its lane has not diverged before.
#[inline(always)]
fn is_noted<R: Real>(result: R, tolerance: Option<f64>) -> bool {
    let single = result.single();
    let diverged = tolerance.is_some_and(|most| diverges(single, result.double(), most));
    !single.is_finite() | diverged
}

#[inline(always)]
fn diverges(single: f32, double: f64, tolerance: f64) -> bool {
    let off = (f64::from(single) - double).abs();
    (off > tolerance * double.abs()) | (single.is_nan() != double.is_nan())
}
