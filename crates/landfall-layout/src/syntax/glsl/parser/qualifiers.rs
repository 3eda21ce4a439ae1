//! Qualifiers and default precisions (GLSL 4.60 §4.3 to §4.10).

use super::Parser;
use crate::Severity;
use crate::diagnostic::Code;
use crate::syntax::glsl::ast::{LayoutId, Name, PrecisionQualifier, Qualifiers, Storage};
use crate::syntax::glsl::layout_ids;
use crate::syntax::glsl::lexer::Kind;
use crate::syntax::glsl::qualifiers::{OTHER_STORAGE, is_qualifier};
use crate::syntax::glsl::report::diagnostic_at;

/// Whether a qualifier may form a declaration of its own: `layout(…) in;`.
fn is_alone(word: &str) -> bool {
    matches!(word, "in" | "out" | "uniform" | "buffer")
}

fn precision(word: &str) -> Option<PrecisionQualifier> {
    match word {
        "lowp" => Some(PrecisionQualifier::Low),
        "mediump" => Some(PrecisionQualifier::Medium),
        "highp" => Some(PrecisionQualifier::High),
        _ => None,
    }
}

impl<'a> Parser<'a> {
    // type_qualifier: single_type_qualifier { single_type_qualifier }
    // single_type_qualifier: storage_qualifier | layout_qualifier | precision_qualifier
    //     | interpolation_qualifier | invariant_qualifier | precise_qualifier
    // In any order and number, as from GLSL 4.20 on (§4.12); earlier versions have a fixed order,
    // which is not checked.
    pub(super) fn qualifiers(&mut self) -> Qualifiers<'a> {
        let mut qualifiers = Qualifiers { tokens: self.at..self.at, ..Qualifiers::default() };
        self.written = None;
        while self.token().kind == Kind::Name {
            let word = self.token().text;
            match word {
                "layout" => {
                    self.bump();
                    self.layout_ids(&mut qualifiers.layout);
                }
                // GL_EXT_spirv_intrinsics: `spirv_instruction(…)`, `spirv_decorate(…)` and so on.
                _ if word == "subroutine" || word.starts_with("spirv_") => {
                    qualifiers.subroutine |= word == "subroutine";
                    self.bump();
                    if self.is("(") {
                        self.skip_balanced();
                    }
                }
                _ if is_qualifier(word) || self.qualifier_macros.contains(word) => {
                    self.qualify(&mut qualifiers, word);
                    self.bump();
                }
                _ => break,
            }
            qualifiers.any = true;
        }
        qualifiers.tokens.end = self.at;
        qualifiers
    }

    fn qualify(&mut self, qualifiers: &mut Qualifiers<'a>, word: &str) {
        let storage = match word {
            "flat" => return qualifiers.flat = true,
            "noperspective" => return qualifiers.noperspective = true,
            "centroid" => return qualifiers.centroid = true,
            "sample" => return qualifiers.sample = true,
            "patch" => return qualifiers.patch = true,
            "lowp" | "mediump" | "highp" => return self.written = precision(word),
            "readonly" => return qualifiers.readonly = true,
            "writeonly" => return qualifiers.writeonly = true,
            // `const in float x` is an input that is not written (§4.6).
            "const" => {
                qualifiers.constant = true;
                match qualifiers.storage {
                    Storage::Plain => Storage::Const,
                    other => other,
                }
            }
            "uniform" => Storage::Uniform,
            // Two storage qualifiers are an error; that of a block takes precedence.
            _ if matches!(qualifiers.storage, Storage::Uniform | Storage::Buffer) => return,
            "buffer" => Storage::Buffer,
            "in" | "attribute" => Storage::In,
            "out" => Storage::Out,
            "inout" => Storage::InOut,
            "varying" => self.varying,
            "shared" => Storage::Shared,
            _ if OTHER_STORAGE.contains(&word) => Storage::Foreign,
            _ => return,
        };
        qualifiers.storage = storage;
    }

    /// Whether a qualifier is next; in old versions some are names, such as `sample`.
    // A qualifier is followed by another, a type, its arguments, a block, or ends a declaration
    // like `in;`. An expression such as `sample = 2.0;` has none of these next.
    pub(super) fn stands_qualifier(&mut self) -> bool {
        let word = self.token().text;
        let wordy = is_qualifier(word) || matches!(word, "layout" | "subroutine");
        if !wordy && !word.starts_with("spirv_") {
            return false;
        }
        let next = self.ahead(1);
        next.kind == Kind::Name || next.is("(") || next.is("{") || (next.is(";") && is_alone(word))
    }

    /// Parses `( NAME [= EXPRESSION] , … )`.
    // layout_qualifier:
    //     LAYOUT LEFT_PAREN layout_qualifier_id { COMMA layout_qualifier_id } RIGHT_PAREN
    // layout_qualifier_id: IDENTIFIER [EQUAL constant_expression] | SHARED
    fn layout_ids(&mut self, ids: &mut Vec<LayoutId<'a>>) {
        if !self.expect_or_report("(") {
            return;
        }
        loop {
            if self.token().kind != Kind::Name {
                let token = *self.token();
                let message = match token.kind {
                    Kind::End => "`layout(…)` is not closed".to_string(),
                    _ => format!("`layout(…)` has an unexpected `{}`", token.text),
                };
                self.report(diagnostic_at(&token, Code::Syntax, message));
                break;
            }
            let name = self.name_here();
            let (mut tokens, mut value) = (self.at..self.at, None);
            if self.eat("=") {
                (tokens, value) = self.code(&[",", ")"]);
            }
            self.check_layout_id(&name);
            ids.push(LayoutId { name, tokens, value });
            if !self.eat(",") {
                break;
            }
        }
        self.expect_or_report(")");
    }

    /// Reports an unknown identifier in `layout(…)`: an error if it resembles a known one, a
    /// warning if it may belong to an unknown extension.
    fn check_layout_id(&mut self, name: &Name<'a>) {
        let text = name.text.to_ascii_lowercase();
        // Where macros are not expanded, a name may stand for an identifier.
        if layout_ids::is_known(&text) || self.preprocessor.is_none() {
            return;
        }
        let message = format!("unknown layout qualifier `{}`", name.text);
        let token = self.token_of(name);
        let mut diagnostic = diagnostic_at(&token, Code::LayoutQualifier, message);
        match layout_ids::suggestion(&text) {
            Some(help) => self.report(diagnostic.with_help(help)),
            None => {
                diagnostic.severity = Severity::Warning;
                let note = "assumed to belong to an extension and not to affect the layout";
                self.preprocessor().diagnostics.push(diagnostic.with_note(note));
            }
        }
    }

    // PRECISION precision_qualifier type_specifier SEMICOLON
    // Of the types that it may name (§4.7.4), only floats and the samplers that have a default are
    // followed.
    pub(super) fn precision_statement(&mut self) {
        let precision = precision(self.ahead(1).text);
        if let Some(precision) = precision {
            match self.ahead(2).text {
                "float" => self.precisions.float = Some(precision),
                "sampler2D" | "samplerCube" => self.precisions.sampled = precision,
                _ => {}
            }
        }
        match self.direct {
            true => self.skip_to_semicolon(),
            false => self.skip_statement(),
        }
    }

    /// Returns the precision of a type: the one written before it, or the default.
    pub(super) fn precision_of(
        &self,
        written: Option<PrecisionQualifier>,
        name: &str,
    ) -> Option<PrecisionQualifier> {
        if !self.has_precisions {
            return None;
        }
        match name {
            "sampler2D" | "samplerCube" => written.or(Some(self.precisions.sampled)),
            _ if is_float(name) => written.or(self.precisions.float),
            _ if name.starts_with("sampler") => written,
            _ => None,
        }
    }
}

/// Whether a type holds floats, whose default precision is set by `precision … float;`.
pub(super) fn is_float(name: &str) -> bool {
    name == "float" || name.starts_with("vec") || name.starts_with("mat")
}
