//! Which module of a folder imports which, and the circles among them.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::tree::{Path, Unit, Use};

/// Arrows between names, each with a place in the text.
pub type Graph = BTreeMap<String, BTreeMap<String, String>>;

/// Stands for what a crate's root file defines itself.
pub const ROOT: &str = "lib";

/// The imports between the modules directly below a module; a folder counts as one with all
/// that it holds.
pub fn below(uses: &[Use], folder: &[String]) -> Graph {
    let mut graph = Graph::new();
    for used in uses {
        let (Some(from), Some(to)) = (part(&used.from, folder), part(&used.to, folder)) else {
            continue;
        };
        // What the root imports of its modules is how the crate shows them.
        let is_root = folder.is_empty() && to == ROOT;
        if from != to && from != ROOT && (to != ROOT || is_root) {
            let arrows = graph.entry(from.to_string()).or_default();
            arrows.entry(to.to_string()).or_insert(used.place.clone());
        }
    }
    graph
}

/// The module directly below a folder that a module is or is in.
fn part<'p>(path: &'p [String], folder: &[String]) -> Option<&'p str> {
    let rest = path.strip_prefix(folder)?;
    Some(rest.first().map_or(ROOT, String::as_str))
}

/// The modules that have modules below them, the root first.
pub fn folders(unit: &Unit) -> BTreeSet<Path> {
    let parents = unit.modules.keys().filter_map(|path| path.split_last());
    parents.map(|(_, folder)| folder.to_vec()).collect()
}

/// The names of each circle, those in no circle left out.
pub fn circles(graph: &Graph) -> Vec<BTreeSet<String>> {
    let reached: BTreeMap<&String, BTreeSet<String>> =
        graph.keys().map(|name| (name, reachable(graph, name))).collect();
    let mut found: Vec<BTreeSet<String>> = Vec::new();
    for (name, far) in &reached {
        let known = found.iter().any(|circle| circle.contains(*name));
        if known || !far.contains(*name) {
            continue;
        }
        let is_back = |other: &&String| reached.get(*other).is_some_and(|r| r.contains(*name));
        found.push(far.iter().filter(is_back).cloned().collect());
    }
    found
}

fn reachable(graph: &Graph, start: &String) -> BTreeSet<String> {
    let mut seen = BTreeSet::new();
    let mut queue = VecDeque::from([start]);
    while let Some(name) = queue.pop_front() {
        for next in graph.get(name).into_iter().flat_map(BTreeMap::keys) {
            if seen.insert(next.clone()) {
                queue.push_back(next);
            }
        }
    }
    seen
}
