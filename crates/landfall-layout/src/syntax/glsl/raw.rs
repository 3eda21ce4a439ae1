//! The tokens of a shader's own file as written, macros not expanded, for edits of the text.

use std::borrow::Cow;

use rustc_hash::FxHashSet;

use super::ast::Item;
use super::lexer::{Kind, Lexer, Token};
use super::parser::Parser;
use super::preprocess::Preprocessor;
use super::splice;
use super::texts::Texts;
use crate::source::{Files, ReadOptions, Source, Span, Target};

// Places instead of texts: edits are made in the shader's own text, with its continuations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawToken {
    pub kind: Kind,
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
    /// Whether the compiler reads it, since no condition excludes it.
    pub active: bool,
    /// The number of the directive it is part of, from 0.
    pub directive: Option<usize>,
}

/// The tokens and other properties of a file.
#[derive(Debug)]
pub struct RawText {
    pub tokens: Vec<RawToken>,
    /// The shader's file, then its includes.
    pub files: Files,
    /// The number in `#version`, or its default.
    pub version: u32,
    pub es: bool,
    /// The API it is written for, as far as the text shows.
    pub target: Option<Target>,
}

/// A global declaration as written, macros not expanded.
#[derive(Debug)]
pub struct RawDeclaration<'a> {
    /// Indices of its tokens in [`RawText::tokens`]; directives and excluded text may lie between
    /// them.
    pub tokens: Vec<usize>,
    /// The declaration; ranges in it count only tokens that the compiler reads.
    pub item: Item<'a>,
}

impl RawText {
    /// Returns the indices of the tokens the compiler reads, without directives.
    pub fn code(&self) -> Vec<usize> {
        let all = self.tokens.iter().enumerate();
        all.filter(|(_, t)| t.active && t.directive.is_none()).map(|(at, _)| at).collect()
    }

    /// Returns `#version` with its number and profile as written, if the text has it.
    pub fn version_directive<'t>(&self, text: &'t str) -> Option<&'t str> {
        let is_version = |t: &RawToken| t.directive.is_some() && &text[t.start..t.end] == "version";
        let name = self.tokens.iter().position(is_version)?;
        let directive = self.tokens[name].directive;
        let last = self.tokens[name..].iter().take_while(|t| t.directive == directive).last()?;
        Some(&text[self.tokens[name.checked_sub(1)?].start..last.end])
    }

    /// Returns the global declarations in order.
    // The parser reads the text as it stands, with macros that look like names; so this is for
    // edits and not for layouts.
    pub fn declarations<'a>(&self, text: &'a str) -> Vec<RawDeclaration<'a>> {
        let code = self.code();
        let places = code.iter().map(|&at| &self.tokens[at]);
        let places = places.map(|token| (token.kind, token.start, token.end));
        let mut parser = Parser::over(lexed(text, places));
        let mut all = Vec::new();
        loop {
            let start = parser.position();
            let Some(item) = parser.item() else { return all };
            all.push(RawDeclaration { tokens: code[start..parser.position()].to_vec(), item });
        }
    }
}

/// Returns tokens for the parser, from their kinds and ranges in a text.
pub fn lexed<'a>(
    text: &'a str,
    places: impl Iterator<Item = (Kind, usize, usize)>,
) -> Vec<Token<'a>> {
    let mut before = 0;
    let token = |(kind, start, end): (Kind, usize, usize)| {
        let gap = &text[before..start];
        before = end;
        Token {
            kind,
            text: &text[start..end],
            span: Span { file: 0, start: start as u32, end: end as u32 },
            definition: None,
            comments: 0,
            first: gap.contains('\n') || gap.len() == start,
            spaced: !gap.is_empty(),
            frozen: true,
        }
    };
    places.map(token).collect()
}

