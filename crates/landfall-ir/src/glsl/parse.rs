//! From tokens to [`ast`](super::ast): expressions and statements.
//!
//! Fed by the preprocessor; [`declare`](super::declare) is its other half.

use landfall_layout::diagnostic::Code;
use rustc_hash::FxHashSet;

use super::ast::*;
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::source::Span;
pub use landfall_layout::syntax::glsl::lexer::{Kind, Token};
pub use landfall_layout::syntax::glsl::types::{Builtin, builtin};

/// Expressions nest this deep at most.
const DEEPEST_EXPRESSION: u32 = 400;

pub type Parsed<T> = Result<T, Box<Diagnostic>>;

/// Reads a token at a time, with as much looking ahead as it takes.
pub struct Parser<'a, 't> {
    pub tokens: &'t [Token<'a>],
    pub at: usize,
    /// Names of structures declared so far.
    pub structures: FxHashSet<&'a str>,
    /// Whether `varying` is an input here.
    pub stage_reads_varyings: bool,
    /// Structures being read, one inside the other.
    pub open_structures: u32,
    /// Precisions in force; none in a dialect that has no use for them.
    pub precisions: Option<Precisions>,
    /// The precision that was said before the type that follows.
    pub said: Option<Precision>,
    depth: u32,
    /// Statements being read, one inside the other.
    pub statements: u32,
}

/// What `precision` statements have set, and the language before them.
#[derive(Clone, Copy, Debug)]
pub struct Precisions {
    pub float: Option<Precision>,
    /// Of what a `sampler2D` or `samplerCube` gives; other samplers have none.
    pub sampled: Precision,
}

