//! Which structures are lights, what kind, and which member plays which part.
//!
//! Guessed from names, types and nesting alone: no scene and no function is looked at.
//! Reads [`shape`](crate::shape) and [`layout`](crate::layout); feeds the binding map,
//! [`cost`](super::cost), and the lints of lights.

use std::sync::Arc;

use super::words::words;
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::{ArrayLen, ScalarKind, Struct, Type};
use crate::source::Span;

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
    for light in &mut all {
        light.count = count_of(light, blocks);
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

/// The members of a structure and of those in it, with the parts they play.
#[derive(Default)]
struct Found {
    parts: Vec<Part>,
    others: Vec<String>,
    /// Structures in it that are lights themselves, and arrays of structures.
    lights: usize,
    arrays: usize,
    /// Parts that are its own and not of a structure in it.
    own: usize,
}

impl Found {
    fn descend<'m>(
        &mut self,
        members: &mut dyn Iterator<Item = (&'m str, &'m Type, Span)>,
        parent: &str,
    ) {
        for (name, ty, span) in members {
            let path = format!("{parent}{name}");
            match ty.innermost() {
                Type::Struct(inner) => {
                    if !ty.dims().is_empty() {
                        self.arrays += 1;
                        continue;
                    }
                    let is_light = parent.is_empty() && of_struct(inner).is_some();
                    self.lights += usize::from(is_light);
                    let mut below = inner.members.iter().map(|m| (&*m.name, &m.ty, m.span));
                    self.descend(&mut below, &format!("{path}."));
                }
                leaf => match role(name, leaf) {
                    Some(role) => {
                        self.own += usize::from(parent.is_empty());
                        let path = format!("{path}{}", "[]".repeat(ty.dims().len()));
                        self.parts.push(Part { path, role, ty: leaf.clone(), span });
                    }
                    None => self.others.push(path),
                },
            }
        }
    }

    /// Whether it is no light but something around lights.
    fn holds_lights(&self) -> bool {
        self.arrays > 0 || self.lights > 1 || (self.lights == 1 && self.own == 0)
    }
}

/// What besides its members speaks for a light.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Evidence {
    Structure,
    Block,
    Members,
}

fn judge(name: &str, found: Found, span: Span, evidence: Evidence) -> Option<Roles> {
    let said = words(name);
    if evidence != Evidence::Members && is_about_something_else(&said) {
        return None;
    }
    let Found { mut parts, mut others, lights, .. } = found;
    agree_on_cones(&mut parts);
    agree_on_quadratic(&mut parts);
    keep_first(&mut parts, &mut others);
    let mut roles = Roles { name: Arc::from(name), kind: Kind::Tagged, parts, others, span };
    let placed = roles.any(|r| matches!(r, Role::Position | Role::Direction));
    let shines = roles.any(Role::is_emission);
    let weakens = roles.any(|r| r.is_attenuation() || r.is_cone());
    let named = is_light(&said);
    let ambient = said.iter().any(|word| word == "ambient");
    let is_one = match evidence {
        Evidence::Structure => {
            (named && (shines || placed) && (placed || shines || lights > 0))
                || (ambient && shines && !placed)
                || (placed && shines && weakens)
        }
        Evidence::Block => (named && shines && placed) || (ambient && shines && !placed),
        Evidence::Members => placed,
    };
    // A structure of scalars that only says how strong something is would be anything.
    let colour = roles
        .parts
        .iter()
        .any(|p| p.role.is_emission() && matches!(p.ty, Type::Vector { rows: 3 | 4, .. }));
    if !is_one || !(colour || placed) {
        return None;
    }
    roles.kind = kind(&said, &roles);
    Some(roles)
}

