//! Preprocessor directives (GLSL 4.60 §3.3): lines that begin with `#`. They change what the
//! preprocessor knows and which text it reads, and yield no tokens.

use std::rc::Rc;

use rustc_hash::FxHashSet;

use super::dialect::GODOT_LINES;
use super::evaluate::{Names, Problem, evaluate_tokens};
use super::lexer::{Kind, Lexer, Stop, Token};
use super::macros::Macro;
use super::preprocess::{Preprocessor, Profile, TokenSource, Version};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::{Span, Target};
use crate::syntax::constant::Value;

/// An `#if` that is still open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Condition {
    span: Span,
    /// Whether one of its branches was taken.
    taken: bool,
    /// Whether it is past its `#else`.
    in_else: bool,
}

/// The version assumed for an unknown one.
const NEWEST: u32 = 460;

/// Known versions (GLSL 4.60 §3.3, GLSL ES 3.20 §3.4), whether they are ES, and their text.
const VERSIONS: &[(u32, bool, &str)] = &[
    (100, true, "100"),
    (110, false, "110"),
    (120, false, "120"),
    (130, false, "130"),
    (140, false, "140"),
    (150, false, "150"),
    (300, true, "300"),
    (310, true, "310"),
    (320, true, "320"),
    (330, false, "330"),
    (400, false, "400"),
    (410, false, "410"),
    (420, false, "420"),
    (430, false, "430"),
    (440, false, "440"),
    (450, false, "450"),
    (460, false, "460"),
];

impl<'a> Preprocessor<'a> {
    /// Defines the macros of the command line and of the language.
    // Each is a file of its own, `-D NAME`, so that spans in it can be shown.
    pub(super) fn define_given(&mut self) {
        for (name, text) in &self.options.defines {
            let text = self.keep(&format!("{name} {text}"));
            let path = format!("-D {name}");
            let file = self.files.add(path, text.into());
            self.define_from(Lexer::new(text, file));
        }
    }

