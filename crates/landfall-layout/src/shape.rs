//! Declared types and blocks, before offsets are assigned.
//!
//! Produced by [`parse`](mod@crate::syntax), read by [`layout`](crate::layout()).

mod rules;
mod spelled;

use std::sync::Arc;

use crate::source::{Language, Span};
pub use rules::{Packing, Rules};
pub use spelled::Spelled;
pub(crate) use spelled::{SCALARS, wgsl_scalar};

/// The kind of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum ScalarKind {
    Bool,
    Sint,
    Uint,
    Float,
    /// bfloat16: 16 bits with the exponent range of a 32-bit float.
    Bfloat,
    /// 8-bit float with 5 exponent bits.
    FloatE5m2,
    /// 8-bit float with 4 exponent bits.
    FloatE4m3,
}

impl ScalarKind {
    /// The name of the kind: `sint`, `float`, `float_e5m2`.
    pub fn name(self) -> &'static str {
        match self {
            ScalarKind::Bool => "bool",
            ScalarKind::Sint => "sint",
            ScalarKind::Uint => "uint",
            ScalarKind::Float => "float",
            ScalarKind::Bfloat => "bfloat",
            ScalarKind::FloatE5m2 => "float_e5m2",
            ScalarKind::FloatE4m3 => "float_e4m3",
        }
    }

    /// Whether it is a floating-point format.
    pub fn is_float(self) -> bool {
        match self {
            ScalarKind::Float
            | ScalarKind::Bfloat
            | ScalarKind::FloatE5m2
            | ScalarKind::FloatE4m3 => true,
            ScalarKind::Bool | ScalarKind::Sint | ScalarKind::Uint => false,
        }
    }
}

/// A component type: kind and width in bytes (a bool in a buffer is 4 bytes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Scalar {
    /// The kind.
    pub kind: ScalarKind,
    /// Size in bytes: 1, 2, 4 or 8.
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

/// The type of a member of a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Type {
    /// A scalar.
    Scalar(Scalar),
    /// WGSL `atomic<T>`: laid out as its component.
    Atomic(Scalar),
    /// A vector of 2 to 4 components.
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
    /// An array; its element may be an array.
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
    /// A length the text determines.
    Fixed(u32),
    /// A runtime-sized array: `T a[]` or `array<T>`.
    Runtime,
    /// A length given by the named specialisation constant or override, which has no default and
    /// was given no value.
    Override(Arc<str>),
}

/// A structure: its name and members.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Struct {
    /// The name; empty for GLSL's `struct { … }` without one.
    pub name: Arc<str>,
    /// Members in declaration order, without opaque ones (samplers, images).
    pub members: Vec<Member>,
    /// Names of the members left out because they are opaque.
    pub opaque: Vec<Arc<str>>,
    /// The span of the name.
    pub span: Span,
    /// Number of leaf patterns, each array counted once.
    leaves: u64,
    /// Number of nested structures and array dimensions down to the deepest leaf.
    depth: u32,
}

/// The limit on nested structures and arrays; the parsers reject deeper types.
pub const DEEPEST_NESTING: u32 = 128;

impl Struct {
    /// Creates a structure from its members.
    pub fn new(name: Arc<str>, members: Vec<Member>, opaque: Vec<Arc<str>>, span: Span) -> Struct {
        // Kept, not computed when asked: structures that hold two of the one before have 2^n
        // leaves, which saturates.
        let leaves = members.iter().fold(0u64, |sum, m| sum.saturating_add(m.ty.leaves()));
        let depth = members.iter().map(|m| m.ty.depth()).max().unwrap_or(0) + 1;
        Struct { name, members, opaque, span, leaves, depth }
    }
}

/// The storage order of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum MatrixLayout {
    Column,
    Row,
}

/// A number written in the text as a layout qualifier or attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// The value.
    pub value: u64,
    /// The span in the source text.
    pub span: Span,
}

/// A member of a structure or block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// The name.
    pub name: Arc<str>,
    /// The type, array dimensions included.
    pub ty: Type,
    /// `row_major` or `column_major` on the member itself.
    pub matrix_layout: Option<MatrixLayout>,
    /// GLSL `layout(offset = N)`.
    pub offset: Option<Written>,
    /// GLSL `layout(align = N)` or WGSL `@align(N)`.
    pub align: Option<Written>,
    /// WGSL `@size(N)`.
    pub size: Option<Written>,
    /// The numbers that SPIR-V gives it.
    pub place: Option<MemberPlace>,
    /// The span of the name.
    pub span: Span,
    /// The comments that belong to the member: on the lines before it and at the end of its own
    /// line.
    pub comment: Vec<Span>,
}

