//! The layout model: the offset, size and strides of every member of every block.
//!
//! Reads [`shape`](crate::shape) and applies [`rules`]; code that prints, checks or fills a block
//! reads only this model.

pub mod attributes;
pub mod byte;
pub mod explain;
mod explicit;
mod leaves;
pub mod measure;
mod packing;
pub mod padding;
pub mod path;
pub mod rules;
pub mod targets;
pub mod uniform_constraints;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diagnostic::Code;
use crate::diagnostic::Diagnostic;
use crate::shape::{
    AddressSpace, ArrayLen, Block, MatrixLayout, Member, OffsetOrder, Rules, Struct, Type, Written,
};
use crate::source::Span;
use crate::text::counts::bytes;
pub(crate) use leaves::leaves_of;
pub use measure::occupied;
use rules::{Alignment, Cursor, TooLarge};

/// The size limit of a block in bytes: offsets are 32 bits wide in every API.
pub const LARGEST_BLOCK: u64 = 1 << 32;

/// The limit on leaf patterns of a block; guards against shaders made to exhaust memory.
pub const MAX_LEAVES: u64 = 100_000;

/// The layout of one block.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BlockLayout {
    /// The name in `uniform NAME { … }`; in WGSL that of the structure, or of the variable if its
    /// type is no structure.
    pub name: Arc<str>,
    /// The instance name or variable, if any.
    pub instance: Option<Arc<str>>,
    /// The address space.
    pub space: AddressSpace,
    /// The layout rules.
    pub rules: Rules,
    /// Whether the text or the language determines the rules; otherwise the driver chooses them.
    pub rules_declared: bool,
    /// Whether the block holds the loose uniforms of a GLSL shader instead of being declared; its
    /// name is then `DEFAULT_BLOCK`, which a declared block may also have.
    pub gathered: bool,
    /// The descriptor set or bind group: `set = N`, `@group(N)`.
    pub group: Option<u32>,
    /// The binding: `binding = N`, `@binding(N)`.
    pub binding: Option<u32>,
    /// Dimensions of an array of blocks, outermost first; each element is a separate buffer.
    pub count: Vec<ArrayLen>,
    /// Bytes a buffer must hold, counting a runtime-sized tail as one element; `None` for loose
    /// uniforms.
    ///
    /// std140 rounds up to 16, as desktop drivers report (OpenGL ES leaves the reported size to the
    /// implementation); the other rules round up to the block's alignment.
    pub size: Option<u64>,
    /// End of the last member; `None` for loose uniforms.
    pub data_size: Option<u64>,
    /// Largest alignment of a member (std140: at least 16); `None` for loose uniforms.
    pub align: Option<u64>,
    /// The members in declaration order.
    pub members: Vec<MemberLayout>,
    /// The scalars, vectors and matrices in the block, one entry per pattern.
    pub leaves: Vec<Leaf>,
    /// Names of the members left out because they are opaque (samplers, images).
    pub opaque: Vec<Arc<str>>,
    /// The span of the name.
    pub span: Span,
    /// The comments directly before the block.
    pub comment: Vec<Span>,
}

/// The layout of a member of a block or structure.
#[derive(Clone, Debug)]
pub struct MemberLayout {
    /// The name.
    pub name: Arc<str>,
    /// The type, array dimensions included.
    pub ty: Type,
    /// Offset from the start of the enclosing block or structure; `None` for loose uniforms.
    pub offset: Option<u64>,
    /// Size in bytes; `None` if runtime-sized and for loose uniforms.
    pub size: Option<u64>,
    /// Alignment in bytes; `None` for loose uniforms.
    pub align: Option<u64>,
    /// Array dimensions, outermost first.
    pub dims: Vec<ArrayLen>,
    /// Array stride of each dimension, outermost first; empty for loose uniforms.
    pub strides: Vec<u64>,
    /// Distance between columns (rows, if row-major) of a matrix or an array of matrices.
    pub matrix_stride: Option<u64>,
    /// Whether matrices are stored row-major.
    pub row_major: bool,
    /// Members of the structure, with offsets from the start of one element.
    pub members: Vec<MemberLayout>,
    /// The span of the name.
    pub span: Span,
    /// The comments that belong to the member.
    pub comment: Vec<Span>,
}

