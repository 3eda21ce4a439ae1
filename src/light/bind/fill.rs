//! The bytes of a shader's blocks, its textures and inputs, by a binding map.
//!
//! Reads an [`Upload`] and fragments; [`render`](crate::light::render) hands what it makes to
//! [`fragments`](crate::run::fragments).

use glam::DVec3;

use super::quantity::{Kind, LightPart, MaterialPart, Quantity, Slot, TilePart};
use super::{BindError, BindingMap, Member, Source};
use crate::buffer::Buffer;
use crate::layout::Leaf;
use crate::light::scene::{Cone, Emission, Lights, Material, PointLight, Surface};
use crate::light::{Fragment, Upload, sample};
use crate::run::fragments::{FragmentShader, Image};
use crate::shape::{ArrayLen, ScalarKind, Type};

/// The lights a list of fragments is lit by: their numbers in the upload, in the order of the
/// sum.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lit<'a> {
    /// Whether the light from everywhere is added.
    pub ambient: bool,
    /// Suns.
    pub directional: &'a [u32],
    /// Lamps.
    pub point: &'a [u32],
    /// Lamps with a cone.
    pub spot: &'a [u32],
}

/// Which of the point lights of a [`Lit`] each tile of the picture has, for shaders that ask.
#[derive(Clone, Copy, Debug)]
pub struct Tiles<'a> {
    /// Pixels along a tile's side.
    pub size: u32,
    /// Tiles in a row.
    pub columns: u32,
    /// Of each tile, the first of its entries in `indices`, and how many they are.
    pub tiles: &'a [[u32; 2]],
    /// Numbers of point lights.
    pub indices: &'a [u32],
}

/// What becomes of lights for which a shader has no slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Excess {
    /// They are an error.
    #[default]
    Refuse,
    /// They are left out, the last first.
    LeaveOut,
}

/// A binding map made ready to write many uploads.
#[derive(Clone, Debug)]
pub struct Filler {
    pub(super) writes: Vec<Write>,
    /// Of each block, zeros; of one that ends in a runtime-sized array, none.
    blocks: Vec<Vec<u8>>,
    layouts: Vec<crate::BlockLayout>,
    /// Slots of each kind and the member that has the fewest.
    slots: [(usize, Option<String>); 3],
    textures: Vec<Source>,
    inputs: Vec<Source>,
    /// Whether some texture carries the diffuse, or the specular, colour.
    textured: [bool; 3],
    rows_from_bottom: bool,
}

/// A leaf and what it is given.
#[derive(Clone, Debug)]
pub(super) struct Write {
    key: String,
    pub block: usize,
    pub offset: usize,
    /// Of the one array on the way.
    pub stride: usize,
    pub len: Len,
    pub kind: ScalarKind,
    pub rows: usize,
    pub source: Source,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Len {
    One,
    Fixed(usize),
    Runtime,
}

/// A number or vector, and the fourth component where the shader has one more.
#[derive(Clone, Copy)]
struct Number {
    values: [f64; 4],
    count: usize,
}

impl Number {
    fn one(value: f64) -> Number {
        Number { values: [value, value, value, value], count: 1 }
    }

    fn vector(value: DVec3, fourth: f64) -> Number {
        Number { values: [value.x, value.y, value.z, fourth], count: 3 }
    }

    /// As a leaf of so many components takes it.
    fn components(&self, rows: usize) -> [f64; 4] {
        let [x, y, z, _] = self.values;
        match (self.count, rows) {
            // One number for a colour of three: the brightest channel.
            (3, 1) => [x.max(y).max(z); 4],
            _ => self.values,
        }
    }
}

impl Filler {
    /// Makes a map ready.
    ///
    /// # Errors
    /// A member that cannot be given what the map says.
    pub fn new(shader: &FragmentShader, map: &BindingMap) -> Result<Filler, BindError> {
        let layouts: Vec<_> = shader.blocks().iter().map(|block| block.layout.clone()).collect();
        let mut writes = Vec::new();
        for member in &map.members {
            if member.source != Source::Unknown {
                writes.push(write(member, &layouts[member.block])?);
            }
        }
        // An element on its own goes over what its array was given.
        writes.sort_by_key(|write| write.len == Len::One);
        let blocks = layouts.iter().map(|layout| match Buffer::new(layout) {
            Ok(buffer) => buffer.into_bytes(),
            Err(_) => Vec::new(),
        });
        let textures: Vec<Source> = map.textures.iter().map(|bound| bound.source.clone()).collect();
        let carries = |part| {
            let wanted = Some(Quantity::Material(part));
            textures.iter().any(|source| source.quantity() == wanted)
        };
        Ok(Filler {
            blocks: blocks.collect(),
            slots: Kind::ALL.map(|kind| slots(&writes, kind)),
            writes,
            layouts,
            textured: [MaterialPart::Ambient, MaterialPart::Diffuse, MaterialPart::Specular]
                .map(carries),
            textures,
            inputs: map.inputs.iter().map(|bound| bound.source.clone()).collect(),
            rows_from_bottom: shader.rows_from_bottom(),
        })
    }

