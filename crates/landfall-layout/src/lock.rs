//! Locks: committed records of shader layouts, one JSON file per shader.
//!
//! [`write()`] makes a lock's text from a [`ShaderLayout`], [`read()`] makes [`BlockLayout`]s
//! from a lock or from the output of `layout --format json`, and the lint `layout-drift`
//! compares a shader with its lock. The command reads and writes the files.

mod check;
mod place;
mod read;
mod spelling;
mod write;

use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};

use crate::layout::BlockLayout;
use crate::shape::AddressSpace;
use crate::source::{Files, Language, Stage, Target};
use crate::{ShaderLayout, Variant};

pub use read::{is_lock, is_newer, read, read_all};
#[cfg(feature = "schema")]
pub use write::schema;
pub use write::{renew, write};

/// The version of the lock format, raised by every incompatible change: 2 has variants.
pub const SCHEMA_VERSION: u32 = 2;

/// The version of a lock without variants, which it still has.
pub const FIRST_SCHEMA_VERSION: u32 = 1;

/// The JSON Schema (draft 2020-12) of a lock.
pub const LOCK_SCHEMA: &str = include_str!("../schema/lock.json");

/// The address spaces of blocks in a lock.
const SPACES: [AddressSpace; 7] = [
    AddressSpace::Uniform,
    AddressSpace::Storage,
    AddressSpace::PushConstant,
    AddressSpace::BufferReference,
    AddressSpace::ShaderRecord,
    AddressSpace::TaskPayload,
    AddressSpace::Default,
];

/// A lock, or one shader of the output of `layout --format json`.
#[derive(Clone, Debug)]
pub struct Lock {
    /// The shader's path, if the JSON holds it. A lock does not; its own path implies it.
    pub shader: Option<String>,
    /// The shader's language.
    pub language: Language,
    /// The shader's stage, if the JSON holds it.
    pub stage: Option<Stage>,
    /// The blocks without macros of variants, with spans in the JSON.
    pub blocks: Vec<BlockLayout>,
    /// The variants whose blocks are others.
    pub variants: Vec<RecordedVariant>,
    /// The devices on which the layout was verified.
    pub verified: Vec<Verified>,
    /// The API assumed for the shader, if its blocks depend on it and the text does not declare it.
    pub assumed_target: Option<Target>,
    /// The JSON text, to resolve spans.
    pub files: Files,
}

/// The blocks of a shader under a set of macros.
#[derive(Clone, Debug)]
pub struct RecordedVariant {
    /// The macros with their texts.
    pub macros: Vec<(String, String)>,
    /// The blocks, those that are as without the macros among them.
    pub blocks: Vec<BlockLayout>,
}

/// A device on which the layout was verified.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Verified {
    /// The backend that read the bytes.
    pub backend: String,
    /// The adapter's name, from its driver; `landfall evaluator` is the interpreter of landfall.
    pub adapter: String,
    /// The driver and its version.
    pub driver: String,
    /// Landfall's version.
    pub version: String,
}

impl Lock {
    /// The lock as a [`ShaderLayout`].
    pub fn layout(&self) -> ShaderLayout {
        let variants = self.variants.iter();
        let variants =
            variants.map(|one| Variant::new(one.macros.clone(), self.layout_of(&one.blocks)));
        ShaderLayout { variants: variants.collect(), ..self.layout_of(&self.blocks) }
    }

    fn layout_of(&self, blocks: &[BlockLayout]) -> ShaderLayout {
        // A lock does not name its shader: its own path stands for it.
        let path = self.files.get(0).map(|file| file.path.clone()).unwrap_or_default();
        let path = self.shader.clone().unwrap_or(path);
        ShaderLayout {
            blocks: blocks.to_vec(),
            files: self.files.clone(),
            assumed_target: self.assumed_target,
            ..ShaderLayout::empty(path, self.language, self.stage)
        }
    }

    /// The lock's text.
    pub fn text(&self) -> String {
        write::document(&self.layout(), &self.verified)
    }

    /// The lock's text without verified devices.
    pub fn text_without_devices(&self) -> String {
        write::document(&self.layout(), &[])
    }
}

/// The path of a shader's lock: `layouts/lights/point.frag.json` for `lights/point.frag`.
///
/// Roots, `.` and `..` in the shader's path are dropped.
pub fn path_of(locks: &Path, shader: &Path) -> PathBuf {
    let inside: PathBuf =
        // `..` would lead out of the directory of locks.
        shader.components().filter(|part| matches!(part, Component::Normal(_))).collect();
    let mut name: OsString = locks.join(inside).into_os_string();
    name.push(".json");
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples;

    #[test]
    fn the_lock_of_a_shader_lies_in_the_same_tree() {
        let at = |shader: &str| path_of(Path::new("layouts"), Path::new(shader));
        assert_eq!(at("lights/point.frag"), Path::new("layouts/lights/point.frag.json"));
        assert_eq!(at("./a.wgsl"), Path::new("layouts/a.wgsl.json"));
        assert_eq!(at("../a.wgsl"), Path::new("layouts/a.wgsl.json"));
        assert_eq!(at("/a.wgsl"), Path::new("layouts/a.wgsl.json"));
    }

    #[test]
    fn a_lock_has_one_member_a_line_and_no_lines_of_the_shader() {
        let shader =
            examples::shader("a.frag", crate::Language::Glsl, vec![examples::point_lights()]);
        assert_eq!(
            write(&shader),
            r#"{
  "schema_version": 1,
  "language": "glsl",
  "blocks": [
    {
      "name": "PointLightBlock",
      "instance": "u_point_light_array",
      "address_space": "uniform",
      "rules": "std140",
      "rules_declared": true,
      "size": 6160,
      "data_size": 6148,
      "align": 16,
      "members": [
        {"name": "data", "type": "PointLight[128]", "offset": 0, "size": 6144, "align": 16, "strides": [48], "members": [
          {"name": "pos", "type": "vec3", "offset": 0, "size": 12, "align": 16},
          {"name": "color", "type": "vec3", "offset": 16, "size": 12, "align": 16},
          {"name": "intensity", "type": "float", "offset": 28, "size": 4, "align": 4},
          {"name": "constant", "type": "float", "offset": 32, "size": 4, "align": 4},
          {"name": "linear", "type": "float", "offset": 36, "size": 4, "align": 4},
          {"name": "quadratic", "type": "float", "offset": 40, "size": 4, "align": 4}
        ]},
        {"name": "actually_used_count", "type": "int", "offset": 6144, "size": 4, "align": 4}
      ]
    }
  ]
}
"#
        );
    }
}
