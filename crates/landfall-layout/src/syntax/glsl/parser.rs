//! The GLSL parser: from tokens to the syntax tree of [`ast`](super::ast).
//!
//! `declaration` (with `qualifiers`) parses what is outside functions and recovers from syntax
//! errors (`recover`); it keeps expressions and bodies as ranges of tokens. `complete` parses
//! those, with `expression` and `statement`.
//!
//! The comment above a parser function is the production that it reads, by its name in GLSL 4.60
//! §9. Words in capitals are tokens, `[ ]` is optional, `{ }` may be repeated or missing.

mod complete;
mod declaration;
mod expression;
mod qualifiers;
mod recover;
mod statement;
mod syntax_error;

use rustc_hash::FxHashSet;

use super::ast::{Expr, Name, PrecisionQualifier, Precisions, Storage, Tokens};
use super::lexer::{Kind, Token};
use super::preprocess::{Preprocessor, Version};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::source::Span;
pub use syntax_error::{Parsed, SyntaxError, Wanted};

/// The limit on tokens; guards against shaders made to exhaust memory.
const MAX_TOKENS: usize = 1 << 20;

/// The number of tokens kept before those of finished declarations are dropped.
// Dropping after each declaration would move the tokens that are left once per declaration; this
// way a token is moved at most once per 1,024 that are read.
const ENOUGH: usize = 1 << 10;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bodies {
    Skip,
    /// Bodies are kept, to be parsed on demand.
    Keep,
}

/// Parses the tokens of a preprocessor, or a list of tokens.
pub struct Parser<'a> {
    preprocessor: Option<Box<Preprocessor<'a>>>,
    bodies: Bodies,
    tokens: Vec<Token<'a>>,
    at: usize,
    /// The end of the tokens to parse, when only a part is parsed.
    limit: usize,
    end: Token<'a>,
    /// Diagnostics for a list of tokens; a preprocessor keeps those of its own tokens.
    diagnostics: Vec<Diagnostic>,
    /// The start of the previous declaration, to detect lack of progress: token and macro
    /// definition.
    passed: Option<(Span, Option<Span>)>,
    // Tells `S[2] a;` and `S[2](…)` from an index: the grammar has a token TYPE_NAME for these
    // (§9), which only a table of names can tell from IDENTIFIER.
    structures: FxHashSet<&'a str>,
    /// The number of structures open, one inside the other.
    open_structures: u32,
    /// The number of member lists open, one inside the other.
    open_members: u32,
    /// Whether expressions are parsed in place, as in function bodies.
    direct: bool,
    precisions: Precisions,
    has_precisions: bool,
    /// The precision of floats that the stage has by default.
    stage_float: Option<PrecisionQualifier>,
    /// The precision written before the next type.
    written: Option<PrecisionQualifier>,
    /// The storage qualifier that `varying` means in this stage.
    varying: Storage,
    depth: u32,
    /// The number of statements open, one inside the other.
    statements: u32,
    /// Names that stand for qualifiers, where macros are not expanded.
    qualifier_macros: FxHashSet<&'a str>,
}

