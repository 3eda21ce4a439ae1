//! The result of a port.

use landfall_layout::{Diagnostic, Source};

/// A ported shader, and the changes that matter to its host program.
#[derive(Clone, Debug)]
pub struct Ported {
    /// The new text.
    pub source: Source,
    /// The name of the block of loose uniforms, if there were any that the partner lacks.
    pub block: Option<String>,
    /// The name of the block of loose uniforms that the partner has, too, declared alike in both
    /// and with one binding.
    pub shared: Option<String>,
    /// Sets and bindings, that of the block of loose uniforms first.
    pub bindings: Vec<Binding>,
    /// The locations of inputs and outputs.
    pub locations: Vec<Location>,
    /// Initial values, as of `uniform float x = 2.0;`, which the host must now upload.
    pub values: Vec<InitialValue>,
    /// Renames as old and new names: keywords, and handles moved out of structures.
    pub renamed: Vec<(String, String)>,
    /// Functions renamed because a built-in function has their name: old and new names.
    pub functions: Vec<(String, String)>,
    /// The line of the original, counted from 1, that each line of the text comes from; empty for
    /// WGSL, and where includes were inlined.
    pub lines: Vec<u32>,
    /// Warnings about the result, at the lines of the original.
    pub warnings: Vec<Diagnostic>,
}

impl Ported {
    /// The new path of a member of the block (`sample.rate` may become `sample_.rate`) or of a
    /// sampler in a structure (`materials[2].diffuse` becomes `materials_diffuse[2]`).
    pub fn new_path(&self, path: &str) -> String {
        fn split(part: &str) -> (&str, &str) {
            part.split_at(part.find('[').unwrap_or(part.len()))
        }
        let (names, brackets): (Vec<&str>, Vec<&str>) = path.split('.').map(split).unzip();
        let renamed = |name: &str| {
            let row = self.renamed.iter().find(|(old, _)| old == name);
            row.map(|(_, new)| new.as_str())
        };
        // A handle: the names of its path are one variable, which has all indices.
        if let Some(own) = renamed(&names.join(".")).filter(|_| names.len() > 1) {
            return format!("{own}{}", brackets.concat());
        }
        let parts = names.iter().zip(brackets);
        let parts =
            parts.map(|(name, brackets)| format!("{}{brackets}", renamed(name).unwrap_or(name)));
        parts.collect::<Vec<_>>().join(".")
    }
}

/// A binding of a block or variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The name of the block or variable.
    pub name: String,
    /// The descriptor set.
    pub set: u32,
    /// The binding.
    pub binding: u32,
}

/// The direction of an interface variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Direction {
    /// Into the stage.
    In,
    /// Out of the stage.
    Out,
}

impl Direction {
    /// The GLSL keyword: `in` or `out`.
    pub fn name(self) -> &'static str {
        match self {
            Direction::In => "in",
            Direction::Out => "out",
        }
    }
}

/// The location of an input or output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The variable's or block's name.
    pub name: String,
    /// The direction.
    pub direction: Direction,
    /// The first location.
    pub location: u32,
}

/// The initial value of a loose uniform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InitialValue {
    /// The uniform's name.
    pub name: String,
    /// The expression as written.
    pub value: String,
}