/// A scalar, vector or matrix member, nested members included; `[]` in its path stands for every
/// element of an array.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// The path as OpenGL spells active uniforms, without the block's name: `data[].pos`.
    pub path: String,
    /// The scalar, vector or matrix type.
    pub ty: Type,
    /// Offset of the first element from the start of the block; `None` for loose uniforms.
    pub offset: Option<u64>,
    /// Every array dimension along the path, outermost first.
    pub dims: Vec<ArrayLen>,
    /// Array stride of each dimension; empty for loose uniforms.
    pub strides: Vec<u64>,
    /// Size of one element in bytes; `None` for loose uniforms.
    pub size: Option<u64>,
    /// Distance between columns (rows, if row-major) of a matrix.
    pub matrix_stride: Option<u64>,
    /// Whether a matrix is stored row-major.
    pub row_major: bool,
    /// The span of the name.
    pub span: Span,
    /// naga's placement where it was computed and differs.
    pub naga: Option<NagaPlace>,
}

/// The placement of a leaf by naga, and so by wgpu.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NagaPlace {
    /// Offset of the first element from the start of the block.
    pub offset: u64,
    /// Array dimensions, outermost first; `None` where runtime-sized.
    pub dims: Vec<Option<u64>>,
    /// Array stride of each dimension.
    pub strides: Vec<u64>,
}

/// Lays out a block by its own rules.
///
/// # Errors
/// Explicit offsets that overlap or are misaligned, more than [`MAX_LEAVES`] leaves, a size past
/// [`LARGEST_BLOCK`].
pub fn lay_out(block: &Block) -> Result<BlockLayout, Vec<Diagnostic>> {
    let leaves = block.members.iter().fold(0u64, |sum, m| sum.saturating_add(m.ty.leaves()));
    if leaves > MAX_LEAVES {
        return Err(vec![too_many_leaves(block, leaves)]);
    }
    match block.rules {
        Rules::Explicit(_) => explicit::lay_out(block),
        Rules::Std140 | Rules::Std430 | Rules::Scalar | Rules::Wgsl => by_rules(block),
    }
}

fn empty(block: &Block) -> BlockLayout {
    BlockLayout {
        name: block.name.clone(),
        instance: block.instance.clone(),
        space: block.space,
        rules: block.rules,
        rules_declared: block.rules_declared,
        gathered: block.gathered,
        group: block.group,
        binding: block.binding,
        count: block.count.clone(),
        size: None,
        data_size: None,
        align: None,
        members: Vec::with_capacity(block.members.len()),
        leaves: Vec::new(),
        opaque: block.opaque.clone(),
        span: block.span,
        comment: block.comment.clone(),
    }
}

/// Lays out a block by rules of a text.
fn by_rules(block: &Block) -> Result<BlockLayout, Vec<Diagnostic>> {
    let mut result = empty(block);
    if block.space == AddressSpace::Default {
        for member in &block.members {
            result.members.push(loose(member, block.matrix_layout));
        }
    } else {
        place_members(block, &mut result)?;
    }
    result.leaves = leaves_of(&result.members, block.rules);
    Ok(result)
}

fn place_members(block: &Block, result: &mut BlockLayout) -> Result<(), Vec<Diagnostic>> {
    let mut diagnostics = Vec::new();
    let mut cursor = Cursor::new(block.rules);
    // The bytes taken so far, by their start; the ranges are disjoint but for those reported. If
    // one of them overlaps a new range, so does the last that starts before the new range ends.
    let mut taken: BTreeMap<u64, (u64, u64, &Member)> = BTreeMap::new();
    let is_explicit = block.members.iter().any(|m| m.offset.is_some());
    for member in &block.members {
        let before = cursor.end();
        // Stage 1: the offset, by the rules and by what the member itself says.
        let Ok(placed) = cursor.place(member, block.matrix_layout) else {
            return Err(vec![too_large(block, member)]);
        };
        if let Some(offset) = member.offset {
            check_offset(block, member, offset, placed, before, &mut diagnostics);
        }
        if let Some(size) = placed.type_layout.size.filter(|&size| size > 0) {
            let end = placed.offset + size;
            let before = taken.range(..end).next_back().map(|(_, other)| other);
            if let Some(other) = before.filter(|(_, other_end, _)| placed.offset < *other_end) {
                // Only an explicit offset, or a member after one, can lie before earlier members.
                diagnostics.push(overlap(member, placed.offset, other));
            }
            if is_explicit {
                taken.insert(placed.offset, (placed.offset, end, member));
            }
        }
        // Stage 2: the same for what lies within the member.
        match member_layout(member, block.rules, placed) {
            Ok(layout) => result.members.push(layout),
            Err(TooLarge) => return Err(vec![too_large(block, member)]),
        }
        if cursor.furthest() > LARGEST_BLOCK {
            // Checked at each member: later sums of offsets then stay far below 2^64.
            return Err(vec![too_large(block, member)]);
        }
    }
    if !diagnostics.is_empty() {
        return Err(diagnostics);
    }
    let whole = Cursor::structure(cursor).map_err(|TooLarge| vec![too_large_block(block)])?;
    let reach = cursor.furthest();
    let size = match block.rules {
        // OpenGL 4.6 §7.6.2.2, end: the data size is rounded up to the alignment of a vec4.
        Rules::Std140 => Alignment::VEC4.round_up(reach),
        // WGSL §14.4.1: a buffer of a non-structure type has SizeOf that type, 12 for a `vec3f`.
        Rules::Wgsl if is_bare_variable(block) => Ok(reach),
        // Rule 9 and WGSL §14.4.2: a structure is padded to its alignment.
        Rules::Std430 | Rules::Wgsl => whole.align.round_up(reach),
        // GL_EXT_scalar_block_layout: a structure ends with its last member.
        Rules::Scalar | Rules::Explicit(_) => Ok(reach),
    };
    let size = size.map_err(|TooLarge| vec![too_large_block(block)])?;
    result.data_size = Some(reach);
    result.size = Some(size);
    result.align = Some(whole.align.bytes());
    Ok(())
}

