//! Heads of functions and names that no compiler takes: types that are not declared, parameters
//! that are not parameters, and requalified names of nothing.

use super::ast::{FunctionDecl, Name, Qualifiers, Tokens};
use super::declarations::DeclarationReader;
use super::lexer::{Kind, Token};
use super::qualifiers::is_qualifier;
use super::report::diagnostic_at;
use super::types::builtin;
use crate::Severity;
use crate::diagnostic::{Code, Diagnostic};

/// Whether a name has the form of a type that an extension declares.
// Extensions declare more types than are listed in `types`, so a name of this form is not called
// unknown.
pub(super) fn may_be_of_extension(name: &str) -> bool {
    let ends = ["EXT", "NV", "KHR", "ARM", "QCOM", "AMD", "ARB", "OES", "HUAWEI"];
    let starts = [
        "coopmat",
        "fcoopmat",
        "icoopmat",
        "ucoopmat",
        "rayQuery",
        "hitObject",
        "tensor",
        "spirv_",
    ];
    ends.iter().any(|end| name.ends_with(end)) || starts.iter().any(|start| name.starts_with(start))
}

impl<'a> DeclarationReader<'a> {
    /// Reports what no compiler takes in the head of a function (GLSL 4.60 §6.1).
    // Only the head: the body may have been skipped, so `name_errors` looks at its locals.
    pub(super) fn check_function(&mut self, function: &FunctionDecl<'a>) {
        let returns = self.parser.tokens()[function.returns.at];
        self.check_declared_type(&returns);
        self.check_main(function, &returns);
        let parameters = self.parameters(&function.parameter_tokens);
        let alone = parameters.len() == 1;
        for parameter in parameters {
            if parameter.is_empty() && alone {
                continue;
            }
            if let Some(error) = self.illegal_parameter(&parameter, alone) {
                self.report(error);
                continue;
            }
            let ty =
                self.parser.tokens()[parameter].iter().find(|t| !is_qualifier(t.text)).copied();
            if let Some(ty) = ty {
                self.check_declared_type(&ty);
            }
        }
    }

    /// Reports an entry point with a result or parameters.
    fn check_main(&mut self, function: &FunctionDecl<'a>, returns: &Token<'a>) {
        if function.name.text != "main" || !self.is_complete() {
            return;
        }
        let parameters = &self.parser.tokens()[function.parameter_tokens.clone()];
        let (token, what) = match parameters {
            _ if returns.text != "void" => (*returns, "a result"),
            [] => return,
            [void] if void.text == "void" => return,
            [first, ..] => (*first, "parameters"),
        };
        let message = format!("`main` has {what}: the entry point is `void main()`");
        let error = diagnostic_at(&token, Code::Syntax, message);
        self.report(error.with_note("GLSL 4.60 §6.1: function definitions"));
    }

    // As token ranges, since the parser of parameters stops at the first error, and types of
    // extensions (`coopmat<float, 8>`) have commas in `<…>`.
    fn parameters(&self, tokens: &Tokens) -> Vec<Tokens> {
        let (mut found, mut depth, mut start) = (Vec::new(), 0u32, tokens.start);
        for at in tokens.clone() {
            match self.parser.tokens()[at].text {
                "(" | "[" | "{" | "<" => depth += 1,
                ")" | "]" | "}" | ">" => depth = depth.saturating_sub(1),
                "," if depth == 0 => {
                    found.push(start..at);
                    start = at + 1;
                }
                _ => {}
            }
        }
        found.push(start..tokens.end);
        found
    }

