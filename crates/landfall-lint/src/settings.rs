//! The settings of lints: levels, targets, tables, copies under other names.
//!
//! The command reads them from `landfall.toml` and its flags.

use std::sync::Arc;

use landfall_layout::finding::{Level, Place};
use landfall_layout::{Options, ShaderLayout, Source, named};

use landfall_layout::text::glob;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Levels by code, a later one over an earlier one; `warnings` stands for every lint that is at
    /// warn by then, `all` for every lint.
    pub levels: Vec<(String, Level)>,
    /// Levels in some files, which precede `levels`; a later row over an earlier one.
    pub path_levels: Vec<PathLevels>,
    /// Levels of the command line, which precede all others.
    pub flag_levels: Vec<(String, Level)>,
    /// The targets whose limits apply.
    pub targets: Vec<Target>,
    /// Sets of macros under which each shader is laid out too: name and text.
    pub permutations: Vec<Vec<(String, String)>>,
    /// Sets of macros of which one holds, for some files; the first row of a file counts.
    pub variants: Vec<VariantSets>,
    /// Blocks or structures that are copies of one another under other names.
    pub mirror_groups: Vec<MirrorGroup>,
    /// Hand-written sizes and offsets.
    pub tables: Vec<Table>,
    /// Hand-written mirrors in Rust files.
    pub rust_mirrors: Vec<RustMirror>,
    /// Modules and the texts that they are compiled from.
    pub compiled: Vec<CompiledShader>,
    /// Functions with demands that are proved.
    pub proofs: Vec<Proof>,
    /// The Rust files those name, and others whose comments may name mirrors.
    pub rust_files: Vec<RustFile>,
}

impl Settings {
    /// Every level that is set, of the configuration, of some files, and of the command line.
    pub fn all_levels(&self) -> impl Iterator<Item = &(String, Level)> {
        let rows = self.path_levels.iter().flat_map(|row| &row.levels);
        self.levels.iter().chain(rows).chain(&self.flag_levels)
    }

    /// Returns the options by which a shader itself is laid out: where one of several sets of macros
    /// holds, with the first.
    pub fn own_options(&self, source: &Source, options: &Options) -> Options {
        options.clone().with_macros(self.own_set(source))
    }

    /// Returns the options by which one of the layouts of [`Settings::divided`] was laid out.
    pub fn options_of(&self, source: &Source, part: &ShaderLayout, options: &Options) -> Options {
        match part.condition.as_ref().and_then(|condition| condition.sets.first()) {
            Some(set) => options.clone().with_macros(set),
            None => self.own_options(source, options),
        }
    }

    /// Lays a shader out by its own options, and under the other sets of macros.
    pub fn layout(&self, source: &Source, options: &Options) -> ShaderLayout {
        self.layout_as(&source.path, source, options)
    }

    /// Lays a copy of a shader out with the sets of macros that hold for another path.
    pub fn layout_as(&self, path: &str, source: &Source, options: &Options) -> ShaderLayout {
        let named = Source { path: path.to_string(), ..source.clone() };
        let own = self.own_options(&named, options);
        landfall_layout::layout(source, &own).with_variants(source, options, &self.sets(&named))
    }

    /// The blocks of a shader and its variants, each once; see [`ShaderLayout::divided`].
    pub fn divided(&self, source: &Source, shader: ShaderLayout) -> Vec<ShaderLayout> {
        shader.divided(self.own_set(source))
    }

    /// The shader and the variants whose blocks differ; see [`ShaderLayout::distinct_variants`].
    pub fn distinct_variants(&self, source: &Source, shader: &ShaderLayout) -> Vec<ShaderLayout> {
        shader.distinct_variants(self.own_set(source))
    }

    /// The set of macros of the shader itself; empty if it has none.
    pub(crate) fn own_set(&self, source: &Source) -> &[(String, String)] {
        self.first_set(source).map_or(&[], Vec::as_slice)
    }

    /// The other sets of macros.
    pub fn sets(&self, source: &Source) -> Vec<Vec<(String, String)>> {
        // The shader itself is laid out with the first set.
        let skipped = usize::from(self.first_set(source).is_some());
        let row = self.variants_of(source).into_iter().flat_map(|row| &row.sets);
        row.skip(skipped).chain(&self.permutations).cloned().collect()
    }