fn kind(said: &[String], roles: &Roles) -> Kind {
    let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
    let has = |role| roles.part(role).is_some();
    if says(&["ambient"]) && !has(Role::Position) && !has(Role::Direction) {
        return Kind::Ambient;
    }
    if says(&["spot", "spotlight", "cone", "torch", "flashlight"]) {
        return Kind::Spot;
    }
    if says(&["dir", "direct", "directional", "sun", "sunlight", "parallel"]) {
        return Kind::Directional;
    }
    if says(&["point", "omni", "omnidirectional"]) {
        return Kind::Point;
    }
    if has(Role::Kind) && has(Role::Position) && has(Role::Direction) {
        return Kind::Tagged;
    }
    if roles.any(Role::is_cone) {
        Kind::Spot
    } else if has(Role::Position) {
        Kind::Point
    } else if has(Role::Direction) {
        Kind::Directional
    } else if says(&["hemi", "hemisphere"]) {
        Kind::Ambient
    } else {
        Kind::Tagged
    }
}

/// One angle beside an inner or outer one is the other.
fn agree_on_cones(parts: &mut [Part]) {
    let has = |role| parts.iter().any(|p: &Part| p.role == role);
    let (inner, outer) = (has(Role::InnerCone), has(Role::OuterCone));
    for part in parts.iter_mut().filter(|p| p.role == Role::Cone) {
        if outer && !inner {
            part.role = Role::InnerCone;
        } else if inner && !outer {
            part.role = Role::OuterCone;
        }
    }
}

/// An exponent beside a constant and a linear coefficient is the quadratic one.
fn agree_on_quadratic(parts: &mut [Part]) {
    let has = |role| parts.iter().any(|p: &Part| p.role == role);
    let (linear, quadratic) = (has(Role::Linear), has(Role::Quadratic));
    if linear && !quadratic {
        if let Some(part) = parts.iter_mut().find(|p| p.role == Role::ConeExponent) {
            part.role = Role::Quadratic;
        }
    }
}

/// Of several members of one role the first plays it.
fn keep_first(parts: &mut Vec<Part>, others: &mut Vec<String>) {
    let mut kept: Vec<Part> = Vec::with_capacity(parts.len());
    for part in parts.drain(..) {
        if kept.iter().any(|known| known.role == part.role) {
            others.push(part.path);
        } else {
            kept.push(part);
        }
    }
    *parts = kept;
}

/// The role a member has by its name and type.
pub fn role(name: &str, ty: &Type) -> Option<Role> {
    let said = words(name);
    let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
    let elsewhere = ["view", "camera", "cam", "eye", "map", "matrix", "space", "texture", "uv"];
    if says(&elsewhere) || says(&["shadow", "index", "pad", "padding", "bias"]) {
        return None;
    }
    let term = || {
        if says(&["ambient", "amb", "ka"]) {
            Some(Role::Ambient)
        } else if says(&["diffuse", "diff", "kd"]) {
            Some(Role::Diffuse)
        } else if says(&["specular", "spec", "ks"]) {
            Some(Role::Specular)
        } else {
            None
        }
    };
    match ty {
        Type::Vector { scalar, rows } if scalar.kind == ScalarKind::Float && *rows >= 3 => {
            if says(&["pos", "position", "positions", "location", "origin", "center", "centre"]) {
                Some(Role::Position)
            } else if says(&["dir", "dirs", "direction", "directions", "axis", "forward"]) {
                Some(Role::Direction)
            } else if says(&["attenuation", "atten", "att", "falloff"]) {
                Some(Role::Attenuation)
            } else if let Some(role) = term() {
                Some(role)
            } else if says(&["color", "colors", "colour", "colours", "col", "rgb", "tint"])
                || says(&["radiance", "emission", "intensity", "la", "ld", "l"])
            {
                Some(Role::Color)
            } else {
                None
            }
        }
        Type::Scalar(scalar) if scalar.kind == ScalarKind::Float => {
            if says(&["range", "radius", "distance", "reach"]) {
                Some(Role::Range)
            } else if says(&["constant", "const", "kc"]) {
                Some(Role::Constant)
            } else if says(&["linear", "lin", "kl"]) {
                Some(Role::Linear)
            } else if says(&["quadratic", "quad", "kq"]) {
                Some(Role::Quadratic)
            } else if says(&["exponent", "exp"]) {
                Some(Role::ConeExponent)
            } else if says(&["outer", "umbra"]) {
                Some(Role::OuterCone)
            } else if says(&["inner", "penumbra"]) {
                Some(Role::InnerCone)
            } else if says(&["cutoff", "cone", "angle", "phi", "theta", "hotspot"]) {
                Some(Role::Cone)
            } else if let Some(role) = term() {
                Some(role)
            } else if says(&["intensity", "strength", "power", "energy", "brightness", "factor"])
                || says(&["lumens", "lumen", "candela", "lux", "flux", "luminance"])
            {
                Some(Role::Intensity)
            } else if says(&["type", "kind"]) {
                Some(Role::Kind)
            } else if says(&["enabled", "enable", "active", "on"]) {
                Some(Role::Enabled)
            } else {
                None
            }
        }
        Type::Scalar(_) => {
            if says(&["type", "kind", "mode"]) {
                Some(Role::Kind)
            } else if says(&["enabled", "enable", "active", "on", "visible"]) {
                Some(Role::Enabled)
            } else {
                None
            }
        }
        Type::Vector { .. }
        | Type::Atomic(_)
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => None,
    }
}

