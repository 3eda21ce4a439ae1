//! Code for one operating system has its other half: an item under `#[cfg(unix)]` and the like has
//! one of the same name under a `not(…)`, so that the crates compile, and do something that was
//! decided on, wherever Rust does.
//!
//! Works on lines, in the form that rustfmt gives them: an attribute has a line of its own.

use std::collections::BTreeMap;

use crate::tree::File;

/// Predicates of `cfg` that name systems.
const SYSTEMS: [&str; 5] = ["unix", "windows", "target_os", "target_family", "target_vendor"];

/// Modules of the standard library that only some systems have.
const MODULES: [&str; 4] =
    ["std::os::unix", "std::os::windows", "std::os::linux", "std::os::macos"];

/// Items that have nothing to do elsewhere: file, name, reason.
const ONE_SIDED: [(&str, &str, &str); 2] = [
    ("src/bin/landfall/stdout.rs", "check_stdout", "elsewhere, a closed stdout is not told apart"),
    ("src/bin/landfall/stdout.rs", "CHECK", "what runs it before `main`"),
];

/// Every item for some systems that other systems lack, a line each.
pub fn problems(files: &[File]) -> Vec<String> {
    files.iter().filter(|file| file.path.ends_with(".rs")).flat_map(of_file).collect()
}

fn of_file(file: &File) -> Vec<String> {
    let lines: Vec<&str> = file.text.lines().collect();
    let mut found = Vec::new();
    // By name: the line of the first, and whether one is for all other systems.
    let mut items: BTreeMap<&str, (usize, bool)> = BTreeMap::new();
    for (at, line) in lines.iter().enumerate().filter(|(_, line)| names_system(line)) {
        let item = lines[at + 1..].iter().map(|line| line.trim_start());
        let item = item.clone().find(|line| !line.starts_with("#[") && !line.starts_with("//"));
        match item.and_then(name) {
            Some(name) => {
                let entry = items.entry(name).or_insert((at + 1, false));
                entry.1 |= line.contains("not(");
            }
            None => found.push(format!(
                "{}:{}: a condition on part of a function; move it into a function with its other half",
                file.path,
                at + 1
            )),
        }
    }
    for (name, (line, has_rest)) in items {
        let is_known =
            ONE_SIDED.iter().any(|(path, known, _)| *path == file.path && *known == name);
        if !has_rest && !is_known {
            found.push(format!("{}:{line}: `{name}` is missing on other systems", file.path));
        }
    }
    let uses = lines.iter().enumerate().filter(|(_, line)| {
        !line.trim_start().starts_with("//") && MODULES.iter().any(|module| line.contains(module))
    });
    found.extend(uses.filter(|(at, _)| !is_conditional(&lines, *at)).map(|(at, _)| {
        format!("{}:{}: a module of one system, without a condition", file.path, at + 1)
    }));
    found
}

fn names_system(line: &str) -> bool {
    let Some(condition) = line.trim_start().strip_prefix("#[cfg(") else { return false };
    let mut words = condition.split(|c: char| c != '_' && !c.is_ascii_alphanumeric());
    words.any(|word| SYSTEMS.contains(&word))
}

/// The name of an item that begins on a line.
fn name(line: &str) -> Option<&str> {
    const KINDS: [&str; 6] = ["fn", "static", "const", "struct", "enum", "mod"];
    let mut words = line.split(|c: char| c != '_' && !c.is_ascii_alphanumeric());
    words.find(|word| KINDS.contains(word))?;
    words.find(|word| !word.is_empty())
}

/// Whether the item at the margin that a line belongs to has a condition on the system.
fn is_conditional(lines: &[&str], at: usize) -> bool {
    let is_start = |line: &&str| line.starts_with(|c: char| c.is_ascii_alphabetic());
    let Some(start) = lines[..=at].iter().rposition(is_start) else { return false };
    let above = lines[..start].iter().rev();
    above
        .take_while(|line| line.starts_with('#') || line.starts_with("//"))
        .any(|l| names_system(l))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        problems(&[File { path: "crates/a/src/lib.rs".to_string(), text: text.to_string() }])
    }

    #[test]
    fn an_item_needs_its_other_half() {
        let one = "/// A.\n#[cfg(unix)]\npub fn node() { std::os::unix::a() }\n";
        assert_eq!(found(one), ["crates/a/src/lib.rs:2: `node` is missing on other systems"]);
        let both = format!("{one}#[cfg(not(unix))]\npub fn node() {{}}\n");
        assert_eq!(found(&both), [""; 0]);
        let three = format!(
            "{one}#[cfg(windows)]\npub fn node() {{}}\n#[cfg(not(any(unix, windows)))]\npub fn node() {{}}\n"
        );
        assert_eq!(found(&three), [""; 0]);
        assert_eq!(found("#[cfg(target_os = \"linux\")]\nconst N: u8 = 1;\n").len(), 1);
        assert_eq!(found("#[cfg(feature = \"unix\")]\nfn a() {}\n").len(), 1, "errs on this side");
    }

    #[test]
    fn a_statement_and_a_bare_module_are_reported() {
        let statement = "fn f() {\n    #[cfg(unix)]\n    options.mode(0o600);\n}\n";
        assert!(found(statement)[0].contains(":2: a condition on part of a function"));
        let bare = "fn f() {\n    use std::os::unix::fs::MetadataExt;\n}\n";
        assert!(found(bare)[0].contains(":2: a module of one system"));
        assert_eq!(found("// std::os::unix\n#[cfg(test)]\nfn f() {}\n"), [""; 0]);
    }
}