    /// The lights of an upload that the shader has slots for; all of them, or an error.
    ///
    /// # Errors
    /// More lights of a kind than slots, unless they are to be left out.
    pub fn lights(&self, lights: &Lights, excess: Excess) -> Result<[Vec<u32>; 3], BindError> {
        let counts = [lights.directional.len(), lights.point.len(), lights.spot.len()];
        let mut chosen: [Vec<u32>; 3] = Default::default();
        for (kind, chosen) in Kind::ALL.into_iter().zip(&mut chosen) {
            let (lights, (slots, member)) = (counts[kind as usize], &self.slots[kind as usize]);
            if lights > *slots && excess == Excess::Refuse {
                let (slots, member) = (*slots, member.clone());
                return Err(BindError::TooManyLights { kind, lights, slots, member });
            }
            *chosen = (0..lights.min(*slots) as u32).collect();
        }
        Ok(chosen)
    }

    /// Slots of the shader for lights of a kind; as many as there may be lights where its array
    /// is as long as its buffer.
    pub fn slots(&self, kind: Kind) -> usize {
        self.slots[kind as usize].0
    }

    /// The bytes of every block for fragments of one material.
    ///
    /// # Errors
    /// More lights than slots.
    pub fn blocks(
        &self,
        upload: &Upload,
        lit: &Lit<'_>,
        material: &Material,
        tiles: Option<&Tiles<'_>>,
    ) -> Result<Vec<Vec<u8>>, BindError> {
        for kind in Kind::ALL {
            let (lights, (slots, member)) = (chosen(lit, kind).len(), &self.slots[kind as usize]);
            if lights > *slots {
                let (slots, member) = (*slots, member.clone());
                return Err(BindError::TooManyLights { kind, lights, slots, member });
            }
        }
        // One tile of everything, for a shader that asks and a plan that has none.
        let all: Vec<u32> = (0..lit.point.len().max(1) as u32).collect();
        let one = [[0, lit.point.len() as u32]];
        let whole = Tiles { size: u32::MAX, columns: 1, tiles: &one, indices: &all };
        let given = Given { upload, lit, material, tiles: tiles.unwrap_or(&whole) };
        let mut blocks = self.sized(&given);
        for write in &self.writes {
            let bytes = &mut blocks[write.block];
            let elements = match write.len {
                Len::One => 1,
                Len::Fixed(len) => len,
                // The leaf need not be the first of its element, so the last is no whole stride.
                Len::Runtime => {
                    bytes.len().saturating_sub(write.offset).div_ceil(write.stride.max(1))
                }
            };
            let used = match write.source.quantity() {
                Some(quantity) if quantity.is_each() => given.count(quantity).min(elements),
                _ => elements,
            };
            for index in 0..used {
                let number = self.number(&write.source, index, &given);
                let at = write.offset + index * write.stride;
                let components = number.components(write.rows);
                for (row, value) in components.into_iter().enumerate().take(write.rows) {
                    let word = match write.kind {
                        ScalarKind::Sint => value as i32 as u32,
                        ScalarKind::Uint => value as u32,
                        ScalarKind::Bool => u32::from(value != 0.0),
                        ScalarKind::Float
                        | ScalarKind::Bfloat
                        | ScalarKind::FloatE5m2
                        | ScalarKind::FloatE4m3 => (value as f32).to_bits(),
                    };
                    let at = at + row * 4;
                    if let Some(to) = bytes.get_mut(at..at + 4) {
                        to.copy_from_slice(&word.to_ne_bytes());
                    }
                }
            }
        }
        Ok(blocks)
    }

