//! A scene lit by a shader on a reader: a picture.
//!
//! A [`Renderer`] is a shader, its binding map and what they compile to. [`Renderer::light`] lights
//! a list of fragments by a list of lights, [`Renderer::render`] makes a picture of several such
//! lists, which is what a plan that skips is. [`truth`] is the same by the reference, and
//! [`tally`] what the evaluator counted.

pub mod planned;
pub mod tally;
pub mod truth;

use std::fmt;
use std::time::Duration;

use glam::DVec3;
use serde_json::{Map, Value};

use super::bind::{
    BindError, BindingMap, Excess, Filler, Kind, Lit, Quantity, Tiles, guess, overridden,
};
use super::{Fragment, Frame, Upload};
use crate::picture::Picture;
use landfall_exec::backend::{Failure, Reader};
use landfall_exec::harness::fragments::{Batch, FragmentShader, Image, Shaded};
use landfall_layout::source::Source;
use landfall_layout::{Diagnostic, Options};

/// A shader ready to light scenes.
#[derive(Clone, Debug)]
pub struct Renderer {
    /// The shader.
    pub shader: FragmentShader,
    /// What its members are given.
    pub map: BindingMap,
    filler: Filler,
}

/// What a renderer is made of besides the shader.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions<'a> {
    /// How the shader's text is read and laid out.
    pub layout: Options,
    /// Which fragment entry point, where there are several.
    pub entry: Option<&'a str>,
    /// What is said of the binding, the last said over the first.
    pub bind: Vec<&'a Map<String, Value>>,
}

/// Fragments lit by the same lights.
#[derive(Clone, Copy, Debug)]
pub struct Draw<'a> {
    /// Their numbers among the frame's, in any order.
    pub fragments: &'a [u32],
    /// The lights.
    pub lights: Lit<'a>,
    /// Which point lights each tile has, for shaders that ask.
    pub tiles: Option<Tiles<'a>>,
}

/// What a picture is made of.
#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    /// The lights and materials.
    pub upload: &'a Upload,
    /// The fragments.
    pub frame: &'a Frame,
    /// Colour where nothing is seen.
    pub background: DVec3,
    /// A reader that takes longer for one job has failed.
    pub limit: Duration,
}

/// What is bound for fragments of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prepared {
    /// The bytes of each block.
    pub blocks: Vec<Vec<u8>>,
    /// The textures.
    pub textures: Vec<Image>,
    /// Values of each input, one a fragment.
    pub inputs: Vec<Vec<[f32; 4]>>,
    /// How many fragments.
    pub count: usize,
}

impl Prepared {
    /// It as the shader takes it.
    pub fn batch(&self, limit: Duration) -> Batch<'_> {
        let Prepared { blocks, textures, inputs, count } = self;
        Batch { blocks, textures, inputs, count: *count, limit }
    }
}

/// A picture and what it took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rendered {
    /// The picture.
    pub picture: Picture,
    /// Fragments that were lit.
    pub fragments: u64,
    /// Fragments that the shader discarded: they show the background.
    pub discarded: u64,
    /// How often a light was evaluated at a fragment, slots that a loop has no count for
    /// included.
    pub evaluations: u64,
    /// Bytes of blocks that were uploaded.
    pub uploaded: u64,
}

/// Why there is no picture.
#[derive(Clone, Debug)]
pub enum RenderError {
    /// Something is wrong with the shader.
    Shader(Vec<Diagnostic>),
    /// The scene does not go into it.
    Bind(BindError),
    /// The reader refuses or fails.
    Reader(Failure),
}

impl From<BindError> for RenderError {
    fn from(error: BindError) -> RenderError {
        RenderError::Bind(error)
    }
}

impl From<Failure> for RenderError {
    fn from(failure: Failure) -> RenderError {
        RenderError::Reader(failure)
    }
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RenderError::Shader(found) => {
                let each: Vec<&str> = found.iter().map(|d| d.message.as_str()).collect();
                f.write_str(&each.join("\n"))
            }
            RenderError::Bind(error) => error.fmt(f),
            RenderError::Reader(failure) => failure.fmt(f),
        }
    }
}

impl std::error::Error for RenderError {}

impl Renderer {
    /// Makes a shader ready to light scenes.
    ///
    /// # Errors
    /// A shader that cannot run so, that holds no light, or a binding that does not fit it.
    pub fn new(source: &Source, options: &RenderOptions<'_>) -> Result<Renderer, RenderError> {
        let made = FragmentShader::new(source, &options.layout, options.entry);
        let shader = made.map_err(RenderError::Shader)?;
        let guessed = guess(&shader, &source.path, &source.text);
        let no_lights = guessed.as_ref().err().cloned();
        let mut map = guessed.unwrap_or_else(|_| crate::bind::members(&shader));
        for given in &options.bind {
            map = overridden(map, given)?;
        }
        // Nothing guessed is no matter where all is said.
        if let Some(error) = no_lights.filter(|_| !map.lights()) {
            return Err(error.into());
        }
        let filler = Filler::new(&shader, &map)?;
        Ok(Renderer { shader, map, filler })
    }

    /// The numbers of the lights of each kind that the shader has slots for.
    ///
    /// # Errors
    /// More lights than slots, unless those are to be left out.
    pub fn lights(&self, upload: &Upload, excess: Excess) -> Result<[Vec<u32>; 3], BindError> {
        self.filler.lights(&upload.lights, excess)
    }

    /// Slots of the shader for lights of a kind; `usize::MAX` where its buffer says.
    pub fn slots(&self, kind: Kind) -> usize {
        self.filler.slots(kind)
    }

    /// Lights that the shader evaluates at a fragment: of a kind without a count, every slot.
    pub fn evaluated(&self, lit: &Lit<'_>) -> u64 {
        Kind::ALL.into_iter().map(|kind| self.walked(kind, lit)).sum()
    }

