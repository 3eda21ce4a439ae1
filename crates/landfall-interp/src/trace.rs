//! Every operation of one invocation, as a graph of values in `f32` and in `f64`.
//!
//! Made by the machine for [`Program::call`] if [`Settings::trace`](super::Settings) is set;
//! `stress` finds the cause of an error with it.

use rustc_hash::FxHashSet;

use super::code::{Cmp, Origin, Test};
use super::program::Program;
use super::undefined::{SourceLocation, UndefinedKind};

/// The operations of one invocation, in execution order.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// The operations, without copies, branches and stores.
    pub steps: Vec<TracedOperation>,
    /// The source of each scalar of the result.
    pub results: Vec<Source>,
    /// The source of each scalar left in each parameter.
    pub returned: Vec<Vec<Source>>,
    /// Whether steps were dropped beyond the maximum.
    pub cut: bool,
}

/// One operation.
#[derive(Clone, Debug)]
pub struct TracedOperation {
    pub operation: Operation,
    /// The operands; for a dot product all of one vector, then all of the other.
    pub operands: Vec<Operand>,
    pub results: Vec<Number>,
    /// Why it has no defined value at these operands.
    pub undefined: Option<UndefinedKind>,
    pub(super) origin: Origin,
}

#[derive(Clone, Copy, Debug)]
pub struct Operand {
    pub number: Number,
    pub source: Source,
}

/// A number in both precisions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Number {
    /// The shader's `f32`.
    pub single: f32,
    /// The reference.
    pub double: f64,
}

/// The source of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    Constant,
    /// A scalar of a parameter.
    Input {
        parameter: u32,
        scalar: u32,
    },
    /// A load from a buffer: its number in the program, and the byte.
    Buffer {
        buffer: u32,
        byte: u32,
    },
    /// Result `part` of a step.
    Step {
        step: u32,
        part: u32,
    },
    /// A source that is not followed.
    Unknown,
}

/// A comparison of two floats, or a test of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Comparison {
    Numbers(Cmp),
    Test(Test),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    Add,
    Sub,
    Mul,
    Div,
    Rem,
    Neg,
    Abs,
    Min,
    Max,
    Edge,
    Clamp,
    Mix,
    SmoothStep,
    Fma,
    Root,
    InverseRoot,
    Pow,
    Exp,
    Log,
    Trigonometric,
    Dot,
    Length,
    Distance,
    Normalize,
    Cross,
    Compare(Comparison),
    Convert,
    Integer,
    /// An index into an array: the index and the array's length.
    Index,
    Texture,
    /// A function by its name.
    Function(&'static str),
    Other,
}

/// The end of the way back from a number that is not finite.
#[derive(Clone, Copy, Debug)]
pub enum NonFinite<'t> {
    /// An operation with finite operands.
    Operation(&'t TracedOperation),
    /// A number that was read so, or that is not followed.
    Read(Operand),
}

/// A step back from a result of an operation to one of its operands.
struct Way<'t> {
    step: &'t TracedOperation,
    part: usize,
    operand: &'t Operand,
}

impl Way<'_> {
    /// Whether the operand may have led to the result: where a product is zero by a factor that is
    /// zero, other factors have not.
    fn decides(&self) -> bool {
        let is_zero = |number: &Number| number.single == 0.0;
        let is_product = self.step.operation == Operation::Mul
            && self.step.results.get(self.part).is_some_and(is_zero);
        let has_zero = self.step.operands.iter().any(|operand| is_zero(&operand.number));
        !(is_product && has_zero) || is_zero(&self.operand.number)
    }
}

impl Number {
    /// Whether it is finite in both precisions.
    pub fn is_finite(self) -> bool {
        self.single.is_finite() && self.double.is_finite()
    }
}

