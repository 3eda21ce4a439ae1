//! Rust mirrors of blocks, and tables from member names to offsets.
//!
//! Reads only the layout model and the comments of the shader. `plan` chooses the Rust type of each
//! member (with `types`, `leaf` and `array`), `naming`, `names` and `rename` name every type, and
//! `mirror` (with `host`), `tail`, `small`, `strided`, `constants`, `check` and `table` print one
//! kind of item each, which `modules` puts together. `docs` copies the shader's comments.
//! `bindings` prints what the rest of a program needs.

mod array;
mod binding_options;
#[cfg(feature = "bindings")]
mod bindings;
mod check;
mod constants;
mod docs;
mod field;
mod header;
mod host;
mod leaf;
mod mirror;
mod modules;
pub(crate) mod names;
mod naming;
mod plan;
mod print;
mod refuse;
mod rename;
mod small;
mod strided;
mod table;
mod tail;
mod types;

pub use binding_options::{Api, BindingOptions, Sources, WgpuMajor};
pub use field::field;

use landfall_layout::ShaderLayout;
use landfall_layout::diagnostic::{Code, Diagnostic, Severity};

use crate::refusal::of_shader;
use crate::user_types::{self, UserTypes};

/// The Rust types of vectors and matrices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Vectors {
    /// `glam::Vec3`, `glam::Mat4`, where size and alignment match.
    #[default]
    Glam,
    /// `[f32; 3]`, `[[f32; 4]; 4]`.
    Array,
}

impl Vectors {
    /// The name in `--vectors`.
    pub fn name(self) -> &'static str {
        match self {
            Vectors::Glam => "glam",
            Vectors::Array => "array",
        }
    }

    /// The variant with this name.
    pub fn from_name(name: &str) -> Option<Vectors> {
        [Vectors::Glam, Vectors::Array].into_iter().find(|vectors| vectors.name() == name)
    }
}

/// The visibility of the generated items.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Visibility {
    /// `pub`.
    #[default]
    Public,
    /// `pub(crate)`.
    Crate,
}

impl Visibility {
    /// `pub` or `pub(crate)`.
    fn keyword(self) -> &'static str {
        match self {
            Visibility::Public => "pub",
            Visibility::Crate => "pub(crate)",
        }
    }
}

/// Whether to generate tables from names to offsets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Tables {
    /// One module per block.
    #[default]
    Beside,
    /// Mirrors only.
    Without,
}

/// The modules that mirrors are written into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Modules {
    /// One for each shader if there are several, none for one.
    #[default]
    Auto,
    /// One for each shader: a name does not depend on other shaders.
    Each,
    /// None: all mirrors have distinct names.
    Flat,
}

impl Modules {
    /// The name in `--modules`.
    pub fn name(self) -> &'static str {
        match self {
            Modules::Auto => "auto",
            Modules::Each => "each",
            Modules::Flat => "flat",
        }
    }

    /// The variant with this name.
    pub fn from_name(name: &str) -> Option<Modules> {
        [Modules::Auto, Modules::Each, Modules::Flat]
            .into_iter()
            .find(|modules| modules.name() == name)
    }
}

/// Options of the Rust output.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct RustOptions {
    /// The types of vectors and matrices.
    pub vectors: Vectors,
    /// The visibility of the items.
    pub visibility: Visibility,
    /// Whether to generate tables.
    pub tables: Tables,
    /// The modules.
    pub modules: Modules,
    /// New names of structures and blocks (`Light`, or `lights.frag:Light` for those of one shader)
    /// and of shaders' modules (`lights.frag`). They are used as they stand.
    pub rename: Vec<(String, String)>,
    /// As `rename`, for all shaders of a project: none has to be among these shaders.
    pub project_renames: Vec<(String, String)>,
    /// The program's own types: what they are for (`vec3`, `Light`, `Light.position`) and a path in
    /// Rust. Each must be plain data of the same size, which is asserted, and implement `Debug`,
    /// `PartialEq` and `bytemuck::Pod`.
    pub types: Vec<(String, String)>,
    /// Traits that all types derive beside `Clone`, `Copy`, `Debug` and `PartialEq`: `serde::Serialize`.
    pub derives: Vec<String>,
    /// As `types`, for all shaders of a project: none has to be used by these shaders.
    pub project_types: Vec<(String, String)>,
    /// The name of each shader in the text, in the order of the shaders. A shader without one is
    /// named by its path, or by its file name if the path is absolute.
    pub inputs: Vec<String>,
    /// What the rest of a program needs; the layouts need their interfaces for it
    /// ([`Options::interface`](landfall_layout::Options)).
    pub bindings: BindingOptions,
}

