//! The shader being ported: its text, tokens, declarations and names.

use std::cell::RefCell;
use std::ops::Range;

use rustc_hash::{FxHashMap, FxHashSet};

use super::outline::{self, OutlineToken, Tokens};
use landfall_layout::Diagnostic;
use landfall_layout::diagnostic::Code;
use landfall_layout::source::{ReadOptions, Source, Span};
use landfall_layout::syntax::glsl::ast::{
    Declaration, Dim, FunctionDecl, Item, Qualifiers, StructDecl, TypeBase, TypeSpec,
};
use landfall_layout::syntax::glsl::layout_numbers;
use landfall_layout::syntax::glsl::lexer::Kind;
use landfall_layout::syntax::glsl::qualifiers::is_qualifier;
use landfall_layout::syntax::glsl::raw::{self, RawText};
use landfall_layout::syntax::glsl::types::{Builtin, builtin};

/// GLSL 4.60.
const NEWEST: u32 = 460;

/// A shader to be ported.
pub(super) struct Shader<'a> {
    pub text: &'a str,
    pub raw: RawText,
    /// The active tokens outside directives.
    pub code: Vec<OutlineToken<'a>>,
    pub items: Vec<Item<'a>>,
    /// The values of `KEY = N` in layout qualifiers, by the first byte of the key.
    pub numbers: FxHashMap<u32, u32>,
    /// Every name in the text, and those created since.
    names: RefCell<FxHashSet<String>>,
}

impl<'a> Shader<'a> {
    pub fn new(source: &'a Source, options: &ReadOptions) -> Shader<'a> {
        let (text, raw) = (&*source.text, raw::read(source, options));
        let code = outline::code(text, &raw);
        let items = outline::declarations(text, &code, qualifier_macros(text, &raw));
        let words = raw.tokens.iter().filter(|token| token.kind == Kind::Name);
        let names = words.map(|token| text[token.start..token.end].to_string()).collect();
        let numbers = layout_numbers(source, options);
        Shader { text, raw, code, items, numbers, names: RefCell::new(names) }
    }

    /// The version of the language that the text is written in. Without `#version` that is 1.10, which
    /// has no `layout(…)`; a text with one is read as the newest, as `landfall layout` reads it.
    pub fn language_version(&self) -> u32 {
        let qualified = |at: &[OutlineToken<'_>]| at[0].text == "layout" && at[1].text == "(";
        match self.raw.version_directive(self.text) {
            None if self.code.windows(2).any(qualified) => NEWEST,
            None | Some(_) => self.raw.version,
        }
    }

    /// The spelling of a raw token; empty behind the last one.
    pub fn word(&self, at: usize) -> &'a str {
        self.raw.tokens.get(at).map_or("", |token| &self.text[token.start..token.end])
    }

    /// The bytes of a raw token.
    pub fn raw_bytes(&self, at: usize) -> Range<usize> {
        let token = &self.raw.tokens[at];
        token.start..token.end
    }

    pub fn raw_span(&self, at: usize) -> Span {
        span(self.raw_bytes(at))
    }

    /// The indices of raw tokens that are names, except in directives without names of the shader.
    pub fn words(&self) -> impl Iterator<Item = usize> + '_ {
        // Words of these directives are no names: a version, an extension, a path.
        let silent = ["version", "extension", "pragma", "error", "include", "line"];
        let mut skipped = None;
        (0..self.raw.tokens.len()).filter(move |&at| {
            let token = &self.raw.tokens[at];
            if token.directive.is_some() && self.word(at) == "#" {
                skipped = silent.contains(&self.word(at + 1)).then_some(token.directive);
            }
            token.kind == Kind::Name
                && (token.directive.is_none() || skipped != Some(token.directive))
        })
    }

    /// Whether a raw token is inside `layout(…)`.
    pub fn in_layout(&self, at: usize) -> bool {
        // A qualifier list is short; the limit keeps long texts from being searched for each word.
        let mut before = (0..at).rev().take(64);
        let open = before.find(|&at| matches!(self.word(at), "(" | ")" | ";" | "{"));
        open.is_some_and(|open| {
            self.word(open) == "(" && open > 0 && self.word(open - 1) == "layout"
        })
    }

    /// The raw tokens of each directive, `#` included.
    pub fn directives(&self) -> Vec<Range<usize>> {
        let mut all: Vec<Range<usize>> = Vec::new();
        for (at, token) in self.raw.tokens.iter().enumerate() {
            let Some(number) = token.directive else { continue };
            match all.get_mut(number) {
                Some(range) => range.end = at + 1,
                None => all.push(at..at + 1),
            }
        }
        all
    }

    /// Claims a name unused in the shader: `name`, possibly with underscores appended.
    pub fn unused(&self, name: &str) -> String {
        // Two underscores in a row are reserved (GLSL 4.60 §3.7).
        let mut name = name.replace("__", "_");
        while !self.names.borrow_mut().insert(name.clone()) {
            name.push_str(if name.ends_with('_') { "0" } else { "_" });
        }
        name
    }