    /// Returns the text of a predefined macro, unless the shader undefined it.
    // Computed at each use: a later `#version` changes the answers.
    pub(super) fn predefined(&self, name: &str) -> Option<&'static str> {
        let Version { number, es, profile } = self.version;
        let there = match name {
            "__VERSION__" => return VERSIONS.iter().find(|row| row.0 == number).map(|row| row.2),
            "GL_ES" | "GL_FRAGMENT_PRECISION_HIGH" => es,
            "GL_es_profile" => es && number >= 150,
            "GL_core_profile" => !es && number >= 150 && profile == Profile::Core,
            "GL_compatibility_profile" => !es && profile == Profile::Compatibility,
            // GL_KHR_vulkan_glsl: `#define VULKAN 100`.
            "VULKAN" => {
                self.tests_vulkan.set(true);
                return (self.target() == Some(Target::Vulkan)).then_some("100");
            }
            _ => false,
        };
        there.then_some("1")
    }

    /// Executes a directive whose `#` was just read.
    pub(super) fn directive(&mut self, hash: Token<'a>) {
        self.obeyed.push(hash.span);
        let Some(name) = self.on_line() else { return };
        match name.text {
            "define" => self.define(),
            "undef" => {
                if let Some(name) = self.on_line() {
                    self.macros.remove(name.text);
                    self.undefined.insert(name.text);
                }
            }
            "if" => self.open(hash, Self::condition),
            "ifdef" => self.open(hash, |this, at| this.is_defined(at)),
            "ifndef" => self.open(hash, |this, at| this.is_defined(at).map(|found| !found)),
            // The previous branch was taken, so this one and the rest are skipped.
            "elif" | "else" if self.in_condition() => {
                self.note_else(&name);
                self.leave_out();
            }
            "endif" if self.in_condition() => {
                self.conditions.pop();
            }
            "elif" | "else" | "endif" => {
                let message = format!("`#{}` without `#if`", name.text);
                self.report(Diagnostic::error(Code::UnmatchedDirective, name.span, message));
            }
            // Returns at once: the innermost file is the included one, and `finish_line` would skip
            // its first line. `#moj_import` is Minecraft's.
            "include" | "moj_import" => return self.include(name),
            "version" => self.set_version(name),
            "extension" => self.extension(),
            "error" => {
                let text = self.rest_of_line().trim();
                let message = format!("`#error {text}`");
                self.report(Diagnostic::error(Code::ErrorDirective, name.span, message).with_help(
                    "define the required macro with `--define NAME` or `--define NAME=VALUE`",
                ));
            }
            "line" => self.set_line(name.span),
            "pragma" => {}
            line if GODOT_LINES.contains(&line) => {}
            _ => {
                let message = format!("unknown directive `#{}`", name.text);
                self.report(Diagnostic::error(Code::UnknownDirective, name.span, message));
            }
        }
        self.finish_line();
    }

    pub(super) fn line(&mut self) -> Vec<Token<'a>> {
        std::iter::from_fn(|| self.on_line()).collect()
    }

    fn finish_line(&mut self) {
        while self.on_line().is_some() {}
    }

    pub(super) fn rest_of_line(&mut self) -> &'a str {
        self.lexer().map_or("", Lexer::rest_of_line)
    }

    fn define(&mut self) {
        let Some(before) = self.lexer().cloned() else { return };
        let after = self.define_from(before);
        if let Some(lexer) = self.lexer() {
            *lexer = after;
        }
    }

    /// Reads `NAME BODY` or `NAME(PARAMETERS) BODY` to the end of the line.
    // object-like:   # define IDENTIFIER replacement-list newline
    // function-like: # define IDENTIFIER( [identifier-list] ) replacement-list newline
    // Only a `(` that touches the name makes parameters: `#define A (x)` has the body `(x)`.
    fn define_from(&mut self, mut lexer: Lexer<'a>) -> Lexer<'a> {
        let comments = &mut self.comments;
        let Some(name) = lexer.next_on_line(comments).filter(|t| t.kind == Kind::Name) else {
            return lexer;
        };
        let mut tokens: Vec<Token<'a>> =
            std::iter::from_fn(|| lexer.next_on_line(comments)).collect();
        let mut parameters = None;
        if tokens.first().is_some_and(|t| t.is("(") && !t.spaced) {
            let Some(close) = tokens.iter().position(|t| t.is(")")) else {
                let message = format!("the parameters of macro `{}` are never closed", name.text);
                self.report(Diagnostic::error(Code::MacroCall, name.span, message));
                return lexer;
            };
            let names = tokens[1..close].iter().filter(|t| t.kind == Kind::Name);
            parameters = Some(names.map(|t| t.text).collect::<Vec<_>>());
            tokens.drain(..=close);
        }
        let mut seen = FxHashSet::default();
        let twice = parameters.iter().flatten().find(|parameter| !seen.insert(**parameter));
        let refused = match (name.text, twice) {
            ("defined", _) => Some("`defined` cannot be a macro".to_string()),
            (_, Some(parameter)) => {
                Some(format!("macro `{}` has the parameter `{parameter}` twice", name.text))
            }
            _ => None,
        };
        if let Some(message) = refused {
            self.report(Diagnostic::error(Code::MacroCall, name.span, message));
            return lexer;
        }
        let definition = Macro::new(name, parameters, tokens);
        self.brace_macros |= definition.has_unpaired_brace();
        if let Some(before) = self.macros.get(name.text) {
            let given = self.files.get(before.span.file).is_some_and(|f| f.path.starts_with("-D "));
            if given && !before.same_as(&definition) {
                // A definition on the command line takes precedence.
                let message = format!("macro `{}` keeps its definition from `--define`", name.text);
                self.diagnostics.push(Diagnostic::warning(
                    Code::MacroRedefined,
                    name.span,
                    message,
                ));
            }
            if given {
                return lexer;
            }
            if !before.same_as(&definition) {
                let message = format!("macro `{}` is redefined differently", name.text);
                let warning = Diagnostic::warning(Code::MacroRedefined, name.span, message)
                    .with_label(before.span, "previously defined here");
                self.diagnostics.push(warning);
            }
        }
        self.macros.insert(name.text, Rc::new(definition));
        lexer
    }

    /// Opens a condition and enters or skips its branch.
    // The state of a condition is only what later `#elif` and `#else` need. Text of a branch that
    // is not taken is passed by `leave_out` here, so that `next_raw` never sees it.
    fn open(
        &mut self,
        hash: Token<'a>,
        holds: impl FnOnce(&mut Self, Span) -> Result<bool, Problem>,
    ) {
        let holds = self.holds(hash.span, holds);
        self.conditions.push(Condition { span: hash.span, taken: holds, in_else: false });
        if !holds {
            self.finish_line();
            self.leave_out();
        }
    }

    fn holds(
        &mut self,
        span: Span,
        holds: impl FnOnce(&mut Self, Span) -> Result<bool, Problem>,
    ) -> bool {
        match holds(self, span) {
            Ok(holds) => holds,
            // Reported, and taken for a condition that does not hold, so that the rest is read on
            // one branch.
            Err(problem) => {
                let message = format!("the condition {}", problem.message);
                self.report(Diagnostic::error(Code::Condition, problem.span, message));
                false
            }
        }
    }

    fn is_defined(&mut self, at: Span) -> Result<bool, Problem> {
        match self.on_line() {
            Some(name) if name.kind == Kind::Name => Ok(self.knows(name.text)),
            Some(other) => Err(Problem::new(other.span, "needs the name of a macro")),
            None => Err(Problem::new(at, "lacks the name of a macro")),
        }
    }

    fn knows(&self, name: &str) -> bool {
        self.macros.contains_key(name)
            || matches!(name, "__LINE__" | "__FILE__")
            || (self.predefined(name).is_some() && !self.undefined.contains(name))
            || is_common_extension(name, self.version.es)
    }

    fn condition(&mut self, at: Span) -> Result<bool, Problem> {
        let line = self.line();
        let mut tokens = Vec::with_capacity(line.len());
        let mut rest = line.iter().peekable();
        // `defined` takes its operand before macros are expanded.
        while let Some(token) = rest.next() {
            if !token.is("defined") {
                tokens.push(*token);
                continue;
            }
            let bracket = rest.next_if(|t| t.is("(")).is_some();
            let name = rest.next().filter(|t| t.kind == Kind::Name);
            let name = name.ok_or_else(|| Problem::new(token.span, "lacks the name of a macro"))?;
            if bracket && rest.next_if(|t| t.is(")")).is_none() {
                return Err(Problem::new(name.span, "lacks `)` after the name of a macro"));
            }
            let text = if self.knows(name.text) { "1" } else { "0" };
            tokens.push(Token { kind: Kind::Number, text, ..*name });
        }
        let tokens = self.expand_alone(&tokens);
        if tokens.is_empty() {
            return Err(Problem::new(at, "is empty"));
        }
        // The evaluator computes with floats; conditions are of integers (§3.3).
        let is_fraction = |t: &&Token<'_>| t.kind == Kind::Number && t.text.contains('.');
        if let Some(token) = tokens.iter().find(is_fraction) {
            let message = format!("has `{}`, which is not an integer", token.text);
            return Err(Problem::new(token.span, message));
        }
        let mut names = UndefinedNames { es: self.version.es, met: Vec::new(), unevaluated: 0 };
        let value = evaluate_tokens(&tokens, at, &mut names)?;
        self.report_undefined(&names.met);
        value.integer().map(|v| v != 0).ok_or_else(|| Problem::new(at, "is not an integer"))
    }

    /// Reports undefined names in an `#if` of GLSL ES, where they are an error (GLSL ES 3.20 §3.4);
    /// desktop compilers evaluate them as 0.
    fn report_undefined(&mut self, names: &[(String, Span)]) {
        for (name, span) in names {
            // Extension macros and `VULKAN` are often tested where undefined.
            if name.starts_with("GL_") || !self.undefined_reported.insert(name.clone()) {
                continue;
            }
            let message = format!("`{name}` is not defined and evaluates to 0");
            let help = match name.as_str() {
                "true" => "conditions have no `true`: write `1`".to_string(),
                "false" => "conditions have no `false`: write `0`".to_string(),
                _ => format!(
                    "write `defined({name}) && {name}`, or define it with `--define {name}=N`"
                ),
            };
            let found = Diagnostic::warning(Code::UndefinedMacro, *span, message).with_help(help);
            if self.version.es {
                let message = format!("`{name}` is not defined, which is an error in GLSL ES");
                self.report(Diagnostic { severity: crate::Severity::Error, message, ..found });
            } else {
                self.diagnostics.push(found);
            }
        }
    }

    // An include cannot close or continue a condition of the file that includes it.
    fn in_condition(&self) -> bool {
        let outside = match self.frames.last() {
            Some(TokenSource::File { conditions, .. }) => *conditions,
            _ => 0,
        };
        self.conditions.len() > outside
    }

    /// Notes an `#else`, and reports what follows one.
    fn note_else(&mut self, name: &Token<'a>) {
        let Some(open) = self.conditions.last_mut() else { return };
        let (span, after) = (open.span, open.in_else);
        open.in_else |= name.text == "else";
        if after {
            let message = format!("`#{}` after `#else`", name.text);
            let found = Diagnostic::error(Code::UnmatchedDirective, name.span, message);
            self.report(found.with_label(span, "in this condition"));
        }
    }

    /// Skips branches up to the one that holds, or past the `#endif`.
    // Nested conditions are counted, not evaluated: their lines need not be valid. Names in a
    // skipped `#elif` after a taken branch are not looked up either, as in C.
    fn leave_out(&mut self) {
        let mut depth = 0u32;
        loop {
            let Some(lexer) = self.lexer() else { return };
            if lexer.skip_to_directive() == Stop::End {
                return; // reported as an open condition
            }
            let hash = self.on_line();
            let (Some(hash), Some(name)) = (hash, self.on_line()) else { continue };
            match name.text {
                "if" | "ifdef" | "ifndef" => depth += 1,
                "endif" if depth > 0 => depth -= 1,
                "endif" => {
                    self.conditions.pop();
                    return;
                }
                "else" | "elif" if depth > 0 => {}
                "else" | "elif" => {
                    let open = self.conditions.last().copied();
                    let Some(open) = open else { return };
                    self.note_else(&name);
                    let holds = !open.taken
                        && (name.text == "else" || self.holds(hash.span, Self::condition));
                    if let Some(open) = self.conditions.last_mut() {
                        open.taken |= holds;
                    }
                    if holds {
                        return;
                    }
                }
                _ => {}
            }
        }
    }

    /// Reports conditions left open at the end of a file.
    pub(super) fn check_open_conditions(&mut self) {
        while self.in_condition() {
            if let Some(open) = self.conditions.pop() {
                let message = "`#if` without `#endif`";
                self.report(Diagnostic::error(Code::UnmatchedDirective, open.span, message));
            }
        }
    }

    fn set_version(&mut self, name: Token<'a>) {
        let line = self.line();
        let is_prelude = self.preludes.contains(&name.span.file);
        if self.frames.len() > 1 && !is_prelude {
            return; // an include's version does not apply to the shader
        }
        if self.version_declared {
            let message = "a second `#version`, which compilers refuse";
            let found = Diagnostic::error(Code::Version, name.span, message);
            return self.report(found.with_help("remove it: only the first line may state it"));
        }
        let number = line.first().and_then(|t| t.text.parse::<u32>().ok());
        let Some(number) = number else {
            let message = "`#version` lacks its number";
            self.report(Diagnostic::error(Code::Version, name.span, message));
            return;
        };
        let known = VERSIONS.iter().find(|row| row.0 == number);
        if known.is_none() {
            let message = format!("unknown GLSL version {number}");
            let warning = Diagnostic::warning(Code::Version, line[0].span, message);
            self.diagnostics.push(warning.with_note("read as version 460, the newest"));
        }
        // `#version 310 es`; 100 is ES without the word (GLSL ES 1.00 §3.4).
        let es = known.is_some_and(|row| row.1) || line.get(1).is_some_and(|t| t.is("es"));
        let number = known.map_or(NEWEST, |row| row.0);
        let compatibility = line.get(1).is_some_and(|t| t.is("compatibility"));
        let profile = if compatibility { Profile::Compatibility } else { Profile::Core };
        self.version = Version { number, es, profile };
        self.version_declared = true;
    }

    /// Executes `#extension`: the extension counts as supported, and its macro is defined.
    fn extension(&mut self) {
        let line = self.line();
        let [name, colon, behaviour, ..] = line.as_slice() else { return };
        if colon.is(":") && matches!(behaviour.text, "enable" | "require" | "warn") {
            self.extensions.push(name.text);
            if !self.macros.contains_key(name.text) {
                let text = self.keep("1");
                let body = vec![Lexer::new(text, 0).next(&mut Vec::new())];
                let macro_ = Macro::new(*name, None, body);
                self.macros.insert(name.text, Rc::new(macro_));
            }
        }
    }
}