/// Whether the block is a WGSL variable whose type is not a structure.
// Such a variable, `var<storage> data: array<f32>`, is a block of one member with its own name.
fn is_bare_variable(block: &Block) -> bool {
    let alone = |member: &Member| member.name == block.name;
    block.instance.is_none() && block.members.len() == 1 && block.members.iter().all(alone)
}

/// Checks an explicit offset by GLSL 4.60 §4.4.5.
fn check_offset(
    block: &Block,
    member: &Member,
    offset: Written,
    placed: rules::Placed,
    before: Option<u64>,
    diagnostics: &mut Vec<Diagnostic>,
) {
    // Without `align = N`: that rounds the written offset up afterwards (§4.4.5) and forbids none.
    let own = rules::type_layout(&member.ty, block.rules, placed.matrix_layout)
        .map_or(Alignment::ONE, |type_layout| type_layout.align);
    if !own.divides(offset.value) {
        diagnostics.push(
            Diagnostic::error(
                Code::MisalignedOffset,
                offset.span,
                format!(
                    "`{}` is given offset {}, but a `{}` is aligned to {} bytes in {}",
                    member.name,
                    offset.value,
                    member.ty.spelled(crate::Language::Glsl),
                    own.bytes(),
                    block.rules.name(),
                ),
            )
            .with_help(format!(
                "write `offset = {}`",
                own.round_up(offset.value).unwrap_or(offset.value)
            )),
        );
        return;
    }
    let Some(before) = before else { return };
    if offset.value < before && block.offset_order == OffsetOrder::Ascending {
        diagnostics.push(
            Diagnostic::error(
                Code::OffsetGoesBack,
                offset.span,
                format!(
                    "`{}` is given offset {}, but the member before it ends at {before}",
                    member.name, offset.value,
                ),
            )
            .with_note(
                "OpenGL requires explicit offsets in ascending order; only Vulkan allows any order",
            )
            .with_help(format!(
                "write `offset = {}` or more, or pass `--target vulkan`",
                own.round_up(before).unwrap_or(before)
            )),
        );
    }
}

/// Returns warnings about offsets that OpenGL rejects, for a block whose target API is unknown.
pub(crate) fn order_of_unknown_target(block: &Block, layout: &BlockLayout) -> Vec<Diagnostic> {
    if block.offset_order != OffsetOrder::Unknown {
        return Vec::new();
    }
    let goes_back = |pair: &[MemberLayout]| {
        let end = pair[0].offset.zip(pair[0].size).map(|(offset, size)| offset + size);
        end.filter(|end| pair[1].offset < Some(*end))
    };
    let pairs = layout.members.windows(2);
    pairs
        .filter_map(|pair| Some((&pair[1], goes_back(pair)?)))
        .map(|(member, end)| {
            let message = format!(
                "`{}` is at offset {}, but the member before it ends at {end}",
                member.name,
                member.offset.unwrap_or(0),
            );
            Diagnostic::warning(Code::OffsetGoesBack, member.span, message)
                .with_note(
                    "Vulkan allows explicit offsets in any order, OpenGL only ascending ones",
                )
                .with_help("pass `--target vulkan` or `--target opengl`")
        })
        .collect()
}

fn overlap(member: &Member, at: u64, other: &(u64, u64, &Member)) -> Diagnostic {
    Diagnostic::error(
        Code::OverlappingMembers,
        member.span,
        format!(
            "`{}` at offset {at} overlaps `{}`, which occupies {} to {}",
            member.name,
            other.2.name,
            other.0,
            other.1 - 1
        ),
    )
    .with_label(other.2.span, "the other member")
}

