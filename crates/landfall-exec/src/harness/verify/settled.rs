//! The text that backends run where they could read the user's in another way than its layout does.
//!
//! A driver defines `VULKAN`, `__VERSION__` and the macros of extensions by its own version, opens no
//! files and knows no `--define`; a probe needs a `#version` that the text may lack. Where a text
//! depends on any of these, each backend gets it as the layout reads it.

use crate::harness::probe::glsl;
use landfall_layout::source::{Language, ReadOptions, Source};
use landfall_layout::syntax::glsl::raw::{self, RawText};

/// Returns the text as it is laid out, with includes inlined, macros expanded and conditions decided,
/// and the options to read it with; `None` if every backend reads the user's text alike.
pub(super) fn settled(source: &Source, read: &ReadOptions) -> Option<(Source, ReadOptions)> {
    if source.language != Language::Glsl {
        return None;
    }
    let raw = raw::read(source, read);
    let is_flattened = depends_on_the_reader(&source.text, &raw, read);
    let has_version = glsl::Head::from_text(&source.text).end > 0;
    if has_version && !is_flattened {
        return None;
    }
    let mut settled = read.clone();
    settled.target = read.target.or(raw.target);
    let mut text = source.text.to_string();
    if is_flattened {
        text = raw::flattened(source, read);
        settled.defines.clear();
    }
    if !has_version {
        // The latest, in which what the oldest has is still there.
        text = format!("#version 450 compatibility\n#line 1\n{text}");
    }
    Some((Source { text: text.into(), ..source.clone() }, settled))
}

/// Whether the text has an include, a name that is defined from outside, or a condition on one.
fn depends_on_the_reader(text: &str, raw: &RawText, read: &ReadOptions) -> bool {
    let mut directive = (None, "");
    raw.tokens.iter().any(|token| {
        let word = &text[token.start..token.end];
        if token.directive != directive.0 {
            directive = (token.directive, "");
        } else if directive.1.is_empty() {
            directive.1 = word;
        }
        let in_condition = || matches!(directive.1, "if" | "ifdef" | "ifndef" | "elif");
        match word {
            "VULKAN" | "__VERSION__" => true,
            "include" => token.directive.is_some() && directive.1 == "include",
            _ if word.starts_with("GL_") => token.directive.is_some() && in_condition(),
            _ => read.defines.iter().any(|(name, _)| name == word),
        }
    })
}
