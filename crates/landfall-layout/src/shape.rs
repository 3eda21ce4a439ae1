//! Declared types with no byte in them: what a shader's text says a block holds.
//!
//! Made by [`parse`](mod@crate::syntax), read by [`layout`](crate::layout()).

mod spelled;

use std::sync::Arc;

use crate::source::{Language, Span};
pub use spelled::Spelled;
pub(crate) use spelled::wgsl_scalar;

/// What a component is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum ScalarKind {
    Bool,
    Sint,
    Uint,
    Float,
    /// The 16-bit format with the exponent of a 32-bit float.
    Bfloat,
    /// The 8-bit format with 5 bits of exponent.
    FloatE5m2,
    /// The 8-bit format with 4 bits of exponent.
    FloatE4m3,
}

/// A component type: kind and width in bytes (a bool in a buffer is 4 bytes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Scalar {
    /// What it is.
    pub kind: ScalarKind,
    /// Bytes it occupies: 1, 2, 4 or 8.
    pub width: u8,
}

#[allow(missing_docs)]
impl Scalar {
    pub const BOOL: Scalar = Scalar { kind: ScalarKind::Bool, width: 4 };
    pub const I32: Scalar = Scalar { kind: ScalarKind::Sint, width: 4 };
    pub const U32: Scalar = Scalar { kind: ScalarKind::Uint, width: 4 };
    pub const F32: Scalar = Scalar { kind: ScalarKind::Float, width: 4 };
    pub const F64: Scalar = Scalar { kind: ScalarKind::Float, width: 8 };
    pub const F16: Scalar = Scalar { kind: ScalarKind::Float, width: 2 };
    pub const U64: Scalar = Scalar { kind: ScalarKind::Uint, width: 8 };
}

/// A type that can stand in a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Type {
    /// One component.
    Scalar(Scalar),
    /// WGSL `atomic<T>`: laid out as its component.
    Atomic(Scalar),
    /// 2 to 4 components.
    Vector {
        /// Component type.
        scalar: Scalar,
        /// Number of components.
        rows: u8,
    },
    /// `matCxR`: C columns of R rows.
    Matrix {
        /// Component type.
        scalar: Scalar,
        /// Number of columns, C.
        columns: u8,
        /// Number of rows, R.
        rows: u8,
    },
    /// A 64-bit address: a GLSL buffer reference, or a bindless sampler or image handle.
    Address(Arc<str>),
    /// A structure.
    Struct(Arc<Struct>),
    /// An array; of arrays when its element is one.
    Array {
        /// Element type.
        element: Arc<Type>,
        /// Number of elements.
        len: ArrayLen,
    },
}

/// Number of elements of an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ArrayLen {
    /// Known from the text.
    Fixed(u32),
    /// `T a[]` or `array<T>`: as many as the buffer holds.
    Runtime,
    /// A specialisation constant or override that has no default and was given no value: its name.
    Override(Arc<str>),
}

/// A structure: its name and members.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Struct {
    /// Its name; empty for GLSL's `struct { … }` without one.
    pub name: Arc<str>,
    /// Its members in the order of the text, without opaque ones (samplers, images).
    pub members: Vec<Member>,
    /// Members left out because they are opaque: their names.
    pub opaque: Vec<Arc<str>>,
    /// Its name in the text.
    pub span: Span,
    /// Leaf patterns below it, each array counted once.
    leaves: u64,
    /// Structures and array dimensions on the way down to its deepest leaf.
    depth: u32,
}

/// Structures and arrays may nest this deep; deeper text is refused by the parsers.
pub const DEEPEST_NESTING: u32 = 128;

impl Struct {
    /// A structure of those members.
    pub fn new(name: Arc<str>, members: Vec<Member>, opaque: Vec<Arc<str>>, span: Span) -> Struct {
        let leaves = members.iter().fold(0u64, |sum, m| sum.saturating_add(m.ty.leaves()));
        let depth = members.iter().map(|m| m.ty.depth()).max().unwrap_or(0) + 1;
        Struct { name, members, opaque, span, leaves, depth }
    }
}

/// How a matrix is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Majorness {
    Column,
    Row,
}

/// A number written in the text as a layout qualifier or attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// The value.
    pub value: u64,
    /// Where it stands.
    pub span: Span,
}

/// A member of a structure or block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: Arc<str>,
    /// Its type, array dimensions included.
    pub ty: Type,
    /// `row_major` or `column_major` on the member itself.
    pub majorness: Option<Majorness>,
    /// GLSL `layout(offset = N)`.
    pub offset: Option<Written>,
    /// GLSL `layout(align = N)` or WGSL `@align(N)`.
    pub align: Option<Written>,
    /// WGSL `@size(N)`.
    pub size: Option<Written>,
    /// Its name in the text.
    pub span: Span,
    /// The comments that belong to it: on the lines before it and at the end of its own line.
    pub comment: Vec<Span>,
}

impl Member {
    /// One of which the text says no more than its name and its type.
    pub fn plain(name: Arc<str>, ty: Type, span: Span) -> Member {
        Member {
            name,
            ty,
            majorness: None,
            offset: None,
            align: None,
            size: None,
            span,
            comment: Vec::new(),
        }
    }
}

/// Where a block lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AddressSpace {
    /// `uniform` block, `var<uniform>`.
    Uniform,
    /// `buffer` block, `var<storage>`.
    Storage,
    /// `layout(push_constant)`, `var<immediate>`.
    PushConstant,
    /// `layout(buffer_reference) buffer`: a type to point at.
    BufferReference,
    /// `layout(shaderRecordEXT) buffer`.
    ShaderRecord,
    /// GLSL's loose uniforms: set one by one, they have no offsets.
    Default,
}

