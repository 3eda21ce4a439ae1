//! The types of GLSL's values, and the naga types that carry them outside of blocks.

use std::fmt;
use std::num::NonZeroU32;
use std::rc::Rc;

use rustc_hash::FxHashMap;

use naga::{ArraySize, Handle, ScalarKind, StructMember, TypeInner, VectorSize};

/// What a component is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    Bool,
    Int,
    Uint,
    Float,
    Double,
    Half,
    Short,
    Ushort,
    Long,
    Ulong,
}

/// A type of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Ty {
    Void,
    Scalar(Kind),
    Vector(Kind, u8),
    /// Component, columns, rows.
    Matrix(Kind, u8, u8),
    /// `None`: as many as the buffer, or the initialiser, holds.
    Array(Rc<Ty>, Option<u32>),
    Struct(Rc<Structure>),
    Opaque(Opaque),
}

/// A structure: two of one name and other members are two types.
#[derive(Debug)]
pub struct Structure {
    pub id: u32,
    pub name: String,
    pub members: Vec<Field>,
    /// Whether a sampler or image is in it, at any depth.
    pub opaque: bool,
    /// Scalars, vectors, matrices and handles in it, elements of arrays counted each.
    pub leaves: u64,
}

#[derive(Clone, Debug)]
pub struct Field {
    pub name: String,
    pub ty: Ty,
}

impl PartialEq for Structure {
    fn eq(&self, other: &Structure) -> bool {
        self.id == other.id
    }
}

/// A handle: what it is to naga.
#[derive(Clone, Debug, PartialEq)]
pub enum Opaque {
    /// `sampler2D`: an image and how it is sampled.
    Combined(Image),
    /// Vulkan's `texture2D`.
    Texture(Image),
    /// Vulkan's `sampler` and `samplerShadow`.
    Sampler { comparison: bool },
    /// `image2D`.
    Storage(Image),
    /// A handle naga has no counterpart for, by its name.
    Foreign(String),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image {
    pub dim: naga::ImageDimension,
    pub arrayed: bool,
    pub multi: bool,
    pub depth: bool,
    pub kind: Kind,
    /// `sampler2DRect`: coordinates are texels.
    pub rectangle: bool,
}

impl Kind {
    pub fn scalar(self) -> naga::Scalar {
        let (kind, width) = match self {
            Kind::Bool => (ScalarKind::Bool, 1),
            Kind::Int => (ScalarKind::Sint, 4),
            Kind::Uint => (ScalarKind::Uint, 4),
            Kind::Float => (ScalarKind::Float, 4),
            Kind::Double => (ScalarKind::Float, 8),
            Kind::Half => (ScalarKind::Float, 2),
            Kind::Short => (ScalarKind::Sint, 2),
            Kind::Ushort => (ScalarKind::Uint, 2),
            Kind::Long => (ScalarKind::Sint, 8),
            Kind::Ulong => (ScalarKind::Uint, 8),
        };
        naga::Scalar { kind, width }
    }

    pub fn is_float(self) -> bool {
        matches!(self, Kind::Float | Kind::Double | Kind::Half)
    }

    pub fn is_integer(self) -> bool {
        !self.is_float() && self != Kind::Bool
    }

    pub fn is_signed(self) -> bool {
        matches!(self, Kind::Int | Kind::Short | Kind::Long)
    }

    /// GLSL 4.60 §4.1.10: how far up the ladder of implicit conversions it stands.
    fn rank(self) -> u8 {
        match self {
            Kind::Bool => 0,
            Kind::Short => 1,
            Kind::Ushort => 2,
            Kind::Int => 3,
            Kind::Uint => 4,
            Kind::Long => 5,
            Kind::Ulong => 6,
            Kind::Half => 7,
            Kind::Float => 8,
            Kind::Double => 9,
        }
    }

    /// Whether a value converts to another kind by itself.
    pub fn converts_to(self, to: Kind) -> bool {
        self == to || (self != Kind::Bool && to != Kind::Bool && self.rank() < to.rank())
    }

