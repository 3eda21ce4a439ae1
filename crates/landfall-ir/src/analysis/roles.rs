//! Finds the structures that are lights, their kinds, and the roles of their members.
//!
//! Inferred from names, types and nesting alone, without scenes or functions. Reads
//! [`shape`](landfall_layout::shape) and [`layout`](mod@landfall_layout::layout); used by the
//! binding map, the report of `landfall lights`, and the lints of lights.

mod count;
mod evidence;
mod names;

use std::sync::Arc;

use self::count::{count_of, counts};
use self::evidence::{Evidence, RoleEvidence, classify};
use self::names::{is_about_something_else, is_light};
use super::identifier::identifier_words;
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::named;
use landfall_layout::shape::{ArrayLen, Struct, Type};
use landfall_layout::source::Span;

pub use names::role;

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Kind {
        /// Light from everywhere.
        Ambient = "ambient",
        /// Light of one direction.
        Directional = "directional",
        /// Light from a point.
        Point = "point",
        /// Light from a point, inside a cone.
        Spot = "spot",
        /// The kind is a member's value at run time, or unknown.
        Tagged = "tagged",
    }
}

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum Role {
        Position = "position",
        /// The direction of the light's travel or its opposite: names do not tell which.
        Direction = "direction",
        Color = "color",
        /// The colour, or strength if it is a scalar, of the light's ambient term.
        Ambient = "ambient",
        /// The colour, or strength, of the diffuse term.
        Diffuse = "diffuse",
        /// The colour, or strength, of the specular term.
        Specular = "specular",
        /// The factor of the colours.
        Intensity = "intensity",
        Constant = "constant",
        /// The coefficient of attenuation by distance.
        Linear = "linear",
        /// The coefficient of attenuation by squared distance.
        Quadratic = "quadratic",
        /// The three coefficients in one vector.
        Attenuation = "attenuation",
        /// The distance at which the light ends.
        Range = "range",
        /// The angle, or cosine, within which a spot light has full strength.
        InnerCone = "inner_cone",
        /// The angle, or cosine, outside which a spot light has no effect.
        OuterCone = "outer_cone",
        /// The only angle, or cosine, of the cone.
        Cone = "cone",
        /// The power of the fall-off in a cone.
        ConeExponent = "cone_exponent",
        /// The kind of light as a number.
        Kind = "kind",
        Enabled = "enabled",
    }
}

impl Role {
    /// Returns whether it is an angle of a cone, or its cosine.
    pub fn is_cone(self) -> bool {
        matches!(self, Role::InnerCone | Role::OuterCone | Role::Cone)
    }

    /// Returns whether it is a coefficient of attenuation or a range.
    pub fn is_attenuation(self) -> bool {
        matches!(self, Role::Constant | Role::Linear | Role::Quadratic | Role::Attenuation)
    }

    /// Returns whether it is a colour or an intensity.
    pub fn is_emission(self) -> bool {
        use Role::*;
        matches!(self, Color | Ambient | Diffuse | Specular | Intensity)
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The path from the structure: `position`, `pl.att.linear`.
    pub path: String,
    pub role: Role,
    pub ty: Type,
    pub span: Span,
}

/// A structure that is a light.
#[derive(Clone, Debug, PartialEq)]
pub struct Roles {
    /// The structure's name, or the block's; empty for a set of members.
    pub name: Arc<str>,
    pub kind: Kind,
    /// The members with a role, in the order of the text; at most one per role, the first.
    pub parts: Vec<Part>,
    /// The paths of members whose role is unknown.
    pub others: Vec<String>,
    pub span: Span,
}

impl Roles {
    pub fn part(&self, role: Role) -> Option<&Part> {
        self.parts.iter().find(|part| part.role == role)
    }

    fn any(&self, is: impl Fn(Role) -> bool) -> bool {
        self.parts.iter().any(|part| is(part.role))
    }
}

/// A place in a block that holds a light, or an array of them.
#[derive(Clone, Debug)]
pub struct LightBinding<'a> {
    pub block: &'a BlockLayout,
    /// The path in the block, with `[]` for indices: `data[]`, `light`; empty if the block itself
    /// is the light, or single members of it are.
    pub path: String,
    /// The form in which the block holds it.
    pub form: Form,
    /// The member that holds the structures.
    pub member: Option<&'a MemberLayout>,
    /// The array dimensions along the path, outermost first.
    pub dims: Vec<ArrayLen>,
    pub roles: Roles,
    /// The member that counts the used slots of the array.
    pub count: Option<Count<'a>>,
}

/// The form in which a block holds a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A structure, or an array of them.
    Structure,
    /// A block whose members are those of one light.
    Block,
    /// Members among others, found by their names: `lightPos`, `lightColor`, or arrays of these.
    Members,
}

