//! What it is to run a shader once: a job in, an answer out, whoever runs it.
//!
//! The interpreter ([`interp`](crate::interp)) and the drivers (`gl`, `gpu`) are the
//! readers; probes and the functions of a shader are the jobs.

pub mod devices;
#[cfg(feature = "gl")]
pub mod gl;
#[cfg(any(feature = "gl", feature = "gpu"))]
mod limits;
pub mod reflection;
mod runs;
#[cfg(any(feature = "gl", feature = "gpu"))]
pub mod subprocess;
#[cfg(feature = "gpu")]
pub mod wgpu;

pub use runs::{executable, single_run};

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::backend::reflection::Reflection;
use landfall_ir::Module;
use landfall_layout::source::Stage;

/// One upload and one run.
#[derive(Clone, Debug)]
pub struct Job {
    /// The programmable stages, in the order of the pipeline.
    pub stages: Vec<StageCode>,
    /// Everything that is bound.
    pub resources: Vec<Resource>,
    /// How often it runs, and what comes back.
    pub grid: Grid,
    /// A reader that is not done by then has failed.
    pub limit: Duration,
}

/// The code of one stage in every form some reader takes.
#[derive(Clone, Debug)]
pub struct StageCode {
    /// Vertex, fragment or compute.
    pub stage: Stage,
    /// Name of the entry point in the module; GLSL's is always `main`.
    pub entry: String,
    /// For the evaluator and wgpu.
    pub module: Option<Arc<Module>>,
    /// For OpenGL: the text as its compiler takes it.
    pub glsl: Option<String>,
    /// For Vulkan: what a compiler of the user's made of it.
    pub spirv: Option<Arc<[u32]>>,
}

/// How often a job runs, and what comes back besides the writable buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Grid {
    /// Compute: so many workgroups; the results are in writable buffers.
    Groups([u32; 3]),
    /// Fragment: a triangle over an image of that size; each pixel is four words
    /// of output location 0. A vertex stage is supplied where the job has none.
    Image {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// What the output's components are.
        texel: Texel,
    },
    /// Vertex: so many vertices, drawn as points; the fragment stage of the job carries
    /// what vertex `i` wrote to pixel `i` of an image one row high.
    Points {
        /// Vertices.
        count: u32,
        /// What the fragment stage's components are.
        texel: Texel,
    },
}

/// What the components of an image are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Texel {
    /// 32-bit floats.
    Float,
    /// 32-bit unsigned integers.
    Uint,
}

/// Something a shader reads or writes.
#[derive(Clone, Debug, PartialEq)]
pub struct Resource {
    /// The block's or variable's name: OpenGL binds by it.
    pub name: String,
    /// Group, or descriptor set, in the module.
    pub group: u32,
    /// Binding in the module.
    pub binding: u32,
    /// What it is.
    pub kind: ResourceKind,
}

/// What is bound.
#[derive(Clone, Debug, PartialEq)]
pub enum ResourceKind {
    /// A uniform buffer of those bytes.
    Uniform(Vec<u8>),
    /// A storage buffer of those bytes; what is left in it comes back when `writable`.
    Storage {
        /// Its bytes before the run.
        bytes: Vec<u8>,
        /// Whether the shader may write it.
        writable: bool,
    },
    /// Push constants, or immediates.
    PushConstant(Vec<u8>),
    /// A two-dimensional image that is sampled: four floats a texel, rows from the first.
    Texture {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// `width * height` texels.
        texels: Vec<[f32; 4]>,
    },
    /// The sampler beside a texture: nearest, repeating.
    Sampler,
    /// OpenGL's uniforms outside of blocks; other readers have them in a block and ignore this.
    Loose(Vec<LooseUniform>),
}

/// A uniform outside of blocks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LooseUniform {
    /// One element as OpenGL spells it: `lights[2].color`.
    pub name: String,
    /// Its components, column by column, 32 bits each.
    pub words: Vec<u32>,
}

/// What came back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// For each resource, what is left in it if it is a writable buffer.
    pub buffers: Vec<Option<Vec<u8>>>,
    /// The image of a grid that has one: the bits of four words a pixel, rows from the first.
    pub pixels: Vec<[u32; 4]>,
}

/// The kinds of backends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum BackendKind {
    /// Landfall's own interpreter.
    Cpu,
    /// The OpenGL driver.
    Gl,
    /// Vulkan, Metal or DX12 through wgpu.
    Gpu,
}

