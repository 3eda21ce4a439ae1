//! The lengths of files and functions.

use crate::token::{Token, matching, tokens};
use crate::tree::File;

/// Lines of a file at most.
pub const FILE: usize = 500;
/// Lines of a function at most, from its `fn` to its closing brace.
pub const FUNCTION: usize = 100;

/// The files and functions that are too long.
pub fn problems(files: &[File]) -> Vec<String> {
    let mut found = Vec::new();
    for file in files.iter().filter(|file| file.path.ends_with(".rs")) {
        let lines = file.text.lines().count();
        if lines > FILE {
            found.push(format!("{}: the file has {lines} lines; {FILE} at most", file.path));
        }
        for (name, line, lines) in functions(&tokens(&file.text)) {
            if lines > FUNCTION {
                let place = format!("{}:{line}", file.path);
                found.push(format!("{place}: `{name}` has {lines} lines; {FUNCTION} at most"));
            }
        }
    }
    found
}

/// Name, first line and number of lines of every function with a body.
fn functions<'t>(tokens: &[Token<'t>]) -> Vec<(&'t str, usize, usize)> {
    let mut found = Vec::new();
    for (at, pair) in tokens.windows(2).enumerate() {
        let name = pair[1].text;
        if pair[0].text != "fn" || !name.starts_with(|c: char| c == '_' || c.is_alphabetic()) {
            continue;
        }
        let mut next = at + 2;
        while let Some(token) = tokens.get(next) {
            match token.text {
                ";" => break,
                "{" => {
                    let last = tokens[matching(tokens, next)].line;
                    found.push((name, pair[0].line, last - pair[0].line + 1));
                    break;
                }
                "(" | "[" => next = matching(tokens, next) + 1,
                _ => next += 1,
            }
        }
    }
    found
}