impl AddressSpace {
    /// The name used in messages and JSON.
    pub fn name(self) -> &'static str {
        match self {
            AddressSpace::Uniform => "uniform",
            AddressSpace::Storage => "storage",
            AddressSpace::PushConstant => "push_constant",
            AddressSpace::BufferReference => "buffer_reference",
            AddressSpace::ShaderRecord => "shader_record",
            AddressSpace::Default => "default",
        }
    }
}

/// The rules a block is laid out by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rules {
    /// OpenGL 4.6 §7.6.2.2.
    Std140,
    /// The same without rounding arrays and structures up to 16.
    Std430,
    /// `GL_EXT_scalar_block_layout`.
    Scalar,
    /// WGSL §14.4.
    Wgsl,
}

impl Rules {
    /// The name used in messages, JSON and `--rules`.
    pub fn name(self) -> &'static str {
        match self {
            Rules::Std140 => "std140",
            Rules::Std430 => "std430",
            Rules::Scalar => "scalar",
            Rules::Wgsl => "wgsl",
        }
    }

    /// The rules of that name.
    pub fn from_name(name: &str) -> Option<Rules> {
        [Rules::Std140, Rules::Std430, Rules::Scalar, Rules::Wgsl]
            .into_iter()
            .find(|rules| rules.name() == name)
    }
}

/// Whether an explicit offset may be smaller than the end of the member before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OffsetOrder {
    /// No: OpenGL, GLSL 4.60 §4.4.5.
    Ascending,
    /// Yes: Vulkan.
    Any,
    /// The text does not tell which of the two it is for.
    Untold,
}

/// The name of the block that loose uniforms are gathered into.
pub const DEFAULT_BLOCK: &str = "DefaultBlock";

/// A block as declared.
#[derive(Clone, Debug)]
pub struct Block {
    /// `uniform NAME { … }`; in WGSL the structure's name, or the variable's if it has none.
    pub name: Arc<str>,
    /// The variable, where there is one: `uniform U { … } INSTANCE;`.
    pub instance: Option<Arc<str>>,
    /// Where it lives.
    pub space: AddressSpace,
    /// The rules it is laid out by.
    pub rules: Rules,
    /// Whether the text, or the language itself, says these rules; if not, they are the driver's.
    pub rules_declared: bool,
    /// Whether it is the loose uniforms of a GLSL text, which declares no such block; its name is
    /// [`DEFAULT_BLOCK`], as that of a declared block may be.
    pub gathered: bool,
    /// `set = N`, `@group(N)`.
    pub group: Option<u32>,
    /// `binding = N`, `@binding(N)`.
    pub binding: Option<u32>,
    /// Dimensions of an array of blocks, outermost first: each element is a buffer of its own.
    pub count: Vec<ArrayLen>,
    /// Matrix storage of members that do not say their own.
    pub majorness: Majorness,
    /// Members in the order of the text, without opaque ones.
    pub members: Vec<Member>,
    /// Members left out because they are opaque: their names.
    pub opaque: Vec<Arc<str>>,
    /// Whether explicit offsets may go back.
    pub offset_order: OffsetOrder,
    /// Its name in the text.
    pub span: Span,
    /// The comments right before it.
    pub comment: Vec<Span>,
}

/// A specialisation constant or override that the layout depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// Its name in the text.
    pub name: Arc<str>,
    /// `constant_id = N`, `@id(N)`.
    pub id: Option<u32>,
    /// The value in force: the default, or what `-O` set.
    pub value: Option<i64>,
}

/// Everything in a shader that has, or could have, a layout.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Blocks in the order of the text; the loose uniforms of GLSL come last.
    pub blocks: Vec<Block>,
    /// Specialisation constants and overrides used as array sizes.
    pub overrides: Vec<Override>,
}

impl Type {
    /// The innermost type below array dimensions.
    pub fn innermost(&self) -> &Type {
        let mut ty = self;
        while let Type::Array { element, .. } = ty {
            ty = element;
        }
        ty
    }

    /// Array dimensions, outermost first.
    pub fn dims(&self) -> Vec<ArrayLen> {
        let mut dims = Vec::new();
        let mut ty = self;
        while let Type::Array { element, len } = ty {
            dims.push(len.clone());
            ty = element;
        }
        dims
    }

    /// Leaf patterns below it, each array counted once.
    pub fn leaves(&self) -> u64 {
        match self.innermost() {
            Type::Struct(s) => s.leaves,
            Type::Scalar(_)
            | Type::Atomic(_)
            | Type::Vector { .. }
            | Type::Matrix { .. }
            | Type::Address(_)
            | Type::Array { .. } => 1,
        }
    }

    /// Structures and array dimensions on the way down to its deepest leaf.
    pub fn depth(&self) -> u32 {
        let mut depth = 0;
        let mut ty = self;
        while let Type::Array { element, .. } = ty {
            depth += 1;
            ty = element;
        }
        match ty {
            Type::Struct(s) => depth + s.depth,
            _ => depth,
        }
    }

    /// The type as its language spells it: `PointLight[128]`, `array<vec3<f32>, 4>`.
    pub fn spelled(&self, language: Language) -> Spelled<'_> {
        Spelled { ty: self, language }
    }
}
