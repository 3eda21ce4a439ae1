//! Requests and replies in serialised form, and conversions from and to their types.

use crate::backend::BackendKind;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::frame::{Blob, WireFrame, invalid};
use crate::backend::devices::BackendEntry;
use crate::backend::{
    Device, Failure, Grid, Job, JobOutput, LooseUniform, Resource, ResourceKind, StageCode,
};
use landfall_ir::Module;
use landfall_layout::source::Stage;

/// A request to the process that runs jobs.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Request {
    /// Open the driver, if it is not open; with or without device timestamps.
    Open {
        timed: bool,
    },
    List,
    /// Remember a module by a number; its IR is the blob.
    Module {
        id: u64,
        ir: Blob,
    },
    Forget,
    Run(WireJob),
    /// Reflect the active blocks of a program of these texts.
    Reflect {
        sources: Vec<(String, String)>,
    },
}

/// A reply. [`Request::Module`] and [`Request::Forget`] have none.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Reply {
    Opened(Device),
    Listed(Vec<BackendEntry>),
    Ran {
        buffers: Vec<Option<Blob>>,
        pixels: Blob,
        times: JobTimes,
    },
    #[cfg(feature = "gl")]
    Reflected(crate::backend::reflection::Reflection),
    Failed(Failure),
}

/// The times of a job, without the transfer.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct JobTimes {
    /// Device time by timestamps.
    pub device: Option<Duration>,
    /// Processor time of all threads of the process.
    pub processor: Option<Duration>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct WireJob {
    stages: Vec<WireStage>,
    resources: Vec<WireResource>,
    grid: Grid,
    limit: Duration,
}

#[derive(Debug, Serialize, Deserialize)]
struct WireStage {
    stage: String,
    entry: String,
    module: Option<u64>,
    text: Option<String>,
    spirv: Option<Blob>,
}

#[derive(Debug, Serialize, Deserialize)]
struct WireResource {
    name: String,
    group: u32,
    binding: u32,
    kind: WireKind,
}

#[derive(Debug, Serialize, Deserialize)]
enum WireKind {
    Uniform(Blob),
    Storage { bytes: Blob, writable: bool },
    PushConstant(Blob),
    Texture { width: u32, height: u32, texels: Blob },
    Sampler,
    Loose(Vec<LooseUniform>),
}

impl WireJob {
    /// Returns a job whose modules are replaced by the server's numbers. Only the form of the code
    /// that the backend takes is sent.
    pub(super) fn new(
        job: &Job,
        backend: BackendKind,
        frame: &mut WireFrame,
        mut number: impl FnMut(&Arc<Module>) -> io::Result<u64>,
    ) -> io::Result<WireJob> {
        let mut stages = Vec::with_capacity(job.stages.len());
        for code in &job.stages {
            let (stage, entry) = (code.stage.name().to_string(), code.entry.clone());
            let mut sent = WireStage { stage, entry, module: None, text: None, spirv: None };
            // OpenGL takes texts; wgpu takes SPIR-V if there is some, else the module.
            if backend == BackendKind::Gl {
                sent.text = code.text.clone();
            } else if let Some(words) = &code.spirv {
                let bytes = words.iter().flat_map(|word| word.to_le_bytes()).collect();
                sent.spirv = Some(frame.put(bytes));
            } else {
                // A module is sent once; from then on its number names it.
                sent.module = code.module.as_ref().map(&mut number).transpose()?;
            }
            stages.push(sent);
        }
        let resources = job.resources.iter().map(|resource| WireResource {
            name: resource.name.clone(),
            group: resource.group,
            binding: resource.binding,
            kind: match &resource.kind {
                ResourceKind::Uniform(bytes) => WireKind::Uniform(frame.put(bytes.clone())),
                ResourceKind::Storage { bytes, writable } => {
                    WireKind::Storage { bytes: frame.put(bytes.clone()), writable: *writable }
                }
                ResourceKind::PushConstant(bytes) => {
                    WireKind::PushConstant(frame.put(bytes.clone()))
                }
                ResourceKind::Texture { width, height, texels } => WireKind::Texture {
                    width: *width,
                    height: *height,
                    texels: frame.put(
                        texels.iter().flatten().flat_map(|c| c.to_bits().to_le_bytes()).collect(),
                    ),
                },
                ResourceKind::Sampler => WireKind::Sampler,
                ResourceKind::Loose(uniforms) => WireKind::Loose(uniforms.clone()),
            },
        });
        Ok(WireJob { stages, resources: resources.collect(), grid: job.grid, limit: job.limit })
    }

    /// Returns the job, its modules looked up by number.
    pub(super) fn job(
        self,
        frame: &mut WireFrame,
        module: impl Fn(u64) -> Option<Arc<Module>>,
    ) -> io::Result<Job> {
        let mut stages = Vec::with_capacity(self.stages.len());
        for code in self.stages {
            let spirv = match code.spirv {
                Some(blob) => Some(words(&frame.take(blob)?).into()),
                None => None,
            };
            let known = |id| {
                module(id)
                    .ok_or_else(|| invalid("the message names a shader module that was not sent"))
            };
            stages.push(StageCode {
                stage: stage(&code.stage)?,
                entry: code.entry,
                module: code.module.map(known).transpose()?,
                text: code.text,
                spirv,
            });
        }
        let mut resources = Vec::with_capacity(self.resources.len());
        for WireResource { name, group, binding, kind } in self.resources {
            let kind = match kind {
                WireKind::Uniform(blob) => ResourceKind::Uniform(frame.take(blob)?),
                WireKind::Storage { bytes, writable } => {
                    ResourceKind::Storage { bytes: frame.take(bytes)?, writable }
                }
                WireKind::PushConstant(blob) => ResourceKind::PushConstant(frame.take(blob)?),
                WireKind::Texture { width, height, texels } => {
                    let texels = quads(&frame.take(texels)?);
                    let texels = texels.into_iter().map(|texel| texel.map(f32::from_bits));
                    ResourceKind::Texture { width, height, texels: texels.collect() }
                }
                WireKind::Sampler => ResourceKind::Sampler,
                WireKind::Loose(uniforms) => ResourceKind::Loose(uniforms),
            };
            resources.push(Resource { name, group, binding, kind });
        }
        Ok(Job { stages, resources, grid: self.grid, limit: self.limit })
    }
}

impl Reply {
    pub(super) fn of_answer(answer: JobOutput, times: JobTimes, frame: &mut WireFrame) -> Reply {
        let buffers = answer.buffers.into_iter().map(|bytes| bytes.map(|bytes| frame.put(bytes)));
        let buffers = buffers.collect();
        let pixels = answer.pixels.iter().flatten().flat_map(|word| word.to_le_bytes());
        Reply::Ran { buffers, pixels: frame.put(pixels.collect()), times }
    }

    pub(super) fn answer(
        buffers: Vec<Option<Blob>>,
        pixels: Blob,
        frame: &mut WireFrame,
    ) -> io::Result<JobOutput> {
        let mut taken = Vec::with_capacity(buffers.len());
        for blob in buffers {
            taken.push(match blob {
                Some(blob) => Some(frame.take(blob)?),
                None => None,
            });
        }
        Ok(JobOutput { buffers: taken, pixels: quads(&frame.take(pixels)?) })
    }
}

pub(super) fn stage(name: &str) -> io::Result<Stage> {
    Stage::from_name(name).ok_or_else(|| invalid(&format!("`{name}` is not a shader stage")))
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes
        .chunks_exact(4)
        .map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
        .collect()
}

fn quads(bytes: &[u8]) -> Vec<[u32; 4]> {
    words(bytes).chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect()
}