    pub fn name(self) -> &'static str {
        match self {
            Kind::Bool => "bool",
            Kind::Int => "int",
            Kind::Uint => "uint",
            Kind::Float => "float",
            Kind::Double => "double",
            Kind::Half => "float16_t",
            Kind::Short => "int16_t",
            Kind::Ushort => "uint16_t",
            Kind::Long => "int64_t",
            Kind::Ulong => "uint64_t",
        }
    }

    fn prefix(self) -> &'static str {
        match self {
            Kind::Bool => "b",
            Kind::Int => "i",
            Kind::Uint => "u",
            Kind::Float => "",
            Kind::Double => "d",
            Kind::Half => "f16",
            Kind::Short => "i16",
            Kind::Ushort => "u16",
            Kind::Long => "i64",
            Kind::Ulong => "u64",
        }
    }

    pub fn of(scalar: crate::shape::Scalar) -> Option<Kind> {
        use crate::shape::ScalarKind as S;
        Some(match (scalar.kind, scalar.width) {
            (S::Bool, _) => Kind::Bool,
            (S::Sint, 4) => Kind::Int,
            (S::Uint, 4) => Kind::Uint,
            (S::Float, 4) => Kind::Float,
            (S::Float, 8) => Kind::Double,
            (S::Float, 2) => Kind::Half,
            (S::Sint, 2) => Kind::Short,
            (S::Uint, 2) => Kind::Ushort,
            (S::Sint, 8) => Kind::Long,
            (S::Uint, 8) => Kind::Ulong,
            (S::Sint | S::Uint | S::Float | S::Bfloat | S::FloatE5m2 | S::FloatE4m3, _) => {
                return None;
            }
        })
    }
}

impl fmt::Display for Ty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ty::Void => f.write_str("void"),
            Ty::Scalar(kind) => f.write_str(kind.name()),
            Ty::Vector(kind, size) => write!(f, "{}vec{size}", kind.prefix()),
            Ty::Matrix(kind, c, r) if c == r => write!(f, "{}mat{c}", kind.prefix()),
            Ty::Matrix(kind, c, r) => write!(f, "{}mat{c}x{r}", kind.prefix()),
            Ty::Array(element, len) => {
                let mut dims = vec![*len];
                let mut element = element;
                while let Ty::Array(next, len) = &**element {
                    dims.push(*len);
                    element = next;
                }
                write!(f, "{element}")?;
                dims.iter().try_for_each(|len| match len {
                    Some(len) => write!(f, "[{len}]"),
                    None => f.write_str("[]"),
                })
            }
            Ty::Struct(s) if s.name.is_empty() => f.write_str("struct"),
            Ty::Struct(s) => f.write_str(&s.name),
            Ty::Opaque(opaque) => write!(f, "{opaque}"),
        }
    }
}

impl fmt::Display for Opaque {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, image) = match self {
            Opaque::Combined(image) => ("sampler", image),
            Opaque::Texture(image) => ("texture", image),
            Opaque::Storage(image) => ("image", image),
            Opaque::Sampler { comparison: false } => return f.write_str("sampler"),
            Opaque::Sampler { comparison: true } => return f.write_str("samplerShadow"),
            Opaque::Foreign(name) => return f.write_str(name),
        };
        let dim = match image.dim {
            naga::ImageDimension::D1 => "1D",
            naga::ImageDimension::D2 if image.rectangle => "2DRect",
            naga::ImageDimension::D2 => "2D",
            naga::ImageDimension::D3 => "3D",
            naga::ImageDimension::Cube => "Cube",
        };
        let multi = if image.multi { "MS" } else { "" };
        let arrayed = if image.arrayed { "Array" } else { "" };
        let shadow = if image.depth { "Shadow" } else { "" };
        write!(f, "{}{word}{dim}{multi}{arrayed}{shadow}", image.kind.prefix())
    }
}

