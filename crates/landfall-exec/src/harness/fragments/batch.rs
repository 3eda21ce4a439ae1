//! Packs fragments into images, runs them, and unpacks the results.

use crate::backend::BackendKind;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use super::{ATLAS, FragmentShader, SIZE};
use crate::backend::{
    Backend, Failure, Grid, Job, LooseUniform, Resource, ResourceKind, StageCode, Texel,
};
use crate::harness::bindings as bound;
use crate::harness::verify::{all_buffers, request};
use landfall_ir::Module;
use landfall_ir::module::HandleKind;
use landfall_layout::buffer::decode;
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::Stage;

/// A list of fragments and the resources bound for it.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// The bytes of each block, in the order of [`FragmentShader::blocks`].
    pub blocks: &'a [Vec<u8>],
    /// The textures, in the order of [`FragmentShader::textures`].
    pub textures: &'a [Image],
    /// The values of each input, in the order of [`FragmentShader::inputs`].
    pub inputs: &'a dyn Inputs,
    /// The number of fragments.
    pub count: usize,
    /// The time limit of one job; a backend that exceeds it has failed.
    pub limit: Duration,
}

/// The values of a shader's inputs at a list of fragments.
///
/// They are asked for by job, so that those of a large picture need not exist at once.
pub trait Inputs: fmt::Debug + Sync {
    /// Returns the number of fragments of each input.
    fn counts(&self) -> Vec<usize>;

    /// Appends the values of an input at some fragments, components first.
    fn append(&self, input: usize, fragments: Range<usize>, to: &mut Vec<[f32; 4]>);
}

impl Inputs for Vec<Vec<[f32; 4]>> {
    fn counts(&self) -> Vec<usize> {
        self.iter().map(Vec::len).collect()
    }

    fn append(&self, input: usize, fragments: Range<usize>, to: &mut Vec<[f32; 4]>) {
        to.extend_from_slice(&self[input][fragments]);
    }
}

/// A texture: four floats a texel.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in texels.
    pub width: u32,
    /// Height in texels, first row first.
    pub height: u32,
    /// `width * height` texels.
    pub texels: Vec<[f32; 4]>,
}

/// The results of a list of fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shaded {
    /// Output location 0 of each fragment; zeros if discarded.
    pub colors: Vec<[f32; 4]>,
    /// Whether each fragment was discarded; empty if the shader never discards.
    pub discarded: Vec<bool>,
}

/// Maximum number of fragments in one job: keeps a backend busy and still shows progress.
const LIMIT: usize = 1 << 16;

/// The interpreter's first of several jobs has [`LIMIT`] divided by this: nothing runs while it is packed.
const FIRST_DIVISOR: usize = 4;

/// Width of the image in pixels, on drivers.
const ROW: usize = 256;

/// Width and height of a texture that every driver supports.
const SIDE: usize = 8192;

impl FragmentShader {
    /// Runs the shader over fragments. `after` is called after each job with the backend and the
    /// job's number of fragments.
    ///
    /// # Errors
    /// Fails if the backend rejects the shader or the buffers, or their number is wrong.
    pub fn run<R: Backend + ?Sized>(
        &self,
        backend: &mut R,
        batch: &Batch<'_>,
        after: impl FnMut(&mut R, usize),
    ) -> Result<Shaded, Failure> {
        let mut shaded = Shaded::default();
        shaded.colors.reserve(batch.count);
        let take = |colors: &[[f32; 4]], discarded: &[bool]| {
            shaded.colors.extend_from_slice(colors);
            shaded.discarded.extend_from_slice(discarded);
        };
        self.run_into(backend, batch, take, after)?;
        Ok(shaded)
    }

    /// Runs the shader over fragments. `take` receives in order the colours of each job's fragments and
    /// which of them were discarded, as in [`Shaded`], while the next job runs, maybe on another thread;
    /// `after` is called after each job with the backend and the job's number of fragments, before its
    /// colours are taken.
    ///
    /// # Errors
    /// As [`FragmentShader::run`].
    pub fn run_into<R: Backend + ?Sized>(
        &self,
        backend: &mut R,
        batch: &Batch<'_>,
        mut take: impl FnMut(&[[f32; 4]], &[bool]) + Send,
        mut after: impl FnMut(&mut R, usize),
    ) -> Result<(), Failure> {
        let is_gl = backend.device().backend == BackendKind::Gl;
        let whole = backend.device().backend == BackendKind::Cpu;
        self.fits(batch)?;
        // As many rows of fragments as there is room for, one range of them below the other for
        // each input.
        let rows = (SIDE / self.inputs.len().max(1)).clamp(1, LIMIT / ROW);
        let most = if whole { LIMIT } else { rows * ROW };
        let fixed = if is_gl { self.for_gl(batch) } else { self.for_module(batch) };
        let mut jobs = Jobs::new(self, is_gl, fixed, batch.limit)?;
        // The interpreter counts operations, so it gets no padding pixels.
        let pack = |from: usize, count: usize| {
            self.pack(batch, from, count, if whole { count } else { ROW.min(count) })
        };
        let first = if whole && batch.count > most { most / FIRST_DIVISOR } else { most };
        let counts = |from: usize| if from == 0 { first } else { most }.min(batch.count - from);
        let mut from = 0;
        let mut packed = (batch.count > 0).then(|| pack(0, counts(0)));
        let mut done: Option<BatchOutput> = None;
        while let Some(image) = packed.take() {
            let count = counts(from);
            jobs.put(self, image);
            let then = from + count;
            // The results of the last job are taken and the next one is packed while this one runs.
            let last = done.take();
            let mut other = || {
                if let Some(last) = &last {
                    take(last.colors(), &last.discarded);
                }
                packed = (then < batch.count).then(|| pack(then, counts(then)));
            };
            let is_only = count == batch.count;
            done = Some(jobs.run(backend, count, (!is_only).then_some(&mut other))?);
            after(backend, count);
            from = then;
        }
        if let Some(done) = done {
            take(done.colors(), &done.discarded);
        }
        Ok(())
    }

