//! The names that a declaration uses and that may be those of other declarations.

use rustc_hash::FxHashSet;

use super::super::lexer::{Kind, WgslLexer, WgslToken};
use super::super::outline::{Class, Outline, OutlineItem};
use super::super::uses;
use super::take_path_separator;

/// A name or path that no local name hides.
pub(super) struct Reference {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) path: Vec<String>,
}

#[derive(Default)]
pub(super) struct References<'a> {
    pub(super) all: Vec<Reference>,
    /// The names that a function declares, its parameters included.
    pub(super) locals: FxHashSet<&'a str>,
}

/// Returns the names and paths that a declaration uses.
// Heads and bodies are read apart: a head has types and attributes, whose words are told by the
// signs around them; in a body scopes decide, which `uses::walk` follows.
pub(super) fn references<'a>(
    text: &'a str,
    outline: &Outline<'a>,
    item: &OutlineItem<'a>,
) -> References<'a> {
    let mut found = References::default();
    // Bodies are in the order of the text.
    let body = outline.bodies.partition_point(|body| body.start < item.start);
    let body = outline.bodies.get(body).filter(|_| item.class == Class::Fn);
    let head_end = body.map_or(item.end, |body| body.start);
    let mut lexer = WgslLexer::new(text, item.start);
    let mut before = None;
    while let Some(token) = lexer.next_before(head_end) {
        if before == Some(b'@') {
            // Their arguments are words of the language.
            if matches!(lexer.text_of(token), "builtin" | "interpolate" | "diagnostic") {
                while !matches!(lexer.next().kind, Kind::Sign(b')') | Kind::End) {}
            }
        } else if token.kind == Kind::Word && before != Some(b'.') {
            let (to, path) = path(&mut lexer, token);
            // `name: type` declares a member or a parameter, in a variable's own declaration its type.
            let declares = path.len() == 1 && lexer.peek().is(b':');
            if declares {
                found.locals.insert(lexer.text_of(token));
            } else if token.start != item.name_span.start {
                found.all.push(Reference { from: token.start, to, path });
            }
        }
        before = token.sign();
    }
    let Some(body) = body else {
        found.locals.clear();
        return found;
    };
    let mut lexer = WgslLexer::new(text, body.start);
    while let Some(token) = lexer.next_before(body.end) {
        if matches!(lexer.text_of(token), "let" | "const" | "var") {
            found.locals.extend(uses::declared(&mut lexer));
        }
    }
    // `walk` passes every word, also those inside a path that was read with its first word.
    let mut done = body.start;
    uses::walk(text, outline, item, &mut |_, word, token, lexer| {
        if token.start < done || word == uses::Word::Member {
            return;
        }
        let (to, path) = path(&mut lexer.clone(), token);
        done = to;
        if path.len() > 1 || word != uses::Word::Local {
            found.all.push(Reference { from: token.start, to, path });
        }
    });
    found
}

/// Reads the rest of a path whose first name was read; returns its end and names.
fn path(lexer: &mut WgslLexer<'_>, first: WgslToken) -> (u32, Vec<String>) {
    let mut names = vec![lexer.text_of(first).to_string()];
    let mut end = first.end;
    loop {
        let mut ahead = lexer.clone();
        if !take_path_separator(&mut ahead) {
            return (end, names);
        }
        let name = ahead.next();
        if name.kind != Kind::Word {
            return (end, names);
        }
        names.push(ahead.text_of(name).to_string());
        end = name.end;
        *lexer = ahead;
    }
}
