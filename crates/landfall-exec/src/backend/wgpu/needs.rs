//! Checks that the adapter has the scalar types a module uses; called by
//! [`pipeline`](super::pipeline) before wgpu, whose own message names its validator's terms.

use naga::{Expression, Scalar, ScalarKind};
use wgpu::Features;

use crate::backend::Failure;

/// Scalar types that need a feature: kinds, bytes, feature, name in messages.
const ROWS: &[(&[ScalarKind], u8, Features, &str)] = &[
    (&[ScalarKind::Float], 2, Features::SHADER_F16, "16-bit floats"),
    (&[ScalarKind::Float], 8, Features::SHADER_F64, "64-bit floats"),
    (&[ScalarKind::Sint, ScalarKind::Uint], 2, Features::SHADER_I16, "16-bit integers"),
    (&[ScalarKind::Sint, ScalarKind::Uint], 8, Features::SHADER_INT64, "64-bit integers"),
];

/// Returns the failure of a module that uses scalar types without their features.
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
    let message = format!("the shader uses {what}, which this adapter does not support");
    Some(Failure::refused(message, "the interpreter supports them: `--backend cpu`"))
}

/// Returns the scalar type of an expression that states it.
fn scalar(expression: &Expression) -> Option<Scalar> {
    match expression {
        Expression::Literal(literal) => Some(literal.scalar()),
        Expression::As { kind, convert: Some(width), .. } => {
            Some(Scalar { kind: *kind, width: *width })
        }
        _ => None,
    }
}
