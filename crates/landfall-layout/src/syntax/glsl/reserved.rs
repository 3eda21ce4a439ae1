//! Names that declarations may not have, and types that need a version or an extension.

use super::ast::{BlockDecl, Item, Name, TypeBase};
use super::declarations::DeclarationReader;
use super::lexer::Token;
use super::report::diagnostic_at;
use super::types::builtin;
use crate::Severity;
use crate::diagnostic::{Code, Diagnostic};
use crate::text::word_filter::WordFilter;

/// Keywords of every version of desktop GLSL and of GLSL ES (GLSL 1.10 §3.6, GLSL 4.60 §3.6).
const KEYWORDS: &[&str] = &[
    "attribute",
    "break",
    "case",
    "const",
    "continue",
    "default",
    "discard",
    "do",
    "else",
    "false",
    "for",
    "goto",
    "if",
    "in",
    "inout",
    "out",
    "return",
    "struct",
    "switch",
    "true",
    "uniform",
    "varying",
    "void",
    "while",
];

/// Types of every version, whose names are keywords as well.
const TYPES: &[&str] = &[
    "bool",
    "bvec2",
    "bvec3",
    "bvec4",
    "float",
    "int",
    "ivec2",
    "ivec3",
    "ivec4",
    "mat2",
    "mat3",
    "mat4",
    "sampler2D",
    "samplerCube",
    "vec2",
    "vec3",
    "vec4",
];

/// Types by the beginnings of their names; parts of the names of extensions that have them, the
/// first of which is suggested.
const EXTENSIONS_OF_TYPES: &[(&[&str], &[&str])] = &[
    (
        &["float16_t", "f16vec", "f16mat"],
        &[
            "GL_EXT_shader_explicit_arithmetic_types_float16",
            "16bit_storage",
            "explicit_arithmetic_types",
            "half_float",
            "subgroup_extended_types",
            "gpu_shader5",
        ],
    ),
    (
        &["int8_t", "uint8_t", "i8vec", "u8vec"],
        &[
            "GL_EXT_shader_explicit_arithmetic_types_int8",
            "8bit_storage",
            "explicit_arithmetic_types",
            "subgroup_extended_types",
            "gpu_shader5",
        ],
    ),
    (
        &["int16_t", "uint16_t", "i16vec", "u16vec"],
        &[
            "GL_EXT_shader_explicit_arithmetic_types_int16",
            "16bit_storage",
            "explicit_arithmetic_types",
            "int16",
            "subgroup_extended_types",
            "gpu_shader5",
        ],
    ),
    (
        &["int64_t", "uint64_t", "i64vec", "u64vec"],
        &[
            "GL_EXT_shader_explicit_arithmetic_types_int64",
            "explicit_arithmetic_types",
            "int64",
            "gpu_shader5",
        ],
    ),
    (
        &[
            "float32_t",
            "float64_t",
            "f32vec",
            "f64vec",
            "f32mat",
            "f64mat",
            "int32_t",
            "uint32_t",
            "i32vec",
            "u32vec",
        ],
        &["GL_EXT_shader_explicit_arithmetic_types", "explicit_arithmetic_types", "gpu_shader5"],
    ),
];

impl<'a> DeclarationReader<'a> {
    /// Returns an error if a name is a keyword.
    pub(super) fn keyword(&self, name: &Name<'a>) -> Option<Diagnostic> {
        let text = name.text;
        const FILTER: WordFilter = WordFilter::NONE.with(KEYWORDS).with(TYPES);
        if !FILTER.may_contain(text) || !KEYWORDS.contains(&text) && !TYPES.contains(&text) {
            return None;
        }
        let token = self.parser.token_of(name);
        let found =
            diagnostic_at(&token, Code::Syntax, format!("`{text}` is a keyword, not a name"));
        Some(found.with_note("GLSL 4.60 §3.6"))
    }

    /// Reports names of a declaration outside blocks that are keywords.
    pub(super) fn check_names(&mut self, item: &Item<'a>) {
        let Item::Variables(declaration) = item else { return };
        let mut names: Vec<Name<'a>> = declaration.names.iter().map(|name| name.name).collect();
        if let TypeBase::Struct(structure) = &declaration.ty.base {
            names.extend((!structure.name.text.is_empty()).then_some(structure.name));
            names.extend(structure.members.iter().flat_map(|m| &m.names).map(|name| name.name));
        }
        let found: Vec<_> = names.iter().filter_map(|name| self.keyword(name)).collect();
        self.report_all(found);
    }

    /// Returns the names of a block that it may not have.
    pub(super) fn reserved_names(&self, block: &BlockDecl<'a>) -> Vec<Diagnostic> {
        let members = block.members.iter().flat_map(|member| &member.names);
        let all = [Some(block.name), block.instance].into_iter().flatten();
        let all = all.chain(members.map(|member| member.name));
        let refuse = |name: Name<'a>| {
            let gl = name.text.starts_with("gl_").then(|| {
                let message = format!("`{}` begins with `gl_`, which is reserved", name.text);
                diagnostic_at(&self.parser.token_of(&name), Code::Syntax, message)
                    .with_note("GLSL 4.60 §3.7: such names are the language's own")
            });
            gl.or_else(|| self.keyword(&name))
        };
        all.filter_map(refuse).collect()
    }

    /// Warns once of a type that the version does not have; drivers may take it.
    pub(super) fn check_type(&mut self, token: &Token<'a>) {
        let name = token.text;
        // Few names come this far.
        let odd = name.starts_with(['d', 'f', 'i', 'u']);
        if !odd || matches!(name, "float" | "int" | "uint") {
            return;
        }
        if self.types.contains_key(name) || builtin(name).is_none() {
            return;
        }
        let preprocessor = self.parser.preprocessor();
        let version = preprocessor.version;
        if !preprocessor.version_declared {
            return;
        }
        let has = |part: &str| {
            preprocessor.extensions.iter().any(|own| *own == "all" || own.contains(part))
        };
        // Doubles are in GLSL 4.00 itself; the sized types of other widths are in no version, only
        // in extensions.
        let double = ["double", "dvec", "dmat"].iter().any(|start| name.starts_with(start));
        let lacking = if double && (version.es || version.number < 400) {
            if has("fp64") || has("64bit") {
                return;
            }
            match version.es {
                true => ("GLSL ES does not have it".to_string(), "use `float`".to_string()),
                false => (
                    "it needs `#version 400`".to_string(),
                    "or write `#extension GL_ARB_gpu_shader_fp64 : enable`".to_string(),
                ),
            }
        } else {
            let of = |row: &&(&[&str], &[&str])| row.0.iter().any(|start| name.starts_with(start));
            let Some((_, extensions)) = EXTENSIONS_OF_TYPES.iter().find(of) else { return };
            if extensions.iter().any(|part| has(part)) {
                return;
            }
            let extension = extensions[0];
            let help = format!("write `#extension {extension} : require`");
            ("it needs an extension that is not enabled".to_string(), help)
        };
        let message = format!("type `{name}` is not in this version of GLSL: {}", lacking.0);
        if self.parser.diagnostics().iter().any(|found| found.message == message) {
            return;
        }
        let mut warning = diagnostic_at(token, Code::Version, message).with_help(lacking.1);
        warning.severity = Severity::Warning;
        self.report(warning);
    }
}
