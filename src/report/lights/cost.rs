//! The cost of the lights in a shader, and the numerical hazards of its code.
//!
//! Combines [`roles`](landfall_ir::analysis::roles), the layout and the findings of
//! [`hazard_findings`](landfall_lint::hazard_findings); [`lights`](crate::report::lights) prints it.

use serde::{Serialize, Serializer};

use landfall_ir::Module;
use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::occurrence::{Access, Certainty, IndexBound};
use landfall_ir::analysis::roles::{Form, LightBinding, lights_in_blocks};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::{BlockLayout, MemberLayout};
#[cfg(feature = "schema")]
use landfall_layout::shape::Rules;
use landfall_layout::shape::{AddressSpace, MatrixLayout, Type};
use landfall_layout::source::{Language, Span};
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

// A light or an array of them.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "LightObject"))]
pub struct Light {
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = ["ambient", "directional", "point", "spot", "tagged"]))
    )]
    pub kind: &'static str,
    /// The form: a structure, all members of a block, or loose members.
    #[serde(serialize_with = "form_name")]
    #[cfg_attr(
        feature = "schema",
        schemars(with = "String", extend("enum" = ["structure", "block", "members"]))
    )]
    pub form: Form,
    /// The name of the structure or block; empty for loose members.
    pub structure: String,
    pub block: String,
    pub instance: Option<String>,
    pub address_space: AddressSpace,
    #[cfg_attr(feature = "schema", schemars(extend("enum" = Rules::ALL.map(Rules::name))))]
    pub rules: &'static str,
    /// The member path in the block, arrays as patterns.
    pub path: String,
    /// Whether it is an array of lights.
    pub array: bool,
    /// The array length over all dimensions; null if the source does not fix it.
    pub slots: Option<u64>,
    /// The stride from one light to the next; null for loose uniforms.
    pub bytes: Option<u64>,
    /// The bytes of padding in one light.
    pub padding: Option<u64>,
    pub block_size: Option<u64>,
    pub members: Vec<Member>,
    /// The members without a known role.
    pub others: Vec<String>,
    /// The member that holds the number of lights.
    pub count: Option<CountMember>,
    /// The distinct bounds of the indices.
    #[serde(serialize_with = "bound_objects")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<BoundObject>"))]
    pub bounds: Vec<IndexBound>,
    /// A smaller order of the members.
    pub reorder: Option<Reorder>,
}

// A member of a light with a role.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "MemberObject"))]
pub struct Member {
    /// The path relative to the light.
    pub path: String,
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = [
            "position", "direction", "color", "ambient", "diffuse", "specular", "intensity",
            "constant", "linear", "quadratic", "attenuation", "range", "inner_cone", "outer_cone",
            "cone", "cone_exponent", "kind", "enabled"
        ]))
    )]
    pub role: &'static str,
    #[serde(rename = "type")]
    pub ty: String,
    /// The offset in the light.
    pub offset: Option<u64>,
}

// A member that holds the number of lights.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "CountObject"))]
pub struct CountMember {
    pub name: String,
    pub block: String,
    pub offset: Option<u64>,
}

// A smaller order of a structure's members.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "ReorderObject"))]
pub struct Reorder {
    pub order: Vec<String>,
    /// The stride in that order.
    pub bytes: u64,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct BoundObject {
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = [
            "fixed", "constant", "clamped_count", "count", "length", "unknown"
        ]))
    )]
    kind: &'static str,
    /// The index, or the constant.
    value: Option<u64>,
}

/// Serialises the form of a light by its name.
fn form_name<S: Serializer>(form: &Form, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(match form {
        Form::Structure => "structure",
        Form::Block => "block",
        Form::Members => "members",
    })
}

/// Serialises the bounds of indices.
fn bound_objects<S: Serializer>(bounds: &[IndexBound], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(bounds.iter().map(|bound| BoundObject::new(*bound)))
}

impl BoundObject {
    fn new(bound: IndexBound) -> BoundObject {
        let (kind, value) = match bound {
            IndexBound::Fixed(index) => ("fixed", Some(index)),
            IndexBound::Constant(n) => ("constant", Some(n)),
            IndexBound::ClampedCount => ("clamped_count", None),
            IndexBound::Count => ("count", None),
            IndexBound::Length => ("length", None),
            IndexBound::Unknown => ("unknown", None),
        };
        BoundObject { kind, value }
    }
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
    let analysis = analyse(Module::unchecked(source, options), source, shader, &lights);
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
        .map(|(number, light)| describe(light, bounds(number, &found.accesses), shader.language));
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

fn describe(light: &LightBinding<'_>, bounds: Vec<IndexBound>, language: Language) -> Light {
    let block = light.block;
    let (bytes, padding) = match light.member {
        Some(member) => sizes(member),
        None if light.form == Form::Block => {
            (block.size, block.size.map(|size| size - scalar_bytes(&block.members).min(size)))
        }
        None => (members_size(block, light), None),
    };
    Light {
        kind: light.roles.kind.name(),
        form: light.form,
        structure: light.roles.name.to_string(),
        block: block.name.to_string(),
        instance: block.instance.as_ref().map(ToString::to_string),
        address_space: block.space,
        rules: block.rules.name(),
        path: light.path.clone(),
        array: !light.dims.is_empty(),
        slots: light.slots(),
        bytes,
        padding,
        block_size: block.size,
        members: parts(light, language),
        others: light.roles.others.clone(),
        count: light.count.map(|count| CountMember {
            name: count.member.name.to_string(),
            block: count.block.name.to_string(),
            offset: count.member.offset,
        }),
        bounds,
        reorder: light.member.and_then(|member| reorder(member, block)),
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

fn parts(light: &LightBinding<'_>, language: Language) -> Vec<Member> {
    let inside = match light.member {
        Some(member) => &member.members,
        None => &light.block.members,
    };
    let parts = light.roles.parts.iter().map(|part| Member {
        path: part.path.clone(),
        role: part.role.name(),
        ty: part.ty.spelled(language).to_string(),
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
    Some(Reorder { order: order.iter().map(ToString::to_string).collect(), bytes })
}
