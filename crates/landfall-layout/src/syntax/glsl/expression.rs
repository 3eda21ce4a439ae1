//! The grammar of constant expressions, over a slice of tokens: array sizes,
//! layout qualifiers, `const` initialisers and `#if` conditions.

use super::lexer::{Kind, Token};
use crate::source::Span;
use crate::syntax::constant;
use crate::syntax::constant::{Fault, Kind as Scalar, Value};

/// Deepest nesting of brackets and operators in one expression.
const DEEPEST: u32 = 100;

/// What names mean in an expression.
pub trait Names<'a> {
    /// Whether this is an `#if` condition, where truth values are the integers 0 and 1.
    const DIRECTIVE: bool = false;

    /// The value of a name, or why it has none.
    fn value(&mut self, name: &Token<'a>) -> Result<Value, Problem>;

    /// An operand begins that `&&` or `||` does not evaluate.
    fn begin_unevaluated(&mut self) {}

    /// That operand ends.
    fn end_unevaluated(&mut self) {}
}

/// Why an expression has no value, and where.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Where.
    pub span: Span,
    /// Why, to be read after `the size`: `is not constant: …`.
    pub message: String,
}

impl Problem {
    /// A problem at a token.
    pub fn new(span: Span, message: impl Into<String>) -> Problem {
        Problem { span, message: message.into() }
    }
}

/// The value of an expression that takes up all of `tokens`.
pub fn evaluate<'a>(
    tokens: &[Token<'a>],
    whole: Span,
    names: &mut impl Names<'a>,
) -> Result<Value, Problem> {
    let mut reader = Reader { tokens, at: 0, whole, depth: 0, names };
    let value = reader.ternary()?;
    match reader.peek() {
        None => Ok(value),
        Some(token) => Err(Problem::new(token.span, format!("has an unexpected `{}`", token.text))),
    }
}

struct Reader<'t, 'a, N> {
    tokens: &'t [Token<'a>],
    at: usize,
    whole: Span,
    depth: u32,
    names: &'t mut N,
}

