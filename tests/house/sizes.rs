//! The lengths of files and functions.

use std::fmt;

use crate::token::{Token, matching, tokens};
use crate::tree::File;

/// Lines of a file at most.
pub const FILE: usize = 500;
/// Lines of a function at most, from its `fn` to its closing brace.
pub const FUNCTION: usize = 100;

/// A file or function that is too long.
#[derive(Clone, Debug, PartialEq)]
pub struct TooLong {
    pub path: String,
    /// The function's name; `file` for the whole file.
    pub name: String,
    pub line: usize,
    pub lines: usize,
    pub most: usize,
}

impl fmt::Display for TooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TooLong { path, name, line, lines, most } = self;
        write!(f, "{path}:{line}: `{name}` has {lines} lines; {most} at most")
    }
}

/// The files and functions that are too long.
pub fn too_long(files: &[File]) -> Vec<TooLong> {
    let mut found = Vec::new();
    for file in files.iter().filter(|file| file.path.ends_with(".rs")) {
        let path = &file.path;
        let mut keep = |name: &str, line: usize, lines: usize, most: usize| {
            if lines > most {
                found.push(TooLong {
                    path: path.clone(),
                    name: name.to_string(),
                    line,
                    lines,
                    most,
                });
            }
        };
        keep("file", 1, file.text.lines().count(), FILE);
        for (name, line, lines) in functions(&tokens(&file.text)) {
            keep(name, line, lines, FUNCTION);
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