impl Member {
    /// Creates a member with a name and a type but no qualifiers or attributes.
    pub fn unqualified(name: Arc<str>, ty: Type, span: Span) -> Member {
        Member {
            name,
            ty,
            matrix_layout: None,
            offset: None,
            align: None,
            size: None,
            place: None,
            span,
            comment: Vec::new(),
        }
    }
}

/// The place of a member as a SPIR-V module gives it, in bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemberPlace {
    /// `Offset`: from the start of its structure.
    pub offset: u64,
    /// `ArrayStride` of each array dimension, outermost first.
    pub strides: Vec<u64>,
    /// `MatrixStride` of a matrix or an array of matrices.
    pub matrix_stride: Option<u64>,
}

/// The address space of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum AddressSpace {
    /// `uniform` block, `var<uniform>`.
    Uniform,
    /// `buffer` block, `var<storage>`.
    Storage,
    /// `layout(push_constant)`, `var<immediate>`.
    PushConstant,
    /// `layout(buffer_reference) buffer`: a type of pointees.
    BufferReference,
    /// `layout(shaderRecordEXT) buffer`.
    ShaderRecord,
    /// What a task shader passes to mesh shaders, where SPIR-V gives it offsets.
    TaskPayload,
    /// GLSL's loose uniforms, which are set individually and have no offsets.
    Default,
    /// A structure that is laid out by its name, whether or not a block holds it.
    #[serde(rename = "struct")]
    Structure,
}

impl AddressSpace {
    /// Returns the keyword of GLSL that declares a block in it.
    pub fn keyword(self) -> &'static str {
        match self {
            AddressSpace::Uniform | AddressSpace::PushConstant | AddressSpace::Default => "uniform",
            AddressSpace::Storage | AddressSpace::BufferReference | AddressSpace::ShaderRecord => {
                "buffer"
            }
            AddressSpace::TaskPayload => "taskPayloadSharedEXT",
            AddressSpace::Structure => "struct",
        }
    }

    /// Returns the name used in messages and JSON.
    pub fn name(self) -> &'static str {
        match self {
            AddressSpace::Uniform => "uniform",
            AddressSpace::Storage => "storage",
            AddressSpace::PushConstant => "push_constant",
            AddressSpace::BufferReference => "buffer_reference",
            AddressSpace::ShaderRecord => "shader_record",
            AddressSpace::TaskPayload => "task_payload",
            AddressSpace::Default => "default",
            AddressSpace::Structure => "struct",
        }
    }
}

/// Whether an explicit offset may be smaller than the end of the preceding member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum OffsetOrder {
    /// Not allowed: OpenGL, GLSL 4.60 §4.4.5.
    Ascending,
    /// Allowed: Vulkan.
    Any,
    /// The text does not show which API it is for.
    Unknown,
}

/// The name of the block that loose uniforms are gathered into.
pub const DEFAULT_BLOCK: &str = "DefaultBlock";

/// A block as declared.
#[derive(Clone, Debug)]
pub struct Block {
    /// The name in `uniform NAME { … }`; in WGSL that of the structure, or of the variable if its
    /// type is no structure.
    pub name: Arc<str>,
    /// The instance name or variable, if any: `uniform U { … } INSTANCE;`.
    pub instance: Option<Arc<str>>,
    /// The address space.
    pub space: AddressSpace,
    /// The layout rules.
    pub rules: Rules,
    /// Whether the text or the language determines the rules; otherwise the driver chooses them.
    pub rules_declared: bool,
    /// Whether the block holds the loose uniforms of a GLSL shader instead of being declared; its
    /// name is then [`DEFAULT_BLOCK`], which a declared block may also have.
    pub gathered: bool,
    /// The descriptor set or bind group: `set = N`, `@group(N)`.
    pub group: Option<u32>,
    /// The binding: `binding = N`, `@binding(N)`.
    pub binding: Option<u32>,
    /// Dimensions of an array of blocks, outermost first; each element is a separate buffer.
    pub count: Vec<ArrayLen>,
    /// Matrix storage of members that do not declare their own.
    pub matrix_layout: MatrixLayout,
    /// Members in declaration order, without opaque ones.
    pub members: Vec<Member>,
    /// Names of the members left out because they are opaque.
    pub opaque: Vec<Arc<str>>,
    /// Whether explicit offsets may go back.
    pub offset_order: OffsetOrder,
    /// The span of the name.
    pub span: Span,
    /// The comments directly before the block.
    pub comment: Vec<Span>,
}

