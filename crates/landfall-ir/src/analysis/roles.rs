//! Which structures are lights, what kind, and which member plays which part.
//!
//! Guessed from names, types and nesting alone: no scene and no function is looked at.
//! Reads [`shape`](landfall_layout::shape) and [`layout`](mod@landfall_layout::layout); feeds the binding map,
//! the report of `landfall lights`, and the lints of lights.

mod count;
mod judge;
mod names;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use self::count::{count_of, counts};
use self::judge::{Evidence, Found, judge};
use self::names::{is_about_something_else, is_light};
use super::words::words;
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{ArrayLen, Struct, Type};
use landfall_layout::source::Span;

pub use names::role;

/// What kind of light a structure holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Light from everywhere.
    Ambient,
    /// Light of one direction.
    Directional,
    /// Light from a point.
    Point,
    /// Light from a point, inside a cone.
    Spot,
    /// A member says at run time which, or no name does.
    Tagged,
}

impl Kind {
    /// The word messages and JSON use.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Ambient => "ambient",
            Kind::Directional => "directional",
            Kind::Point => "point",
            Kind::Spot => "spot",
            Kind::Tagged => "tagged",
        }
    }
}

/// The part a member plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Role {
    /// Where the light is.
    Position,
    /// Where it travels, or where it comes from: names do not tell.
    Direction,
    /// The one colour of its terms.
    Color,
    /// Colour, or strength if it is a scalar, of its own ambient term.
    Ambient,
    /// Colour, or strength, of the diffuse term.
    Diffuse,
    /// Colour, or strength, of the specular term.
    Specular,
    /// What colours are multiplied with.
    Intensity,
    /// Attenuation per nothing.
    Constant,
    /// Attenuation per distance.
    Linear,
    /// Attenuation per distance squared.
    Quadratic,
    /// The three of them in one vector.
    Attenuation,
    /// Where the light ends.
    Range,
    /// Inside this angle, or above this cosine, the light is whole.
    InnerCone,
    /// Outside this angle, or below this cosine, there is no light.
    OuterCone,
    /// The one angle, or cosine, of the cone.
    Cone,
    /// The power of the fall-off in a cone.
    ConeExponent,
    /// Which kind of light it is.
    Kind,
    /// Whether it shines.
    Enabled,
}

impl Role {
    /// The word messages and JSON use.
    pub fn name(self) -> &'static str {
        match self {
            Role::Position => "position",
            Role::Direction => "direction",
            Role::Color => "color",
            Role::Ambient => "ambient",
            Role::Diffuse => "diffuse",
            Role::Specular => "specular",
            Role::Intensity => "intensity",
            Role::Constant => "constant",
            Role::Linear => "linear",
            Role::Quadratic => "quadratic",
            Role::Attenuation => "attenuation",
            Role::Range => "range",
            Role::InnerCone => "inner_cone",
            Role::OuterCone => "outer_cone",
            Role::Cone => "cone",
            Role::ConeExponent => "cone_exponent",
            Role::Kind => "kind",
            Role::Enabled => "enabled",
        }
    }

    /// Whether it is an angle of a cone, or the cosine of one.
    pub fn is_cone(self) -> bool {
        matches!(self, Role::InnerCone | Role::OuterCone | Role::Cone)
    }

    /// Whether it says how the light weakens with distance.
    pub fn is_attenuation(self) -> bool {
        matches!(self, Role::Constant | Role::Linear | Role::Quadratic | Role::Attenuation)
    }

    /// Whether it says what the light sends out.
    pub fn is_emission(self) -> bool {
        use Role::*;
        matches!(self, Color | Ambient | Diffuse | Specular | Intensity)
    }
}

/// A member with its part.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The way to it from the structure: `position`, `pl.att.linear`.
    pub path: String,
    /// What it is for.
    pub role: Role,
    /// Its type.
    pub ty: Type,
    /// Its name in the text.
    pub span: Span,
}

/// A structure of a light.
#[derive(Clone, Debug, PartialEq)]
pub struct Roles {
    /// The structure's name, or the block's; empty for a set of members.
    pub name: Arc<str>,
    /// What it holds.
    pub kind: Kind,
    /// Its members with a part, in the order of the text; at most one a role, the first.
    pub parts: Vec<Part>,
    /// The ways to members whose part is unknown.
    pub others: Vec<String>,
    /// Its name in the text.
    pub span: Span,
}

impl Roles {
    /// The member of that role.
    pub fn part(&self, role: Role) -> Option<&Part> {
        self.parts.iter().find(|part| part.role == role)
    }

    fn any(&self, is: impl Fn(Role) -> bool) -> bool {
        self.parts.iter().any(|part| is(part.role))
    }
}