    /// Zeros for each block, runtime-sized arrays as long as what goes into them.
    fn sized(&self, given: &Given<'_>) -> Vec<Vec<u8>> {
        let each = self.blocks.iter().enumerate().map(|(number, zeros)| {
            if !zeros.is_empty() {
                return zeros.clone();
            }
            let of_block = self.writes.iter().filter(|w| w.block == number);
            let lens = of_block.filter(|w| w.len == Len::Runtime).filter_map(|write| {
                Some(given.count(write.source.quantity().filter(|q| q.is_each())?))
            });
            let elements = lens.max().unwrap_or(0).max(1);
            let buffer = Buffer::with_tail(&self.layouts[number], elements);
            buffer.map(Buffer::into_bytes).unwrap_or_default()
        });
        each.collect()
    }

    fn number(&self, source: &Source, index: usize, given: &Given<'_>) -> Number {
        match source {
            Source::Unknown => Number::one(0.0),
            Source::Number(numbers) => {
                let mut values = [0.0; 4];
                for (to, from) in values.iter_mut().zip(numbers) {
                    *to = *from;
                }
                match numbers[..] {
                    [one] => Number::one(one),
                    _ => Number { values, count: numbers.len() },
                }
            }
            Source::Scene { quantity, negated } => {
                let mut number = given.number(*quantity, index, &self.textured);
                if *negated {
                    number.values = number.values.map(|value| -value);
                }
                number
            }
        }
    }

    /// The textures for fragments of one material.
    pub fn textures(&self, material: &Material) -> Vec<Image> {
        let each = self.textures.iter().map(|source| match source {
            Source::Scene { quantity: Quantity::Material(part), .. } => {
                self.texture(material, *part)
            }
            Source::Number(numbers) => {
                let channel = |at: usize| numbers.get(at).or(numbers.last()).copied();
                let alpha = if numbers.len() == 4 { numbers[3] } else { 1.0 };
                let rgb = [0, 1, 2].map(|at| channel(at).unwrap_or(0.0));
                plain([rgb[0], rgb[1], rgb[2], alpha].map(|c| c as f32))
            }
            Source::Scene { .. } | Source::Unknown => plain([0.0, 0.0, 0.0, 1.0]),
        });
        each.collect()
    }

    fn texture(&self, material: &Material, part: MaterialPart) -> Image {
        let Some(surface) = surface(material, part) else { return plain([0.0; 4]) };
        match surface {
            Surface::Texture(texture) => {
                let color = |texel: &[u8; 3]| {
                    let [r, g, b] = sample::color(*texel, texture.srgb).as_vec3().to_array();
                    [r, g, b, 1.0]
                };
                let texels = texture.texels.iter().map(color).collect();
                Image { width: texture.width, height: texture.height, texels }
            }
            // The colour is in a member, and this is multiplied with it.
            Surface::Constant(_) if self.colours(part) => plain([1.0; 4]),
            Surface::Constant(color) => {
                let [r, g, b] = color.as_vec3().to_array();
                plain([r, g, b, 1.0])
            }
        }
    }

    /// Whether a member of the shader holds that colour.
    fn colours(&self, part: MaterialPart) -> bool {
        let wanted = Some(Quantity::Material(part));
        self.writes.iter().any(|write| write.source.quantity() == wanted)
    }

    /// The values of each input for fragments.
    pub fn inputs<'f>(
        &self,
        fragments: impl Iterator<Item = &'f Fragment> + Clone,
        size: [u32; 2],
    ) -> Vec<Vec<[f32; 4]>> {
        let [width, height] = size.map(|n| n.max(1));
        let each = self.inputs.iter().map(|source| -> Vec<[f32; 4]> {
            let value = |fragment: &Fragment| -> [f32; 4] {
                let quantity = match source {
                    Source::Scene { quantity, .. } => quantity,
                    Source::Number(numbers) => {
                        let at = |at: usize| numbers.get(at).copied().unwrap_or(0.0) as f32;
                        return [at(0), at(1), at(2), at(3)];
                    }
                    Source::Unknown => return [0.0; 4],
                };
                let ([x, y, z], [nx, ny, nz]) = (fragment.position, fragment.normal);
                match quantity {
                    Quantity::Position => [x, y, z, 1.0],
                    Quantity::Normal => [nx, ny, nz, 0.0],
                    Quantity::Uv => [fragment.uv[0], fragment.uv[1], 0.0, 0.0],
                    Quantity::Pixel => {
                        let (column, row) = (fragment.pixel % width, fragment.pixel / width);
                        let row = if self.rows_from_bottom { height - 1 - row } else { row };
                        [column as f32 + 0.5, row as f32 + 0.5, 0.0, 1.0]
                    }
                    Quantity::Camera
                    | Quantity::Ambient(_)
                    | Quantity::Light { .. }
                    | Quantity::Count(_)
                    | Quantity::Material(_)
                    | Quantity::Tiles(_) => [0.0; 4],
                }
            };
            let negated = matches!(source, Source::Scene { negated: true, .. });
            let signed = |v: [f32; 4]| if negated { v.map(|c| -c) } else { v };
            fragments.clone().map(|fragment| signed(value(fragment))).collect()
        });
        each.collect()
    }

