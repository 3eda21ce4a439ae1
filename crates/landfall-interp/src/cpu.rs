//! The interpreter as a [`Backend`]: grids of workgroups, pixels and points.
//!
//! Takes a [`Job`], compiles its modules once, runs them with [`drive`](super::drive).

use crate::backend::BackendKind;
use std::path::Path;
use std::sync::{Arc, Mutex};

use super::code::{Class, LANES, Reg};
use super::drive::{Other, Outcome, run_other};
use super::interface::{InterfaceVariable, Port};
use super::lanes::Lanes;
use super::machine::Machine;
use super::numbers::Numbers;
use super::pixels::{Triangle, row, tile};
use super::program::{BufferSpace, Floats, Program};
use super::real::Real;
use super::shadow::Shadow;
use super::stage::{
    Invocations, Notes, Precision, Settings, failure, mask, refused_for, set_register,
};
use crate::backend::{Backend, Device, Failure, FailureKind, Grid, Job, JobOutput, StageCode};
use landfall_ir::Module;
use landfall_layout::source::{Language, Stage, kind_of_path};

/// The interpreter as a [`Backend`].
#[derive(Debug)]
pub struct Cpu {
    /// The settings of runs; a job's limit becomes the deadline.
    pub settings: Settings,
    /// The notes of the last run.
    pub notes: Notes,
    device: Device,
    compiled: Programs,
}

/// Modules that an interpreter has compiled, the last eight of them.
#[derive(Clone, Debug)]
pub struct Programs {
    /// How their floats are rounded.
    floats: Floats,
    list: Vec<(Arc<Module>, Arc<Program>)>,
}

impl Programs {
    /// Whether these are the same programs, not others of the same modules.
    pub(super) fn is_same(&self, other: &Programs) -> bool {
        let same = |((_, a), (_, b)): (&(_, Arc<Program>), &(_, Arc<Program>))| Arc::ptr_eq(a, b);
        self.list.len() == other.list.len() && self.list.iter().zip(&other.list).all(same)
    }
}

/// The number of compiled modules kept, which [`Programs`] states.
const KEPT: usize = 8;

impl Cpu {
    pub fn new(settings: Settings) -> Cpu {
        Cpu::rounded(settings, Floats::AsWritten)
    }

    /// Returns an interpreter whose floats are rounded to a lower precision.
    pub fn rounded(settings: Settings, floats: Floats) -> Cpu {
        let device = Device {
            backend: BackendKind::Cpu,
            adapter: "landfall evaluator".into(),
            driver: "landfall".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            software: true,
        };
        let compiled = Programs { floats, list: Vec::new() };
        Cpu { settings, notes: Notes::default(), device, compiled }
    }

    /// Returns an interpreter with the given settings that need not compile what another one has
    /// compiled, its [`programs`](Cpu::programs). Its floats are rounded as theirs.
    pub fn with_programs(settings: Settings, programs: &Programs) -> Cpu {
        Cpu { compiled: programs.clone(), ..Cpu::new(settings) }
    }

    /// Returns the modules that the interpreter has compiled.
    pub fn programs(&self) -> Programs {
        self.compiled.clone()
    }

    /// Returns the compiled module of a stage.
    pub fn program(&mut self, stage: &StageCode) -> Result<Arc<Program>, Failure> {
        let Some(module) = &stage.module else {
            return Err(refused_for("a stage without a module"));
        };
        let Programs { floats, list: compiled } = &mut self.compiled;
        if let Some((_, program)) = compiled.iter().find(|(m, _)| Arc::ptr_eq(m, module)) {
            return Ok(program.clone());
        }
        let program = Arc::new(Program::rounded(module, &[], *floats));
        // The oldest goes.
        if compiled.len() == KEPT {
            compiled.remove(0);
        }
        compiled.push((module.clone(), program.clone()));
        Ok(program)
    }