fn is_light(said: &[String]) -> bool {
    let light = ["light", "lights", "lamp", "lamps", "sun", "spotlight", "sunlight", "flashlight"];
    said.iter().any(|word| light.contains(&word.as_str()))
}

/// Whether a name speaks of light without being a light's.
fn is_about_something_else(said: &[String]) -> bool {
    let other = [
        "material", "camera", "vertex", "probe", "grid", "cluster", "tile", "map", "shadow",
        "shadows", "cascade", "volume", "surface", "ray", "hit", "result", "lighting",
    ];
    said.iter().any(|word| other.contains(&word.as_str()))
}

/// The whole number beside an array of lights, or in another block, that counts them.
fn count_of<'a>(light: &Held<'a>, blocks: &'a [BlockLayout]) -> Option<Count<'a>> {
    if light.dims.is_empty() {
        return None;
    }
    let own = [light.roles.name.as_ref(), &light.path, light.block.name.as_ref()].map(words);
    let kinds = ["point", "spot", "directional", "dir", "area"];
    let mut best: Option<(u32, Count<'a>)> = None;
    for block in blocks {
        let beside = std::ptr::eq(block, light.block);
        for member in block.members.iter().filter(|m| is_whole_number(m)) {
            let said = words(&member.name);
            if !says_count(&said) {
                continue;
            }
            // `numSpotLights` does not count point lights.
            let foreign = said.iter().filter(|w| kinds.contains(&w.as_str()));
            if foreign.clone().any(|w| !own.iter().flatten().any(|o| same_word(o, w))) {
                continue;
            }
            let is_light = is_light(&said);
            let shared = said.iter().filter(|w| own.iter().flatten().any(|o| same_word(o, w)));
            let shared = shared.count() as u32;
            if !beside && !is_light && shared == 0 {
                continue;
            }
            let score = 4 * u32::from(beside) + 2 * shared + u32::from(is_light);
            if best.as_ref().is_none_or(|(known, _)| *known < score) {
                best = Some((score, Count { block, member }));
            }
        }
    }
    best.map(|(_, count)| count)
}

fn is_whole_number(member: &MemberLayout) -> bool {
    match &member.ty {
        Type::Scalar(scalar) => matches!(scalar.kind, ScalarKind::Sint | ScalarKind::Uint),
        Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => false,
    }
}

fn says_count(said: &[String]) -> bool {
    let count = ["count", "num", "nr", "number", "amount", "used", "total", "length", "len", "n"];
    said.iter().any(|word| count.contains(&word.as_str()))
}

/// The same word, in singular or plural.
fn same_word(a: &str, b: &str) -> bool {
    a.trim_end_matches('s') == b.trim_end_matches('s')
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, Source, layout};

    /// Kind, path and parts of every light, as text.
    fn lights(name: &str, text: &str) -> Vec<String> {
        let shader = layout(&Source::new(name, text), &Options::default());
        assert!(shader.diagnostics.is_empty(), "{:?}", shader.diagnostics);
        let all = held(&shader.blocks);
        let line = |light: &Held<'_>| {
            let parts = light.roles.parts.iter().map(|p| format!("{}={}", p.path, p.role.name()));
            let count = light.count.map(|c| format!(" count {}", c.member.name));
            format!(
                "{} {} {}: {}{}",
                light.roles.kind.name(),
                light.block.name,
                light.path,
                parts.collect::<Vec<_>>().join(" "),
                count.unwrap_or_default(),
            )
        };
        all.iter().map(line).collect()
    }

    #[test]
    fn a_counted_array_of_point_lights() {
        let text = "#version 330\nstruct PointLight { vec3 pos; vec3 color; float intensity; \
                    float constant; float linear; float quadratic; };\n\
                    layout(std140) uniform B { PointLight data[128]; int actually_used_count; } u;\n\
                    void main() {}";
        assert_eq!(
            lights("a.frag", text),
            ["point B data[]: pos=position color=color intensity=intensity constant=constant \
              linear=linear quadratic=quadratic count actually_used_count"]
        );
    }

    #[test]
    fn a_light_in_a_light_lends_it_its_parts() {
        let text = "#version 330\nstruct Attenuation { float constant; float linear; float exponent; };\n\
                    struct PointLight { vec3 position; vec3 colour; float intensity; Attenuation att; };\n\
                    struct SpotLight { PointLight pl; vec3 conedir; float cutoff; };\n\
                    struct Material { vec4 ambient; vec4 diffuse; vec4 specular; float reflectance; };\n\
                    uniform Material material;\nuniform SpotLight spotLights[5];\n\
                    uniform int numPointLights;\nvoid main() {}";
        let all = lights("a.frag", text);
        assert_eq!(all.len(), 1, "{all:?}");
        assert!(
            all[0].starts_with("spot DefaultBlock spotLights[]:")
                || all[0].contains("spotLights[]:")
        );
        for part in [
            "pl.position=position",
            "pl.att.exponent=quadratic",
            "conedir=direction",
            "cutoff=cone",
        ] {
            assert!(all[0].contains(part), "{part}: {}", all[0]);
        }
        assert!(!all[0].contains("count"), "counts another kind: {}", all[0]);
    }

    #[test]
    fn an_inner_and_an_outer_cone() {
        let text = "#version 330\nstruct SpotLight { vec3 position; vec3 direction; float cutOff; \
                    float outerCutOff; vec3 ambient; vec3 diffuse; vec3 specular; };\n\
                    uniform SpotLight spotLight;\nvoid main() {}";
        let all = lights("a.frag", text);
        assert!(all[0].contains("cutOff=inner_cone outerCutOff=outer_cone"), "{all:?}");
    }

    #[test]
    fn a_block_whose_members_are_a_light_and_members_named_after_one() {
        let block = "#version 330\nlayout(std140) uniform LightBlock { vec3 position; vec3 color; } light;\n\
                     void main() {}";
        assert_eq!(lights("a.frag", block), ["point LightBlock : position=position color=color"]);
        let wgsl = "struct Sun { direction: vec3f, color: vec3f }\n@group(0) @binding(0) var<uniform> sun: Sun;\n";
        assert_eq!(lights("a.wgsl", wgsl), ["directional Sun : direction=direction color=color"]);
        let loose = "#version 330\nuniform vec3 lightPos;\nuniform vec3 lightColor;\nuniform vec3 viewPos;\nvoid main() {}";
        let all = lights("a.frag", loose);
        assert!(all[0].ends_with(": lightPos=position lightColor=color"), "{all:?}");
    }

    #[test]
    fn materials_cameras_and_matrices_are_no_lights() {
        let text = "#version 330\nstruct Material { vec3 ambient; vec3 diffuse; vec3 specular; float shininess; };\n\
                    struct Particle { vec3 position; vec4 color; float radius_; };\n\
                    layout(std140) uniform Camera { mat4 view; vec3 position; } camera;\n\
                    layout(std140) uniform Shadow { mat4 lightSpaceMatrix; } shadow;\n\
                    uniform Material material;\nvoid main() {}";
        assert_eq!(lights("a.frag", text), Vec::<String>::new());
    }
}
