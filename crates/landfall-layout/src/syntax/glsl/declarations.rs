//! The walk over a shader's global declarations: structures, blocks, loose
//! uniforms and constants are read, everything else is passed over.

mod skip;

use crate::diagnostic::Code;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::constants::Constants;
use super::lexer::{Kind, Token};
use super::preprocess::Preprocessor;
use super::qualifiers::Qualifiers;
use crate::diagnostic::Diagnostic;
use crate::shape::{Block, Majorness, Member, Rules, Struct};
use crate::source::{ReadOptions, Span};
use crate::syntax::constant::Kind as Scalar;

/// Reads declarations from the preprocessor's tokens.
pub(super) struct Reader<'a> {
    pub preprocessor: Preprocessor<'a>,
    /// The token to be read next.
    pub token: Token<'a>,
    /// The one after it, where it was looked at.
    peeked: Option<Token<'a>>,
    /// The token read last.
    pub previous: Token<'a>,
    pub types: FxHashMap<&'a str, Named<'a>>,
    pub constants: Constants<'a>,
    pub uniform_defaults: Defaults,
    pub buffer_defaults: Defaults,
    pub blocks: Vec<Block>,
    /// Loose uniforms that hold data.
    pub loose: Vec<Member>,
    /// Loose uniforms that are handles: their names.
    pub loose_opaque: Vec<Arc<str>>,
    /// Structures whose members are being read, one inside the other.
    pub open_structures: u32,
}

/// What `layout(…) uniform;` and `layout(…) buffer;` set for the blocks that follow.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Defaults {
    /// The rules, if set; `None` inside means the driver's own (`shared`, `packed`).
    pub rules: Option<Option<Rules>>,
    pub majorness: Option<Majorness>,
}

/// A type the shader declares.
#[derive(Clone, Debug)]
pub(super) enum Named<'a> {
    Struct(Arc<Struct>),
    /// `layout(buffer_reference) buffer NAME`.
    Reference,
    /// A structure that cannot be laid out, and why; told when something is made of it.
    Broken {
        name: Token<'a>,
        why: Vec<Diagnostic>,
        told: bool,
    },
}

/// `NAME [dims] [= initialiser]`, one of several after a type.
pub(super) struct Declarator<'a> {
    pub name: Token<'a>,
    pub dims: Vec<Dim<'a>>,
    pub initialiser: Vec<Token<'a>>,
}

/// `[ EXPRESSION ]` as written; empty for `[]`.
#[derive(Clone, Debug)]
pub(super) struct Dim<'a> {
    pub size: Vec<Token<'a>>,
    pub span: Span,
}

impl<'a> Reader<'a> {
    pub fn new(mut preprocessor: Preprocessor<'a>) -> Reader<'a> {
        let token = preprocessor.next();
        let previous = Token { kind: Kind::End, text: "", ..token };
        Reader {
            preprocessor,
            token,
            peeked: None,
            previous,
            types: FxHashMap::default(),
            constants: Constants::default(),
            uniform_defaults: Defaults::default(),
            buffer_defaults: Defaults::default(),
            blocks: Vec::new(),
            loose: Vec::new(),
            loose_opaque: Vec::new(),
            open_structures: 0,
        }
    }

    /// Reads the whole shader.
    pub fn read(&mut self) {
        while self.token.kind != Kind::End {
            let (span, definition) = (self.token.span, self.token.definition);
            self.declaration();
            if (span, definition) == (self.token.span, self.token.definition) {
                self.bump(); // a declaration always passes something, whatever it was
            }
        }
        self.tell_unused_broken_types();
    }

    pub fn options(&self) -> &'a ReadOptions {
        self.preprocessor.options
    }

