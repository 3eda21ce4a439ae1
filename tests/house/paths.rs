//! Paths and functions that ARCHITECTURE.md and CONTRIBUTING.md name are there.
//!
//! A path is a piece of code with a `/`, or one that ends like a file. In a row of a table whose
//! first cell is a Rust file, `name()` is a function or a method of that file.

use std::fs;
use std::path::Path;

const PAGES: [&str; 2] = ["ARCHITECTURE.md", "CONTRIBUTING.md"];

/// The pieces of code in a line, without their backticks.
fn code(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// Whether a piece of code names a file or a folder of this repository.
fn is_path(code: &str) -> bool {
    let named = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    let ends = [".rs", ".md", ".toml", ".json", ".frag", ".yaml"];
    let file = ends.iter().any(|end| code.len() > end.len() && code.ends_with(end));
    code.chars().all(named) && code != "/" && (code.contains('/') || file)
}

/// The problems of one page, each a line; `there` tells whether a path exists, `read` its text.
fn wrong(
    page: &str,
    text: &str,
    there: &dyn Fn(&str) -> bool,
    read: &dyn Fn(&str) -> Option<String>,
) -> Vec<String> {
    let mut found = Vec::new();
    let mut fenced = false;
    for (number, line) in (1..).zip(text.lines()) {
        if line.starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            // A name without a folder lies beside the path before it.
            let mut folder = "";
            for path in code(line).filter(|code| is_path(code)) {
                let beside = match folder {
                    "" => String::new(),
                    folder => format!("{folder}/{path}"),
                };
                if there(path.trim_start_matches("./")) {
                    folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
                } else if beside.is_empty() || path.contains('/') || !there(&beside) {
                    found.push(format!("{page}:{number}: there is no `{path}`"));
                }
            }
            let file = line.starts_with("| `").then(|| code(line).next()).flatten();
            if let Some(file) = file.filter(|file| file.ends_with(".rs")) {
                let text = read(file).unwrap_or_default();
                for name in code(line).filter_map(|code| code.strip_suffix("()")) {
                    if !text.contains(&format!("fn {name}")) {
                        found.push(format!("{page}:{number}: {file} has no function `{name}`"));
                    }
                }
            }
        }
    }
    found
}

#[test]
fn every_path_and_function_that_a_page_names_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let there = |path: &str| root.join(path).exists();
    let read = |path: &str| fs::read_to_string(root.join(path)).ok();
    for page in PAGES {
        let text = read(page).unwrap_or_else(|| panic!("there is no {page}"));
        let paths = text.lines().flat_map(code).filter(|code| is_path(code)).count();
        assert!(paths >= 20, "{page}: {paths} paths");
        let found = wrong(page, &text, &there, &read);
        assert!(found.is_empty(), "{}", found.join("\n"));
    }
}

#[test]
fn a_path_or_function_that_is_gone_is_found() {
    let there = |path: &str| ["src/a.rs", "src/b.json"].contains(&path);
    let read = |path: &str| (path == "src/a.rs").then(|| "fn walk() {}".to_string());
    let check = |text: &str| wrong("page", text, &there, &read);
    assert!(check("see `src/a.rs`, `b.json` beside it, `a / b`, `/` and `name()`").is_empty());
    assert!(check("| `src/a.rs` | `walk()` |").is_empty());
    assert!(check("```\n`src/gone.rs`\n```").is_empty());
    assert_eq!(check("| `src/a.rs` | `run()` |").len(), 1);
    for gone in ["see `src/gone.rs`", "see `gone.rs`", "see `src/a.rs` and `c.json`"] {
        assert_eq!(check(gone).len(), 1, "{gone}");
    }
}