    fn run_in<R: Real>(&mut self, job: &Job, other: &Other) -> Result<JobOutput, Failure> {
        let deadline = crate::backend::deadline(job.limit);
        let settings = Settings { deadline, ..self.settings.clone() };
        let stage = |kind: Stage| job.stages.iter().find(|s| s.stage == kind);
        let (notes, buffers, pixels) = match job.grid {
            Grid::Groups(groups) => {
                let Some(code) = stage(Stage::Compute) else {
                    return Err(failure(FailureKind::Refused, "no compute stage to run".into()));
                };
                let program = self.program(code)?;
                let outcome = compute::<R>(&program, &code.entry, groups, job, &settings)?;
                (outcome.notes, outcome.left, Vec::new())
            }
            Grid::Image { width, height, .. } => {
                let Some(code) = stage(Stage::Fragment) else {
                    return Err(failure(FailureKind::Refused, "no fragment stage to run".into()));
                };
                let program = self.program(code)?;
                let triangle = match stage(Stage::Vertex) {
                    Some(vertex) => Some(self.triangle(vertex, &program, code, job, &settings)?),
                    None => None,
                };
                let size = [width, height];
                let drawn = DrawnStages { entry: &code.entry, size, triangle: triangle.as_ref() };
                let (outcome, pixels) = image::<R>(&program, &drawn, job, &settings, other)?;
                (outcome.notes, outcome.left, pixels)
            }
            Grid::Points { count, .. } => {
                let (Some(vertex), Some(code)) = (stage(Stage::Vertex), stage(Stage::Fragment))
                else {
                    let message = "no vertex and fragment stage to run".into();
                    return Err(failure(FailureKind::Refused, message));
                };
                let vertices = self.vertices(vertex, count as usize, job, &settings)?;
                let program = self.program(code)?;
                let mut inputs = vertices.ports;
                // The vertex with number `i` is drawn as the pixel with that number of the only
                // row, at its centre.
                let columns =
                    (0..u64::from(count)).map(|i| u64::from((i as f32 + 0.5).to_bits())).collect();
                let row = vec![u64::from(0.5f32.to_bits()); count as usize];
                // For fragments, the position is in pixels, not in clip space.
                inputs.retain(|(port, _)| *port != Port::Position);
                let mut inputs: Vec<_> =
                    inputs.into_iter().map(|(port, numbers)| (port, numbers.words)).collect();
                inputs.push((Port::Position, vec![columns, row]));
                let invocations = Invocations { count: count as usize, inputs };
                let outputs =
                    program.run_entry(&code.entry, &invocations, &job.resources, &settings)?;
                let first = outputs.ports.iter().find(|(port, _)| *port == Port::Location(0));
                let pixels = (0..count as usize)
                    .map(|i| first.map_or([0; 4], |(_, numbers)| pixel(numbers, i)))
                    .collect();
                // Of a buffer that both stages may write, the vertex stage's contents are returned.
                let buffers = vertices.buffers.into_iter().zip(outputs.buffers);
                let left = buffers.map(|(vertex, fragment)| vertex.or(fragment)).collect();
                (outputs.notes, left, pixels)
            }
        };
        self.notes = notes;
        Ok(JobOutput { buffers, pixels })
    }

    fn run_with(&mut self, job: &Job, other: &Other) -> Result<JobOutput, Failure> {
        match self.settings.precision {
            Precision::Single => self.run_in::<f32>(job, other),
            Precision::Double => self.run_in::<f64>(job, other),
            Precision::Both => self.run_in::<Shadow>(job, other),
            // The output has room for the `f32` only.
            Precision::Permitted => self.run_in::<f32>(job, other),
        }
    }

    fn vertices(
        &mut self,
        vertex: &StageCode,
        count: usize,
        job: &Job,
        settings: &Settings,
    ) -> Result<super::Outputs, Failure> {
        let program = self.program(vertex)?;
        let numbers: Vec<u64> = (0..count as u64).collect();
        let inputs = vec![(Port::VertexIndex, vec![numbers])];
        let invocations = Invocations { count, inputs };
        program.run_entry(&vertex.entry, &invocations, &job.resources, settings)
    }

    /// Returns the triangle of a vertex stage's first three vertices.
    fn triangle(
        &mut self,
        vertex: &StageCode,
        fragment: &Program,
        code: &StageCode,
        job: &Job,
        settings: &Settings,
    ) -> Result<Triangle, Failure> {
        let entry = fragment.entry(&code.entry)?;
        let interface = fragment.functions[entry as usize].interface.as_ref();
        let plugs = interface.map_or(&[][..], |i| &i.inputs);
        let outputs = self.vertices(vertex, 3, job, settings)?;
        let text = vertex.module.as_ref().and_then(|m| m.files.get(0));
        let wgsl = text
            .and_then(|file| kind_of_path(Path::new(&file.path)))
            .is_some_and(|(language, _)| language == Language::Wgsl);
        Ok(Triangle::new(&outputs.ports, plugs, wgsl))
    }
}

impl Default for Cpu {
    fn default() -> Cpu {
        Cpu::new(Settings::default())
    }
}

