//! Reads `ARCHITECTURE.md` and compares it with the tree.
//!
//! A fenced block whose first line is `arrows NAME` holds a line `a -> b, c` for each part that
//! imports others. `NAME` is `crates` for the crates, a crate's name for the modules at its top,
//! or a module's path (`landfall-exec/harness`) for those below it. `*` stands for every module
//! of the block that has no line of its own, on either side. A block `recursive` lists the files that may import
//! each other in circles, as the rules of a grammar do: a folder, a colon, and its files; one
//! with files of its own below it is written with a `/`. A block
//! `long` lists what may be longer than the rest: a file, a colon, and its functions, or `file`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::graph::{Graph, below, circles, folders};
use crate::sizes::TooLong;
use crate::tree::{Path, Tree, Unit};

/// What the document shows.
#[derive(Debug, Default)]
pub struct Document {
    blocks: BTreeMap<String, BTreeMap<String, BTreeSet<String>>>,
    recursive: BTreeMap<String, BTreeSet<String>>,
    long: BTreeMap<String, BTreeSet<String>>,
}

/// Reads the document's blocks.
pub fn read(text: &str) -> Result<Document, String> {
    let mut document = Document::default();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some(title) = line.strip_prefix("```") else { continue };
        let body = lines.by_ref().take_while(|line| !line.starts_with("```"));
        let body: Vec<&str> = body.map(str::trim).filter(|line| !line.is_empty()).collect();
        if let Some(name) = title.trim().strip_prefix("arrows ") {
            let rows = body.iter().map(|line| row(line, "->")).collect::<Result<_, _>>()?;
            document.blocks.insert(name.to_string(), rows);
        } else if title.trim() == "recursive" {
            document.recursive =
                body.iter().map(|line| row(line, ":")).collect::<Result<_, _>>()?;
        } else if title.trim() == "long" {
            document.long = body.iter().map(|line| row(line, ":")).collect::<Result<_, _>>()?;
        }
    }
    Ok(document)
}

fn row(line: &str, mark: &str) -> Result<(String, BTreeSet<String>), String> {
    let (from, to) = line
        .split_once(mark)
        .ok_or_else(|| format!("ARCHITECTURE.md: `{line}` has no `{mark}`"))?;
    Ok((from.trim().to_string(), to.split(',').map(|name| name.trim().to_string()).collect()))
}

impl Document {
    /// What is too long and not listed, and what is listed and not too long.
    pub fn lengths(&self, sizes: &[TooLong]) -> Vec<String> {
        let listed = |size: &&TooLong| {
            self.long.get(&size.path).is_some_and(|names| names.contains(&size.name))
        };
        let mut found: Vec<String> =
            sizes.iter().filter(|size| !listed(size)).map(TooLong::to_string).collect();
        for (path, names) in &self.long {
            for name in names {
                if !sizes.iter().any(|size| size.path == *path && size.name == *name) {
                    found.push(format!("{path}: `{name}` is listed as long, and is not"));
                }
            }
        }
        found
    }

    /// The differences between the arrows shown and the imports.
    pub fn compare(&self, tree: &Tree) -> Vec<String> {
        let mut found = self.compare_crates(tree);
        for (name, unit) in &tree.units {
            if !self.blocks.contains_key(name) {
                found.push(format!("ARCHITECTURE.md has no block `arrows {name}`"));
            }
            let uses = unit.uses();
            for (block, rows) in &self.blocks {
                if let Some(folder) = folder_of(block, name) {
                    let names = unit.modules.keys().filter(|path| path.starts_with(&folder));
                    let names = names.filter_map(|path| path.get(folder.len()));
                    let names: BTreeSet<&str> = names.map(String::as_str).collect();
                    found.extend(differences(block, rows, &below(&uses, &folder), &names));
                }
            }
        }
        for block in self.blocks.keys().filter(|block| *block != "crates") {
            if !tree.units.keys().any(|unit| folder_of(block, unit).is_some()) {
                found.push(format!("ARCHITECTURE.md: `arrows {block}` is of no crate"));
            }
        }
        found
    }

    /// The crates' arrows, held against the paths in their code and against their manifests.
    fn compare_crates(&self, tree: &Tree) -> Vec<String> {
        let Some(rows) = self.blocks.get("crates") else {
            return vec!["ARCHITECTURE.md has no block `arrows crates`".to_string()];
        };
        let graph = crate_graph(tree);
        let names = tree.units.keys().map(String::as_str).collect();
        let mut found = differences("crates", rows, &graph, &names);
        for (package, dependencies) in &tree.manifests {
            // The facade and the command are one package.
            let units = match package.as_str() {
                "landfall" => vec!["landfall", "command"],
                package => vec![package],
            };
            let shown = units.iter().filter_map(|unit| rows.get(*unit)).flatten();
            let shown: BTreeSet<&String> = shown.filter(|name| *name != package).collect();
            for name in dependencies.iter().filter(|name| !shown.contains(name)) {
                found.push(format!(
                    "{package}: Cargo.toml depends on `{name}`, which ARCHITECTURE.md does not show"
                ));
            }
            for name in shown.iter().filter(|name| !dependencies.contains(**name)) {
                found.push(format!("{package}: `-> {name}` is shown, but Cargo.toml has it not"));
            }
        }
        found.extend(self.undeclared("crates", &graph));
        found
    }

