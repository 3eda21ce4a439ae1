//! Declarations of variables, defaults and precisions that no compiler takes, for OpenGL or for
//! Vulkan: qualifiers that exclude each other, and those that the type or the storage does not have.

use super::ast::{Declaration, LayoutId, Qualifiers, Storage, Tokens, TypeBase};
use super::declarations::DeclarationReader;
use super::lexer::Token;
use super::report::diagnostic_at;
use super::types::{Builtin, builtin};
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{ScalarKind, Type};
use crate::source::Stage;

/// Storage qualifiers, of which a declaration has one (GLSL 4.60 §4.3).
const STORAGE: &[&str] =
    &["const", "in", "out", "inout", "uniform", "buffer", "shared", "attribute", "varying"];

/// Interpolation qualifiers, of which a declaration has one (GLSL 4.60 §4.5).
const INTERPOLATION: &[&str] = &["flat", "smooth", "noperspective"];

/// Auxiliary, invariance and precision-of-operations qualifiers.
const SINGLE: &[&str] = &["centroid", "sample", "patch", "invariant", "precise"];

/// Memory qualifiers (GLSL 4.60 §4.10).
const MEMORY: &[&str] = &["coherent", "volatile", "restrict", "readonly", "writeonly"];

/// Entries of `layout(…)` that blocks have, and variables do not.
const OF_BLOCKS: &[&str] = &[
    "std140",
    "std430",
    "scalar",
    "shared",
    "packed",
    "row_major",
    "column_major",
    "push_constant",
    "buffer_reference",
    "align",
];

/// Entries of `layout(…)` that stand in declarations of their own: `layout(…) in;`.
const ALONE: &[&str] = &["local_size_x", "local_size_y", "local_size_z", "early_fragment_tests"];

impl<'a> DeclarationReader<'a> {
    /// Returns what no compiler takes in a declaration of variables at global scope.
    pub(super) fn illegal_variables(&self, declaration: &Declaration<'a>) -> Vec<Diagnostic> {
        let Declaration { qualifiers, ty, names, .. } = declaration;
        let mut found = self.excluding(qualifiers);
        if names.is_empty() {
            return found; // `uniform struct S { … };` declares no variable
        }
        // `None` for structures of the text, also for one with the name of a built-in type.
        let kind = match &ty.base {
            TypeBase::Name(name) if !self.types.contains_key(name) => builtin(name),
            TypeBase::Name(_) | TypeBase::Struct(_) => None,
        };
        self.storage_of_variables(declaration, kind.as_ref(), &mut found);
        for id in &qualifiers.layout {
            if !self.is_allowed(id, qualifiers, kind.as_ref(), ty.at) {
                found.push(
                    self.not_allowed(&self.parser.token_of(&id.name), "a variable like this"),
                );
            }
        }
        let memory = self.words(qualifiers).find(|token| MEMORY.contains(&token.text));
        if let (Some(token), Some(Builtin::Data(_))) = (memory, &kind) {
            if !matches!(qualifiers.storage, Storage::Foreign | Storage::Buffer) {
                found.push(self.not_allowed(&token, "a variable that is no image"));
            }
        }
        for name in names {
            let token = self.parser.token_of(&name.name);
            let with_value = !name.tokens.is_empty();
            if qualifiers.storage == Storage::Const && !with_value {
                let message = format!("constant `{}` has no initialiser", token.text);
                let note = "GLSL 4.60 §4.3.3: constants are initialised where they are declared";
                found.push(diagnostic_at(&token, Code::Syntax, message).with_note(note));
            }
            let passed =
                matches!(qualifiers.storage, Storage::In | Storage::Out | Storage::Varying);
            if passed && with_value {
                let message = format!("input or output `{}` has an initialiser", token.text);
                let note = "GLSL 4.60 §4.3.4, §4.3.6: inputs and outputs take no initialisers";
                found.push(diagnostic_at(&token, Code::Syntax, message).with_note(note));
            }
        }
        found
    }

    /// Returns qualifiers that are repeated or exclude each other.
    pub(super) fn excluding(&self, qualifiers: &Qualifiers<'a>) -> Vec<Diagnostic> {
        let words: Vec<Token<'a>> = self.words(qualifiers).collect();
        let mut found = Vec::new();
        // Each word is reported once, against the first before it that excludes it. Quadratic in
        // the qualifiers of a declaration, of which there are few.
        for (at, token) in words.iter().enumerate() {
            let class = [STORAGE, INTERPOLATION].into_iter().find(|all| all.contains(&token.text));
            let single = SINGLE.contains(&token.text) || MEMORY.contains(&token.text);
            let mut before = words[..at].iter();
            let message = match class {
                Some(class) => before.find(|other| class.contains(&other.text)).map(|other| {
                    match other.text == token.text {
                        true => format!("`{}` is written twice", token.text),
                        false => {
                            format!("`{}` and `{}` exclude each other", other.text, token.text)
                        }
                    }
                }),
                None => before
                    .any(|other| single && other.text == token.text)
                    .then(|| format!("`{}` is written twice", token.text)),
            };
            if let Some(message) = message {
                let help = format!("remove `{}`", token.text);
                let error = diagnostic_at(token, Code::LayoutQualifier, message);
                found.push(error.with_help(help));
            }
        }
        found
    }