    /// What of a material a member cannot be given as it is.
    pub fn notes(&self, material: &Material) -> Vec<String> {
        let mut notes = Vec::new();
        for write in &self.writes {
            let Some(Quantity::Material(part)) = write.source.quantity() else { continue };
            let textured = self.carried(part);
            if let (Some(Surface::Texture(_)), false) = (surface(material, part), textured) {
                notes.push(format!(
                    "`{}` is one colour, and the {} of `{}` a texture: its mean is given",
                    write.key,
                    part.word(),
                    material.name
                ));
            }
        }
        notes
    }

    fn carried(&self, part: MaterialPart) -> bool {
        match part {
            MaterialPart::Ambient => self.textured[0] || self.textured[1],
            MaterialPart::Diffuse => self.textured[1],
            MaterialPart::Specular => self.textured[2],
            MaterialPart::Shininess | MaterialPart::Reflectance => false,
        }
    }
}

fn write(member: &Member, block: &crate::BlockLayout) -> Result<Write, BindError> {
    let key = member.key();
    let misfit = |why: String| BindError::Misfit { key: key.clone(), why };
    let (leaf, index) = leaf(&block.leaves, &member.path)
        .ok_or_else(|| misfit("is not in the block it is said to be in".to_string()))?;
    let (scalar, rows) = match &leaf.ty {
        Type::Scalar(scalar) | Type::Atomic(scalar) => (*scalar, 1),
        Type::Vector { scalar, rows } => (*scalar, usize::from(*rows)),
        Type::Matrix { .. } | Type::Address(_) | Type::Struct(_) | Type::Array { .. } => {
            return Err(misfit("is no scalar or vector".to_string()));
        }
    };
    if scalar.width != 4 {
        return Err(misfit(format!("is of {}-bit numbers, not of 32", scalar.width * 8)));
    }
    let offset = leaf.offset.unwrap_or(0) as usize;
    let (len, stride) = match (&leaf.dims[..], index) {
        ([], _) => (Len::One, 0),
        ([ArrayLen::Fixed(len)], None) => (Len::Fixed(*len as usize), leaf.strides[0] as usize),
        ([ArrayLen::Runtime], None) => (Len::Runtime, leaf.strides[0] as usize),
        ([ArrayLen::Fixed(len)], Some(index)) if index < *len as usize => (Len::One, 0),
        ([_], Some(_)) => return Err(misfit("is past the end of its array".to_string())),
        _ => return Err(misfit("is in arrays of arrays, or of a length nobody knows".to_string())),
    };
    let offset = offset + index.map_or(0, |index| index * leaf.strides[0] as usize);
    let each = member.source.quantity().is_some_and(Quantity::is_each);
    if each && len == Len::One {
        let why = format!("is one and no array, and `{}` is one for each element", member.source);
        return Err(misfit(why));
    }
    let (kind, source) = (scalar.kind, member.source.clone());
    Ok(Write { key, block: member.block, offset, stride, len, kind, rows, source })
}

/// The leaf of a path, and the index where it names one element of an array.
fn leaf<'l>(leaves: &'l [Leaf], path: &str) -> Option<(&'l Leaf, Option<usize>)> {
    if let Some(leaf) = leaves.iter().find(|leaf| leaf.path == path) {
        return Some((leaf, None));
    }
    let (before, rest) = path.split_once('[')?;
    let (index, after) = rest.split_once(']')?;
    let pattern = format!("{before}[]{after}");
    let leaf = leaves.iter().find(|leaf| leaf.path == pattern && leaf.dims.len() == 1)?;
    Some((leaf, Some(index.parse().ok()?)))
}

