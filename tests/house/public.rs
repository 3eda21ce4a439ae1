//! What users of the façade see: the public items of `landfall-layout`, `landfall-codegen` and
//! `landfall-port` that `src/lib.rs` re-exports, and what stands in their signatures.
//!
//! Reads text, not types: a name in a signature is of another crate if the file imports it from
//! there. Macros are not expanded.

use std::collections::{BTreeMap, BTreeSet};

use crate::imports::imports;
use crate::token::{Token, matching, tokens, without_tests};
use crate::tree::{File, Path};

/// The crates that the façade re-exports, by the name in code, and their folders.
const SHOWN: [(&str, &str); 3] = [
    ("landfall_layout", "crates/landfall-layout/"),
    ("landfall_codegen", "crates/landfall-codegen/"),
    ("landfall_port", "crates/landfall-port/"),
];

/// Enums that users see and that get no further variant without a new major version, and why.
const CLOSED: &[(&str, &str)] = &[
    ("Access", "read, written, or both, in steps or at once"),
    ("Answer", "a query is about a member or a byte"),
    ("ArrayLen", "a length is a number, open, or given by a constant: all code of layouts decides"),
    ("ByteOwner", "a byte is in a component, in padding or in neither"),
    ("Class", "an upload reads as before, still fits, or is misread"),
    ("Direction", "a variable enters or leaves a stage"),
    ("Language", "a front end, rules and spelling of its own: all code decides"),
    ("MatrixLayout", "by columns or by rows"),
    ("Paint", "with colours or without"),
    ("Rules", "all code of layouts and every generator decides for each"),
    ("Sampled", "a texel is a float, an integer of either sign, or a depth"),
    ("ScalarKind", "all code of layouts and every generator decides for each"),
    ("Segment", "a path has names and indices"),
    ("Severity", "there is a layout or there is none"),
    ("Type", "all code of layouts decides for each type"),
    ("Width", "beside each other or below each other"),
];

/// An item at the outer level of a file.
struct Item<'t> {
    attributes: &'t [Token<'t>],
    public: bool,
    /// The keyword: `enum`, `fn`, `impl`.
    kind: &'t str,
    name: &'t str,
    /// From the keyword to the end, body included.
    all: &'t [Token<'t>],
}

impl Item<'_> {
    fn has(&self, attribute: &str) -> bool {
        self.attributes.iter().any(|token| token.text == attribute)
    }

    /// The parts that users read: neither bodies of functions nor private fields.
    fn signature(&self) -> Vec<&[Token<'_>]> {
        let before = |texts: &[&str]| {
            self.all.split(|token| texts.contains(&token.text)).next().unwrap_or_default()
        };
        match self.kind {
            "fn" => vec![before(&["{", ";"])],
            "const" | "static" => vec![before(&["="])],
            "struct" | "impl" => {
                let head = before(&["{", "("]);
                let public = |at: &usize| is(self.all, *at, "pub") && !is(self.all, at + 1, "(");
                let part = |at: usize| {
                    let ends = |token: &Token<'_>| matches!(token.text, "," | ";" | "{");
                    self.all[at..].split(ends).next().unwrap_or_default()
                };
                let mut parts: Vec<_> =
                    (head.len()..self.all.len()).filter(public).map(part).collect();
                // The head of an `impl` may be of a private trait or type.
                parts.extend((self.kind == "struct").then_some(head));
                parts
            }
            _ => vec![self.all],
        }
    }
}

