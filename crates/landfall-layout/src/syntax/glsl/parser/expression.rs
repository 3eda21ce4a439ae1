//! Expressions (GLSL 4.60 §5.1).

use super::{Parsed, Parser, SyntaxError, Wanted};
use crate::source::Span;
use crate::syntax::glsl::ast::{Binary, Expr, ExprKind, IncrementOp, Unary};
use crate::syntax::glsl::lexer::Kind;
use crate::syntax::glsl::types::{Builtin, builtin};
use crate::syntax::glsl::walk;

// A level of nesting is a dozen calls here, and readers of the tree recurse over it again: the
// limit keeps both within the stack.
const DEEPEST_EXPRESSION: u32 = 400;

fn too_deep(span: Span) -> SyntaxError {
    SyntaxError::TooDeep { span, what: "an expression nests", limit: DEEPEST_EXPRESSION }
}

impl<'a> Parser<'a> {
    // `deeper` bounds the recursion of the parser, this the height of the tree: `a + b + c + …` is
    // parsed by a loop, yet each operator makes the tree one level higher.
    fn expr(&self, kind: ExprKind<'a>, mark: Span, span: Span) -> Parsed<Expr<'a>> {
        let expr = Expr { kind, span, mark, depth: 0 };
        let mut below = 0;
        walk::operands(&expr, &mut |operand| below = below.max(operand.depth));
        if below >= DEEPEST_EXPRESSION {
            return Err(too_deep(span));
        }
        Ok(Expr { depth: below + 1, ..expr })
    }

    fn deeper<T>(&mut self, read: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        self.depth += 1;
        if self.depth > DEEPEST_EXPRESSION {
            return Err(too_deep(self.token().span));
        }
        let result = read(self);
        self.depth -= 1;
        result
    }

    /// Parses an expression, commas included.
    // expression: assignment_expression { COMMA assignment_expression }
    pub(super) fn expression(&mut self) -> Parsed<Expr<'a>> {
        let mut left = self.assignment()?;
        while self.is(",") {
            let mark = self.bump().span;
            let right = self.assignment()?;
            let span = left.span.to(right.span);
            left = self.expr(ExprKind::Comma(Box::new(left), Box::new(right)), mark, span)?;
        }
        Ok(left)
    }

