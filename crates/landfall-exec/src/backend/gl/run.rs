//! Runs one job on one context: binds, runs, reads back and cleans up.

#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use crate::processor::Stopwatch;

use glow::HasContext as _;

use super::bindings::{GlResources, check, no_objects};
use super::context::GlContext;
use super::program::{GlPrograms, PartnerStage, Program};
use crate::backend::limits::{check_grid, check_stages};
use crate::backend::{Failure, Grid, Job, JobOutput, Texel};
use landfall_layout::source::Stage;

/// Returns the texts of a job's stages.
pub(super) fn texts(job: &Job) -> Result<Vec<(Stage, &str)>, Failure> {
    job.stages
        .iter()
        .map(|code| match &code.text {
            Some(text) => Ok((code.stage, text.as_str())),
            None => {
                let name = code.stage.name();
                let message = format!("OpenGL needs GLSL, but the {name} stage has none");
                Err(Failure::refused(message, ""))
            }
        })
        .collect()
}

pub(super) fn run(
    context: &GlContext,
    programs: &mut GlPrograms,
    job: &Job,
    texts: &[(Stage, &str)],
) -> Result<JobOutput, Failure> {
    let begun = Stopwatch::start();
    check(context, &job.resources)?;
    check_run(context, job)?;
    // What an earlier job left is no error of this one.
    let _ = (context.take_messages(), errors(context));
    let partner = match job.grid {
        Grid::Image { .. } => PartnerStage::Vertex,
        Grid::Groups(_) | Grid::Points { .. } => PartnerStage::None,
    };
    let program = programs.get(context, texts, partner)?;
    // SAFETY: the program is of the current context.
    unsafe { context.gl.use_program(Some(program.id)) };
    let answer = bound_run(context, program, job);
    // SAFETY: as above.
    unsafe { context.gl.use_program(None) };
    let errors = errors(context);
    let answer = answer?;
    if !errors.is_empty() {
        let log = context.take_messages();
        let message = format!("OpenGL reports {} for the job", errors.join(", "));
        return Err(match errors.iter().any(|e| FATAL.contains(e)) {
            true => Failure::died(message, log),
            false => Failure::refused(message, log),
        });
    }
    // The driver cannot be interrupted: a job that hangs ends with the process it is in.
    if begun.elapsed() > job.limit {
        return Err(Failure::timed_out(job.limit));
    }
    Ok(answer)
}

fn bound_run(context: &GlContext, program: &Program, job: &Job) -> Result<JobOutput, Failure> {
    let bound = GlResources::new(context, program, &job.resources)?;
    let gl = &context.gl;
    let pixels = match job.grid {
        Grid::Groups([x, y, z]) => {
            // SAFETY: a compute program is in use.
            unsafe { gl.dispatch_compute(x, y, z) };
            Vec::new()
        }
        Grid::Image { width, height, texel } => {
            let target = RenderTarget::new(context, (width, height), texel)?;
            // Bound as long as it lives.
            let _vertices = Vertices::new(context, program.takes_corners)?;
            // SAFETY: program, target and vertices are in place.
            unsafe { gl.draw_arrays(glow::TRIANGLES, 0, 3) };
            target.read()
        }
        Grid::Points { count, texel } => {
            let target = RenderTarget::new(context, (count, 1), texel)?;
            let _vertices = Vertices::new(context, false)?;
            // SAFETY: as above.
            unsafe { gl.draw_arrays(glow::POINTS, 0, count.cast_signed()) };
            target.read()
        }
    };
    // What a shader wrote can be read after a barrier only: OpenGL 4.6 §7.13.2.
    if context.computes() {
        // SAFETY: the version has barriers.
        unsafe { gl.memory_barrier(glow::ALL_BARRIER_BITS) };
    }
    Ok(JobOutput { buffers: bound.read_back()?, pixels })
}

/// Checks that the stages are those of the grid, and the grid within the limits.
fn check_run(context: &GlContext, job: &Job) -> Result<(), Failure> {
    check_stages(job)?;
    if matches!(job.grid, Grid::Groups(_)) && !context.computes() {
        let (name, (major, minor)) = (context.kind.name(), context.version);
        let message = format!(
            "compute shaders need OpenGL 4.3 or ES 3.1, but this is {name} {major}.{minor}"
        );
        return Err(Failure::refused(message, ""));
    }
    check_grid(job.grid, &context.limits)
}

struct RenderTarget<'c> {
    context: &'c GlContext,
    framebuffer: glow::Framebuffer,
    image: glow::Renderbuffer,
    size: (i32, i32),
    texel: Texel,
}