    pub(super) fn fits(&self, batch: &Batch<'_>) -> Result<(), Failure> {
        let check = |what: &str, wanted: usize, given: usize| match wanted == given {
            true => Ok(()),
            false => {
                let message = format!("the shader has {wanted} {what}, but {given} were given");
                Err(Failure::refused(message, ""))
            }
        };
        check("blocks", self.blocks().len(), batch.blocks.len())?;
        check("textures", self.textures().count(), batch.textures.len())?;
        let counts = batch.inputs.counts();
        check("inputs", self.inputs.len(), counts.len())?;
        counts.iter().find(|count| **count < batch.count).map_or(Ok(()), |count| {
            let message = format!("{} fragments, but an input has only {count}", batch.count);
            Err(Failure::refused(message, ""))
        })
    }

    /// Packs the inputs of some fragments, one below the other; the last fragment fills up the last
    /// row.
    pub(super) fn pack(&self, batch: &Batch<'_>, from: usize, count: usize, width: usize) -> Image {
        let rows = count.div_ceil(width);
        let size = rows * width;
        let mut texels = Vec::with_capacity(size * self.inputs.len().max(1));
        for input in 0..self.inputs.len() {
            batch.inputs.append(input, from..from + count, &mut texels);
            let last = texels.last().copied().unwrap_or_default();
            texels.extend(std::iter::repeat_n(last, size - count));
        }
        // A texture has one row at least, also without inputs.
        if texels.is_empty() {
            texels.resize(size, [0.0; 4]);
        }
        Image { width: width as u32, height: (texels.len() / width) as u32, texels }
    }

    /// Returns the resources that all jobs share, by the bindings of the module.
    pub(super) fn for_module(&self, batch: &Batch<'_>) -> Vec<Resource> {
        let blocks = self.blocks().iter().zip(batch.blocks).zip(&self.writable);
        let blocks = blocks.map(|((block, bytes), writable)| Resource {
            name: block.layout.name.to_string(),
            group: block.group,
            binding: block.binding,
            kind: bound::kind(&block.layout, bytes.clone(), *writable),
        });
        let mut resources: Vec<Resource> = blocks.collect();
        let mut images = batch.textures.iter();
        // In the order of the handles, as `textures` lists them.
        for handle in self.module.handles() {
            let kind = match handle.kind {
                HandleKind::Texture => images.next().map(texture),
                HandleKind::Sampler => Some(ResourceKind::Sampler),
                HandleKind::Image => None,
            };
            let (name, group, binding) = (handle.path.clone(), handle.group, handle.binding);
            resources.extend(kind.map(|kind| Resource { name, group, binding, kind }));
        }
        resources
    }

    /// Returns the resources that all jobs share, by OpenGL's names.
    fn for_gl(&self, batch: &Batch<'_>) -> Vec<Resource> {
        let mut resources = Vec::new();
        let blocks = self.blocks().iter().zip(batch.blocks).zip(&self.writable);
        for ((block, bytes), writable) in blocks {
            let elements = all_buffers(&block.layout.count);
            let nth = block.element.and_then(|nth| elements.get(nth as usize));
            let name = request::gl_name(&block.layout.name, nth.map_or(&[], |nth| nth.as_slice()));
            let kind = match self.is_loose(&block.layout) {
                true => ResourceKind::Loose(loose(&block.layout, bytes)),
                false => bound::kind(&block.layout, bytes.clone(), *writable),
            };
            resources.push(Resource { name, group: 0, binding: 0, kind });
        }
        for (handle, image) in self.textures().zip(batch.textures) {
            let name = handle.path.clone();
            resources.push(Resource { name, group: 0, binding: 0, kind: texture(image) });
        }
        resources
    }
}

fn texture(image: &Image) -> ResourceKind {
    let Image { width, height, texels } = image.clone();
    ResourceKind::Texture { width, height, texels }
}

