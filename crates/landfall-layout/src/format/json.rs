//! JSON that follows [`LAYOUT_SCHEMA`](super::LAYOUT_SCHEMA): snake_case keys, sizes in bytes,
//! source order, each object of an array on its own line.

mod document;
mod lines;

use std::fmt::Write as _;

use rustc_hash::FxHashMap;
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::place::Places;
use super::{EmitOptions, SCHEMA_VERSION, expand, phrases};
use crate::layout::{BlockLayout, Leaf, MemberLayout};
use crate::shape::{AddressSpace, ArrayLen, Override, Rules, Type};
use crate::source::{Language, Span, Target};
use crate::{ShaderLayout, variant_name};

pub use document::Tool;
#[doc(hidden)]
pub use document::document;
#[cfg(feature = "schema")]
#[doc(hidden)]
pub use document::document_schema;
#[doc(hidden)]
pub use lines::{to_lines, write_lines};

/// Layouts of shader blocks. All numbers are bytes unless stated otherwise.
#[cfg(feature = "schema")]
#[derive(schemars::JsonSchema)]
#[expect(dead_code, reason = "never more than a shader is in memory")]
struct LayoutDocument<'a> {
    #[schemars(extend("const" = SCHEMA_VERSION))]
    schema_version: u32,
    tool: Tool,
    shaders: Vec<LayoutShaderObject<'a>>,
}

/// The schema of [`LAYOUT_SCHEMA`](super::LAYOUT_SCHEMA).
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    crate::schema::text::<LayoutDocument<'_>>("landfall layout --format json")
}

/// The text before the first shader.
pub(super) fn opening() -> String {
    let tool = to_lines(&Tool::LANDFALL);
    format!("{{\"schema_version\":{SCHEMA_VERSION},\"tool\":{tool},\"shaders\":[\n")
}

/// One shader, without a trailing newline.
pub(super) fn shader(shader: &ShaderLayout, options: &EmitOptions) -> String {
    let mut context = PlaceContext {
        language: shader.language,
        path: &shader.path,
        places: Places::new(&shader.files),
        structures: Vec::new(),
        known: FxHashMap::default(),
    };
    let blocks: Vec<_> =
        shader.blocks.iter().map(|block| block_object(block, &mut context, options)).collect();
    let constants = shader.constants.iter();
    let constants = constants.map(|it| LengthConstantObject { name: &it.name, value: it.value });
    let object = LayoutShaderObject {
        path: &shader.path,
        language: shader.language,
        stage: shader.stage.map(|stage| stage.name()),
        variants: variants(shader),
        includes: shader.files.iter().skip(1).map(|file| file.path.as_str()).collect(),
        overrides: shader.overrides.iter().map(OverrideObject::new).collect(),
        constants: constants.collect(),
        assumed_target: shader.assumed_target,
        structures: context.structures,
        blocks,
    };
    format!("  {}", to_lines(&object))
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LayoutShaderObject<'a> {
    path: &'a str,
    language: Language,
    /// fragment, vertex, ...; null if neither the shader nor the file name specifies it.
    stage: Option<&'static str>,
    /// The sets of macros that have these blocks, where others of the shader's variants do not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    variants: Vec<Vec<String>>,
    /// The files it includes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    includes: Vec<&'a str>,
    /// The specialisation constants and overrides that sizes depend on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    overrides: Vec<OverrideObject<'a>>,
    /// The constants and macros that the lengths of arrays in blocks are written with, but for
    /// specialisation constants.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    constants: Vec<LengthConstantObject<'a>>,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    /// The structures of blocks, once for each layout that rules give them; those in others come first.
    /// A block of WGSL that is a structure is only in blocks.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    structures: Vec<LayoutStructureObject<'a>>,
    /// Blocks in source order; loose uniforms come last.
    blocks: Vec<LayoutBlockObject<'a>>,
}

/// The sets of macros that have the blocks, if not all variants have them.
fn variants(shader: &ShaderLayout) -> Vec<Vec<String>> {
    let sets = shader.condition.iter().flat_map(|condition| &condition.sets);
    let one = |one: &(String, String)| variant_name(std::slice::from_ref(one));
    sets.map(|set| set.iter().map(one).collect()).collect()
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LengthConstantObject<'a> {
    name: &'a str,
    value: u32,
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct OverrideObject<'a> {
    name: &'a str,
    /// constant_id = N, @id(N).
    id: Option<u32>,
    /// The default, by which blocks are laid out; null if there is none and -O sets none.
    value: Option<i64>,
}

