//! The names that a declaration uses and that may be those of other declarations.

use super::super::lexer::{Kind, Lexer, Token};
use super::super::outline::{Class, Item, Outline};
use super::super::uses;
use super::take_path_separator;
use crate::source::Span;

/// Returns the names and paths that a declaration uses, with their ranges: those that no local name
/// hides.
pub(super) fn references(
    text: &str,
    outline: &Outline<'_>,
    item: &Item<'_>,
) -> Vec<(u32, u32, Vec<String>)> {
    let mut found = Vec::new();
    let inside = |span: &&Span| span.start >= item.start && span.end <= item.end;
    let body = outline.bodies.iter().find(inside).filter(|_| item.class == Class::Fn);
    let head_end = body.map_or(item.end, |body| body.start);
    let mut lexer = Lexer::new(text, item.start);
    let mut before = None;
    loop {
        let token = lexer.next();
        if token.kind == Kind::End || token.start >= head_end {
            break;
        }
        if before == Some(b'@') {
            // Their arguments are words of the language.
            if matches!(lexer.text_of(token), "builtin" | "interpolate" | "diagnostic") {
                while !matches!(lexer.next().kind, Kind::Sign(b')') | Kind::End) {}
            }
        } else if token.kind == Kind::Word && before != Some(b'.') {
            let (end, path) = path(&mut lexer, token);
            // `name: type` declares a member or a parameter, in a variable's own declaration its type.
            let declares = path.len() == 1 && lexer.peek().is(b':');
            if !declares && token.start != item.name_span.start {
                found.push((token.start, end, path));
            }
        }
        before = match token.kind {
            Kind::Sign(sign) => Some(sign),
            Kind::Word | Kind::Number | Kind::End => None,
        };
    }
    if let Some(body) = body {
        let mut done = body.start;
        uses::walk(text, outline, item, &mut |_, word, token, lexer| {
            if token.start < done || word == uses::Word::Member {
                return;
            }
            let (end, path) = path(&mut lexer.clone(), token);
            done = end;
            if path.len() > 1 || word != uses::Word::Local {
                found.push((token.start, end, path));
            }
        });
    }
    found
}

/// Reads the rest of a path whose first name was read; returns its end and names.
fn path(lexer: &mut Lexer<'_>, first: Token) -> (u32, Vec<String>) {
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