/// A specialisation constant or override that the layout depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Override {
    /// The name.
    pub name: Arc<str>,
    /// The number: `constant_id = N`, `@id(N)`.
    pub id: Option<u32>,
    /// The default, by which blocks are laid out; the value set with `-O` where there is none.
    pub value: Option<i64>,
}

/// An array of a block whose length depends on specialisation constants. It is laid out by their
/// defaults.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SpecialisedLength {
    /// The span of the member's name.
    pub member: Span,
    /// The constants, in declaration order.
    pub constants: Vec<Arc<str>>,
    /// The length in a pipeline with the values set by `-O`, if they change it.
    pub given: Option<u32>,
}

/// A constant or macro of a shader that the lengths of its blocks' arrays are written with.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LengthConstant {
    /// The name.
    pub name: Arc<str>,
    /// The value.
    pub value: u32,
}

impl LengthConstant {
    /// Returns each name once, in the order given, without those of two values.
    pub(crate) fn distinct(all: impl Iterator<Item = LengthConstant>) -> Vec<LengthConstant> {
        let mut distinct: Vec<(LengthConstant, bool)> = Vec::new();
        for constant in all {
            match distinct.iter_mut().find(|(known, _)| known.name == constant.name) {
                // Of a name with two values neither can be generated as a constant.
                Some((known, is_one)) => *is_one &= known.value == constant.value,
                None => distinct.push((constant, true)),
            }
        }
        distinct.into_iter().filter(|(_, is_one)| *is_one).map(|(constant, _)| constant).collect()
    }
}

/// The blocks of a shader and the constants their sizes depend on.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// The blocks in declaration order; GLSL's loose uniforms come last.
    pub blocks: Vec<Block>,
    /// The specialisation constants and overrides used as array sizes.
    pub overrides: Vec<Override>,
    /// The arrays of GLSL whose lengths depend on specialisation constants.
    pub specialised: Vec<SpecialisedLength>,
    /// The constants that lengths are written with, without those that specialisation changes, in
    /// the order of their first use; each name has one value.
    pub constants: Vec<LengthConstant>,
    /// The names of GLSL's members whose lengths are taken from their uses.
    pub sized_by_use: Vec<Span>,
}

impl Block {
    /// Creates a block of declared rules, without an instance, qualifiers or attributes.
    pub(crate) fn unqualified(
        name: Arc<str>,
        space: AddressSpace,
        rules: Rules,
        members: Vec<Member>,
        span: Span,
    ) -> Block {
        Block {
            name,
            instance: None,
            space,
            rules,
            rules_declared: true,
            gathered: false,
            group: None,
            binding: None,
            count: Vec::new(),
            matrix_layout: MatrixLayout::Column,
            members,
            opaque: Vec::new(),
            offset_order: OffsetOrder::Ascending,
            span,
            comment: Vec::new(),
        }
    }

    /// Returns a structure as a block, to be laid out by its name.
    pub(crate) fn of_structure(structure: &Struct, rules: Rules) -> Block {
        let Struct { name, members, opaque, span, .. } = structure.clone();
        let block = Block::unqualified(name, AddressSpace::Structure, rules, members, span);
        Block { opaque, ..block }
    }
}

impl Type {
    /// Returns the innermost element type of an array, or the type itself.
    pub fn innermost(&self) -> &Type {
        let mut ty = self;
        while let Type::Array { element, .. } = ty {
            ty = element;
        }
        ty
    }

    /// Returns the array dimensions, outermost first.
    pub fn dims(&self) -> Vec<ArrayLen> {
        let mut dims = Vec::new();
        let mut ty = self;
        while let Type::Array { element, len } = ty {
            dims.push(len.clone());
            ty = element;
        }
        dims
    }

    /// Returns the number of leaf patterns, each array counted once.
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

    /// Returns the number of nested structures and array dimensions down to the deepest leaf.
    pub fn depth(&self) -> u32 {
        let dims = self.dims().len() as u32;
        match self.innermost() {
            Type::Struct(s) => dims + s.depth,
            _ => dims,
        }
    }

    /// Returns the type in a language's spelling: `PointLight[128]`, `array<vec3<f32>, 4>`.
    pub fn spelled(&self, language: Language) -> Spelled<'_> {
        Spelled { ty: self, language }
    }
}