/// Binary operators from the loosest to the tightest (GLSL 4.60 §5.1).
const LEVELS: &[&[&str]] = &[
    &["||"],
    &["^^"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<", ">", "<=", ">="],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

impl<'a, N: Names<'a>> Reader<'_, 'a, N> {
    fn peek(&self) -> Option<&Token<'a>> {
        self.tokens.get(self.at)
    }

    fn next(&mut self) -> Result<Token<'a>, Problem> {
        let token = self.peek().copied();
        self.at += 1;
        token.ok_or_else(|| Problem::new(self.whole, "ends too early"))
    }

    fn eat(&mut self, text: &str) -> bool {
        let found = self.peek().is_some_and(|token| token.is(text));
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, text: &str) -> Result<(), Problem> {
        let token = self.next()?;
        if token.is(text) {
            return Ok(());
        }
        Err(Problem::new(token.span, format!("has `{}` where `{text}` is wanted", token.text)))
    }

    fn deeper<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        if self.depth == DEEPEST {
            let span = self.peek().map_or(self.whole, |token| token.span);
            return Err(Problem::new(span, format!("is nested more than {DEEPEST} deep")));
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }

    fn ternary(&mut self) -> Result<Value, Problem> {
        self.deeper(|reader| {
            let start = reader.at;
            let condition = reader.binary(0)?;
            if !reader.eat("?") {
                return Ok(condition);
            }
            let span = reader.tokens[start].span;
            let yes = reader.ternary()?;
            reader.expect(":")?;
            let no = reader.ternary()?;
            let truth = condition
                .truth()
                .or_else(|| condition.integer().map(|v| v != 0))
                .ok_or_else(|| Problem::new(span, "has a condition that is no truth value"))?;
            Ok(if truth { yes } else { no })
        })
    }

    /// Operators of `loosest` level and tighter, by precedence climbing.
    fn binary(&mut self, loosest: usize) -> Result<Value, Problem> {
        let mut left = self.unary()?;
        loop {
            let Some(token) = self.peek().copied() else { return Ok(left) };
            let level = LEVELS.iter().position(|level| level.contains(&token.text));
            let Some(level) = level.filter(|&level| level >= loosest) else { return Ok(left) };
            self.at += 1;
            let decided = N::DIRECTIVE
                && match token.text {
                    "&&" => left.integer() == Some(0),
                    "||" => left.integer().is_some_and(|value| value != 0),
                    _ => false,
                };
            if decided {
                self.names.begin_unevaluated();
            }
            let right = self.deeper(|reader| reader.binary(level + 1))?;
            if decided {
                self.names.end_unevaluated();
            }
            left = self.apply(&token, &left, &right).map_err(|fault| problem(fault, &token))?;
        }
    }

    fn apply(&self, token: &Token<'a>, left: &Value, right: &Value) -> Result<Value, Fault> {
        if !N::DIRECTIVE {
            return constant::binary(token.text, left, right);
        }
        let logic = matches!(token.text, "&&" | "||" | "^^");
        let operand = |v: &Value| if logic { v.convert(Scalar::Bool) } else { Ok(v.clone()) };
        constant::binary(token.text, &operand(left)?, &operand(right)?)?.convert(Scalar::Long)
    }

    fn unary(&mut self) -> Result<Value, Problem> {
        let Some(token) = self.peek().copied() else { return self.postfix() };
        if token.kind != Kind::Punctuation || !matches!(token.text, "-" | "+" | "!" | "~") {
            return self.postfix();
        }
        self.at += 1;
        let value = self.deeper(Self::unary)?;
        let result = if N::DIRECTIVE && token.is("!") {
            value
                .convert(Scalar::Bool)
                .and_then(|v| constant::unary("!", &v)?.convert(Scalar::Long))
        } else {
            constant::unary(token.text, &value)
        };
        result.map_err(|fault| problem(fault, &token))
    }

    fn postfix(&mut self) -> Result<Value, Problem> {
        let mut value = self.primary()?;
        loop {
            if self.eat(".") {
                let name = self.next()?;
                value = if name.is("length") {
                    self.expect("(")?;
                    self.expect(")")?;
                    length(&value).ok_or_else(|| {
                        Problem::new(name.span, "asks for the length of what is no array")
                    })?
                } else {
                    swizzle(&value, &name)?
                };
            } else if let Some(bracket) = self.peek().copied().filter(|token| token.is("[")) {
                self.at += 1;
                let index = self.ternary()?;
                self.expect("]")?;
                let at = index.integer().and_then(|i| usize::try_from(i).ok());
                value = match (&value, at) {
                    (Value::List(items), Some(i)) if i < items.len() => items[i].clone(),
                    _ => return Err(Problem::new(bracket.span, "has an index out of range")),
                };
            } else {
                return Ok(value);
            }
        }
    }

    fn primary(&mut self) -> Result<Value, Problem> {
        let token = self.next()?;
        match token.kind {
            Kind::Number => number(&token),
            Kind::Name => match token.text {
                "true" => Ok(Value::Bool(true)),
                "false" => Ok(Value::Bool(false)),
                _ if self.peek().is_some_and(|next| next.is("(") || next.is("[")) => {
                    self.call(token)
                }
                _ => self.names.value(&token),
            },
            Kind::Punctuation if token.is("(") => {
                let value = self.ternary()?;
                self.expect(")")?;
                Ok(value)
            }
            Kind::Punctuation if token.is("{") => Ok(Value::List(self.list("}")?)),
            Kind::Punctuation | Kind::Text | Kind::Stray | Kind::End => {
                Err(Problem::new(token.span, format!("has an unexpected `{}`", token.text)))
            }
        }
    }

    /// A constructor or function call; or a name that is indexed.
    fn call(&mut self, name: Token<'a>) -> Result<Value, Problem> {
        let start = self.at;
        let mut dimensions = 0;
        // `int[](1, 2)` and `int[2](1, 2)` construct an array.
        while self.eat("[") {
            while !self.eat("]") {
                self.next()?;
            }
            dimensions += 1;
        }
        if !self.eat("(") {
            self.at = start;
            return self.names.value(&name);
        }
        let args = self.list(")")?;
        if dimensions > 0 {
            return Ok(Value::List(args));
        }
        construct(name.text, &args)
            .unwrap_or_else(|| constant::call(name.text, &args))
            .map_err(|fault| problem(fault, &name))
    }

    /// Expressions separated by commas up to `close`.
    fn list(&mut self, close: &str) -> Result<Vec<Value>, Problem> {
        let mut items = Vec::new();
        while !self.eat(close) {
            if !items.is_empty() {
                self.expect(",")?;
                if self.eat(close) {
                    break;
                }
            }
            items.push(self.ternary()?);
        }
        Ok(items)
    }
}

