//! Compiles and links texts, each program once.
//!
//! Used by jobs and by reflection; gives [`bindings`](super::bindings) linked programs.

#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use std::cell::OnceCell;
use std::collections::HashMap;

use glow::HasContext as _;

use super::context::GlContext;
use super::reflect;
use super::reflect::{ActiveBlock, Outside};
use super::version::{CORNER, passing_vertex, version};
use crate::backend::Failure;
use crate::backend::reflection::Reflection;
use landfall_layout::source::Stage;

/// A linked program and its active resources.
pub(super) struct Program {
    pub(super) id: glow::Program,
    /// Active uniform blocks, by OpenGL's index.
    pub(super) uniform_blocks: Vec<ActiveBlock>,
    /// Active storage blocks, by OpenGL's index.
    pub(super) storage_blocks: Vec<ActiveBlock>,
    /// Active samplers and other uniforms outside blocks.
    pub(super) outside: Outside,
    /// Whether the vertex shader is Landfall's and reads corners at location 0.
    pub(super) takes_corners: bool,
    /// Its reflection, once it was asked for.
    reflection: OnceCell<Reflection>,
}

impl Program {
    /// Returns its reflection. The driver is asked once: of a thousand members that takes as long as
    /// to compile.
    pub(super) fn reflection(&self, context: &GlContext) -> Result<&Reflection, Failure> {
        match self.reflection.get() {
            Some(known) => Ok(known),
            None => {
                let found = reflect::reflect(context, self.id)?;
                Ok(self.reflection.get_or_init(|| found))
            }
        }
    }
}

/// The replacement for missing stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PartnerStage {
    /// None: the program is separable, so a single stage links.
    None,
    /// A vertex shader that passes corners on, before a lone fragment shader.
    Vertex,
}

/// The compiled programs of one context.
#[derive(Default)]
pub(super) struct GlPrograms {
    linked: HashMap<(Vec<(Stage, String)>, PartnerStage), Program>,
}

/// The number of programs kept; beyond it all are deleted.
const KEPT: usize = 64;

impl GlPrograms {
    /// Returns the program of the given texts, compiled on first use.
    pub(super) fn get(
        &mut self,
        context: &GlContext,
        texts: &[(Stage, &str)],
        partner: PartnerStage,
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

    fn clear(&mut self, context: &GlContext) {
        for (_, program) in self.linked.drain() {
            // SAFETY: the context is current and the program its own.
            unsafe { context.gl.delete_program(program.id) }
        }
    }
}

/// A program under construction, deleted unless it is kept.
struct PendingProgram<'c> {
    context: &'c GlContext,
    id: glow::Program,
    shaders: Vec<glow::Shader>,
    kept: bool,
}

impl Drop for PendingProgram<'_> {
    fn drop(&mut self) {
        // SAFETY: the context is current and these are its own.
        unsafe {
            // A linked program keeps what it needs of its shaders.
            for &shader in &self.shaders {
                self.context.gl.delete_shader(shader);
            }
            if !self.kept {
                self.context.gl.delete_program(self.id);
            }
        }
    }
}

fn build(
    context: &GlContext,
    texts: &[(Stage, &str)],
    partner: PartnerStage,
) -> Result<Program, Failure> {
    let gl = &context.gl;
    let takes_corners = partner == PartnerStage::Vertex && matches!(texts, [(Stage::Fragment, _)]);
    let ours = takes_corners.then(|| passing_vertex(version(texts[0].1)));
    let gone = |what: String| Failure::died("the driver cannot create a shader or program", what);
    // SAFETY: objects are made, used and deleted in the current context.
    unsafe {
        let id = gl.create_program().map_err(gone)?;
        let mut making = PendingProgram { context, id, shaders: Vec::new(), kept: false };
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
            // GLSL before 3.30 cannot give its input a location.
            gl.bind_attrib_location(id, 0, CORNER);
        } else if let (true, Some(separable)) = (lacks_stage(texts), &context.separable) {
            separable.make(id);
        }
        gl.link_program(id);
        if !gl.get_program_link_status(id) {
            let log = gl.get_program_info_log(id);
            return Err(Failure::refused("the program does not link", log));
        }
        let uniform_blocks = reflect::uniform_blocks(context, id)?;
        let program = Program {
            id,
            outside: reflect::Outside::new(context, id, &uniform_blocks)?,
            uniform_blocks,
            storage_blocks: reflect::storage_blocks(context, id)?,
            takes_corners,
            reflection: OnceCell::new(),
        };
        making.kept = true;
        Ok(program)
    }
}

/// Returns whether a stage is missing that a non-separable program needs.
fn lacks_stage(texts: &[(Stage, &str)]) -> bool {
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
        _ => {
            let message = format!("OpenGL has no stage `{}`", stage.name());
            return Err(Failure::refused(message, ""));
        }
    })
}