/// A place in a block that holds a light, or an array of them.
#[derive(Clone, Debug)]
pub struct Held<'a> {
    /// The block.
    pub block: &'a BlockLayout,
    /// The way to it in the block, arrays as patterns: `data[]`, `light`; empty where the block
    /// itself is the light, or where members on their own are.
    pub path: String,
    /// What it is.
    pub form: Form,
    /// The member that holds the structures.
    pub member: Option<&'a MemberLayout>,
    /// Array dimensions on the way, outermost first.
    pub dims: Vec<ArrayLen>,
    /// Its parts.
    pub roles: Roles,
    /// The member that says how many slots of the array are used.
    pub count: Option<Count<'a>>,
}

/// How a light is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A structure, or an array of them.
    Structure,
    /// The members of a block are those of one light.
    Block,
    /// Members beside others, found by their names: `lightPos`, `lightColor`, or an array each.
    Members,
}

/// A member that counts lights.
#[derive(Clone, Copy, Debug)]
pub struct Count<'a> {
    /// The block it is in.
    pub block: &'a BlockLayout,
    /// It; a member of the block itself.
    pub member: &'a MemberLayout,
}

impl Held<'_> {
    /// Slots of the array through all dimensions; 1 without one, `None` if the text does not say.
    pub fn slots(&self) -> Option<u64> {
        self.dims.iter().try_fold(1u64, |slots, len| match len {
            ArrayLen::Fixed(n) => slots.checked_mul(u64::from(*n)),
            ArrayLen::Runtime | ArrayLen::Override(_) => None,
        })
    }

    /// The way from the block to one of its parts: `data[].pos`.
    pub fn full_path(&self, part: &Part) -> String {
        if self.path.is_empty() {
            part.path.clone()
        } else {
            format!("{}.{}", self.path, part.path)
        }
    }
}

/// Lights of one shader at most; a text made to take long has more.
const MOST_LIGHTS: usize = 256;

/// A structure with more leaves is no light.
const MOST_LEAVES: u64 = 200;

/// The parts of a structure, if it is a light.
pub fn of_struct(structure: &Struct) -> Option<Roles> {
    let leaves = structure.members.iter().fold(0u64, |sum, m| sum.saturating_add(m.ty.leaves()));
    if leaves > MOST_LEAVES {
        return None;
    }
    let mut found = Found::default();
    found.descend(&mut structure.members.iter().map(|m| (&*m.name, &m.ty, m.span)), "");
    if found.holds_lights() {
        return None;
    }
    judge(&structure.name, found, structure.span, Evidence::Structure)
}

/// Every light of those blocks, in their order.
pub fn held(blocks: &[BlockLayout]) -> Vec<Held<'_>> {
    let mut all = Vec::new();
    for block in blocks {
        let before = all.len();
        for member in &block.members {
            search(block, member, "", &[], &mut all);
        }
        if all.len() == before {
            all.extend(whole_block(block).or_else(|| members_alone(block)));
        }
    }
    all.truncate(MOST_LIGHTS);
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
    all: &mut Vec<Held<'a>>,
) {
    let Type::Struct(structure) = member.ty.innermost() else { return };
    let path = format!("{parent}{}{}", member.name, "[]".repeat(member.dims.len()));
    let dims = [outer, &member.dims].concat();
    if let Some(roles) = of_struct(structure) {
        let form = Form::Structure;
        all.push(Held { block, path, form, member: Some(member), dims, roles, count: None });
        return;
    }
    for inner in &member.members {
        search(block, inner, &format!("{path}."), &dims, all);
    }
}

/// A block whose members are those of one light.
fn whole_block(block: &BlockLayout) -> Option<Held<'_>> {
    if block.leaves.len() as u64 > MOST_LEAVES {
        return None;
    }
    let mut found = Found::default();
    found.descend(&mut block.members.iter().map(|m| (&*m.name, &m.ty, m.span)), "");
    let roles = judge(&block.name, found, block.span, Evidence::Block)?;
    let (path, dims) = (String::new(), Vec::new());
    Some(Held { block, path, form: Form::Block, member: None, dims, roles, count: None })
}

/// Members of a block that say by their names that they are a light's.
fn members_alone(block: &BlockLayout) -> Option<Held<'_>> {
    let of_light = |m: &&MemberLayout| {
        let words = words(&m.name);
        is_light(&words) && !is_about_something_else(&words)
    };
    let mut members: Vec<&MemberLayout> = block.members.iter().filter(of_light).collect();
    members.retain(|m| role(&m.name, m.ty.innermost()).is_some_and(|role| role != Role::Kind));
    let dims = members.first()?.dims.clone();
    members.retain(|m| m.dims == dims);
    let mut found = Found::default();
    found.descend(&mut members.iter().map(|m| (&*m.name, &m.ty, m.span)), "");
    let span = members.first()?.span;
    let roles = judge("", found, span, Evidence::Members)?;
    let path = String::new();
    Some(Held { block, path, form: Form::Members, member: None, dims, roles, count: None })
}
