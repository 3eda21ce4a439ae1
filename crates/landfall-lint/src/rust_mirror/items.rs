//! Splits Rust tokens into items, and limits their nesting so that parsing does not exhaust the
//! stack.
//!
//! Used by [`file`](super::file).

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The deepest nesting of groups in a parsed declaration, because parsing recurses on them.
const DEEPEST_GROUPS: usize = 32;

/// The most tokens between two separators of a parsed declaration, because prefixes and operators
/// recurse too.
const LONGEST_RUN: usize = 200;

/// Returns whether an item ends with that token.
pub(super) fn ends_item(item: &[TokenTree], token: &TokenTree) -> bool {
    match token {
        TokenTree::Punct(punct) => punct.as_char() == ';',
        TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
            // `use a::{b};` and `const X: T = { … };` go on to their semicolon.
            let word = keyword(item).map(|at| item[at].to_string());
            !matches!(word.as_deref(), Some("use" | "const" | "static" | "type"))
                || item.iter().any(|t| matches!(t, TokenTree::Ident(word) if word == "fn"))
        }
        TokenTree::Group(_) | TokenTree::Ident(_) | TokenTree::Literal(_) => false,
    }
}

/// Returns the position of an item's keyword, after attributes and visibility.
pub(super) fn keyword(item: &[TokenTree]) -> Option<usize> {
    let mut at = 0;
    loop {
        match item.get(at)? {
            // `#[…]` or `#![…]`.
            TokenTree::Punct(punct) if punct.as_char() == '#' => {
                at += 1;
                if matches!(item.get(at)?, TokenTree::Punct(p) if p.as_char() == '!') {
                    at += 1;
                }
                at += 1;
            }
            // `pub` or `pub(crate)`.
            TokenTree::Ident(word) if word == "pub" => {
                at += 1;
                if matches!(item.get(at)?, TokenTree::Group(g) if g.delimiter() == Delimiter::Parenthesis)
                {
                    at += 1;
                }
            }
            TokenTree::Ident(_) => return Some(at),
            TokenTree::Group(_) | TokenTree::Punct(_) | TokenTree::Literal(_) => return None,
        }
    }
}

/// Returns whether a recursive parser can parse the tokens without exhausting the stack.
pub(super) fn bounded(tokens: &[TokenTree]) -> bool {
    let mut waiting: Vec<(TokenStream, usize)> = vec![(tokens.iter().cloned().collect(), 0)];
    while let Some((tokens, depth)) = waiting.pop() {
        if depth > DEEPEST_GROUPS {
            return false;
        }
        let mut run = 0;
        for token in tokens {
            run += 1;
            match token {
                TokenTree::Group(group) => waiting.push((group.stream(), depth + 1)),
                // A separator, or the next attribute: a comment of documentation is one a line.
                TokenTree::Punct(punct) if matches!(punct.as_char(), ',' | ';' | '#') => run = 0,
                TokenTree::Punct(_) | TokenTree::Ident(_) | TokenTree::Literal(_) => {}
            }
            if run > LONGEST_RUN {
                return false;
            }
        }
    }
    true
}