impl BackendKind {
    /// Every kind.
    pub const ALL: [BackendKind; 3] = [BackendKind::Cpu, BackendKind::Gl, BackendKind::Gpu];

    /// Returns the name on the command line and in reports: `cpu`, `gl`, `gpu`.
    pub fn name(self) -> &'static str {
        match self {
            BackendKind::Cpu => "cpu",
            BackendKind::Gl => "gl",
            BackendKind::Gpu => "gpu",
        }
    }

    /// Returns the kind of that name.
    pub fn from_name(name: &str) -> Option<BackendKind> {
        BackendKind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Returns whether it is a driver, which may end, hang or differ from another.
    pub fn is_driver(self) -> bool {
        self != BackendKind::Cpu
    }
}

impl fmt::Display for BackendKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Who ran it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// What kind it is.
    pub reader: BackendKind,
    /// The adapter's name, such as `llvmpipe (LLVM 15.0.6, 256 bits)`.
    pub adapter: String,
    /// The driver, such as `Mesa` or `Vulkan`.
    pub driver: String,
    /// Its version.
    pub version: String,
    /// Whether it computes on the processor.
    pub software: bool,
}

/// Why a job has no answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// What kind of failure.
    pub kind: FailureKind,
    /// One line for people.
    pub message: String,
    /// What the driver or its compiler said, if anything.
    pub log: String,
}

/// The kinds of [`Failure`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FailureKind {
    /// There is no such reader here.
    Missing,
    /// It does not take this shader: its compiler or its limits say no.
    Refused,
    /// The shader is nothing that can be run this way at all.
    Unfit,
    /// It stopped while it ran: a crash, a lost device.
    Died,
    /// It was not done within the limit, or the budget of steps.
    TimedOut,
}

impl Failure {
    /// There is no such reader here.
    pub fn missing(message: impl Into<String>, log: impl Into<String>) -> Failure {
        Failure { kind: FailureKind::Missing, message: message.into(), log: log.into() }
    }

    /// It does not take this shader.
    pub fn refused(message: impl Into<String>, log: impl Into<String>) -> Failure {
        Failure { kind: FailureKind::Refused, message: message.into(), log: log.into() }
    }

    /// It stopped while it ran.
    pub fn died(message: impl Into<String>, log: impl Into<String>) -> Failure {
        Failure { kind: FailureKind::Died, message: message.into(), log: log.into() }
    }

    /// It was not done in time.
    pub fn timed_out(limit: Duration) -> Failure {
        let message = format!("not done after {:.1} s, which is its limit", limit.as_secs_f64());
        Failure { kind: FailureKind::TimedOut, message, log: String::new() }
    }
}

impl Failure {
    /// The message and, on the same line, the first thing the driver said was wrong.
    pub fn brief(&self) -> String {
        let mut lines = self.log.lines().map(str::trim).filter(|line| !line.is_empty());
        let first = lines.clone().next();
        let wrong = lines.find(|line| line.to_ascii_lowercase().contains("error"));
        match wrong.or(first) {
            Some(line) => format!("{}: {line}", self.message),
            None => self.message.clone(),
        }
    }
}

impl fmt::Display for Failure {
    /// The message, and below it what the driver said.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match self.log.trim_end() {
            "" => Ok(()),
            log => write!(f, "\n{log}"),
        }
    }
}

impl std::error::Error for Failure {}

/// Something that runs jobs.
pub trait Reader {
    /// Who it is.
    fn device(&self) -> &Device;

    /// Runs a job.
    ///
    /// # Errors
    /// Why there is no answer; the reader can be asked again unless it died.
    fn run(&mut self, job: &Job) -> Result<Answer, Failure>;

    /// How long the device worked at the last job, by timestamps of its own; `None` where it
    /// has none or is no device of its own.
    fn device_time(&self) -> Option<Duration> {
        None
    }

    /// How long processors worked at the last job where that was in another process; `None` of
    /// what runs in this one, whose clock has it.
    fn processor_time(&self) -> Option<Duration> {
        None
    }

    /// What its compiler says of texts as they are, within that time; `None` where it has none.
    fn reflect(
        &mut self,
        _texts: &[(Stage, &str)],
        _limit: Duration,
    ) -> Option<Result<Reflection, Failure>> {
        None
    }
}
