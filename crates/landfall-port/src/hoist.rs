//! Moves handles (samplers, images) out of structures, where Vulkan's GLSL forbids them:
//! `material.diffuse` becomes the variable `material_diffuse`, also in arrays and in function
//! parameters.

use rustc_hash::{FxHashMap, FxHashSet};

use super::edits::Edits;
use super::outline::Tokens;
use super::shader::{Shader, is_opaque, refusal, structure};
use landfall_layout::Diagnostic;
use landfall_layout::syntax::glsl::ast::{FunctionDecl, Parameter, StructDecl, TypeSpec};
use landfall_layout::syntax::glsl::lexer::Kind;

/// The path from a structure to a handle in it.
#[derive(Clone, Debug)]
pub(super) struct HoistedPath<'a> {
    pub fields: Vec<&'a str>,
    pub ty: &'a str,
    /// All array dimensions on the path, outermost first, as written: `[2][N]`.
    pub dims: String,
}

/// The structures that contain handles.
pub(super) struct Handles<'s, 'a> {
    shader: &'s Shader<'a>,
    structures: FxHashMap<&'a str, &'s StructDecl<'a>>,
    paths: FxHashMap<&'a str, Vec<HoistedPath<'a>>>,
    /// Global variables of these types.
    globals: FxHashMap<&'a str, Variable<'a>>,
    /// Functions with parameters of these types: index and structure of each.
    functions: FxHashMap<&'a str, Vec<(usize, &'a str)>>,
    /// Structures that contain anything but handles.
    data: FxHashSet<&'a str>,
    /// A structure with more than [`MAX_HANDLES`] handles.
    too_many: Option<&'a str>,
}

/// A variable whose type contains handles.
#[derive(Clone, Debug)]
struct Variable<'a> {
    structure: &'a str,
    /// The name of each handle's new variable, in the order of the structure's paths.
    names: Vec<String>,
}

/// The fields and indices after a use of a variable.
struct Chain<'a> {
    /// The tokens of the field names.
    fields: Vec<usize>,
    /// The indices, brackets included.
    indices: Vec<Tokens>,
    end: usize,
    to: Target<'a>,
}

enum Target<'a> {
    Handle,
    /// A structure that contains handles.
    Structure(&'a str),
    Data,
}

impl<'s, 'a> Handles<'s, 'a> {
    pub fn new(shader: &'s Shader<'a>) -> Handles<'s, 'a> {
        let structures = shader.structures();
        let mut handles = Handles {
            shader,
            structures,
            paths: FxHashMap::default(),
            globals: FxHashMap::default(),
            functions: FxHashMap::default(),
            data: FxHashSet::default(),
            too_many: None,
        };
        // Structures found before are not searched again, as they may be nested many times.
        let mut known = FxHashMap::default();
        for name in handles.structures.keys() {
            match paths(shader, &handles.structures, name, 0, &mut known) {
                None => handles.too_many = handles.too_many.or(Some(name)),
                Some(found) if found.is_empty() => {}
                Some(found) => {
                    handles.paths.insert(name, found);
                }
            }
        }
        handles.data = with_data(shader, &handles.structures);
        for variables in shader.variables().filter(|v| shader.has_word(&v.qualifiers, "uniform")) {
            let Some(structure) = handles.type_name(&variables.ty) else { continue };
            for declarator in &variables.names {
                let name = declarator.name.text;
                let variable = handles.variable(name, structure);
                handles.globals.insert(name, variable);
            }
        }
        for function in shader.functions() {
            let taken = function.parameters.iter().enumerate().filter_map(|(index, parameter)| {
                let name = shader.type_word(&parameter.ty);
                handles.paths.contains_key(name).then_some((index, name))
            });
            let taken: Vec<_> = taken.collect();
            if !taken.is_empty() {
                handles.functions.insert(function.name.text, taken);
            }
        }
        handles
    }

