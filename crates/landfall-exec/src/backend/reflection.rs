//! What an OpenGL driver says of a text as the user wrote it: where it put every member.
//!
//! Plain data; made by the driver's reader, compared with the layout by
//! [`verify`](crate::harness::verify).

use serde::{Deserialize, Serialize};

/// What is active in a program, by its driver.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reflection {
    /// Uniform blocks; not in the order of the text.
    pub uniform_blocks: Vec<ReflectedBlock>,
    /// Storage blocks; none where OpenGL is older than 4.3 or ES 3.1.
    pub storage_blocks: Vec<ReflectedBlock>,
    /// Loose uniforms.
    pub uniforms: Vec<ReflectedUniform>,
}

/// A block by its driver.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReflectedBlock {
    /// Its name; `B[0]`, `B[1]` where it is an array of blocks.
    pub name: String,
    /// Where the text binds it; 0 where it does not say.
    pub binding: u32,
    /// Bytes its buffer must have: `GL_UNIFORM_BLOCK_DATA_SIZE` or `GL_BUFFER_DATA_SIZE`.
    pub size: u64,
    /// Its active members down to scalars, vectors and matrices. Drivers list those of an
    /// array of blocks with its first element only, or with each.
    pub members: Vec<ReflectedMember>,
}

/// A member by its driver.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReflectedMember {
    /// Its path without the block's name: `lights[0].pos`, `weights[0]`.
    pub name: String,
    /// Its type as GLSL spells it; of an array, that of its elements.
    pub ty: String,
    /// Bytes from the start of the block.
    pub offset: u64,
    /// Elements: 1 if it is no array, `None` if it is runtime-sized.
    pub array_size: Option<u64>,
    /// Bytes from one element to the next; 0 if it is no array.
    pub array_stride: u64,
    /// Bytes from one column, or row, to the next; 0 if it is no matrix.
    pub matrix_stride: u64,
    /// Whether a matrix is stored row by row.
    pub row_major: bool,
    /// Storage blocks list one element of an outermost array of structs: its length
    /// (`None` if runtime-sized) and stride.
    pub top_level: Option<(Option<u64>, u64)>,
}

/// A loose uniform by its driver.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReflectedUniform {
    /// Its path.
    pub name: String,
    /// Its type as GLSL spells it.
    pub ty: String,
    /// Elements: 1 if it is no array.
    pub array_size: u64,
}
