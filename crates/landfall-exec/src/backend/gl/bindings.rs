//! Binds a job's resources by name, and deletes and unbinds them after the job.
//!
//! Called by [`run`](super::run) with a job and its program.

#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use glow::HasContext as _;

use super::context::{ContextKind, GlContext};
use super::default_uniforms;
use super::program::Program;
use super::reflect::ActiveBlock;
use crate::backend::limits::{check_resource, twice, unbound};
use crate::backend::{Failure, Resource, ResourceKind};

/// The GL objects of a job; deleted and unbound on drop.
pub(super) struct GlResources<'c> {
    context: &'c GlContext,
    buffers: Vec<(u32, u32, glow::Buffer)>,
    textures: Vec<glow::Texture>,
    /// By resource: the buffer and its size if it is read back.
    writable: Vec<Option<(glow::Buffer, usize)>>,
}

/// Checks the resources before anything is compiled.
pub(super) fn check(context: &GlContext, resources: &[Resource]) -> Result<(), Failure> {
    for (at, resource) in resources.iter().enumerate() {
        let name = &resource.name;
        // A sampler is part of the texture in OpenGL, and has no name of its own.
        let bound = |r: &Resource| r.kind != ResourceKind::Sampler && r.name == *name;
        if resource.kind != ResourceKind::Sampler && resources[..at].iter().any(bound) {
            return Err(twice(&format!("`{name}`")));
        }
        if let ResourceKind::PushConstant(_) = resource.kind {
            let message =
                format!("OpenGL has no push constants, but `{name}` is a push constant block");
            return Err(Failure::refused(message, ""));
        }
        check_resource(resource, &context.limits)?;
    }
    Ok(())
}

impl<'c> GlResources<'c> {
    /// Binds every resource that the program names. The program must be in use.
    pub(super) fn new(
        context: &'c GlContext,
        program: &Program,
        resources: &[Resource],
    ) -> Result<GlResources<'c>, Failure> {
        let (buffers, textures) = (Vec::new(), Vec::new());
        let writable = vec![None; resources.len()];
        let mut bound = GlResources { context, buffers, textures, writable };
        // A block is bound to the point that has its index as the number, as texts before GLSL 4.20
        // name none.
        for (index, block) in (0..).zip(&program.uniform_blocks) {
            let found = find(resources, &program.uniform_blocks, block, |kind| {
                matches!(kind, ResourceKind::Uniform(_))
            });
            let resource = found.ok_or_else(|| unbound("uniform block", &block.name))?;
            // `find` returns a uniform block only.
            let ResourceKind::Uniform(bytes) = &resources[resource].kind else { continue };
            large_enough(block, bytes.len())?;
            // SAFETY: the index is one of the program's.
            unsafe { context.gl.uniform_block_binding(program.id, index, index) };
            bound.buffer(glow::UNIFORM_BUFFER, index, bytes)?;
        }
        for (index, block) in (0..).zip(&program.storage_blocks) {
            let found = find(resources, &program.storage_blocks, block, |kind| {
                matches!(kind, ResourceKind::Storage { .. })
            });
            let resource = found.ok_or_else(|| unbound("storage block", &block.name))?;
            let ResourceKind::Storage { bytes, writable } = &resources[resource].kind else {
                continue;
            };
            let slot = match context.kind {
                ContextKind::Core | ContextKind::Compat => {
                    // SAFETY: the index is one of the program's.
                    unsafe { context.gl.shader_storage_block_binding(program.id, index, index) };
                    index
                }
                // ES takes the binding from the text alone.
                ContextKind::Es => {
                    let here = |b: &&ActiveBlock| b.binding == block.binding;
                    if let Some(other) = program.storage_blocks[..index as usize].iter().find(here)
                    {
                        let names = format!("`{}` and `{}`", other.name, block.name);
                        let message =
                            format!("{names} both have binding {} in the source", block.binding);
                        return Err(Failure::refused(message, ""));
                    }
                    block.binding
                }
            };
            let buffer = bound.buffer(glow::SHADER_STORAGE_BUFFER, slot, bytes)?;
            if *writable {
                bound.writable[resource] = Some((buffer, bytes.len()));
            }
        }
        // The texture units are taken in order.
        for (unit, sampler) in (0..).zip(&program.outside.samplers) {
            let found = resources.iter().find_map(|resource| match &resource.kind {
                ResourceKind::Texture { width, height, texels }
                    if belongs_to_sampler(&resource.name, sampler) =>
                {
                    Some((*width, *height, texels))
                }
                ResourceKind::Texture { .. }
                | ResourceKind::Uniform(_)
                | ResourceKind::Storage { .. }
                | ResourceKind::PushConstant(_)
                | ResourceKind::Sampler
                | ResourceKind::Loose(_) => None,
            });
            let (width, height, texels) = found.ok_or_else(|| unbound("sampler", sampler))?;
            bound.texture(unit, (width, height), texels)?;
            // SAFETY: the program is in use and the name one of its samplers.
            unsafe {
                let location = context.gl.get_uniform_location(program.id, sampler);
                context.gl.uniform_1_i32(location.as_ref(), unit.cast_signed());
            }
        }
        for resource in resources {
            if let ResourceKind::Loose(uniforms) = &resource.kind {
                default_uniforms::set(context, program, uniforms)?;
            }
        }
        Ok(bound)
    }

    fn buffer(&mut self, target: u32, slot: u32, bytes: &[u8]) -> Result<glow::Buffer, Failure> {
        let gl = &self.context.gl;
        // SAFETY: the buffer is made, filled and bound in the current context.
        unsafe {
            let buffer = gl.create_buffer().map_err(no_objects)?;
            // Kept at once, so that it is deleted whatever fails.
            self.buffers.push((target, slot, buffer));
            gl.bind_buffer(target, Some(buffer));
            // A buffer of no bytes cannot be bound.
            let bytes = if bytes.is_empty() { &[0; 4] } else { bytes };
            gl.buffer_data_u8_slice(target, bytes, glow::DYNAMIC_COPY);
            gl.bind_buffer_base(target, slot, Some(buffer));
            Ok(buffer)
        }
    }

    fn texture(
        &mut self,
        unit: u32,
        (width, height): (u32, u32),
        texels: &[[f32; 4]],
    ) -> Result<(), Failure> {
        let gl = &self.context.gl;
        // SAFETY: the texture is made, filled and bound in the current context.
        unsafe {
            let texture = gl.create_texture().map_err(no_objects)?;
            self.textures.push(texture);
            gl.active_texture(glow::TEXTURE0 + unit);
            gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            // As the interpreter samples: the nearest texel, repeating.
            for (what, value) in [
                (glow::TEXTURE_MIN_FILTER, glow::NEAREST),
                (glow::TEXTURE_MAG_FILTER, glow::NEAREST),
                (glow::TEXTURE_WRAP_S, glow::REPEAT),
                (glow::TEXTURE_WRAP_T, glow::REPEAT),
            ] {
                gl.tex_parameter_i32(glow::TEXTURE_2D, what, value.cast_signed());
            }
            gl.tex_image_2d(
                glow::TEXTURE_2D,
                0,
                glow::RGBA32F.cast_signed(),
                width.cast_signed(),
                height.cast_signed(),
                0,
                glow::RGBA,
                glow::FLOAT,
                glow::PixelUnpackData::Slice(Some(bytemuck::cast_slice(texels))),
            );
        }
        Ok(())
    }

    /// Returns the contents of the writable buffers; all writes must be complete.
    pub(super) fn read_back(&self) -> Result<Vec<Option<Vec<u8>>>, Failure> {
        let gl = &self.context.gl;
        let read = |&(buffer, length): &(glow::Buffer, usize)| {
            if length == 0 {
                return Ok(Vec::new());
            }
            // SAFETY: the range is the buffer's; ES has no glGetBufferSubData. The bytes
            // are copied while they are mapped.
            unsafe {
                gl.bind_buffer(glow::COPY_READ_BUFFER, Some(buffer));
                let room = i32::try_from(length).map_err(|_| unreadable(length))?;
                let at = gl.map_buffer_range(glow::COPY_READ_BUFFER, 0, room, glow::MAP_READ_BIT);
                if at.is_null() {
                    return Err(unreadable(length));
                }
                let bytes = std::slice::from_raw_parts(at, length).to_vec();
                gl.unmap_buffer(glow::COPY_READ_BUFFER);
                gl.bind_buffer(glow::COPY_READ_BUFFER, None);
                Ok(bytes)
            }
        };
        self.writable.iter().map(|buffer| buffer.as_ref().map(read).transpose()).collect()
    }
}

