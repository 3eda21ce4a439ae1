//! Notes of a watched run: operations whose value no specification defines, and the points where
//! `f32` and `f64` diverge.
//!
//! Operands are checked before an instruction and results after it; the instructions themselves are
//! unaffected.

use landfall_layout::source::Language;
use rustc_hash::FxHashMap;

use super::super::code::{Access, Cast, Class, D2, F1, F2, F3, I2, Op, Stored};
use super::super::lanes::Lanes;
use super::super::real::Real;
use super::super::undefined::UndefinedKind;
use super::memory::elements;
use super::trace::Tracer;
use super::unset::Unset;
use super::{Machine, column};

/// The occurrences noted at one instruction.
#[derive(Clone, Debug)]
pub(in crate::interp) struct Occurrences {
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
pub(in crate::interp) struct Diverged {
    pub pc: usize,
    pub lane: usize,
    pub single: f32,
    pub double: f64,
    pub operands: Vec<(f32, f64)>,
}

/// The notes of a run.
#[derive(Clone, Debug, Default)]
pub(in crate::interp) struct Sanitizer {
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
    pub(in crate::interp) unset: Unset,
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
        let Some(mut watch) = self.watch.take() else { return };
        let shape = op.shape();
        let mut rest = self.active;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            match op {
                Op::Load(access) | Op::Save(access) | Op::Atomic(access) => {
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
            Op::F1(f) => !matches!(f, F1::Neg | F1::Abs | F1::Sign | F1::Floor | F1::Fract),
            Op::F2(F2::Add | F2::Sub) | Op::F3(F3::Fma | F3::Mix) => false,
            Op::F2(F2::Mul) => operands.chunks_exact(3).any(|group| {
                group[1..].iter().any(|reg| {
                    let any = |any: bool, x: R| any | x.followed().is_infinite();
                    column(&self.reals, *reg).each().fold(false, any)
                })
            }),
            Op::Dot(_) | Op::Cross | Op::Distance(_) | Op::FCmp(_) | Op::Select(_) => false,
            Op::Move(_) | Op::Blank(_) | Op::Store(_) | Op::CmpSint(_) | Op::CmpUint(_) => false,
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
        use UndefinedKind as U;
        let real = |i: usize| column(&self.reals, reads[i]).lane(lane).followed();
        let word = |i: usize| column(&self.words, reads[i])[lane];
        let wide = |i: usize| column(&self.wides, reads[i])[lane];
        match op {
            Op::F1(f) => {
                if let Some(kind) = undefined1(f, real(0)) {
                    watch.see((pc, lane), kind, || vec![real(0)]);
                }
            }
            Op::D1(f) => {
                let x = f64::from_bits(wide(0));
                if let Some(kind) = undefined1(f, x) {
                    watch.see((pc, lane), kind, || vec![x]);
                }
            }
            Op::F2(f) => {
                if let Some(kind) = undefined2(f, real(0), real(1)) {
                    watch.see((pc, lane), kind, || vec![real(0), real(1)]);
                }
            }
            Op::D2(D2::Float(f)) => {
                let [a, b] = [0, 1].map(|i| f64::from_bits(wide(i)));
                if let Some(kind) = undefined2(f, a, b) {
                    watch.see((pc, lane), kind, || vec![a, b]);
                }
            }
            Op::F3(f) => {
                let operands = [real(0), real(1), real(2)];
                if let Some(kind) = undefined3(f, operands) {
                    watch.see((pc, lane), kind, || operands.to_vec());
                }
            }
            Op::Normalize(n) => {
                let all = || (0..usize::from(n)).map(real).collect::<Vec<f64>>();
                if (0..usize::from(n)).all(|i| real(i) == 0.0) {
                    watch.see((pc, lane), U::NormalizeOfZero, all);
                } else if let Some(kind) = self.length_out_of_range(reads, lane) {
                    watch.see((pc, lane), kind, all);
                }
            }
            Op::Length(n) if n > 1 => {
                if let Some(kind) = self.length_out_of_range(reads, lane) {
                    watch.see((pc, lane), kind, || (0..usize::from(n)).map(real).collect());
                }
            }
            // GLSL 4.60 §5.9 leaves it undefined; WGSL §8.7 defines it.
            Op::I2(I2::RemSint)
                if self.program.language == Language::Glsl
                    && word(1) != 0
                    && (word(0) as i32).min(word(1) as i32) < 0 =>
            {
                let number = |i: usize| f64::from(word(i) as i32);
                watch.see((pc, lane), U::RemainderOfNegative, || vec![number(0), number(1)]);
            }
            Op::I2(f) => {
                let (a, b) = (word(0), word(1));
                if let Some(kind) = undefined_int(f, u64::from(a), u64::from(b), 32) {
                    let signed = matches!(f, I2::DivSint | I2::RemSint | I2::ShrSint);
                    let number = move |x: u32| {
                        if signed { f64::from(x as i32) } else { f64::from(x) }
                    };
                    watch.see((pc, lane), kind, || vec![number(a), number(b)]);
                }
            }
            Op::D2(D2::Int(f)) => {
                let (a, b) = (wide(0), wide(1));
                if let Some(kind) = undefined_int(f, a, b, 64) {
                    watch.see((pc, lane), kind, || vec![a as f64, b as f64]);
                }
            }
            Op::ExtractSint | Op::ExtractUint | Op::Insert => {
                let [offset, count] = [reads.len() - 2, reads.len() - 1].map(word);
                if u64::from(offset) + u64::from(count) > 32 {
                    let both = vec![f64::from(offset), f64::from(count)];
                    watch.see((pc, lane), U::BitsOutOfRange, || both);
                }
            }
            Op::Cast(Cast::HalfToBits) => {
                // From half a unit above the largest `f16` on, the nearest one is infinity.
                let x = real(0);
                if x.is_nan() || x.abs() >= 65520.0 {
                    watch.see((pc, lane), U::ConversionOutOfRange, || vec![x]);
                }
            }
            Op::Cast(cast) => {
                let Some((from, low, high)) = whole_range(cast) else { return };
                let x = match from {
                    Class::Wide => f64::from_bits(wide(0)),
                    Class::Real | Class::Word => real(0),
                };
                if !(x.trunc() >= low && x.trunc() <= high) {
                    watch.see((pc, lane), U::ConversionOutOfRange, || vec![x]);
                }
            }
            _ => {}
        }
    }

    /// Returns the fault in a vector's length, if any: the sum of its squares, which devices
    /// compute, is above the largest number of the run's precision, or below the smallest normal
    /// one, where it loses digits or is flushed to zero.
    fn length_out_of_range(&self, reads: &[u32], lane: usize) -> Option<UndefinedKind> {
        let each = || reads.iter().map(|reg| column(&self.reals, *reg).lane(lane));
        let any = each().any(|x| x.double() != 0.0);
        let finite = each().all(|x| x.double().is_finite() && !x.is_infinite());
        if !any || !finite {
            return None;
        }
        let sum = each().fold(R::narrow(0.0), |sum, x| sum.add(x.mul(x)));
        // A double has room for the square of every `f32`.
        let smallest = f64::from(f32::MIN_POSITIVE);
        let tiny = R::narrow(f32::MIN_POSITIVE);
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
            match Stored::ALL[group[2] as usize] {
                Stored::F32 | Stored::F16 => {}
                Stored::B32 | Stored::I16 | Stored::U16 | Stored::Bool | Stored::B64 => continue,
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

/// Returns the undefined behaviour of an integer operation of the given width.
fn undefined_int(f: I2, a: u64, b: u64, bits: u32) -> Option<UndefinedKind> {
    let (lowest, ones) = (1 << (bits - 1), u64::MAX >> (64 - bits));
    match f {
        I2::DivSint | I2::DivUint | I2::RemSint | I2::RemUint if b == 0 => {
            Some(UndefinedKind::IntegerDivisionByZero)
        }
        I2::DivSint | I2::RemSint if a == lowest && b == ones => {
            Some(UndefinedKind::IntegerOverflow)
        }
        I2::Shl | I2::ShrSint | I2::ShrUint if b >= u64::from(bits) => {
            Some(UndefinedKind::ShiftTooFar)
        }
        _ => None,
    }
}

/// Returns the class that a conversion to integers reads, and the least and largest result.
fn whole_range(cast: Cast) -> Option<(Class, f64, f64)> {
    let sint = (f64::from(i32::MIN), f64::from(i32::MAX));
    let uint = (0.0, f64::from(u32::MAX));
    let sint64 = (i64::MIN as f64, i64::MAX as f64);
    let uint64 = (0.0, u64::MAX as f64);
    let (class, (low, high)) = match cast {
        Cast::RealToSint => (Class::Real, sint),
        Cast::RealToUint => (Class::Real, uint),
        Cast::RealToSint64 => (Class::Real, sint64),
        Cast::RealToUint64 => (Class::Real, uint64),
        Cast::DoubleToSint => (Class::Wide, sint),
        Cast::DoubleToUint => (Class::Wide, uint),
        Cast::DoubleToSint64 => (Class::Wide, sint64),
        Cast::DoubleToUint64 => (Class::Wide, uint64),
        _ => return None,
    };
    Some((class, low, high))
}

fn undefined1(f: F1, x: f64) -> Option<UndefinedKind> {
    use UndefinedKind as U;
    match f {
        F1::Sqrt if x < 0.0 => Some(U::RootOfNegative),
        F1::InverseSqrt if x <= 0.0 => Some(U::RootOfNegative),
        F1::Log | F1::Log2 if x <= 0.0 => Some(U::LogOfNonPositive),
        F1::Asin | F1::Acos if x.abs() > 1.0 => Some(U::ArcOutOfRange),
        F1::Acosh if x < 1.0 => Some(U::ArcOutOfRange),
        F1::Atanh if x.abs() >= 1.0 => Some(U::ArcOutOfRange),
        F1::Saturate if x.is_nan() => Some(U::NanCompared),
        _ => None,
    }
}

fn undefined2(f: F2, a: f64, b: f64) -> Option<UndefinedKind> {
    use UndefinedKind as U;
    match f {
        F2::Div | F2::Rem if b == 0.0 => Some(U::DivisionByZero),
        F2::Mul if a == 0.0 && b.is_infinite() || a.is_infinite() && b == 0.0 => {
            Some(U::ZeroTimesInfinity)
        }
        F2::Pow if a < 0.0 => Some(U::PowOfNegative),
        F2::Pow if a == 0.0 && b <= 0.0 => Some(U::PowOfZero),
        F2::Atan2 if a == 0.0 && b == 0.0 => Some(U::AtanOfZeros),
        F2::Min | F2::Max | F2::Step if a.is_nan() || b.is_nan() => Some(U::NanCompared),
        _ => None,
    }
}

fn undefined3(f: F3, [a, b, c]: [f64; 3]) -> Option<UndefinedKind> {
    use UndefinedKind as U;
    match f {
        F3::SmoothStep if a >= b => Some(U::SmoothStepEdges),
        F3::Clamp if a.is_nan() || b.is_nan() || c.is_nan() => Some(U::NanCompared),
        F3::Clamp if b > c => Some(U::ClampBounds),
        F3::SmoothStep | F3::Clamp | F3::Fma | F3::Mix => None,
    }
}
