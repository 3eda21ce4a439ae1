//! The table of languages that mirrors are generated in.

mod csharp;
mod gdscript;
mod python;
mod renderdoc;
mod typescript;
mod zig;

pub use csharp::CSHARP;
pub use gdscript::GDSCRIPT;
pub use python::PYTHON;
pub use renderdoc::RENDERDOC;
pub use typescript::TYPESCRIPT;
pub use zig::ZIG;

use super::assertions;
use super::c::{COptions, c};
use super::language::{CodeOptions, CodeOutput, OutputLanguage};
use super::rust::rust;
use landfall_layout::ShaderLayout;

/// All languages, in the order of the help.
pub const LANGUAGES: &[OutputLanguage] =
    &[RUST, C, CSHARP, PYTHON, TYPESCRIPT, ZIG, GDSCRIPT, RENDERDOC];

/// Rust.
pub const RUST: OutputLanguage = OutputLanguage {
    name: "rust",
    title: "Rust",
    about: "`#[repr(C)]` structures for bytemuck, offsets checked at compile time",
    options: &[
        "--vectors",
        "--modules",
        "--rename",
        "--type",
        "--derive",
        "--crate-visible",
        "--no-tables",
        "--bindings",
    ],
    write: |shaders, options| {
        let output = rust(shaders, &options.rust);
        CodeOutput { text: output.text, diagnostics: output.diagnostics }
    },
    assert: assertions::rust,
};

/// C11 and C++17.
pub const C: OutputLanguage = OutputLanguage {
    name: "c",
    title: "C",
    about: "A header for C11 and C++17, offsets checked at compile time",
    options: &["--prefix", "--vectors", "--type", "--namespace", "--include-header"],
    write: c_header,
    assert: assertions::c,
};

fn c_header(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    let CodeOptions { file, prefix, .. } = options;
    // The include guard is made of it, also where the header has no file.
    let file = if file.is_empty() { "landfall.h" } else { file };
    let output = c(
        shaders,
        &COptions { file: file.to_string(), prefix: prefix.clone(), ..options.c.clone() },
    );
    CodeOutput { text: output.text, diagnostics: output.diagnostics }
}

/// Finds a language by its name in `--lang`.
pub fn from_name(name: &str) -> Option<OutputLanguage> {
    LANGUAGES.iter().copied().find(|language| language.name == name)
}