impl Ty {
    pub const BOOL: Ty = Ty::Scalar(Kind::Bool);
    pub const INT: Ty = Ty::Scalar(Kind::Int);
    pub const UINT: Ty = Ty::Scalar(Kind::Uint);
    pub const FLOAT: Ty = Ty::Scalar(Kind::Float);

    /// A scalar or a vector of that many components.
    pub fn of(kind: Kind, size: u8) -> Ty {
        if size == 1 { Ty::Scalar(kind) } else { Ty::Vector(kind, size) }
    }

    /// Component and number of them, of a scalar or vector.
    pub fn components(&self) -> Option<(Kind, u8)> {
        match self {
            Ty::Scalar(kind) => Some((*kind, 1)),
            Ty::Vector(kind, size) => Some((*kind, *size)),
            Ty::Void | Ty::Matrix(..) | Ty::Array(..) | Ty::Struct(_) | Ty::Opaque(_) => None,
        }
    }

    /// Component of a scalar, vector or matrix.
    pub fn kind(&self) -> Option<Kind> {
        match self {
            Ty::Scalar(kind) | Ty::Vector(kind, _) | Ty::Matrix(kind, ..) => Some(*kind),
            Ty::Void | Ty::Array(..) | Ty::Struct(_) | Ty::Opaque(_) => None,
        }
    }

    /// The same shape with another component.
    pub fn with_kind(&self, kind: Kind) -> Ty {
        match self {
            Ty::Scalar(_) => Ty::Scalar(kind),
            Ty::Vector(_, size) => Ty::Vector(kind, *size),
            Ty::Matrix(_, c, r) => Ty::Matrix(kind, *c, *r),
            Ty::Void | Ty::Array(..) | Ty::Struct(_) | Ty::Opaque(_) => self.clone(),
        }
    }

    /// Whether a value becomes one of another type by itself.
    pub fn converts_to(&self, to: &Ty) -> bool {
        self == to
            || match (self.kind(), to.kind()) {
                (Some(from), Some(kind)) => self.with_kind(kind) == *to && from.converts_to(kind),
                _ => false,
            }
    }

    /// Scalars, vectors, matrices and handles in a value, elements of arrays counted each.
    pub fn leaves(&self) -> u64 {
        match self {
            Ty::Array(element, len) => element.leaves().saturating_mul(len.unwrap_or(1).into()),
            Ty::Struct(s) => s.leaves,
            Ty::Void | Ty::Scalar(_) | Ty::Vector(..) | Ty::Matrix(..) | Ty::Opaque(_) => 1,
        }
    }

    pub fn has_opaque(&self) -> bool {
        match self {
            Ty::Opaque(_) => true,
            Ty::Array(element, _) => element.has_opaque(),
            Ty::Struct(s) => s.opaque,
            Ty::Void | Ty::Scalar(_) | Ty::Vector(..) | Ty::Matrix(..) => false,
        }
    }

    /// Components, columns, elements: what an index may be below; `None` if nothing is indexed.
    pub fn indexed(&self) -> Option<(Ty, Option<u32>)> {
        match self {
            Ty::Vector(kind, size) => Some((Ty::Scalar(*kind), Some((*size).into()))),
            Ty::Matrix(kind, c, r) => Some((Ty::Vector(*kind, *r), Some((*c).into()))),
            Ty::Array(element, len) => Some(((**element).clone(), *len)),
            Ty::Void | Ty::Scalar(_) | Ty::Struct(_) | Ty::Opaque(_) => None,
        }
    }
}

pub fn vector_size(size: u8) -> VectorSize {
    match size {
        2 => VectorSize::Bi,
        3 => VectorSize::Tri,
        _ => VectorSize::Quad,
    }
}

/// A naga type that carries values: with the alignments naga itself would choose.
#[derive(Clone, Copy, Debug)]
pub struct Carrier {
    pub handle: Handle<naga::Type>,
    pub size: u32,
    pub align: u32,
}

