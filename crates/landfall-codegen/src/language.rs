//! What a language of generated code is: its name, what it is for, and the function that writes it.
//!
//! [`languages`](super::languages) lists all of them.

use std::fmt;

use super::c::COptions;
use super::rust::RustOptions;
use landfall_layout::diagnostic::{Code, Severity};
use landfall_layout::shape::AddressSpace;
use landfall_layout::{Diagnostic, ShaderLayout};

/// A language that mirrors are generated in.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct OutputLanguage {
    /// The name in `--lang`.
    pub name: &'static str,
    /// The name in messages.
    pub title: &'static str,
    /// One line of help.
    pub about: &'static str,
    /// The options of `landfall emit` that have an effect on it only or on some languages only.
    pub options: &'static [&'static str],
    pub(super) write: fn(&[&ShaderLayout], &CodeOptions) -> CodeOutput,
    pub(super) assert: fn(&[&ShaderLayout], &CodeOptions) -> CodeOutput,
}

/// Options of generated code; each language reads those that it has.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct CodeOptions {
    /// Options of Rust mirrors.
    pub rust: RustOptions,
    /// Options of C headers, but for their file and prefix.
    pub c: COptions,
    /// The name of the file that is written, if known.
    pub file: String,
    /// The prefix of every name outside of a type.
    pub prefix: String,
    /// The structures of the program that [`OutputLanguage::assertions`] are about.
    pub assertions: AssertOptions,
}

/// The structures of a program that assertions are written for.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct AssertOptions {
    /// A structure of the program, `engine::PointLight`, with the structure (`PointLight`), block or
    /// member of a block (`Lights.data[]`) of the shaders that its bytes are read as.
    pub structures: Vec<(String, String)>,
    /// The program's name of a member, `PointLight.position` with `pos`; an empty one for a member
    /// that the program's structure does not have.
    pub fields: Vec<(String, String)>,
    /// What the program's names of members begin with, where the shader's do not: `m_`.
    pub field_prefix: String,
}

/// Generated code, and the diagnostics of the blocks it leaves out.
#[derive(Clone, Debug)]
pub struct CodeOutput {
    /// The text of the file.
    pub text: String,
    /// An error for every block that the language cannot mirror; `text` holds the others. A warning
    /// where there are none.
    pub diagnostics: Vec<Diagnostic>,
}

impl OutputLanguage {
    /// Writes one file for the blocks of `shaders`. Skips loose uniforms, which have no offsets; lay
    /// the shader out with `gather` to include them.
    pub fn generate(&self, shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
        let mut output = (self.write)(shaders, options);
        // Where blocks were refused, errors say so.
        if output.diagnostics.is_empty() {
            output.diagnostics.extend(no_blocks(shaders));
        }
        output
    }

    /// Writes one file of assertions that structures of the program lie in memory as `shaders` read
    /// them. An error for a structure or member that is not there, and for a language that has no
    /// structures with a layout.
    pub fn assertions(&self, shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
        (self.assert)(shaders, options)
    }
}

/// Returns the warning that there is nothing to mirror.
fn no_blocks(shaders: &[&ShaderLayout]) -> Option<Diagnostic> {
    let mut blocks = shaders.iter().flat_map(|shader| &shader.blocks).peekable();
    let (message, help) = match blocks.peek() {
        None => ("no blocks to mirror", None),
        Some(_) => (
            "no blocks to mirror: the output has none, as uniforms outside blocks have no bytes",
            Some("lay them out as one block with `--gather`"),
        ),
    };
    let found = Diagnostic::without_place(Code::NoBlocks, Severity::Warning, message);
    blocks.all(|block| block.space == AddressSpace::Default).then(|| match help {
        Some(help) => found.with_help(help),
        None => found,
    })
}

impl fmt::Debug for OutputLanguage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("OutputLanguage").field(&self.name).finish()
    }
}

impl PartialEq for OutputLanguage {
    fn eq(&self, other: &OutputLanguage) -> bool {
        // Names are unique, and functions cannot be compared.
        self.name == other.name
    }
}

impl Eq for OutputLanguage {}