    /// Cyclic imports between the modules of each folder.
    pub fn circles(&self, tree: &Tree) -> Vec<String> {
        let mut found = Vec::new();
        let mut seen = BTreeSet::new();
        for (name, unit) in &tree.units {
            let uses = unit.uses();
            for folder in folders(unit) {
                let graph = below(&uses, &folder);
                let place = place(name, &folder);
                let known = in_circles(unit, &folder, &graph);
                for file in self.recursive.get(&place).into_iter().flatten() {
                    if !known.contains(file) {
                        found.push(format!(
                            "{place}: `{file}` is shown as recursive, but no such file is in a circle"
                        ));
                    }
                }
                found.extend(self.undeclared(&place, &graph));
                seen.insert(place);
            }
        }
        for place in self.recursive.keys().filter(|place| !seen.contains(*place)) {
            found.push(format!("ARCHITECTURE.md: `{place}` is no folder"));
        }
        found
    }

    /// The circles that the document does not allow.
    fn undeclared(&self, place: &str, graph: &Graph) -> Vec<String> {
        let allowed = self.recursive.get(place);
        let mut found = Vec::new();
        for circle in circles(graph) {
            let is_allowed = |part: &String| {
                allowed.is_some_and(|all| all.contains(part) || all.contains(&format!("{part}/")))
            };
            if circle.iter().all(is_allowed) {
                continue;
            }
            let mut message = format!("{place}: a circle of imports");
            for (from, to, at) in arrows_of(graph) {
                if circle.contains(from) && circle.contains(to) {
                    write!(message, "\n    {from} -> {to} at {at}").expect("a string grows");
                }
            }
            found.push(message);
        }
        found
    }
}

fn place(unit: &str, folder: &[String]) -> String {
    [&[unit.to_string()], folder].concat().join("/")
}

/// The modules of a folder that are in circles; one that has modules below it ends in `/`.
fn in_circles(unit: &Unit, folder: &[String], graph: &Graph) -> Vec<String> {
    let spelled = |part: String| {
        let path = [folder, std::slice::from_ref(&part)].concat();
        let is_below = |other: &Path| other.len() > path.len() && other.starts_with(&path);
        if unit.modules.keys().any(is_below) { part + "/" } else { part }
    };
    circles(graph).into_iter().flatten().map(spelled).collect()
}

fn arrows_of(graph: &Graph) -> impl Iterator<Item = (&String, &String, &String)> {
    graph.iter().flat_map(|(from, all)| all.iter().map(move |(to, at)| (from, to, at)))
}

/// The imports between the crates.
fn crate_graph(tree: &Tree) -> Graph {
    let mut graph = Graph::new();
    for (name, unit) in &tree.units {
        let others = unit.crates().into_iter().filter(|(other, _)| other != name);
        graph.insert(name.clone(), others.collect());
    }
    graph
}

/// The folder of a crate that a block shows.
fn folder_of(block: &str, unit: &str) -> Option<Path> {
    let rest = block.strip_prefix(unit)?;
    match rest.strip_prefix('/') {
        Some(path) => Some(path.split('/').map(str::to_string).collect()),
        None => rest.is_empty().then(Vec::new),
    }
}

/// What differs between the rows of a block and a graph.
fn differences(
    block: &str,
    rows: &BTreeMap<String, BTreeSet<String>>,
    graph: &Graph,
    names: &BTreeSet<&str>,
) -> Vec<String> {
    let mut found = Vec::new();
    let is_in = |row: &BTreeSet<String>, to: &String| {
        row.contains(to) || !rows.contains_key(to) && row.contains("*")
    };
    let shown = |from: &String, to: &String| {
        rows.get(from).or_else(|| rows.get("*")).is_some_and(|row| is_in(row, to))
    };
    for (from, to, at) in arrows_of(graph) {
        if !shown(from, to) {
            found.push(format!("{block}: `{from} -> {to}` is not shown; {at} imports it"));
        }
    }
    for (from, row) in rows {
        let is_of = |name: &String| {
            if from == "*" { !rows.contains_key(name) } else { name == from }
        };
        if from != "*" && !names.contains(from.as_str()) {
            found.push(format!("{block}: `{from}` is shown, and is no module"));
        }
        for to in row {
            let is_to = |other: &String| {
                if to == "*" { !rows.contains_key(other) } else { other == to }
            };
            if !arrows_of(graph).any(|(own, other, _)| is_of(own) && is_to(other)) {
                found.push(format!("{block}: `{from} -> {to}` is shown, but nothing imports it"));
            }
        }
    }
    found
}

/// The blocks as they would be for a tree.
pub fn blocks(tree: &Tree) -> String {
    let mut text = String::new();
    let mut block = |name: &str, graph: &Graph| {
        writeln!(text, "```arrows {name}").expect("a string grows");
        for (from, to) in graph.iter().filter(|(_, to)| !to.is_empty()) {
            let to: Vec<&str> = to.keys().map(String::as_str).collect();
            writeln!(text, "{from} -> {}", to.join(", ")).expect("a string grows");
        }
        writeln!(text, "```\n").expect("a string grows");
    };
    block("crates", &crate_graph(tree));
    let mut recursive = String::new();
    for (name, unit) in &tree.units {
        let uses = unit.uses();
        for folder in folders(unit) {
            let graph = below(&uses, &folder);
            let place = place(name, &folder);
            let circles = in_circles(unit, &folder, &graph);
            if !circles.is_empty() {
                writeln!(recursive, "{place}: {}", circles.join(", ")).expect("a string grows");
            }
            if folder.len() < 2 {
                block(&place, &graph);
            }
        }
    }
    format!("{text}```recursive\n{recursive}```\n")
}