fn is(tokens: &[Token<'_>], at: usize, text: &str) -> bool {
    tokens.get(at).is_some_and(|token| token.text == text)
}

/// The items of a file, those of modules written in it left out.
fn items<'t>(tokens: &'t [Token<'t>]) -> Vec<Item<'t>> {
    const KINDS: [&str; 10] =
        ["mod", "use", "fn", "struct", "enum", "trait", "type", "const", "static", "impl"];
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let start = at;
        while is(tokens, at, "#") {
            at = matching(tokens, at + 1 + usize::from(is(tokens, at + 1, "!"))) + 1;
        }
        let attributes = &tokens[start..at];
        let public = is(tokens, at, "pub") && !is(tokens, at + 1, "(");
        let end_of = |mut at: usize| loop {
            match tokens.get(at).map(|token| token.text) {
                None | Some(";") => return at + 1,
                Some("{") => return matching(tokens, at) + 1,
                Some("(" | "[") => at = matching(tokens, at) + 1,
                Some(_) => at += 1,
            }
        };
        // `use a::{b};` and `struct A(B);` go on behind their brackets.
        let mut end = end_of(at);
        let keyword = (at..end.min(tokens.len())).find(|&at| KINDS.contains(&tokens[at].text));
        if let Some(keyword) = keyword {
            let kind = tokens[keyword].text;
            if matches!(kind, "use" | "const" | "static") {
                while end < tokens.len() && !is(tokens, end - 1, ";") {
                    end = end_of(end);
                }
            }
            let is_const_fn = kind == "const" && is(tokens, keyword + 1, "fn");
            let keyword = keyword + usize::from(is_const_fn);
            let end = if is_const_fn { end_of(at) } else { end }.min(tokens.len());
            found.push(Item {
                attributes,
                public,
                kind: tokens[keyword].text,
                name: tokens.get(keyword + 1).map_or("", |token| token.text),
                all: &tokens[keyword..end],
            });
            at = end;
        } else {
            at = end.max(at + 1);
        }
    }
    found
}

/// What is wrong with what users see, one line each.
pub fn problems(files: &[File]) -> Vec<String> {
    problems_beside(files, CLOSED)
}

fn problems_beside(files: &[File], closed: &[(&str, &str)]) -> Vec<String> {
    let mut open: BTreeSet<&str> = closed.iter().map(|(name, _)| *name).collect();
    let mut found: Vec<String> =
        SHOWN.iter().flat_map(|shown| problems_in(*shown, files, &mut open)).collect();
    found.extend(
        open.into_iter().map(|name| format!("`{name}` is listed as closed, and is not seen")),
    );
    found
}

/// What is wrong in one crate; the closed enums that it shows leave `open`.
fn problems_in(
    (name, folder): (&str, &str),
    files: &[File],
    open: &mut BTreeSet<&str>,
) -> Vec<String> {
    let text = |path: &str| files.iter().find(|f| f.path == path).map_or("", |f| f.text.as_str());
    let facade = text("src/lib.rs");
    let named = documented(facade);
    let others = dependencies(text(&format!("{folder}Cargo.toml")));
    let mut sources: BTreeMap<Path, (&str, Vec<Token<'_>>)> = BTreeMap::new();
    for file in files {
        let inside = file.path.strip_prefix(folder).and_then(|path| path.strip_prefix("src/"));
        let Some(inside) = inside.and_then(|path| path.strip_suffix(".rs")) else { continue };
        let path = if inside == "lib" { "" } else { inside };
        let path = path.split('/').filter(|part| !part.is_empty()).map(str::to_string).collect();
        sources.insert(path, (&file.path, without_tests(&tokens(&file.text)).0));
    }
    let modules: BTreeMap<&Path, Vec<Item<'_>>> =
        sources.iter().map(|(path, (_, tokens))| (path, items(tokens))).collect();
    let mut seen = BTreeSet::new();
    for import in imports(&tokens(facade)) {
        if import.path[0] == name {
            reach(&import.path[1..], &modules, &mut seen);
        }
    }
    let types: BTreeSet<&str> = seen.iter().filter_map(|(_, name)| name.as_deref()).collect();
    let mut found = Vec::new();
    for (path, items) in &modules {
        let (file, tokens) = &sources[*path];
        let foreign = foreign(tokens, &others);
        for item in items {
            let own = seen.contains(&((*path).clone(), Some(item.name.to_string())));
            let of_type = item.kind == "impl"
                && item.all.iter().take_while(|t| t.text != "{").any(|t| types.contains(t.text))
                && !item.all.iter().take_while(|t| t.text != "{").any(|t| t.text == "for");
            if !own && !of_type || item.kind != "impl" && !item.public {
                continue;
            }
            let line = item.all[0].line;
            if item.kind == "enum" && !item.has("non_exhaustive") && !open.remove(item.name) {
                let name = item.name;
                found.push(format!("{file}:{line}: `{name}` is neither non-exhaustive nor closed"));
            }
            if item.kind == "struct"
                && item.name.ends_with("Options")
                && !item.has("non_exhaustive")
            {
                found.push(format!("{file}:{line}: the options `{}` may not grow", item.name));
            }
            let derived = item.attributes.iter();
            let signature = item.signature().into_iter().flatten();
            for token in signature.chain(derived) {
                let Some(name) = foreign.get(token.text) else { continue };
                if !named.contains(name) {
                    let line = token.line;
                    found.push(format!("{file}:{line}: `{name}` is not named in src/lib.rs"));
                }
            }
        }
    }
    found
}

/// Adds what a path inside the crate leads to: an item, or all that a module shows.
fn reach(
    path: &[String],
    modules: &BTreeMap<&Path, Vec<Item<'_>>>,
    seen: &mut BTreeSet<(Path, Option<String>)>,
) {
    let whole = path.to_vec();
    if let Some(items) = modules.get(&whole).filter(|_| !is_hidden(path, modules)) {
        if !seen.insert((whole.clone(), None)) {
            return;
        }
        for item in items.iter().filter(|item| item.public && !item.has("hidden")) {
            if item.kind == "use" {
                reach_uses(item, &whole, modules, seen);
            } else {
                reach(&[&whole[..], &[item.name.to_string()]].concat(), modules, seen);
            }
        }
    }
    let Some((name, inside)) = path.split_last() else { return };
    let inside = inside.to_vec();
    for item in modules.get(&inside).into_iter().flatten() {
        if item.kind == "use" {
            let of_name = imports(item.all).into_iter().any(|import| import.name == *name);
            if of_name
                && item.public
                && !item.has("hidden")
                && !modules.contains_key(&path.to_vec())
            {
                reach_uses(item, &inside, modules, seen);
            }
        } else if item.name == name && item.kind != "impl" && !item.has("hidden") {
            seen.insert((inside.clone(), Some(name.clone())));
        }
    }
}

/// Whether a module is declared as hidden.
fn is_hidden(path: &[String], modules: &BTreeMap<&Path, Vec<Item<'_>>>) -> bool {
    path.split_last().is_some_and(|(name, inside)| {
        let mut declared = modules.get(&inside.to_vec()).into_iter().flatten();
        declared.any(|item| item.kind == "mod" && item.name == name && item.has("hidden"))
    })
}

fn reach_uses(
    item: &Item<'_>,
    module: &[String],
    modules: &BTreeMap<&Path, Vec<Item<'_>>>,
    seen: &mut BTreeSet<(Path, Option<String>)>,
) {
    for import in imports(item.all) {
        let rest = &import.path[1..];
        let target = match import.path[0].as_str() {
            "crate" => rest.to_vec(),
            "super" => [&module[..module.len().saturating_sub(1)], rest].concat(),
            "self" => [module, rest].concat(),
            _ => [module, &import.path[..]].concat(),
        };
        reach(&target, modules, seen);
    }
}

/// The names that a file imports from other crates, and those crates themselves.
fn foreign(tokens: &[Token<'_>], others: &BTreeSet<String>) -> BTreeMap<String, String> {
    let all = imports(tokens).into_iter().filter(|import| others.contains(&import.path[0]));
    all.map(|import| {
        let last = import.path.last().cloned().unwrap_or_default();
        (import.name, format!("{}::{last}", import.path[0]))
    })
    .collect()
}

/// The dependencies of a manifest, as code names them.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let section = manifest.split("\n[").find_map(|section| section.strip_prefix("dependencies]"));
    let lines = section.unwrap_or_default().lines();
    let names = lines.filter_map(|line| line.split(['.', ' ', '=']).next());
    names
        .filter(|name| !name.is_empty() && *name != "#")
        .map(|name| name.replace('-', "_"))
        .filter(|name| SHOWN.iter().all(|(shown, _)| shown != name))
        .collect()
}

/// The types of other crates that the documentation of the façade names: `serde_json::Value`.
fn documented(facade: &str) -> BTreeSet<String> {
    let section = facade.split("# Types of other crates").nth(1).unwrap_or_default();
    let section = section.lines().skip(1).take_while(|line| line.starts_with("//!"));
    let text: Vec<&str> = section.collect();
    let text = text.join("\n");
    text.split('`')
        .skip(1)
        .step_by(2)
        .filter(|code| code.contains("::"))
        .map(str::to_string)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIB: &str = "mod a;\n#[doc(hidden)]\npub mod b;\npub use a::{Kind, Thing};\npub mod c;\n";

    fn found(facade: &str, a: &str, closed: &[(&str, &str)]) -> Vec<String> {
        let file = |path: &str, text: &str| File { path: path.to_string(), text: text.to_string() };
        let manifest = "[package]\nname = \"x\"\n\n[dependencies]\nserde_json = \"1\"\nglam.workspace = true\n";
        problems_beside(
            &[
                file("src/lib.rs", facade),
                file("crates/landfall-layout/Cargo.toml", manifest),
                file("crates/landfall-layout/src/lib.rs", LIB),
                file("crates/landfall-layout/src/a.rs", a),
                file("crates/landfall-layout/src/b.rs", "pub enum Hidden { A }"),
                file("crates/landfall-layout/src/c.rs", "pub use super::b::Hidden;\npub struct E;"),
            ],
            closed,
        )
    }

    const FACADE: &str = "//! # Types of other crates\n//!\n//! `serde_json::Value`, no other.\n\
                          pub use landfall_layout::{Kind, Thing};\n";

    #[test]
    fn an_enum_that_users_see_is_open_or_listed() {
        let open = "#[non_exhaustive]\npub enum Kind { A }\npub enum Private { B }";
        assert_eq!(found(FACADE, open, &[]), Vec::<String>::new());
        let shut = "pub enum Kind { A }";
        let path = "crates/landfall-layout/src/a.rs:1: `Kind` is neither";
        assert!(found(FACADE, shut, &[])[0].starts_with(path));
        assert_eq!(found(FACADE, shut, &[("Kind", "it is")]), Vec::<String>::new());
        assert_eq!(found(FACADE, open, &[("Kind", "it is")]).len(), 1);
        // Through a module that is seen, though it is written in one that is not.
        let facade = FACADE.replace("{Kind, Thing}", "c");
        assert!(found(&facade, open, &[])[0].contains("`Hidden` is neither"));
    }

    #[test]
    fn options_that_users_see_can_grow() {
        let facade = FACADE.replace("Kind", "ThingOptions").replace(", Thing", "");
        let facade = facade.replace("landfall_layout::", "landfall_layout::a::");
        let text = "pub struct ThingOptions { pub a: u8 }";
        assert!(found(&facade, text, &[])[0].contains("`ThingOptions` may not grow"));
        let text = format!("#[non_exhaustive] {text}");
        assert_eq!(found(&facade, &text, &[]), Vec::<String>::new());
    }

    #[test]
    fn a_type_of_another_crate_in_a_signature_is_named_in_the_documentation() {
        let fault = "crates/landfall-layout/src/a.rs:2: `glam::Vec3` is not named in src/lib.rs";
        for (text, reported) in [
            ("pub struct Thing {\npub a: Vec3 }", true),
            ("pub struct Thing {\na: Vec3, pub b: Value }", false),
            ("pub struct Thing; impl Thing { \npub fn a(x: Vec3) { } }", true),
            ("pub struct Thing; impl Thing { \npub const fn a() -> Vec3 { } }", true),
            ("pub struct Thing; impl Thing { \npub(crate) fn a(x: Vec3) { } }", false),
            ("pub struct Thing; impl Thing { \npub fn a(x: Value) { Vec3::new() } }", false),
            ("pub struct Other {\npub a: Vec3 }", false),
        ] {
            let text = format!("use glam::Vec3; use serde_json::Value; {text}");
            let expected = if reported { vec![fault.to_string()] } else { Vec::new() };
            assert_eq!(found(FACADE, &text, &[]), expected, "{text}");
        }
    }
}
