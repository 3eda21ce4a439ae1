//! Infers the binding map of a shader from its names, types and nesting, and from its code.
//!
//! [`roles`] finds the lights; this adds light counts, cameras,
//! materials, textures and inputs. Names do not tell whether a direction points towards the light
//! or whether a cone is a cosine: the code is searched for how they are used, which is a first
//! guess that [`decide`](mod@super::decide) tests by running the shader.

use super::quantity::{Kind, LightPart, MaterialPart, Quantity, Slot, TilePart};
use super::{BindError, BindingMap, BoundValue, Member, Source};
use landfall_exec::harness::fragments::{FragmentShader, Input, PIXEL};
use landfall_ir::analysis::identifier::identifier_words;
use landfall_ir::analysis::roles;
use landfall_ir::analysis::roles::{Form, LightBinding, Role};
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::{ScalarKind, Type};

/// Infers the map of a shader; `text` is its source.
///
/// # Errors
/// A shader without a member of a light.
pub fn infer(shader: &FragmentShader, path: &str, text: &str) -> Result<BindingMap, BindError> {
    let text = &WordTokens::new(text);
    let blocks: Vec<BlockLayout> =
        shader.blocks().iter().map(|block| block.layout.clone()).collect();
    // All members first, with unknown sources; then lights, then what belongs to none.
    let mut map = members(shader);
    lights(&blocks, text, &mut map);
    let leaf = |member: &Member| {
        let leaves = &blocks[member.block].leaves;
        leaves.iter().find(|leaf| leaf.path == member.path).expect("members were made of leaves")
    };
    for at in 0..map.members.len() {
        let member = &map.members[at];
        if member.source != Source::Unknown {
            continue;
        }
        if let Some(source) = other(leaf(member), &blocks[member.block]) {
            map.members[at].source = source;
        }
    }
    let textures: Vec<&str> = shader.textures().map(|handle| handle.path.as_str()).collect();
    let texture = |name: &&str| BoundValue {
        name: name.to_string(),
        source: texture(name, textures.len())
            .map_or(Source::Unknown, |part| Source::scene(Quantity::Material(part))),
    };
    map.textures = textures.iter().map(texture).collect();
    map.inputs = shader.inputs().iter().map(input).collect();
    // A shader without lights would render black, which is no answer.
    match map.lights() {
        true => Ok(map),
        false => Err(BindError::NoLights { shader: path.to_string() }),
    }
}

/// Returns the map of all members, with unknown sources.
pub fn members(shader: &FragmentShader) -> BindingMap {
    let mut map = BindingMap::default();
    for (number, block) in shader.blocks().iter().enumerate() {
        if !shader.reads(number) {
            continue;
        }
        let block = &block.layout;
        map.members.extend(block.leaves.iter().map(|leaf| Member {
            block: number,
            name: block.name.to_string(),
            gathered: block.gathered,
            path: leaf.path.clone(),
            source: Source::Unknown,
        }));
    }
    let unknown = |name: String| BoundValue { name, source: Source::Unknown };
    map.textures = shader.textures().map(|handle| unknown(handle.path.clone())).collect();
    map.inputs = shader.inputs().iter().map(|input| unknown(input.name.clone())).collect();
    map
}

