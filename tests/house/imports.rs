//! Reads the paths that a file names: its `use` declarations and paths written out in code.

use crate::token::Token;

/// A path as it is written, one a leaf of a `use` tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// Its segments, from `crate`, `super`, a crate or a name in scope; `*` may be the last.
    pub path: Vec<String>,
    /// The name it has in the file.
    pub name: String,
    pub line: usize,
    /// Whether it is of a `use` declaration.
    pub declared: bool,
}

/// The paths of `use` declarations, and those in code that begin with `crate`, `super`, `self`
/// or a crate of the workspace.
pub fn imports(tokens: &[Token<'_>]) -> Vec<Import> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let token = tokens[at];
        if token.text == "use" {
            let start = at + 1 + usize::from(is(tokens, at + 1, "::"));
            at = tree(tokens, start, &[], true, &mut found);
            continue;
        }
        let before = at.checked_sub(1).map_or("", |before| tokens[before].text);
        let is_start = matches!(token.text, "crate" | "super" | "self")
            || token.text == "landfall"
            || token.text.starts_with("landfall_");
        if is_start && before != "::" && is(tokens, at + 1, "::") {
            at = tree(tokens, at, &[], false, &mut found);
        } else {
            at += 1;
        }
    }
    found
}

fn is(tokens: &[Token<'_>], at: usize, text: &str) -> bool {
    tokens.get(at).is_some_and(|token| token.text == text)
}

/// Reads a tree of paths below a prefix; returns the token after it.
fn tree(
    tokens: &[Token<'_>],
    start: usize,
    prefix: &[String],
    declared: bool,
    found: &mut Vec<Import>,
) -> usize {
    let mut path = prefix.to_vec();
    let mut at = start;
    let line = tokens.get(start).map_or(0, |token| token.line);
    loop {
        if is(tokens, at, "{") {
            at += 1;
            while at < tokens.len() && !is(tokens, at, "}") {
                at = if is(tokens, at, ",") {
                    at + 1
                } else {
                    tree(tokens, at, &path, declared, found).max(at + 1)
                };
            }
            return at + 1;
        }
        let Some(segment) = tokens.get(at).filter(|t| is_segment(t.text)) else { break };
        at += 1;
        if segment.text != "self" || path.is_empty() {
            path.push(segment.text.to_string());
        }
        if !is(tokens, at, "::") {
            break;
        }
        at += 1;
    }
    let mut name = path.last().cloned().unwrap_or_default();
    if declared && is(tokens, at, "as") {
        name = tokens.get(at + 1).map_or(name, |token| token.text.to_string());
        at += 2;
    }
    if path.len() > 1 || declared && !path.is_empty() {
        found.push(Import { path, name, line, declared });
    }
    at
}

fn is_segment(text: &str) -> bool {
    text == "*" || text.starts_with(|c: char| c == '_' || c.is_ascii_alphabetic())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::token::tokens;

    fn paths(text: &str) -> Vec<(String, String)> {
        let all = imports(&tokens(text));
        all.into_iter().map(|import| (import.path.join("::"), import.name)).collect()
    }

    fn pair(path: &str, name: &str) -> (String, String) {
        (path.to_string(), name.to_string())
    }

    #[test]
    fn every_leaf_of_a_use_tree_is_a_path() {
        let text = "use super::a::{self, B as C, d::{E, *}}; pub use landfall_ir::F;";
        let expected = [
            pair("super::a", "a"),
            pair("super::a::B", "C"),
            pair("super::a::d::E", "E"),
            pair("super::a::d::*", "*"),
            pair("landfall_ir::F", "F"),
        ];
        assert_eq!(paths(text), expected);
    }

    #[test]
    fn paths_in_code_are_read_and_other_paths_are_not() {
        let text = "fn f() { crate::a::b(); std::mem::swap(); x.y::<super::c::D>(); }";
        assert_eq!(paths(text), [pair("crate::a::b", "b"), pair("super::c::D", "D")]);
    }
}
