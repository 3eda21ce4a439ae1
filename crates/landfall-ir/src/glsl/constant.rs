//! Constant expressions: array sizes, indices, `case` labels, integer constants.
//!
//! Floating-point values are computed here only as part of an integer; a constant in a computation
//! is lowered as its expression.

use super::ast::Expr;
use super::types::Kind;
use landfall_layout::source::Span;
use landfall_layout::syntax::constant::Kind as ConstantKind;
pub use landfall_layout::syntax::constant::Value as Const;
use landfall_layout::syntax::glsl::evaluate;
use landfall_layout::syntax::glsl::evaluate::{Names, Problem};

struct ConstantScope<'s>(&'s dyn Fn(&str) -> Option<Const>);

impl Names for ConstantScope<'_> {
    fn value(&mut self, name: &str, span: Span) -> Result<Const, Problem> {
        (self.0)(name).ok_or_else(|| Problem::new(span, "is not constant"))
    }
}

/// Evaluates an expression; `None` if it is not constant.
pub fn evaluate(e: &Expr<'_>, look_up: &dyn Fn(&str) -> Option<Const>) -> Option<Const> {
    evaluate::evaluate(e, &mut ConstantScope(look_up)).ok()
}

/// Returns a constant as a scalar of a kind.
pub fn converted(value: &Const, kind: Kind) -> Option<Const> {
    if matches!(value, Const::List(_)) {
        return None;
    }
    let kind = match kind {
        Kind::Bool => ConstantKind::Bool,
        Kind::Int | Kind::Short => ConstantKind::Int,
        Kind::Uint | Kind::Ushort => ConstantKind::Uint,
        Kind::Long => ConstantKind::Long,
        Kind::Ulong => ConstantKind::Ulong,
        Kind::Float | Kind::Double | Kind::Half => ConstantKind::Float,
    };
    value.convert(kind).ok()
}

/// Returns a literal's value and kind; a float's value is exact in f64, integers have 32 bits.
pub fn literal(text: &str) -> Option<(f64, Kind)> {
    let (value, scalar) = evaluate::literal(text).ok()?;
    let kind = Kind::from_scalar(scalar)?;
    let number = match (value, kind) {
        (Const::Float(value), _) => value,
        // A literal past 2^31 keeps its bits.
        (value, Kind::Int) => f64::from(value.integer()? as i32),
        (value, _) => f64::from(u32::try_from(value.integer()?).ok()?),
    };
    Some((number, kind))
}