impl Drop for GlResources<'_> {
    fn drop(&mut self) {
        let gl = &self.context.gl;
        // SAFETY: the context is current and the objects its own.
        unsafe {
            // Unbound, too: the context outlives the job.
            for &(target, slot, buffer) in &self.buffers {
                gl.bind_buffer_base(target, slot, None);
                gl.delete_buffer(buffer);
            }
            for (unit, &texture) in (0..).zip(&self.textures) {
                gl.active_texture(glow::TEXTURE0 + unit);
                gl.bind_texture(glow::TEXTURE_2D, None);
                gl.delete_texture(texture);
            }
            gl.active_texture(glow::TEXTURE0);
        }
    }
}

/// Returns the index of the resource for a block: the one of its name, or `B` for a lone `B[0]`.
fn find(
    resources: &[Resource],
    blocks: &[ActiveBlock],
    block: &ActiveBlock,
    fits: impl Fn(&ResourceKind) -> bool,
) -> Option<usize> {
    let exact = resources.iter().position(|r| fits(&r.kind) && r.name == block.name);
    exact.or_else(|| {
        let bare = block.name.strip_suffix("[0]")?;
        let one = |b: &&ActiveBlock| b.name.split('[').next() == Some(bare);
        if blocks.iter().filter(one).count() > 1 {
            return None;
        }
        resources.iter().position(|r| fits(&r.kind) && r.name == bare)
    })
}

/// Returns whether a resource belongs to a sampler: `tex` stands for `tex[0]` too.
fn belongs_to_sampler(resource: &str, sampler: &str) -> bool {
    resource == sampler || sampler.strip_suffix("[0]") == Some(resource)
}

/// Checks that a buffer is large enough for its uniform block. Not applied to storage blocks: Mesa
/// rounds their size up to 16 bytes, and their last array may have any length.
fn large_enough(block: &ActiveBlock, bytes: usize) -> Result<(), Failure> {
    if bytes as u64 >= block.size {
        return Ok(());
    }
    let (name, size) = (&block.name, block.size);
    let message =
        format!("the driver requires {size} bytes in `{name}`, but {bytes} bytes are bound");
    Err(Failure::refused(message, ""))
}

fn unreadable(length: usize) -> Failure {
    Failure::died(format!("{length} bytes of a storage block cannot be read back"), "")
}

pub(super) fn no_objects(cause: String) -> Failure {
    Failure::died("the driver cannot create a buffer, texture or framebuffer", cause)
}
