//! Operations whose value no specification defines, and their places.

use std::fmt;

use super::code::Origin;
use super::program::Program;
use landfall_layout::source::Span;

/// The kinds of operations without a defined value, or with a surprising one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)]
pub enum UndefinedKind {
    DivisionByZero,
    ZeroTimesInfinity,
    RootOfNegative,
    LogOfNonPositive,
    PowOfNegative,
    PowOfZero,
    ArcOutOfRange,
    AtanOfZeros,
    NormalizeOfZero,
    SmoothStepEdges,
    ClampBounds,
    IntegerDivisionByZero,
    IntegerOverflow,
    RemainderOfNegative,
    ShiftTooFar,
    BitsOutOfRange,
    ConversionOutOfRange,
    IndexOutOfBounds,
    PastEndOfBuffer,
    Uninitialised,
    NanFromBuffer,
    NanCompared,
    SquaresTooLarge,
    SquaresTooSmall,
    BornNan,
    BornInfinite,
}

impl UndefinedKind {
    /// Returns a short description.
    pub fn text(self) -> &'static str {
        match self {
            UndefinedKind::DivisionByZero => "division by zero",
            UndefinedKind::ZeroTimesInfinity => "zero times infinity",
            UndefinedKind::RootOfNegative => "root of a negative number",
            UndefinedKind::LogOfNonPositive => "logarithm of zero or less",
            UndefinedKind::PowOfNegative => "power of a negative number",
            UndefinedKind::PowOfZero => "zero to the power of zero or less",
            UndefinedKind::ArcOutOfRange => "inverse of a trigonometric function out of range",
            UndefinedKind::AtanOfZeros => "angle of the point (0, 0)",
            UndefinedKind::NormalizeOfZero => "normalised zero vector",
            UndefinedKind::SmoothStepEdges => "smoothstep with its first edge not below its second",
            UndefinedKind::ClampBounds => "clamp with its lower bound above its upper one",
            UndefinedKind::IntegerDivisionByZero => "integer division by zero",
            UndefinedKind::RemainderOfNegative => "remainder of a negative integer",
            UndefinedKind::IntegerOverflow => "integer division that overflows",
            UndefinedKind::ShiftTooFar => "shift by the width or more",
            UndefinedKind::BitsOutOfRange => "bit field past the end of the word",
            UndefinedKind::ConversionOutOfRange => "conversion of a number out of range",
            UndefinedKind::IndexOutOfBounds => "index out of bounds",
            UndefinedKind::PastEndOfBuffer => "access past the end of the buffer",
            UndefinedKind::Uninitialised => "variable read before it is written",
            UndefinedKind::NanFromBuffer => "the buffer holds NaN",
            UndefinedKind::NanCompared => "NaN into min, max, clamp or step",
            UndefinedKind::SquaresTooLarge => "length of a vector whose squares overflow",
            UndefinedKind::SquaresTooSmall => "length of a vector whose squares underflow",
            UndefinedKind::BornNan => "NaN from finite operands",
            UndefinedKind::BornInfinite => "infinity from finite operands",
        }
    }
}

impl fmt::Display for UndefinedKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// A place in a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceLocation {
    /// The function or entry point that contains it.
    pub function: String,
    /// The byte range in the module's files.
    pub span: Span,
    /// `file:line:column`; empty if the module has no text.
    pub shown: String,
}

/// An operation without a defined value.
#[derive(Clone, Debug, PartialEq)]
pub struct Undefined {
    /// The kind.
    pub kind: UndefinedKind,
    /// The place.
    pub place: SourceLocation,
    /// The number of occurrences over all invocations.
    pub count: u64,
    /// The operands of the first occurrence.
    pub operands: Vec<f64>,
    /// The first few invocations in which it occurred.
    pub lanes: Vec<usize>,
}

/// The first divergence of `f32` and `f64` in one invocation.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// The invocation.
    pub lane: usize,
    /// The operation.
    pub place: SourceLocation,
    /// The result in `f32`.
    pub single: f32,
    /// The result in `f64`.
    pub double: f64,
    /// The operands in both.
    pub operands: Vec<(f32, f64)>,
}

impl Program {
    /// Returns the place of an instruction.
    pub(super) fn place(&self, origin: Origin) -> SourceLocation {
        let function = self.functions.get(origin.function as usize);
        let function = function.map_or_else(String::new, |f| f.name.clone());
        let file = self.bases.iter().rposition(|&base| base <= origin.start).unwrap_or(0);
        let base = self.bases.get(file).copied().unwrap_or(0);
        let (start, end) = (origin.start - base, origin.end.saturating_sub(base));
        let span = Span { file: file as u32, start, end };
        let known = self.files.get(span.file).is_some() && origin.end > 0;
        let shown = if known {
            let at = self.files.locate(span);
            format!("{}:{}:{}", at.path, at.line, at.column)
        } else {
            String::new()
        };
        SourceLocation { function, span, shown }
    }
}