/// How many lights of a kind there is room for.
fn slots(writes: &[Write], kind: Kind) -> (usize, Option<String>) {
    let mut fewest: Option<(usize, String)> = None;
    let mut singles = 0usize;
    for write in writes {
        let Some(Quantity::Light { kind: of, slot, .. }) = write.source.quantity() else {
            continue;
        };
        if of != kind {
            continue;
        }
        let slots = match (slot, write.len) {
            (Slot::One(number), _) => {
                singles = singles.max(number as usize + 1);
                continue;
            }
            (Slot::Each, Len::Fixed(len)) => len,
            (Slot::Each, Len::Runtime) => usize::MAX,
            (Slot::Each, Len::One) => continue,
        };
        if fewest.as_ref().is_none_or(|(known, _)| slots < *known) {
            fewest = Some((slots, write.key.clone()));
        }
    }
    match fewest {
        Some((slots, member)) => (slots, Some(member)),
        None => (singles, None),
    }
}

fn chosen<'l>(lit: &Lit<'l>, kind: Kind) -> &'l [u32] {
    match kind {
        Kind::Directional => lit.directional,
        Kind::Point => lit.point,
        Kind::Spot => lit.spot,
    }
}

fn surface(material: &Material, part: MaterialPart) -> Option<&Surface> {
    match part {
        MaterialPart::Ambient => Some(&material.ambient),
        MaterialPart::Diffuse => Some(&material.diffuse),
        MaterialPart::Specular => Some(&material.specular),
        MaterialPart::Shininess | MaterialPart::Reflectance => None,
    }
}

fn plain(texel: [f32; 4]) -> Image {
    Image { width: 1, height: 1, texels: vec![texel] }
}

/// Everything a member may be given.
struct Given<'a> {
    upload: &'a Upload,
    lit: &'a Lit<'a>,
    material: &'a Material,
    tiles: &'a Tiles<'a>,
}

/// Where a light ends that does not: far enough that a window is 1 at any distance.
const ENDLESS: f64 = 1e18;

impl Given<'_> {
    /// How many elements of a quantity there are.
    fn count(&self, quantity: Quantity) -> usize {
        match quantity {
            Quantity::Light { kind, .. } => chosen(self.lit, kind).len(),
            Quantity::Tiles(TilePart::First | TilePart::Count) => self.tiles.tiles.len(),
            Quantity::Tiles(TilePart::Index) => self.tiles.indices.len(),
            Quantity::Tiles(TilePart::Size | TilePart::Columns)
            | Quantity::Camera
            | Quantity::Ambient(_)
            | Quantity::Count(_)
            | Quantity::Material(_)
            | Quantity::Position
            | Quantity::Normal
            | Quantity::Uv
            | Quantity::Pixel => 1,
        }
    }

    fn number(&self, quantity: Quantity, index: usize, textured: &[bool; 3]) -> Number {
        let nothing = Number::one(0.0);
        match quantity {
            Quantity::Camera => Number::vector(self.upload.camera, 1.0),
            Quantity::Ambient(part) => {
                let ambient = self.upload.lights.ambient.filter(|_| self.lit.ambient);
                let Some(ambient) = ambient else { return nothing };
                match part {
                    LightPart::Intensity => Number::one(ambient.intensity),
                    LightPart::Radiance => Number::vector(ambient.color * ambient.intensity, 1.0),
                    _ => Number::vector(ambient.color, 1.0),
                }
            }
            Quantity::Light { kind, slot, part } => {
                let at = match slot {
                    Slot::Each => index,
                    Slot::One(number) => number as usize,
                };
                match chosen(self.lit, kind).get(at) {
                    Some(number) => self.light(kind, *number as usize, part),
                    None => nothing,
                }
            }
            Quantity::Count(kind) => Number::one(chosen(self.lit, kind).len() as f64),
            Quantity::Material(part) => self.of_material(part, textured),
            Quantity::Tiles(part) => Number::one(f64::from(match part {
                TilePart::Size => self.tiles.size,
                TilePart::Columns => self.tiles.columns,
                TilePart::First => self.tiles.tiles.get(index).map_or(0, |tile| tile[0]),
                TilePart::Count => self.tiles.tiles.get(index).map_or(0, |tile| tile[1]),
                TilePart::Index => self.tiles.indices.get(index).copied().unwrap_or(0),
            })),
            Quantity::Position | Quantity::Normal | Quantity::Uv | Quantity::Pixel => nothing,
        }
    }

    fn light(&self, kind: Kind, number: usize, part: LightPart) -> Number {
        let lights = &self.upload.lights;
        let found = match kind {
            Kind::Directional => lights.directional.get(number).and_then(|light| {
                of_emission(&light.emission, part).or(match part {
                    LightPart::Direction => Some(Number::vector(light.direction, 0.0)),
                    _ => None,
                })
            }),
            Kind::Point => lights.point.get(number).and_then(|light| of_lamp(light, part)),
            Kind::Spot => lights.spot.get(number).and_then(|light| {
                let own = match part {
                    LightPart::Direction => Some(Number::vector(light.direction, 0.0)),
                    _ => of_cone(&light.cone, part),
                };
                own.or_else(|| of_lamp(&light.lamp, part))
            }),
        };
        found.unwrap_or(Number::one(0.0))
    }

    fn of_material(&self, part: MaterialPart, textured: &[bool; 3]) -> Number {
        let Material { diffuse, shininess, reflectance, .. } = self.material;
        let white = Number::vector(DVec3::ONE, 1.0);
        let color = |surface: &Surface| match surface {
            Surface::Constant(color) => Number::vector(*color, 1.0),
            Surface::Texture(texture) => {
                let sum: DVec3 =
                    texture.texels.iter().map(|t| sample::color(*t, texture.srgb)).sum();
                Number::vector(sum / texture.texels.len().max(1) as f64, 1.0)
            }
        };
        let [ambient, by_diffuse, specular] = *textured;
        match part {
            MaterialPart::Shininess => Number::one(*shininess),
            MaterialPart::Reflectance => Number::one(*reflectance),
            MaterialPart::Diffuse | MaterialPart::Ambient | MaterialPart::Specular => {
                let surface = surface(self.material, part).unwrap_or(diffuse);
                let is_texture = matches!(surface, Surface::Texture(_));
                let carried = match part {
                    MaterialPart::Diffuse => by_diffuse,
                    MaterialPart::Specular => specular,
                    // The diffuse texture is multiplied with it where there is no other.
                    MaterialPart::Ambient => ambient || (by_diffuse && surface == diffuse),
                    MaterialPart::Shininess | MaterialPart::Reflectance => false,
                };
                if is_texture && carried { white } else { color(surface) }
            }
        }
    }
}

