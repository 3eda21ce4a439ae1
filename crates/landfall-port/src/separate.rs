//! Rewrites a ported text for naga: separate textures and samplers, no precision qualifiers, no
//! `bool` in blocks.

use rustc_hash::{FxHashMap, FxHashSet};

use super::Binding;
use super::edits::Edits;
use super::hoist::arguments;
use super::outline::Tokens;
use super::shader::{Shader, is_opaque, refusal, structure};
use super::uniforms::number;
use landfall_layout::Diagnostic;
use landfall_layout::syntax::glsl::ast::{FunctionDecl, Item};
use landfall_layout::syntax::glsl::lexer::Kind;

/// A combined sampler split into a texture and a sampler.
#[derive(Clone, Debug)]
struct SplitSampler {
    /// Its old type, which combines the two in uses: `sampler2D(t, t_sampler)`.
    joined: String,
    sampler: String,
}

type Scope<'a> = FxHashMap<&'a str, SplitSampler>;

/// Returns the edits that rewrite a ported text; adds new bindings to `bindings`.
pub(super) fn separate(
    shader: &Shader<'_>,
    bindings: &mut Vec<Binding>,
    problems: &mut Vec<Diagnostic>,
) -> Edits {
    let mut edits = Edits::default();
    // Each kind of edit is independent of the others, and drops what overlaps.
    drop_words(shader, &mut edits);
    drop_redeclared(shader, &mut edits);
    let bools = bools(shader, &mut edits);
    let globals = globals(shader, bindings, &mut edits, problems);
    // Functions that take combined samplers: which of their parameters.
    let takers: FxHashMap<&str, Vec<usize>> = shader
        .functions()
        .map(|function| {
            let taken = function.parameters.iter().enumerate();
            let taken = taken.filter(|(_, p)| is_joined(shader.type_word(&p.ty)));
            (function.name.text, taken.map(|(index, _)| index).collect::<Vec<_>>())
        })
        .filter(|(_, taken)| !taken.is_empty())
        .collect();
    for function in shader.functions() {
        let scope = parameters(shader, function, &globals, &mut edits, problems);
        if let Some(body) = &function.body_tokens {
            uses(shader, body, &scope, &takers, &bools, &mut edits);
        }
    }
    refuse(shader, &globals, problems);
    edits
}

/// Whether a type is a combined texture and sampler.
fn is_joined(ty: &str) -> bool {
    is_opaque(ty) && ty.contains("sampler") && !matches!(ty, "sampler" | "samplerShadow")
}

/// The texture and sampler types of a combined one: `texture2D` and `samplerShadow` for
/// `sampler2DShadow`.
fn parts(joined: &str) -> (String, &'static str) {
    let texture = joined.replacen("sampler", "texture", 1);
    match texture.strip_suffix("Shadow") {
        Some(texture) => (texture.to_string(), "samplerShadow"),
        None => (texture, "sampler"),
    }
}

/// Deletes qualifiers and statements without effect here, which naga does not parse.
fn drop_words(shader: &Shader<'_>, edits: &mut Edits) {
    for at in shader.words() {
        let token = &shader.raw.tokens[at];
        match shader.word(at) {
            "precision" | "invariant" if token.directive.is_none() => {
                // A statement has at most four tokens, `precision mediump float ;`; a qualifier
                // goes alone.
                let rest = shader.raw.tokens[at..].iter().take_while(|t| t.directive.is_none());
                let end = rest.take(4).find(|t| &shader.text[t.start..t.end] == ";");
                let end = end.filter(|_| is_statement(shader, at)).map(|t| t.end);
                edits.delete(token.start..end.unwrap_or(token.end + 1));
            }
            "lowp" | "mediump" | "highp" => {
                let space = shader.text[token.end..].starts_with(' ');
                edits.delete(token.start..token.end + usize::from(space));
            }
            _ => {}
        }
    }
}

