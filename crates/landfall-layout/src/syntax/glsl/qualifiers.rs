//! The qualifiers in front of a declaration (GLSL 4.60 §4.3 to §4.10).

use super::declarations::Reader;
use super::lexer::{Kind, Token};
use crate::diagnostic::Code;
use crate::diagnostic::Diagnostic;

/// What the qualifiers of a declaration say.
#[derive(Clone, Debug, Default)]
pub struct Qualifiers<'a> {
    /// Whether there is any.
    pub any: bool,
    /// `uniform`.
    pub uniform: bool,
    /// `buffer`.
    pub buffer: bool,
    /// `const`.
    pub constant: bool,
    /// `in`, `out`, `varying`, `shared` and other storage without a layout in bytes.
    pub other_storage: bool,
    /// `subroutine`.
    pub subroutine: bool,
    /// What stands in `layout(…)`, in order.
    pub layout: Vec<LayoutId<'a>>,
}

/// One entry of `layout(…)`.
#[derive(Clone, Debug)]
pub struct LayoutId<'a> {
    /// Its name.
    pub name: Token<'a>,
    /// The expression after `=`.
    pub value: Vec<Token<'a>>,
}

impl LayoutId<'_> {
    /// Whether it is of that name; names in `layout(…)` are not case sensitive (§4.4).
    pub fn is(&self, name: &str) -> bool {
        self.name.text.eq_ignore_ascii_case(name)
    }
}

impl<'a> Qualifiers<'a> {
    /// The last layout entry of that name: later ones override earlier ones.
    pub fn find(&self, name: &str) -> Option<&LayoutId<'a>> {
        self.layout.iter().rev().find(|id| id.is(name))
    }
}

/// Words that qualify a declaration and say nothing of its bytes.
pub const SILENT: &[&str] = &[
    "flat",
    "smooth",
    "noperspective",
    "centroid",
    "sample",
    "patch",
    "invariant",
    "precise",
    "lowp",
    "mediump",
    "highp",
    "superp",
    "coherent",
    "volatile",
    "restrict",
    "readonly",
    "writeonly",
    "devicecoherent",
    "queuefamilycoherent",
    "workgroupcoherent",
    "subgroupcoherent",
    "shadercallcoherent",
    "nonprivate",
    "nontemporal",
    "nonuniformEXT",
    "perprimitiveNV",
    "perprimitiveEXT",
    "perviewNV",
    "pervertexNV",
    "pervertexEXT",
    "__explicitInterpAMD",
];

/// Words for storage that has no layout in bytes.
pub const OTHER_STORAGE: &[&str] = &[
    "in",
    "out",
    "inout",
    "attribute",
    "varying",
    "shared",
    "rayPayloadEXT",
    "rayPayloadInEXT",
    "rayPayloadNV",
    "rayPayloadInNV",
    "hitAttributeEXT",
    "hitAttributeNV",
    "callableDataEXT",
    "callableDataInEXT",
    "callableDataNV",
    "callableDataInNV",
    "hitObjectAttributeEXT",
    "hitObjectAttributeNV",
    "taskNV",
    "taskPayloadSharedEXT",
    "tileImageEXT",
];

/// Whether a word may stand among the qualifiers in front of a type.
pub(crate) fn is_qualifier(word: &str) -> bool {
    ["const", "uniform", "buffer"].contains(&word)
        || OTHER_STORAGE.contains(&word)
        || SILENT.contains(&word)
}

impl<'a> Reader<'a> {
    /// Reads qualifiers as long as there are some.
    pub(super) fn qualifiers(&mut self) -> Qualifiers<'a> {
        let mut qualifiers = Qualifiers::default();
        while self.token.kind == Kind::Name {
            match self.token.text {
                "uniform" => qualifiers.uniform = true,
                "buffer" => qualifiers.buffer = true,
                "const" => qualifiers.constant = true,
                "layout" => {
                    qualifiers.any = true;
                    self.bump();
                    self.layout_ids(&mut qualifiers.layout);
                    continue;
                }
                "subroutine" => {
                    qualifiers.subroutine = true;
                    qualifiers.any = true;
                    self.bump();
                    if self.token.is("(") {
                        self.skip_balanced();
                    }
                    continue;
                }
                // GL_EXT_spirv_intrinsics: `spirv_instruction(…)`, `spirv_decorate(…)` and so on.
                word if word.starts_with("spirv_") => {
                    qualifiers.any = true;
                    self.bump();
                    if self.token.is("(") {
                        self.skip_balanced();
                    }
                    continue;
                }
                word if OTHER_STORAGE.contains(&word) => qualifiers.other_storage = true,
                word if SILENT.contains(&word) => {}
                _ => break,
            }
            qualifiers.any = true;
            self.bump();
        }
        qualifiers
    }

    /// `( NAME [= EXPRESSION] , … )`
    fn layout_ids(&mut self, ids: &mut Vec<LayoutId<'a>>) {
        if !self.expect("(") {
            return;
        }
        while !self.token.is(")") {
            if self.token.kind != Kind::Name {
                let message = format!("`layout(…)` has an unexpected `{}`", self.token.text);
                self.report_at(&self.token.clone(), Code::Syntax, message);
                break;
            }
            let name = self.bump();
            let mut value = Vec::new();
            if self.token.is("=") {
                self.bump();
                value = self.collect_until(&[",", ")"]);
            }
            ids.push(LayoutId { name, value });
            if !self.token.is(",") {
                break;
            }
            self.bump();
        }
        self.expect(")");
    }

    /// The value of a layout entry, a whole number from 0.
    pub(super) fn layout_number(&mut self, id: &LayoutId<'a>) -> Result<u64, Diagnostic> {
        let name = id.name;
        if id.value.is_empty() {
            let message = format!("`{}` wants a number: `{} = N`", name.text, name.text);
            return Err(self.diagnostic(&name, Code::LayoutQualifier, message));
        }
        let value = self.constant_integer(&id.value, name.span);
        let value = value.map_err(|problem| {
            let message = format!("the value of `{}` {}", name.text, problem.message);
            Diagnostic::error(Code::LayoutQualifier, problem.span, message)
        })?;
        u64::try_from(value).map_err(|_| {
            let message = format!("`{} = {value}` is negative", name.text);
            self.diagnostic(&id.value[0], Code::LayoutQualifier, message)
        })
    }
}
