//! Renders a scene with a shader on a backend.
//!
//! A [`Renderer`] is a compiled shader with its binding map. [`Renderer::light`] lights a list of
//! fragments with a list of lights, [`Renderer::render`] makes a picture of several such draws, as
//! a plan requires. [`truth`] renders with the reference; [`tally`] adds up the interpreter's
//! counts.

pub mod causes;
pub mod choose;
mod ignored;
pub mod limits;
pub mod planned;
mod scene_shader;
mod shown;
pub mod tally;
pub mod truth;

pub use scene_shader::SceneShader;
use std::fmt;
use std::time::Duration;

use glam::DVec3;
use serde_json::{Map, Value};

use super::bind::{
    BindError, BindingMap, BlockWriter, FragmentInputs, Kind, OverflowPolicy, Quantity, decide,
    infer, overridden,
};
use super::{Chosen, Frame, Upload};
use crate::picture::Picture;
use crate::plan::{LightSet, TileLists};
use landfall_exec::backend::{Backend, Failure};
use landfall_exec::harness::fragments::{Batch, FragmentShader, Image};
use landfall_interp::{Cpu, Programs, Settings};
use landfall_layout::source::Source;
use landfall_layout::{Diagnostic, Options};

#[derive(Clone, Debug)]
pub struct Renderer {
    pub shader: FragmentShader,
    pub map: BindingMap,
    filler: BlockWriter,
    /// What the interpreter has compiled of the shader.
    programs: Programs,
}

#[derive(Clone, Debug, Default)]
pub struct RenderOptions<'a> {
    /// The options for parsing and laying out the shader.
    pub layout: Options,
    /// The fragment entry point, if there are several.
    pub entry: Option<&'a str>,
    /// Overrides of the binding; later ones replace earlier ones.
    pub bind: Vec<&'a Map<String, Value>>,
}

/// Fragments lit by the same lights.
#[derive(Clone, Copy, Debug)]
pub struct Draw<'a> {
    /// The indices of the fragments in the frame, in any order.
    pub fragments: &'a [u32],
    pub lights: &'a LightSet,
    /// The lights of each tile, for shaders that use them.
    pub tiles: Option<&'a TileLists>,
}

#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    pub upload: &'a Upload,
    pub frame: &'a Frame,
    /// The colour of pixels without a fragment.
    pub background: DVec3,
    /// The time limit of a backend for one job.
    pub limit: Duration,
}

impl Work<'_> {
    fn picture(&self) -> Picture {
        let Frame { width, height, .. } = *self.frame;
        Picture::filled(width, height, background(self.background))
    }
}

/// The bindings for fragments of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prepared {
    pub blocks: Vec<Vec<u8>>,
    pub textures: Vec<Image>,
    /// The values of each input, one for each fragment.
    pub inputs: Vec<Vec<[f32; 4]>>,
    pub count: usize,
}

impl Prepared {
    pub fn batch(&self, limit: Duration) -> Batch<'_> {
        let Prepared { blocks, textures, inputs, count } = self;
        Batch { blocks, textures, inputs, count: *count, limit }
    }
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rendered {
    pub picture: Picture,
    pub fragments: u64,
    /// The fragments discarded by the shader, which show the background.
    pub discarded: u64,
    /// The light evaluations over all fragments, including empty slots of loops without a count.
    pub evaluations: u64,
    pub uploaded: u64,
}

#[derive(Clone, Debug)]
pub enum RenderError {
    Shader(Vec<Diagnostic>),
    /// The scene does not fit the shader.
    Bind(BindError),
    /// The backend refused or failed.
    Backend(Failure),
}

impl From<BindError> for RenderError {
    fn from(error: BindError) -> RenderError {
        RenderError::Bind(error)
    }
}

impl From<Failure> for RenderError {
    fn from(failure: Failure) -> RenderError {
        RenderError::Backend(failure)
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
            RenderError::Backend(failure) => failure.fmt(f),
        }
    }
}

impl std::error::Error for RenderError {}