impl Backend for Cpu {
    fn device(&self) -> &Device {
        &self.device
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        self.run_with(job, &Other::default())
    }

    fn run_concurrently(
        &mut self,
        job: &Job,
        other: &mut (dyn FnMut() + Send),
    ) -> Result<JobOutput, Failure> {
        let other = Mutex::new(Some(other));
        let answer = self.run_with(job, &other);
        // Where no batch ran.
        run_other(&other);
        answer
    }
}

/// Returns a pixel of a fragment's output.
fn pixel(numbers: &Numbers, lane: usize) -> [u32; 4] {
    let mut pixel = [0; 4];
    for (to, words) in pixel.iter_mut().zip(&numbers.words) {
        *to = words[lane] as u32;
    }
    pixel
}

/// Writes the words of a fragment's output in all lanes.
fn words_of_pixels<R: Real>(m: &mut Machine<R>, regs: &[Reg], pixels: &mut [[u32; 4]]) {
    for (i, &reg) in regs.iter().take(4).enumerate() {
        let to = pixels.iter_mut().map(|pixel| &mut pixel[i]);
        match reg.class() {
            Class::Real => {
                to.zip(m.reals_of(reg).each()).for_each(|(to, x)| *to = x.single().to_bits());
            }
            Class::Word => to.zip(&*m.words_of(reg)).for_each(|(to, x)| *to = *x),
            Class::Wide => to.zip(&*m.wides_of(reg)).for_each(|(to, x)| *to = *x as u32),
        }
    }
}

/// Runs workgroups one after the other.
fn compute<R: Real>(
    program: &Program,
    entry: &str,
    groups: [u32; 3],
    job: &Job,
    settings: &Settings,
) -> Result<Outcome<()>, Failure> {
    let number = program.entry(entry)?;
    let code = &program.functions[number as usize];
    let interface = code.interface.as_ref().expect("an entry point has an interface");
    if interface.stage != Some(Stage::Compute) {
        return Err(failure(FailureKind::Refused, format!("`{entry}` is not a compute stage")));
    }
    let bound = program.bind(number, &job.resources)?;
    let size = interface.workgroup;
    let volume =
        |v: [u32; 3]| v.iter().try_fold(1usize, |product, &n| product.checked_mul(n as usize));
    let (Some(invocations), Some(count)) = (volume(size), volume(groups)) else {
        return Err(failure(FailureKind::Refused, "too many workgroups".into()));
    };
    let chunks = invocations.div_ceil(LANES).max(1);
    let Some(batches) = count.checked_mul(chunks) else {
        return Err(failure(FailureKind::Refused, "too many workgroups".into()));
    };
    // The batches of a workgroup share its variables, which are in the memory of one machine.
    let settings = Settings { threads: 1, ..settings.clone() };
    program.drive::<R, ()>(&bound, batches, &settings, |m, batch| {
        let (group, chunk) = (batch / chunks, batch % chunks);
        // A new workgroup in the same memory: WGSL zeroes its variables.
        if chunk == 0 {
            for (info, memory) in program.buffers.iter().zip(&mut m.buffers) {
                if info.space == BufferSpace::Workgroup {
                    memory.bytes.to_mut().fill(0);
                }
            }
        }
        m.barriers = chunks == 1;
        let lanes = LANES.min(invocations - chunk * LANES);
        let group = split(group, groups);
        for plug in &interface.inputs {
            for (axis, &reg) in plug.regs.iter().enumerate() {
                let words: Vec<u64> = (0..lanes)
                    .map(|lane| {
                        let index = chunk * LANES + lane;
                        let local = split(index, size);
                        u64::from(match plug.port {
                            Port::GlobalInvocationId => {
                                group[axis].wrapping_mul(size[axis]).wrapping_add(local[axis])
                            }
                            Port::LocalInvocationId => local[axis],
                            Port::LocalInvocationIndex => index as u32,
                            Port::WorkgroupId => group[axis],
                            Port::WorkgroupSize => size[axis],
                            Port::NumWorkgroups => groups[axis],
                            _ => 0,
                        })
                    })
                    .collect();
                set_register(m, reg, &words);
            }
        }
        m.invoke(number, program.starts[number as usize], mask(lanes))
    })
}

/// Returns a linear index as coordinates in a box, x running fastest.
fn split(number: usize, size: [u32; 3]) -> [u32; 3] {
    let (x, y) = (size[0].max(1) as usize, size[1].max(1) as usize);
    [(number % x) as u32, (number / x % y) as u32, (number / x / y) as u32]
}

