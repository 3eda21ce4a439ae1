//! What the lights of a shader cost, and where their code may leave the numbers.
//!
//! Reads [`roles`](landfall_ir::analysis::roles), the layout, and what [`lint::hazards`](landfall_lint::hazards)
//! found by following the shader; [`lights`](crate::report::lights) prints it.

use std::sync::Arc;

use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::hazards::{Bound, Certainty};
use landfall_ir::analysis::roles::{Form, Held, Kind, Role, held};
use landfall_layout::finding::Finding;
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{AddressSpace, Majorness, Rules, Type};
use landfall_layout::source::Span;
use landfall_layout::{Diagnostic, Options, ShaderLayout, Source};
use landfall_lint::hazards::{analyse, finding};
pub use landfall_lint::smaller_order;

/// The lights of one shader.
#[derive(Clone, Debug)]
pub struct Report {
    /// Each light, or array of them, in the order of the blocks.
    pub lights: Vec<Light>,
    /// Hazards in the order of the text.
    pub hazards: Vec<Found>,
    /// Why its functions could not be followed; then there are no hazards and no loop bounds.
    pub unfollowed: Vec<Diagnostic>,
    /// Whether it was too long to be followed to its end.
    pub cut_short: bool,
}

/// A light or an array of them.
#[derive(Clone, Debug)]
pub struct Light {
    /// What kind.
    pub kind: Kind,
    /// The structure's name; the block's, or empty where members alone are the light.
    pub structure: Arc<str>,
    /// The block that holds it.
    pub block: Arc<str>,
    /// The block's instance.
    pub instance: Option<Arc<str>>,
    /// Where the block lives.
    pub space: AddressSpace,
    /// The rules it is laid out by.
    pub rules: Rules,
    /// Bytes of the block; `None` for loose uniforms.
    pub block_size: Option<u64>,
    /// The way to it: `data[]`.
    pub path: String,
    /// How it is held.
    pub form: Form,
    /// Its members that play a part.
    pub parts: Vec<Member>,
    /// The ways to its other members.
    pub others: Vec<String>,
    /// Bytes a light, from one to the next in an array; `None` for loose uniforms.
    pub bytes: Option<u64>,
    /// How many of them are padding.
    pub padding: Option<u64>,
    /// Slots; `None` where the text does not say.
    pub slots: Option<u64>,
    /// Whether it is an array.
    pub is_array: bool,
    /// The member that counts the slots in use.
    pub count: Option<CountMember>,
    /// What bounds the loops over it, each once, as far as they were followed.
    pub bounds: Vec<Bound>,
    /// A smaller order of the structure's members.
    pub reorder: Option<Reorder>,
    /// Its name in the text.
    pub span: Span,
}

/// A member of a light.
#[derive(Clone, Debug)]
pub struct Member {
    /// The way to it from the light.
    pub path: String,
    /// The part it plays.
    pub role: Role,
    /// Its type.
    pub ty: Type,
    /// From the start of the light; of the block where members alone are the light.
    pub offset: Option<u64>,
}

/// A member that counts lights.
#[derive(Clone, Debug)]
pub struct CountMember {
    /// Its name.
    pub name: Arc<str>,
    /// The block it is in.
    pub block: Arc<str>,
    /// Where in it.
    pub offset: Option<u64>,
}

/// A smaller order of members.
#[derive(Clone, Debug)]
pub struct Reorder {
    /// Their names in that order.
    pub order: Vec<Arc<str>>,
    /// Bytes a light then.
    pub bytes: u64,
}

/// A hazard with its words.
#[derive(Clone, Debug)]
pub struct Found {
    /// What may happen.
    pub hazard: Hazard,
    /// How sure it is that some input meets it.
    pub certainty: Certainty,
    /// Its lint, message, place and robust form.
    pub finding: Finding,
    /// The operation.
    pub span: Span,
}

/// What the lights of a shader cost; its layout has no errors.
pub fn cost(source: &Source, options: &Options, shader: &ShaderLayout) -> Report {
    let lights = held(&shader.blocks);
    let analysis = analyse(source, options, shader, &lights);
    let found = &analysis.found;
    let hazards = found.hazards.iter().map(|hazard| Found {
        hazard: hazard.hazard,
        certainty: hazard.certainty,
        finding: finding(hazard, &shader.files, shader.language),
        span: hazard.span,
    });
    let hazards = hazards.collect();
    let described = lights.iter().enumerate().map(|(number, light)| {
        let mut bounds: Vec<Bound> = Vec::new();
        for access in found.accesses.iter().filter(|access| access.light == number) {
            if !bounds.contains(&access.bound) {
                bounds.push(access.bound);
            }
        }
        describe(light, bounds)
    });
    Report {
        lights: described.collect(),
        hazards,
        unfollowed: analysis.unfollowed,
        cut_short: found.cut_short,
    }
}

fn describe(light: &Held<'_>, bounds: Vec<Bound>) -> Light {
    let block = light.block;
    let (bytes, padding) = match light.member {
        Some(member) => sizes(member),
        None if light.form == Form::Block => {
            (block.size, block.size.map(|size| size - used(&block.members).min(size)))
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

/// Bytes of one structure, and how many of them hold nothing.
fn sizes(member: &MemberLayout) -> (Option<u64>, Option<u64>) {
    let one = match member.strides.last() {
        Some(stride) => Some(*stride),
        None => member.size,
    };
    (one, one.map(|one| one - used(&member.members).min(one)))
}

/// Bytes of the scalars below.
fn used(members: &[MemberLayout]) -> u64 {
    let one = |member: &MemberLayout| {
        let scalars = match member.ty.innermost() {
            Type::Struct(_) => used(&member.members),
            Type::Scalar(scalar) | Type::Atomic(scalar) => u64::from(scalar.width),
            Type::Vector { scalar, rows } => u64::from(scalar.width) * u64::from(*rows),
            Type::Matrix { scalar, columns, rows } => {
                u64::from(scalar.width) * u64::from(*columns) * u64::from(*rows)
            }
            Type::Address(_) => 8,
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

/// Bytes a light of members that stand beside others.
fn members_size(block: &BlockLayout, light: &Held<'_>) -> Option<u64> {
    let of_light =
        |member: &&MemberLayout| light.roles.parts.iter().any(|part| part.span == member.span);
    block.members.iter().filter(of_light).try_fold(0, |sum: u64, member| {
        let one = member.strides.last().copied().or(member.size)?;
        sum.checked_add(one)
    })
}

fn parts(light: &Held<'_>) -> Vec<Member> {
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

/// Where a member is, by names alone.
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
    if block.space == AddressSpace::Default {
        return None;
    }
    let majorness = if member.row_major { Majorness::Row } else { Majorness::Column };
    let (order, bytes) = smaller_order(structure, block.rules, majorness)?;
    Some(Reorder { order, bytes })
}