impl Renderer {
    /// Compiles a shader for lighting scenes.
    ///
    /// # Errors
    /// A shader that cannot run, has no lights, or does not fit a binding.
    pub fn new(source: &Source, options: &RenderOptions<'_>) -> Result<Renderer, RenderError> {
        let made = FragmentShader::new(source, &options.layout, options.entry);
        let shader = made.map_err(RenderError::Shader)?;
        let guessed = infer(&shader, &source.path, &source.text);
        let no_lights = guessed.as_ref().err().cloned();
        let mut map = guessed.unwrap_or_else(|_| crate::bind::members(&shader));
        for given in &options.bind {
            map = overridden(map, given)?;
        }
        let given = |key: &str| options.bind.iter().any(|given| given.contains_key(key));
        let mut cpu = Cpu::new(Settings { threads: 1, ..Settings::default() });
        // What names leave open is decided by running the shader.
        let map = decide(&shader, map, &given, &mut cpu)?;
        // A missing inference does not matter if all lights are bound explicitly.
        if let Some(error) = no_lights.filter(|_| !map.lights()) {
            return Err(error.into());
        }
        let filler = BlockWriter::new(&shader, &map)?;
        Ok(Renderer { shader, map, filler, programs: cpu.programs() })
    }

    /// Returns an interpreter that has compiled the shader, if the binding was decided by running
    /// it.
    pub fn cpu(&self, settings: Settings) -> Cpu {
        Cpu::with_programs(settings, &self.programs)
    }

    /// Returns the ambient light, and the others for which the shader has slots.
    ///
    /// # Errors
    /// More lights than slots, unless the policy leaves them out; a camera that is not where the
    /// shader takes it to be.
    pub fn lights(&self, upload: &Upload, excess: OverflowPolicy) -> Result<LightSet, BindError> {
        if self.map.camera_at_origin && upload.camera != DVec3::ZERO {
            return Err(BindError::CameraElsewhere);
        }
        self.filler.lights(&upload.lights, excess)
    }

    /// Returns the slots of the shader for lights of a kind; `usize::MAX` for a runtime-sized
    /// array.
    pub fn slots(&self, kind: Kind) -> usize {
        self.filler.slots(kind)
    }

    /// Returns the lights the shader evaluates at a fragment: for a kind without a count, every
    /// slot.
    pub fn evaluated(&self, lit: &LightSet) -> u64 {
        Kind::ALL.into_iter().map(|kind| self.walked(kind, lit)).sum()
    }

    /// Returns the slots of a kind that the shader visits for a fragment, evaluated or not: for a
    /// kind without a count, every one.
    pub fn walked(&self, kind: Kind, lit: &LightSet) -> u64 {
        let lights = lit.of(kind).len();
        let slots = self.filler.slots(kind);
        let counted = self.counts(kind) || slots == usize::MAX;
        if counted { lights as u64 } else { slots as u64 }
    }

    /// Returns the bindings with NaN as the colours of the light in a slot, so that the fragments
    /// it reaches show it; `None` for a shader without colours of such lights.
    pub fn marked(&self, prepared: &Prepared, kind: Kind, slot: usize) -> Option<Prepared> {
        let mut marked = prepared.clone();
        self.filler.mark(&mut marked.blocks, kind, slot).then_some(marked)
    }

    /// Whether the shader has a count of the lights of a kind.
    fn counts(&self, kind: Kind) -> bool {
        let count = Some(Quantity::Count(kind));
        self.map.members.iter().any(|member| member.source.quantity() == count)
    }

    /// Returns the slots without a light that the shader evaluates anyway.
    pub fn unused_slots(&self, lit: &LightSet) -> u64 {
        self.evaluated(lit).saturating_sub(lit.count() as u64)
    }

    /// Returns notes on material properties that the shader cannot represent.
    pub fn notes(&self, upload: &Upload) -> Vec<String> {
        let mut notes: Vec<String> = self.map.notes.clone();
        notes.extend(upload.materials.iter().flat_map(|material| self.filler.notes(material)));
        notes.dedup();
        notes
    }

