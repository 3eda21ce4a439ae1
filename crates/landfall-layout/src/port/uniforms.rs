//! Uniforms: the loose ones are taken out of the text for one block, handles
//! and blocks stay where they are and get their bindings.

use crate::diagnostic::Code;
use std::collections::BTreeSet;

use super::edits::Edits;
use super::hoist::Handles;
use super::outline::{Block, Declaration, Declarator, Qualifiers, Variables};
use super::shader::{Shader, is_opaque};
use super::{Binding, InitialValue};
use crate::Diagnostic;

/// The loose uniforms of a shader.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathered {
    /// The members of the block, one line each, with their comments.
    pub members: String,
    /// Handles that were in structures: type, name and dimensions.
    pub handles: Vec<(String, String)>,
    /// Names that must be declared before they are used.
    pub names: Vec<String>,
    pub values: Vec<InitialValue>,
    /// The byte where the last of them ended.
    pub last: Option<usize>,
    /// A place all their types are declared before.
    pub after: usize,
}

/// Takes the loose uniforms out of the text.
pub(super) fn gather(
    shader: &Shader<'_>,
    handles: &Handles<'_, '_>,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) -> Gathered {
    let mut gathered = Gathered::default();
    for variables in shader.variables().filter(|v| shader.has_word(v, "uniform")) {
        let ty = type_of(shader, variables);
        if is_opaque(&ty) {
            if ty == "atomic_uint" {
                let message = "Vulkan has no atomic counters";
                problems.push(
                    Diagnostic::error(Code::NotPortable, shader.span(variables.ty), message)
                        .with_help("use a `uint` in a `buffer` block and `atomicAdd`"),
                );
            }
            continue;
        }
        unsized_arrays(shader, variables, problems);
        for declarator in &variables.declarators {
            let name = shader.code[declarator.name].text;
            gathered.names.push(name.to_string());
            for (own, path) in handles.of_global(name) {
                let outer = dims(shader, declarator, variables);
                let inner: String = path.dims.iter().map(|dim| format!("[{dim}]")).collect();
                gathered.names.push(own.to_string());
                gathered.handles.push((path.ty.to_string(), format!("{own}{outer}{inner}")));
            }
            if let Some(initialiser) = &declarator.initialiser {
                let text = shader.text_of(&(initialiser.start + 1..initialiser.end));
                gathered
                    .values
                    .push(InitialValue { name: name.to_string(), value: text.to_string() });
            }
        }
        take(shader, variables, &ty, handles.has_data(&ty), edits, &mut gathered);
    }
    gathered.after = types_end(shader, &gathered);
    gathered
}

fn type_of(shader: &Shader<'_>, variables: &Variables) -> String {
    match &variables.structure {
        None => shader.code[variables.ty].text.to_string(),
        Some(structure) => match structure.name {
            Some(name) => shader.code[name].text.to_string(),
            None => {
                let first = shader.code[variables.declarators[0].name].text;
                shader.unused(&format!("{first}_type"))
            }
        },
    }
}

fn dims(shader: &Shader<'_>, declarator: &Declarator, variables: &Variables) -> String {
    let all = declarator.dims.iter().chain(&variables.type_dims);
    all.map(|dim| format!("[{}]", shader.text_of(dim))).collect()
}

fn unsized_arrays(shader: &Shader<'_>, variables: &Variables, problems: &mut Vec<Diagnostic>) {
    for declarator in &variables.declarators {
        if declarator.dims.iter().chain(&variables.type_dims).any(|dim| dim.is_empty()) {
            let name = shader.code[declarator.name].text;
            let message = format!("the size of `{name}` is not written, and a block needs it");
            problems.push(
                Diagnostic::error(Code::NotPortable, shader.span(declarator.name), message)
                    .with_help("write the number of elements between the brackets"),
            );
        }
    }
}