    fn variants_of(&self, source: &Source) -> Option<&VariantSets> {
        let path = source.path.replace(std::path::MAIN_SEPARATOR, "/");
        self.variants.iter().find(|row| glob::matches(&row.file, &path))
    }

    /// The set of macros that holds for the shader itself; `None` if none need hold.
    fn first_set(&self, source: &Source) -> Option<&Vec<(String, String)>> {
        self.variants_of(source).filter(|row| !row.base)?.sets.first()
    }
}

/// Sets of macros, features and definitions of which one holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VariantSets {
    /// A glob of the files.
    pub file: String,
    /// The sets: name and text.
    pub sets: Vec<Vec<(String, String)>>,
    /// Whether the files are laid out without any of them, too.
    pub base: bool,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathLevels {
    /// A glob of the files.
    pub file: String,
    /// Levels by code, as in [`Settings::levels`].
    pub levels: Vec<(String, Level)>,
}

named! {
    /// An API whose guaranteed limits a shader must not exceed.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Target {
        /// OpenGL 3.3.
        Gl33 = "gl33",
        /// OpenGL ES 3.0.
        Gles30 = "gles30",
        /// WebGL 2.
        WebGl2 = "webgl2",
        /// WebGPU.
        WebGpu = "webgpu",
        /// Vulkan 1.0.
        Vulkan = "vulkan",
    }

    const ALL;
    fn from_name;
}

impl Target {
    /// Returns the API whose GLSL it reads; `None` for WebGPU, which reads WGSL.
    pub fn dialect(self) -> Option<landfall_layout::Target> {
        match self {
            Target::Gl33 | Target::Gles30 | Target::WebGl2 => Some(landfall_layout::Target::OpenGl),
            Target::Vulkan => Some(landfall_layout::Target::Vulkan),
            Target::WebGpu => None,
        }
    }
}

/// Copies of one block or structure that must have the same layout.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MirrorGroup {
    /// The name in messages.
    pub name: String,
    pub copies: Vec<MirrorCopy>,
    /// The place in the configuration.
    pub place: Place,
}

/// One copy in a mirror group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MirrorCopy {
    /// A glob of the shaders it is in; empty for all.
    pub file: String,
    /// The block's name, or its instance's, or a path in it such as `pointLights[]`.
    pub block: String,
    /// The prefix of every member's name in this copy (`u_`).
    pub prefix: String,
    /// Members that have other names in this copy: the group's name, and the name here.
    pub aliases: Vec<(String, String)>,
    /// The place in the configuration.
    pub place: Place,
}

/// A hand-written table of a block: its size, or where its members are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The block's name, or its instance's.
    pub block: String,
    /// A glob of the shaders it is in; empty for all.
    pub file: String,
    /// The size of the buffer in bytes.
    pub size: Option<Figure>,
    /// Offsets by path.
    pub offsets: Vec<Row>,
    /// The place in the configuration.
    pub place: Place,
}

/// A hand-written number of bytes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Its value.
    pub bytes: u64,
    /// The expression in the configuration: `48 * 128 + 4`.
    pub written: String,
    /// Its place.
    pub place: Place,
}

/// A row of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The path of the member: `data[3].color`.
    pub path: String,
    /// The offset from the start of the block, in bytes.
    pub offset: Figure,
}

/// A SPIR-V module and the text that it is compiled from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CompiledShader {
    /// The path of the text.
    pub source: String,
    /// The path of the module.
    pub spirv: String,
    /// The place in the configuration.
    pub place: Place,
}

/// A function with demands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Proof {
    /// A glob of the shaders it is in.
    pub file: String,
    /// Its name, or an overload such as `f(vec3)`.
    pub function: String,
    /// Whether no result may be NaN.
    pub no_nan: bool,
    /// Whether no result may be infinite.
    pub no_inf: bool,
    /// The most units in the last place that results may be off.
    pub max_ulp: Option<f64>,
    /// The most steps of 1/255 of full scale that results may be off.
    pub max_step: Option<f64>,
    /// The ranges of the inputs by path.
    pub domain: Option<serde_json::Value>,
    /// The limit of processor time in seconds, if set.
    pub time: Option<f64>,
    /// The place in the configuration.
    pub place: Place,
}