/// Returns every element of a block of loose uniforms by its name.
fn loose(block: &BlockLayout, bytes: &[u8]) -> Vec<LooseUniform> {
    let mut uniforms = Vec::new();
    if let Ok(decoded) = decode(block, bytes) {
        decoded.for_each(|element| {
            let words = element.cells.iter().map(|cell| cell.bits as u32).collect();
            uniforms.push(LooseUniform { name: element.path.to_string(), words });
        });
    }
    uniforms
}

/// The results of a job.
struct BatchOutput {
    pixels: Vec<[u32; 4]>,
    /// As in [`Shaded`].
    discarded: Vec<bool>,
}

impl BatchOutput {
    fn colors(&self) -> &[[f32; 4]] {
        bytemuck::cast_slice(&self.pixels)
    }
}

/// The jobs of a batch, which differ in the texture of inputs and its size alone.
pub(super) struct Jobs {
    shading: Job,
    covering: Option<Job>,
    /// The index of the texture of inputs among the resources.
    atlas: usize,
    /// The index of the uniform with its size.
    size: Option<usize>,
}

impl Jobs {
    pub(super) fn new(
        shader: &FragmentShader,
        is_gl: bool,
        mut resources: Vec<Resource>,
        limit: Duration,
    ) -> Result<Jobs, Failure> {
        let texts = match (is_gl, &shader.texts) {
            (true, None) => return Err(Failure::refused("OpenGL does not accept WGSL", "")),
            (true, Some((text, covered))) => Some((text, covered)),
            (false, _) => None,
        };
        let stage = |module: &Arc<Module>, text: Option<&String>| StageCode {
            stage: Stage::Fragment,
            entry: shader.entry.clone(),
            module: (!is_gl).then(|| Arc::clone(module)),
            text: text.cloned(),
            spirv: None,
        };
        // `put` sets the size.
        let grid = Grid::Image { width: 0, height: 0, texel: Texel::Float };
        let job = |stage, resources| Job { stages: vec![stage], resources, grid, limit };
        let (group, binding) = shader.atlas;
        let atlas = resources.len();
        let name = ATLAS.to_string();
        let kind = ResourceKind::Texture { width: 0, height: 0, texels: Vec::new() };
        resources.push(Resource { name, group, binding, kind });
        let mut size = None;
        if is_gl && shader.wants_size {
            // With the loose uniforms, if the shader has some.
            let found = resources.iter().position(|r| matches!(r.kind, ResourceKind::Loose(_)));
            size = Some(found.unwrap_or(resources.len()));
            if found.is_none() {
                let (name, kind) = (SIZE.to_string(), ResourceKind::Loose(Vec::new()));
                resources.push(Resource { name, group: 0, binding: 0, kind });
            }
        }
        let covering = shader.covered.as_ref().map(|module| {
            job(stage(module, texts.and_then(|(_, covered)| covered.as_ref())), Vec::new())
        });
        let shading = job(stage(&shader.module, texts.map(|(text, _)| text)), resources);
        Ok(Jobs { shading, covering, atlas, size })
    }

    pub(super) fn put(&mut self, shader: &FragmentShader, image: Image) {
        let Image { width, height, texels } = image;
        let rows = height / shader.inputs.len().max(1) as u32;
        self.shading.grid = Grid::Image { width, height: rows, texel: Texel::Float };
        let resources = &mut self.shading.resources;
        if let Some(ResourceKind::Loose(uniforms)) = self.size.map(|at| &mut resources[at].kind) {
            // That of the job before.
            uniforms.retain(|uniform| uniform.name != SIZE);
            let words = [width, rows].map(|n| (n as f32).to_bits()).to_vec();
            uniforms.push(LooseUniform { name: SIZE.to_string(), words });
        }
        resources[self.atlas].kind = ResourceKind::Texture { width, height, texels };
    }

    /// Returns the job that computes the colours.
    pub(super) fn shading(&self) -> &Job {
        &self.shading
    }

    /// Runs the job for `count` fragments, and `other` concurrently.
    fn run<R: Backend + ?Sized>(
        &mut self,
        backend: &mut R,
        count: usize,
        other: Option<&mut (dyn FnMut() + Send)>,
    ) -> Result<BatchOutput, Failure> {
        let mut pixels = match other {
            Some(other) => backend.run_concurrently(&self.shading, other)?.pixels,
            None => backend.run(&self.shading)?.pixels,
        };
        pixels.truncate(count);
        let mut discarded = Vec::new();
        if let Some(covering) = &mut self.covering {
            // The resources are moved to the second job and back: they may be large.
            covering.resources = std::mem::take(&mut self.shading.resources);
            covering.grid = self.shading.grid;
            let answer = backend.run(covering);
            self.shading.resources = std::mem::take(&mut covering.resources);
            // That job gives white where the shader does not discard.
            discarded.extend(answer?.pixels[..count].iter().map(|pixel| pixel[0] == 0));
        }
        for (pixel, _) in pixels.iter_mut().zip(&discarded).filter(|(_, is)| **is) {
            *pixel = [0; 4];
        }
        Ok(BatchOutput { pixels, discarded })
    }
}
