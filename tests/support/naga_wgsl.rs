//! What naga's WGSL front end says of a text, as a second opinion on `wgsl`.
//!
//! naga is part of the crate under test, so nothing of the crate is held
//! against this; it only tells whether encase's answers are worth trusting.

use naga::{ArraySize, Handle, Module, Scalar, ScalarKind, Type, TypeInner, VectorSize};

use super::leaf::{OracleBlock, OracleLeaf};

/// The structures that variables of the text have as type.
pub fn blocks(text: &str) -> Result<Vec<OracleBlock>, String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    let mut found = Vec::new();
    for (_, variable) in module.global_variables.iter() {
        let ty = &module.types[variable.ty];
        if let TypeInner::Struct { span, .. } = ty.inner {
            let mut leaves = Vec::new();
            let root = OracleLeaf {
                path: String::new(),
                ty: String::new(),
                offset: 0,
                dims: Vec::new(),
                strides: Vec::new(),
                matrix_stride: None,
                row_major: false,
            };
            below(&module, variable.ty, root, &mut leaves);
            found.push(OracleBlock {
                name: ty.name.clone().ok_or("a structure without a name")?,
                count: Vec::new(),
                size: Some(u64::from(span)),
                data_size: None,
                leaves,
            });
        }
    }
    Ok(found)
}

fn below(module: &Module, ty: Handle<Type>, place: OracleLeaf, leaves: &mut Vec<OracleLeaf>) {
    match &module.types[ty].inner {
        TypeInner::Struct { members, .. } => {
            for member in members {
                let name = member.name.as_deref().expect("WGSL members have names");
                let dot = if place.path.is_empty() { "" } else { "." };
                let place = OracleLeaf {
                    path: format!("{}{dot}{name}", place.path),
                    offset: place.offset + u64::from(member.offset),
                    ..place.clone()
                };
                below(module, member.ty, place, leaves);
            }
        }
        TypeInner::Array { base, size, stride } => {
            let mut place = place;
            place.path.push_str("[]");
            place.strides.push(Some(u64::from(*stride)));
            place.dims.push(match size {
                ArraySize::Constant(length) => Some(u64::from(length.get())),
                ArraySize::Dynamic => None,
                ArraySize::Pending(_) => unreachable!("no overrides in these texts"),
            });
            below(module, *base, place, leaves);
        }
        TypeInner::Scalar(kind) => leaves.push(OracleLeaf { ty: scalar(*kind), ..place }),
        TypeInner::Atomic(kind) => {
            leaves.push(OracleLeaf { ty: format!("atomic<{}>", scalar(*kind)), ..place });
        }
        TypeInner::Vector { size, scalar: kind } => {
            let ty = format!("vec{}<{}>", *size as u8, scalar(*kind));
            leaves.push(OracleLeaf { ty, ..place });
        }
        TypeInner::Matrix { columns, rows, scalar: kind } => {
            let ty = format!("mat{}x{}<{}>", *columns as u8, *rows as u8, scalar(*kind));
            // naga keeps no matrix stride: WGSL §14.4.1 gives columns the
            // alignment of their vector type.
            let column = if *rows == VectorSize::Bi { 2 } else { 4 };
            let matrix_stride = Some(u64::from(kind.width) * column);
            leaves.push(OracleLeaf { ty, matrix_stride, ..place });
        }
        other => unreachable!("no {other:?} in these texts"),
    }
}

fn scalar(scalar: Scalar) -> String {
    let letter = match scalar.kind {
        ScalarKind::Sint => 'i',
        ScalarKind::Uint => 'u',
        ScalarKind::Float => 'f',
        other => unreachable!("no {other:?} in these texts"),
    };
    format!("{letter}{}", u32::from(scalar.width) * 8)
}
