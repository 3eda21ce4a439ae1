//! The interface of everything that executes a shader: a [`Job`] in, a [`JobOutput`] or a
//! [`Failure`] out.
//!
//! [`Cpu`](crate::Cpu) is one; the drivers and browsers of `landfall-exec` are others.

use std::fmt;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::reflection::Reflection;
use landfall_ir::Module;
use landfall_layout::named;
use landfall_layout::source::Stage;

/// A job: shader code, the resources bound to it, and one run.
#[derive(Clone, Debug)]
pub struct Job {
    /// The programmable stages, in the order of the pipeline.
    pub stages: Vec<StageCode>,
    pub resources: Vec<Resource>,
    /// The invocations, and the kind of output.
    pub grid: Grid,
    /// The time limit; a backend that exceeds it has failed.
    pub limit: Duration,
}

/// Returns the end of a time limit that begins now; `None` where there is no clock, as in
/// WebAssembly: there the interpreter ends after its budget of steps.
pub fn deadline(limit: Duration) -> Option<Instant> {
    if cfg!(target_family = "wasm") { None } else { Instant::now().checked_add(limit) }
}

/// The code of one stage in every form that some backend takes.
#[derive(Clone, Debug)]
pub struct StageCode {
    /// The stage: vertex, fragment or compute.
    pub stage: Stage,
    /// The name of the entry point in the module; always `main` in GLSL.
    pub entry: String,
    /// The module for the interpreter and wgpu.
    pub module: Option<Arc<Module>>,
    /// The text for compilers of drivers and browsers: GLSL for OpenGL, GLSL ES 3.00 for WebGL,
    /// WGSL for WebGPU.
    pub text: Option<String>,
    /// SPIR-V of a third-party compiler, for Vulkan.
    pub spirv: Option<Arc<[u32]>>,
}

impl StageCode {
    pub fn of_module(stage: Stage, entry: &str, module: impl Into<Arc<Module>>) -> StageCode {
        let module = Some(module.into());
        StageCode { stage, entry: entry.to_string(), module, text: None, spirv: None }
    }

    /// Returns code of a text whose entry point is `main`.
    pub fn of_text(stage: Stage, text: impl Into<String>) -> StageCode {
        let text = Some(text.into());
        StageCode { stage, entry: "main".to_string(), module: None, text, spirv: None }
    }
}

/// The invocations of a job, and its output besides the writable buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Grid {
    /// Compute workgroups in x, y and z; the results are in writable buffers.
    Groups([u32; 3]),
    /// Fragments: a triangle over an image of this size; each pixel is four words of output
    /// location 0. A vertex stage is supplied if the job has none.
    Image {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// The component type of the output.
        texel: Texel,
    },
    /// Vertices, drawn as points: the job's fragment stage writes the output of vertex `i` to pixel
    /// `i` of an image one row high.
    Points {
        /// The number of vertices.
        count: u32,
        /// The component type of the fragment stage's output.
        texel: Texel,
    },
}

/// The component type of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Texel {
    /// 32-bit floats.
    Float,
    /// 32-bit unsigned integers.
    Uint,
}

/// A resource that a shader reads or writes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resource {
    /// The name of the block or variable, by which OpenGL binds.
    pub name: String,
    /// The group (WGSL) or descriptor set (Vulkan) in the module.
    pub group: u32,
    /// The binding in the module.
    pub binding: u32,
    pub kind: ResourceKind,
}

/// The kind and contents of a resource.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ResourceKind {
    /// The bytes of a uniform buffer.
    Uniform(#[serde(with = "as_bytes")] Vec<u8>),
    /// A storage buffer; its contents after the run are returned if `writable`.
    Storage {
        /// The contents before the run.
        #[serde(with = "as_bytes")]
        bytes: Vec<u8>,
        /// Whether the shader may write it.
        writable: bool,
    },
    /// The bytes of push constants (immediates in wgpu).
    PushConstant(#[serde(with = "as_bytes")] Vec<u8>),
    /// A sampled two-dimensional image: four floats a texel, first row first.
    Texture {
        /// Width in texels.
        width: u32,
        /// Height in texels.
        height: u32,
        /// `width * height` texels.
        texels: Vec<[f32; 4]>,
    },
    /// The sampler of a texture: nearest, repeating.
    Sampler,
    /// OpenGL's uniforms outside blocks; other backends read them from a block and ignore this.
    Loose(Vec<LooseUniform>),
}

/// Serialises bytes as a whole instead of one after the other.
pub mod as_bytes {
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(bytes: &[u8], to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(bytes)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<u8>, D::Error> {
        <&[u8]>::deserialize(from).map(<[u8]>::to_vec)
    }
}

/// Returns the column or row of the texel that a coordinate selects: the nearest, repeating.
///
/// The fraction of the coordinate times the size, rounded down. The product is rounded to `f32`, as
/// drivers compute it: just below a border it may be the next texel's. Where the size is a power of
/// two, it is exact. OpenGL 4.6 §8.14.2 gives the rule, and leaves the precision to the driver.
/// Coordinates that are not finite select the first texel.
#[inline(always)]
pub fn texel_index(coordinate: f64, size: u32) -> u32 {
    let fraction = coordinate - coordinate.floor();
    let place = if size.is_power_of_two() {
        fraction * f64::from(size)
    } else {
        f64::from(fraction as f32 * size as f32)
    };
    // `as` converts NaN to 0; just below an integer the fraction is rounded to 1.
    (place as u32).min(size.saturating_sub(1))
}

/// A uniform outside blocks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LooseUniform {
    /// The name of one element as OpenGL spells it: `lights[2].color`.
    pub name: String,
    /// The components, column by column, 32 bits each.
    pub words: Vec<u32>,
}

/// The results of a job.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobOutput {
    /// The contents of each writable buffer after the run, by resource; `None` for the others.
    pub buffers: Vec<Option<Vec<u8>>>,
    /// The image of a grid that has one: the bits of four words a pixel, first row first.
    pub pixels: Vec<[u32; 4]>,
}