fn too_many_leaves(block: &Block, leaves: u64) -> Diagnostic {
    let message = format!("block `{}` has {leaves} scalar, vector and matrix members", block.name);
    Diagnostic::error(Code::TooManyMembers, block.span, message)
        .with_note(format!("landfall lays out at most {MAX_LEAVES} per block"))
}

fn too_large(block: &Block, member: &Member) -> Diagnostic {
    Diagnostic::error(
        Code::BlockTooLarge,
        member.span,
        format!("block `{}` is larger than 2^32 bytes at member `{}`", block.name, member.name),
    )
    .with_note(format!("offsets are 32 bits wide: a block holds at most {}", bytes(LARGEST_BLOCK)))
    .with_help("use smaller arrays")
}

fn too_large_block(block: &Block) -> Diagnostic {
    Diagnostic::error(
        Code::BlockTooLarge,
        block.span,
        format!("block `{}` is larger than 2^32 bytes", block.name),
    )
    .with_help("use smaller arrays")
}

/// Returns the layout of a placed member and of its nested members.
fn member_layout(
    member: &Member,
    rules: Rules,
    placed: rules::Placed,
) -> Result<MemberLayout, TooLarge> {
    // From the outermost dimension inwards: each array type has the stride of its own dimension.
    let mut strides = Vec::new();
    let mut ty = &member.ty;
    while let Type::Array { element, .. } = ty {
        let type_layout = rules::type_layout(ty, rules, placed.matrix_layout)?;
        strides.push(type_layout.array_stride.expect("an array has a stride"));
        ty = element;
    }
    let members = match ty {
        Type::Struct(s) => struct_members(s, rules, placed.matrix_layout)?,
        _ => Vec::new(),
    };
    Ok(MemberLayout {
        name: member.name.clone(),
        ty: member.ty.clone(),
        offset: Some(placed.offset),
        size: placed.type_layout.size,
        align: Some(placed.type_layout.align.bytes()),
        dims: member.ty.dims(),
        strides,
        matrix_stride: placed.type_layout.matrix_stride,
        row_major: is_matrix(ty) && placed.matrix_layout == MatrixLayout::Row,
        members,
        span: member.span,
        comment: member.comment.clone(),
    })
}

fn struct_members(
    s: &Struct,
    rules: Rules,
    matrix_layout: MatrixLayout,
) -> Result<Vec<MemberLayout>, TooLarge> {
    let mut cursor = Cursor::new(rules);
    s.members
        .iter()
        .map(|member| {
            let placed = cursor.place(member, matrix_layout)?;
            member_layout(member, rules, placed)
        })
        .collect()
}

/// Returns the layout of a loose uniform, which has a name and a type but no offset.
fn loose(member: &Member, inherited: MatrixLayout) -> MemberLayout {
    let matrix_layout = member.matrix_layout.unwrap_or(inherited);
    let members = match member.ty.innermost() {
        Type::Struct(s) => s.members.iter().map(|m| loose(m, matrix_layout)).collect(),
        _ => Vec::new(),
    };
    MemberLayout {
        name: member.name.clone(),
        ty: member.ty.clone(),
        offset: None,
        size: None,
        align: None,
        dims: member.ty.dims(),
        strides: Vec::new(),
        matrix_stride: None,
        // A default of the block reaches nested members that have no qualifier of their own.
        row_major: is_matrix(member.ty.innermost()) && matrix_layout == MatrixLayout::Row,
        members,
        span: member.span,
        comment: member.comment.clone(),
    }
}

fn is_matrix(ty: &Type) -> bool {
    matches!(ty, Type::Matrix { .. })
}

impl MemberLayout {
    pub(crate) fn matrix_layout(&self) -> MatrixLayout {
        if self.row_major { MatrixLayout::Row } else { MatrixLayout::Column }
    }
}

impl BlockLayout {
    /// Returns the bytes of the block that hold components; the rest of [`size`](Self::size) is
    /// padding. A runtime-sized dimension counts as one element.
    pub fn used(&self) -> u64 {
        self.leaves.iter().map(|leaf| occupied(&leaf.ty) * measure::elements(&leaf.dims)).sum()
    }

    /// Splits off the runtime-sized array at the end, if there is one.
    pub fn split_tail(&self) -> (&[MemberLayout], Option<&MemberLayout>) {
        match self.members.split_last() {
            Some((last, rest)) if last.dims.first() == Some(&ArrayLen::Runtime) => {
                (rest, Some(last))
            }
            _ => (&self.members, None),
        }
    }
}