impl<'a> Parser<'a> {
    /// Creates a parser at the first token of a shader.
    // Tokens are read one by one: where bodies are skipped, the preprocessor must not be past the
    // `{` of a body when the parser sees that it is one.
    pub(super) fn new(mut preprocessor: Preprocessor<'a>, bodies: Bodies) -> Parser<'a> {
        let first = preprocessor.next();
        let mut tokens = Vec::with_capacity(ENOUGH / 2);
        tokens.push(first);
        let mut parser = Parser::over(tokens);
        parser.bodies = bodies;
        parser.preprocessor = Some(Box::new(preprocessor));
        parser
    }

    // The end stands right behind the last token, where what is missing belongs.
    pub fn over(tokens: Vec<Token<'a>>) -> Parser<'a> {
        let last = tokens.last().map_or(Span::default(), |last| last.span);
        Parser {
            preprocessor: None,
            bodies: Bodies::Keep,
            tokens,
            at: 0,
            limit: usize::MAX,
            end: Token::end(Span { start: last.end, ..last }),
            diagnostics: Vec::new(),
            passed: None,
            structures: FxHashSet::default(),
            open_structures: 0,
            open_members: 0,
            direct: false,
            precisions: Precisions::default(),
            has_precisions: false,
            stage_float: None,
            written: None,
            varying: Storage::Varying,
            depth: 0,
            statements: 0,
            qualifier_macros: FxHashSet::default(),
        }
    }

    /// Returns the parser with names that count as qualifiers: macros that are not expanded.
    pub fn with_qualifier_macros(self, qualifier_macros: FxHashSet<&'a str>) -> Parser<'a> {
        Parser { qualifier_macros, ..self }
    }

    pub fn position(&self) -> usize {
        self.at
    }

    pub fn forget_diagnostics(&mut self) {
        self.diagnostics.clear();
    }

    pub(super) fn preprocessor(&mut self) -> &mut Preprocessor<'a> {
        self.preprocessor.as_mut().expect("a shader's parser has a preprocessor")
    }

    /// Whether an include was not found.
    pub(super) fn misses_include(&self) -> bool {
        let found = self.preprocessor.iter().flat_map(|preprocessor| &preprocessor.diagnostics);
        found.into_iter().any(|found| found.code == Code::MissingInclude)
    }

    pub fn is_es(&self) -> bool {
        self.preprocessor.as_ref().is_some_and(|preprocessor| preprocessor.version.es)
    }

    /// The version, if there is a preprocessor.
    pub(super) fn version(&self) -> Option<Version> {
        self.preprocessor.as_ref().map(|preprocessor| preprocessor.version)
    }

    pub(super) fn extensions(&self) -> &[&'a str] {
        self.preprocessor.as_ref().map_or(&[], |preprocessor| &preprocessor.extensions)
    }

    /// All tokens read so far; those of bodies are missing where they are skipped.
    pub fn tokens(&self) -> &[Token<'a>] {
        &self.tokens
    }

    pub(crate) fn token_of(&self, name: &Name<'a>) -> Token<'a> {
        self.tokens[name.at]
    }

    /// Returns the token before `at`; at the start of the shader one of kind `End`.
    pub(super) fn before(&self, at: usize) -> Token<'a> {
        match at.checked_sub(1) {
            Some(before) => self.tokens[before],
            None => Token { kind: Kind::End, text: "", ..*self.token() },
        }
    }

    /// Drops the tokens of finished declarations.
    // The last token stays, since a message about a missing `;` points behind it. Indices of tokens
    // in finished items are invalid afterwards, so only readers that drop the items call this.
    pub(super) fn forget(&mut self) {
        if self.at > ENOUGH {
            self.tokens.drain(..self.at - 1);
            self.at = 1;
        }
    }

    fn token(&self) -> &Token<'a> {
        if self.at >= self.limit {
            return &self.end;
        }
        self.tokens.get(self.at).unwrap_or(&self.end)
    }

    fn ahead(&mut self, count: usize) -> &Token<'a> {
        let at = self.at + count;
        if at >= self.limit {
            return &self.end;
        }
        self.load(at);
        self.tokens.get(at).unwrap_or(&self.end)
    }

    /// Reads tokens from the preprocessor up to index `at`. No tokens follow the end.
    // The tokens past the end repeat it; `ahead` may so ask for any number of tokens.
    fn load(&mut self, at: usize) {
        if at < self.tokens.len() {
            return;
        }
        let Some(preprocessor) = &mut self.preprocessor else { return };
        while self.tokens.len() <= at {
            if self.tokens.last().is_some_and(|last| last.kind == Kind::End) {
                let end = self.tokens[self.tokens.len() - 1];
                self.end = end;
                return;
            }
            let token = preprocessor.next();
            self.tokens.push(token);
            // Skipped bodies and forgotten tokens take no memory, so only a tree of the whole text
            // is limited.
            if self.bodies == Bodies::Keep && self.tokens.len() == MAX_TOKENS {
                let message = format!("the shader has more than {MAX_TOKENS} tokens");
                preprocessor.stop(Diagnostic::error(Code::CannotRun, token.span, message));
            }
        }
    }

