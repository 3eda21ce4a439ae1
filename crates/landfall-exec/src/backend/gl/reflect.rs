//! Reflection of a linked program: each active block, its size and its members' offsets.
//!
//! Uniform blocks through glGetActiveUniformsiv and glGetActiveUniformBlockiv (OpenGL 4.6
//! §7.6), storage blocks through the program interface queries (§7.3.1).

#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use super::context::GlContext;
use super::types::{is_sampler, word};
use crate::backend::Failure;
use crate::backend::reflection::{ReflectedBlock, ReflectedMember, ReflectedUniform, Reflection};
use glow::HasContext as _;

/// An active block of a program.
pub(super) struct ActiveBlock {
    /// OpenGL's name: `B`, or `B[1]` of an array.
    pub(super) name: String,
    /// Bytes its buffer must have.
    pub(super) size: u64,
    /// The binding in the text.
    pub(super) binding: u32,
    /// The number of its active uniforms; 0 of a storage block.
    pub(super) uniforms: usize,
}

/// A uniform outside blocks.
pub(super) struct ActiveUniform {
    /// OpenGL's name: `lights[2].color`.
    pub(super) name: String,
    /// OpenGL's constant of its type.
    pub(super) ty: u32,
    pub(super) location: glow::UniformLocation,
}

/// Returns everything that is active in a linked program.
pub(super) fn reflect(context: &GlContext, program: glow::Program) -> Result<Reflection, Failure> {
    let mut uniform_blocks: Vec<ReflectedBlock> =
        uniform_blocks(context, program)?.into_iter().map(empty).collect();
    let mut storage_blocks: Vec<ReflectedBlock> =
        storage_blocks(context, program)?.into_iter().map(empty).collect();
    let mut uniforms = Vec::new();
    for uniform in active_uniforms(context, program, |_| true, usize::MAX)? {
        let Some(block) = uniform.block else {
            uniforms.push(ReflectedUniform {
                name: uniform.name,
                ty: word(uniform.ty),
                array_size: number(uniform.size)?,
            });
            continue;
        };
        let block = uniform_blocks.get_mut(block).ok_or_else(|| nonsense(block as i32))?;
        block.members.push(ReflectedMember {
            name: without_block(&uniform.name, &block.name),
            ty: word(uniform.ty),
            offset: number(uniform.offset)?,
            array_size: Some(number(uniform.size)?),
            array_stride: number(uniform.array_stride)?,
            matrix_stride: number(uniform.matrix_stride)?,
            row_major: uniform.row_major != 0,
            top_level: None,
        });
    }
    storage_members(context, program, &mut storage_blocks)?;
    Ok(Reflection { uniform_blocks, storage_blocks, uniforms })
}

/// Returns the active uniform blocks, without their members.
pub(super) fn uniform_blocks(
    context: &GlContext,
    program: glow::Program,
) -> Result<Vec<ActiveBlock>, Failure> {
    let gl = &context.gl;
    // SAFETY: the program is linked and every index below its count.
    unsafe {
        let count = gl.get_program_parameter_i32(program, glow::ACTIVE_UNIFORM_BLOCKS);
        (0..u32::try_from(count).unwrap_or(0))
            .map(|index| {
                let fact = |name| gl.get_active_uniform_block_parameter_i32(program, index, name);
                Ok(ActiveBlock {
                    name: gl.get_active_uniform_block_name(program, index),
                    size: number(fact(glow::UNIFORM_BLOCK_DATA_SIZE))?,
                    binding: small(fact(glow::UNIFORM_BLOCK_BINDING))?,
                    uniforms: small(fact(glow::UNIFORM_BLOCK_ACTIVE_UNIFORMS))? as usize,
                })
            })
            .collect()
    }
}

/// Returns the active storage blocks, without their members.
pub(super) fn storage_blocks(
    context: &GlContext,
    program: glow::Program,
) -> Result<Vec<ActiveBlock>, Failure> {
    let Some(interface) = &context.interface else { return Ok(Vec::new()) };
    let longest = interface.longest(program, glow::SHADER_STORAGE_BLOCK);
    (0..interface.count(program, glow::SHADER_STORAGE_BLOCK))
        .map(|index| {
            let asked = [glow::BUFFER_DATA_SIZE, glow::BUFFER_BINDING];
            let [size, binding] = interface
                .values(program, glow::SHADER_STORAGE_BLOCK, index, asked)
                .map_err(incomplete)?;
            Ok(ActiveBlock {
                name: interface.name(program, glow::SHADER_STORAGE_BLOCK, index, longest),
                size: number(size)?,
                binding: small(binding)?,
                uniforms: 0,
            })
        })
        .collect()
}

