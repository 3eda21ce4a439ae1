//! Uniforms: loose ones move into one block, handles and blocks stay in place and get bindings.

use rustc_hash::FxHashSet;

use std::collections::BTreeSet;

use super::edits::Edits;
use super::hoist::Handles;
use super::outline::layouts;
use super::ported::{Binding, InitialValue};
use super::shader::{Shader, is_opaque, refusal, structure};
use landfall_layout::Diagnostic;
use landfall_layout::syntax::glsl::ast::{BlockDecl, Declaration, Declarator, Item, Qualifiers};

/// The loose uniforms of a shader.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathered {
    /// The block's members, one line each, with their comments.
    pub members: String,
    /// The members of the block shared with the partner: the place of each there, and its lines.
    pub shared: Vec<(usize, String)>,
    /// The handles moved out of structures: type, and name with dimensions.
    pub handles: Vec<(String, String)>,
    /// The names that must be declared before their use.
    pub names: Vec<String>,
    pub values: Vec<InitialValue>,
    /// The end of the last loose uniform, as a byte offset.
    pub last: Option<usize>,
    /// The byte offset after the declarations of all their types.
    pub after: usize,
}

impl Gathered {
    /// The members of the shared block in their order.
    pub fn shared_members(&self) -> String {
        let mut members = self.shared.clone();
        members.sort();
        members.into_iter().map(|(_, text)| text).collect()
    }
}

/// Removes the loose uniforms from the text; those named in `shared` go into the shared block.
pub(super) fn gather(
    shader: &Shader<'_>,
    handles: &Handles<'_, '_>,
    shared: &[String],
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) -> Gathered {
    let mut gathered = Gathered::default();
    for variables in shader.variables().filter(|v| shader.has_word(&v.qualifiers, "uniform")) {
        let ty = type_of(shader, variables);
        // Handles stay where they are: `bind` gives them bindings.
        if is_opaque(&ty) {
            if ty == "atomic_uint" {
                let problem = refusal(variables.ty.span, "Vulkan has no atomic counters");
                let help = "use a `uint` in a `buffer` block and `atomicAdd`";
                problems.push(problem.with_help(help));
            }
            continue;
        }
        unsized_arrays(variables, problems);
        for declarator in &variables.names {
            let name = declarator.name.text;
            gathered.names.push(name.to_string());
            // Of a structure with handles, these become variables, the rest a member.
            for (own, path) in handles.of_global(name) {
                let outer = shader.dims(declarator.dims.iter().chain(&variables.ty.dims));
                gathered.names.push(own.to_string());
                gathered.handles.push((path.ty.to_string(), format!("{own}{outer}{}", path.dims)));
            }
            // An initial value: blocks have none, so that the host has to set it.
            if !declarator.tokens.is_empty() {
                let text = shader.text_of(&declarator.tokens);
                gathered
                    .values
                    .push(InitialValue { name: name.to_string(), value: text.to_string() });
            }
        }
        take(shader, variables, &ty, (handles.has_data(&ty), shared), edits, &mut gathered);
    }
    gathered.after = types_end(shader, &gathered);
    gathered
}

fn type_of(shader: &Shader<'_>, variables: &Declaration<'_>) -> String {
    match structure(&variables.ty) {
        None => shader.type_word(&variables.ty).to_string(),
        Some(structure) if structure.name.text.is_empty() => {
            shader.unused(&format!("{}_type", variables.names[0].name.text))
        }
        Some(structure) => structure.name.text.to_string(),
    }
}

fn unsized_arrays(variables: &Declaration<'_>, problems: &mut Vec<Diagnostic>) {
    for Declarator { name, dims, .. } in &variables.names {
        if dims.iter().chain(&variables.ty.dims).any(|dim| dim.tokens.is_empty()) {
            let message = format!("the array `{}` has no size, which a block needs", name.text);
            let problem = refusal(name.span, message);
            problems.push(problem.with_help("write the number of elements between the brackets"));
        }
    }
}