/// A scalar or vector constructor; `None` when the name is no constructor.
fn construct(name: &str, args: &[Value]) -> Option<Result<Value, Fault>> {
    let (prefix, size) = match name.split_once("vec") {
        Some((prefix, size)) => (prefix, Some(size.parse::<usize>().ok()?)),
        None => (name, None),
    };
    let kind = match (prefix, size) {
        ("int" | "int8_t" | "int16_t" | "int32_t", None) | ("i", Some(_)) => Scalar::Int,
        ("uint" | "uint8_t" | "uint16_t" | "uint32_t", None) | ("u", Some(_)) => Scalar::Uint,
        ("bool", None) | ("b", Some(_)) => Scalar::Bool,
        ("float" | "double" | "float16_t" | "float32_t" | "float64_t", None)
        | ("" | "d" | "f16", Some(_)) => Scalar::Float,
        ("int64_t", None) | ("i64", Some(_)) => Scalar::Long,
        ("uint64_t", None) | ("u64", Some(_)) => Scalar::Ulong,
        _ => return None,
    };
    let mut components = Vec::new();
    for arg in args {
        match arg.convert(kind) {
            Ok(Value::List(items)) => components.extend(items),
            Ok(scalar) => components.push(scalar),
            Err(fault) => return Some(Err(fault)),
        }
    }
    Some(match (size, components.len()) {
        (_, 0) => Err(Fault::Mismatch),
        (None, _) => Ok(components.swap_remove(0)),
        // GLSL 4.60 §5.4.2: one scalar fills all components; surplus components are dropped.
        (Some(size), 1) => Ok(Value::List(vec![components[0].clone(); size])),
        (Some(size), count) if count >= size => {
            components.truncate(size);
            Ok(Value::List(components))
        }
        (Some(_), _) => Err(Fault::Mismatch),
    })
}

fn length(value: &Value) -> Option<Value> {
    match value {
        Value::List(items) => Some(Value::Int(i32::try_from(items.len()).ok()?)),
        _ => None,
    }
}

fn swizzle(value: &Value, name: &Token<'_>) -> Result<Value, Problem> {
    let wrong =
        || Problem::new(name.span, format!("selects `{}`, which is no component", name.text));
    let Value::List(items) = value else { return Err(wrong()) };
    let mut picked = Vec::new();
    for letter in name.text.chars() {
        let sets = ["xyzw", "rgba", "stpq"];
        let index = sets.iter().find_map(|set| set.find(letter)).ok_or_else(wrong)?;
        picked.push(items.get(index).ok_or_else(wrong)?.clone());
    }
    Ok(if picked.len() == 1 { picked.swap_remove(0) } else { Value::List(picked) })
}

fn problem(fault: Fault, token: &Token<'_>) -> Problem {
    let message = match fault {
        Fault::DivisionByZero => "divides by zero".to_string(),
        Fault::Overflow => "overflows".to_string(),
        Fault::Mismatch => format!("has operands that do not fit `{}`", token.text),
        Fault::Unsupported => {
            format!("calls `{}`, which landfall does not evaluate", token.text)
        }
    };
    Problem::new(token.span, message)
}

/// The value of a literal (GLSL 4.60 §4.1.3 and §4.1.4).
fn number(token: &Token<'_>) -> Result<Value, Problem> {
    let text = token.text;
    let wrong = || Problem::new(token.span, format!("has `{text}`, which is no number"));
    let lower = text.to_ascii_lowercase();
    let hex = lower.starts_with("0x");
    let float = !hex && (lower.contains('.') || lower.contains('e') || lower.ends_with('f'));
    if float {
        let digits = lower.trim_end_matches("lf").trim_end_matches("hf").trim_end_matches('f');
        return digits.parse().map(Value::Float).map_err(|_| wrong());
    }
    let unsigned = lower.contains('u');
    let digits = lower.trim_end_matches(['u', 'l', 's']);
    let wide = lower.ends_with('l');
    let bits = match digits {
        "" => return Err(wrong()),
        _ if hex => u64::from_str_radix(&digits[2..], 16),
        _ if digits.len() > 1 && digits.starts_with('0') => u64::from_str_radix(&digits[1..], 8),
        _ => digits.parse(),
    }
    .map_err(|_| wrong())?;
    match (wide, unsigned) {
        (true, true) => Ok(Value::Ulong(bits)),
        (true, false) => Ok(Value::Long(bits as i64)),
        (false, _) if bits > u64::from(u32::MAX) => {
            Err(Problem::new(token.span, format!("has `{text}`, which does not fit 32 bits")))
        }
        (false, true) => Ok(Value::Uint(bits as u32)),
        // A literal past 2^31 keeps its bits, so that `0xffffffff` is -1; kept wide for sizes.
        (false, false) if bits > i32::MAX as u64 && !hex => Ok(Value::Long(bits as i64)),
        (false, false) => Ok(Value::Int(bits as u32 as i32)),
    }
}