    /// Goes on to the next token; returns the one passed.
    pub fn bump(&mut self) -> Token<'a> {
        self.previous = self.token;
        self.token = match self.peeked.take() {
            Some(token) => token,
            None => self.preprocessor.next(),
        };
        self.previous
    }

    pub fn peek(&mut self) -> Token<'a> {
        *self.peeked.get_or_insert_with(|| self.preprocessor.next())
    }

    /// Passes that operator or bracket, or says that it is missing.
    pub fn expect(&mut self, text: &str) -> bool {
        if self.token.is(text) {
            self.bump();
            return true;
        }
        let found = match self.token.kind {
            Kind::End => "the end of the file".to_string(),
            _ => format!("`{}`", self.token.text),
        };
        let message = format!("expected `{text}`, found {found}");
        let diagnostic = self.diagnostic(&self.token, Code::Syntax, message);
        let after = Span { start: self.previous.span.end, ..self.previous.span };
        self.report(match self.previous.kind {
            Kind::End => diagnostic,
            _ => diagnostic.with_label(after, format!("`{text}` may be missing here")),
        });
        false
    }

    /// A finding at a token, with the macro it came out of.
    pub fn diagnostic(
        &self,
        token: &Token<'a>,
        code: Code,
        message: impl Into<String>,
    ) -> Diagnostic {
        let diagnostic = Diagnostic::error(code, token.span, message);
        match token.definition {
            Some(definition) => diagnostic.with_label(definition, "from this macro"),
            None => diagnostic,
        }
    }

    pub fn report(&mut self, diagnostic: Diagnostic) {
        self.preprocessor.report(diagnostic);
    }

    pub fn report_at(&mut self, token: &Token<'a>, code: Code, message: impl Into<String>) {
        let diagnostic = self.diagnostic(token, code, message);
        self.report(diagnostic);
    }

    fn declaration(&mut self) {
        match self.token.text {
            ";" => {
                self.bump();
                return;
            }
            "precision" => return self.skip_statement(),
            "[" => return self.skip_balanced(),
            _ => {}
        }
        let before = self.previous;
        let first = self.token;
        let qualifiers = self.qualifiers();
        if self.token.is(";") && qualifiers.any {
            self.set_defaults(&qualifiers);
            self.bump();
        } else if self.token.is("struct") {
            self.variables_of_structure(&qualifiers, before, first);
        } else if self.token.kind == Kind::Name {
            let next = self.peek();
            if next.is("{") && (qualifiers.uniform || qualifiers.buffer) {
                self.block(&qualifiers, before, first);
            } else if next.is("{") && qualifiers.other_storage {
                // `in NAME { … } name[];` has locations, not bytes.
                self.bump();
                self.skip_balanced();
                self.skip_statement();
            } else if (next.is(";") || next.is(",")) && qualifiers.any {
                self.requalification(&qualifiers);
            } else {
                self.variables(&qualifiers, before, first);
            }
        } else {
            self.unexpected();
        }
    }

    /// `layout(…) uniform;` sets defaults; so does `layout(…) buffer;`.
    fn set_defaults(&mut self, qualifiers: &Qualifiers<'a>) {
        let own = super::blocks::own_defaults(qualifiers);
        for (named, defaults) in [
            (qualifiers.uniform, &mut self.uniform_defaults),
            (qualifiers.buffer, &mut self.buffer_defaults),
        ] {
            if named {
                defaults.rules = own.rules.or(defaults.rules);
                defaults.majorness = own.majorness.or(defaults.majorness);
            }
        }
    }

    /// `invariant gl_Position;`, or `layout(buffer_reference) buffer NAME;` ahead of its body.
    fn requalification(&mut self, qualifiers: &Qualifiers<'a>) {
        if qualifiers.buffer && qualifiers.find("buffer_reference").is_some() {
            self.types.insert(self.token.text, Named::Reference);
        }
        self.skip_statement();
    }

    /// `struct NAME { … } a, b;`
    fn variables_of_structure(
        &mut self,
        qualifiers: &Qualifiers<'a>,
        before: Token<'a>,
        first: Token<'a>,
    ) {
        let Some(named) = self.structure() else { return };
        if self.token.is(";") {
            self.bump();
            return;
        }
        let dims = self.dims();
        let declarators = self.declarators();
        if qualifiers.uniform && !qualifiers.subroutine {
            self.loose_uniforms(
                super::members::TypeName::Declared(named),
                &dims,
                declarators,
                before,
                first,
            );
        }
    }

    /// `TYPE a, b;`, or a function.
    fn variables(&mut self, qualifiers: &Qualifiers<'a>, before: Token<'a>, first: Token<'a>) {
        let ty = self.bump();
        if self.token.is("<") {
            self.skip_angles();
            if !qualifiers.uniform && !self.peek().is("(") {
                // A value of such a type may have commas of its own kind in its initialiser.
                return self.skip_statement();
            }
        }
        let dims = self.dims();
        if self.token.kind != Kind::Name {
            return self.unexpected();
        }
        if self.peek().is("(") && !qualifiers.uniform {
            return self.function();
        }
        let declarators = self.declarators();
        if qualifiers.subroutine {
            // A subroutine uniform is set by its own call and has no bytes.
        } else if qualifiers.uniform {
            let ty = super::members::TypeName::Name(ty);
            self.loose_uniforms(ty, &dims, declarators, before, first);
        } else if qualifiers.constant {
            for declarator in declarators {
                let scalar = match (ty.text, dims.len() + declarator.dims.len()) {
                    ("int" | "int16_t" | "int8_t" | "int32_t", 0) => Some(Scalar::Int),
                    ("uint" | "uint16_t" | "uint8_t" | "uint32_t", 0) => Some(Scalar::Uint),
                    ("float" | "double", 0) => Some(Scalar::Float),
                    ("bool", 0) => Some(Scalar::Bool),
                    ("int64_t", 0) => Some(Scalar::Long),
                    ("uint64_t", 0) => Some(Scalar::Ulong),
                    _ => None,
                };
                self.add_constant(declarator.name, scalar, qualifiers, declarator.initialiser);
            }
        }
    }

    /// `NAME ( … ) ;` or `NAME ( … ) { … }`, its type passed.
    fn function(&mut self) {
        let name = self.bump();
        self.skip_balanced();
        if self.token.is("{") {
            let open = self.token;
            if !self.preprocessor.skip_body(&open) {
                let message = format!("the body of `{}` is never closed", name.text);
                self.report_at(&open, Code::UnclosedBrace, message);
            }
            self.previous = Token { text: "}", ..open };
            self.token = self.preprocessor.next();
        } else {
            self.end_of_statement();
        }
    }

    /// Reads `NAME [dims] [= …] , … ;`.
    pub fn declarators(&mut self) -> Vec<Declarator<'a>> {
        let mut declarators = Vec::new();
        loop {
            if self.token.kind != Kind::Name {
                self.unexpected();
                return declarators;
            }
            let name = self.bump();
            let dims = self.dims();
            let mut initialiser = Vec::new();
            if self.token.is("=") {
                self.bump();
                initialiser = self.collect_until(&[",", ";"]);
            }
            declarators.push(Declarator { name, dims, initialiser });
            if !self.token.is(",") {
                break;
            }
            self.bump();
        }
        self.end_of_statement();
        declarators
    }

    /// Reads `[…]` as often as it stands there.
    pub fn dims(&mut self) -> Vec<Dim<'a>> {
        let mut dims = Vec::new();
        while self.token.is("[") {
            let open = self.bump();
            let size = self.collect_until(&["]"]);
            let span = open.span.to(self.token.span);
            if !self.expect("]") {
                break;
            }
            dims.push(Dim { size, span });
        }
        dims
    }

    fn tell_unused_broken_types(&mut self) {
        let types = std::mem::take(&mut self.types);
        let mut untold: Vec<_> = types
            .into_values()
            .filter_map(|named| match named {
                Named::Broken { why, told: false, .. } => Some(why),
                Named::Broken { .. } | Named::Struct(_) | Named::Reference => None,
            })
            .flatten()
            .collect();
        untold.sort_by_key(|d| d.labels.first().map(|label| (label.span.file, label.span.start)));
        for diagnostic in untold {
            self.report(diagnostic);
        }
    }
}
