//! Division of a module by its entry points, where two of them use one binding for two resources.

use landfall_layout::interface::{EntryPoint, Interface};
use landfall_layout::source::{Language, Stage};

use super::ProgramShader;

/// The entry points of each program of a module, the one that names it first; empty if the whole module
/// can be one.
///
/// Each fragment entry point is a program with the vertex entry points that fit it and one another; each
/// compute entry point is one, and each vertex entry point that is in no other.
pub(super) fn parts<'a>(shader: &ProgramShader<'a>) -> Vec<Vec<&'a str>> {
    let Some(interface) = &shader.layout.interface else { return Vec::new() };
    // Only a module of WGSL has entry points that no pipeline uses together.
    let all = &shader.entries;
    let fits = |a: &EntryPoint, b: &EntryPoint| !conflict(interface, a, b);
    let is_one = all.iter().all(|a| all.iter().all(|b| std::ptr::eq(*a, *b) || fits(a, b)));
    if is_one || shader.layout.language != Language::Wgsl {
        return Vec::new();
    }
    let vertices = || all.iter().copied().filter(|entry| entry.stage == Some(Stage::Vertex));
    let mut parts: Vec<Vec<&EntryPoint>> = Vec::new();
    for entry in all.iter().copied().filter(|entry| entry.stage != Some(Stage::Vertex)) {
        let mut part = vec![entry];
        if entry.stage == Some(Stage::Fragment) {
            for vertex in vertices() {
                if part.iter().all(|other| fits(vertex, other)) {
                    part.push(vertex);
                }
            }
        }
        parts.push(part);
    }
    let is_in =
        |vertex: &EntryPoint| parts.iter().flatten().any(|entry| std::ptr::eq(*entry, vertex));
    let alone: Vec<_> = vertices().filter(|vertex| !is_in(vertex)).map(|one| vec![one]).collect();
    let names = |part: Vec<&'a EntryPoint>| part.iter().map(|entry| &*entry.name).collect();
    parts.into_iter().chain(alone).map(names).collect()
}

/// Whether two entry points use one binding for two resources.
fn conflict(interface: &Interface, a: &EntryPoint, b: &EntryPoint) -> bool {
    a.uses.iter().any(|one| {
        b.uses.iter().any(|other| {
            let (this, that) = (&interface.resources[*one], &interface.resources[*other]);
            let is_same = this.group == that.group && this.binding == that.binding;
            one != other && this.binding.is_some() && is_same
        })
    })
}