/// Deletes `out gl_PerVertex { … };`, which names again what is predeclared (GLSL 4.60 §7.1.1).
fn drop_redeclared(shader: &Shader<'_>, edits: &mut Edits) {
    for (at, token) in shader.code.iter().enumerate() {
        let qualifier = at.checked_sub(1).map(|before| shader.code[before]);
        let Some(first) = qualifier.filter(|word| matches!(word.text, "in" | "out")) else {
            continue;
        };
        let rest = &shader.code[at..];
        let is_block = token.text == "gl_PerVertex" && rest.get(1).is_some_and(|t| t.text == "{");
        let close = rest.iter().position(|token| token.text == "}").filter(|_| is_block);
        // An instance, `gl_in[]`, is not predeclared by this.
        let end = close.and_then(|close| rest.get(close + 1)).filter(|token| token.text == ";");
        if let Some(end) = end {
            edits.delete(first.start..end.end);
        }
    }
}

/// Whether a word starts a whole statement: `precision …;` and `invariant gl_Position;`, not
/// `invariant out vec3 v;`.
fn is_statement(shader: &Shader<'_>, at: usize) -> bool {
    shader.word(at) == "precision" || shader.word(at + 1).starts_with("gl_")
}

/// Changes `bool` members of blocks without an instance to `uint`; returns their names.
fn bools<'a>(shader: &Shader<'a>, edits: &mut Edits) -> FxHashSet<&'a str> {
    let mut names = FxHashSet::default();
    for item in &shader.items {
        let (Item::Block(block) | Item::Interface(block)) = item else { continue };
        if block.instance.is_some() {
            continue;
        }
        for member in &block.members {
            let ty = shader.code[member.ty.at];
            let plain = member.ty.dims.is_empty() && member.names.iter().all(|d| d.dims.is_empty());
            if ty.text == "bool" && plain {
                edits.replace(ty.start..ty.end, "uint");
                names.extend(member.names.iter().map(|d| d.name.text));
            }
        }
    }
    names
}

fn globals<'a>(
    shader: &Shader<'a>,
    bindings: &mut Vec<Binding>,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) -> Scope<'a> {
    let mut scope = Scope::default();
    for variables in shader.variables().filter(|v| shader.has_word(&v.qualifiers, "uniform")) {
        let ty = shader.code[variables.ty.at];
        if !is_joined(ty.text) {
            continue;
        }
        let (texture, sampler) = parts(ty.text);
        let declarator = &variables.names[0];
        let name = declarator.name.text;
        let dims = shader.dims(variables.ty.dims.iter().chain(&declarator.dims));
        // Texel buffers are no combined samplers, and naga has no arrays of them.
        if ty.text.contains("Buffer") || !dims.is_empty() {
            let message =
                format!("naga does not support the type of `{name}`: `{}{dims}`", ty.text);
            problems.push(refusal(declarator.name.span, message));
            continue;
        }
        let own = shader.unused(&format!("{name}_sampler"));
        let set = number(shader, &variables.qualifiers, "set").unwrap_or(0);
        // Behind all bindings of its set.
        let free =
            bindings.iter().filter(|b| b.set == set).map(|b| b.binding + 1).max().unwrap_or(0);
        bindings.push(Binding { name: own.clone(), set, binding: free });
        edits.replace(ty.start..ty.end, texture);
        let end = shader.bytes(&variables.tokens).end;
        edits.insert(
            end,
            format!(" layout(set = {set}, binding = {free}) uniform {sampler} {own};"),
        );
        scope.insert(name, SplitSampler { joined: ty.text.to_string(), sampler: own });
    }
    scope
}

