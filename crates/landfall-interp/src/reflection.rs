//! An OpenGL driver's reflection of an unchanged text: the offset of every member.
//!
//! Plain data; made by the OpenGL backend, compared with the layout by
//! `landfall_exec::harness::verify`.

use serde::{Deserialize, Serialize};

/// The active blocks and uniforms of a program as the driver reports them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reflection {
    /// Uniform blocks, in the driver's order.
    pub uniform_blocks: Vec<ReflectedBlock>,
    /// Storage blocks; empty before OpenGL 4.3 and ES 3.1.
    pub storage_blocks: Vec<ReflectedBlock>,
    /// Uniforms outside blocks.
    pub uniforms: Vec<ReflectedUniform>,
}

/// A block as the driver reports it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReflectedBlock {
    /// The name; `B[0]`, `B[1]` for an array of blocks.
    pub name: String,
    /// The binding in the text; 0 if it has none.
    pub binding: u32,
    /// The buffer's minimum size in bytes: `GL_UNIFORM_BLOCK_DATA_SIZE` or `GL_BUFFER_DATA_SIZE`.
    pub size: u64,
    /// The active members down to scalars, vectors and matrices. Drivers list those of an array of
    /// blocks with its first element only, or with each.
    pub members: Vec<ReflectedMember>,
}

/// A member as the driver reports it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReflectedMember {
    /// The path without the block's name: `lights[0].pos`, `weights[0]`.
    pub name: String,
    /// The type as GLSL spells it; the element type of an array.
    pub ty: String,
    /// The offset in bytes from the start of the block.
    pub offset: u64,
    /// The number of elements: 1 if it is no array, `None` if it is runtime-sized.
    pub array_size: Option<u64>,
    /// The array stride in bytes; 0 if it is no array.
    pub array_stride: u64,
    /// The matrix stride in bytes; 0 if it is no matrix.
    pub matrix_stride: u64,
    /// Whether a matrix is row-major.
    pub row_major: bool,
    /// Length (`None` if runtime-sized) and stride of an outermost array of structures in a storage
    /// block, of which drivers list one element.
    pub top_level: Option<(Option<u64>, u64)>,
}

/// A uniform outside blocks as the driver reports it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReflectedUniform {
    /// The path.
    pub name: String,
    /// The type as GLSL spells it.
    pub ty: String,
    /// The number of elements: 1 if it is no array.
    pub array_size: u64,
}
