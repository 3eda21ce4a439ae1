//! Diagnostics about WGSL text, and their wording.

use super::lexer::{Kind, WgslLexer, WgslToken};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::source::Span;
use crate::text::edit_distance::suggestion;

/// The limit on diagnostics per file; later ones tend to follow from earlier ones.
const MAX_REPORTS: usize = 100;

/// The language features of WGSL (§4.1.2) and those proposed for it.
pub(super) const LANGUAGE_FEATURES: [&str; 14] = [
    "buffer_view",
    "fragment_depth",
    "immediate_address_space",
    "linear_indexing",
    "packed_4x8_integer_dot_product",
    "pointer_composite_access",
    "readonly_and_readwrite_storage_textures",
    "subgroup_id",
    "subgroup_uniformity",
    "swizzle_assignment",
    "texture_and_sampler_let",
    "texture_formats_tier1",
    "uniform_buffer_standard_layout",
    "unrestricted_pointer_parameters",
];

/// An error that has been reported.
// Carries nothing, since what there is to say is in `Reports`; a caller that meets it goes on or
// gives up in silence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Refused;

#[derive(Debug, Default)]
pub(super) struct Reports {
    list: Vec<Diagnostic>,
    /// The number of diagnostics left out.
    more: usize,
    /// Whether the text is a template of another tool.
    pub(super) saw_preprocessor: bool,
}