impl Proof {
    /// Whether the shader of this path has the function.
    pub fn takes(&self, path: &str) -> bool {
        landfall_layout::text::glob::matches(&self.file, path)
    }
}

/// A Rust file that contains, or may contain, mirrors.
#[derive(Clone, Debug, PartialEq)]
pub struct RustFile {
    /// The path in messages, with `/` as its separator.
    pub path: String,
    /// Its text.
    pub text: Arc<str>,
}

/// A hand-written mirror.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RustMirror {
    pub file: String,
    pub structure: String,
    /// The block's name, its instance's, or the name of a structure in it.
    pub block: String,
    /// A glob of the shaders it is in; empty for all.
    pub shader: String,
    /// Fields that have other names: the member's, and the field's.
    pub aliases: Vec<(String, String)>,
    /// The place in the configuration.
    pub place: Place,
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLUSTERED: &str = "#version 450\n#if defined(LOW)\n#define COUNT 4\n#elif defined(HIGH)\n\
                             #define COUNT 64\n#else\n#error no quality\n#endif\n\
                             layout(std140, binding = 0) uniform Lights { vec4 at[COUNT]; };\n\
                             void main() {}\n";

    fn macros(names: &[&str]) -> Vec<(String, String)> {
        names.iter().map(|name| (name.to_string(), "1".to_string())).collect()
    }

    fn sizes(settings: &Settings, path: &str, text: &str) -> Vec<(String, Option<u64>)> {
        let shader = settings.layout(&Source::new(path, text), &Options::default());
        let size = |shader: &ShaderLayout| shader.blocks.first().and_then(|block| block.size);
        let own = std::iter::once((String::new(), size(&shader)));
        let variants = shader.variants.iter();
        let others = variants.map(|one| (one.name(), one.layout.as_deref().and_then(size)));
        own.chain(others).collect()
    }

    #[test]
    fn one_of_the_sets_holds_unless_none_need() {
        let row = VariantSets {
            file: "shaders/*.frag".into(),
            sets: vec![macros(&["LOW"]), macros(&["HIGH"])],
            base: false,
        };
        let mut settings = Settings { variants: vec![row], ..Settings::default() };
        let high = ("HIGH".to_string(), Some(1024));
        assert_eq!(
            sizes(&settings, "shaders/a.frag", CLUSTERED),
            [(String::new(), Some(64)), high.clone()]
        );
        assert_eq!(sizes(&settings, "other/a.frag", CLUSTERED), [(String::new(), None)]);
        // Without any, the text is no shader, whose variants are not looked at.
        settings.variants[0].base = true;
        assert_eq!(sizes(&settings, "shaders/a.frag", CLUSTERED), [(String::new(), None)]);
        let fallback = CLUSTERED.replace("#error no quality", "#define COUNT 1");
        assert_eq!(
            sizes(&settings, "shaders/a.frag", &fallback),
            [(String::new(), Some(16)), ("LOW".to_string(), Some(64)), high]
        );
    }

    #[test]
    fn permutations_are_of_features_of_wesl_too() {
        let text = "struct S { @if(FOG) fog: vec4f, t: f32 }\n\
                    @group(0) @binding(0) var<uniform> s: S;\n";
        let settings = Settings { permutations: vec![macros(&["FOG"])], ..Settings::default() };
        assert_eq!(
            sizes(&settings, "a.wesl", text),
            [(String::new(), Some(4)), ("FOG".to_string(), Some(32))]
        );
        let oil = "#ifdef FOG\nstruct S { fog: vec4f, t: f32 }\n#else\nstruct S { t: f32 }\n#endif\n\
                   @group(0) @binding(0) var<uniform> s: S;\n";
        assert_eq!(
            sizes(&settings, "a.wgsl", oil),
            [(String::new(), Some(4)), ("FOG".to_string(), Some(32))]
        );
    }
}
