//! Lengths of block members declared without one, `float a[];`: the largest constant index that
//! the shader uses, plus one (GLSL 4.60 §4.1.9).
//!
//! Function bodies have to be read for that, so it is done only for texts with such a member.

use super::declarations::{DeclarationReader, Lengths, Unknown, Unsized};
use super::lexer::{Kind, Token};
use super::parser::Bodies;
use super::preprocess::Texts;
use crate::source::{ReadOptions, Source};

/// Returns a shader with the lengths of such members written into their declarations, which then
/// also take indices known only at run time; `None` if its own text has no such member.
pub fn sized(source: &Source, options: &ReadOptions) -> Option<Source> {
    let texts = Texts::new();
    let mut reader = super::reader(source, options, &texts, Bodies::Keep);
    reader.read(|_, _| ());
    let members = std::mem::take(&mut reader.unsized_members);
    let found = lengths(&mut reader, &members);
    let mut text = source.text.to_string();
    let mut written = false;
    for member in members.iter().rev().filter(|member| member.brackets.file == 0) {
        let place = member.brackets.start as usize..member.brackets.end as usize;
        let Some(Ok(length)) = found.get(member.name) else { continue };
        // The brackets may be those of a macro.
        if source.text.get(place.clone()).is_some_and(|text| text.starts_with('[')) {
            text.replace_range(place, &format!("[{length}]"));
            written = true;
        }
    }
    written.then(|| Source { text: text.into(), ..source.clone() })
}

/// Returns the lengths of members, from a reader that has kept the function bodies.
pub(super) fn lengths<'a>(
    reader: &mut DeclarationReader<'a>,
    members: &[Unsized<'a>],
) -> Lengths<'a> {
    let tokens = reader.parser.tokens().to_vec();
    let mut found = Lengths::default();
    for member in members {
        let length = length(reader, &tokens, member);
        found.insert(member.name, length);
    }
    found
}

fn length<'a>(
    reader: &mut DeclarationReader<'a>,
    tokens: &[Token<'a>],
    member: &Unsized<'a>,
) -> Result<u32, Unknown> {
    let mut largest = None;
    for (at, token) in tokens.iter().enumerate() {
        if token.kind != Kind::Name || token.text != member.name || token.span == member.span {
            continue;
        }
        let declared = at > 0 && is_type_end(&tokens[at - 1]);
        let index = tokens.get(at + 1).filter(|next| next.is("["));
        if declared || index.is_none() {
            return Err(Unknown::Ambiguous(token.span));
        }
        let end = closing(tokens, at + 1);
        let span = tokens.get(at + 2).map_or(token.span, |token| token.span);
        match reader.constant_integer(&(at + 2..end), span).ok().map(u32::try_from) {
            Some(Ok(index)) if index < u32::MAX => largest = largest.max(Some(index)),
            Some(_) | None => return Err(Unknown::NotConstant(span)),
        }
    }
    largest.map(|index| index + 1).ok_or(Unknown::Unused)
}

/// Whether a name after this token is declared by it: `float a`, `Light a`, `vec4[2] a`.
fn is_type_end(token: &Token<'_>) -> bool {
    let statement = ["return", "else", "do", "case"];
    token.is("]") || token.kind == Kind::Name && !statement.contains(&token.text)
}

/// The index of the bracket that closes the one at `open`.
fn closing(tokens: &[Token<'_>], open: usize) -> usize {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match token.text {
            "[" => depth += 1,
            "]" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    tokens.len()
}