fn of_emission(emission: &Emission, part: LightPart) -> Option<Number> {
    let Emission { ambient, diffuse, specular, color, intensity } = *emission;
    let color_of = |color| Some(Number::vector(color, 1.0));
    match part {
        LightPart::Color => color_of(color),
        LightPart::Radiance => color_of(color * intensity),
        LightPart::Ambient => color_of(ambient),
        LightPart::Diffuse => color_of(diffuse),
        LightPart::Specular => color_of(specular),
        LightPart::Intensity => Some(Number::one(intensity)),
        LightPart::Enabled => Some(Number::one(1.0)),
        LightPart::Position
        | LightPart::Direction
        | LightPart::Constant
        | LightPart::Linear
        | LightPart::Quadratic
        | LightPart::Attenuation
        | LightPart::Range
        | LightPart::InnerCos
        | LightPart::OuterCos
        | LightPart::InnerDegrees
        | LightPart::OuterDegrees
        | LightPart::InnerRadians
        | LightPart::OuterRadians => None,
    }
}

fn of_lamp(lamp: &PointLight, part: LightPart) -> Option<Number> {
    let weakening = lamp.attenuation;
    let (c, l, q) = (weakening.constant, weakening.linear, weakening.quadratic);
    match part {
        LightPart::Position => Some(Number::vector(lamp.position, 1.0)),
        LightPart::Constant => Some(Number::one(c)),
        LightPart::Linear => Some(Number::one(l)),
        LightPart::Quadratic => Some(Number::one(q)),
        LightPart::Attenuation => Some(Number::vector(DVec3::new(c, l, q), 0.0)),
        LightPart::Range => Some(Number::one(weakening.range.unwrap_or(ENDLESS))),
        _ => of_emission(&lamp.emission, part),
    }
}

fn of_cone(cone: &Cone, part: LightPart) -> Option<Number> {
    let degrees = |at: usize, cos: f64| cone.degrees.map_or(cos.acos().to_degrees(), |d| d[at]);
    let inner = || degrees(0, cone.inner_cos);
    let outer = || degrees(1, cone.outer_cos);
    match part {
        LightPart::InnerCos => Some(Number::one(cone.inner_cos)),
        LightPart::OuterCos => Some(Number::one(cone.outer_cos)),
        LightPart::InnerDegrees => Some(Number::one(inner())),
        LightPart::OuterDegrees => Some(Number::one(outer())),
        LightPart::InnerRadians => Some(Number::one(inner().to_radians())),
        LightPart::OuterRadians => Some(Number::one(outer().to_radians())),
        _ => None,
    }
}
