//! Sets uniforms outside blocks one by one.
//!
//! Called by [`bindings`](super::bindings) with a job's values.

#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use std::collections::HashMap;

use glow::HasContext as _;

use super::context::GlContext;
use super::program::Program;
use super::reflect::ActiveUniform;
use super::types::word;
use crate::backend::limits::unbound;
use crate::backend::{Failure, LooseUniform};

/// Sets every active uniform of a program. The program must be in use.
pub(super) fn set(
    context: &GlContext,
    program: &Program,
    values: &[LooseUniform],
) -> Result<(), Failure> {
    let by_name: HashMap<&str, &[u32]> =
        values.iter().map(|value| (value.name.as_str(), value.words.as_slice())).collect();
    for uniform in &program.outside.loose {
        let words = by_name.get(uniform.name.as_str());
        let words = words.ok_or_else(|| unbound("uniform", &uniform.name))?;
        set_uniform(context, uniform, words)?;
    }
    Ok(())
}

fn set_uniform(context: &GlContext, uniform: &ActiveUniform, words: &[u32]) -> Result<(), Failure> {
    let gl = &context.gl;
    let at = Some(&uniform.location);
    let count = words.len();
    let floats: &[f32] = bytemuck::cast_slice(words);
    let whole: &[i32] = bytemuck::cast_slice(words);
    let fits = |components: usize| match count == components {
        true => Ok(()),
        false => {
            let (name, ty) = (&uniform.name, word(uniform.ty));
            let message = format!("`{name}` is a `{ty}`, but {count} 32-bit values were given");
            Err(Failure::refused(message, ""))
        }
    };
    // SAFETY: the program is in use, the location its own, and the slice as long as the type.
    unsafe {
        match uniform.ty {
            glow::FLOAT => fits(1).map(|()| gl.uniform_1_f32_slice(at, floats)),
            glow::FLOAT_VEC2 => fits(2).map(|()| gl.uniform_2_f32_slice(at, floats)),
            glow::FLOAT_VEC3 => fits(3).map(|()| gl.uniform_3_f32_slice(at, floats)),
            glow::FLOAT_VEC4 => fits(4).map(|()| gl.uniform_4_f32_slice(at, floats)),
            // A bool is set by an integer, of which all but 0 are true: OpenGL 4.6 §7.6.1.
            glow::INT | glow::BOOL => fits(1).map(|()| gl.uniform_1_i32_slice(at, whole)),
            glow::INT_VEC2 | glow::BOOL_VEC2 => fits(2).map(|()| gl.uniform_2_i32_slice(at, whole)),
            glow::INT_VEC3 | glow::BOOL_VEC3 => fits(3).map(|()| gl.uniform_3_i32_slice(at, whole)),
            glow::INT_VEC4 | glow::BOOL_VEC4 => fits(4).map(|()| gl.uniform_4_i32_slice(at, whole)),
            glow::UNSIGNED_INT => fits(1).map(|()| gl.uniform_1_u32_slice(at, words)),
            glow::UNSIGNED_INT_VEC2 => fits(2).map(|()| gl.uniform_2_u32_slice(at, words)),
            glow::UNSIGNED_INT_VEC3 => fits(3).map(|()| gl.uniform_3_u32_slice(at, words)),
            glow::UNSIGNED_INT_VEC4 => fits(4).map(|()| gl.uniform_4_u32_slice(at, words)),
            // Column by column as GLSL has them, so nothing is transposed.
            glow::FLOAT_MAT2 => fits(4).map(|()| gl.uniform_matrix_2_f32_slice(at, false, floats)),
            glow::FLOAT_MAT3 => fits(9).map(|()| gl.uniform_matrix_3_f32_slice(at, false, floats)),
            glow::FLOAT_MAT4 => fits(16).map(|()| gl.uniform_matrix_4_f32_slice(at, false, floats)),
            glow::FLOAT_MAT2x3 => {
                fits(6).map(|()| gl.uniform_matrix_2x3_f32_slice(at, false, floats))
            }
            glow::FLOAT_MAT2x4 => {
                fits(8).map(|()| gl.uniform_matrix_2x4_f32_slice(at, false, floats))
            }
            glow::FLOAT_MAT3x2 => {
                fits(6).map(|()| gl.uniform_matrix_3x2_f32_slice(at, false, floats))
            }
            glow::FLOAT_MAT3x4 => {
                fits(12).map(|()| gl.uniform_matrix_3x4_f32_slice(at, false, floats))
            }
            glow::FLOAT_MAT4x2 => {
                fits(8).map(|()| gl.uniform_matrix_4x2_f32_slice(at, false, floats))
            }
            glow::FLOAT_MAT4x3 => {
                fits(12).map(|()| gl.uniform_matrix_4x3_f32_slice(at, false, floats))
            }
            other => {
                let (name, ty) = (&uniform.name, word(other));
                let message = format!("the uniform `{name}` is a `{ty}`, which cannot be set here");
                Err(Failure::refused(message, ""))
            }
        }
    }
}