    /// Returns what is wrong with the form of `QUALIFIERS TYPE [N] NAME [N]`.
    // parameter_declaration: [type_qualifier] type_specifier [IDENTIFIER [array_specifier]]
    fn illegal_parameter(&self, parameter: &Tokens, alone: bool) -> Option<Diagnostic> {
        let tokens = &self.parser.tokens()[parameter.clone()];
        let syntax = |token: &Token<'a>, message: String| {
            Some(
                diagnostic_at(token, Code::Syntax, message).with_note("GLSL 4.60 §6.1: parameters"),
            )
        };
        let end = self.parser.tokens().get(parameter.end)?;
        // `layout(…)` and the like are of extensions.
        if tokens.iter().any(|t| matches!(t.text, "layout" | "<") || t.text.starts_with("spirv_")) {
            return None;
        }
        let count = tokens.iter().take_while(|token| is_qualifier(token.text)).count();
        let (words, rest) = tokens.split_at(count);
        for (at, word) in words.iter().enumerate() {
            let twice = words[..at].iter().any(|before| before.text == word.text);
            let foreign = matches!(
                word.text,
                "uniform"
                    | "buffer"
                    | "shared"
                    | "attribute"
                    | "varying"
                    | "flat"
                    | "smooth"
                    | "noperspective"
                    | "centroid"
                    | "sample"
                    | "patch"
            );
            let precision = matches!(word.text, "lowp" | "mediump" | "highp");
            if twice && !precision {
                return syntax(word, format!("`{}` is written twice", word.text));
            }
            if foreign {
                return syntax(word, format!("`{}` is not allowed on a parameter", word.text));
            }
        }
        let Some(ty) = rest.first() else {
            return syntax(end, "a parameter has no type".to_string());
        };
        if ty.kind != Kind::Name || ty.text == "struct" {
            return syntax(ty, format!("unexpected `{}` in a parameter", ty.text));
        }
        let rest = without_dimensions(&rest[1..]);
        if ty.text == "void" && !(alone && rest.is_empty()) {
            return syntax(ty, "a parameter has the type `void`".to_string());
        }
        let name = rest.first()?;
        if name.kind != Kind::Name {
            return syntax(name, format!("unexpected `{}` in a parameter", name.text));
        }
        let at = parameter.end - rest.len();
        let keyword = self.keyword(&Name { text: name.text, span: name.span, at });
        if keyword.is_some() || name.text == ty.text && builtin(name.text).is_some() {
            return syntax(name, format!("`{}` is a keyword, not a name", name.text));
        }
        let after = without_dimensions(&rest[1..]).first()?;
        syntax(after, format!("unexpected `{}` in a parameter", after.text))
    }

    /// Reports a type that is not declared or not in this version, in a shader that stands alone:
    /// others may be parts of one.
    pub(super) fn check_declared_type(&mut self, token: &Token<'a>) {
        let name = token.text;
        if !self.is_complete() || token.kind != Kind::Name || name == "struct" {
            return;
        }
        if self.types.contains_key(name) {
            return;
        }
        if builtin(name).is_some() {
            return self.check_type(token);
        }
        if !may_be_of_extension(name) {
            self.report(self.unknown_type(token));
        }
    }

    /// Whether a name that is not declared so far is an error of its own: in the shader of a stage,
    /// without an error before, such as a file that was not found.
    fn is_complete(&self) -> bool {
        let error = |found: &Diagnostic| found.severity == Severity::Error;
        self.stage.is_some() && !self.parser.diagnostics().iter().any(error)
    }

    /// Reports `QUALIFIERS NAME;` of a name that is not declared: its type is missing.
    pub(super) fn check_requalified(&mut self, qualifiers: &Qualifiers<'a>, name: &Name<'a>) {
        let reference = qualifiers.find("buffer_reference").is_some();
        let known = name.text.starts_with("gl_") || self.globals.has(name.text);
        if !self.is_complete() || reference || known || builtin(name.text).is_some() {
            return;
        }
        let message = format!("`{}` has no type, and is not declared before", name.text);
        let error = diagnostic_at(&self.parser.token_of(name), Code::Syntax, message);
        self.report(error.with_help(format!("write its type before `{}`", name.text)));
    }
}

/// Returns what follows any number of `[…]`.
fn without_dimensions<'t, 'a>(tokens: &'t [Token<'a>]) -> &'t [Token<'a>] {
    let mut depth = 0u32;
    let end = tokens.iter().position(|token| {
        match token.text {
            "[" => depth += 1,
            "]" => depth = depth.saturating_sub(1),
            _ => return depth == 0,
        }
        false
    });
    &tokens[end.unwrap_or(tokens.len())..]
}