/// Moves a declaration into the block, with its comments; a structure it declares stays.
fn take(
    shader: &Shader<'_>,
    variables: &Declaration<'_>,
    ty: &str,
    (has_data, shared): (bool, &[String]),
    edits: &mut Edits,
    gathered: &mut Gathered,
) {
    let taken = shader.lines_of(&variables.tokens);
    gathered.last = Some(shader.bytes(&variables.tokens).end);
    let qualifiers = shader.words_of(&variables.qualifiers).into_iter();
    let precisions = qualifiers.filter(|word| matches!(*word, "lowp" | "mediump" | "highp"));
    let precision: String = precisions.map(|word| format!("{word} ")).collect();
    let all = shader.bytes(&variables.tokens);
    // Before the declaration is rendered for the block, which then comes without values.
    for value in variables.names.iter().map(|d| &d.tokens).filter(|value| !value.is_empty()) {
        // From the token before `=`.
        edits.delete(shader.code[value.start - 2].end..shader.bytes(value).end);
    }
    let first = shader.code[variables.names[0].name.at].start;
    let type_end = match structure(&variables.ty) {
        Some(structure) => shader.bytes(&structure.tokens).end,
        None => shader.code[variables.ty.at].end,
    };
    if has_data {
        let lines = taken.before.lines();
        let before: String = lines.map(|line| format!("    {}\n", line.trim())).collect();
        let after =
            if taken.after.is_empty() { String::new() } else { format!(" {}", taken.after) };
        let place = |declarator: &Declarator<'_>| {
            shared.iter().position(|name| name == declarator.name.text)
        };
        let names = &variables.names;
        // All declarators are in one block: the declaration moves as it is.
        if names.iter().all(|declarator| place(declarator).is_none()) {
            let declared = edits.render(shader.text, type_end..all.end);
            let text = format!("{before}    {precision}{ty}{declared}{after}\n");
            gathered.members.push_str(&text);
        } else {
            // Some are in the shared block: each declarator becomes a declaration of its own.
            let dims = edits.render(shader.text, type_end..first);
            for (index, declarator) in names.iter().enumerate() {
                let start = shader.code[declarator.name.at].start;
                let end = match names.get(index + 1) {
                    Some(next) => shader.code[next.name.at - 1].start,
                    None => all.end - 1,
                };
                let declared = edits.render(shader.text, start..end);
                let before = if index == 0 { &*before } else { "" };
                let after = if index + 1 == names.len() { &*after } else { "" };
                let text = format!("{before}    {precision}{ty}{dims}{declared};{after}\n");
                match place(declarator) {
                    Some(place) => gathered.shared.push((place, text)),
                    None => gathered.members.push_str(&text),
                }
            }
        }
    }
    match structure(&variables.ty) {
        None => edits.delete(taken.bytes),
        // The structure stays where it is declared, under a name if it had none.
        Some(structure) => {
            let body = shader.bytes(&structure.tokens);
            edits.delete(all.start..body.start);
            if structure.name.text.is_empty() {
                edits.insert(body.start + "struct".len(), format!(" {ty}"));
            }
            edits.delete(body.end..first);
            edits.delete(first..all.end - 1);
        }
    }
}

/// The end of the last declaration that the members' types and sizes use.
fn types_end(shader: &Shader<'_>, gathered: &Gathered) -> usize {
    let of_handles = gathered.handles.iter().flat_map(|(_, text)| words(text));
    let of_shared = gathered.shared.iter().flat_map(|(_, text)| words(text));
    let used: FxHashSet<&str> =
        words(&gathered.members).chain(of_shared).chain(of_handles).collect();
    let uses = |name: &str| used.contains(name);
    // Behind the last one of: constants in sizes, structures, macros.
    let mut end = 0;
    for item in &shader.items {
        let Item::Variables(variables) = item else { continue };
        let name = match (variables.names.first(), structure(&variables.ty)) {
            (Some(first), _) if shader.has_word(&variables.qualifiers, "const") => first.name.text,
            (_, Some(structure)) => structure.name.text,
            (_, None) => continue,
        };
        if !name.is_empty() && uses(name) {
            end = end.max(shader.next_line(shader.bytes(&variables.tokens).end));
        }
    }
    for directive in shader.directives() {
        // A macro behind all the uniforms changes none of their declarations.
        let is_before =
            gathered.last.is_none_or(|last| shader.raw.tokens[directive.start].start < last);
        let defines = directive.len() > 2 && shader.word(directive.start + 1) == "define";
        if is_before && defines && uses(shader.word(directive.start + 2)) {
            end = end.max(shader.next_line(shader.raw.tokens[directive.end - 1].end));
        }
    }
    end
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_')
}

/// The bindings of the partner.
#[derive(Debug, Default)]
pub(super) struct PartnerBindings {
    /// Bindings by name that the partner determines.
    pub by_name: Vec<Binding>,
    /// Binding numbers that the partner uses.
    pub taken: BTreeSet<u32>,
    /// The first binding after those of an earlier stage.
    pub next: u32,
}

/// Assigns binding numbers, skipping those written in the text and those of the partner.
pub(super) struct Bindings {
    set: u32,
    next: u32,
    taken: BTreeSet<u32>,
    /// The numbers that declarations have so far.
    used: BTreeSet<u32>,
    /// Bindings by name that the partner determines.
    partners: Vec<Binding>,
    /// Whether the partner is the earlier stage, whose bindings are settled.
    is_later: bool,
    pub given: Vec<Binding>,
}

