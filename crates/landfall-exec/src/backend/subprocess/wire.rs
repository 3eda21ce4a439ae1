//! Requests and replies in serialised form, and conversions from and to their types.

use crate::backend::BackendKind;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::frame::{Blob, invalid};
use crate::backend::devices::BackendEntry;
use crate::backend::{Device, Failure, Grid, Job, JobOutput, Resource, StageCode};
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
    /// Remember a module by a number.
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
    resources: Vec<Resource>,
    grid: Grid,
    limit: Duration,
}

#[derive(Debug, Serialize, Deserialize)]
struct WireStage {
    stage: String,
    entry: String,
    module: Option<u64>,
    text: Option<String>,
    spirv: Option<Vec<u32>>,
}

impl WireJob {
    /// Returns a job whose modules are replaced by the server's numbers. Only the form of the code
    /// that the backend takes is sent.
    pub(super) fn new(
        job: &Job,
        backend: BackendKind,
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
                sent.spirv = Some(words.to_vec());
            } else {
                // A module is sent once; from then on its number names it.
                sent.module = code.module.as_ref().map(&mut number).transpose()?;
            }
            stages.push(sent);
        }
        let resources = job.resources.clone();
        Ok(WireJob { stages, resources, grid: job.grid, limit: job.limit })
    }

    /// Returns the job, its modules looked up by number.
    pub(super) fn job(self, module: impl Fn(u64) -> Option<Arc<Module>>) -> io::Result<Job> {
        let mut stages = Vec::with_capacity(self.stages.len());
        for code in self.stages {
            let known = |id| {
                module(id)
                    .ok_or_else(|| invalid("the message names a shader module that was not sent"))
            };
            stages.push(StageCode {
                stage: stage(&code.stage)?,
                entry: code.entry,
                module: code.module.map(known).transpose()?,
                text: code.text,
                spirv: code.spirv.map(Arc::from),
            });
        }
        Ok(Job { stages, resources: self.resources, grid: self.grid, limit: self.limit })
    }
}

impl Reply {
    pub(super) fn of_answer(answer: JobOutput, times: JobTimes) -> Reply {
        let pixels = answer.pixels.iter().flatten().flat_map(|word| word.to_le_bytes());
        let pixels = Blob(pixels.collect());
        let buffers = answer.buffers.into_iter().map(|bytes| bytes.map(Blob)).collect();
        Reply::Ran { buffers, pixels, times }
    }

    pub(super) fn answer(buffers: Vec<Option<Blob>>, pixels: &Blob) -> JobOutput {
        let word = |at: &[u8]| u32::from_le_bytes([at[0], at[1], at[2], at[3]]);
        let texel = |at: &[u8]| [0, 4, 8, 12].map(|from| word(&at[from..]));
        JobOutput {
            buffers: buffers.into_iter().map(|blob| blob.map(|Blob(bytes)| bytes)).collect(),
            pixels: pixels.0.chunks_exact(16).map(texel).collect(),
        }
    }
}

pub(super) fn stage(name: &str) -> io::Result<Stage> {
    Stage::from_name(name).ok_or_else(|| invalid(&format!("`{name}` is not a shader stage")))
}