/// The uniforms outside blocks, each element of an array listed separately.
#[derive(Default)]
pub(super) struct Outside {
    pub(super) samplers: Vec<String>,
    pub(super) loose: Vec<ActiveUniform>,
}

impl Outside {
    /// Returns those of a program with these blocks.
    pub(super) fn new(
        context: &GlContext,
        program: glow::Program,
        blocks: &[ActiveBlock],
    ) -> Result<Outside, Failure> {
        let mut outside = Outside::default();
        // SAFETY: the program is linked.
        let all = unsafe { context.gl.get_active_uniforms(program) } as usize;
        // The blocks of an array have the same uniforms. Only Mesa is known to count them so, and to
        // need much time for a uniform.
        let is_counted = context.device.driver == "Mesa"
            && !blocks.iter().any(|block| block.name.ends_with(']'));
        let inside: usize = blocks.iter().map(|block| block.uniforms).sum();
        let wanted = all.checked_sub(inside).filter(|_| is_counted).unwrap_or(usize::MAX);
        let is_named = |uniform: &Uniform| uniform.block.is_none();
        let active = active_uniforms(context, program, is_named, wanted)?;
        for Uniform { name, ty, size, .. } in active.into_iter().filter(is_named) {
            // An array is listed once, by the name of its first element.
            let names: Vec<String> = match name.strip_suffix("[0]") {
                Some(array) => (0..size).map(|at| format!("{array}[{at}]")).collect(),
                None => vec![name],
            };
            if is_sampler(ty) {
                outside.samplers.extend(names);
                continue;
            }
            for name in names {
                // SAFETY: the program is linked. Built-in uniforms have no location.
                let location = unsafe { context.gl.get_uniform_location(program, &name) };
                outside.loose.extend(location.map(|location| ActiveUniform { name, ty, location }));
            }
        }
        Ok(outside)
    }
}

/// An active uniform and its properties.
struct Uniform {
    /// Empty unless it was asked for.
    name: String,
    /// OpenGL's constant of its type.
    ty: u32,
    /// The length of an array, or 1.
    size: i32,
    block: Option<usize>,
    offset: i32,
    array_stride: i32,
    matrix_stride: i32,
    row_major: i32,
}

/// Returns the active uniforms, those in blocks too, up to the one that is the last of as many as are
/// wanted with names. Mesa searches a list of all for each property of a uniform, so that reading them
/// takes time by the square of their number: few properties are read, and only the names that are needed.
fn active_uniforms(
    context: &GlContext,
    program: glow::Program,
    is_named: impl Fn(&Uniform) -> bool,
    wanted: usize,
) -> Result<Vec<Uniform>, Failure> {
    if wanted == 0 {
        return Ok(Vec::new());
    }
    let Some(interface) = &context.interface else { return by_index(context, program) };
    let asked = [
        glow::TYPE,
        glow::ARRAY_SIZE,
        glow::BLOCK_INDEX,
        glow::OFFSET,
        glow::ARRAY_STRIDE,
        glow::MATRIX_STRIDE,
        glow::IS_ROW_MAJOR,
    ];
    let longest = interface.longest(program, glow::UNIFORM);
    let (mut uniforms, mut named) = (Vec::new(), 0);
    for index in 0..interface.count(program, glow::UNIFORM) {
        let [ty, size, block, offset, array_stride, matrix_stride, row_major] =
            interface.values(program, glow::UNIFORM, index, asked).map_err(incomplete)?;
        let mut uniform = Uniform {
            name: String::new(),
            ty: ty.cast_unsigned(),
            size,
            // -1 stands for no block.
            block: usize::try_from(block).ok(),
            offset,
            array_stride,
            matrix_stride,
            row_major,
        };
        if is_named(&uniform) {
            uniform.name = interface.name(program, glow::UNIFORM, index, longest);
            named += 1;
        }
        uniforms.push(uniform);
        if named == wanted {
            break;
        }
    }
    Ok(uniforms)
}

