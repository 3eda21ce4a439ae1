//! Rust mirrors of blocks, and tables from a member's name to its offset.
//!
//! Reads only the layout model and the comments of the shader. `plan` decides
//! which Rust type stands for each member (`types`, `leaf` and `array` are what
//! it can choose from), `naming` and `names` give every type its Rust name, and
//! `mirror`, `tail`, `small`, `strided`, `check` and `table` print one kind of
//! item each. `docs` carries the shader's comments over.

mod array;
mod check;
mod docs;
mod field;
mod header;
mod leaf;
mod mirror;
mod names;
mod naming;
mod plan;
mod print;
mod refuse;
mod small;
mod strided;
mod table;
mod tail;
mod types;

pub use field::field;

use crate::ShaderLayout;
use crate::diagnostic::Diagnostic;

/// How vectors and matrices are written in a mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vectors {
    /// `glam::Vec3`, `glam::Mat4`, where their size and alignment fit.
    #[default]
    Glam,
    /// `[f32; 3]`, `[[f32; 4]; 4]`.
    Array,
}

impl Vectors {
    /// The name used in `--vectors`.
    pub fn name(self) -> &'static str {
        match self {
            Vectors::Glam => "glam",
            Vectors::Array => "array",
        }
    }

    /// The way of that name.
    pub fn from_name(name: &str) -> Option<Vectors> {
        [Vectors::Glam, Vectors::Array].into_iter().find(|vectors| vectors.name() == name)
    }
}

/// Who may use the items that are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Visibility {
    /// `pub`.
    #[default]
    Public,
    /// `pub(crate)`.
    Crate,
}

/// Whether the tables from names to offsets are written beside the mirrors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tables {
    /// One module a block.
    #[default]
    Beside,
    /// Mirrors only.
    Without,
}

/// What the Rust text is to be like.
#[derive(Clone, Debug, Default)]
pub struct RustOptions {
    /// How vectors and matrices are written.
    pub vectors: Vectors,
    /// Who may use the items.
    pub visibility: Visibility,
    /// Whether tables stand beside the mirrors.
    pub tables: Tables,
    /// What each shader is called in the text, in the order of the shaders. One without a name
    /// here goes by its own path, of which only the file name is used when it is absolute.
    pub inputs: Vec<String>,
}

/// Mirrors and tables as Rust text.
#[derive(Clone, Debug)]
pub struct RustOutput {
    /// The file: for `include!`, or to be checked in.
    pub text: String,
    /// One finding for every block that has no mirror.
    pub diagnostics: Vec<Diagnostic>,
}

/// Writes a mirror of every block of `shaders` and of every structure in them, and the tables.
///
/// The text needs `bytemuck`, and `glam` where it is asked for; its head says which features.
/// The same layout in two shaders is written once. A block that no Rust type can mirror is
/// left out and has a finding; its neighbours are written.
pub fn rust(shaders: &[&ShaderLayout], options: &RustOptions) -> RustOutput {
    let inputs: Vec<String> =
        shaders.iter().enumerate().map(|(i, shader)| header::input(shader, options, i)).collect();
    let mut plan = plan::Plan::new(options.vectors);
    let mut diagnostics = Vec::new();
    for (shader, input) in shaders.iter().zip(&inputs) {
        for block in &shader.blocks {
            match refuse::reason(block, shader.language) {
                Some(finding) => {
                    diagnostics.push(Diagnostic { path: Some(shader.path.clone()), ..finding })
                }
                None => plan.add(block, shader, input),
            }
        }
    }
    let names = naming::name_all(&plan, options.tables);
    let out = print::Printer { plan: &plan, names: &names, options };

    let mut text = header::header(&out, &inputs, shaders);
    mirror::mirrors(&out, &mut text);
    if options.tables == Tables::Beside {
        table::tables(&out, &mut text);
    }
    small::small_types(&out, &mut text);
    check::checks(&out, &mut text);
    RustOutput { text, diagnostics }
}