named! {
    /// The kinds of backends.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[serde(rename_all = "lowercase")]
    pub enum BackendKind {
        /// Landfall's interpreter.
        Cpu = "cpu",
        /// The OpenGL driver.
        Gl = "gl",
        /// Vulkan, Metal or DX12 through wgpu.
        Gpu = "gpu",
        /// WebGL 2 of a browser.
        WebGl = "webgl",
        /// WebGPU of a browser.
        WebGpu = "webgpu",
    }
}

impl BackendKind {
    /// Returns whether this is a driver, which may crash, hang or differ from another.
    pub fn is_driver(self) -> bool {
        self != BackendKind::Cpu
    }
}

impl fmt::Display for BackendKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A backend and its device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "JsonDevice"))]
pub struct Device {
    #[cfg_attr(
        feature = "schema",
        schemars(with = "String", extend("enum" = ["cpu", "gl", "gpu"]))
    )]
    pub backend: BackendKind,
    /// The adapter's name; `landfall evaluator` is the interpreter of landfall.
    pub adapter: String,
    // The driver, such as `Mesa` or `Vulkan`.
    pub driver: String,
    pub version: String,
    // Whether it renders in software.
    pub software: bool,
}

/// The reason why a job has no result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    pub kind: FailureKind,
    /// The message, one line.
    pub message: String,
    /// The log of the driver or its compiler; empty if there is none.
    pub log: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FailureKind {
    /// No such backend on this machine.
    Missing,
    /// The shader is rejected by the backend's compiler or exceeds its limits.
    Refused,
    /// The shader cannot be run in this way on any backend.
    Unfit,
    /// The backend stopped during the run: a crash or a lost device.
    Died,
    /// The run exceeded the time limit or the budget of steps.
    TimedOut,
}

impl Failure {
    pub fn missing(message: impl Into<String>, log: impl Into<String>) -> Failure {
        Failure { kind: FailureKind::Missing, message: message.into(), log: log.into() }
    }

    pub fn refused(message: impl Into<String>, log: impl Into<String>) -> Failure {
        Failure { kind: FailureKind::Refused, message: message.into(), log: log.into() }
    }

    pub fn died(message: impl Into<String>, log: impl Into<String>) -> Failure {
        Failure { kind: FailureKind::Died, message: message.into(), log: log.into() }
    }

    pub fn timed_out(limit: Duration) -> Failure {
        let message = format!("timed out after {:.1} s", limit.as_secs_f64());
        Failure { kind: FailureKind::TimedOut, message, log: String::new() }
    }
}

impl Failure {
    /// Returns the message and, on the same line, the first error in the log.
    pub fn summary(&self) -> String {
        // Compilers put notes and warnings before the first error.
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
    /// Writes the message, and the log below it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match self.log.trim_end() {
            "" => Ok(()),
            log => write!(f, "\n{log}"),
        }
    }
}

impl std::error::Error for Failure {}

/// A backend: runs jobs.
pub trait Backend {
    fn device(&self) -> &Device;

    /// Runs a job.
    ///
    /// # Errors
    /// Fails if there is no result. The backend stays usable unless it died.
    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure>;

    /// Runs a job and calls `other` once: meanwhile on another thread, if there is one, and also if the
    /// job fails. On the interpreter its time counts towards the job's limit.
    ///
    /// # Errors
    /// Those of [`run`](Backend::run).
    ///
    /// # Panics
    /// If `other` does.
    fn run_concurrently(
        &mut self,
        job: &Job,
        other: &mut (dyn FnMut() + Send),
    ) -> Result<JobOutput, Failure> {
        let mut has_thread = true;
        let answer = thread::scope(|scope| {
            // Where the system has no thread to give, `other` is called after the job.
            let thread = thread::Builder::new().spawn_scoped(scope, &mut *other);
            let answer = self.run(job);
            match thread {
                Ok(thread) => thread.join().expect("`other` does not panic"),
                Err(_) => has_thread = false,
            }
            answer
        });
        if !has_thread {
            other();
        }
        answer
    }

    /// Returns the device's time for the last job by its own timestamps; `None` if it has none or
    /// is not a separate device.
    fn device_time(&self) -> Option<Duration> {
        None
    }

    /// Returns the processor time of the last job if it ran in another process; `None` for backends
    /// in this process, whose own clock counts it.
    fn processor_time(&self) -> Option<Duration> {
        None
    }

    /// Compiles texts unchanged within a time limit and returns the driver's reflection; `None` if
    /// the backend has none.
    fn reflect(
        &mut self,
        _texts: &[(Stage, &str)],
        _limit: Duration,
    ) -> Option<Result<Reflection, Failure>> {
        None
    }
}