    /// Advances to the next token; returns the one passed.
    fn bump(&mut self) -> Token<'a> {
        let token = *self.token();
        if token.kind != Kind::End {
            self.at += 1;
            if self.at < self.limit {
                self.load(self.at);
            }
        }
        token
    }

    fn is(&self, text: &str) -> bool {
        self.token().is(text)
    }

    fn eat(&mut self, text: &str) -> bool {
        let found = self.is(text);
        if found {
            self.bump();
        }
        found
    }

    fn eat_two(&mut self) {
        self.bump();
        self.bump();
    }

    /// Whether the two operators are adjacent here: `+=`, `++`.
    // The lexer joins only operators of constant expressions. Those that assign and those that step
    // (`+=`, `<<=`, `++`) are two tokens that touch; `a + +b` has the same tokens with a blank
    // between.
    fn is_pair(&mut self, first: &str, second: &str) -> bool {
        if !self.is(first) {
            return false;
        }
        let b = self.ahead(1);
        b.is(second) && !b.spaced && (b.definition.is_some() || !b.first)
    }

    /// Consumes that operator or bracket.
    fn expect(&mut self, text: &'static str) -> Parsed<Span> {
        if self.is(text) {
            return Ok(self.bump().span);
        }
        Err(self.unexpected(Wanted::Token(text)))
    }

    fn unexpected(&self, wanted: Wanted) -> SyntaxError {
        let token = self.token();
        let end = token.kind == Kind::End;
        // At the end of a part of the text the message names what follows it: `float a[2 +];` has
        // an unexpected `]`, not an unexpected end of the file.
        let found = match self.tokens.get(self.limit) {
            Some(past) if end => past.text,
            _ => token.text,
        };
        SyntaxError::Unexpected { span: token.span, found: found.to_string(), end, wanted }
    }

    fn name(&mut self) -> Parsed<Name<'a>> {
        if self.token().kind != Kind::Name {
            return Err(self.unexpected(Wanted::Name));
        }
        Ok(self.name_here())
    }

    fn name_here(&mut self) -> Name<'a> {
        let at = self.at;
        let token = self.bump();
        Name { text: token.text, span: token.span, at }
    }

    /// Returns the span from `start` to the end of the last token read.
    fn since(&self, start: Span) -> Span {
        start.to(self.before(self.at).span)
    }

    pub fn diagnostics(&self) -> &Vec<Diagnostic> {
        match &self.preprocessor {
            Some(preprocessor) => &preprocessor.diagnostics,
            None => &self.diagnostics,
        }
    }

    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        match &mut self.preprocessor {
            Some(preprocessor) => preprocessor.report(diagnostic),
            None => self.diagnostics.push(diagnostic),
        }
    }

    /// Returns the first error after the first `count` diagnostics; later ones follow from it.
    // Inside bodies the first error ends the parse, by `Err`. Functions that both ways share report
    // instead, so their report is taken back and returned here.
    fn failed_since(&mut self, count: usize) -> Parsed<()> {
        let diagnostics = match &mut self.preprocessor {
            Some(preprocessor) => &mut preprocessor.diagnostics,
            None => &mut self.diagnostics,
        };
        let error = |d: &Diagnostic| d.severity == Severity::Error;
        match diagnostics[count..].iter().position(error) {
            Some(at) => {
                let first = diagnostics.remove(count + at);
                diagnostics.truncate(count);
                Err(SyntaxError::Other(Box::new(first)))
            }
            None => Ok(()),
        }
    }

    fn errors(&self) -> usize {
        self.diagnostics().iter().filter(|d| d.severity == Severity::Error).count()
    }

    /// Parses a part of the tokens, all of which must be consumed.
    fn part<T>(
        &mut self,
        tokens: &Tokens,
        parse: impl FnOnce(&mut Self) -> Parsed<T>,
    ) -> Parsed<T> {
        let (at, limit, direct) = (self.at, self.limit, self.direct);
        let end = self.end;
        // The end of the part stands where its closing bracket does, so that errors there have a
        // place.
        if let Some(past) = self.tokens.get(tokens.end) {
            self.end = Token { kind: Kind::End, text: "", ..*past };
        }
        (self.at, self.limit, self.direct) = (tokens.start, tokens.end, true);
        let result = parse(self).and_then(|result| match self.token().kind {
            Kind::End => Ok(result),
            _ => Err(self.unexpected(Wanted::End)),
        });
        (self.at, self.limit, self.direct, self.end) = (at, limit, direct, end);
        result
    }

    /// Parses a part of the tokens as an expression.
    pub(super) fn expression_of(&mut self, tokens: &Tokens) -> Parsed<Expr<'a>> {
        self.depth = 0;
        self.part(tokens, Self::assignment)
    }

    /// Parses a list of tokens as an expression.
    pub(super) fn expression_over(tokens: &[Token<'a>]) -> Parsed<Expr<'a>> {
        let mut parser = Parser::over(tokens.to_vec());
        let all = 0..tokens.len();
        parser.expression_of(&all)
    }
}