impl Bindings {
    pub fn new(shader: &Shader<'_>, set: u32, first: u32, partner: &PartnerBindings) -> Bindings {
        let own = explicit(shader, set).into_iter().map(|binding| binding.binding);
        // Only an earlier stage sets it: to what comes after its bindings, if it has any.
        let is_later = partner.next > 0;
        let used = if is_later { partner.taken.clone() } else { BTreeSet::new() };
        Bindings {
            set,
            next: first.max(partner.next),
            taken: own.chain(partner.taken.iter().copied()).collect(),
            used,
            partners: partner.by_name.clone(),
            is_later,
            given: Vec::new(),
        }
    }

    /// Assigns the next free binding; returns set and binding.
    pub fn give(&mut self, name: &str) -> (u32, u32) {
        // Numbers written in the text or used by the partner are not given again.
        while self.taken.contains(&self.next) {
            self.next += 1;
        }
        self.next += 1;
        self.note(name, self.next - 1)
    }

    /// Assigns the partner's binding of that name, or the next free one.
    pub fn known_or_new(&mut self, name: &str) -> (u32, u32) {
        match self.partners.iter().find(|binding| binding.name == name) {
            Some(known) => self.note(name, known.binding),
            None => self.give(name),
        }
    }

    /// Assigns the binding of the shared block: that of the earlier stage, if that is the partner.
    pub fn shared(&mut self, name: &str, known: Option<u32>) -> (u32, u32) {
        match known {
            Some(binding) => self.note(name, binding),
            None => self.give(name),
        }
    }

    fn note(&mut self, name: &str, binding: u32) -> (u32, u32) {
        self.given.push(Binding { name: name.to_string(), set: self.set, binding });
        (self.set, binding)
    }
}

/// The bindings written in a text, by the names of blocks and variables.
pub(super) fn explicit(shader: &Shader<'_>, set: u32) -> Vec<Binding> {
    let mut written = Vec::new();
    for item in &shader.items {
        let Some(binding) = qualifiers(item).and_then(|q| number(shader, q, "binding")) else {
            continue;
        };
        let mut add = |name: &str| written.push(Binding { name: name.to_string(), set, binding });
        match item {
            Item::Block(block) | Item::Interface(block) => add(block.name.text),
            Item::Variables(variables) => {
                variables.names.iter().for_each(|declarator| add(declarator.name.text));
            }
            _ => {}
        }
    }
    written
}

pub(super) fn qualifiers<'i, 'a>(item: &'i Item<'a>) -> Option<&'i Qualifiers<'a>> {
    match item {
        Item::Block(block) | Item::Interface(block) => Some(&block.qualifiers),
        Item::Variables(variables) => Some(&variables.qualifiers),
        _ => None,
    }
}

/// The number N of `KEY = N` in `layout(…)`.
pub(super) fn number(shader: &Shader<'_>, qualifiers: &Qualifiers<'_>, key: &str) -> Option<u32> {
    let ids = qualifiers.layout.iter().filter(|id| id.name.text.eq_ignore_ascii_case(key));
    let mut found = ids.filter_map(|id| shader.numbers.get(&id.name.span.start).copied());
    found.next()
}

/// Assigns bindings to the blocks and handles, in source order.
pub(super) fn bind(
    shader: &Shader<'_>,
    bindings: &mut Bindings,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) {
    for item in &shader.items {
        match item {
            Item::Block(block) | Item::Interface(block) => {
                bind_block(shader, block, bindings, edits)
            }
            Item::Variables(variables)
                if !variables.names.is_empty()
                    && shader.has_word(&variables.qualifiers, "uniform")
                    && is_opaque(shader.type_word(&variables.ty)) =>
            {
                bind_handles(shader, variables, bindings, edits, problems);
            }
            _ => {}
        }
    }
}

/// The partner's binding of that name, or the one written in the text, or a new one if there is
/// none or it is already used.
fn binding_for(
    shader: &Shader<'_>,
    qualifiers: &Qualifiers<'_>,
    name: &str,
    bindings: &mut Bindings,
) -> (u32, u32) {
    // An earlier stage has decided. Otherwise what is written counts, unless another declaration
    // has that number: in OpenGL, blocks and samplers are numbered apart.
    let known = bindings.partners.iter().find(|binding| binding.name == name);
    let known = known.map(|known| known.binding);
    if let Some(known) = known.filter(|_| bindings.is_later) {
        return bindings.note(name, known);
    }
    let written = number(shader, qualifiers, "binding").or(known);
    match written.filter(|binding| bindings.used.insert(*binding)) {
        Some(binding) => bindings.note(name, binding),
        None => bindings.give(name),
    }
}

