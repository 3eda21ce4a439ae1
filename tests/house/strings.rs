//! Lists the strings that a user can see: literals of messages, the help of the command and the
//! descriptions of JSON schemas.
//!
//! A literal counts if it holds at least two words and is not shader, Rust or C text. Left out
//! are items under `#[cfg(test)]`, the examples of lints, and the reasons of `expect()` and
//! `unreachable!`, which only a defect of Landfall shows.

use std::collections::BTreeSet;
use std::fmt;

use crate::token::{test_items, token_end, tokens};
use crate::tree::{File, Tree};

/// A text with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Visible {
    pub path: String,
    pub line: usize,
    pub text: String,
}

impl fmt::Display for Visible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.path, self.line, self.text)
    }
}

/// The strings of all files, in the order of the files.
pub fn visible(files: &[File]) -> Vec<Visible> {
    let tree = Tree::new(files);
    let modules = tree.units.values().flat_map(|unit| unit.modules.values());
    let modules: BTreeSet<&str> = modules.map(|module| module.file.as_str()).collect();
    let mut found = Vec::new();
    for file in files {
        let mut own = if file.path.ends_with(".json") {
            descriptions(&file.text)
        } else if modules.contains(file.path.as_str()) {
            let mut own = literals(&file.text);
            if file.path.starts_with("src/bin/landfall/args") {
                own.extend(help(&file.text));
            }
            own
        } else {
            continue;
        };
        own.sort();
        let path = &file.path;
        found.extend(own.into_iter().map(|(line, text)| Visible {
            path: path.clone(),
            line,
            text,
        }));
    }
    found
}

/// The string literals of a file that are messages, each with its line.
fn literals(text: &str) -> Vec<(usize, String)> {
    let tokens = tokens(text);
    let under_test: Vec<_> = test_items(&tokens)
        .into_iter()
        .map(|item| tokens[item.start].line..=tokens[item.end - 1].line)
        .collect();
    let mut found = Vec::new();
    let (mut at, mut line) = (0, 1);
    while at < text.len() {
        let end = token_end(text, at);
        let literal = &text[at..end];
        if literal.ends_with(['"', '#']) && literal.contains('"') && !literal.starts_with('/') {
            let body = unescaped(literal);
            let is_tested = under_test.iter().any(|lines| lines.contains(&line));
            if !is_tested && is_prose(&body) && !is_internal(text[..at].trim_end()) {
                found.push((line, body));
            }
        }
        line += text[at..end].matches('\n').count();
        at = end;
    }
    found
}

/// Whether a literal after this code is a lint's example or a reason for a panic.
fn is_internal(code: &str) -> bool {
    ["example:", "expect(", "unreachable!(", "panic!(", "assert!(", "reason ="]
        .iter()
        .any(|end| code.ends_with(end))
}

/// What a literal stands for: its quotes and line continuations removed, its line ends as `\n`.
fn unescaped(literal: &str) -> String {
    let start = literal.find('"').map_or(0, |quote| quote + 1);
    let end = literal.rfind('"').unwrap_or(literal.len());
    let body = literal.get(start..end).unwrap_or_default();
    let mut lines = body.split("\\\n");
    let mut joined = lines.next().unwrap_or_default().to_string();
    for line in lines {
        joined += line.trim_start();
    }
    joined.replace('\n', "\\n").replace("\\\"", "\"")
}

/// Whether a text holds at least two words, and is not code of a shader or a mirror.
fn is_prose(text: &str) -> bool {
    let words = text.split(' ').filter(|part| part.contains(|c: char| c.is_ascii_alphabetic()));
    let lines = || text.split("\\n").map(str::trim).filter(|line| !line.is_empty());
    let is_code = |line: &&str| line.ends_with([';', '{', '}']) && !line.ends_with("`{}`");
    let code = lines().filter(|line| is_code(line) && !line.contains(": {")).count();
    let placeholders = text.starts_with('{') && text.ends_with('}') && !text.contains("} ");
    words.count() > 1 && 2 * code <= lines().count() && !placeholders
}

/// The doc comments that clap prints as help, each with its first line.
fn help(text: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut open: Option<(usize, String)> = None;
    for (index, line) in text.lines().map(str::trim).enumerate() {
        if let Some(doc) = line.strip_prefix("///") {
            let (_, body) = open.get_or_insert((index + 1, String::new()));
            *body = format!("{body} {}", doc.trim()).trim_start().to_string();
        } else if !line.starts_with("#[") {
            let item =
                line.strip_prefix("pub").map_or(line, |rest| rest.trim_start_matches("(super)"));
            let is_other = ["fn ", "const ", "static ", "type ", "impl", "trait "]
                .iter()
                .any(|keyword| item.trim_start().starts_with(keyword));
            found.extend(open.take().filter(|_| !is_other));
        }
    }
    found
}

/// The descriptions and titles of a JSON schema, each with its line.
fn descriptions(text: &str) -> Vec<(usize, String)> {
    let described = text.lines().enumerate().filter_map(|(index, line)| {
        let (_, rest) =
            line.split_once("\"description\":").or_else(|| line.split_once("\"title\":"))?;
        let rest = rest.trim().strip_prefix('"')?;
        let (end, _) = rest.match_indices('"').find(|&(at, _)| !rest[..at].ends_with('\\'))?;
        Some((index + 1, rest[..end].replace("\\\"", "\"")))
    });
    described.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, text: &str) -> File {
        File { path: path.to_string(), text: text.to_string() }
    }

    #[test]
    fn messages_are_listed_and_code_tests_and_reasons_are_not() {
        let text = r##"//! A comment with "three quoted words".
fn a(n: u32) -> String {
    let one = "word";
    let mirror = "pub struct Lights {\n    pub count: u32,\n}\n";
    let message = format!("`{n}` is \"too\" \
                           large");
    let raw = r#"two "words" here"#;
    let shown = one.strip_prefix('"').expect("it begins with a quote");
}
#[cfg(test)]
mod tests {
    const TEXT: &str = "seen by tests only";
}
const LAST: &str = "after the tests";
"##;
        let found = visible(&[file("src/a.rs", text)]);
        let found: Vec<String> = found.iter().map(Visible::to_string).collect();
        assert_eq!(
            found,
            [
                "src/a.rs:5: `{n}` is \"too\" large",
                "src/a.rs:7: two \"words\" here",
                "src/a.rs:14: after the tests",
            ]
        );
    }

    #[test]
    fn doc_comments_of_arguments_are_help_and_those_of_functions_are_not() {
        let text = "/// Of a function.\nfn a() {}\n/// How many\n/// to print\n#[arg(long)]\n\
                    pub limit: u32,\n";
        let found = visible(&[file("src/bin/landfall/args/a.rs", text)]);
        let found: Vec<String> = found.iter().map(Visible::to_string).collect();
        assert_eq!(found, ["src/bin/landfall/args/a.rs:3: How many to print"]);
        assert_eq!(visible(&[file("src/bin/landfall/a.rs", text)]), []);
    }

    #[test]
    fn descriptions_of_schemas_are_listed() {
        let text = "{\n  \"type\": \"object\",\n  \"description\": \"Says \\\"why\\\".\", \"a\": \"b\"\n}\n";
        let found = visible(&[file("src/report/schema/a.json", text)]);
        let found: Vec<String> = found.iter().map(Visible::to_string).collect();
        assert_eq!(found, ["src/report/schema/a.json:3: Says \"why\"."]);
    }
}