/// The types that carry values of structures, by number.
pub type Carriers = FxHashMap<u32, Carrier>;

/// The type that carries values of a type; `None` when it is too large, or carries nothing.
pub fn carrier(
    types: &mut naga::UniqueArena<naga::Type>,
    known: &mut Carriers,
    ty: &Ty,
) -> Option<Carrier> {
    let plain = |types: &mut naga::UniqueArena<naga::Type>, inner: TypeInner| {
        types.insert(naga::Type { name: None, inner }, naga::Span::UNDEFINED)
    };
    let vector_align = |kind: Kind, size: u8| {
        u32::from(kind.scalar().width) * if size == 3 { 4 } else { u32::from(size) }
    };
    Some(match ty {
        Ty::Scalar(kind) => {
            let scalar = kind.scalar();
            let width = u32::from(scalar.width);
            Carrier { handle: plain(types, TypeInner::Scalar(scalar)), size: width, align: width }
        }
        Ty::Vector(kind, size) => {
            let scalar = kind.scalar();
            let inner = TypeInner::Vector { size: vector_size(*size), scalar };
            Carrier {
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
            Carrier { handle: plain(types, inner), size: align * u32::from(*c), align }
        }
        Ty::Array(element, Some(len)) => {
            let base = carrier(types, known, element)?;
            let stride = base.size.checked_next_multiple_of(base.align)?;
            let size = ArraySize::Constant(NonZeroU32::new(*len)?);
            let inner = TypeInner::Array { base: base.handle, size, stride };
            let size = stride.checked_mul(*len).filter(|&size| size < 1 << 30)?;
            Carrier { handle: plain(types, inner), size, align: base.align }
        }
        Ty::Struct(s) => {
            if let Some(known) = known.get(&s.id) {
                return Some(*known);
            }
            let (mut offset, mut align) = (0u32, 1u32);
            let mut members = Vec::with_capacity(s.members.len());
            for field in carried(s) {
                let member = carrier(types, known, &field.ty)?;
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
            if members.is_empty() {
                return None;
            }
            let span = offset.checked_next_multiple_of(align)?;
            let inner = TypeInner::Struct { members, span };
            let name = (!s.name.is_empty()).then(|| s.name.clone());
            let handle = types.insert(naga::Type { name, inner }, naga::Span::UNDEFINED);
            let carrier = Carrier { handle, size: span, align };
            known.insert(s.id, carrier);
            carrier
        }
        Ty::Void | Ty::Opaque(_) | Ty::Array(_, None) => return None,
    })
}

/// The members of a structure that hold values: those that are no handles.
pub fn carried(s: &Structure) -> impl Iterator<Item = &Field> {
    s.members.iter().filter(|field| holds_values(&field.ty))
}

/// Whether anything but handles is in a type.
pub fn holds_values(ty: &Ty) -> bool {
    match ty {
        Ty::Void | Ty::Opaque(_) => false,
        Ty::Array(element, _) => holds_values(element),
        Ty::Struct(s) => s.members.iter().any(|field| holds_values(&field.ty)),
        Ty::Scalar(_) | Ty::Vector(..) | Ty::Matrix(..) => true,
    }
}

/// What a name of the language's own means; `None` for any other.
pub fn builtin(name: &str) -> Option<Ty> {
    use crate::parse::glsl::types::{Builtin, builtin};
    use crate::shape::Type;
    Some(match builtin(name)? {
        Builtin::Void => Ty::Void,
        Builtin::Data(Type::Scalar(scalar)) => Ty::Scalar(Kind::of(scalar)?),
        Builtin::Data(Type::Vector { scalar, rows }) => Ty::Vector(Kind::of(scalar)?, rows),
        Builtin::Data(Type::Matrix { scalar, columns, rows }) => {
            Ty::Matrix(Kind::of(scalar)?, columns, rows)
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