fn bind_block(
    shader: &Shader<'_>,
    block: &BlockDecl<'_>,
    bindings: &mut Bindings,
    edits: &mut Edits,
) {
    let word = |word: &str| shader.has_word(&block.qualifiers, word);
    let has = |id: &str| ids(shader, &block.qualifiers).iter().any(|(key, _)| key == id);
    let (uniform, buffer) = (word("uniform"), word("buffer"));
    // Push constants and buffer references have no binding, nor do inputs and outputs.
    if !(uniform || buffer) || has("push_constant") || has("buffer_reference") {
        return;
    }
    let (set, binding) = binding_for(shader, &block.qualifiers, block.name.text, bindings);
    let set = number(shader, &block.qualifiers, "set").unwrap_or(set);
    let mut add = vec![format!("set = {set}"), format!("binding = {binding}")];
    // GL_KHR_vulkan_glsl: `shared` and `packed` are not allowed, and these are the defaults.
    if !has("std140") && !has("std430") && !has("scalar") {
        add.push(if uniform { "std140" } else { "std430" }.to_string());
    }
    let drop = ["set", "binding", "shared", "packed"];
    qualify(shader, &block.qualifiers, block.tokens.start, &add, &drop, edits);
}

fn bind_handles(
    shader: &Shader<'_>,
    variables: &Declaration<'_>,
    bindings: &mut Bindings,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) {
    unsized_arrays(variables, problems);
    let drop = ["set", "binding", "location"];
    let places: Vec<Vec<String>> = variables
        .names
        .iter()
        .map(|declarator| {
            let name = declarator.name.text;
            let (set, binding) = binding_for(shader, &variables.qualifiers, name, bindings);
            vec![format!("set = {set}"), format!("binding = {binding}")]
        })
        .collect();
    qualify(shader, &variables.qualifiers, variables.tokens.start, &places[0], &drop, edits);
    // `uniform sampler2D a, b;`: each needs a declaration for its own binding.
    let words = shader.words_of(&variables.qualifiers);
    for (declarator, place) in variables.names.iter().zip(&places).skip(1) {
        set_apart(shader, variables, declarator, &words, place, &drop, edits);
    }
}

/// Begins a declaration of its own for a declarator after the first.
pub(super) fn set_apart(
    shader: &Shader<'_>,
    variables: &Declaration<'_>,
    declarator: &Declarator<'_>,
    words: &[&str],
    add: &[String],
    drop: &[&str],
    edits: &mut Edits,
) {
    let comma = shader.code[declarator.name.at - 1];
    let layout = changed_layout(shader, &variables.qualifiers, add, drop);
    let ty = shader.type_word(&variables.ty);
    let dims = shader.dims(&variables.ty.dims);
    let text = format!("; layout({layout}) {} {ty}{dims}", words.join(" "));
    edits.replace(comma.start..comma.end, text);
}

/// The entries of a declaration's `layout(…)`: keys in lower case, and whole texts.
fn ids(shader: &Shader<'_>, qualifiers: &Qualifiers<'_>) -> Vec<(String, String)> {
    let layouts = layouts(&shader.code, qualifiers);
    let texts = layouts.iter().map(|layout| shader.text_of(layout));
    texts
        .flat_map(|text| text.split(','))
        .map(|id| {
            let key = id.split('=').next().unwrap_or("").trim();
            (key.to_ascii_lowercase(), id.trim().to_string())
        })
        .filter(|(key, _)| !key.is_empty())
        .collect()
}

/// What stands between the parentheses of `layout(…)`, with other entries.
fn changed_layout(
    shader: &Shader<'_>,
    qualifiers: &Qualifiers<'_>,
    add: &[String],
    drop: &[&str],
) -> String {
    let kept = ids(shader, qualifiers).into_iter();
    let kept = kept.filter(|(key, _)| !drop.contains(&key.as_str())).map(|(_, text)| text);
    let all: Vec<String> = add.iter().cloned().chain(kept).collect();
    all.join(", ")
}

/// Inserts a `layout(…)` before a declaration, or changes the existing one.
pub(super) fn qualify(
    shader: &Shader<'_>,
    qualifiers: &Qualifiers<'_>,
    first: usize,
    add: &[String],
    drop: &[&str],
    edits: &mut Edits,
) {
    let text = changed_layout(shader, qualifiers, add, drop);
    match layouts(&shader.code, qualifiers).as_slice() {
        [] => edits.insert(shader.code[first].start, format!("layout({text}) ")),
        // Later `layout(…)` are merged into the first: GLSL before 4.20 takes only one.
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
