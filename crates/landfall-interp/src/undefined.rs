//! The places of operations whose value no specification defines.

use super::code::Origin;
use super::program::Program;
pub use landfall_ir::analysis::undefined::UndefinedKind;
use landfall_layout::source::Span;

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
    pub kind: UndefinedKind,
    pub place: SourceLocation,
    /// The number of occurrences over all invocations.
    pub count: u64,
    /// The operands of the first occurrence.
    pub operands: Vec<f64>,
    /// The first few invocations in which it occurred.
    pub lanes: Vec<usize>,
}

impl Undefined {
    /// Whether it is the NaN or infinity of an operation that others say to be undefined.
    pub fn follows<'u>(&self, mut others: impl Iterator<Item = &'u Undefined>) -> bool {
        let is_born = |kind| matches!(kind, UndefinedKind::BornNan | UndefinedKind::BornInfinite);
        is_born(self.kind) && others.any(|other| other.place == self.place && !is_born(other.kind))
    }
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
        // `bases` is where the text of each file begins in naga's numbering.
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