impl<'a, 't> Parser<'a, 't> {
    /// At the first of some tokens, the last of which is the end.
    pub fn new(tokens: &'t [Token<'a>]) -> Parser<'a, 't> {
        Parser {
            tokens,
            at: 0,
            structures: FxHashSet::default(),
            stage_reads_varyings: false,
            open_structures: 0,
            precisions: None,
            said: None,
            depth: 0,
            statements: 0,
        }
    }

    pub fn token(&self) -> &'t Token<'a> {
        self.ahead(0)
    }

    pub fn ahead(&self, count: usize) -> &'t Token<'a> {
        let last = self.tokens.len() - 1;
        &self.tokens[(self.at + count).min(last)]
    }

    pub fn bump(&mut self) -> &'t Token<'a> {
        let token = self.token();
        self.at += 1;
        token
    }

    pub fn is(&self, text: &str) -> bool {
        self.token().is(text)
    }

    pub fn eat(&mut self, text: &str) -> bool {
        let found = self.is(text);
        if found {
            self.at += 1;
        }
        found
    }

    /// Whether these two stand here with nothing between: `+=`, `++`.
    pub fn is_pair(&self, first: &str, second: &str) -> bool {
        let (a, b) = (self.token(), self.ahead(1));
        a.is(first) && b.is(second) && !b.spaced && (b.definition.is_some() || !b.first)
    }

    pub fn expect(&mut self, text: &str) -> Parsed<Span> {
        if self.is(text) {
            return Ok(self.bump().span);
        }
        Err(self.unexpected(&format!("expected `{text}`")))
    }

    pub fn unexpected(&self, wanted: &str) -> Box<Diagnostic> {
        let token = self.token();
        let found = match token.kind {
            Kind::End => "the end of the file".to_string(),
            _ => format!("`{}`", token.text),
        };
        Box::new(Diagnostic::error(Code::Syntax, token.span, format!("{wanted}, found {found}")))
    }

    pub fn name(&mut self) -> Parsed<Name<'a>> {
        if self.token().kind != Kind::Name {
            return Err(self.unexpected("expected a name"));
        }
        let token = self.bump();
        Ok(Name { text: token.text, span: token.span })
    }

    /// Where what was read last ends, as one span with its start.
    pub fn since(&self, start: Span) -> Span {
        start.to(self.tokens[self.at.saturating_sub(1).min(self.tokens.len() - 1)].span)
    }

    pub fn expr(&self, kind: ExprKind<'a>, span: Span, below: u32) -> Parsed<Expr<'a>> {
        let depth = below + 1;
        if depth > DEEPEST_EXPRESSION {
            let message = format!("an expression nests more than {DEEPEST_EXPRESSION} deep");
            return Err(Box::new(Diagnostic::error(Code::NestedTooDeep, span, message)));
        }
        Ok(Expr { kind, span, depth })
    }

    fn deeper<T>(&mut self, read: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        self.depth += 1;
        if self.depth > DEEPEST_EXPRESSION {
            let message = format!("an expression nests more than {DEEPEST_EXPRESSION} deep");
            return Err(Box::new(Diagnostic::error(
                Code::NestedTooDeep,
                self.token().span,
                message,
            )));
        }
        let result = read(self);
        self.depth -= 1;
        result
    }

    /// With commas.
    pub fn expression(&mut self) -> Parsed<Expr<'a>> {
        let mut left = self.assignment()?;
        while self.is(",") {
            self.bump();
            let right = self.assignment()?;
            let (span, depth) = (left.span.to(right.span), left.depth.max(right.depth));
            left = self.expr(ExprKind::Comma(Box::new(left), Box::new(right)), span, depth)?;
        }
        Ok(left)
    }

    /// Without commas.
    pub fn assignment(&mut self) -> Parsed<Expr<'a>> {
        self.deeper(|this| {
            let left = this.choice()?;
            let Some(operator) = this.assignment_operator() else { return Ok(left) };
            let right = this.assignment()?;
            let (span, depth) = (left.span.to(right.span), left.depth.max(right.depth));
            this.expr(ExprKind::Assign(operator, Box::new(left), Box::new(right)), span, depth)
        })
    }

    fn assignment_operator(&mut self) -> Option<Option<Binary>> {
        if self.eat("=") {
            return Some(None);
        }
        let operator = match self.token().text {
            "+" => Binary::Add,
            "-" => Binary::Subtract,
            "*" => Binary::Multiply,
            "/" => Binary::Divide,
            "%" => Binary::Modulo,
            "&" => Binary::BitAnd,
            "|" => Binary::BitOr,
            "^" => Binary::BitXor,
            "<<" => Binary::ShiftLeft,
            ">>" => Binary::ShiftRight,
            _ => return None,
        };
        if !self.is_pair(self.token().text, "=") {
            return None;
        }
        self.at += 2;
        Some(Some(operator))
    }

    fn choice(&mut self) -> Parsed<Expr<'a>> {
        let condition = self.binary(0)?;
        if !self.eat("?") {
            return Ok(condition);
        }
        self.deeper(|this| {
            let accept = this.expression()?;
            this.expect(":")?;
            let reject = this.assignment()?;
            let span = condition.span.to(reject.span);
            let depth = condition.depth.max(accept.depth).max(reject.depth);
            this.expr(ExprKind::Choose(Box::new([condition, accept, reject])), span, depth)
        })
    }

    /// GLSL 4.60 §5.1, operators that bind at least as tightly as `least`.
    fn binary(&mut self, least: u8) -> Parsed<Expr<'a>> {
        let mut left = self.unary()?;
        while let Some((operator, binds)) = self.binary_operator().filter(|o| o.1 >= least) {
            self.bump();
            let right = self.deeper(|this| this.binary(binds + 1))?;
            let (span, depth) = (left.span.to(right.span), left.depth.max(right.depth));
            let kind = ExprKind::Binary(operator, Box::new(left), Box::new(right));
            left = self.expr(kind, span, depth)?;
        }
        Ok(left)
    }

    fn binary_operator(&self) -> Option<(Binary, u8)> {
        let token = self.token();
        if token.kind != Kind::Punctuation {
            return None;
        }
        let found = match token.text {
            "||" => (Binary::Or, 1),
            "^^" => (Binary::Xor, 2),
            "&&" => (Binary::And, 3),
            "|" => (Binary::BitOr, 4),
            "^" => (Binary::BitXor, 5),
            "&" => (Binary::BitAnd, 6),
            "==" => (Binary::Equal, 7),
            "!=" => (Binary::NotEqual, 7),
            "<" => (Binary::Less, 8),
            ">" => (Binary::Greater, 8),
            "<=" => (Binary::LessEqual, 8),
            ">=" => (Binary::GreaterEqual, 8),
            "<<" => (Binary::ShiftLeft, 9),
            ">>" => (Binary::ShiftRight, 9),
            "+" => (Binary::Add, 10),
            "-" => (Binary::Subtract, 10),
            "*" => (Binary::Multiply, 11),
            "/" => (Binary::Divide, 11),
            "%" => (Binary::Modulo, 11),
            _ => return None,
        };
        // `a += b`: an assignment, not a sum.
        let assigns =
            matches!(token.text, "|" | "^" | "&" | "<<" | ">>" | "+" | "-" | "*" | "/" | "%");
        (!assigns || !self.is_pair(token.text, "=")).then_some(found)
    }

    fn unary(&mut self) -> Parsed<Expr<'a>> {
        let start = self.token().span;
        for (sign, increment) in [("+", true), ("-", false)] {
            if self.is_pair(sign, sign) {
                self.at += 2;
                let inner = self.deeper(Self::unary)?;
                let (span, depth) = (start.to(inner.span), inner.depth);
                let step = Step { increment, before: true };
                return self.expr(ExprKind::Step(step, Box::new(inner)), span, depth);
            }
        }
        let operator = match self.token().text {
            "+" => Unary::Plus,
            "-" => Unary::Minus,
            "!" => Unary::Not,
            "~" => Unary::Complement,
            _ => return self.postfix(),
        };
        self.bump();
        let inner = self.deeper(Self::unary)?;
        let (span, depth) = (start.to(inner.span), inner.depth);
        self.expr(ExprKind::Unary(operator, Box::new(inner)), span, depth)
    }

    fn postfix(&mut self) -> Parsed<Expr<'a>> {
        let mut left = self.primary()?;
        loop {
            let start = left.span;
            if self.eat("[") {
                let index = self.expression()?;
                self.expect("]")?;
                let depth = left.depth.max(index.depth);
                let kind = ExprKind::Index(Box::new(left), Box::new(index));
                left = self.expr(kind, self.since(start), depth)?;
            } else if self.eat(".") {
                let name = self.name()?;
                let depth = left.depth;
                let kind = if name.text == "length" && self.is("(") {
                    self.bump();
                    self.expect(")")?;
                    ExprKind::Length(Box::new(left))
                } else {
                    ExprKind::Member(Box::new(left), name)
                };
                left = self.expr(kind, self.since(start), depth)?;
            } else if self.is_pair("+", "+") || self.is_pair("-", "-") {
                let step = Step { increment: self.is("+"), before: false };
                self.at += 2;
                let depth = left.depth;
                left = self.expr(ExprKind::Step(step, Box::new(left)), self.since(start), depth)?;
            } else {
                return Ok(left);
            }
        }
    }

    fn primary(&mut self) -> Parsed<Expr<'a>> {
        let token = self.token();
        match token.kind {
            Kind::Number => {
                self.bump();
                self.expr(ExprKind::Number(token.text), token.span, 0)
            }
            Kind::Name if matches!(token.text, "true" | "false") => {
                self.bump();
                self.expr(ExprKind::Bool(token.text == "true"), token.span, 0)
            }
            Kind::Name => self.named(),
            _ if token.is("(") => {
                self.bump();
                let mut inner = self.deeper(Self::expression)?;
                self.expect(")")?;
                inner.span = self.since(token.span);
                Ok(inner)
            }
            // Text for a debugger: it has no value.
            Kind::Text => {
                self.bump();
                self.expr(ExprKind::Number("0"), token.span, 0)
            }
            _ if token.is("{") => {
                self.bump();
                let items = self.deeper(|this| this.list("}"))?;
                let depth = items.iter().map(|e| e.depth).max().unwrap_or(0);
                self.expr(ExprKind::List(items), self.since(token.span), depth)
            }
            _ => Err(self.unexpected("expected an expression")),
        }
    }

    /// A variable, a call, a constructor.
    fn named(&mut self) -> Parsed<Expr<'a>> {
        let start = self.token().span;
        let text = self.token().text;
        // A structure's own name before `(` is read as a call; which it is, its scope says.
        let meaning = builtin(text);
        let handle = matches!(meaning, Some(Builtin::Opaque));
        let array = self.ahead(1).is("[") && !handle;
        let constructs = (meaning.is_some() && self.ahead(1).is("("))
            || (array && (meaning.is_some() || self.structures.contains(text)));
        if constructs && (!array || self.constructs_array()) {
            let ty = self.type_spec()?;
            self.expect("(")?;
            let arguments = self.deeper(|this| this.list(")"))?;
            let depth = arguments.iter().map(|e| e.depth).max().unwrap_or(0);
            let kind = ExprKind::Construct(Box::new(ty), arguments);
            return self.expr(kind, self.since(start), depth);
        }
        let name = self.name()?;
        if !self.eat("(") {
            return self.expr(ExprKind::Name(name.text), start, 0);
        }
        let arguments = self.deeper(|this| this.list(")"))?;
        let depth = arguments.iter().map(|e| e.depth).max().unwrap_or(0);
        self.expr(ExprKind::Call(name, arguments), self.since(start), depth)
    }

    /// Expressions up to `close`, which is passed.
    fn list(&mut self, close: &str) -> Parsed<Vec<Expr<'a>>> {
        let mut items = Vec::new();
        if self.is("void") && self.ahead(1).is(")") {
            self.bump();
        }
        while !self.eat(close) {
            items.push(self.assignment()?);
            if !self.eat(",") && !self.is(close) {
                return Err(self.unexpected(&format!("expected `,` or `{close}`")));
            }
        }
        Ok(items)
    }

    /// Whether `NAME[…]` here goes on with the `(` of a constructor.
    pub fn constructs_array(&self) -> bool {
        self.ahead(self.past_dims(1)).is("(")
    }

    /// How far ahead the first token past all `[…]` is.
    pub fn past_dims(&self, mut ahead: usize) -> usize {
        while self.ahead(ahead).is("[") {
            let mut depth = 0u32;
            loop {
                match self.ahead(ahead).text {
                    "[" => depth += 1,
                    "]" => depth -= 1,
                    _ if self.ahead(ahead).kind == Kind::End => return ahead,
                    _ => {}
                }
                ahead += 1;
                if depth == 0 {
                    break;
                }
            }
        }
        ahead
    }
}