    /// Returns qualifiers of a block that are written twice.
    pub(super) fn repeated(&self, qualifiers: &Qualifiers<'a>) -> Vec<Diagnostic> {
        let mut found = self.excluding(qualifiers);
        found.retain(|error| error.message.ends_with("written twice"));
        found
    }

    /// Adds what a variable's storage forbids: types, stages, versions.
    fn storage_of_variables(
        &self,
        declaration: &Declaration<'a>,
        kind: Option<&Builtin>,
        found: &mut Vec<Diagnostic>,
    ) {
        let Declaration { qualifiers, ty, names, .. } = declaration;
        let of_type = self.parser.tokens()[ty.at];
        let at = |words: &[&str]| self.words(qualifiers).find(|token| words.contains(&token.text));
        let mut refuse = |token: &Token<'a>, message: String, note: &str| {
            let error = diagnostic_at(token, Code::LayoutQualifier, message);
            found.push(if note.is_empty() { error } else { error.with_note(note) });
        };
        if let Some(token) = at(&["inout"]) {
            let note = "GLSL 4.60 §4.6: `inout` qualifies parameters";
            refuse(&token, "`inout` is not allowed at global scope".to_string(), note);
        }
        if let (Storage::Buffer, Some(token)) = (qualifiers.storage, at(&["buffer"])) {
            let note = "GLSL 4.60 §4.3.7: `buffer` declares blocks";
            refuse(&token, "`buffer` is not allowed on a variable".to_string(), note);
        }
        if matches!(kind, Some(Builtin::Void)) {
            let message = format!("`{}` has the type `void`", names[0].name.text);
            refuse(&of_type, message, "GLSL 4.60 §4.1.1: `void` is the type of no variable");
        }
        let opaque = matches!(kind, Some(Builtin::Opaque));
        let handle = matches!(qualifiers.storage, Storage::Uniform | Storage::Foreign);
        if opaque && !handle && !self.is_bindless() {
            let message = format!(
                "`{}` has the opaque type `{}`, but is no uniform",
                names[0].name.text, of_type.text
            );
            refuse(
                &of_type,
                message,
                "GLSL 4.60 §4.1.7: opaque types are of uniforms and parameters",
            );
        }
        let passed = matches!(qualifiers.storage, Storage::In | Storage::Out | Storage::Varying);
        if let (true, Some(Builtin::Data(data))) = (passed, kind) {
            self.passed_type(declaration, data, &mut refuse);
        }
        // Only stages whose interface leaves no doubt; `shared` is of compute, task and mesh
        // shaders, `patch` of tessellation.
        let unsuitable = match self.stage {
            Some(Stage::Vertex | Stage::Fragment) => at(&["shared", "patch"]),
            Some(Stage::Compute) => at(&["in", "out", "patch", "attribute", "varying"]),
            _ => None,
        };
        let predeclared = names.iter().any(|name| name.name.text.starts_with("gl_"));
        if let (Some(token), Some(stage), false) = (unsuitable, self.stage, predeclared) {
            let message = format!("`{}` is not allowed in a {} shader", token.text, stage.name());
            refuse(&token, message, "");
        }
    }

    /// Reports the type of an input or output that its stage does not pass (GLSL 4.60 §4.3.4,
    /// §4.3.6).
    fn passed_type(
        &self,
        declaration: &Declaration<'a>,
        data: &Type,
        refuse: &mut impl FnMut(&Token<'a>, String, &str),
    ) {
        let Declaration { qualifiers, ty, names, .. } = declaration;
        let token = self.parser.tokens()[ty.at];
        let name = names[0].name.text;
        let (scalar, matrix) = match data {
            Type::Scalar(scalar) | Type::Vector { scalar, .. } => (*scalar, false),
            Type::Matrix { scalar, .. } => (*scalar, true),
            Type::Atomic(_) | Type::Address(_) | Type::Struct(_) | Type::Array { .. } => return,
        };
        let output = qualifiers.storage == Storage::Out;
        let fragment = self.stage == Some(Stage::Fragment);
        if scalar.kind == ScalarKind::Bool {
            let message = format!("input or output `{name}` has the type `{}`", token.text);
            refuse(&token, message, "GLSL 4.60 §4.3.4, §4.3.6: no stage passes booleans");
        } else if fragment && output && (matrix || scalar.width == 8) {
            let message =
                format!("output `{name}` of a fragment shader has the type `{}`", token.text);
            refuse(&token, message, "GLSL 4.60 §4.3.6: scalars and vectors of 32 bits are written");
        } else if fragment && !output && !qualifiers.flat && !name.starts_with("gl_") {
            let whole = matches!(scalar.kind, ScalarKind::Sint | ScalarKind::Uint);
            // `perprimitiveEXT`, `pervertexEXT` and the like replace interpolation.
            let foreign = self.words(qualifiers).any(|token| token.text.starts_with("per"));
            if (whole || scalar.width == 8) && !foreign {
                let message = format!("input `{name}` of type `{}` is not `flat`", token.text);
                refuse(
                    &token,
                    message,
                    "GLSL 4.60 §4.3.4: integers and doubles are not interpolated",
                );
            }
        }
    }

    /// Whether a variable may have an entry of `layout(…)`.
    // The table of GLSL 4.60 §4.4: `location` on what passes between stages and on uniforms,
    // `component` and `index` only beside it, `binding` on blocks and handles, `offset` on atomic
    // counters.
    fn is_allowed(
        &self,
        id: &LayoutId<'a>,
        qualifiers: &Qualifiers<'a>,
        kind: Option<&Builtin>,
        ty: usize,
    ) -> bool {
        let storage = qualifiers.storage;
        let uniform = matches!(storage, Storage::Uniform | Storage::Buffer);
        let data = matches!(kind, Some(Builtin::Data(_)));
        if id.is_among(OF_BLOCKS) || id.is_among(ALONE) {
            return false;
        }
        if id.is_among(&["location", "component", "index"]) {
            let nowhere = matches!(storage, Storage::Plain | Storage::Const | Storage::Shared);
            return !nowhere && (id.is("location") || qualifiers.find("location").is_some());
        }
        if id.is_among(&["binding", "set"]) {
            let resource = uniform || storage == Storage::Foreign;
            return resource && !(id.is("binding") && data && storage == Storage::Uniform);
        }
        if id.is("offset") {
            return !data && self.parser.tokens()[ty].is("atomic_uint");
        }
        if id.is("constant_id") {
            return qualifiers.constant && matches!(kind, Some(Builtin::Data(Type::Scalar(_))));
        }
        true
    }

    /// Returns what no compiler takes in `layout(…) in;` and the like (GLSL 4.60 §4.4).
    pub(super) fn illegal_defaults(&self, qualifiers: &Qualifiers<'a>) -> Vec<Diagnostic> {
        let mut found = self.excluding(qualifiers);
        let memory = matches!(qualifiers.storage, Storage::Uniform | Storage::Buffer);
        for id in &qualifiers.layout {
            let token = self.parser.token_of(&id.name);
            let rules = id.is_among(&["std140", "std430", "scalar", "shared", "packed"]);
            if (rules || id.is_among(&["row_major", "column_major"])) && !memory {
                let error =
                    self.not_allowed(&token, "defaults of anything but `uniform` and `buffer`");
                found.push(error);
            } else if id.is_among(ALONE) && qualifiers.storage != Storage::In {
                found.push(self.not_allowed(&token, "anything but `in`"));
            } else if id.is_among(&["location", "component", "index", "constant_id"]) {
                found.push(self.not_allowed(&token, "a declaration without a variable"));
            }
        }
        found
    }

    /// `precision mediump float;` (GLSL 4.60 §4.7.4)
    pub(super) fn illegal_precision(&self, tokens: &Tokens) -> Option<Diagnostic> {
        let tokens = self.parser.tokens().get(tokens.clone())?;
        let (word, ty) = (tokens.get(1)?, tokens.get(2)?);
        if !matches!(word.text, "lowp" | "mediump" | "highp") {
            let message = format!("`{}` is no precision", word.text);
            let error = diagnostic_at(word, Code::Syntax, message);
            return Some(error.with_help("write `lowp`, `mediump` or `highp`"));
        }
        let takes = matches!(ty.text, "float" | "int" | "atomic_uint")
            || matches!(builtin(ty.text), Some(Builtin::Opaque));
        (!takes).then(|| {
            let message = format!("`{}` has no default precision", ty.text);
            let help = "name `float`, `int`, a sampler or an image";
            diagnostic_at(ty, Code::Syntax, message).with_help(help)
        })
    }

    /// Returns qualifiers that no member of a structure has (GLSL 4.60 §4.1.8).
    pub(super) fn illegal_in_structure(&self, qualifiers: &Qualifiers<'a>) -> Vec<Diagnostic> {
        let classes = [STORAGE, INTERPOLATION, MEMORY, &["centroid", "sample", "patch"]];
        let of = |token: &Token<'a>| classes.iter().any(|class| class.contains(&token.text));
        let words = self.words(qualifiers).filter(of);
        words.map(|token| self.not_allowed(&token, "a member of a structure")).collect()
    }

    pub(super) fn is_bindless(&self) -> bool {
        self.parser.extensions().iter().any(|name| name.ends_with("bindless_texture"))
    }
}