impl OverrideObject<'_> {
    fn new(it: &Override) -> OverrideObject<'_> {
        OverrideObject { name: &it.name, id: it.id, value: it.value }
    }
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LayoutBlockObject<'a> {
    /// uniform NAME { ... }; in WGSL the structure's name, or the variable's if it has none.
    name: &'a str,
    /// The name of the instance or variable.
    instance: Option<&'a str>,
    /// The address space; default for loose uniforms, struct for a structure of --struct.
    address_space: AddressSpace,
    /// The layout rules; null for loose uniforms.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = Rules::ALL.map(Rules::name))))]
    rules: Option<&'static str>,
    /// Whether the shader or its language specifies these rules; if not, the driver's offsets may
    /// differ.
    rules_declared: bool,
    /// set = N, @group(N).
    group: Option<u32>,
    /// binding = N, @binding(N).
    binding: Option<u32>,
    /// The number of buffers: the elements of an array of blocks, else 1; null if the shader does
    /// not specify it.
    count: Option<u64>,
    /// Bytes a buffer must hold, as desktop drivers report; OpenGL ES leaves the reported size to
    /// the implementation. A runtime-sized tail is counted with one element; null for loose
    /// uniforms.
    size: Option<u64>,
    /// The end of the last member; null for loose uniforms.
    data_size: Option<u64>,
    /// The largest alignment of a member; null for loose uniforms.
    align: Option<u64>,
    span: LineColumn,
    /// The paths of its samplers and images, which have no bytes. After 10000 paths the last one is
    /// ….
    #[serde(skip_serializing_if = "Vec::is_empty")]
    opaque: Vec<String>,
    /// In source order.
    members: Vec<LayoutMemberObject<'a>>,
    /// Every scalar, vector and matrix, one entry per path pattern.
    leaves: Vec<LeafObject<'a>>,
    /// With --expand: every array element by its own path; of a runtime-sized array only the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "schema",
        schemars(with = "Option<std::collections::BTreeMap<String, u64>>")
    )]
    offsets: Option<Offsets<'a>>,
}

/// A structure as a block's rules lay it out; those that it contains come before it.
#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LayoutStructureObject<'a> {
    name: &'a str,
    /// The rules of the blocks that it is laid out for.
    rules: &'static str,
    /// Bytes of one, with the padding at its end.
    size: u64,
    /// The alignment.
    align: Option<u64>,
    /// In source order, with offsets from its start, and without the members of structures in it.
    members: Vec<LayoutMemberObject<'a>>,
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LayoutMemberObject<'a> {
    name: &'a str,
    /// The type in the shader's language.
    #[serde(rename = "type")]
    ty: String,
    /// Bytes from the start of the enclosing block or structure; null for loose uniforms.
    offset: Option<u64>,
    /// The bytes it occupies: 12 for a vec3, stride times count for an array, rounded up to its
    /// alignment for a structure; null if runtime-sized, and for loose uniforms.
    size: Option<u64>,
    /// The alignment: its offset is a multiple of this; null for loose uniforms.
    align: Option<u64>,
    /// Bytes from one element to the next of the outermost dimension.
    #[serde(skip_serializing_if = "Option::is_none")]
    array_stride: Option<u64>,
    /// Array lengths, outermost first; null if runtime-sized or not specified in the shader.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    dims: Vec<Option<u64>>,
    /// Bytes from one element to the next, for each dimension, outermost first; empty for loose
    /// uniforms.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    strides: &'a [u64],
    /// The matrix stride: bytes from one column to the next, or from one row to the next if
    /// row_major.
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix_stride: Option<u64>,
    /// Whether its matrices are row-major; only on matrices.
    #[serde(skip_serializing_if = "Option::is_none")]
    row_major: Option<bool>,
    /// The index of its structure in the shader's structures.
    #[serde(skip_serializing_if = "Option::is_none")]
    structure: Option<usize>,
    span: LineColumn,
    /// The members of its structure, with offsets from the start of one element.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    members: Vec<LayoutMemberObject<'a>>,
}