/// Moves a declaration into the block, comments included; a structure it declares stays.
fn take(
    shader: &Shader<'_>,
    variables: &Variables,
    ty: &str,
    has_data: bool,
    edits: &mut Edits,
    gathered: &mut Gathered,
) {
    let taken = shader.lines_of(&variables.tokens);
    gathered.last = Some(shader.bytes(&variables.tokens).end);
    let precision = variables.qualifiers.words.iter().map(|&word| shader.code[word].text);
    let precision = precision.filter(|word| matches!(*word, "lowp" | "mediump" | "highp"));
    let precision: String = precision.map(|word| format!("{word} ")).collect();
    let all = shader.bytes(&variables.tokens);
    for initialiser in variables.declarators.iter().filter_map(|d| d.initialiser.as_ref()) {
        let name_end = shader.code[initialiser.start - 1].end;
        edits.delete(name_end..shader.bytes(initialiser).end);
    }
    let first = shader.code[variables.declarators[0].name].start;
    let type_end = match &variables.structure {
        Some(structure) => shader.bytes(&structure.body).end,
        None => shader.code[variables.ty].end,
    };
    let declared = edits.render(shader.text, type_end..all.end);
    if has_data {
        for line in taken.before.lines() {
            gathered.members.push_str(&format!("    {}\n", line.trim()));
        }
        let after =
            if taken.after.is_empty() { String::new() } else { format!(" {}", taken.after) };
        gathered.members.push_str(&format!("    {precision}{ty}{declared}{after}\n"));
    }
    match &variables.structure {
        None => edits.delete(taken.bytes),
        Some(structure) => {
            let body = shader.bytes(&structure.body);
            edits.delete(all.start..body.start);
            if structure.name.is_none() {
                edits.insert(body.start + "struct".len(), format!(" {ty}"));
            }
            edits.delete(body.end..first);
            edits.delete(first..all.end - 1);
        }
    }
}

/// The end of the last declaration the members' types and sizes come from.
fn types_end(shader: &Shader<'_>, gathered: &Gathered) -> usize {
    let uses = |name: &str| {
        words(&gathered.members).any(|word| word == name)
            || gathered.handles.iter().any(|(_, text)| words(text).any(|word| word == name))
    };
    let mut end = 0;
    for declaration in &shader.declarations {
        let (name, tokens) = match declaration {
            Declaration::Structure(structure) => (structure.name, &structure.tokens),
            Declaration::Variables(variables) if shader.has_word(variables, "const") => {
                (Some(variables.declarators[0].name), &variables.tokens)
            }
            Declaration::Variables(variables) if variables.structure.is_some() => {
                let name = variables.structure.as_ref().and_then(|s| s.name);
                (name.or(Some(variables.ty)), &variables.tokens)
            }
            _ => continue,
        };
        if name.is_some_and(|name| uses(shader.code[name].text)) {
            end = end.max(shader.next_line(shader.bytes(tokens).end));
        }
    }
    for directive in shader.directives() {
        let defines = directive.len() > 2 && shader.word(directive.start + 1) == "define";
        if defines && uses(shader.word(directive.start + 2)) {
            end = end.max(shader.next_line(shader.raw.tokens[directive.end - 1].end));
        }
    }
    end
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_')
}

/// Gives out binding numbers, those written in the text first.
pub(super) struct Bindings {
    set: u32,
    next: u32,
    taken: BTreeSet<u32>,
    pub given: Vec<Binding>,
}

impl Bindings {
    pub fn new(shader: &Shader<'_>, set: u32, first: u32) -> Bindings {
        let mut taken = BTreeSet::new();
        for declaration in &shader.declarations {
            if let Some(binding) =
                qualifiers(declaration).and_then(|q| number(shader, q, "binding"))
            {
                taken.insert(binding);
            }
        }
        Bindings { set, next: first, taken, given: Vec::new() }
    }

    /// The next free number, for something of that name.
    pub fn give(&mut self, name: &str) -> (u32, u32) {
        while self.taken.contains(&self.next) {
            self.next += 1;
        }
        self.next += 1;
        self.note(name, self.next - 1)
    }

    fn note(&mut self, name: &str, binding: u32) -> (u32, u32) {
        self.given.push(Binding { name: name.to_string(), set: self.set, binding });
        (self.set, binding)
    }
}

fn qualifiers(declaration: &Declaration) -> Option<&Qualifiers> {
    match declaration {
        Declaration::Block(block) => Some(&block.qualifiers),
        Declaration::Variables(variables) => Some(&variables.qualifiers),
        _ => None,
    }
}

/// `KEY = N` in a layout.
pub(super) fn number(shader: &Shader<'_>, qualifiers: &Qualifiers, key: &str) -> Option<u32> {
    let tokens = qualifiers.layouts.iter().cloned().flatten();
    tokens.filter(|&at| shader.code[at].text == key).find_map(|at| {
        let value = shader.code.get(at + 2)?.text;
        (shader.code[at + 1].text == "=").then(|| value.parse().ok())?
    })
}

/// Gives the blocks and handles that stay their bindings, in the order of the text.
pub(super) fn bind(
    shader: &Shader<'_>,
    bindings: &mut Bindings,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) {
    let mut seen = BTreeSet::new();
    for declaration in &shader.declarations {
        match declaration {
            Declaration::Block(block) => bind_block(shader, block, bindings, &mut seen, edits),
            Declaration::Variables(variables)
                if shader.has_word(variables, "uniform")
                    && is_opaque(shader.code[variables.ty].text) =>
            {
                bind_handles(shader, variables, bindings, &mut seen, edits, problems);
            }
            _ => {}
        }
    }
}

