//! Compares the source tree with `ARCHITECTURE.md`, and measures files and functions.
//!
//! Fails on an import that the document's arrows do not show, on an arrow without an import, on
//! a circle between the modules of a folder, on a file past 500 lines and on a function past 100.
//! Sizes are those of `crates/` and `src/`; `tests/` is exempt, as tables of cases are long and
//! read from above to below. Uses the standard library only: no crate of the workspace need
//! compile for it to run.

mod document;
mod graph;
mod imports;
mod paths;
mod planted;
mod public;
mod sizes;
mod strings;
mod systems;
mod token;
mod tree;

use std::fs;
use std::path::Path;

use tree::{File, Tree};

/// Everything wrong with a tree of files, one line each.
fn problems(files: Vec<File>) -> Vec<String> {
    let Some(text) = files.iter().find(|file| file.path == "ARCHITECTURE.md") else {
        return vec!["there is no ARCHITECTURE.md".to_string()];
    };
    let document = match document::read(&text.text) {
        Ok(document) => document,
        Err(error) => return vec![error],
    };
    let tree = Tree::new(&files);
    let mut found = document.lengths(&sizes::too_long(&files));
    found.extend(document.compare(&tree));
    found.extend(document.circles(&tree));
    found
}

/// The files that the checks read, by their paths from the root of the repository.
fn repository() -> Vec<File> {
    files(&[".rs", "Cargo.toml"])
}

/// ARCHITECTURE.md, Cargo.toml and the files of `crates/` and `src/` with these endings.
fn files(endings: &[&str]) -> Vec<File> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for path in ["ARCHITECTURE.md", "Cargo.toml"] {
        if let Ok(text) = fs::read_to_string(root.join(path)) {
            files.push(File { path: path.to_string(), text });
        }
    }
    for folder in ["crates", "src"] {
        collect(root, &root.join(folder), endings, &mut files);
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));
    files
}

fn collect(root: &Path, folder: &Path, endings: &[&str], files: &mut Vec<File>) {
    for entry in fs::read_dir(folder).expect("the folder exists") {
        let path = entry.expect("the folder can be read").path();
        let short = path.strip_prefix(root).expect("it is below the root");
        let short = short.to_str().expect("names are ASCII").replace('\\', "/");
        if path.is_dir() {
            collect(root, &path, endings, files);
        } else if endings.iter().any(|ending| short.ends_with(ending)) {
            let text = fs::read_to_string(&path).expect("the file can be read");
            files.push(File { path: short, text });
        }
    }
}

#[test]
fn the_tree_is_as_architecture_md_shows_it() {
    let files = repository();
    assert!(files.len() > 300, "only {} files were found", files.len());
    let found = problems(files);
    let list = found.join("\n");
    assert!(found.is_empty(), "{} problems:\n{list}", found.len());
}

#[test]
fn code_for_one_system_has_its_other_half() {
    let found = systems::problems(&repository());
    assert!(found.is_empty(), "{} problems:\n{}", found.len(), found.join("\n"));
}

#[test]
fn what_users_see_can_grow_and_names_no_other_crate_than_documented() {
    let found = public::problems(&repository());
    assert!(found.is_empty(), "{} problems:\n{}", found.len(), found.join("\n"));
}

/// Prints the blocks of `ARCHITECTURE.md` as they would be, those of folders included:
/// `cargo test --test house -- --ignored --nocapture`.
#[test]
#[ignore = "prints the blocks as they are"]
fn print_blocks() {
    print!("{}", document::blocks(&Tree::new(&repository())));
}

/// Prints every string that a user can see, each with its file and line:
/// `cargo test --test house strings -- --ignored --nocapture`.
#[test]
#[ignore = "prints the strings that users see"]
fn print_strings() {
    for string in strings::visible(&files(&[".rs", ".json"])) {
        println!("{string}");
    }
}
