//! The checks themselves: small trees with one fault each, and the fault is reported.

use crate::problems;
use crate::tree::File;

const DOCUMENT: &str = "\
```arrows crates
landfall-high -> landfall-low
```
```arrows landfall-high
```
```arrows landfall-low
a -> b
c -> b
```
";

const LOW: &str = "crates/landfall-low/src";

/// A tree without a fault.
fn sound() -> Vec<(String, String)> {
    let low = |name: &str| format!("{LOW}/{name}.rs");
    [
        ("ARCHITECTURE.md".to_string(), DOCUMENT),
        ("crates/landfall-low/Cargo.toml".to_string(), "[dependencies]\nmemchr = \"2\"\n"),
        (low("lib"), "mod a;\nmod b;\nmod c;\npub use b::B;\n"),
        (low("a"), "use super::B;\nmod inner;\n"),
        (low("a/inner"), "fn f() { crate::b::g(); }\n"),
        (low("b"), "pub struct B;\n// crate::a\nconst T: &str = \"crate::c\";\n"),
        (low("c"), "use crate::{B as C};\n"),
        (
            "crates/landfall-high/Cargo.toml".to_string(),
            "[dependencies]\nlandfall-low.workspace = true\n\n[dev-dependencies]\nlandfall-x = 1\n",
        ),
        ("crates/landfall-high/src/lib.rs".to_string(), "use landfall_low::B;\n"),
    ]
    .map(|(path, text)| (path, text.to_string()))
    .to_vec()
}

/// What is reported of the sound tree with one file replaced or added.
fn with(path: &str, text: &str) -> Vec<String> {
    let mut files = sound();
    files.retain(|(own, _)| own != path);
    files.push((path.to_string(), text.to_string()));
    problems(files.into_iter().map(|(path, text)| File { path, text }).collect())
}

/// The sound tree with a change of the document.
fn with_document(from: &str, to: &str) -> Vec<String> {
    assert!(DOCUMENT.contains(from), "{from}");
    with("ARCHITECTURE.md", &DOCUMENT.replace(from, to))
}

fn assert_one(found: &[String], part: &str) {
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].contains(part), "{} lacks {part}", found[0]);
}

#[test]
fn a_tree_as_it_is_shown_has_no_problems() {
    assert_eq!(with("README.md", ""), Vec::<String>::new());
}

#[test]
fn an_import_that_is_not_shown_is_reported_with_its_line() {
    let found = with(&format!("{LOW}/c.rs"), "use crate::{B as C};\n\nuse crate::a::inner;\n");
    assert_one(&found, &format!("`c -> a` is not shown; {LOW}/c.rs:3"));
}

#[test]
fn an_upward_import_between_crates_is_reported() {
    let found = with(&format!("{LOW}/b.rs"), "pub struct B;\nuse landfall_high::X;\n");
    let expected = "`landfall-low -> landfall-high` is not shown";
    assert!(found.iter().any(|line| line.contains(expected)), "{found:#?}");
    assert!(found.iter().any(|line| line.contains("crates: a circle")), "{found:#?}");
}

#[test]
fn a_dependency_of_a_manifest_that_is_not_shown_is_reported() {
    let path = "crates/landfall-low/Cargo.toml";
    let found = with(path, "[dependencies]\nlandfall-high = { path = \"../landfall-high\" }\n");
    assert_one(&found, "Cargo.toml depends on `landfall-high`");
}

#[test]
fn an_arrow_without_an_import_is_reported() {
    let found = with_document("c -> b", "c -> a, b");
    assert_one(&found, "`c -> a` is shown, but nothing imports it");
    let found = with(&format!("{LOW}/c.rs"), "");
    assert_one(&found, "`c -> b` is shown, but nothing imports it");
}

#[test]
fn a_name_that_is_no_module_is_reported() {
    let found = with_document("c -> b", "c -> b\nd -> b");
    assert!(found.iter().any(|line| line.contains("`d` is shown, and is no module")), "{found:#?}");
}

#[test]
fn a_star_stands_for_the_modules_without_a_row() {
    assert_eq!(with_document("a -> b\nc -> b", "* -> b"), Vec::<String>::new());
    let found = with_document("c -> b", "* -> c");
    assert!(found.iter().any(|line| line.contains("`c -> b` is not shown")), "{found:#?}");
    assert!(found.iter().any(|line| line.contains("`* -> c` is shown, but")), "{found:#?}");
}

#[test]
fn a_star_behind_an_arrow_stands_for_the_modules_without_a_row() {
    assert_eq!(with_document("c -> b", "c -> *"), Vec::<String>::new());
    // `a` has a row, so the star does not cover it; nothing else is imported.
    let mut files = sound();
    files.retain(|(path, _)| *path != format!("{LOW}/c.rs") && path != "ARCHITECTURE.md");
    files.push((format!("{LOW}/c.rs"), "use crate::a::inner;\n".to_string()));
    files.push(("ARCHITECTURE.md".to_string(), DOCUMENT.replace("c -> b", "c -> *")));
    let found = problems(files.into_iter().map(|(path, text)| File { path, text }).collect());
    assert!(found.iter().any(|line| line.contains("`c -> a` is not shown")), "{found:#?}");
    assert!(found.iter().any(|line| line.contains("`c -> *` is shown, but")), "{found:#?}");
}

#[test]
fn a_circle_is_reported_even_where_its_arrows_are_shown() {
    let mut files = sound();
    files.retain(|(path, _)| !path.ends_with("low/src/b.rs") && path != "ARCHITECTURE.md");
    files.push((format!("{LOW}/b.rs"), "pub struct B;\nuse super::a::A;\n".to_string()));
    let shown = DOCUMENT.replace("a -> b", "a -> b\nb -> a");
    files.push(("ARCHITECTURE.md".to_string(), shown));
    let files = files.into_iter().map(|(path, text)| File { path, text }).collect();
    assert_one(&problems(files), "landfall-low: a circle of imports\n    a -> b");
}

#[test]
fn a_circle_below_a_folder_is_reported_unless_it_is_shown_as_recursive() {
    let mut files = sound();
    for (name, text) in [("a/x", "use super::y::Y;"), ("a/y", "use crate::a::x;")] {
        files.push((format!("{LOW}/{name}.rs"), text.to_string()));
    }
    let all = |files: &[(String, String)]| {
        let file =
            |(path, text): &(String, String)| File { path: path.clone(), text: text.clone() };
        problems(files.iter().map(file).collect())
    };
    assert_one(&all(&files), "landfall-low/a: a circle of imports\n    x -> y");
    files[0].1.push_str("```recursive\nlandfall-low/a: x, y\n```\n");
    assert_eq!(all(&files), Vec::<String>::new());
    // A module with files below it has to be written as one.
    files.push((format!("{LOW}/a/x/z.rs"), String::new()));
    assert_one(&all(&files), "`x` is shown as recursive, but no such file is in a circle");
    files[0].1 = files[0].1.replace(": x,", ": x/,");
    assert_eq!(all(&files), Vec::<String>::new());
}

#[test]
fn a_circle_that_is_gone_may_not_be_shown() {
    let found =
        with_document("```arrows crates", "```recursive\nlandfall-low: a\n```\n```arrows crates");
    assert_one(&found, "`a` is shown as recursive, but no such file is in a circle");
}

#[test]
fn imports_of_tests_do_not_count() {
    let text = "pub struct B;\n#[cfg(test)]\nmod tests { use crate::a::A; }\n";
    assert_eq!(with(&format!("{LOW}/b.rs"), text), Vec::<String>::new());
}

#[test]
fn a_file_past_500_lines_is_reported() {
    let path = format!("{LOW}/b/long.rs");
    assert_eq!(with(&path, &"\n".repeat(500)), Vec::<String>::new());
    assert_one(&with(&path, &"\n".repeat(501)), "`file` has 501 lines");
}

#[test]
fn a_function_past_100_lines_is_reported() {
    let path = format!("{LOW}/b/long.rs");
    let function = |lines: usize| format!("fn f()\n{{ // }}\n{}}}\n", "x;\n".repeat(lines - 3));
    assert_eq!(with(&path, &function(100)), Vec::<String>::new());
    assert_one(&with(&path, &function(101)), &format!("{path}:1: `f` has 101 lines"));
}

#[test]
fn what_is_listed_as_long_must_be_long() {
    let long = "```long\ncrates/landfall-low/src/b.rs: file\n```\n```arrows crates";
    let found = with_document("```arrows crates", long);
    assert_one(&found, "`file` is listed as long, and is not");
}