fn lights(blocks: &[BlockLayout], text: &WordTokens<'_>, map: &mut BindingMap) {
    // Single lights of a kind are numbered in the order of the text.
    let mut singles = [0u32; 3];
    for held in roles::lights_in_blocks(blocks) {
        let number = blocks.iter().position(|block| std::ptr::eq(block, held.block));
        let number = number.expect("lights are held by the blocks that were asked");
        let kind = match held.roles.kind {
            roles::Kind::Ambient => {
                ambient(number, &held, map);
                continue;
            }
            roles::Kind::Directional => Kind::Directional,
            roles::Kind::Point => Kind::Point,
            roles::Kind::Spot => Kind::Spot,
            roles::Kind::Tagged => match by_parts(&held) {
                Some(kind) => kind,
                None => {
                    map.notes.push(format!("{}: the kind of light is unknown", name(&held)));
                    continue;
                }
            },
        };
        let slot = match held.dims.len() {
            0 => {
                let number = singles[kind as usize];
                singles[kind as usize] += 1;
                Slot::One(number)
            }
            1 => Slot::Each,
            _ => {
                map.notes.push(format!("{}: arrays of arrays are not bound", name(&held)));
                continue;
            }
        };
        let has = |role| held.roles.part(role).is_some();
        for part in &held.roles.parts {
            let light = |part| Source::scene(Quantity::Light { kind, slot, part });
            let source = match part.role {
                Role::Position => light(LightPart::Position),
                Role::Direction => {
                    // A name does not tell the sign; the code may: `-light.direction` negates what
                    // points away.
                    let negated = kind == Kind::Directional && text.is_towards(last(&part.path));
                    let part = LightPart::Direction;
                    Source::Scene { quantity: Quantity::Light { kind, slot, part }, negated }
                }
                // With an intensity beside it the colour is not yet multiplied.
                Role::Color if has(Role::Intensity) => light(LightPart::Color),
                Role::Color => light(LightPart::Radiance),
                Role::Intensity => light(LightPart::Intensity),
                Role::Ambient => light(LightPart::Ambient),
                Role::Diffuse => light(LightPart::Diffuse),
                Role::Specular => light(LightPart::Specular),
                Role::Constant => light(LightPart::Constant),
                Role::Linear => light(LightPart::Linear),
                Role::Quadratic => light(LightPart::Quadratic),
                Role::Attenuation => light(LightPart::Attenuation),
                Role::Range => light(range(last(&part.path))),
                Role::InnerCone => light(text.cone(last(&part.path), Edge::Inner)),
                Role::OuterCone | Role::Cone => light(text.cone(last(&part.path), Edge::Outer)),
                Role::Enabled => light(LightPart::Enabled),
                // A fall-off exponent or a kind has no counterpart in a scene.
                Role::ConeExponent | Role::Kind => continue,
            };
            let takes = |source: &Source| match source.quantity() {
                Some(Quantity::Light { kind, part, .. }) => kind.takes(part),
                _ => true,
            };
            // A cone of a point light, say, is left unknown.
            if takes(&source) {
                set(map, number, &held.full_path(part), source);
            }
        }
        if let Some(count) = held.count {
            let at = blocks.iter().position(|block| std::ptr::eq(block, count.block));
            let at = at.expect("counts are in the blocks that were asked");
            set(map, at, &count.member.name, Source::scene(Quantity::Count(kind)));
        }
    }
}

fn name(held: &LightBinding<'_>) -> String {
    match held.form {
        Form::Structure => format!("`{}.{}`", held.block.name, held.path),
        Form::Block | Form::Members => format!("`{}`", held.block.name),
    }
}

/// Returns the kind of a light whose name does not tell it.
fn by_parts(held: &LightBinding<'_>) -> Option<Kind> {
    let has = |role| held.roles.part(role).is_some();
    if has(Role::Kind) {
        return None;
    }
    match (has(Role::Position), has(Role::Direction)) {
        (true, true) => Some(Kind::Spot),
        (true, false) => Some(Kind::Point),
        (false, true) => Some(Kind::Directional),
        (false, false) => None,
    }
}

fn ambient(block: usize, held: &LightBinding<'_>, map: &mut BindingMap) {
    let has = |role| held.roles.part(role).is_some();
    for part in &held.roles.parts {
        let part_of = match part.role {
            Role::Color | Role::Ambient if has(Role::Intensity) => LightPart::Color,
            Role::Color | Role::Ambient => LightPart::Radiance,
            Role::Intensity => LightPart::Intensity,
            _ => continue,
        };
        set(map, block, &held.full_path(part), Source::scene(Quantity::Ambient(part_of)));
    }
}

fn set(map: &mut BindingMap, block: usize, path: &str, source: Source) {
    let found = map.members.iter_mut().find(|m| m.block == block && m.path == path);
    // The first source stays: a member belongs to the first light that claims it.
    if let Some(member) = found.filter(|member| member.source == Source::Unknown) {
        member.source = source;
    }
}

/// Returns the form of a range that its name tells.
fn range(name: &str) -> LightPart {
    let said = identifier_words(name);
    let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
    let squared = says(&["sq", "sqr", "square", "squared", "2"]) || name.ends_with('2');
    match (says(&["inv", "inverse", "rcp", "reciprocal", "one"]), squared) {
        (false, false) => LightPart::Range,
        (false, true) => LightPart::RangeSquared,
        (true, false) => LightPart::InverseRange,
        (true, true) => LightPart::InverseRangeSquared,
    }
}

/// Returns the last name of a path.
fn last(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path).trim_end_matches("[]")
}