/// The same by the queries of contexts before OpenGL 4.3, with all names.
fn by_index(context: &GlContext, program: glow::Program) -> Result<Vec<Uniform>, Failure> {
    let gl = &context.gl;
    // SAFETY: the program is linked and every index below its count.
    unsafe {
        let indices: Vec<u32> = (0..gl.get_active_uniforms(program)).collect();
        let facts = |name| match indices.as_slice() {
            [] => Vec::new(),
            some => gl.get_active_uniforms_parameter(program, some, name),
        };
        let block = facts(glow::UNIFORM_BLOCK_INDEX);
        let offset = facts(glow::UNIFORM_OFFSET);
        let array_stride = facts(glow::UNIFORM_ARRAY_STRIDE);
        let matrix_stride = facts(glow::UNIFORM_MATRIX_STRIDE);
        let row_major = facts(glow::UNIFORM_IS_ROW_MAJOR);
        let uniform = |at: usize| {
            let active = gl.get_active_uniform(program, indices[at]).ok_or_else(|| {
                incomplete("the driver lists a uniform without a name".to_string())
            })?;
            Ok(Uniform {
                name: active.name,
                ty: active.utype,
                size: active.size,
                block: usize::try_from(block[at]).ok(),
                offset: offset[at],
                array_stride: array_stride[at],
                matrix_stride: matrix_stride[at],
                row_major: row_major[at],
            })
        };
        (0..indices.len()).map(uniform).collect()
    }
}

fn storage_members(
    context: &GlContext,
    program: glow::Program,
    blocks: &mut [ReflectedBlock],
) -> Result<(), Failure> {
    let Some(interface) = &context.interface else { return Ok(()) };
    let asked = [
        glow::BLOCK_INDEX,
        glow::TYPE,
        glow::OFFSET,
        glow::ARRAY_SIZE,
        glow::ARRAY_STRIDE,
        glow::MATRIX_STRIDE,
        glow::IS_ROW_MAJOR,
        glow::TOP_LEVEL_ARRAY_SIZE,
        glow::TOP_LEVEL_ARRAY_STRIDE,
    ];
    let longest = interface.longest(program, glow::BUFFER_VARIABLE);
    for index in 0..interface.count(program, glow::BUFFER_VARIABLE) {
        let [block, ty, offset, size, stride, matrix, row_major, top_size, top_stride] =
            interface.values(program, glow::BUFFER_VARIABLE, index, asked).map_err(incomplete)?;
        let name = interface.name(program, glow::BUFFER_VARIABLE, index, longest);
        let at = usize::try_from(block).map_err(|_| nonsense(block))?;
        let block = blocks.get_mut(at).ok_or_else(|| nonsense(block))?;
        block.members.push(ReflectedMember {
            name: without_block(&name, &block.name),
            ty: word(ty.cast_unsigned()),
            offset: number(offset)?,
            array_size: length(size)?,
            array_stride: number(stride)?,
            matrix_stride: number(matrix)?,
            row_major: row_major != 0,
            // A stride of 0 tells that the block's member is no array of structures.
            top_level: match top_stride {
                0 => None,
                stride => Some((length(top_size)?, number(stride)?)),
            },
        });
    }
    Ok(())
}

fn empty(block: ActiveBlock) -> ReflectedBlock {
    let ActiveBlock { name, size, binding, uniforms: _ } = block;
    ReflectedBlock { name, binding, size, members: Vec::new() }
}

/// Strips the block's name, with which the members of a block with an instance name begin (OpenGL
/// 4.6 §7.3.1.1).
fn without_block(member: &str, block: &str) -> String {
    // The members of an array of blocks have the array's name.
    let bare = block.split('[').next().unwrap_or(block);
    let rest = member.strip_prefix(bare).and_then(|rest| rest.strip_prefix('.'));
    rest.unwrap_or(member).to_string()
}

/// Returns an array's length; 0 stands for an array without a declared size.
fn length(value: i32) -> Result<Option<u64>, Failure> {
    Ok(match value {
        0 => None,
        length => Some(number(length)?),
    })
}

fn number(value: i32) -> Result<u64, Failure> {
    u64::try_from(value).map_err(|_| nonsense(value))
}

fn small(value: i32) -> Result<u32, Failure> {
    u32::try_from(value).map_err(|_| nonsense(value))
}

fn nonsense(value: i32) -> Failure {
    incomplete(format!("the driver returned {value} where a count is expected"))
}

fn incomplete(log: String) -> Failure {
    Failure::died(
        "the driver returns invalid data about the uniforms and blocks of the program",
        log,
    )
}
