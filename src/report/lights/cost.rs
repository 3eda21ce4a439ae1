//! The cost of the lights in a shader, and the numerical hazards of its code.
//!
//! Combines [`roles`](landfall_ir::analysis::roles), the layout and the findings of
//! [`hazard_findings`](landfall_lint::hazard_findings); [`lights`](crate::report::lights) prints it.

use std::sync::Arc;

use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::occurrence::{Access, Certainty, IndexBound};
use landfall_ir::analysis::roles::{Form, Kind, LightBinding, Role, lights_in_blocks};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{AddressSpace, MatrixLayout, Rules, Type};
use landfall_layout::source::Span;
use landfall_layout::{Diagnostic, Options, ShaderLayout, Source};
use landfall_lint::hazard_findings::{analyse, finding, lint_of};
pub use landfall_lint::smaller_order;

/// The lights of one shader.
#[derive(Clone, Debug)]
pub struct Report {
    /// The lights and arrays of lights, in the order of the blocks.
    pub lights: Vec<Light>,
    /// The places where these lights are read.
    pub accesses: Vec<Access>,
    /// The hazards in source order.
    pub hazards: Vec<LightHazard>,
    /// The reasons why functions could not be analysed; if not empty, there are no hazards or loop
    /// bounds.
    pub unfollowed: Vec<Diagnostic>,
    /// Whether the analysis stopped early because the functions are too long.
    pub cut_short: bool,
}

/// A light or an array of them.
#[derive(Clone, Debug)]
pub struct Light {
    /// The kind of light.
    pub kind: Kind,
    /// The name of the structure or block; empty where loose members form the light.
    pub structure: Arc<str>,
    /// The block that contains it.
    pub block: Arc<str>,
    /// The instance name of the block.
    pub instance: Option<Arc<str>>,
    /// The address space of the block.
    pub space: AddressSpace,
    /// The layout rules of the block.
    pub rules: Rules,
    /// The size of the block in bytes; `None` for loose uniforms.
    pub block_size: Option<u64>,
    /// The member path: `data[]`.
    pub path: String,
    /// The form: a structure, a block or loose members.
    pub form: Form,
    /// The members with a role.
    pub parts: Vec<Member>,
    /// The paths of its other members.
    pub others: Vec<String>,
    /// The size of one light in bytes, the stride in an array; `None` for loose uniforms.
    pub bytes: Option<u64>,
    /// The bytes of padding in one light.
    pub padding: Option<u64>,
    /// The array length; `None` if the source does not fix it.
    pub slots: Option<u64>,
    /// Whether it is an array.
    pub is_array: bool,
    /// The member that counts the slots in use.
    pub count: Option<CountMember>,
    /// The distinct bounds of the loops over it, as far as they were analysed.
    pub bounds: Vec<IndexBound>,
    /// A smaller order of the structure's members, if there is one.
    pub reorder: Option<Reorder>,
    /// The span of its name in the source text.
    pub span: Span,
}

/// A member of a light.
#[derive(Clone, Debug)]
pub struct Member {
    /// The path relative to the light.
    pub path: String,
    /// The role of the member.
    pub role: Role,
    /// The type of the member.
    pub ty: Type,
    /// The byte offset in the light; in the block where loose members form the light.
    pub offset: Option<u64>,
}

/// A member that holds the number of lights.
#[derive(Clone, Debug)]
pub struct CountMember {
    /// The name of the member.
    pub name: Arc<str>,
    /// The block that contains it.
    pub block: Arc<str>,
    /// The byte offset in the block.
    pub offset: Option<u64>,
}

/// A smaller order of a structure's members.
#[derive(Clone, Debug)]
pub struct Reorder {
    /// The names of the members in that order.
    pub order: Vec<Arc<str>>,
    /// The size of one light in that order, in bytes.
    pub bytes: u64,
}

/// A hazard with its finding.
#[derive(Clone, Debug)]
pub struct LightHazard {
    /// The hazard.
    pub hazard: Hazard,
    /// The certainty that some input triggers it.
    pub certainty: Certainty,
    /// The finding: lint, message, place and the robust form.
    pub finding: Finding,
    /// The default level of its lint.
    pub level: Level,
    /// The span of the operation.
    pub span: Span,
}

/// Returns the cost of the lights of a shader whose layout has no errors.
pub fn cost(source: &Source, options: &Options, shader: &ShaderLayout) -> Report {
    let lights = lights_in_blocks(&shader.blocks);
    let analysis = analyse(source, options, shader, &lights);
    let found = &analysis.found;
    let hazards = found.hazards.iter().map(|hazard| LightHazard {
        hazard: hazard.hazard,
        certainty: hazard.certainty,
        finding: finding(hazard, &shader.files, shader.language),
        level: lint_of(hazard.kind).level,
        span: hazard.span,
    });
    let hazards = hazards.collect();
    let described = lights
        .iter()
        .enumerate()
        .map(|(number, light)| describe(light, bounds(number, &found.accesses)));
    Report {
        lights: described.collect(),
        accesses: found.accesses.clone(),
        hazards,
        unfollowed: analysis.unfollowed,
        cut_short: found.cut_short,
    }
}

