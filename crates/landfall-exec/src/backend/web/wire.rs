//! Requests to the page and its replies, as JSON.

use serde::{Deserialize, Serialize};

use crate::backend::devices::Limits;
use crate::backend::reflection::Reflection;
use crate::backend::{
    BackendKind, Failure, Grid, Job, JobOutput, LooseUniform, Resource, ResourceKind,
};
use landfall_layout::source::Stage;

#[derive(Debug, Deserialize)]
pub(super) enum PageReply {
    Opened {
        adapter: String,
        software: bool,
        limits: Limits,
    },
    Ran {
        /// The words of each writable buffer, by resource.
        buffers: Vec<Option<Vec<u32>>>,
        /// Four words a pixel.
        pixels: Vec<u32>,
    },
    Reflected(Reflection),
    Failed(Failure),
}

/// A job with the texts that the page compiles.
#[derive(Debug, Serialize)]
pub(super) struct WebJob<'a> {
    stages: Vec<WebStage<'a>>,
    resources: Vec<WebResource<'a>>,
    grid: Grid,
}

/// The texts of a program.
#[derive(Debug, Serialize)]
pub(super) struct WebTexts<'a> {
    stages: Vec<WebStage<'a>>,
}

#[derive(Debug, Serialize)]
struct WebStage<'a> {
    stage: &'static str,
    entry: &'a str,
    text: &'a str,
}

#[derive(Debug, Serialize)]
struct WebResource<'a> {
    name: &'a str,
    group: u32,
    binding: u32,
    #[serde(flatten)]
    kind: WebKind<'a>,
}

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum WebKind<'a> {
    Uniform { words: Vec<u32> },
    Storage { words: Vec<u32> },
    Writable { words: Vec<u32> },
    Loose { uniforms: &'a [LooseUniform] },
}

impl<'a> WebJob<'a> {
    /// Returns a job to send.
    ///
    /// # Errors
    /// Fails if a stage has no text or a resource is none that the page binds.
    pub(super) fn new(job: &'a Job, backend: BackendKind) -> Result<WebJob<'a>, Failure> {
        let stages = job.stages.iter().map(|code| {
            let text = code.text.as_deref().ok_or_else(|| {
                Failure::refused(format!("the shader has no text for the backend `{backend}`"), "")
            })?;
            Ok(WebStage { stage: code.stage.name(), entry: &code.entry, text })
        });
        Ok(WebJob {
            stages: stages.collect::<Result<_, Failure>>()?,
            resources: job.resources.iter().map(resource).collect::<Result<_, Failure>>()?,
            grid: job.grid,
        })
    }
}

impl<'a> WebTexts<'a> {
    pub(super) fn new(texts: &[(Stage, &'a str)]) -> WebTexts<'a> {
        let stage = |&(stage, text): &(Stage, &'a str)| WebStage {
            stage: stage.name(),
            entry: "main",
            text,
        };
        WebTexts { stages: texts.iter().map(stage).collect() }
    }
}

fn resource(resource: &Resource) -> Result<WebResource<'_>, Failure> {
    let kind = match &resource.kind {
        ResourceKind::Uniform(bytes) => WebKind::Uniform { words: words(bytes) },
        ResourceKind::Storage { bytes, writable: false } => {
            WebKind::Storage { words: words(bytes) }
        }
        ResourceKind::Storage { bytes, writable: true } => {
            WebKind::Writable { words: words(bytes) }
        }
        ResourceKind::Loose(uniforms) => WebKind::Loose { uniforms },
        ResourceKind::PushConstant(_) => return Err(unbound("push constants")),
        ResourceKind::Texture { .. } | ResourceKind::Sampler => return Err(unbound("textures")),
    };
    let Resource { name, group, binding, .. } = resource;
    Ok(WebResource { name, group: *group, binding: *binding, kind })
}

fn unbound(what: &str) -> Failure {
    Failure::refused(format!("the page of the web backends binds no {what}"), "")
}

/// Returns the words of a buffer, its last one filled up with zeros.
fn words(bytes: &[u8]) -> Vec<u32> {
    let word = |part: &[u8]| {
        let mut four = [0; 4];
        four[..part.len()].copy_from_slice(part);
        u32::from_le_bytes(four)
    };
    bytes.chunks(4).map(word).collect()
}

pub(super) fn output(job: &Job, buffers: Vec<Option<Vec<u32>>>, pixels: &[u32]) -> JobOutput {
    let buffers = job.resources.iter().zip(buffers).map(|(resource, words)| {
        let length = match &resource.kind {
            ResourceKind::Storage { bytes, .. } => bytes.len(),
            _ => return None,
        };
        let mut bytes: Vec<u8> = words?.into_iter().flat_map(u32::to_le_bytes).collect();
        // The last word may reach past the end of the buffer.
        bytes.truncate(length);
        Some(bytes)
    });
    let pixels = pixels.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]);
    JobOutput { buffers: buffers.collect(), pixels: pixels.collect() }
}
