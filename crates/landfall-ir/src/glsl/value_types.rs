//! The naga types of values outside of blocks, and the meaning of type names.

use std::num::NonZeroU32;

use naga::{ArraySize, Handle, StructMember, TypeInner};
use rustc_hash::FxHashMap;

use super::types::{Image, Kind, Opaque, Ty, carried, vector_size};

/// Adds a naga type for values, with naga's own alignments.
#[derive(Clone, Copy, Debug)]
pub struct NagaValueType {
    pub handle: Handle<naga::Type>,
    pub size: u32,
    pub align: u32,
}

pub type ValueTypes = FxHashMap<u32, NagaValueType>;

/// Returns the naga type for values of a type; `None` if it is too large or has no values.
pub fn value_type(
    types: &mut naga::UniqueArena<naga::Type>,
    known: &mut ValueTypes,
    ty: &Ty,
) -> Option<NagaValueType> {
    let plain = |types: &mut naga::UniqueArena<naga::Type>, inner: TypeInner| {
        types.insert(naga::Type { name: None, inner }, naga::Span::UNDEFINED)
    };
    let vector_align = |kind: Kind, size: u8| {
        // A vector of three is aligned like one of four.
        u32::from(kind.scalar().width) * if size == 3 { 4 } else { u32::from(size) }
    };
    Some(match ty {
        Ty::Scalar(kind) => {
            let scalar = kind.scalar();
            let width = u32::from(scalar.width);
            NagaValueType {
                handle: plain(types, TypeInner::Scalar(scalar)),
                size: width,
                align: width,
            }
        }
        Ty::Vector(kind, size) => {
            let scalar = kind.scalar();
            let inner = TypeInner::Vector { size: vector_size(*size), scalar };
            NagaValueType {
                handle: plain(types, inner),
                size: u32::from(scalar.width) * u32::from(*size),
                align: vector_align(*kind, *size),
            }
        }
        Ty::Matrix(kind, c, r) => {
            let inner = TypeInner::Matrix {
                columns: vector_size(*c),
                rows: vector_size(*r),
                scalar: kind.scalar(),
            };
            let align = vector_align(*kind, *r);
            NagaValueType { handle: plain(types, inner), size: align * u32::from(*c), align }
        }
        Ty::Array(element, Some(len)) => {
            let base = value_type(types, known, element)?;
            let stride = base.size.checked_next_multiple_of(base.align)?;
            let size = ArraySize::Constant(NonZeroU32::new(*len)?);
            let inner = TypeInner::Array { base: base.handle, size, stride };
            // Below 2^30 bytes, so that sizes and offsets cannot overflow.
            let size = stride.checked_mul(*len).filter(|&size| size < 1 << 30)?;
            NagaValueType { handle: plain(types, inner), size, align: base.align }
        }
        Ty::Struct(s) => {
            // Each structure is made once, by its number.
            if let Some(known) = known.get(&s.id) {
                return Some(*known);
            }
            let (mut offset, mut align) = (0u32, 1u32);
            let mut members = Vec::with_capacity(s.members.len());
            for field in carried(s) {
                let member = value_type(types, known, &field.ty)?;
                offset = offset.checked_next_multiple_of(member.align)?;
                members.push(StructMember {
                    name: Some(field.name.clone()),
                    ty: member.handle,
                    binding: None,
                    offset,
                });
                offset = offset.checked_add(member.size).filter(|&size| size < 1 << 30)?;
                align = align.max(member.align);
            }
            // naga has no empty structures.
            if members.is_empty() {
                return None;
            }
            let span = offset.checked_next_multiple_of(align)?;
            let inner = TypeInner::Struct { members, span };
            let name = (!s.name.is_empty()).then(|| s.name.clone());
            let handle = types.insert(naga::Type { name, inner }, naga::Span::UNDEFINED);
            let value_type = NagaValueType { handle, size: span, align };
            known.insert(s.id, value_type);
            value_type
        }
        Ty::Void | Ty::Opaque(_) | Ty::Array(_, None) => return None,
    })
}

/// Returns the built-in type of a name; `None` for other names.
pub fn builtin(name: &str) -> Option<Ty> {
    use landfall_layout::shape::Type;
    pub use landfall_layout::syntax::glsl::types::{Builtin, builtin};
    Some(match builtin(name)? {
        Builtin::Void => Ty::Void,
        Builtin::Data(Type::Scalar(scalar)) => Ty::Scalar(Kind::from_scalar(scalar)?),
        Builtin::Data(Type::Vector { scalar, rows }) => {
            Ty::Vector(Kind::from_scalar(scalar)?, rows)
        }
        Builtin::Data(Type::Matrix { scalar, columns, rows }) => {
            Ty::Matrix(Kind::from_scalar(scalar)?, columns, rows)
        }
        Builtin::Data(
            Type::Atomic(_) | Type::Address(_) | Type::Struct(_) | Type::Array { .. },
        ) => {
            return None;
        }
        Builtin::Opaque => Ty::Opaque(opaque(name)),
    })
}

fn opaque(name: &str) -> Opaque {
    // `isampler2D`, `usampler2D`: the kind of the texel is the first letter; `image2D` begins with
    // an i as well.
    let (kind, rest) = match name.as_bytes().first() {
        Some(b'i') if !name.starts_with("image") => (Kind::Int, &name[1..]),
        Some(b'u') => (Kind::Uint, &name[1..]),
        _ => (Kind::Float, name),
    };
    match rest {
        "sampler" => return Opaque::Sampler { comparison: false },
        "samplerShadow" => return Opaque::Sampler { comparison: true },
        // An input attachment is a texture that is read where the fragment is.
        "subpassInput" | "subpassInputMS" => {
            let (multi, dim) = (rest == "subpassInputMS", naga::ImageDimension::D2);
            let (arrayed, depth, rectangle) = (false, false, false);
            return Opaque::Texture(Image { dim, arrayed, multi, depth, kind, rectangle });
        }
        _ => {}
    }
    let foreign = || Opaque::Foreign(name.to_string());
    let Some((word, dim)) =
        ["sampler", "texture", "image"].iter().find_map(|w| Some((*w, rest.strip_prefix(w)?)))
    else {
        return foreign();
    };
    // The suffix `Shadow` makes a comparison.
    let (dim, depth) = match dim.strip_suffix("Shadow") {
        Some(dim) => (dim, true),
        None => (dim, false),
    };
    use naga::ImageDimension as D;
    let (dim, arrayed, multi) = match dim {
        "1D" => (D::D1, false, false),
        "2D" | "2DRect" => (D::D2, false, false),
        "3D" => (D::D3, false, false),
        "Cube" => (D::Cube, false, false),
        "1DArray" => (D::D1, true, false),
        "2DArray" => (D::D2, true, false),
        "CubeArray" => (D::Cube, true, false),
        "2DMS" => (D::D2, false, true),
        "2DMSArray" => (D::D2, true, true),
        _ => return foreign(),
    };
    let rectangle = rest.contains("Rect");
    let image = Image { dim, arrayed, multi, depth, kind, rectangle };
    match word {
        "sampler" => Opaque::Combined(image),
        "texture" => Opaque::Texture(image),
        _ => Opaque::Storage(image),
    }
}
