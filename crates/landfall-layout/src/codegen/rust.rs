//! Rust mirrors of blocks, and tables from member names to offsets.
//!
//! Reads only the layout model and the comments of the shader. `plan` chooses the Rust type of
//! each member (with `types`, `leaf` and `array`), `naming` and `names` name every type, and
//! `mirror`, `tail`, `small`, `strided`, `check` and `table` print one kind of item each.
//! `docs` copies the shader's comments.

mod array;
mod check;
mod docs;
mod field;
mod header;
mod host;
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

/// Whether to generate tables from names to offsets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tables {
    /// One module per block.
    #[default]
    Beside,
    /// Mirrors only.
    Without,
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
    /// The name of each shader in the text, in the order of the shaders. A shader without one is
    /// named by its path, or by its file name if the path is absolute.
    pub inputs: Vec<String>,
}

/// Mirrors and tables as Rust text.
#[derive(Clone, Debug)]
pub struct RustOutput {
    /// The file's text, for `include!` or to be checked in.
    pub text: String,
    /// One error for every block without a mirror.
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
