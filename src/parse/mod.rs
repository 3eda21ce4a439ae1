//! From text to [`Shape`]: the declarations of a shader, function bodies passed over.

pub(crate) mod constant;
pub(crate) mod glsl;
pub(crate) mod naga;
mod wgsl;

use crate::diagnostic::Diagnostic;
use crate::shape::Shape;
use crate::source::{Files, Language, ReadOptions, Source, Span};

/// What was read of a shader.
#[derive(Clone, Debug, Default)]
pub struct Parsed {
    /// Its blocks and the types in them.
    pub shape: Shape,
    /// The files it is made of: itself, then its includes.
    pub files: Files,
    /// What is wrong with it.
    pub diagnostics: Vec<Diagnostic>,
    /// Function bodies in the shader's own file: from after `{` to before `}`.
    pub bodies: Vec<Span>,
}

/// Reads the declarations of a shader. With `gather`, loose uniforms become one std140 block.
pub fn parse(source: &Source, options: &ReadOptions, gather: bool) -> Parsed {
    match source.language {
        Language::Glsl => glsl::read(source, options, gather),
        Language::Wgsl => wgsl::read(source, options),
    }
}

/// The known name a misspelt one is closest to, if it is close.
pub(crate) fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    let bound = if name.len() < 4 { 1 } else { 2 };
    known
        .map(|other| (distance(name, other), other))
        .filter(|(distance, _)| *distance <= bound)
        .min()
        .map(|(_, other)| other)
}

/// Edits between two names: a letter added, taken away or changed; case does not count.
fn distance(a: &str, b: &str) -> usize {
    let (a, b) = (a.to_ascii_lowercase().into_bytes(), b.to_ascii_lowercase().into_bytes());
    if a.len().abs_diff(b.len()) > 2 {
        return usize::MAX;
    }
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let change = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = change.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
