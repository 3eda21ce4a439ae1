//! Blocks declared inside function bodies, where no compiler takes them. Bodies are skipped as
//! text, so they are read again where one looks as if it had a block.

use super::ast::Item;
use super::lexer::Kind;
use super::parser::Bodies;
use super::report::diagnostic_at;
use super::texts::Texts;
use crate::diagnostic::{Code, Diagnostic};
use crate::source::{ReadOptions, Source, Span};

/// Returns an error for each block inside a function of a shader with those bodies.
pub(super) fn blocks(source: &Source, options: &ReadOptions, bodies: &[Span]) -> Vec<Diagnostic> {
    // Nearly no body has these words, and only those that have are worth a second reading of the
    // text.
    let looks = |body: &Span| {
        let text = source.text.get(body.start as usize..body.end as usize);
        text.is_some_and(|text| has_block(text, "uniform") || has_block(text, "buffer"))
    };
    if !bodies.iter().any(looks) {
        return Vec::new();
    }
    let texts = Texts::new();
    let mut reader = super::reader(source, options, &texts, Bodies::Keep);
    let mut functions = Vec::new();
    reader.read(|_, item| {
        if let Item::Function(function) = item {
            functions.extend(function.body_tokens.clone());
        }
    });
    let tokens = reader.parser.tokens();
    let mut found = Vec::new();
    // Three tokens are enough: `uniform NAME {` is nothing else, whatever qualifiers stand around.
    for three in functions.iter().flat_map(|body| tokens[body.clone()].windows(3)) {
        let [storage, name, open] = three else { continue };
        let is_block = (storage.is("uniform") || storage.is("buffer"))
            && name.kind == Kind::Name
            && open.is("{");
        if is_block {
            let message = format!("block `{}` is declared inside a function", name.text);
            let error = diagnostic_at(name, Code::Syntax, message);
            let help = "declare it outside functions";
            found.push(error.with_note("GLSL 4.60 §4.3.9: blocks are global").with_help(help));
        }
    }
    found
}

/// Whether a text has `WORD NAME {`.
fn has_block(text: &str, word: &str) -> bool {
    let inside = |c: char| c.is_ascii_alphanumeric() || c == '_';
    memchr::memmem::find_iter(text.as_bytes(), word.as_bytes()).any(|at| {
        let rest = &text[at + word.len()..];
        let name = rest.trim_start();
        let after = name.trim_start_matches(inside);
        !text[..at].ends_with(inside)
            && name.len() < rest.len()
            && after.len() < name.len()
            && after.trim_start().starts_with('{')
    })
}