    /// The name of a type, if it contains handles.
    fn type_name(&self, ty: &TypeSpec<'a>) -> Option<&'a str> {
        let name = structure(ty).map_or_else(|| self.shader.type_word(ty), |s| s.name.text);
        self.paths.contains_key(name).then_some(name)
    }

    fn variable(&self, name: &str, structure: &'a str) -> Variable<'a> {
        let own = |path: &HoistedPath<'a>| {
            self.shader.unused(&format!("{name}_{}", path.fields.join("_")))
        };
        Variable { structure, names: self.paths[structure].iter().map(own).collect() }
    }

    /// Whether a type contains anything but handles.
    pub fn has_data(&self, ty: &str) -> bool {
        match self.structures.contains_key(ty) {
            true => self.data.contains(ty),
            false => !is_opaque(ty),
        }
    }

    /// The handles of a global variable, each with the name of its new variable.
    pub fn of_global(&self, name: &str) -> Vec<(&str, &HoistedPath<'a>)> {
        let Some(variable) = self.globals.get(name) else { return Vec::new() };
        let paths = &self.paths[variable.structure];
        variable.names.iter().map(String::as_str).zip(paths).collect()
    }

    /// Removes the handles from the structures.
    pub fn strip(&self, edits: &mut Edits) {
        // A structure of handles alone goes with its `;`, since GLSL has no empty structures; of
        // others the members go.
        for (name, structure) in &self.structures {
            if !self.paths.contains_key(name) {
                continue;
            }
            if !self.has_data(name) {
                let mut tokens = structure.tokens.clone();
                let next = self.shader.code.get(tokens.end);
                tokens.end += usize::from(next.is_some_and(|next| next.text == ";"));
                edits.delete(self.shader.lines_of(&tokens).bytes);
                continue;
            }
            for member in &structure.members {
                if !self.has_data(self.shader.type_word(&member.ty)) {
                    edits.delete(self.shader.lines_of(&member.tokens).bytes);
                }
            }
        }
    }

    /// Rewrites parameters, arguments and uses.
    pub fn rewrite(&self, edits: &mut Edits, problems: &mut Vec<Diagnostic>) {
        let mut known = FxHashMap::default();
        for function in self.shader.functions() {
            // A parameter hides a global variable of its name.
            let mut scope = self.globals.clone();
            for parameter in &function.parameters {
                self.parameter(function, parameter, &mut known, &mut scope, edits);
            }
            if let Some(body) = &function.body_tokens {
                self.body(body, &scope, edits, problems);
            }
        }
        self.refuse_macros(problems);
        if let Some(name) = self.too_many {
            let span = self.structures[name].name.span;
            let message =
                format!("structure `{name}` contains more than {MAX_HANDLES} samplers and images");
            problems.push(refusal(span, message));
        }
    }

    fn parameter(
        &self,
        function: &FunctionDecl<'a>,
        parameter: &Parameter<'a>,
        known: &mut FxHashMap<(&'a str, &'a str), Variable<'a>>,
        scope: &mut FxHashMap<&'a str, Variable<'a>>,
        edits: &mut Edits,
    ) {
        let name = Some(parameter.name.text).filter(|name| !name.is_empty());
        let Some(structure) = self.type_name(&parameter.ty) else {
            if let Some(name) = name {
                scope.remove(name); // it hides the global one
            }
            return;
        };
        let variable = match name {
            // Functions have the same names for it: each is new to the shader.
            Some(name) => {
                let new = || self.variable(name, structure);
                known.entry((name, structure)).or_insert_with(new).clone()
            }
            None => self.variable("p", structure),
        };
        let outer = self.shader.dims(parameter.ty.dims.iter().chain(&parameter.dims));
        // A prototype need not name its parameters.
        let nameless = function.body_tokens.is_none() && name.is_none();
        let own = variable.names.iter().zip(&self.paths[structure]).map(|(own, path)| {
            let own = if nameless { "" } else { own.as_str() };
            format!("{} {own}{outer}{}", path.ty, path.dims).trim_end().to_string()
        });
        let own: Vec<String> = own.collect();
        let bytes = self.shader.bytes(&parameter.tokens);
        if self.has_data(structure) {
            // The handles follow the parameter that keeps the data, or take its place.
            edits.insert(bytes.end, format!(", {}", own.join(", ")));
        } else {
            edits.replace(bytes, own.join(", "));
        }
        if let Some(name) = name {
            scope.insert(name, variable);
        }
    }

    fn body(
        &self,
        body: &Tokens,
        scope: &FxHashMap<&'a str, Variable<'a>>,
        edits: &mut Edits,
        problems: &mut Vec<Diagnostic>,
    ) {
        let code = &self.shader.code;
        let mut passed_on = FxHashSet::default();
        // `passed_on` has the arguments that were rewritten whole: their variables stay.
        for at in body.clone() {
            let word = code[at].text;
            if code[at].kind != Kind::Name || (at > 0 && code[at - 1].text == ".") {
                continue;
            }
            let called = code.get(at + 1).is_some_and(|token| token.text == "(");
            if let Some(parameters) = self.functions.get(word).filter(|_| called) {
                let arguments = arguments(self.shader, at + 1);
                for (index, structure) in parameters {
                    let Some(argument) = arguments.get(*index) else { continue };
                    if self.argument(argument, structure, scope, edits) {
                        passed_on.insert(argument.start);
                    }
                }
            }
            // A local variable of such a structure would be a copy.
            if self.paths.contains_key(word) && !called {
                problems.push(self.copied(at, word));
                continue;
            }
            let Some(variable) = scope.get(word) else { continue };
            let chain = self.chain(at, variable.structure);
            match chain.to {
                Target::Data => {}
                Target::Handle => {
                    let fields: Vec<&str> = chain.fields.iter().map(|&f| code[f].text).collect();
                    let paths = &self.paths[variable.structure];
                    let place = paths.iter().position(|path| path.fields == fields);
                    let name = place.and_then(|place| variable.names.get(place));
                    // `m[i].diffuse` becomes `m_diffuse[i]`: the name is replaced, fields go and
                    // indices stay.
                    edits.replace(code[at].start..code[at].end, name.map_or("", String::as_str));
                    for field in chain.fields {
                        edits.delete(code[field - 1].start..code[field].end);
                    }
                }
                Target::Structure(_) if passed_on.contains(&at) => {}
                Target::Structure(name) => problems.push(self.copied(at, name)),
            }
        }
    }

    /// Adds the handles of an argument after it; `false` if the argument is not a plain variable.
    fn argument(
        &self,
        argument: &Tokens,
        structure: &str,
        scope: &FxHashMap<&'a str, Variable<'a>>,
        edits: &mut Edits,
    ) -> bool {
        let code = &self.shader.code;
        let Some(first) = code.get(argument.start) else { return false };
        let Some(variable) = scope.get(first.text) else { return false };
        let chain = self.chain(argument.start, variable.structure);
        let found = matches!(chain.to, Target::Structure(name) if name == structure);
        if !found || chain.end != argument.end {
            return false;
        }
        let fields: Vec<&str> = chain.fields.iter().map(|&field| code[field].text).collect();
        let indices: String = chain.indices.iter().map(|i| self.shader.text_of(i)).collect();
        let paths = self.paths[variable.structure].iter().zip(&variable.names);
        // Of an argument `a.b`, the handles below that member, which keep their order.
        let own = paths.filter(|(path, _)| path.fields.starts_with(&fields));
        let own: Vec<String> = own.map(|(_, name)| format!("{name}{indices}")).collect();
        let bytes = self.shader.bytes(argument);
        if self.has_data(structure) {
            edits.insert(bytes.end, format!(", {}", own.join(", ")));
        } else {
            edits.replace(bytes, own.join(", "));
        }
        true
    }

    /// Follows `[…]` and `.field` after a variable.
    fn chain(&self, at: usize, structure: &'a str) -> Chain<'a> {
        let code = &self.shader.code;
        let mut chain = Chain {
            fields: Vec::new(),
            indices: Vec::new(),
            end: at + 1,
            to: Target::Structure(structure),
        };
        let mut current = structure;
        while let Some(token) = code.get(chain.end) {
            if token.text == "[" {
                let close = closing(self.shader, chain.end);
                chain.indices.push(chain.end..close + 1);
                chain.end = close + 1;
                continue;
            }
            if token.text != "." {
                break;
            }
            let field = chain.end + 1;
            let name = code.get(field).map_or("", |token| token.text);
            let members = &self.structures[current].members;
            let member = members
                .iter()
                .find(|member| member.names.iter().any(|declarator| declarator.name.text == name));
            // No member: `.length()` of an array, or an error that is reported elsewhere.
            let Some(member) = member else {
                chain.to = Target::Data;
                break;
            };
            chain.fields.push(field);
            chain.end = field + 1;
            let ty = self.shader.type_word(&member.ty);
            if is_opaque(ty) {
                chain.to = Target::Handle;
                break;
            }
            match self.paths.get_key_value(ty) {
                Some((name, _)) => {
                    current = name;
                    chain.to = Target::Structure(name);
                }
                None => {
                    chain.to = Target::Data;
                    break;
                }
            }
        }
        chain
    }

    fn copied(&self, at: usize, structure: &str) -> Diagnostic {
        let message = format!("this copies `{structure}`, which contains samplers or images");
        refusal(self.shader.span(at), message)
            .with_note(
                "samplers and images cannot be copied, so they are moved out of the structure",
            )
            .with_help("use the uniform itself, or pass it to a function")
    }

    /// Rejects macros that use such a variable.
    fn refuse_macros(&self, problems: &mut Vec<Diagnostic>) {
        for directive in self.shader.directives() {
            let words = directive.clone().map(|at| (at, self.shader.word(at)));
            let is_define = words.clone().nth(1).is_some_and(|(_, word)| word == "define");
            let found = words.skip(3).find(|(_, word)| self.globals.contains_key(word));
            if let (true, Some((at, word))) = (is_define, found) {
                let message = format!("a macro uses `{word}`, which contains samplers or images");
                let problem = refusal(self.shader.raw_span(at), message);
                problems.push(problem.with_help("expand the macro by hand"));
            }
        }
    }
}

/// The most handles in a structure, including those of its members.
const MAX_HANDLES: usize = 1024;

/// The handles in a structure; `None` when there are more than [`MAX_HANDLES`].
fn paths<'a>(
    shader: &Shader<'a>,
    structures: &FxHashMap<&'a str, &StructDecl<'a>>,
    name: &'a str,
    depth: usize,
    known: &mut FxHashMap<&'a str, Option<Vec<HoistedPath<'a>>>>,
) -> Option<Vec<HoistedPath<'a>>> {
    if let Some(found) = known.get(name) {
        return found.clone();
    }
    let mut found = Vec::new();
    // A structure that contains itself is an error in GLSL: deeper ones are not followed.
    let Some(structure) = structures.get(name).filter(|_| depth < 32) else { return Some(found) };
    for member in &structure.members {
        let ty = shader.type_word(&member.ty);
        let inner = if is_opaque(ty) {
            vec![HoistedPath { fields: Vec::new(), ty, dims: String::new() }]
        } else {
            let inner = paths(shader, structures, ty, depth + 1, known);
            match inner.filter(|inner| inner.len() * member.names.len() <= MAX_HANDLES) {
                Some(inner) => inner,
                None => {
                    known.insert(name, None);
                    return None;
                }
            }
        };
        for declarator in &member.names {
            // `T[2] a[3]` has three elements of two: the variable's dimensions come first (GLSL
            // 4.60 §4.1.9).
            let own = shader.dims(declarator.dims.iter().chain(&member.ty.dims));
            for path in &inner {
                let mut fields = vec![declarator.name.text];
                fields.extend(&path.fields);
                found.push(HoistedPath {
                    fields,
                    ty: path.ty,
                    dims: format!("{own}{}", path.dims),
                });
            }
        }
    }
    let found = (found.len() <= MAX_HANDLES).then_some(found);
    known.insert(name, found.clone());
    found
}

