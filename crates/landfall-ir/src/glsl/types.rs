//! The types of GLSL values.

use std::fmt;
use std::rc::Rc;

use landfall_layout::named;
use naga::{ScalarKind, VectorSize};
use rustc_hash::FxHashMap;

named! {
    /// The kinds of numbers in the order of their implicit conversions (GLSL 4.60 §4.1.10): each
    /// converts to those below it, but not back.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd)]
    pub enum Kind {
        Bool = "bool",
        Short = "int16_t",
        Ushort = "uint16_t",
        Int = "int",
        Uint = "uint",
        Long = "int64_t",
        Ulong = "uint64_t",
        Half = "float16_t",
        Float = "float",
        Double = "double",
    }
}

#[derive(Clone, Debug, PartialEq)]
pub enum Ty {
    Void,
    Scalar(Kind),
    Vector(Kind, u8),
    /// Component, columns, rows.
    Matrix(Kind, u8, u8),
    /// An array; `None` if the buffer or the initialiser determines its size.
    Array(Rc<Ty>, Option<u32>),
    Struct(Rc<Structure>),
    Opaque(Opaque),
}

/// A structure; two of the same name with different members are different types.
#[derive(Debug)]
pub struct Structure {
    pub id: u32,
    pub name: String,
    pub members: Vec<Field>,
    /// Whether it contains a sampler or image, at any depth.
    pub opaque: bool,
    /// The number of scalars, vectors, matrices and handles in it, elements of arrays counted each.
    pub leaves: u64,
    /// By name: the index among all members, and among those that are not handles.
    indices: FxHashMap<String, (usize, Option<u32>)>,
}

impl Structure {
    pub fn new(id: u32, name: &str, members: Vec<Field>) -> Structure {
        let opaque = members.iter().any(|member| member.ty.has_opaque());
        let leaves = members.iter().fold(0u64, |sum, m| sum.saturating_add(m.ty.leaves()));
        let mut indices = FxHashMap::default();
        // Handles are global variables, so values of the structure lack them: two ways of counting
        // members.
        let mut carried = 0;
        for (index, member) in members.iter().enumerate() {
            let own = holds_values(&member.ty).then_some(carried);
            carried += u32::from(own.is_some());
            indices.entry(member.name.clone()).or_insert((index, own));
        }
        Structure { id, name: name.to_string(), members, opaque, leaves, indices }
    }

    pub fn member(&self, name: &str) -> Option<&Field> {
        self.indices.get(name).map(|(index, _)| &self.members[*index])
    }

    /// Returns the index of a member among those that are not handles.
    pub fn carried_index(&self, name: &str) -> Option<u32> {
        self.indices.get(name)?.1
    }
}

#[derive(Clone, Debug)]
pub struct Field {
    pub name: String,
    pub ty: Ty,
}

impl PartialEq for Structure {
    fn eq(&self, other: &Structure) -> bool {
        // By declaration, not by name: GLSL compares structures so (GLSL 4.60 §4.1.8).
        self.id == other.id
    }
}

#[derive(Clone, Debug, PartialEq)]
pub enum Opaque {
    /// `sampler2D`: a texture with a sampler.
    Combined(Image),
    /// Vulkan's `texture2D`.
    Texture(Image),
    /// Vulkan's `sampler` and `samplerShadow`.
    Sampler { comparison: bool },
    /// `image2D`.
    Storage(Image),
    /// A handle that naga does not support, by its name.
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

    /// Returns whether a kind converts to another implicitly.
    pub fn converts_to(self, to: Kind) -> bool {
        self == to || (self != Kind::Bool && self < to)
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

    pub fn from_scalar(scalar: landfall_layout::shape::Scalar) -> Option<Kind> {
        use landfall_layout::shape::ScalarKind as S;
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
            _ => return None,
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
                // The outermost dimension is written first.
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

    /// Returns a scalar or vector of that many components.
    pub fn new(kind: Kind, size: u8) -> Ty {
        if size == 1 { Ty::Scalar(kind) } else { Ty::Vector(kind, size) }
    }

    /// Returns the component kind and the number of components of a scalar or vector.
    pub fn components(&self) -> Option<(Kind, u8)> {
        match self {
            Ty::Scalar(kind) => Some((*kind, 1)),
            Ty::Vector(kind, size) => Some((*kind, *size)),
            Ty::Void | Ty::Matrix(..) | Ty::Array(..) | Ty::Struct(_) | Ty::Opaque(_) => None,
        }
    }

    /// Returns the component kind of a scalar, vector or matrix.
    pub fn kind(&self) -> Option<Kind> {
        match self {
            Ty::Scalar(kind) | Ty::Vector(kind, _) | Ty::Matrix(kind, ..) => Some(*kind),
            Ty::Void | Ty::Array(..) | Ty::Struct(_) | Ty::Opaque(_) => None,
        }
    }

    /// Returns the same shape with another component kind.
    pub fn with_kind(&self, kind: Kind) -> Ty {
        match self {
            Ty::Scalar(_) => Ty::Scalar(kind),
            Ty::Vector(_, size) => Ty::Vector(kind, *size),
            Ty::Matrix(_, c, r) => Ty::Matrix(kind, *c, *r),
            Ty::Void | Ty::Array(..) | Ty::Struct(_) | Ty::Opaque(_) => self.clone(),
        }
    }

    /// Returns whether a value converts to another type implicitly.
    pub fn converts_to(&self, to: &Ty) -> bool {
        self == to
            || match (self.kind(), to.kind()) {
                (Some(from), Some(kind)) => self.with_kind(kind) == *to && from.converts_to(kind),
                _ => false,
            }
    }

    /// Returns the number of scalars, vectors, matrices and handles in a value, elements of arrays
    /// counted each.
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

    /// Returns the number of components, columns or elements that an index selects from; `None` if
    /// the type cannot be indexed.
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

/// Returns the members of a structure that are not handles.
pub fn carried(s: &Structure) -> impl Iterator<Item = &Field> {
    s.members.iter().filter(|field| holds_values(&field.ty))
}

/// Returns whether a type contains anything but handles.
pub fn holds_values(ty: &Ty) -> bool {
    match ty {
        Ty::Void | Ty::Opaque(_) => false,
        Ty::Array(element, _) => holds_values(element),
        Ty::Struct(s) => s.members.iter().any(|field| holds_values(&field.ty)),
        Ty::Scalar(_) | Ty::Vector(..) | Ty::Matrix(..) => true,
    }
}