/// Returns the source of a leaf that does not belong to a light.
fn other(leaf: &Leaf, block: &BlockLayout) -> Option<Source> {
    let plain = |quantity| Some(Source::scene(quantity));
    let own = identifier_words(last(&leaf.path));
    let says = |any: &[&str]| own.iter().any(|word| any.contains(&word.as_str()));
    // The names along the path, and of the block for a member directly in it, tell what a leaf is
    // about.
    let mut around: Vec<String> = leaf.path.split('.').flat_map(identifier_words).collect();
    if leaf.path.split('.').count() < 2 {
        around.extend(identifier_words(&block.name));
        around.extend(block.instance.iter().flat_map(|instance| identifier_words(instance)));
    }
    let about = |any: &[&str]| around.iter().any(|word| any.contains(&word.as_str()));
    let tiles = about(&["tile", "tiles", "grid", "index", "indices", "list"]);
    match &leaf.ty {
        Type::Vector { scalar, rows: 3 | 4 } if scalar.kind == ScalarKind::Float => {
            let camera = says(&["view", "viewer", "camera", "cam", "eye"])
                || about(&["camera", "eye", "viewer"]);
            let place = says(&["pos", "position", "origin", "location", "place", "eye"]);
            // `viewPos`, `camera.position`, but not `viewMatrix`.
            if camera && place {
                return plain(Quantity::Camera);
            }
            if says(&["ambient"]) && about(&["light", "lights", "lighting", "scene", "global"]) {
                return plain(Quantity::Ambient(LightPart::Radiance));
            }
            let material = about(&["material", "mat", "surface", "object", "mesh", "brdf"]);
            let tint = says(&["albedo", "base", "diffuse", "kd"]);
            match () {
                () if material && says(&["ambient", "ka"]) => {
                    plain(Quantity::Material(MaterialPart::Ambient))
                }
                () if material && says(&["specular", "spec", "ks"]) => {
                    plain(Quantity::Material(MaterialPart::Specular))
                }
                () if tint || (material && says(&["color", "colour"])) => {
                    plain(Quantity::Material(MaterialPart::Diffuse))
                }
                () => None,
            }
        }
        Type::Scalar(scalar) if scalar.kind == ScalarKind::Float => {
            if says(&["shininess", "glossiness", "gloss"])
                || says(&["specular"]) && says(&["power", "exponent"])
            {
                return plain(Quantity::Material(MaterialPart::Shininess));
            }
            if says(&["reflectance", "reflectivity"]) {
                return plain(Quantity::Material(MaterialPart::Reflectance));
            }
            None
        }
        Type::Scalar(scalar) if scalar.kind != ScalarKind::Bool && tiles => {
            let each = !leaf.dims.is_empty();
            let part = match each {
                // In arrays by tile, or single numbers of the whole picture.
                true if says(&["mask"]) && says(&["directional"]) => TilePart::DirectionalMask,
                true if says(&["spot"]) && says(&["first"]) => TilePart::SpotFirst,
                true if says(&["spot"]) && says(&["count"]) => TilePart::SpotCount,
                true if says(&["first", "start", "offset", "begin"]) => TilePart::First,
                true if says(&["count", "length", "num"]) => TilePart::Count,
                true if says(&["index", "indices", "list", "lights"]) => TilePart::Index,
                false if says(&["height"]) && says(&["picture"]) => TilePart::Height,
                false if says(&["size", "width"]) => TilePart::Size,
                false if says(&["across", "columns", "stride", "row"]) => TilePart::Columns,
                true | false => return None,
            };
            plain(Quantity::Tiles(part))
        }
        Type::Scalar(_)
        | Type::Vector { .. }
        | Type::Atomic(_)
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => None,
    }
}

fn texture(name: &str, textures: usize) -> Option<MaterialPart> {
    let said = identifier_words(last(name));
    let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
    // Textures of other uses are not material colours.
    if says(&["normal", "shadow", "depth", "height", "bump", "environment", "emission", "noise"]) {
        return None;
    }
    if says(&["specular", "spec", "gloss", "flashlight"]) {
        return Some(MaterialPart::Specular);
    }
    if says(&["ambient", "ao"]) {
        return Some(MaterialPart::Ambient);
    }
    let diffuse = says(&["diffuse", "albedo", "base", "color", "colour"]);
    // A single texture is the diffuse one.
    (diffuse || textures == 1).then_some(MaterialPart::Diffuse)
}