/// What is drawn in an image.
struct DrawnStages<'a> {
    /// The fragment stage's entry point.
    entry: &'a str,
    /// Width and height.
    size: [u32; 2],
    /// What covers the image; all of it is covered otherwise.
    triangle: Option<&'a Triangle>,
}

/// Renders an image in tiles of eight by eight, or row by row if it is low.
fn image<R: Real>(
    program: &Program,
    &DrawnStages { entry, size: [width, height], triangle }: &DrawnStages<'_>,
    job: &Job,
    settings: &Settings,
    other: &Other,
) -> Result<(Outcome<()>, Vec<[u32; 4]>), Failure> {
    let number = program.entry(entry)?;
    let code = &program.functions[number as usize];
    let interface = code.interface.as_ref().expect("an entry point has an interface");
    let bound = program.bind(number, &job.resources)?;
    let helpers = program.uses(number).derivatives;
    let pixels = (width as usize).checked_mul(height as usize).filter(|&n| n <= 1 << 28);
    // Row by row, if tiles would be half empty and no derivatives are taken.
    let rows = height < 8 && !helpers;
    let across = width.div_ceil(8) as usize;
    let batches = match rows {
        true => pixels.map(|pixels| pixels.div_ceil(LANES)),
        false => across.checked_mul(height.div_ceil(8) as usize),
    };
    let places = |batch| if rows { row(batch, width) } else { tile(batch, across) };
    let (Some(batches), Some(pixels)) = (batches, pixels) else {
        let message = format!("an image of {width} by {height} pixels is too large");
        return Err(failure(FailureKind::Refused, message));
    };
    let first = interface.outputs.iter().find(|plug| plug.port == Port::Location(0));
    // Batch by batch; zeros where nothing is written.
    let mut all = vec![[0; 4]; batches * LANES];
    let parts: Vec<Mutex<&mut [[u32; 4]]>> = all.chunks_exact_mut(LANES).map(Mutex::new).collect();
    let outcome = program.drive_with::<R, ()>(&bound, batches, settings, other, |m, batch| {
        let places = places(batch);
        let mut inside = 0u64;
        for (lane, [x, y]) in places.iter().enumerate() {
            inside |= u64::from(*x < width && *y < height) << lane;
        }
        let mut covered = inside;
        match triangle {
            Some(triangle) => {
                covered &= triangle.fill(m, &interface.inputs, &places, [width, height]);
            }
            None => set_positions(m, &interface.inputs, &places),
        }
        // Helper invocations beside the edge, so that derivatives have both sides of a quad.
        let run = if helpers && covered != 0 { u64::MAX } else { covered };
        m.invoke(number, program.starts[number as usize], run)?;
        let output = first.map_or(&[][..], |plug| &plug.regs);
        if let Some(tracer) = m.watch.as_mut().and_then(|watch| watch.tracer.as_mut()) {
            tracer.finish_output(output);
        }
        let mut pixels = parts[batch].lock().expect("the machine does not panic");
        words_of_pixels(m, output, &mut pixels);
        let written = covered & !m.killed;
        for (lane, pixel) in pixels.iter_mut().enumerate() {
            if written >> lane & 1 == 0 {
                *pixel = [0; 4];
            }
        }
        Ok(())
    })?;
    if rows {
        all.truncate(pixels);
        return Ok((outcome, all));
    }
    let mut image = vec![[0; 4]; pixels];
    for (batch, colors) in all.chunks_exact(LANES).enumerate() {
        for ([x, y], color) in places(batch).into_iter().zip(colors) {
            if x < width && y < height {
                image[y as usize * width as usize + x as usize] = *color;
            }
        }
    }
    Ok((outcome, image))
}

/// Sets the inputs of fragments without a vertex stage: their position only.
fn set_positions<R: Real>(
    m: &mut Machine<R>,
    inputs: &[InterfaceVariable],
    places: &[[u32; 2]; LANES],
) {
    for plug in inputs {
        for (axis, &reg) in plug.regs.iter().enumerate() {
            match plug.port {
                Port::Position => {
                    let to = m.reals_of(reg);
                    to.set(|lane| match axis {
                        0 | 1 => R::narrow(places[lane][axis] as f32 + 0.5),
                        2 => R::narrow(0.0),
                        _ => R::narrow(1.0),
                    });
                }
                Port::FrontFacing => *m.words_of(reg) = [1; LANES],
                _ => set_register(m, reg, &[]),
            }
        }
    }
}