/// Returns the distinct bounds of the indices of a light.
pub fn bounds<'a>(light: usize, accesses: impl IntoIterator<Item = &'a Access>) -> Vec<IndexBound> {
    let mut bounds: Vec<IndexBound> = Vec::new();
    for access in accesses.into_iter().filter(|access| access.light == light) {
        if !bounds.contains(&access.bound) {
            bounds.push(access.bound);
        }
    }
    bounds
}

fn describe(light: &LightBinding<'_>, bounds: Vec<IndexBound>) -> Light {
    let block = light.block;
    let (bytes, padding) = match light.member {
        Some(member) => sizes(member),
        None if light.form == Form::Block => {
            (block.size, block.size.map(|size| size - scalar_bytes(&block.members).min(size)))
        }
        None => (members_size(block, light), None),
    };
    Light {
        kind: light.roles.kind,
        structure: light.roles.name.clone(),
        block: block.name.clone(),
        instance: block.instance.clone(),
        space: block.space,
        rules: block.rules,
        block_size: block.size,
        path: light.path.clone(),
        form: light.form,
        parts: parts(light),
        others: light.roles.others.clone(),
        bytes,
        padding,
        slots: light.slots(),
        is_array: !light.dims.is_empty(),
        count: light.count.map(|count| CountMember {
            name: count.member.name.clone(),
            block: count.block.name.clone(),
            offset: count.member.offset,
        }),
        bounds,
        reorder: light.member.and_then(|member| reorder(member, block)),
        span: light.member.map_or(light.roles.span, |member| member.span),
    }
}

/// Returns the size of one structure in bytes, and the bytes of padding in it.
fn sizes(member: &MemberLayout) -> (Option<u64>, Option<u64>) {
    // The stride of the innermost array is the size of one light with its padding.
    let one = match member.strides.last() {
        Some(stride) => Some(*stride),
        None => member.size,
    };
    (one, one.map(|one| one - scalar_bytes(&member.members).min(one)))
}

/// Returns the bytes of all scalars in the members.
fn scalar_bytes(members: &[MemberLayout]) -> u64 {
    let one = |member: &MemberLayout| {
        let scalars = match member.ty.innermost() {
            Type::Struct(_) => scalar_bytes(&member.members),
            Type::Scalar(scalar) | Type::Atomic(scalar) => u64::from(scalar.width),
            Type::Vector { scalar, rows } => u64::from(scalar.width) * u64::from(*rows),
            Type::Matrix { scalar, columns, rows } => {
                u64::from(scalar.width) * u64::from(*columns) * u64::from(*rows)
            }
            Type::Address(_) => 8,
            // The innermost type is never an array.
            Type::Array { .. } => 0,
        };
        let elements = member.dims.iter().map(|len| match len {
            landfall_layout::shape::ArrayLen::Fixed(n) => u64::from(*n),
            landfall_layout::shape::ArrayLen::Runtime
            | landfall_layout::shape::ArrayLen::Override(_) => 1,
        });
        elements.fold(scalars, u64::saturating_mul)
    };
    members.iter().map(one).fold(0, u64::saturating_add)
}

/// Returns the bytes of a light that consists of loose members.
fn members_size(block: &BlockLayout, light: &LightBinding<'_>) -> Option<u64> {
    let of_light =
        |member: &&MemberLayout| light.roles.parts.iter().any(|part| part.span == member.span);
    block.members.iter().filter(of_light).try_fold(0, |sum: u64, member| {
        let one = member.strides.last().copied().or(member.size)?;
        sum.checked_add(one)
    })
}

fn parts(light: &LightBinding<'_>) -> Vec<Member> {
    let inside = match light.member {
        Some(member) => &member.members,
        None => &light.block.members,
    };
    let parts = light.roles.parts.iter().map(|part| Member {
        path: part.path.clone(),
        role: part.role,
        ty: part.ty.clone(),
        offset: offset_of(inside, &part.path),
    });
    parts.collect()
}

/// Returns the byte offset of a member path; indices are ignored.
fn offset_of(members: &[MemberLayout], path: &str) -> Option<u64> {
    let (first, rest) = match path.split_once('.') {
        Some((first, rest)) => (first, Some(rest)),
        None => (path, None),
    };
    let name = first.split('[').next().unwrap_or(first);
    let member = members.iter().find(|member| *member.name == *name)?;
    match rest {
        Some(rest) => Some(member.offset? + offset_of(&member.members, rest)?),
        None => member.offset,
    }
}

fn reorder(member: &MemberLayout, block: &BlockLayout) -> Option<Reorder> {
    let Type::Struct(structure) = member.ty.innermost() else { return None };
    // Loose uniforms have no layout that an order of members could make smaller.
    if block.space == AddressSpace::Default {
        return None;
    }
    let matrix_layout = if member.row_major { MatrixLayout::Row } else { MatrixLayout::Column };
    let (order, bytes) = smaller_order(structure, block.rules, matrix_layout)?;
    Some(Reorder { order, bytes })
}
