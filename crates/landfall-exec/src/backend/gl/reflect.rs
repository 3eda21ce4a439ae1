//! Reflection of a linked program: each active block, its size and its members' offsets.
//!
//! Uniform blocks through glGetActiveUniformsiv and glGetActiveUniformBlockiv (OpenGL 4.6
//! §7.6), storage blocks through the program interface queries (§7.3.1).

#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use super::context::Context;
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
pub(super) fn reflect(context: &Context, program: glow::Program) -> Result<Reflection, Failure> {
    let mut uniform_blocks: Vec<ReflectedBlock> =
        uniform_blocks(context, program)?.into_iter().map(empty).collect();
    let mut storage_blocks: Vec<ReflectedBlock> =
        storage_blocks(context, program)?.into_iter().map(empty).collect();
    let mut uniforms = Vec::new();
    let active = Uniforms::of(context, program)?;
    for (at, uniform) in active.all.iter().enumerate() {
        let block = usize::try_from(active.block[at]).ok();
        let Some(block) = block else {
            uniforms.push(ReflectedUniform {
                name: uniform.name.clone(),
                ty: word(uniform.utype),
                array_size: number(uniform.size)?,
            });
            continue;
        };
        let block = uniform_blocks.get_mut(block).ok_or_else(|| nonsense(active.block[at]))?;
        block.members.push(ReflectedMember {
            name: without_block(&uniform.name, &block.name),
            ty: word(uniform.utype),
            offset: number(active.offset[at])?,
            array_size: Some(number(uniform.size)?),
            array_stride: number(active.array_stride[at])?,
            matrix_stride: number(active.matrix_stride[at])?,
            row_major: active.row_major[at] != 0,
            top_level: None,
        });
    }
    storage_members(context, program, &mut storage_blocks)?;
    Ok(Reflection { uniform_blocks, storage_blocks, uniforms })
}

/// Returns the active uniform blocks, without their members.
pub(super) fn uniform_blocks(
    context: &Context,
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
                })
            })
            .collect()
    }
}

/// Returns the active storage blocks, without their members.
pub(super) fn storage_blocks(
    context: &Context,
    program: glow::Program,
) -> Result<Vec<ActiveBlock>, Failure> {
    let Some(interface) = &context.interface else { return Ok(Vec::new()) };
    (0..interface.count(program, glow::SHADER_STORAGE_BLOCK))
        .map(|index| {
            let asked = [glow::BUFFER_DATA_SIZE, glow::BUFFER_BINDING];
            let [size, binding] = interface
                .values(program, glow::SHADER_STORAGE_BLOCK, index, asked)
                .map_err(incomplete)?;
            Ok(ActiveBlock {
                name: interface.name(program, glow::SHADER_STORAGE_BLOCK, index),
                size: number(size)?,
                binding: small(binding)?,
            })
        })
        .collect()
}

/// Returns the active samplers, each element of an array listed separately.
pub(super) fn samplers(context: &Context, program: glow::Program) -> Result<Vec<String>, Failure> {
    let mut names = Vec::new();
    for uniform in Uniforms::of(context, program)?.all {
        match uniform.name.strip_suffix("[0]") {
            _ if !is_sampler(uniform.utype) => {}
            Some(array) => names.extend((0..uniform.size).map(|at| format!("{array}[{at}]"))),
            None => names.push(uniform.name),
        }
    }
    Ok(names)
}

/// Returns the active uniforms outside blocks other than samplers, each element listed separately.
pub(super) fn loose(
    context: &Context,
    program: glow::Program,
) -> Result<Vec<ActiveUniform>, Failure> {
    let mut found = Vec::new();
    let active = Uniforms::of(context, program)?;
    let outside = active.all.into_iter().zip(active.block).filter(|(_, block)| *block < 0);
    for (uniform, _) in outside.filter(|(uniform, _)| !is_sampler(uniform.utype)) {
        let names = match uniform.name.strip_suffix("[0]") {
            Some(array) => (0..uniform.size).map(|at| format!("{array}[{at}]")).collect(),
            None => vec![uniform.name],
        };
        for name in names {
            // SAFETY: the program is linked. Built-in uniforms have no location.
            let location = unsafe { context.gl.get_uniform_location(program, &name) };
            let ty = uniform.utype;
            found.extend(location.map(|location| ActiveUniform { name, ty, location }));
        }
    }
    Ok(found)
}

/// The active uniforms, those in blocks too, and their properties.
struct Uniforms {
    all: Vec<glow::ActiveUniform>,
    block: Vec<i32>,
    offset: Vec<i32>,
    array_stride: Vec<i32>,
    matrix_stride: Vec<i32>,
    row_major: Vec<i32>,
}

impl Uniforms {
    fn of(context: &Context, program: glow::Program) -> Result<Uniforms, Failure> {
        let gl = &context.gl;
        // SAFETY: the program is linked and every index below its count.
        unsafe {
            let indices: Vec<u32> = (0..gl.get_active_uniforms(program)).collect();
            let facts = |name| match indices.as_slice() {
                [] => Vec::new(),
                some => gl.get_active_uniforms_parameter(program, some, name),
            };
            let all: Option<Vec<_>> =
                indices.iter().map(|&index| gl.get_active_uniform(program, index)).collect();
            Ok(Uniforms {
                all: all.ok_or_else(|| {
                    incomplete("the driver lists a uniform without a name".to_string())
                })?,
                block: facts(glow::UNIFORM_BLOCK_INDEX),
                offset: facts(glow::UNIFORM_OFFSET),
                array_stride: facts(glow::UNIFORM_ARRAY_STRIDE),
                matrix_stride: facts(glow::UNIFORM_MATRIX_STRIDE),
                row_major: facts(glow::UNIFORM_IS_ROW_MAJOR),
            })
        }
    }
}

fn storage_members(
    context: &Context,
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
    for index in 0..interface.count(program, glow::BUFFER_VARIABLE) {
        let [block, ty, offset, size, stride, matrix, row_major, top_size, top_stride] =
            interface.values(program, glow::BUFFER_VARIABLE, index, asked).map_err(incomplete)?;
        let name = interface.name(program, glow::BUFFER_VARIABLE, index);
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
            top_level: match top_stride {
                0 => None,
                stride => Some((length(top_size)?, number(stride)?)),
            },
        });
    }
    Ok(())
}

fn empty(block: ActiveBlock) -> ReflectedBlock {
    let ActiveBlock { name, size, binding } = block;
    ReflectedBlock { name, binding, size, members: Vec::new() }
}

/// Strips the block's name, with which the members of a block with an instance name begin (OpenGL
/// 4.6 §7.3.1.1).
fn without_block(member: &str, block: &str) -> String {
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