impl<'c> RenderTarget<'c> {
    fn new(
        context: &'c GlContext,
        (width, height): (u32, u32),
        texel: Texel,
    ) -> Result<RenderTarget<'c>, Failure> {
        let gl = &context.gl;
        let size = (width.cast_signed(), height.cast_signed());
        let format = match texel {
            Texel::Float => glow::RGBA32F,
            Texel::Uint => glow::RGBA32UI,
        };
        // SAFETY: objects are made and bound in the current context.
        unsafe {
            let framebuffer = gl.create_framebuffer().map_err(no_objects)?;
            let image = match gl.create_renderbuffer() {
                Ok(image) => image,
                Err(cause) => {
                    // No target deletes it yet.
                    gl.delete_framebuffer(framebuffer);
                    return Err(no_objects(cause));
                }
            };
            let target = RenderTarget { context, framebuffer, image, size, texel };
            gl.bind_renderbuffer(glow::RENDERBUFFER, Some(image));
            gl.renderbuffer_storage(glow::RENDERBUFFER, format, size.0, size.1);
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(framebuffer));
            let place = glow::COLOR_ATTACHMENT0;
            gl.framebuffer_renderbuffer(glow::FRAMEBUFFER, place, glow::RENDERBUFFER, Some(image));
            let status = gl.check_framebuffer_status(glow::FRAMEBUFFER);
            if status != glow::FRAMEBUFFER_COMPLETE {
                let words = match texel {
                    Texel::Float => "floats",
                    Texel::Uint => "unsigned integers",
                };
                let message = format!(
                    "this context cannot draw a {width} by {height} image of 32-bit {words}"
                );
                return Err(Failure::refused(
                    message,
                    format!("framebuffer status 0x{status:04X}"),
                ));
            }
            gl.viewport(0, 0, size.0, size.1);
            // Discarded fragments leave zeros.
            match texel {
                Texel::Float => gl.clear_buffer_f32_slice(glow::COLOR, 0, &[0.0; 4]),
                Texel::Uint => gl.clear_buffer_u32_slice(glow::COLOR, 0, &[0; 4]),
            }
            Ok(target)
        }
    }

    fn read(&self) -> Vec<[u32; 4]> {
        let (width, height) = self.size;
        let mut pixels =
            vec![[0u32; 4]; width.unsigned_abs() as usize * height.unsigned_abs() as usize];
        let (format, ty) = match self.texel {
            Texel::Float => (glow::RGBA, glow::FLOAT),
            Texel::Uint => (glow::RGBA_INTEGER, glow::UNSIGNED_INT),
        };
        // SAFETY: the pixels have room for the whole image, 16 bytes each.
        unsafe {
            let room = glow::PixelPackData::Slice(Some(bytemuck::cast_slice_mut(&mut pixels)));
            self.context.gl.read_pixels(0, 0, width, height, format, ty, room);
        }
        pixels
    }
}

impl Drop for RenderTarget<'_> {
    fn drop(&mut self) {
        let gl = &self.context.gl;
        // SAFETY: the context is current and the objects its own.
        unsafe {
            gl.bind_framebuffer(glow::FRAMEBUFFER, None);
            gl.bind_renderbuffer(glow::RENDERBUFFER, None);
            gl.delete_framebuffer(self.framebuffer);
            gl.delete_renderbuffer(self.image);
        }
    }
}

/// The vertex array, with the corners of a triangle over the whole image if the program reads them.
struct Vertices<'c> {
    context: &'c GlContext,
    array: glow::VertexArray,
    corners: Option<glow::Buffer>,
}

impl<'c> Vertices<'c> {
    fn new(context: &'c GlContext, takes_corners: bool) -> Result<Vertices<'c>, Failure> {
        let gl = &context.gl;
        // SAFETY: objects are made and bound in the current context.
        unsafe {
            let array = gl.create_vertex_array().map_err(no_objects)?;
            let mut vertices = Vertices { context, array, corners: None };
            gl.bind_vertex_array(Some(array));
            if takes_corners {
                let corners = gl.create_buffer().map_err(no_objects)?;
                vertices.corners = Some(corners);
                // A triangle that covers the whole image, without an edge within it.
                let places: [f32; 6] = [-1.0, -1.0, 3.0, -1.0, -1.0, 3.0];
                gl.bind_buffer(glow::ARRAY_BUFFER, Some(corners));
                let bytes = bytemuck::cast_slice(&places);
                gl.buffer_data_u8_slice(glow::ARRAY_BUFFER, bytes, glow::STATIC_DRAW);
                gl.enable_vertex_attrib_array(0);
                gl.vertex_attrib_pointer_f32(0, 2, glow::FLOAT, false, 0, 0);
            }
            Ok(vertices)
        }
    }
}

impl Drop for Vertices<'_> {
    fn drop(&mut self) {
        let gl = &self.context.gl;
        // SAFETY: the context is current and the objects its own.
        unsafe {
            gl.bind_vertex_array(None);
            gl.bind_buffer(glow::ARRAY_BUFFER, None);
            gl.delete_vertex_array(self.array);
            if let Some(corners) = self.corners {
                gl.delete_buffer(corners);
            }
        }
    }
}

/// Errors that make the context unusable.
const FATAL: [&str; 2] = ["GL_OUT_OF_MEMORY", "GL_CONTEXT_LOST"];

/// Returns the names of the errors since the last call.
fn errors(context: &GlContext) -> Vec<&'static str> {
    let mut errors = Vec::new();
    // A lost context may report errors without end.
    for _ in 0..8 {
        // SAFETY: the context is current.
        errors.push(match unsafe { context.gl.get_error() } {
            glow::NO_ERROR => break,
            glow::INVALID_ENUM => "GL_INVALID_ENUM",
            glow::INVALID_VALUE => "GL_INVALID_VALUE",
            glow::INVALID_OPERATION => "GL_INVALID_OPERATION",
            glow::INVALID_FRAMEBUFFER_OPERATION => "GL_INVALID_FRAMEBUFFER_OPERATION",
            glow::OUT_OF_MEMORY => FATAL[0],
            glow::CONTEXT_LOST => FATAL[1],
            _ => "an unknown error",
        });
    }
    errors
}