    /// Lights fragments of one material. `take` receives the colours of each job's fragments and
    /// which of them were discarded, maybe on another thread; `after` the backend and the number of
    /// fragments after each job. Returns the bytes of blocks uploaded.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the backend.
    pub fn light<R: Backend + ?Sized>(
        &self,
        backend: &mut R,
        work: &Work<'_>,
        fragments: Chosen<'_>,
        draw: &Draw<'_>,
        take: impl FnMut(&[[f32; 4]], &[bool]) + Send,
        after: impl FnMut(&mut R, usize),
    ) -> Result<u64, RenderError> {
        let Some(first) = fragments.iter().next() else { return Ok(0) };
        let material = work.upload.materials.get(first.material as usize);
        let material = material.expect("a fragment's material is one of the upload's");
        self.within_limits(backend.device(), draw)?;
        let writer = &self.filler;
        let blocks = writer.blocks(work.upload, draw.lights, material, draw.tiles)?;
        let size = [work.frame.width, work.frame.height];
        let batch = Batch {
            blocks: &blocks,
            textures: &writer.textures(material),
            inputs: &FragmentInputs { writer, fragments, size },
            count: fragments.numbers.len(),
            limit: work.limit,
        };
        self.shader.run_into(backend, &batch, take, after)?;
        Ok(blocks.iter().map(|bytes| bytes.len() as u64).sum())
    }

    /// Returns the bindings for lighting fragments of one material, to be run repeatedly.
    ///
    /// # Errors
    /// More lights than slots.
    pub fn prepare(
        &self,
        work: &Work<'_>,
        fragments: Chosen<'_>,
        draw: &Draw<'_>,
    ) -> Result<Prepared, RenderError> {
        let Some(first) = fragments.iter().next() else { return Ok(Prepared::default()) };
        let material = work.upload.materials.get(first.material as usize);
        let material = material.expect("a fragment's material is one of the upload's");
        let filler = &self.filler;
        Ok(Prepared {
            blocks: filler.blocks(work.upload, draw.lights, material, draw.tiles)?,
            textures: filler.textures(material),
            inputs: filler.inputs(fragments, [work.frame.width, work.frame.height]),
            count: fragments.numbers.len(),
        })
    }

    /// Renders the picture of the draws; fragments in none of them show the background.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the backend.
    pub fn render<R: Backend + ?Sized>(
        &self,
        backend: &mut R,
        work: &Work<'_>,
        draws: &[Draw<'_>],
        after: &mut dyn FnMut(&mut R, usize),
    ) -> Result<Rendered, RenderError> {
        self.render_onto(work.picture(), backend, work, draws, after)
    }

    /// Renders the draws onto a picture; one without pixels stays so.
    fn render_onto<R: Backend + ?Sized>(
        &self,
        picture: Picture,
        backend: &mut R,
        work: &Work<'_>,
        draws: &[Draw<'_>],
        after: &mut dyn FnMut(&mut R, usize),
    ) -> Result<Rendered, RenderError> {
        let fragments = &work.frame.fragments;
        let mut rendered = Rendered { picture, ..Rendered::default() };
        for draw in draws {
            let chosen = Chosen { all: fragments, numbers: draw.fragments };
            let each = chosen.by_material(work.upload.materials.len());
            for numbers in each.iter().filter(|numbers| !numbers.is_empty()) {
                let same = Chosen { numbers, ..chosen };
                let Rendered { picture, discarded: left_out, .. } = &mut rendered;
                let mut lit = same.iter();
                let take = |colors: &[[f32; 4]], discarded: &[bool]| {
                    for (at, (color, fragment)) in colors.iter().zip(lit.by_ref()).enumerate() {
                        if discarded.get(at) == Some(&true) {
                            *left_out += 1;
                        } else if let Some(pixel) = picture.pixels.get_mut(fragment.pixel as usize)
                        {
                            *pixel = *color;
                        }
                    }
                };
                // Materials are uploaded in blocks, so each run is of one material.
                let bytes = self.light(backend, work, same, draw, take, &mut *after)?;
                rendered.fragments += numbers.len() as u64;
                rendered.evaluations += numbers.len() as u64 * self.evaluated(draw.lights);
                rendered.uploaded += bytes;
            }
        }
        Ok(rendered)
    }
}

pub(super) fn background(color: DVec3) -> [f32; 4] {
    let [r, g, b] = color.as_vec3().to_array();
    [r, g, b, 1.0]
}
