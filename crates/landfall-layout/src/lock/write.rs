//! Writes a lock: JSON that changes only with the layout, one member per line.
//!
//! [`super::read`] reads it back. The keys are those of the layout's JSON, without lines, tools
//! and paths.

mod lines;
mod variants;

use serde::Serialize;

use super::{FIRST_SCHEMA_VERSION, Lock, SCHEMA_VERSION, Verified};
use crate::ShaderLayout;
use crate::layout::measure::fixed_elements;
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::{AddressSpace, Type};
use crate::source::{Language, Target};
use variants::AllBlocks;

/// The layout of one shader's blocks, to be committed: it changes only with the layout. Keys have
/// the meaning they have in `landfall layout --format json`; numbers are bytes unless stated
/// otherwise, and absent keys do not apply.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LockDocument<'a> {
    /// 2 with variants, 1 without.
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = [FIRST_SCHEMA_VERSION, SCHEMA_VERSION]))
    )]
    schema_version: u32,
    language: Language,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    /// The sets of macros of `permutations` in the configuration under which the shader has other
    /// blocks than without them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(length(min = 1), extend("uniqueItems" = true)))]
    variants: Vec<MacroTexts>,
    /// Blocks in source order, those of the shader without macros of `variants` first; loose uniforms
    /// come last. Blocks that several variants have alike are listed once.
    blocks: Vec<RecordedBlock<'a>>,
    /// The devices on which the layout was verified; dropped when the layout changes.
    #[serde(skip_serializing_if = "<[Verified]>::is_empty")]
    verified: &'a [Verified],
}

/// Macros as in `permutations`: `NAME`, or `NAME=TEXT`.
#[derive(Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct MacroTexts(Vec<String>);

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RecordedBlock<'a> {
    /// uniform NAME { ... }; in WGSL the structure's name, or the variable's if it has none.
    name: &'a str,
    /// The variants that have it, the empty set being the shader without macros of `variants`; absent
    /// if all have it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(length(min = 1), extend("uniqueItems" = true)))]
    variants: Vec<MacroTexts>,
    /// The name of the instance or variable.
    #[serde(skip_serializing_if = "Option::is_none")]
    instance: Option<&'a str>,
    /// The address space; default for loose uniforms.
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = super::SPACES.map(AddressSpace::name)))
    )]
    address_space: &'static str,
    /// The layout rules; absent for loose uniforms. Those of a SPIR-V module are found from its
    /// numbers: relaxed (Vulkan's relaxed block layout) and d3d (Direct3D's packing) are kept to,
    /// explicit follows none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = crate::shape::Rules::ALL.map(crate::shape::Rules::name)))
    )]
    rules: Option<&'static str>,
    /// Whether the shader or its language specifies these rules; if not, the driver's offsets may
    /// differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    rules_declared: Option<bool>,
    /// set = N, @group(N).
    #[serde(skip_serializing_if = "Option::is_none")]
    group: Option<u32>,
    /// binding = N, @binding(N).
    #[serde(skip_serializing_if = "Option::is_none")]
    binding: Option<u32>,
    /// The number of buffers of an array of blocks; null if the shader does not specify it, absent for
    /// a single block.
    #[serde(skip_serializing_if = "Option::is_none")]
    count: Option<BufferCount>,
    /// Bytes a buffer must hold, a runtime-sized tail counted with one element.
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<u64>,
    /// The end of the last member.
    #[serde(skip_serializing_if = "Option::is_none")]
    data_size: Option<u64>,
    /// The largest alignment of a member.
    #[serde(skip_serializing_if = "Option::is_none")]
    align: Option<u64>,
    /// In source order.
    members: Vec<RecordedMember<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct BufferCount(Option<u64>);

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RecordedMember<'a> {
    name: &'a str,
    /// The type in the shader's language.
    #[serde(rename = "type")]
    ty: String,
    /// Bytes from the start of the enclosing block or structure.
    #[serde(skip_serializing_if = "Option::is_none")]
    offset: Option<u64>,
    /// The bytes it occupies; absent if runtime-sized.
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<u64>,
    /// The alignment: its offset is a multiple of this.
    #[serde(skip_serializing_if = "Option::is_none")]
    align: Option<u64>,
    /// Bytes from one element to the next, for each dimension, outermost first.
    #[serde(skip_serializing_if = "<[u64]>::is_empty")]
    strides: &'a [u64],
    /// The matrix stride: bytes from one column to the next, or from one row to the next if row_major.
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix_stride: Option<u64>,
    /// Whether its matrices are row-major; only on matrices.
    #[serde(skip_serializing_if = "Option::is_none")]
    row_major: Option<bool>,
    /// The members of its structure, with offsets from the start of one element.
    #[serde(skip_serializing_if = "Option::is_none")]
    members: Option<Vec<RecordedMember<'a>>>,
}

/// The schema of [`LOCK_SCHEMA`](super::LOCK_SCHEMA).
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    crate::schema::text::<LockDocument<'_>>("landfall lock")
}

/// The text of a shader's lock, without verified devices.
pub fn write(shader: &ShaderLayout) -> String {
    document(shader, &[])
}

/// The text of a shader's lock that replaces `old`, keeping its verified devices if the layout is
/// unchanged.
pub fn renew(shader: &ShaderLayout, old: Option<&Lock>) -> String {
    let text = write(shader);
    // Verified bytes were those of the layout: another layout has not been verified.
    match old {
        Some(old) if !old.verified.is_empty() && old.text_without_devices() == text => {
            document(shader, &old.verified)
        }
        Some(_) | None => text,
    }
}

pub(super) fn document(shader: &ShaderLayout, verified: &[Verified]) -> String {
    let AllBlocks { sets, blocks } = AllBlocks::from_shader(shader);
    lines::text(&LockDocument {
        // A lock without variants is readable by every landfall.
        schema_version: if sets.is_empty() { FIRST_SCHEMA_VERSION } else { SCHEMA_VERSION },
        language: shader.language,
        assumed_target: shader.assumed_target,
        variants: sets,
        blocks,
        verified,
    })
}

impl<'a> RecordedBlock<'a> {
    /// A block that all variants have.
    fn new(block: &'a BlockLayout, language: Language) -> RecordedBlock<'a> {
        let declares = block.space != AddressSpace::Default;
        let members = block.members.iter();
        RecordedBlock {
            name: &block.name,
            variants: Vec::new(),
            instance: block.instance.as_deref(),
            address_space: block.space.name(),
            rules: declares.then(|| block.rules.name()),
            rules_declared: declares.then_some(block.rules_declared),
            group: block.group,
            binding: block.binding,
            // Most blocks are no arrays, and have no line for it.
            count: Some(BufferCount(fixed_elements(&block.count))).filter(|n| n.0 != Some(1)),
            size: block.size,
            data_size: block.data_size,
            align: block.align,
            members: members.map(|member| RecordedMember::new(member, language)).collect(),
        }
    }
}

impl<'a> RecordedMember<'a> {
    fn new(member: &'a MemberLayout, language: Language) -> RecordedMember<'a> {
        let ty = member.ty.innermost();
        let members = || member.members.iter().map(|inner| RecordedMember::new(inner, language));
        RecordedMember {
            name: &member.name,
            ty: member.ty.spelled(language).to_string(),
            offset: member.offset,
            size: member.size,
            align: member.align,
            strides: &member.strides,
            matrix_stride: member.matrix_stride,
            row_major: matches!(ty, Type::Matrix { .. }).then_some(member.row_major),
            members: matches!(ty, Type::Struct(_)).then(|| members().collect()),
        }
    }
}
