//! The wgpu backend: Vulkan, Metal or DX12, given naga modules or unchanged SPIR-V.
//!
//! llvmpipe (Mesa 22.3.6) ends all loops of an invocation after 65535 iterations in total, without
//! an error: results of longer loops are wrong.
//!
//! Modules are never passed as WGSL text, which would lose offsets and strides. The driver of
//! [`Gpu`] may crash or hang; [`subprocess`](crate::backend::subprocess) runs it in a separate
//! process.

mod adapter;
mod device;
mod needs;
mod pipeline;
mod run;
mod spirv;
mod timing;

use std::time::Duration;

pub use adapter::AdapterChoice;

use super::devices::{BackendEntry, Limits};
use crate::backend::{Backend, Device, Failure, FailureKind, Job, JobOutput};
use device::OpenDevice;
use pipeline::Pipelines;
use timing::Timestamps;

/// A GPU in this process.
pub struct Gpu {
    open: OpenDevice,
    pipelines: Pipelines,
    device: Device,
    limits: Limits,
    /// Whether an abandoned job is still running.
    busy: bool,
    timing: JobTiming,
}

/// Whether jobs are timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum JobTiming {
    Off,
    /// The time of the last job, if the device reports it.
    On(Option<Duration>),
}

impl Gpu {
    /// Opens an adapter.
    ///
    /// # Errors
    /// [`FailureKind::Missing`] if no adapter matches.
    pub fn open(choice: &AdapterChoice) -> Result<Gpu, Failure> {
        let adapter = adapter::choose(choice)?;
        Ok(Gpu {
            open: OpenDevice::new(&adapter)?,
            pipelines: Pipelines::default(),
            device: adapter::device(&adapter),
            limits: adapter::limits(&adapter),
            busy: false,
            timing: JobTiming::Off,
        })
    }

    /// Returns this GPU with jobs timed by the device's timestamps, if it has any.
    pub fn timed(self) -> Gpu {
        Gpu { timing: JobTiming::On(None), ..self }
    }

    /// Lists every adapter of every wgpu backend in this build, and each wgpu backend without one.
    pub fn list() -> Vec<BackendEntry> {
        adapter::list()
    }
}

impl Backend for Gpu {
    fn device(&self) -> &Device {
        &self.device
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        // A job that was submitted cannot be taken back: after a timeout the device still works on
        // it.
        if self.busy {
            return Err(Failure::died("the device is still busy with an earlier job", ""));
        }
        let timestamps = match self.timing {
            JobTiming::Off => None,
            JobTiming::On(_) => Timestamps::new(&self.open),
        };
        let Gpu { open, pipelines, limits, .. } = self;
        let answer = run::run(open, pipelines, limits, job, timestamps.as_ref());
        if let Some(timestamps) = &timestamps {
            let passed = answer.as_ref().ok().and_then(|_| timestamps.elapsed());
            self.timing = JobTiming::On(passed);
        }
        let timed_out = |failure: &Failure| failure.kind == FailureKind::TimedOut;
        self.busy = answer.as_ref().is_err_and(timed_out);
        answer
    }

    fn device_time(&self) -> Option<Duration> {
        match self.timing {
            JobTiming::Off => None,
            JobTiming::On(passed) => passed,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use naga::{Type, TypeInner};

    use super::*;
    use crate::backend::{Grid, Resource, ResourceKind, StageCode};
    use landfall_ir::Module;
    use landfall_layout::{Options, Source, Stage};

    #[test]
    fn offsets_replaced_in_the_module_are_the_ones_read() {
        let text = "struct B { a: u32, b: u32 }
            @group(0) @binding(0) var<uniform> block: B;
            @group(0) @binding(1) var<storage, read_write> to: array<u32, 2>;
            @compute @workgroup_size(1) fn main() { to[0] = block.a; to[1] = block.b; }";
        let mut module =
            Module::by_naga(&Source::new("b.wgsl", text), &Options::default()).unwrap();
        let (handle, block) = module.ir.types.iter().find(|t| t.1.name.is_some()).unwrap();
        let TypeInner::Struct { mut members, .. } = block.inner.clone() else {
            panic!("{block:?}")
        };
        (members[0].offset, members[1].offset) = (12, 36);
        let moved =
            Type { name: block.name.clone(), inner: TypeInner::Struct { members, span: 48 } };
        module.ir.types.replace(handle, moved);
        let stage = StageCode::of_module(Stage::Compute, "main", module);
        let bytes = (0..12u32).flat_map(u32::to_le_bytes).collect();
        let kinds = [
            ResourceKind::Uniform(bytes),
            ResourceKind::Storage { bytes: vec![0; 8], writable: true },
        ];
        let bound = |(binding, kind)| Resource { name: "b".to_string(), group: 0, binding, kind };
        let job = Job {
            stages: vec![stage],
            resources: (0..).zip(kinds).map(bound).collect(),
            grid: Grid::Groups([1, 1, 1]),
            limit: Duration::from_secs(60),
        };
        let answer = Gpu::open(&AdapterChoice::default()).unwrap().run(&job).unwrap();
        assert_eq!(answer.buffers[1].as_deref(), Some(&[3, 0, 0, 0, 9, 0, 0, 0][..]));
    }
}
