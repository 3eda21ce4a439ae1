//! The tokens and global declarations of a shader, from the syntax tree of its unexpanded text.

use std::rc::Rc;

use rustc_hash::FxHashSet;

pub(super) use landfall_layout::syntax::glsl::ast::Tokens;
use landfall_layout::syntax::glsl::ast::{Declaration, Item, Qualifiers, TypeBase};
use landfall_layout::syntax::glsl::lexer::Kind;
use landfall_layout::syntax::glsl::parser::Parser;
use landfall_layout::syntax::glsl::raw::{RawText, lexed};

/// A token outside directives and inactive branches.
#[derive(Clone, Copy, Debug)]
pub(super) struct OutlineToken<'a> {
    pub kind: Kind,
    pub text: &'a str,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// The active tokens outside directives.
pub(super) fn code<'a>(text: &'a str, raw: &RawText) -> Vec<OutlineToken<'a>> {
    let read = raw.tokens.iter().filter(|token| token.active && token.directive.is_none());
    read.map(|t| OutlineToken {
        kind: t.kind,
        text: &text[t.start..t.end],
        start: t.start,
        end: t.end,
    })
    .collect()
}

/// The global declarations in source order, with members and parameters parsed. `macros` are
/// names of macros that expand to qualifiers. Declarations that cannot be ported are
/// [`Item::Other`].
pub(super) fn declarations<'a>(
    text: &'a str,
    code: &[OutlineToken<'a>],
    macros: FxHashSet<&'a str>,
) -> Vec<Item<'a>> {
    let tokens = lexed(text, code.iter().map(|token| (token.kind, token.start, token.end)));
    let mut parser = Parser::over(tokens).with_qualifier_macros(macros);
    let mut items = Vec::new();
    // One item in each round; what has an error, or parts that cannot be read, is passed over
    // whole.
    loop {
        let start = parser.position();
        let Some(mut item) = parser.item() else { return items };
        let tokens = start..parser.position();
        if matches!(&item, Item::Other(_)) && tokens.len() == 1 && code[start].text == ";" {
            continue;
        }
        let parsed = parser.diagnostics().is_empty();
        parser.forget_diagnostics();
        if !parsed || !complete(&mut parser, code, &mut item) {
            item = Item::Other(tokens);
        }
        items.push(item);
    }
}

/// Parses the members or parameters of a declaration; returns whether it can be ported.
fn complete<'a>(parser: &mut Parser<'a>, code: &[OutlineToken<'a>], item: &mut Item<'a>) -> bool {
    match item {
        Item::Variables(declaration) => match &declaration.ty.base {
            TypeBase::Name(_) => !declaration.names.is_empty(),
            TypeBase::Struct(structure) => {
                let alone = || words(code, &declaration.qualifiers).is_empty();
                named_types(&structure.members) && (!declaration.names.is_empty() || alone())
            }
        },
        Item::Block(block) => named_types(&block.members),
        Item::Interface(block) => {
            parser.complete_interface(block).is_ok() && named_types(&block.members)
        }
        Item::Function(function) => {
            let Ok(parameters) = parser.parameters_of(function) else { return false };
            Rc::get_mut(function).expect("the parser shares no item").parameters = parameters;
            true
        }
        Item::Defaults(_) | Item::Precision(_) => true,
        Item::Requalified(..) | Item::Other(_) => false,
    }
}

/// Whether no member declares a structure.
fn named_types(members: &[Declaration<'_>]) -> bool {
    members.iter().all(|member| matches!(member.ty.base, TypeBase::Name(_)))
}

/// The one-word qualifiers.
pub(super) fn words<'a>(code: &[OutlineToken<'a>], qualifiers: &Qualifiers<'_>) -> Vec<&'a str> {
    // At depth 0, outside the parentheses of `layout(…)`.
    let mut depth = 0;
    let mut words = Vec::new();
    for token in &code[qualifiers.tokens.clone()] {
        match token.text {
            "(" => depth += 1,
            ")" => depth -= 1,
            "layout" => {}
            word if depth == 0 => words.push(word),
            _ => {}
        }
    }
    words
}

/// The tokens between the parentheses of each `layout(…)`.
pub(super) fn layouts(code: &[OutlineToken<'_>], qualifiers: &Qualifiers<'_>) -> Vec<Tokens> {
    let mut depth = 0;
    let mut layouts: Vec<Tokens> = Vec::new();
    for at in qualifiers.tokens.clone() {
        match code[at].text {
            "(" => {
                depth += 1;
                if depth == 1 {
                    layouts.push(at + 1..at + 1);
                }
            }
            ")" => {
                depth -= 1;
                if let (0, Some(layout)) = (depth, layouts.last_mut()) {
                    layout.end = at;
                }
            }
            _ => {}
        }
    }
    layouts
}