fn input(input: &Input) -> BoundValue {
    let said = identifier_words(last(&input.name));
    let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
    let quantity = match input.components {
        // Inputs by type and name: three or four components for positions and normals, two and
        // more for texture coordinates.
        _ if input.name == PIXEL => Some(Quantity::Pixel),
        3 | 4 if says(&["normal", "norm", "normals", "n", "nrm"]) => Some(Quantity::Normal),
        3 | 4
            if says(&["pos", "position", "frag", "fragment", "world", "vertex", "point", "p"])
                && !says(&["tangent", "color", "colour", "light", "view"]) =>
        {
            Some(Quantity::Position)
        }
        2..=4 if says(&["uv", "uvs", "tex", "text", "texture", "texcoord", "st", "coord"]) => {
            Some(Quantity::Uv)
        }
        2..=4 if says(&["coords", "texcoords"]) => Some(Quantity::Uv),
        _ => None,
    };
    let source = quantity.map_or(Source::Unknown, Source::scene);
    BoundValue { name: input.name.clone(), source }
}

#[derive(Clone, Copy)]
enum Edge {
    Inner,
    Outer,
}

/// The tokens of a text without its comments.
struct WordTokens<'t> {
    tokens: Vec<&'t str>,
}

impl<'t> WordTokens<'t> {
    fn new(text: &'t str) -> WordTokens<'t> {
        let mut tokens = Vec::new();
        let bytes = text.as_bytes();
        let mut at = 0;
        while at < bytes.len() {
            let rest = &bytes[at..];
            let skip = match rest {
                // Comments may mention a member in another sense.
                [b'/', b'/', ..] => memchr::memchr(b'\n', rest).unwrap_or(rest.len()),
                [b'/', b'*', ..] => {
                    memchr::memmem::find(&rest[2..], b"*/").map_or(rest.len(), |end| end + 4)
                }
                [c, ..] if c.is_ascii_alphanumeric() || *c == b'_' => {
                    let is_word = |c: &&u8| c.is_ascii_alphanumeric() || **c == b'_';
                    let length = rest.iter().take_while(is_word).count();
                    tokens.push(&text[at..at + length]);
                    length
                }
                [c, ..] if c.is_ascii_punctuation() => {
                    tokens.push(&text[at..at + 1]);
                    1
                }
                _ => 1,
            };
            at += skip;
        }
        WordTokens { tokens }
    }

    /// Returns the positions of `.member`, and where its expression begins.
    fn uses(&self, member: &str) -> impl Iterator<Item = (usize, usize)> {
        let tokens = &self.tokens;
        (1..tokens.len()).filter(move |&at| tokens[at] == member && tokens[at - 1] == ".").map(
            move |at| {
                let mut start = at;
                // Back over `a.b[i].c` to where the expression begins.
                while start > 1 && tokens[start - 1] == "." {
                    start -= 2;
                    while tokens[start] == "]" {
                        let mut depth = 1;
                        while depth > 0 && start > 0 {
                            start -= 1;
                            depth += i32::from(tokens[start] == "]");
                            depth -= i32::from(tokens[start] == "[");
                        }
                        start = start.saturating_sub(1);
                    }
                }
                (at, start)
            },
        )
    }

    /// Whether a direction points towards the light: it is used, and never after a minus.
    fn is_towards(&self, member: &str) -> bool {
        let mut used = false;
        for (_, start) in self.uses(member) {
            used = true;
            let before = start.checked_sub(1).map(|at| self.tokens[at]);
            if before == Some("-") {
                return false;
            }
            // `vec3 d = light.direction; … -d`
            let name = match start.checked_sub(2).map(|at| &self.tokens[at..start]) {
                Some([name, "="]) => *name,
                _ => continue,
            };
            if self.tokens.windows(2).any(|pair| pair == ["-", name]) {
                return false;
            }
        }
        used
    }

    /// Returns the quantity of a cone: the cosine, unless the code takes the cosine of it.
    fn cone(&self, member: &str, edge: Edge) -> LightPart {
        let called = |start: usize, function: &str| {
            start >= 2 && self.tokens[start - 1] == "(" && self.tokens[start - 2] == function
        };
        for (_, start) in self.uses(member) {
            if called(start, "radians") {
                return match edge {
                    Edge::Inner => LightPart::InnerDegrees,
                    Edge::Outer => LightPart::OuterDegrees,
                };
            }
            if called(start, "cos") {
                return match edge {
                    Edge::Inner => LightPart::InnerRadians,
                    Edge::Outer => LightPart::OuterRadians,
                };
            }
        }
        match edge {
            Edge::Inner => LightPart::InnerCos,
            Edge::Outer => LightPart::OuterCos,
        }
    }
}
