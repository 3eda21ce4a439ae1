//! Expressions that are not evaluated here: naga is handed the constants and
//! types they depend on, and asked.

use rustc_hash::FxHashSet;

use super::lexer::{Kind, Lexer};
use super::outline::{Class, Outline};
use crate::naga_front;
use crate::source::Span;

const ANSWER: &str = "landfall_answer";

/// The value of an expression, if it is constant and above zero.
pub(super) fn positive(outline: &Outline<'_>, text: &str, at: Span) -> Option<u32> {
    let mut asked = String::new();
    if outline.f16 {
        asked.push_str("enable f16;\n");
    }
    let mut taken = FxHashSet::default();
    let mut open = vec![(at.start, at.end)];
    while let Some((start, end)) = open.pop() {
        let mut lexer = Lexer::new(text, start);
        loop {
            let token = lexer.next();
            if token.kind == Kind::End || token.end > end {
                break;
            }
            if token.kind != Kind::Word {
                continue;
            }
            let Some(&index) = outline.names.get(lexer.text_of(token)) else { continue };
            let item = &outline.items[index];
            match item.class {
                Class::Const | Class::Alias | Class::Struct => {}
                // A member may be named like a function; where it is meant, naga will miss it.
                Class::Override | Class::Var | Class::Fn => continue,
            }
            if taken.insert(index) {
                asked.push_str(&text[item.start as usize..item.end as usize]);
                asked.push('\n');
                open.push((item.rest, item.end));
            }
        }
    }
    let expression = &text[at.start as usize..at.end as usize];
    asked.push_str(&format!("alias {ANSWER} = array<u32, ({expression})>;\n"));
    naga_front::array_length(&asked, ANSWER)
}
