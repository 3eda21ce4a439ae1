//! Evaluation by naga of expressions not implemented here, together with the constants and types
//! they depend on.

use rustc_hash::FxHashSet;

use super::lexer::{Kind, WgslLexer};
use super::outline::{Class, Outline};
use crate::naga_front;
use crate::source::Span;

const ANSWER: &str = "landfall_answer";

/// Returns the value of an expression, if it is constant and positive.
// naga validates whole modules, so only what the expression needs is copied: a walk over the names
// in it, and in what they name. Errors elsewhere in the text then do not matter.
pub(super) fn positive(outline: &Outline<'_>, text: &str, at: Span) -> Option<u32> {
    let mut module = String::new();
    if outline.f16 {
        module.push_str("enable f16;\n");
    }
    let mut taken = FxHashSet::default();
    let mut open = vec![(at.start, at.end)];
    while let Some((start, end)) = open.pop() {
        let mut lexer = WgslLexer::new(text, start);
        while let Some(token) = lexer.next_before(end) {
            if token.kind != Kind::Word {
                continue;
            }
            let Some(&index) = outline.names.get(lexer.text_of(token)) else { continue };
            let item = &outline.items[index];
            match item.class {
                Class::Const | Class::Alias | Class::Struct => {}
                // A member may share a function's name; if the function is needed, naga fails.
                Class::Override | Class::Var | Class::Fn => continue,
            }
            if taken.insert(index) {
                module.push_str(&text[item.start as usize..item.end as usize]);
                module.push('\n');
                open.push((item.rest, item.end));
            }
        }
    }
    let expression = &text[at.start as usize..at.end as usize];
    module.push_str(&format!("alias {ANSWER} = array<u32, ({expression})>;\n"));
    naga_front::array_length(&module, ANSWER)
}
