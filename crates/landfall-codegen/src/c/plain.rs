//! C types of scalars, vectors and matrices.

use crate::scalar_names::ScalarNames;
use landfall_layout::layout::MemberLayout;
use landfall_layout::shape::{Scalar, ScalarKind, Type};

/// C has no type for other floats, so their bits are stored.
const SCALARS: ScalarNames = ScalarNames {
    sint: ["int8_t", "int16_t", "int32_t", "int64_t"],
    uint: ["uint8_t", "uint16_t", "uint32_t", "uint64_t"],
    float: ["", "", "float", "double"],
};

/// A C type.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct CType {
    /// The type before the name: `float`, `PointLight`.
    pub base: String,
    /// The array lengths after the name: `[3]`.
    pub brackets: Vec<u64>,
    /// `sizeof`, in bytes.
    pub size: u64,
    /// The largest alignment C may give it.
    pub align: u64,
    /// Whether it is a type of the program.
    pub is_user: bool,
}

/// The C type of a scalar, vector or matrix.
pub(super) fn plain_type(ty: &Type, member: &MemberLayout) -> CType {
    let (scalar, brackets) = match ty {
        Type::Scalar(scalar) | Type::Atomic(scalar) => (*scalar, vec![]),
        Type::Vector { scalar, rows } => (*scalar, vec![u64::from(*rows)]),
        Type::Matrix { scalar, columns, rows } => {
            let vectors = if member.row_major { *rows } else { *columns };
            let stride = member.matrix_stride.expect("a placed matrix has a stride");
            // The components of a column (or row), and those that its padding has room for.
            (*scalar, vec![u64::from(vectors), stride / u64::from(scalar.width)])
        }
        Type::Address(_) => (Scalar::U64, vec![]),
        Type::Struct(_) | Type::Array { .. } => unreachable!("only called with what has no parts"),
    };
    let width = u64::from(scalar.width);
    CType {
        base: SCALARS.of(scalar).to_string(),
        size: width * brackets.iter().product::<u64>(),
        brackets,
        align: width,
        is_user: false,
    }
}

/// The type of glm with the bytes of a vector or of a matrix that is stored by columns, if any.
pub(super) fn glm_type(ty: &Type, member: &MemberLayout) -> Option<String> {
    let (Type::Vector { scalar, .. } | Type::Matrix { scalar, .. }) = ty else { return None };
    let prefix = match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => "",
        (ScalarKind::Float, 8) => "d",
        (ScalarKind::Sint, 4) => "i",
        // A bool of a shader has 4 bytes, one of glm 1.
        (ScalarKind::Uint, 4) | (ScalarKind::Bool, _) => "u",
        _ => return None,
    };
    match ty {
        Type::Vector { rows, .. } => Some(format!("glm::{prefix}vec{rows}")),
        Type::Matrix { columns, .. } if !member.row_major => {
            // Columns with padding are those of a matrix with more rows.
            let rows = member.matrix_stride? / u64::from(scalar.width);
            (2..=4).contains(&rows).then(|| format!("glm::{prefix}mat{columns}x{rows}"))
        }
        _ => None,
    }
}
