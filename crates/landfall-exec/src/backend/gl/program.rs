//! Texts compiled and linked, each program once.
//!
//! Fed by jobs and by reflection; feeds [`bind`](super::bind) and
//! [`reflect`](super::reflect) with programs and what they have active.

#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use std::collections::HashMap;

use glow::HasContext as _;

use super::context::Context;
use super::reflect;
use super::version::{CORNER, passing_vertex, version};
use crate::backend::Failure;
use landfall_layout::source::Stage;

/// A linked program and what a job must bind to it.
pub(super) struct Program {
    pub(super) id: glow::Program,
    /// Active uniform blocks; the index is OpenGL's.
    pub(super) uniform_blocks: Vec<ActiveBlock>,
    /// Active storage blocks; the index is OpenGL's.
    pub(super) storage_blocks: Vec<ActiveBlock>,
    /// Active samplers, each element of an array by itself.
    pub(super) samplers: Vec<String>,
    /// Active uniforms outside of blocks that are no samplers, each element by itself.
    pub(super) loose: Vec<ActiveUniform>,
    /// Whether its vertex shader is ours and wants corners at location 0.
    pub(super) takes_corners: bool,
}

/// A block a program reads or writes.
pub(super) struct ActiveBlock {
    /// OpenGL's name: `B`, or `B[1]` of an array.
    pub(super) name: String,
    /// Bytes its buffer must have.
    pub(super) size: u64,
    /// Where the text binds it.
    pub(super) binding: u32,
}

/// A uniform outside of blocks.
pub(super) struct ActiveUniform {
    /// OpenGL's name: `lights[2].color`.
    pub(super) name: String,
    /// OpenGL's number of its type.
    pub(super) ty: u32,
    pub(super) location: glow::UniformLocation,
}

/// What stands in for the stages a set of texts lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Partner {
    /// Nothing: the program is separable, so a lone stage links.
    None,
    /// A vertex shader that passes corners on goes before a lone fragment shader.
    Vertex,
}

/// The programs of one context.
#[derive(Default)]
pub(super) struct Programs {
    linked: HashMap<(Vec<(Stage, String)>, Partner), Program>,
}

/// Beyond this many all are let go: nobody runs more in turn.
const KEPT: usize = 64;

impl Programs {
    /// The program of those texts, compiled at the first time.
    pub(super) fn get(
        &mut self,
        context: &Context,
        texts: &[(Stage, &str)],
        partner: Partner,
    ) -> Result<&Program, Failure> {
        let texts = texts.iter().map(|(stage, text)| (*stage, (*text).to_string())).collect();
        let key = (texts, partner);
        if !self.linked.contains_key(&key) {
            if self.linked.len() >= KEPT {
                self.clear(context);
            }
            let texts: Vec<(Stage, &str)> = key.0.iter().map(|(s, t)| (*s, t.as_str())).collect();
            let program = build(context, &texts, partner)?;
            self.linked.insert(key.clone(), program);
        }
        Ok(&self.linked[&key])
    }

    fn clear(&mut self, context: &Context) {
        for (_, program) in self.linked.drain() {
            // SAFETY: the context is current and the program its own.
            unsafe { context.gl.delete_program(program.id) }
        }
    }
}

/// A program in the making, deleted unless it is kept.
struct Making<'c> {
    context: &'c Context,
    id: glow::Program,
    shaders: Vec<glow::Shader>,
    kept: bool,
}

impl Drop for Making<'_> {
    fn drop(&mut self) {
        // SAFETY: the context is current and these are its own.
        unsafe {
            for &shader in &self.shaders {
                self.context.gl.delete_shader(shader);
            }
            if !self.kept {
                self.context.gl.delete_program(self.id);
            }
        }
    }
}

fn build(context: &Context, texts: &[(Stage, &str)], partner: Partner) -> Result<Program, Failure> {
    let gl = &context.gl;
    let takes_corners = partner == Partner::Vertex && matches!(texts, [(Stage::Fragment, _)]);
    let ours = takes_corners.then(|| passing_vertex(version(texts[0].1)));
    let gone = |what: String| Failure::died("the driver makes no more objects", what);
    // SAFETY: objects are made, used and deleted in the current context.
    unsafe {
        let id = gl.create_program().map_err(gone)?;
        let mut making = Making { context, id, shaders: Vec::new(), kept: false };
        let stages = texts.iter().copied().chain(ours.as_deref().map(|t| (Stage::Vertex, t)));
        for (stage, text) in stages {
            let shader = gl.create_shader(kind(stage)?).map_err(gone)?;
            making.shaders.push(shader);
            gl.shader_source(shader, text);
            gl.compile_shader(shader);
            if !gl.get_shader_compile_status(shader) {
                let log = gl.get_shader_info_log(shader);
                let message = format!("the {} shader does not compile", stage.name());
                return Err(Failure::refused(message, log));
            }
            gl.attach_shader(id, shader);
        }
        if takes_corners {
            gl.bind_attrib_location(id, 0, CORNER);
        } else if let (true, Some(separable)) = (alone(texts), &context.separable) {
            separable.make(id);
        }
        gl.link_program(id);
        if !gl.get_program_link_status(id) {
            let log = gl.get_program_info_log(id);
            return Err(Failure::refused("the program does not link", log));
        }
        let program = Program {
            id,
            uniform_blocks: reflect::uniform_blocks(context, id)?,
            storage_blocks: reflect::storage_blocks(context, id)?,
            samplers: reflect::samplers(context, id)?,
            loose: reflect::loose(context, id)?,
            takes_corners,
        };
        making.kept = true;
        Ok(program)
    }
}

/// Whether a stage is missing that a program without separation would need.
fn alone(texts: &[(Stage, &str)]) -> bool {
    let has = |stage| texts.iter().any(|text| text.0 == stage);
    let pair = has(Stage::Vertex) && has(Stage::Fragment);
    !pair && !has(Stage::Compute)
}

fn kind(stage: Stage) -> Result<u32, Failure> {
    Ok(match stage {
        Stage::Vertex => glow::VERTEX_SHADER,
        Stage::TessellationControl => glow::TESS_CONTROL_SHADER,
        Stage::TessellationEvaluation => glow::TESS_EVALUATION_SHADER,
        Stage::Geometry => glow::GEOMETRY_SHADER,
        Stage::Fragment => glow::FRAGMENT_SHADER,
        Stage::Compute => glow::COMPUTE_SHADER,
        Stage::Task
        | Stage::Mesh
        | Stage::RayGeneration
        | Stage::Intersection
        | Stage::AnyHit
        | Stage::ClosestHit
        | Stage::Miss
        | Stage::Callable => {
            let message = format!("OpenGL has no stage `{}`", stage.name());
            return Err(Failure::refused(message, ""));
        }
    })
}