/// Reads the tokens of a shader's own file.
// The lexer gives every token, the preprocessor those that a compiler reads. A token is active if
// the preprocessor returned it, or a token of the same run, or executed it as a directive.
pub fn read(source: &Source, options: &ReadOptions) -> RawText {
    let texts = Texts::new();
    let mut preprocessor =
        Preprocessor::new(&source.path, &source.text, source.stage, &texts, options);
    let mut seen = FxHashSet::default();
    loop {
        let token = preprocessor.next();
        if token.kind == Kind::End {
            break;
        }
        if token.span.file == 0 {
            seen.insert(token.span.start);
        }
    }
    seen.extend(preprocessor.obeyed.iter().filter(|span| span.file == 0).map(|span| span.start));
    let mut tokens = lex(&source.text, &texts);
    mark_active(&mut tokens, &seen);
    RawText {
        tokens,
        version: preprocessor.version.number,
        es: preprocessor.version.es,
        target: preprocessor.target(),
        files: preprocessor.files,
    }
}

/// Returns a shader's text with includes inlined and macros expanded, for compilers that open no
/// files; comments and line numbers are lost.
pub fn flattened(source: &Source, options: &ReadOptions) -> String {
    let texts = Texts::new();
    let mut preprocessor =
        Preprocessor::new(&source.path, &source.text, source.stage, &texts, options);
    let mut body = String::with_capacity(source.text.len());
    let mut before = Span::default();
    loop {
        let token = preprocessor.next();
        if token.kind == Kind::End {
            break;
        }
        // The two halves of `+=` are separate tokens.
        let joined = token.definition.is_none()
            && (before.file, before.end) == (token.span.file, token.span.start);
        if !joined {
            body.push(if token.first { '\n' } else { ' ' });
        }
        body.push_str(token.text);
        before = token.span;
    }
    let mut text = String::with_capacity(body.len() + 256);
    // Of the directives only `#version` and the extensions are still of use; an extension for
    // includes would promise what the text no longer has.
    for span in &preprocessor.obeyed {
        let Some(file) = preprocessor.files.get(span.file) else { continue };
        let line = logical_line(&file.text[span.start as usize..]);
        let name = line.trim_start_matches('#').trim_start();
        let kept = name.starts_with("version") && span.file == 0
            || name.starts_with("extension") && !name.contains("include");
        if kept {
            text.push_str(&line);
            text.push('\n');
        }
    }
    text.push_str(&body);
    text.push('\n');
    text
}

/// Returns the first line of a text, joined with its continuations.
fn logical_line(text: &str) -> Cow<'_, str> {
    let mut end = 0;
    loop {
        let rest = &text[end..];
        let line = rest.split(['\n', '\r']).next().unwrap_or_default();
        end += line.len();
        if !line.ends_with('\\') || end == text.len() {
            break;
        }
        end += if text[end..].starts_with("\r\n") { 2 } else { 1 };
    }
    let line = &text[..end];
    splice::splice(line).map_or(Cow::Borrowed(line), |(clean, _)| Cow::Owned(clean))
}

// Each directive is a run of its own, by its number; the text between two directives has none.
fn lex<'a>(text: &'a str, texts: &'a Texts) -> Vec<RawToken> {
    let mut lexer = Lexer::of_file(text, 0, texts);
    let mut comments = Vec::new();
    let mut tokens: Vec<RawToken> = Vec::new();
    let mut directives = 0;
    loop {
        let mut token = lexer.next(&mut comments);
        if token.kind == Kind::End {
            return tokens;
        }
        let directive = (token.first && token.is("#")).then_some(directives);
        directives += usize::from(directive.is_some());
        loop {
            let (start, end) = (token.span.start as usize, token.span.end as usize);
            tokens.push(RawToken { kind: token.kind, start, end, active: false, directive });
            match directive.and_then(|_| lexer.next_on_line(&mut comments)) {
                Some(next) => token = next,
                None => break,
            }
        }
    }
}

/// Text between two directives is read as a whole or not at all, so one token that was seen stands
/// for all, including macro arguments that were dropped.
fn mark_active(tokens: &mut [RawToken], seen: &FxHashSet<u32>) {
    let mut start = 0;
    while start < tokens.len() {
        let group = tokens[start].directive;
        let length = tokens[start..].iter().take_while(|t| t.directive == group).count();
        let run = &mut tokens[start..start + length];
        let active = run.iter().any(|token| seen.contains(&(token.start as u32)));
        run.iter_mut().for_each(|token| token.active = active);
        start += length;
    }
}