impl<'a> LayoutMemberObject<'a> {
    /// Without the members of its structure.
    fn alone(&self) -> LayoutMemberObject<'a> {
        let (ty, dims, span) = (self.ty.clone(), self.dims.clone(), self.span.clone());
        LayoutMemberObject { ty, dims, span, members: Vec::new(), ..*self }
    }
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend("dependentRequired" = serde_json::json!({
    "naga_offset": ["naga_dims", "naga_strides"],
    "naga_dims": ["naga_offset"],
    "naga_strides": ["naga_offset"],
}))))]
struct LeafObject<'a> {
    /// The path, as in data[].pos: spelled like OpenGL's active uniforms, without the block's name.
    path: &'a str,
    /// A scalar, vector or matrix, spelled in the shader's language.
    #[serde(rename = "type")]
    ty: String,
    /// The kind of a component, in the same words for every language; address is a 64-bit address
    /// or handle.
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = [
            "bool", "sint", "uint", "float", "bfloat", "float_e5m2", "float_e4m3", "address"
        ]))
    )]
    kind: &'static str,
    /// Bytes of a component.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = [1, 2, 4, 8])))]
    width: u8,
    /// Columns of a matrix; 1 for all else.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 4)))]
    columns: u8,
    /// Rows of a matrix, components of a vector; 1 for a scalar.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 4)))]
    rows: u8,
    /// The offset of its first element from the start of the block; null for loose uniforms.
    /// Element i, j is at offset + i * strides[0] + j * strides[1].
    offset: Option<u64>,
    /// Array lengths, outermost first; null if runtime-sized or not specified in the shader.
    dims: Vec<Option<u64>>,
    /// Bytes from one element to the next, for each dimension, outermost first; empty for loose
    /// uniforms.
    strides: &'a [u64],
    /// The bytes of one element; null for loose uniforms.
    size: Option<u64>,
    /// The matrix stride: bytes from one column to the next, or from one row to the next if
    /// row_major.
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix_stride: Option<u64>,
    /// Whether the matrix is row-major; only on matrices.
    #[serde(skip_serializing_if = "Option::is_none")]
    row_major: Option<bool>,
    /// The offset at which naga and wgpu read it, if any of its numbers differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    naga_offset: Option<u64>,
    /// naga's array dimensions; with naga_offset.
    #[serde(skip_serializing_if = "Option::is_none")]
    naga_dims: Option<&'a [Option<u64>]>,
    /// naga's strides; with naga_offset.
    #[serde(skip_serializing_if = "Option::is_none")]
    naga_strides: Option<&'a [u64]>,
}

/// A line and column, from 1; the path only in included files.
#[derive(Clone, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LineColumn {
    /// The line, from 1.
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    line: u32,
    /// The column in characters, from 1.
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    column: u32,
    /// The included file; absent for the shader's own file.
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<String>,
}

struct PlaceContext<'a> {
    language: Language,
    path: &'a str,
    places: Places<'a>,
    structures: Vec<LayoutStructureObject<'a>>,
    /// The index of each structure by its name and layout.
    known: FxHashMap<String, usize>,
}