impl TracedOperation {
    /// Returns the operand that a NaN or an infinity came in by, NaN before infinity.
    pub fn non_finite_operand(&self) -> Option<&Operand> {
        let odd = self.operands.iter().filter(|operand| !operand.number.is_finite());
        odd.max_by_key(|operand| operand.number.single.is_nan())
    }

    /// Returns why an operation with finite operands has no defined value, or no finite one.
    pub fn fault(&self) -> Option<UndefinedKind> {
        // The reference follows the branches of the `f32`, which alone decide what is defined.
        let finite = |n: &Number| n.single.is_finite();
        let are_finite = self.operands.iter().all(|o| finite(&o.number));
        match self.undefined {
            // A NaN that goes on is a finding where it arises; one that is hidden is on other devices
            // not.
            Some(kind @ UndefinedKind::NanCompared) => {
                self.results.iter().all(finite).then_some(kind)
            }
            Some(kind) => are_finite.then_some(kind),
            None if !are_finite => None,
            None => self.results.iter().find(|n| !finite(n)).map(|odd| match odd.single.is_nan() {
                true => UndefinedKind::BornNan,
                false => UndefinedKind::BornInfinite,
            }),
        }
    }

    /// Returns the operands that leave the result undefined: of a division, the divisor.
    fn decisive(&self) -> &[Operand] {
        self.undefined.map_or(&self.operands, |kind| kind.deciding(&self.operands))
    }
}

impl Trace {
    /// Returns the operation that a number is a result of, and which of its results it is.
    pub fn step(&self, source: Source) -> Option<(&TracedOperation, usize)> {
        match source {
            Source::Step { step, part } => {
                self.steps.get(step as usize).map(|found| (found, part as usize))
            }
            Source::Constant | Source::Input { .. } | Source::Buffer { .. } | Source::Unknown => {
                None
            }
        }
    }

    /// Returns the inputs and loads that some operands were computed from.
    pub fn origins(&self, operands: &[Operand]) -> Vec<Operand> {
        self.behind(operands, |_| true)
    }

    /// Returns the inputs and loads behind some operands, by the ways that are followed.
    fn behind(&self, operands: &[Operand], is_followed: fn(&Way<'_>) -> bool) -> Vec<Operand> {
        // The last is taken first.
        let mut open: Vec<Operand> = operands.iter().rev().copied().collect();
        let mut seen = FxHashSet::default();
        let mut found = Vec::new();
        while let Some(operand) = open.pop() {
            if !seen.insert(operand.source) {
                continue;
            }
            match (self.step(operand.source), operand.source) {
                (Some((step, part)), _) => {
                    let ways = step.operands.iter().rev();
                    let ways = ways.map(|operand| Way { step, part, operand });
                    open.extend(ways.filter(is_followed).map(|way| *way.operand));
                }
                (None, Source::Input { .. } | Source::Buffer { .. }) => found.push(operand),
                (None, _) => {}
            }
        }
        found
    }

    /// Goes back from a number that is not finite to where it became so.
    pub fn non_finite(&self, mut number: Operand) -> NonFinite<'_> {
        loop {
            let Some((step, _)) = self.step(number.source) else { return NonFinite::Read(number) };
            match step.non_finite_operand() {
                Some(operand) => number = *operand,
                None => return NonFinite::Operation(step),
            }
        }
    }

    /// Returns the inputs and loads whose values led to an operation's result: of an operand that is
    /// not finite, those that led to it.
    pub fn led_to(&self, step: &TracedOperation) -> Vec<Operand> {
        let Some(operand) = step.non_finite_operand() else {
            return self.behind(step.decisive(), |way| way.decides());
        };
        match self.non_finite(*operand) {
            NonFinite::Operation(first) => self.behind(first.decisive(), |way| way.decides()),
            NonFinite::Read(read) => self.origins(&[read]),
        }
    }
}

impl Program {
    /// Returns the place of an operation in one of the program's traces.
    pub fn place_of(&self, step: &TracedOperation) -> SourceLocation {
        self.place(step.origin)
    }
}