/// The number written, unless another thing has it already; else a new one.
fn binding_for(
    shader: &Shader<'_>,
    qualifiers: &Qualifiers,
    name: &str,
    bindings: &mut Bindings,
    seen: &mut BTreeSet<u32>,
) -> (u32, u32) {
    match number(shader, qualifiers, "binding").filter(|binding| seen.insert(*binding)) {
        Some(binding) => bindings.note(name, binding),
        None => bindings.give(name),
    }
}

fn bind_block(
    shader: &Shader<'_>,
    block: &Block,
    bindings: &mut Bindings,
    seen: &mut BTreeSet<u32>,
    edits: &mut Edits,
) {
    let word = |word: &str| block.qualifiers.words.iter().any(|&at| shader.code[at].text == word);
    let has = |id: &str| ids(shader, &block.qualifiers).iter().any(|(key, _)| key == id);
    let (uniform, buffer) = (word("uniform"), word("buffer"));
    if !(uniform || buffer) || has("push_constant") || has("buffer_reference") {
        return;
    }
    let name = shader.code[block.name].text;
    let (set, binding) = match number(shader, &block.qualifiers, "set") {
        Some(set) => {
            let (_, binding) = binding_for(shader, &block.qualifiers, name, bindings, seen);
            (set, binding)
        }
        None => binding_for(shader, &block.qualifiers, name, bindings, seen),
    };
    let mut add = vec![format!("set = {set}"), format!("binding = {binding}")];
    if !has("std140") && !has("std430") && !has("scalar") {
        add.push(if uniform { "std140" } else { "std430" }.to_string());
    }
    let drop = ["set", "binding", "shared", "packed"];
    qualify(shader, &block.qualifiers, block.tokens.start, &add, &drop, edits);
}

fn bind_handles(
    shader: &Shader<'_>,
    variables: &Variables,
    bindings: &mut Bindings,
    seen: &mut BTreeSet<u32>,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) {
    unsized_arrays(shader, variables, problems);
    let drop = ["set", "binding", "location"];
    let places: Vec<Vec<String>> = variables
        .declarators
        .iter()
        .map(|declarator| {
            let name = shader.code[declarator.name].text;
            let (set, binding) = binding_for(shader, &variables.qualifiers, name, bindings, seen);
            vec![format!("set = {set}"), format!("binding = {binding}")]
        })
        .collect();
    qualify(shader, &variables.qualifiers, variables.tokens.start, &places[0], &drop, edits);
    // `uniform sampler2D a, b;`: each has a number, so each has a declaration.
    for (declarator, place) in variables.declarators.iter().zip(&places).skip(1) {
        let comma = shader.code[declarator.name - 1];
        let words = variables.qualifiers.words.iter().map(|&at| shader.code[at].text);
        let words: Vec<&str> = words.collect();
        let mut layout = place.clone();
        layout.extend(kept(shader, &variables.qualifiers, &drop));
        let ty = shader.code[variables.ty].text;
        let text = format!("; layout({}) {} {ty}", layout.join(", "), words.join(" "));
        edits.replace(comma.start..comma.end, text);
    }
}

/// What stands in the `layout(…)` of a declaration: keys and their whole text.
fn ids(shader: &Shader<'_>, qualifiers: &Qualifiers) -> Vec<(String, String)> {
    let texts = qualifiers.layouts.iter().map(|layout| shader.text_of(layout));
    texts
        .flat_map(|text| text.split(','))
        .map(|id| {
            let key = id.split('=').next().unwrap_or("").trim();
            (key.to_ascii_lowercase(), id.trim().to_string())
        })
        .filter(|(key, _)| !key.is_empty())
        .collect()
}

fn kept(shader: &Shader<'_>, qualifiers: &Qualifiers, drop: &[&str]) -> Vec<String> {
    let ids = ids(shader, qualifiers).into_iter();
    ids.filter(|(key, _)| !drop.contains(&key.as_str())).map(|(_, text)| text).collect()
}

/// Writes a `layout(…)` in front of a declaration, or changes the one it has.
pub(super) fn qualify(
    shader: &Shader<'_>,
    qualifiers: &Qualifiers,
    first: usize,
    add: &[String],
    drop: &[&str],
    edits: &mut Edits,
) {
    let mut all = add.to_vec();
    all.extend(kept(shader, qualifiers, drop));
    let text = all.join(", ");
    match qualifiers.layouts.as_slice() {
        [] => edits.insert(shader.code[first].start, format!("layout({text}) ")),
        [one, rest @ ..] => {
            let (open, close) = (shader.code[one.start - 1].end, shader.code[one.end].start);
            edits.replace(open..close, text);
            for layout in rest {
                let end = shader.code[layout.end].end;
                edits.delete(shader.code[layout.start - 2].start..end);
            }
        }
    }
}