/// Whether a name is that of an extension assumed to be supported when a shader tests it with
/// `#ifdef`: those that several vendors share. Extensions of a single vendor are not, unless
/// enabled.
fn is_common_extension(name: &str, es: bool) -> bool {
    let Some((vendor, rest)) = name.strip_prefix("GL_").and_then(|n| n.split_once('_')) else {
        return false;
    };
    let common = match vendor {
        "EXT" | "KHR" | "GOOGLE" => true,
        "ARB" => !es,
        "OES" => es,
        _ => false,
    };
    common && rest.starts_with(|c: char| c.is_ascii_lowercase())
}

/// Evaluates undefined names in an `#if` as 0.
struct UndefinedNames {
    es: bool,
    met: Vec<(String, Span)>,
    /// Depth of operands that are not evaluated.
    unevaluated: u32,
}

impl Names for UndefinedNames {
    const DIRECTIVE: bool = true;

    fn value(&mut self, name: &str, span: Span) -> Result<Value, Problem> {
        let common = is_common_extension(name, self.es);
        if !common && self.unevaluated == 0 {
            self.met.push((name.to_string(), span));
        }
        Ok(Value::Long(common.into()))
    }

    fn begin_unevaluated(&mut self) {
        self.unevaluated += 1;
    }

    fn end_unevaluated(&mut self) {
        self.unevaluated -= 1;
    }
}