impl<'a> PlaceContext<'a> {
    /// The index of the structure that a member of a block is of, which is added if it is new.
    fn structure(
        &mut self,
        member: &'a MemberLayout,
        rules: Rules,
        members: &[LayoutMemberObject<'a>],
    ) -> Option<usize> {
        let (Type::Struct(of), Some(_)) = (member.ty.innermost(), member.offset) else {
            return None;
        };
        // Two structures of one name and rules are one if all their numbers are.
        let mut key = format!("{} {}", of.name, rules.name());
        for one in members {
            let LayoutMemberObject { name, ty, offset, strides, .. } = one;
            let _ = write!(key, ";{name} {ty} {offset:?} {strides:?} {:?}", one.structure);
            let _ = write!(key, " {:?} {:?}", one.matrix_stride, one.row_major);
        }
        let next = self.structures.len();
        let at = *self.known.entry(key).or_insert(next);
        if at == next {
            self.structures.push(LayoutStructureObject {
                name: &of.name,
                rules: rules.name(),
                size: crate::layout::measure::element_size(member, rules),
                align: member.align,
                members: members.iter().map(LayoutMemberObject::alone).collect(),
            });
        }
        Some(at)
    }

    fn place(&mut self, span: Span) -> LineColumn {
        let at = self.places.locate(span);
        let path = (at.path != self.path).then_some(at.path);
        LineColumn { line: at.line, column: at.column, path }
    }
}

fn block_object<'a>(
    block: &'a BlockLayout,
    context: &mut PlaceContext<'a>,
    options: &EmitOptions,
) -> LayoutBlockObject<'a> {
    let expanded = options.expand && expand::can_expand(block);
    LayoutBlockObject {
        name: &block.name,
        instance: block.instance.as_deref(),
        address_space: block.space,
        // Loose uniforms have no offsets, and so no rules.
        rules: (block.space != AddressSpace::Default).then(|| block.rules.name()),
        rules_declared: block.rules_declared,
        group: block.group,
        binding: block.binding,
        count: phrases::buffers(block),
        size: block.size,
        data_size: block.data_size,
        align: block.align,
        span: context.place(block.span),
        opaque: phrases::opaque(block),
        members: block.members.iter().map(|m| member_object(m, block.rules, context)).collect(),
        leaves: block.leaves.iter().map(|leaf| leaf_object(leaf, context.language)).collect(),
        offsets: expanded.then_some(Offsets(block)),
    }
}

fn member_object<'a>(
    member: &'a MemberLayout,
    rules: Rules,
    context: &mut PlaceContext<'a>,
) -> LayoutMemberObject<'a> {
    // Inner members first, so that the structures within get their indices first.
    let members: Vec<_> = member.members.iter().map(|m| member_object(m, rules, context)).collect();
    LayoutMemberObject {
        name: &member.name,
        ty: member.ty.spelled(context.language).to_string(),
        offset: member.offset,
        size: member.size,
        align: member.align,
        array_stride: member.strides.first().copied(),
        dims: dims(&member.dims),
        strides: &member.strides,
        matrix_stride: member.matrix_stride,
        row_major: row_major(&member.ty, member.row_major),
        structure: context.structure(member, rules, &members),
        span: context.place(member.span),
        members,
    }
}

fn leaf_object(leaf: &Leaf, language: Language) -> LeafObject<'_> {
    let (kind, width, columns, rows) = components(&leaf.ty);
    LeafObject {
        path: &leaf.path,
        ty: leaf.ty.spelled(language).to_string(),
        kind,
        width,
        columns,
        rows,
        offset: leaf.offset,
        dims: dims(&leaf.dims),
        strides: &leaf.strides,
        size: leaf.size,
        matrix_stride: leaf.matrix_stride,
        row_major: row_major(&leaf.ty, leaf.row_major),
        naga_offset: leaf.naga.as_ref().map(|naga| naga.offset),
        naga_dims: leaf.naga.as_ref().map(|naga| naga.dims.as_slice()),
        naga_strides: leaf.naga.as_ref().map(|naga| naga.strides.as_slice()),
    }
}

/// The kind and the bytes of a component, and the columns and rows of the type, in words that do not
/// depend on the language.
fn components(ty: &Type) -> (&'static str, u8, u8, u8) {
    match ty.innermost() {
        Type::Scalar(scalar) | Type::Atomic(scalar) => (scalar.kind.name(), scalar.width, 1, 1),
        Type::Vector { scalar, rows } => (scalar.kind.name(), scalar.width, 1, *rows),
        Type::Matrix { scalar, columns, rows } => {
            (scalar.kind.name(), scalar.width, *columns, *rows)
        }
        // A leaf is neither a structure nor an array.
        Type::Address(_) | Type::Struct(_) | Type::Array { .. } => ("address", 8, 1, 1),
    }
}

/// The majorness of a matrix; `None` for types without one.
fn row_major(ty: &Type, row_major: bool) -> Option<bool> {
    matches!(ty.innermost(), Type::Matrix { .. }).then_some(row_major)
}

fn dims(dims: &[ArrayLen]) -> Vec<Option<u64>> {
    dims.iter().map(crate::layout::measure::fixed).collect()
}

/// The path and offset of every element, serialised without collecting them.
struct Offsets<'a>(&'a BlockLayout);

impl Serialize for Offsets<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        expand::each(self.0, &mut |element| map.serialize_entry(element.path, &element.offset))?;
        map.end()
    }
}