    pub fn functions(&self) -> impl Iterator<Item = &FunctionDecl<'a>> {
        self.items.iter().filter_map(|item| match item {
            Item::Function(function) => Some(&**function),
            _ => None,
        })
    }

    /// The declarations of variables.
    pub fn variables(&self) -> impl Iterator<Item = &Declaration<'a>> {
        self.items.iter().filter_map(|item| match item {
            Item::Variables(declaration) if !declaration.names.is_empty() => Some(&**declaration),
            _ => None,
        })
    }

    /// Every structure by name, including those declared with variables.
    pub fn structures(&self) -> FxHashMap<&'a str, &StructDecl<'a>> {
        let declared = self.items.iter().filter_map(|item| match item {
            Item::Variables(declaration) => structure(&declaration.ty),
            _ => None,
        });
        declared.filter(|s| !s.name.text.is_empty()).map(|s| (s.name.text, s)).collect()
    }

    /// The one-word qualifiers.
    pub fn words_of(&self, qualifiers: &Qualifiers<'_>) -> Vec<&'a str> {
        outline::words(&self.code, qualifiers)
    }

    pub fn has_word(&self, qualifiers: &Qualifiers<'_>, word: &str) -> bool {
        self.words_of(qualifiers).contains(&word)
    }

    /// The type name of a declaration, or `struct`.
    pub fn type_word(&self, ty: &TypeSpec<'_>) -> &'a str {
        self.code[ty.at].text
    }

    /// Array dimensions as written: `[2][N]`.
    pub fn dims<'d>(&self, dims: impl IntoIterator<Item = &'d Dim<'a>>) -> String
    where
        'a: 'd,
    {
        let dims = dims.into_iter();
        dims.map(|dim| format!("[{}]", self.text_of(&dim.tokens))).collect()
    }

    /// The bytes of some tokens.
    pub fn bytes(&self, tokens: &Tokens) -> Range<usize> {
        match (self.code.get(tokens.start), tokens.end.checked_sub(1).map(|last| &self.code[last]))
        {
            (Some(first), Some(last)) if first.start <= last.end && !tokens.is_empty() => {
                first.start..last.end
            }
            _ => 0..0,
        }
    }

    /// The text of some tokens.
    pub fn text_of(&self, tokens: &Tokens) -> &'a str {
        &self.text[self.bytes(tokens)]
    }

    pub fn span(&self, token: usize) -> Span {
        let token = &self.code[token];
        span(token.start..token.end)
    }

    /// The start of the line of a byte.
    pub fn line_start(&self, at: usize) -> usize {
        self.text[..at].rfind('\n').map_or(0, |newline| newline + 1)
    }

    /// The start of the line after that of a byte.
    pub fn next_line(&self, at: usize) -> usize {
        self.text[at..].find('\n').map_or(self.text.len(), |newline| at + newline + 1)
    }

    /// The text removed with a declaration: whole lines with their comments if nothing else is on
    /// them, else only the declaration.
    pub fn lines_of(&self, tokens: &Tokens) -> MovedText<'a> {
        let bytes = self.bytes(tokens);
        let (mut start, end) = (self.line_start(bytes.start), self.next_line(bytes.end));
        let after = self.text[bytes.end..end].trim();
        let comment = after.starts_with("//")
            || (after.starts_with("/*") && after.find("*/") == Some(after.len() - 2));
        let alone =
            self.text[start..bytes.start].trim().is_empty() && (after.is_empty() || comment);
        if !alone {
            let space = self.text[bytes.end..].starts_with(' ');
            return MovedText {
                bytes: bytes.start..bytes.end + usize::from(space),
                before: "",
                after: "",
            };
        }
        let own = start;
        // Whole-line comments right above belong to it.
        while start > 0 {
            let above = self.line_start(start - 1);
            if !self.text[above..start].trim_start().starts_with("//") {
                break;
            }
            start = above;
        }
        MovedText { bytes: start..end, before: &self.text[start..own], after }
    }
}

/// The macros that expand to qualifiers only: `#define MEDIUM mediump`.
fn qualifier_macros<'a>(text: &'a str, raw: &RawText) -> FxHashSet<&'a str> {
    let mut lines: Vec<Vec<&'a str>> = Vec::new();
    for token in raw.tokens.iter().filter(|token| token.active) {
        if let Some(number) = token.directive {
            // Directives are numbered from 0, in the order of the text.
            lines.resize_with(lines.len().max(number + 1), Vec::new);
            lines[number].push(&text[token.start..token.end]);
        }
    }
    let named = lines.iter().filter_map(|line| match line.as_slice() {
        ["#", "define", name, body @ ..] => {
            body.iter().all(|word| is_qualifier(word)).then_some(*name)
        }
        _ => None,
    });
    named.collect()
}

/// A part of the text to be moved.
#[derive(Clone, Debug)]
pub(super) struct MovedText<'a> {
    pub bytes: Range<usize>,
    /// Lines of comment above it.
    pub before: &'a str,
    /// A comment at the end of its line.
    pub after: &'a str,
}

/// The structure that a type declares.
pub(super) fn structure<'s, 'a>(ty: &'s TypeSpec<'a>) -> Option<&'s StructDecl<'a>> {
    match &ty.base {
        TypeBase::Struct(structure) => Some(structure),
        TypeBase::Name(_) => None,
    }
}

/// The place of some bytes of the shader's own text.
pub(super) fn span(bytes: Range<usize>) -> Span {
    Span { file: 0, start: bytes.start as u32, end: bytes.end as u32 }
}

/// An error about what cannot be ported.
pub(super) fn refusal(span: Span, message: impl Into<String>) -> Diagnostic {
    Diagnostic::error(Code::NotPortable, span, message)
}

/// Whether `name` is an opaque type: a sampler, an image.
pub(super) fn is_opaque(name: &str) -> bool {
    builtin(name) == Some(Builtin::Opaque)
}
