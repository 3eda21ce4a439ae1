//! Finds the place in the user's text that a diagnostic of a ported text is about.

use super::edits::Edits;
use super::shader::Shader;
use landfall_layout::source::Span;
use landfall_layout::{Diagnostic, Source};

/// Maps places in a ported text back to the user's text.
pub(super) struct Origin<'a> {
    pub user: &'a Shader<'a>,
    /// The edits that produced the ported text.
    pub edits: &'a Edits,
    /// The ported text.
    pub before: &'a Source,
    /// Renames as old and new names.
    pub renamed: &'a [(String, String)],
}

impl Origin<'_> {
    /// Moves the places of diagnostics from the ported text, or from what `further` made of it, to
    /// the user's text. One without a place gets that of the variable it names.
    pub fn move_back(&self, found: &mut [Diagnostic], further: Option<&Edits>) {
        for diagnostic in found {
            let about = std::mem::take(&mut diagnostic.about);
            for label in &mut diagnostic.labels {
                label.at = match label.at == Span::default() {
                    true => self.declaration(&about).unwrap_or_default(),
                    false => self.place(label.at, further),
                };
            }
        }
    }

    fn place(&self, span: Span, further: Option<&Edits>) -> Span {
        if span.file != 0 {
            return span;
        }
        // First to the text for Vulkan, then to the user's.
        let back = |at: usize| match further {
            Some(edits) => edits.origin(&self.before.text, at),
            None => at,
        };
        let (start, end) = (back(span.start as usize), back(span.end as usize));
        let text = self.user.text;
        let origin = |at: usize| self.edits.origin(text, at);
        // A member of the block of uniforms was declared elsewhere.
        if self.edits.is_inserted(text, start) {
            let line = self.before.text.get(start..).unwrap_or("").split([';', '\n']).next();
            let name = line.unwrap_or("").split('[').next().unwrap_or("");
            let name = name.rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_').next();
            if let Some(found) = name.and_then(|name| self.declaration(name)) {
                return found;
            }
        }
        let (start, end) = (origin(start), origin(end));
        Span { file: 0, start: start as u32, end: end.max(start) as u32 }
    }

    /// Returns the declaration of the variable that a path of the ported text begins with.
    fn declaration(&self, path: &str) -> Option<Span> {
        let name = path.split(['.', '[']).next().filter(|name| !name.is_empty())?;
        let renamed = self.renamed.iter().find(|(_, new)| new == name);
        let name = renamed.map_or(name, |(old, _)| old.split('.').next().unwrap_or(old));
        declared(self.user, name)
    }
}

// The declaration of a global variable, or else the first use of the name.
fn declared(shader: &Shader<'_>, name: &str) -> Option<Span> {
    let names = shader.variables().flat_map(|variables| &variables.names);
    let found = names.map(|declarator| &declarator.name).find(|own| own.text == name);
    found.map(|own| own.span).or_else(|| {
        let token = shader.code.iter().position(|token| token.text == name)?;
        Some(shader.span(token))
    })
}