/// Splits the parameters of a function; returns the split samplers in scope of its body.
fn parameters<'a>(
    shader: &Shader<'a>,
    function: &FunctionDecl<'a>,
    globals: &Scope<'a>,
    edits: &mut Edits,
    problems: &mut Vec<Diagnostic>,
) -> Scope<'a> {
    let mut scope = globals.clone();
    for parameter in &function.parameters {
        for at in parameter.tokens.clone().filter(|&at| shader.code[at].text == "const") {
            edits.delete(shader.code[at].start..shader.code[at].end + 1);
        }
        let ty = shader.code[parameter.ty.at];
        let name = Some(parameter.name.text).filter(|name| !name.is_empty());
        if !is_joined(ty.text) {
            // A parameter of another type hides a global sampler.
            name.map(|name| scope.remove(name));
            continue;
        }
        if !parameter.dims.is_empty() || !parameter.ty.dims.is_empty() {
            let message = "naga does not support arrays of textures";
            problems.push(refusal(parameter.ty.span, message));
        }
        let (texture, sampler) = parts(ty.text);
        edits.replace(ty.start..ty.end, texture);
        // A prototype may have no names.
        let own = name.map_or(String::new(), |name| shader.unused(&format!("{name}_sampler")));
        let end = shader.bytes(&parameter.tokens).end;
        edits.insert(end, format!(", {sampler} {own}").trim_end().to_string());
        if let Some(name) = name {
            scope.insert(name, SplitSampler { joined: ty.text.to_string(), sampler: own });
        }
    }
    scope
}

fn uses<'a>(
    shader: &Shader<'a>,
    body: &Tokens,
    scope: &Scope<'a>,
    takers: &FxHashMap<&str, Vec<usize>>,
    bools: &FxHashSet<&str>,
    edits: &mut Edits,
) {
    let mut handed_on = FxHashSet::default();
    for at in body.clone() {
        let token = shader.code[at];
        if token.kind != Kind::Name || shader.code[at - 1].text == "." {
            continue;
        }
        let called = shader.code.get(at + 1).is_some_and(|next| next.text == "(");
        if let Some(taken) = takers.get(token.text).filter(|_| called) {
            let given = arguments(shader, at + 1);
            let own = taken.iter().filter_map(|index| given.get(*index));
            // Handed on as it is, a sampler becomes two arguments; anywhere else it is joined
            // again.
            handed_on.extend(own.filter(|argument| argument.len() == 1).map(|a| a.start));
        }
        if let Some(pair) = scope.get(token.text).filter(|_| !called) {
            let text = if handed_on.contains(&at) {
                format!("{}, {}", token.text, pair.sampler)
            } else {
                format!("{}({}, {})", pair.joined, token.text, pair.sampler)
            };
            edits.replace(token.start..token.end, text);
        // Uniform blocks are only read, so that a comparison can stand for the member.
        } else if bools.contains(token.text) && !called {
            edits.replace(token.start..token.end, format!("({} != 0u)", token.text));
        }
    }
}

/// Rejects what naga (as of 30.0.1) silently misreads.
fn refuse(shader: &Shader<'_>, globals: &Scope<'_>, problems: &mut Vec<Diagnostic>) {
    let declarators = shader.items.iter().flat_map(|item| match item {
        Item::Block(block) | Item::Interface(block) => {
            block.members.iter().flat_map(|member| &member.names).collect()
        }
        Item::Variables(variables) => match structure(&variables.ty) {
            Some(structure) if variables.names.is_empty() => {
                structure.members.iter().flat_map(|member| &member.names).collect()
            }
            _ => variables.names.iter().collect::<Vec<_>>(),
        },
        _ => Vec::new(),
    });
    for declarator in declarators {
        if declarator.dims.len() > 1 {
            let message = format!("naga swaps the dimensions of `{}`", declarator.name.text);
            let problem = refusal(declarator.name.span, message);
            problems.push(problem.with_help("use an array of one dimension"));
        }
    }
    let in_macro = shader.words().find(|&at| {
        let token = &shader.raw.tokens[at];
        token.active && token.directive.is_some() && globals.contains_key(shader.word(at))
    });
    if let Some(at) = in_macro {
        let message = format!("a macro uses the sampler `{}`", shader.word(at));
        let problem = refusal(shader.raw_span(at), message);
        problems.push(problem.with_help("expand the macro by hand"));
    }
}