/// Mirrors and tables as Rust text.
#[derive(Clone, Debug)]
pub struct RustOutput {
    /// The file's text, for `include!` or to be checked in.
    pub text: String,
    /// An error for every block without a mirror, a warning for every name that got a number.
    pub diagnostics: Vec<Diagnostic>,
}

/// Writes mirrors of every block and structure of `shaders`, and the tables.
///
/// The text needs `bytemuck`, and `glam` with [`Vectors::Glam`]; its head lists the features.
/// A layout that two shaders share is written once. A block that no Rust type can mirror is
/// left out and reported; the others are written.
pub fn rust(shaders: &[&ShaderLayout], options: &RustOptions) -> RustOutput {
    let inputs: Vec<String> =
        shaders.iter().enumerate().map(|(i, shader)| header::input(shader, options, i)).collect();
    let each = match options.modules {
        Modules::Auto => shaders.len() > 1,
        Modules::Each => true,
        Modules::Flat => false,
    };
    let (renames, mut diagnostics) = rename::Renames::new(options);
    let (types, bad) = UserTypes::new(&options.types, &options.project_types, &user_types::RUST);
    diagnostics.extend(bad);
    diagnostics.extend(bad_derives(options));
    // Stage 1: a plan of all types, before any name is given. A block that is refused takes no
    // other with it.
    let mut plan = plan::Plan::new(options.vectors, &renames, &types, !each);
    for (at, (shader, input)) in shaders.iter().zip(&inputs).enumerate() {
        for block in &shader.blocks {
            match refuse::reason(block, shader.language) {
                Some(found) => diagnostics.push(of_shader(found, shader)),
                None => plan.add(block, shader, input, at),
            }
        }
    }
    // Stage 2: the text. What is printed first has the first choice of names in the file.
    let mut text = header::header(&plan, options, &inputs, shaders);
    let mut items = names::Scope::default();
    diagnostics
        .extend(modules::modules(&plan, options, &renames, &inputs, each, &mut items, &mut text));
    #[cfg(feature = "bindings")]
    diagnostics.extend(bindings::modules(shaders, &inputs, options, &mut items, &mut text));
    #[cfg(not(feature = "bindings"))]
    if !options.bindings.apis.is_empty() {
        let message = "bindings are not part of this build".to_string();
        let error = Diagnostic::without_place(Code::CannotRun, Severity::Error, message);
        diagnostics.push(error.with_help("build `landfall-codegen` with its feature `bindings`"));
    }
    diagnostics.extend(renames.unused(shaders, &inputs));
    diagnostics.extend(types.unused());
    RustOutput { text, diagnostics }
}

/// An error for each trait to derive that is no path in Rust.
fn bad_derives(options: &RustOptions) -> Vec<Diagnostic> {
    let is_path = |path: &&String| user_types::is_type(path) && !path.contains('<');
    let bad = options.derives.iter().filter(|path| !is_path(path));
    bad.map(|path| {
        let message = format!("`{path}` cannot be derived: it is no path in Rust");
        Diagnostic::without_place(Code::BadName, Severity::Error, message)
            .with_help("write a path such as `serde::Serialize`")
    })
    .collect()
}
