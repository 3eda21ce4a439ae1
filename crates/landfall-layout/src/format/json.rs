//! JSON that follows [`LAYOUT_SCHEMA`](super::LAYOUT_SCHEMA): snake_case keys, sizes in bytes,
//! source order, each object of an array on its own line.

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

#[doc(hidden)]
pub use lines::{to_lines, write_lines};

/// The tool's name and version in JSON documents.
#[derive(serde::Serialize)]
pub struct Tool {
    name: &'static str,
    version: &'static str,
}

impl Tool {
    /// Landfall, with this crate's version.
    pub const LANDFALL: Tool = Tool { name: super::NAME, version: env!("CARGO_PKG_VERSION") };
}

/// The text before the first shader.
pub(super) fn opening() -> String {
    let tool = to_lines(&Tool::LANDFALL, 0);
    format!("{{\"schema_version\":{SCHEMA_VERSION},\"tool\":{tool},\"shaders\":[\n")
}

/// One shader, without a trailing newline.
pub(super) fn shader(shader: &ShaderLayout, options: &EmitOptions) -> String {
    let mut context = Context {
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
        language: shader.language.name(),
        stage: shader.stage.map(|stage| stage.name()),
        variants: variants(shader),
        includes: shader.files.iter().skip(1).map(|file| file.path.as_str()).collect(),
        overrides: shader.overrides.iter().map(OverrideObject::of).collect(),
        constants: constants.collect(),
        assumed_target: shader.assumed_target,
        structures: context.structures,
        blocks,
    };
    format!("  {}", to_lines(&object, 0))
}

#[derive(serde::Serialize)]
struct LayoutShaderObject<'a> {
    path: &'a str,
    language: &'static str,
    stage: Option<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    variants: Vec<Vec<String>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    includes: Vec<&'a str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    overrides: Vec<OverrideObject<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    constants: Vec<LengthConstantObject<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    structures: Vec<LayoutStructureObject<'a>>,
    blocks: Vec<LayoutBlockObject<'a>>,
}

/// The sets of macros that have the blocks, if not all variants have them.
fn variants(shader: &ShaderLayout) -> Vec<Vec<String>> {
    let sets = shader.condition.iter().flat_map(|condition| &condition.sets);
    let one = |one: &(String, String)| variant_name(std::slice::from_ref(one));
    sets.map(|set| set.iter().map(one).collect()).collect()
}

#[derive(serde::Serialize)]
struct LengthConstantObject<'a> {
    name: &'a str,
    value: u32,
}

#[derive(serde::Serialize)]
struct OverrideObject<'a> {
    name: &'a str,
    id: Option<u32>,
    value: Option<i64>,
}

impl OverrideObject<'_> {
    fn of(it: &Override) -> OverrideObject<'_> {
        OverrideObject { name: &it.name, id: it.id, value: it.value }
    }
}

#[derive(serde::Serialize)]
struct LayoutBlockObject<'a> {
    name: &'a str,
    instance: Option<&'a str>,
    address_space: &'static str,
    rules: Option<&'static str>,
    rules_declared: bool,
    group: Option<u32>,
    binding: Option<u32>,
    count: Option<u64>,
    size: Option<u64>,
    data_size: Option<u64>,
    align: Option<u64>,
    span: LineColumn,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    opaque: Vec<String>,
    members: Vec<LayoutMemberObject<'a>>,
    leaves: Vec<LeafObject<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    offsets: Option<Offsets<'a>>,
}

/// A structure as a block's rules lay it out; those that it contains come before it.
#[derive(serde::Serialize)]
struct LayoutStructureObject<'a> {
    name: &'a str,
    rules: &'static str,
    size: u64,
    align: Option<u64>,
    members: Vec<LayoutMemberObject<'a>>,
}

#[derive(serde::Serialize)]
struct LayoutMemberObject<'a> {
    name: &'a str,
    #[serde(rename = "type")]
    ty: String,
    offset: Option<u64>,
    size: Option<u64>,
    align: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    array_stride: Option<u64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    dims: Vec<Option<u64>>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    strides: &'a [u64],
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix_stride: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    row_major: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    structure: Option<usize>,
    span: LineColumn,
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
struct LeafObject<'a> {
    path: &'a str,
    #[serde(rename = "type")]
    ty: String,
    kind: &'static str,
    width: u8,
    columns: u8,
    rows: u8,
    offset: Option<u64>,
    dims: Vec<Option<u64>>,
    strides: &'a [u64],
    size: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix_stride: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    row_major: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    naga_offset: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    naga_dims: Option<&'a [Option<u64>]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    naga_strides: Option<&'a [u64]>,
}

/// A line and column, from 1; the path only in included files.
#[derive(Clone, serde::Serialize)]
struct LineColumn {
    line: u32,
    column: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<String>,
}

struct Context<'a> {
    language: Language,
    path: &'a str,
    places: Places<'a>,
    structures: Vec<LayoutStructureObject<'a>>,
    /// The index of each structure by its name and layout.
    known: FxHashMap<String, usize>,
}

impl<'a> Context<'a> {
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
    context: &mut Context<'a>,
    options: &EmitOptions,
) -> LayoutBlockObject<'a> {
    let expanded = options.expand && expand::can_expand(block);
    LayoutBlockObject {
        name: &block.name,
        instance: block.instance.as_deref(),
        address_space: block.space.name(),
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
    context: &mut Context<'a>,
) -> LayoutMemberObject<'a> {
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
    match ty.innermost() {
        Type::Matrix { .. } => Some(row_major),
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => None,
    }
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