    /// Parses an expression without commas.
    // assignment_expression: conditional_expression
    //     | unary_expression assignment_operator assignment_expression
    // The left side is read as a `conditional_expression`, of which `unary_expression` is a part:
    // after it the operator decides, without going back.
    pub(super) fn assignment(&mut self) -> Parsed<Expr<'a>> {
        self.deeper(|this| {
            let left = this.choice()?;
            let mark = this.token().span;
            let Some(operator) = this.assignment_operator() else { return Ok(left) };
            let right = this.assignment()?;
            let span = left.span.to(right.span);
            this.expr(ExprKind::Assign(operator, Box::new(left), Box::new(right)), mark, span)
        })
    }

    // `Some(None)` is `=` alone.
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
        if !self.is_pair(operator.name(), "=") {
            return None;
        }
        self.eat_two();
        Some(Some(operator))
    }

    // conditional_expression: logical_or_expression
    //     | logical_or_expression QUESTION expression COLON assignment_expression
    fn choice(&mut self) -> Parsed<Expr<'a>> {
        let mark = self.token().span;
        let condition = self.binary(0)?;
        if !self.eat("?") {
            return Ok(condition);
        }
        self.deeper(|this| {
            let accept = this.expression()?;
            this.expect(":")?;
            let reject = this.assignment()?;
            let span = condition.span.to(reject.span);
            this.expr(ExprKind::Choose(Box::new([condition, accept, reject])), mark, span)
        })
    }

    /// Parses operators that bind at least as tightly as `least` (GLSL 4.60 §5.1).
    // Precedence climbing over the eleven productions from `logical_or_expression` down to
    // `multiplicative_expression`. The right operand is read with `binds + 1`, so that equal
    // operators group from the left.
    fn binary(&mut self, least: u8) -> Parsed<Expr<'a>> {
        let mut left = self.unary()?;
        while let Some((operator, binds)) = self.binary_operator().filter(|o| o.1 >= least) {
            let mark = self.bump().span;
            let right = self.deeper(|this| this.binary(binds + 1))?;
            let span = left.span.to(right.span);
            let kind = ExprKind::Binary(operator, Box::new(left), Box::new(right));
            left = self.expr(kind, mark, span)?;
        }
        Ok(left)
    }

    // The number is 15 less the precedence of the table in §5.1: 14 for `||`, the loosest, to 4 for
    // `*`.
    fn binary_operator(&mut self) -> Option<(Binary, u8)> {
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
        // The levels whose operators have an assigning form: bits, shifts, sums and products. `<=`,
        // `>=` and `==` are tokens of their own.
        let assigns = matches!(found.1, 4..=6 | 9..);
        (!assigns || !self.is_pair(found.0.name(), "=")).then_some(found)
    }

    // unary_expression: postfix_expression | (INC_OP | DEC_OP) unary_expression
    //     | (PLUS | DASH | BANG | TILDE) unary_expression
    fn unary(&mut self) -> Parsed<Expr<'a>> {
        let start = self.token().span;
        for (sign, increment) in [("+", true), ("-", false)] {
            if self.is_pair(sign, sign) {
                self.eat_two();
                let inner = self.deeper(Self::unary)?;
                let span = start.to(inner.span);
                let step = IncrementOp { increment, before: true };
                return self.expr(ExprKind::Step(step, Box::new(inner)), start, span);
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
        let span = start.to(inner.span);
        self.expr(ExprKind::Unary(operator, Box::new(inner)), start, span)
    }

    // postfix_expression: primary_expression | function_call
    //     | postfix_expression LEFT_BRACKET integer_expression RIGHT_BRACKET
    //     | postfix_expression DOT FIELD_SELECTION | postfix_expression (INC_OP | DEC_OP)
    // `length()` is the only method (§4.1.9), so it is a kind of its own.
    fn postfix(&mut self) -> Parsed<Expr<'a>> {
        let mut left = self.primary()?;
        loop {
            let (start, mark) = (left.span, self.token().span);
            let (kind, mark) = if self.eat("[") {
                let index = self.expression()?;
                self.expect("]")?;
                (ExprKind::Index(Box::new(left), Box::new(index)), mark)
            } else if self.eat(".") {
                let name = self.name()?;
                if name.text == "length" && self.eat("(") {
                    self.expect(")")?;
                    (ExprKind::Length(Box::new(left)), name.span)
                } else {
                    (ExprKind::Member(Box::new(left), name), name.span)
                }
            } else if self.is_pair("+", "+") || self.is_pair("-", "-") {
                let step = IncrementOp { increment: self.is("+"), before: false };
                self.eat_two();
                (ExprKind::Step(step, Box::new(left)), mark)
            } else {
                return Ok(left);
            };
            left = self.expr(kind, mark, self.since(start))?;
        }
    }

    // primary_expression: variable_identifier | INTCONSTANT | UINTCONSTANT | FLOATCONSTANT
    //     | DOUBLECONSTANT | BOOLCONSTANT | LEFT_PAREN expression RIGHT_PAREN
    // initializer: assignment_expression | LEFT_BRACE initializer_list [COMMA] RIGHT_BRACE
    // Lists in braces are read wherever an expression may stand; only initialisers have them
    // (§4.1.11).
    fn primary(&mut self) -> Parsed<Expr<'a>> {
        let token = *self.token();
        let literal = |this: &mut Self, kind| {
            this.bump();
            this.expr(kind, token.span, token.span)
        };
        match token.kind {
            Kind::Number => literal(self, ExprKind::Number(token.text)),
            Kind::Name if matches!(token.text, "true" | "false") => {
                literal(self, ExprKind::Bool(token.text == "true"))
            }
            Kind::Name => self.named(),
            // A string for a debugger: it has no value.
            Kind::Text => literal(self, ExprKind::Number("0")),
            _ if token.is("(") => {
                self.bump();
                let mut inner = self.deeper(Self::expression)?;
                self.expect(")")?;
                inner.span = self.since(token.span);
                Ok(inner)
            }
            _ if token.is("{") => {
                self.bump();
                let items = self.deeper(|this| this.list("}"))?;
                self.expr(ExprKind::List(items), token.span, self.since(token.span))
            }
            _ => Err(self.unexpected(Wanted::Expression)),
        }
    }

    /// Parses a variable, a call or a constructor.
    // function_call:
    //     function_identifier LEFT_PAREN [VOID | assignment_expression { COMMA … }] RIGHT_PAREN
    // function_identifier: type_specifier | postfix_expression
    fn named(&mut self) -> Parsed<Expr<'a>> {
        let start = self.token().span;
        let text = self.token().text;
        // A structure's name before `(` parses as a call; its scope decides later.
        let meaning = builtin(text);
        let handle = matches!(meaning, Some(Builtin::Opaque));
        // `float[2](a, b)` constructs an array; `S[i]` is an index where S is a variable that hides
        // the structure, which `constructs_array` tells by the `(` after the brackets. Opaque types
        // have no constructors of arrays, and old versions use their names for functions
        // (`texture2D`).
        let array = self.ahead(1).is("[") && !handle;
        let constructs = (meaning.is_some() && self.ahead(1).is("("))
            || (array && (meaning.is_some() || self.structures.contains(text)));
        if constructs && (!array || self.constructs_array()) {
            let ty = self.type_spec()?;
            self.expect("(")?;
            let arguments = self.deeper(|this| this.list(")"))?;
            let kind = ExprKind::Construct(Box::new(ty), arguments);
            return self.expr(kind, start, self.since(start));
        }
        let name = self.name()?;
        if !self.eat("(") {
            return self.expr(ExprKind::Name(name.text), start, start);
        }
        let arguments = self.deeper(|this| this.list(")"))?;
        self.expr(ExprKind::Call(name, arguments), start, self.since(start))
    }

    /// Parses expressions up to `close`, which is consumed.
    fn list(&mut self, close: &'static str) -> Parsed<Vec<Expr<'a>>> {
        let mut items = Vec::new();
        // `f(void)` is a call without arguments.
        if self.is("void") && self.ahead(1).is(")") {
            self.bump();
        }
        while !self.eat(close) {
            items.push(self.assignment()?);
            if self.eat(",") {
                // Only lists in braces may end with a comma (GLSL 4.60 §9).
                if close == ")" && self.is(close) {
                    return Err(self.unexpected(Wanted::Expression));
                }
            } else if !self.is(close) {
                return Err(self.unexpected(Wanted::CommaOr(close)));
            }
        }
        Ok(items)
    }

    /// Whether the `NAME[…]` here continues with the `(` of a constructor.
    pub(super) fn constructs_array(&mut self) -> bool {
        let past = self.past_dims(1);
        self.ahead(past).is("(")
    }

    /// Returns the number of tokens up to the first one after all `[…]`.
    pub(super) fn past_dims(&mut self, mut ahead: usize) -> usize {
        while self.ahead(ahead).is("[") {
            let mut depth = 0u32;
            loop {
                let token = self.ahead(ahead);
                match token.text {
                    "[" => depth += 1,
                    "]" => depth -= 1,
                    _ if token.kind == Kind::End => return ahead,
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