/// The structures that contain anything but handles, at any depth.
fn with_data<'a>(
    shader: &Shader<'a>,
    structures: &FxHashMap<&'a str, &StructDecl<'a>>,
) -> FxHashSet<&'a str> {
    let mut found = FxHashSet::default();
    // Structures are declared after those they contain, so one pass in order suffices; the second
    // is for invalid GLSL.
    let mut order: Vec<(&'a str, &StructDecl<'a>)> =
        structures.iter().map(|(name, structure)| (*name, *structure)).collect();
    order.sort_by_key(|(_, structure)| structure.tokens.start);
    for _ in 0..2 {
        for (name, structure) in &order {
            let is_data = |ty: &'a str| match structures.contains_key(ty) {
                true => found.contains(ty),
                false => !is_opaque(ty),
            };
            if structure.members.iter().any(|member| is_data(shader.type_word(&member.ty))) {
                found.insert(*name);
            }
        }
    }
    found
}

/// The arguments of a call whose `(` is at `open`.
pub(super) fn arguments(shader: &Shader<'_>, open: usize) -> Vec<Tokens> {
    let close = closing(shader, open);
    let mut all = Vec::new();
    let mut start = open + 1;
    let mut at = start;
    while at < close {
        match shader.code[at].text {
            "(" | "[" | "{" => at = closing(shader, at),
            "," => {
                all.push(start..at);
                start = at + 1;
            }
            _ => {}
        }
        at += 1;
    }
    all.push(start..close);
    all
}

/// The matching bracket; the last token if there is none.
fn closing(shader: &Shader<'_>, open: usize) -> usize {
    let mut depth = 0usize;
    for (at, token) in shader.code.iter().enumerate().skip(open) {
        match token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    shader.code.len() - 1
}