#[derive(Clone, Copy, Debug)]
pub struct Count<'a> {
    pub block: &'a BlockLayout,
    /// The member, which is a direct member of the block.
    pub member: &'a MemberLayout,
}

impl LightBinding<'_> {
    /// Returns the number of slots of the array over all dimensions; 1 without an array, `None` if
    /// the text does not fix it.
    pub fn slots(&self) -> Option<u64> {
        self.dims.iter().try_fold(1u64, |slots, len| match len {
            ArrayLen::Fixed(n) => slots.checked_mul(u64::from(*n)),
            ArrayLen::Runtime | ArrayLen::Override(_) => None,
        })
    }

    /// Returns the path from the block to a member of the light: `data[].pos`.
    pub fn full_path(&self, part: &Part) -> String {
        if self.path.is_empty() {
            part.path.clone()
        } else {
            format!("{}.{}", self.path, part.path)
        }
    }
}

/// The most lights of a shader, which bounds the time on hostile texts.
const MAX_LIGHTS: usize = 256;

/// The most leaves of a structure that may be a light.
const MAX_LEAVES: u64 = 200;

/// Returns the roles of a structure's members, if it is a light.
pub fn of_struct(structure: &Struct) -> Option<Roles> {
    let leaves = structure.members.iter().fold(0u64, |sum, m| sum.saturating_add(m.ty.leaves()));
    // A material library or a scene in one structure is no light, and each leaf costs a look-up of
    // names.
    if leaves > MAX_LEAVES {
        return None;
    }
    let mut found = RoleEvidence::default();
    found.descend(&mut structure.members.iter().map(|m| (&*m.name, &m.ty, m.span)), "");
    // `struct Lights { Light data[8]; int count; }` holds lights, it is none.
    if found.holds_lights() {
        return None;
    }
    classify(&structure.name, found, structure.span, Evidence::Structure)
}

/// Returns every light in those blocks, in order.
pub fn lights_in_blocks(blocks: &[BlockLayout]) -> Vec<LightBinding<'_>> {
    let mut all = Vec::new();
    for block in blocks {
        let before = all.len();
        for member in &block.members {
            search(block, member, "", &[], &mut all);
        }
        // A block without structures of light may be a light itself, or have some members of one.
        if all.len() == before {
            all.extend(whole_block(block).or_else(|| members_alone(block)));
        }
    }
    all.truncate(MAX_LIGHTS);
    let counts = counts(blocks);
    for light in &mut all {
        light.count = count_of(light, &counts);
    }
    all
}

fn search<'a>(
    block: &'a BlockLayout,
    member: &'a MemberLayout,
    parent: &str,
    outer: &[ArrayLen],
    all: &mut Vec<LightBinding<'a>>,
) {
    let Type::Struct(structure) = member.ty.innermost() else { return };
    let path = format!("{parent}{}{}", member.name, "[]".repeat(member.dims.len()));
    let dims = [outer, &member.dims].concat();
    if let Some(roles) = of_struct(structure) {
        let form = Form::Structure;
        all.push(LightBinding {
            block,
            path,
            form,
            member: Some(member),
            dims,
            roles,
            count: None,
        });
        return;
    }
    for inner in &member.members {
        search(block, inner, &format!("{path}."), &dims, all);
    }
}

/// Returns a block whose members are those of one light.
fn whole_block(block: &BlockLayout) -> Option<LightBinding<'_>> {
    if block.leaves.len() as u64 > MAX_LEAVES {
        return None;
    }
    let mut found = RoleEvidence::default();
    found.descend(&mut block.members.iter().map(|m| (&*m.name, &m.ty, m.span)), "");
    let roles = classify(&block.name, found, block.span, Evidence::Block)?;
    let (path, dims) = (String::new(), Vec::new());
    Some(LightBinding { block, path, form: Form::Block, member: None, dims, roles, count: None })
}

/// Returns members of a block that belong to a light by their names.
fn members_alone(block: &BlockLayout) -> Option<LightBinding<'_>> {
    let of_light = |m: &&MemberLayout| {
        let words = identifier_words(&m.name);
        is_light(&words) && !is_about_something_else(&words)
    };
    let mut members: Vec<&MemberLayout> = block.members.iter().filter(of_light).collect();
    // `lightType` alone says nothing of a light.
    members.retain(|m| role(&m.name, m.ty.innermost()).is_some_and(|role| role != Role::Kind));
    // Arrays in parallel must be of one length: `vec3 lightPos[4], lightColor[4]`.
    let dims = members.first()?.dims.clone();
    members.retain(|m| m.dims == dims);
    let mut found = RoleEvidence::default();
    found.descend(&mut members.iter().map(|m| (&*m.name, &m.ty, m.span)), "");
    let span = members.first()?.span;
    let roles = classify("", found, span, Evidence::Members)?;
    let path = String::new();
    Some(LightBinding { block, path, form: Form::Members, member: None, dims, roles, count: None })
}
