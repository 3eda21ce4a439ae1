//! A shader as the port sees it: its text, its tokens, its declarations, and
//! the names in it.

use std::cell::RefCell;
use std::ops::Range;

use rustc_hash::{FxHashMap, FxHashSet};

use super::outline::{
    Declaration, Function, Structure, Token, Tokens, Variables, code, declarations,
};
use crate::source::Span;
use crate::syntax::glsl::lexer::Kind;
use crate::syntax::glsl::qualifiers::is_qualifier;
use crate::syntax::glsl::raw::RawText;
use crate::syntax::glsl::types::{Builtin, builtin};

/// A shader to be ported.
pub(super) struct Shader<'a> {
    pub text: &'a str,
    pub raw: RawText,
    /// What the compiler reads.
    pub code: Vec<Token<'a>>,
    pub declarations: Vec<Declaration>,
    /// Every name in the text, and those given out since.
    names: RefCell<FxHashSet<String>>,
}

impl<'a> Shader<'a> {
    pub fn new(text: &'a str, raw: RawText) -> Shader<'a> {
        let code = code(text, &raw);
        let declarations = declarations(text, &code, qualifier_macros(text, &raw));
        let words = raw.tokens.iter().filter(|token| token.kind == Kind::Name);
        let names = words.map(|token| text[token.start..token.end].to_string()).collect();
        Shader { text, raw, code, declarations, names: RefCell::new(names) }
    }

    /// The spelling of a raw token.
    pub fn word(&self, at: usize) -> &'a str {
        let token = &self.raw.tokens[at];
        &self.text[token.start..token.end]
    }

    /// Raw tokens that are names, those of directives that speak to the compiler left out.
    pub fn words(&self) -> impl Iterator<Item = usize> + '_ {
        let silent = ["version", "extension", "pragma", "error", "include", "line"];
        let mut skipped = None;
        (0..self.raw.tokens.len()).filter(move |&at| {
            let token = &self.raw.tokens[at];
            if token.directive.is_some() && self.word(at) == "#" {
                let name = self.raw.tokens.get(at + 1);
                let name = name.map_or("", |name| &self.text[name.start..name.end]);
                skipped = silent.contains(&name).then_some(token.directive);
            }
            token.kind == Kind::Name
                && (token.directive.is_none() || skipped != Some(token.directive))
        })
    }

    /// Whether a raw token stands in `layout(…)`.
    pub fn in_layout(&self, at: usize) -> bool {
        let mut before = (0..at).rev().take(64);
        let open = before.find(|&at| matches!(self.word(at), "(" | ")" | ";" | "{"));
        open.is_some_and(|open| {
            self.word(open) == "(" && open > 0 && self.word(open - 1) == "layout"
        })
    }

    /// The directives: the raw tokens of each, `#` included.
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

    /// A name nothing in the shader has: that one, or with underscores behind it.
    pub fn unused(&self, name: &str) -> String {
        let mut name = name.replace("__", "_");
        while !self.names.borrow_mut().insert(name.clone()) {
            name.push_str(if name.ends_with('_') { "0" } else { "_" });
        }
        name
    }

    pub fn functions(&self) -> impl Iterator<Item = &Function> {
        self.declarations.iter().filter_map(|declaration| match declaration {
            Declaration::Function(function) => Some(function),
            _ => None,
        })
    }

    pub fn variables(&self) -> impl Iterator<Item = &Variables> {
        self.declarations.iter().filter_map(|declaration| match declaration {
            Declaration::Variables(variables) => Some(variables),
            _ => None,
        })
    }

    /// Every structure by its name, those declared with variables too.
    pub fn structures(&self) -> FxHashMap<&'a str, &Structure> {
        let declared = self.declarations.iter().filter_map(|declaration| match declaration {
            Declaration::Structure(structure) => Some(structure),
            Declaration::Variables(variables) => variables.structure.as_ref(),
            _ => None,
        });
        declared.filter_map(|s| Some((self.code[s.name?].text, s))).collect()
    }

    pub fn has_word(&self, variables: &Variables, word: &str) -> bool {
        variables.qualifiers.words.iter().any(|&at| self.code[at].text == word)
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
        Span { file: 0, start: token.start as u32, end: token.end as u32 }
    }

    /// Where the line of a byte begins.
    pub fn line_start(&self, at: usize) -> usize {
        self.text[..at].rfind('\n').map_or(0, |newline| newline + 1)
    }

    /// Where the line after that of a byte begins.
    pub fn next_line(&self, at: usize) -> usize {
        self.text[at..].find('\n').map_or(self.text.len(), |newline| at + newline + 1)
    }

    /// What a declaration takes with it when it goes: its lines with their comments when it is
    /// alone on them, else itself.
    pub fn lines_of(&self, tokens: &Tokens) -> Taken<'a> {
        let bytes = self.bytes(tokens);
        let (mut start, end) = (self.line_start(bytes.start), self.next_line(bytes.end));
        let after = self.text[bytes.end..end].trim();
        let comment = after.starts_with("//")
            || (after.starts_with("/*") && after.find("*/") == Some(after.len() - 2));
        let alone =
            self.text[start..bytes.start].trim().is_empty() && (after.is_empty() || comment);
        if !alone {
            let space = self.text[bytes.end..].starts_with(' ');
            return Taken {
                bytes: bytes.start..bytes.end + usize::from(space),
                before: "",
                after: "",
            };
        }
        let own = start;
        // Comments of whole lines right above belong to it.
        while start > 0 {
            let above = self.line_start(start - 1);
            if !self.text[above..start].trim_start().starts_with("//") {
                break;
            }
            start = above;
        }
        Taken { bytes: start..end, before: &self.text[start..own], after }
    }
}

/// Macros that stand for nothing but qualifiers: `#define MEDIUM mediump`.
fn qualifier_macros<'a>(text: &'a str, raw: &RawText) -> FxHashSet<&'a str> {
    let mut lines: Vec<Vec<&'a str>> = Vec::new();
    for token in raw.tokens.iter().filter(|token| token.active) {
        if let Some(number) = token.directive {
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

/// A part of the text that moves.
#[derive(Clone, Debug)]
pub(super) struct Taken<'a> {
    pub bytes: Range<usize>,
    /// Lines of comment above it.
    pub before: &'a str,
    /// A comment at the end of its line.
    pub after: &'a str,
}

/// Whether a type's name is that of a handle: a sampler, an image.
pub(super) fn is_opaque(name: &str) -> bool {
    builtin(name) == Some(Builtin::Opaque)
}
