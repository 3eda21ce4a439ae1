//! What lints are told besides the shaders: levels, targets, tables, copies by other names.
//!
//! Plain data; the command reads it from `landfall.toml` and its flags.

use serde::{Deserialize, Serialize};
use std::sync::Arc;

use landfall_layout::finding::{Level, Place};

/// What lints are told.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Levels by code, a later one over an earlier one; `warnings` stands for every lint that is at
    /// warn by then, `all` for every lint.
    pub levels: Vec<(String, Level)>,
    /// The targets whose limits hold.
    pub targets: Vec<Target>,
    /// Sets of macros under which each shader is laid out too: name and text.
    pub permutations: Vec<Vec<(String, String)>>,
    /// Blocks or structures that are copies of one another under other names.
    pub mirror_groups: Vec<MirrorGroup>,
    /// Hand-written sizes and offsets.
    pub tables: Vec<Table>,
    /// Hand-written mirrors in Rust files.
    pub rust_mirrors: Vec<RustMirror>,
    /// The Rust files those name, and others whose comments may name mirrors.
    #[serde(skip)]
    pub rust_files: Vec<RustFile>,
}

/// An API whose guaranteed limits a shader has to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Target {
    /// OpenGL 3.3.
    Gl33,
    /// OpenGL ES 3.0.
    Gles30,
    /// WebGL 2.
    WebGl2,
    /// WebGPU.
    WebGpu,
    /// Vulkan 1.0.
    Vulkan,
}

impl Target {
    /// Every target.
    pub const ALL: [Target; 5] =
        [Target::Gl33, Target::Gles30, Target::WebGl2, Target::WebGpu, Target::Vulkan];

    /// The target of that name.
    pub fn from_name(name: &str) -> Option<Target> {
        Target::ALL.into_iter().find(|target| target.name() == name)
    }

    /// The name on the command line and in the configuration.
    pub fn name(self) -> &'static str {
        match self {
            Target::Gl33 => "gl33",
            Target::Gles30 => "gles30",
            Target::WebGl2 => "webgl2",
            Target::WebGpu => "webgpu",
            Target::Vulkan => "vulkan",
        }
    }
}

/// Copies of one block or structure that must have the same layout.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MirrorGroup {
    /// What messages call it.
    pub name: String,
    /// The copies.
    pub copies: Vec<MirrorCopy>,
    /// Where the configuration says so.
    pub place: Place,
}

/// One copy in a mirror group.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MirrorCopy {
    /// A glob of the shaders it is in; empty for all.
    pub file: String,
    /// The block's name, or its instance's, or a path in it such as `pointLights[]`.
    pub block: String,
    /// Put before every member's name in this copy (`u_`).
    pub prefix: String,
    /// Members that have other names in this copy: the group's name, and the name here.
    pub aliases: Vec<(String, String)>,
    /// Where the configuration says so.
    pub place: Place,
}

/// A hand-written table of a block: its size, or where its members are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// The block's name, or its instance's.
    pub block: String,
    /// A glob of the shaders it is in; empty for all.
    pub file: String,
    /// Bytes a buffer is made with.
    pub size: Option<Figure>,
    /// Offsets by path.
    pub offsets: Vec<Row>,
    /// Where the configuration says so.
    pub place: Place,
}

/// A number of bytes somebody wrote down.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Its value.
    pub bytes: u64,
    /// As it is written: `48 * 128 + 4`.
    pub written: String,
    /// Where.
    pub place: Place,
}

/// A row of a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// `data[3].color`.
    pub path: String,
    /// Bytes from the start of the block.
    pub offset: Figure,
}

/// A Rust file in which there are mirrors, or may be.
#[derive(Clone, Debug, PartialEq)]
pub struct RustFile {
    /// The path as messages print it, `/` between its parts.
    pub path: String,
    /// Its text.
    pub text: Arc<str>,
}

/// A hand-written mirror.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RustMirror {
    /// The Rust file.
    pub file: String,
    /// The structure in it.
    pub structure: String,
    /// The block's name, its instance's, or the name of a structure in it.
    pub block: String,
    /// A glob of the shaders it is in; empty for all.
    pub shader: String,
    /// Fields that have other names: the member's, and the field's.
    pub aliases: Vec<(String, String)>,
    /// Where the configuration says so.
    pub place: Place,
}
