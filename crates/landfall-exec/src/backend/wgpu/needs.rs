//! Numbers that a module uses and an adapter may not have, refused by name.
//!
//! Asked by [`pipeline`](super::pipeline) before wgpu is, whose words for the same are of its
//! own validator.

use naga::{Expression, Scalar, ScalarKind};
use wgpu::Features;

use crate::backend::Failure;

/// Numbers that need a feature of the adapter: bytes, feature, what messages call them.
const ROWS: &[(&[ScalarKind], u8, Features, &str)] = &[
    (&[ScalarKind::Float], 2, Features::SHADER_F16, "16-bit floats"),
    (&[ScalarKind::Float], 8, Features::SHADER_F64, "64-bit floats"),
    (&[ScalarKind::Sint, ScalarKind::Uint], 2, Features::SHADER_I16, "16-bit integers"),
    (&[ScalarKind::Sint, ScalarKind::Uint], 8, Features::SHADER_INT64, "64-bit integers"),
];

/// The refusal of a module that uses what those features do not give.
pub(super) fn lacking(ir: &naga::Module, has: Features) -> Option<Failure> {
    let types = ir.types.iter().filter_map(|(_, ty)| ty.inner.scalar());
    let functions = ir.functions.iter().map(|(_, function)| function);
    let functions = functions.chain(ir.entry_points.iter().map(|entry| &entry.function));
    let expressions = functions.flat_map(|function| function.expressions.iter());
    let expressions = expressions.chain(ir.global_expressions.iter());
    let used = types.chain(expressions.filter_map(|(_, expression)| scalar(expression)));
    let row = |used: Scalar| {
        ROWS.iter().find(|(kinds, width, feature, _)| {
            kinds.contains(&used.kind) && *width == used.width && !has.contains(*feature)
        })
    };
    let (_, _, _, what) = used.filter_map(row).next()?;
    let message = format!("the shader uses {what}, which this adapter does not have");
    Some(Failure::refused(message, "the evaluator has them: `--reader cpu`"))
}

/// What an expression makes, where it says so itself.
fn scalar(expression: &Expression) -> Option<Scalar> {
    match expression {
        Expression::Literal(literal) => Some(literal.scalar()),
        Expression::As { kind, convert: Some(width), .. } => {
            Some(Scalar { kind: *kind, width: *width })
        }
        _ => None,
    }
}