    /// Slots of a kind that the shader looks at for a fragment, whether it evaluates what is in
    /// them or not: of a kind without a count, every one.
    pub fn walked(&self, kind: Kind, lit: &Lit<'_>) -> u64 {
        let lights = match kind {
            Kind::Directional => lit.directional.len(),
            Kind::Point => lit.point.len(),
            Kind::Spot => lit.spot.len(),
        };
        let slots = self.filler.slots(kind);
        let counted = self.counts(kind) || slots == usize::MAX;
        if counted { lights as u64 } else { slots as u64 }
    }

    /// The same with the colours of the light in a slot no numbers, so that fragments that it
    /// reaches show it; none where the shader is given no colours of such lights.
    pub fn marked(&self, prepared: &Prepared, kind: Kind, slot: usize) -> Option<Prepared> {
        let mut marked = prepared.clone();
        self.filler.mark(&mut marked.blocks, kind, slot).then_some(marked)
    }

    /// Whether the shader is told how many lights of a kind there are.
    fn counts(&self, kind: Kind) -> bool {
        let count = Some(Quantity::Count(kind));
        self.map.members.iter().any(|member| member.source.quantity() == count)
    }

    /// Slots that have no light and that nothing tells the shader to leave out.
    pub fn idle(&self, lit: &Lit<'_>) -> u64 {
        let lights = lit.directional.len() + lit.point.len() + lit.spot.len();
        self.evaluated(lit).saturating_sub(lights as u64)
    }

    /// What of the materials the shader cannot be given as it is.
    pub fn notes(&self, upload: &Upload) -> Vec<String> {
        let mut notes: Vec<String> = self.map.notes.clone();
        notes.extend(upload.materials.iter().flat_map(|material| self.filler.notes(material)));
        notes.dedup();
        notes
    }

    /// Lights fragments of one material. `after` is told, after each job, how many are done.
    ///
    /// # Errors
    /// More lights than slots, or what the reader says.
    pub fn light<R: Reader + ?Sized>(
        &self,
        reader: &mut R,
        work: &Work<'_>,
        fragments: &[&Fragment],
        draw: &Draw<'_>,
        after: &mut dyn FnMut(&mut R, usize),
    ) -> Result<(Shaded, u64), RenderError> {
        let Some(first) = fragments.first() else { return Ok(Default::default()) };
        let material = work.upload.materials.get(first.material as usize);
        let material = material.expect("a fragment's material is one of the upload's");
        let filler = &self.filler;
        let blocks = filler.blocks(work.upload, &draw.lights, material, draw.tiles.as_ref())?;
        let size = [work.frame.width, work.frame.height];
        let inputs = filler.inputs(fragments.iter().copied(), size);
        let batch = Batch {
            blocks: &blocks,
            textures: &filler.textures(material),
            inputs: &inputs,
            count: fragments.len(),
            limit: work.limit,
        };
        let shaded = self.shader.run(reader, &batch, |reader, done| after(reader, done))?;
        Ok((shaded, blocks.iter().map(|bytes| bytes.len() as u64).sum()))
    }

    /// What lighting fragments of one material binds, made once to be run often.
    ///
    /// # Errors
    /// More lights than slots.
    pub fn prepare(
        &self,
        work: &Work<'_>,
        fragments: &[&Fragment],
        draw: &Draw<'_>,
    ) -> Result<Prepared, RenderError> {
        let Some(first) = fragments.first() else { return Ok(Prepared::default()) };
        let material = work.upload.materials.get(first.material as usize);
        let material = material.expect("a fragment's material is one of the upload's");
        let filler = &self.filler;
        Ok(Prepared {
            blocks: filler.blocks(work.upload, &draw.lights, material, draw.tiles.as_ref())?,
            textures: filler.textures(material),
            inputs: filler.inputs(fragments.iter().copied(), [work.frame.width, work.frame.height]),
            count: fragments.len(),
        })
    }

    /// Makes the picture of those draws; a fragment of none of them shows the background.
    ///
    /// # Errors
    /// More lights than slots, or what the reader says.
    pub fn render<R: Reader + ?Sized>(
        &self,
        reader: &mut R,
        work: &Work<'_>,
        draws: &[Draw<'_>],
        after: &mut dyn FnMut(&mut R, usize),
    ) -> Result<Rendered, RenderError> {
        let Frame { width, height, fragments } = work.frame;
        let mut rendered = Rendered {
            picture: Picture::filled(*width, *height, background(work.background)),
            ..Rendered::default()
        };
        for draw in draws {
            let found = draw.fragments.iter().filter_map(|n| fragments.get(*n as usize));
            let mut found: Vec<&Fragment> = found.collect();
            // Stable: the caller's order stays within a material.
            found.sort_by_key(|fragment| fragment.material);
            for same in found.chunk_by(|a, b| a.material == b.material) {
                let (shaded, bytes) = self.light(reader, work, same, draw, after)?;
                rendered.fragments += same.len() as u64;
                rendered.evaluations += same.len() as u64 * self.evaluated(&draw.lights);
                rendered.uploaded += bytes;
                for (at, (fragment, color)) in same.iter().zip(&shaded.colors).enumerate() {
                    if shaded.discarded.get(at) == Some(&true) {
                        rendered.discarded += 1;
                        continue;
                    }
                    if let Some(pixel) = rendered.picture.pixels.get_mut(fragment.pixel as usize) {
                        *pixel = *color;
                    }
                }
            }
        }
        Ok(rendered)
    }
}

/// The background as a pixel.
pub(super) fn background(color: DVec3) -> [f32; 4] {
    let [r, g, b] = color.as_vec3().to_array();
    [r, g, b, 1.0]
}