impl Reports {
    pub(super) fn push(&mut self, diagnostic: Diagnostic) {
        self.saw_preprocessor |= diagnostic.code == Code::Preprocessor;
        if self.list.len() < MAX_REPORTS {
            self.list.push(diagnostic);
        } else if diagnostic.severity == Severity::Error {
            self.more += 1;
        }
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Drops the diagnostics from `first` on that are not syntax errors.
    pub(super) fn keep_syntax_errors(&mut self, first: usize) {
        let later = self.list.split_off(first);
        self.list.extend(later.into_iter().filter(|found| found.code == Code::Syntax));
    }

    /// Records a diagnostic and returns the value to use as `Err`.
    pub(super) fn refuse(&mut self, diagnostic: Diagnostic) -> Refused {
        self.push(diagnostic);
        Refused
    }

    /// Records the error of a part that was read.
    pub(super) fn checked<T>(&mut self, read: Result<T, Diagnostic>) -> Result<T, Refused> {
        read.map_err(|error| self.refuse(error))
    }

    /// Returns the diagnostics; the last one notes how many were left out.
    pub(super) fn finish(mut self) -> Vec<Diagnostic> {
        if let (Some(last), true) = (self.list.last_mut(), self.more > 0) {
            last.notes.push(format!("{} more errors in this file are not shown", self.more));
        }
        self.list
    }
}

pub(super) fn span(token: WgslToken) -> Span {
    Span { file: 0, start: token.start, end: token.end }
}

/// Returns the warning about a language feature that landfall does not know.
pub(super) fn unknown_feature(name: &str, token: WgslToken) -> Diagnostic {
    let message = format!("unknown language feature `{name}`");
    let warning = Diagnostic::warning(Code::UnknownName, span(token), message);
    let note = "compilers that do not know a required feature refuse the shader (WGSL §4.1.2)";
    misspelt(warning, name, LANGUAGE_FEATURES.into_iter()).with_note(note)
}

/// Returns the diagnostic for an unexpected token.
// A `#` stands for a preprocessor wherever it is, so that case comes before the others.
pub(super) fn unexpected(lexer: &WgslLexer<'_>, token: WgslToken, expected: &str) -> Diagnostic {
    let found = match token.kind {
        Kind::End => "the end of the file".to_string(),
        Kind::Word | Kind::Number | Kind::Sign(_) => format!("`{}`", lexer.text_of(token)),
    };
    let message = format!("expected {expected}, found {found}");
    let diagnostic = Diagnostic::error(Code::Syntax, span(token), message);
    match (token.kind, expected) {
        (Kind::Sign(b'#'), _) => preprocessor(lexer, token),
        (_, "`;`") => diagnostic.with_help("write `;` after the declaration before it"),
        (_, "`,` or `}`") => diagnostic.with_help("write `,` between two members"),
        _ => diagnostic,
    }
}

/// Consumes a sign.
///
/// # Errors
/// Another token, which is not consumed.
pub(super) fn expect(lexer: &mut WgslLexer<'_>, sign: u8) -> Result<WgslToken, Diagnostic> {
    let token = lexer.peek();
    match lexer.take(sign) {
        true => Ok(token),
        false => Err(unexpected(lexer, token, &format!("`{}`", char::from(sign)))),
    }
}

/// Consumes a word, which `expected` describes.
///
/// # Errors
/// Another token.
pub(super) fn word(lexer: &mut WgslLexer<'_>, expected: &str) -> Result<WgslToken, Diagnostic> {
    let token = lexer.next();
    match token.kind {
        Kind::Word => Ok(token),
        Kind::Number | Kind::Sign(_) | Kind::End => Err(unexpected(lexer, token, expected)),
    }
}

/// Skips from after a bracket past the one that closes it.
///
/// # Errors
/// A sign that stands in no such brackets.
pub(super) fn skip_past(lexer: &mut WgslLexer<'_>, open: u8, close: u8) -> Result<(), Diagnostic> {
    let mut depth = 1u32;
    while depth > 0 {
        let token = lexer.next();
        match token.kind {
            Kind::Sign(sign) if sign == open => depth += 1,
            Kind::Sign(sign) if sign == close => depth -= 1,
            Kind::Sign(b';' | b'{' | b'}') | Kind::End => {
                let expected = format!("`{}`", char::from(close));
                return Err(unexpected(lexer, token, &expected));
            }
            Kind::Word | Kind::Number | Kind::Sign(_) => {}
        }
    }
    Ok(())
}

pub(super) fn bad_number(lexer: &WgslLexer<'_>, token: WgslToken) -> Diagnostic {
    let message = format!("`{}` is not a valid number in WGSL", lexer.text_of(token));
    Diagnostic::error(Code::Syntax, span(token), message)
}

pub(super) fn unclosed_comment(start: u32) -> Diagnostic {
    let span = Span { file: 0, start, end: start + 2 };
    Diagnostic::error(Code::UnclosedComment, span, "this comment is never closed")
        .with_note("block comments nest in WGSL: every `/*` in it needs its own `*/`")
        .with_help("write `*/` where it ends")
}

pub(super) fn unclosed_brace(name: &str, open: Span) -> Diagnostic {
    Diagnostic::error(Code::UnclosedBrace, open, format!("a `{{` of `{name}` is never closed"))
        .with_help(format!("write `}}` at the end of `{name}`"))
}

pub(super) fn bracket_attribute(token: WgslToken) -> Diagnostic {
    Diagnostic::error(Code::Syntax, span(token), "attributes in `[[…]]` are no longer WGSL")
        .with_help("write `@group(0) @binding(0)` for `[[group(0), binding(0)]]`")
}

pub(super) fn module_let(token: WgslToken) -> Diagnostic {
    Diagnostic::error(Code::Syntax, span(token), "`let` is only allowed inside functions")
        .with_help("write `const`")
}

/// Returns the diagnostic for a declaration in another shading language.
pub(super) fn other_language(
    lexer: &WgslLexer<'_>,
    token: WgslToken,
    language: &str,
) -> Diagnostic {
    let word = lexer.text_of(token);
    let message = format!("`{word}` begins a declaration in {language}, not WGSL");
    let help = match language {
        "GLSL" => "name the file `.frag`, `.vert` or `.comp`, or pass `--language glsl`",
        _ => "landfall reads GLSL and WGSL",
    };
    Diagnostic::error(Code::OtherLanguage, span(token), message).with_help(help)
}

/// Returns the diagnostic for lines that begin with `#` and for imports out of place.
pub(super) fn preprocessor(lexer: &WgslLexer<'_>, token: WgslToken) -> Diagnostic {
    let rest = &lexer.text()[token.start as usize..];
    let word_end = rest[1..].find(|c: char| !c.is_alphanumeric() && c != '_');
    let word = &rest[..word_end.map_or(rest.len(), |end| end + 1)];
    let end = token.start + word.len() as u32;
    let span = Span { file: 0, start: token.start, end };
    match word {
        "#version" | "#extension" => {
            let message = format!("`{word}` is a line of GLSL, not WGSL");
            Diagnostic::error(Code::OtherLanguage, span, message)
                .with_help("name the file `.frag`, `.vert` or `.comp`, or pass `--language glsl`")
        }
        "import" => {
            let message = "an import stands before all declarations";
            Diagnostic::error(Code::Preprocessor, span, message)
        }
        _ => Diagnostic::error(Code::Preprocessor, span, format!("`{word}` is not WGSL"))
            .with_note("of lines with `#`, those of naga_oil and `#include` are read")
            .with_help("put the shader together first, and lay out the result"),
    }
}

pub(super) fn duplicate(name: &str, again: Span, first: Span) -> Diagnostic {
    Diagnostic::error(Code::DuplicateName, again, format!("`{name}` is defined twice"))
        .with_label(first, "first defined here")
        .with_help("rename or remove one of them")
}

pub(super) fn too_deep(at: Span) -> Diagnostic {
    Diagnostic::error(Code::NestedTooDeep, at, "types and expressions are nested too deeply here")
        .with_note("landfall supports about a hundred levels, so as not to overflow the stack")
}

/// Returns a diagnostic that suggests the name nearest to a misspelt one.
pub(super) fn misspelt<'n>(
    diagnostic: Diagnostic,
    name: &str,
    known: impl Iterator<Item = &'n str>,
) -> Diagnostic {
    match suggestion(name, known) {
        Some(help) => diagnostic.with_help(help),
        None => diagnostic,
    }
}
