//! Evaluation of constant expressions: array sizes, layout qualifiers, `const` initialisers and
//! `#if` conditions (GLSL 4.60 §4.3.3).

use super::ast::{Binary, Expr, ExprKind, TypeBase, Unary};
use super::lexer::Token;
use super::parser::{Parser, SyntaxError, Wanted};
use super::types::{Builtin, builtin};
use crate::shape::{Scalar, ScalarKind, Type};
use crate::source::Span;
use crate::syntax::constant::{self, Fault, Kind, Value};

// What a name stands for is all that differs between lengths (constants of the shader), `#if` lines
// (undefined macros, 0) and `#line` (no names at all).
pub trait Names {
    /// Whether this is an `#if` condition, where truth is the integers 0 and 1, and `true` and
    /// `false` are names like others.
    const DIRECTIVE: bool = false;

    /// Returns the value of a name, or the reason it has none.
    fn value(&mut self, name: &str, span: Span) -> Result<Value, Problem>;

    /// Called before an operand that `&&` or `||` does not evaluate.
    fn begin_unevaluated(&mut self) {}

    /// Called after such an operand.
    fn end_unevaluated(&mut self) {}
}

/// The reason an expression has no value, with its place.
#[derive(Clone, Debug)]
pub struct Problem {
    pub span: Span,
    /// The reason, read after `the size`: `is not constant: …`.
    pub message: String,
    /// Whether the expression is constant, but an operation in it has no result.
    pub fault: bool,
    /// The name in it that is no constant.
    pub unknown: Option<String>,
}

impl Problem {
    pub fn new(span: Span, message: impl Into<String>) -> Problem {
        Problem { span, message: message.into(), fault: false, unknown: None }
    }
}

/// Evaluates an expression that spans all of `tokens`.
pub(crate) fn evaluate_tokens<N: Names>(
    tokens: &[Token<'_>],
    whole: Span,
    names: &mut N,
) -> Result<Value, Problem> {
    // Most sizes are a single number or name.
    if let [token] = tokens {
        match token.kind {
            super::lexer::Kind::Number => return number(token.text, token.span),
            super::lexer::Kind::Name if N::DIRECTIVE || !matches!(token.text, "true" | "false") => {
                return names.value(token.text, token.span);
            }
            _ => {}
        }
    }
    let parsed = Parser::expression_over(tokens).map_err(|error| unparsed(error, whole))?;
    evaluate(&parsed, names)
}

/// Returns a syntax error as the reason why a constant expression at `whole` has no value.
// Messages begin with what the expression is of (`the size …`), so those of the parser are put in
// its place in the sentence.
fn unparsed(error: SyntaxError, whole: Span) -> Problem {
    match error {
        SyntaxError::Unexpected { end: true, .. } => Problem::new(whole, "ends too early"),
        SyntaxError::Unexpected { span, found, wanted, .. } => {
            let message = match wanted {
                Wanted::Token(text) => format!("has `{found}` where `{text}` is expected"),
                Wanted::CommaOr(_) => format!("has `{found}` where `,` is expected"),
                Wanted::Name | Wanted::Expression | Wanted::End => {
                    format!("has an unexpected `{found}`")
                }
            };
            Problem::new(span, message)
        }
        SyntaxError::TooDeep { span, limit, .. } => {
            Problem::new(span, format!("is nested more than {limit} deep"))
        }
        SyntaxError::Other(diagnostic) => {
            let span = diagnostic.labels.first().map_or(whole, |label| label.at);
            Problem::new(span, format!("cannot be parsed: {}", diagnostic.message))
        }
    }
}

pub fn evaluate<N: Names>(e: &Expr<'_>, names: &mut N) -> Result<Value, Problem> {
    match N::DIRECTIVE.then(|| no_condition(&e.kind)).flatten() {
        Some(message) => Err(Problem::new(e.mark, message)),
        None => value_of(e, names),
    }
}

// `defined(A) && A > 1`: the right side is evaluated for its syntax, but names in it are not
// reported as undefined where the left side decides. Both sides of `?:` must be constant
// expressions (§4.3.3); an operation without a result is allowed in the side that is not chosen. An
// array or a structure is the list of its elements: only its `length()` or an element is of use.
fn value_of<N: Names>(e: &Expr<'_>, names: &mut N) -> Result<Value, Problem> {
    let fault = |fault, text: &str| problem(fault, text, e.mark);
    match &e.kind {
        ExprKind::Number(text) => number(text, e.mark),
        // GLSL 4.60 §3.3: the preprocessor knows no keywords.
        ExprKind::Bool(value) if N::DIRECTIVE => {
            names.value(if *value { "true" } else { "false" }, e.mark)
        }
        ExprKind::Bool(value) => Ok(Value::Bool(*value)),
        ExprKind::Name(name) => names.value(name, e.mark),
        ExprKind::Unary(op, inner) => {
            let value = evaluate(inner, names)?;
            let result = if N::DIRECTIVE && *op == Unary::Not {
                let truth = value.convert(Kind::Bool);
                truth.and_then(|v| constant::unary("!", &v)?.convert(Kind::Long))
            } else {
                constant::unary(op.name(), &value)
            };
            result.map_err(|why| fault(why, op.name()))
        }
        ExprKind::Binary(op, a, b) => {
            let a = evaluate(a, names)?;
            let truth = a.integer().map(|value| value != 0);
            let decided = N::DIRECTIVE
                && match op.name() {
                    "&&" => truth == Some(false),
                    "||" => truth == Some(true),
                    _ => false,
                };
            if decided {
                names.begin_unevaluated();
            }
            let b = evaluate(b, names);
            if decided {
                names.end_unevaluated();
            }
            let b = b?;
            let result = match N::DIRECTIVE {
                true => in_directive(*op, &a, &b),
                false => of_operands(*op, &a, &b),
            };
            result.map_err(|why| fault(why, op.name()))
        }
        ExprKind::Choose(parts) => {
            let [condition, accept, reject] = &**parts;
            let condition = evaluate(condition, names)?;
            let truth = condition
                .truth()
                .or_else(|| condition.integer().map(|v| v != 0))
                .ok_or_else(|| Problem::new(e.mark, "has a condition that is not a boolean"))?;
            let (chosen, other) = if truth { (accept, reject) } else { (reject, accept) };
            let (chosen, other) = (evaluate(chosen, names), evaluate(other, names));
            match other {
                // `N == 0 ? 1 : 8 / N` has a value even if N is 0.
                Err(problem) if !problem.fault => Err(problem),
                Err(_) | Ok(_) => chosen,
            }
        }
        ExprKind::Index(base, index) => {
            let (value, index) = (evaluate(base, names)?, evaluate(index, names)?);
            let at = index.integer().and_then(|i| usize::try_from(i).ok());
            match (&value, at) {
                (Value::List(items), Some(i)) if i < items.len() => Ok(items[i].clone()),
                _ => Err(Problem::new(e.mark, "has an index out of range")),
            }
        }
        ExprKind::Member(base, name) => swizzle(&evaluate(base, names)?, name.text, e.mark),
        ExprKind::Length(base) => match evaluate(base, names)? {
            Value::List(items) if i32::try_from(items.len()).is_ok() => {
                Ok(Value::Int(items.len() as i32))
            }
            _ => Err(Problem::new(e.mark, "takes the length of a value that is not an array")),
        },
        ExprKind::List(items) => list(items, names).map(Value::List),
        ExprKind::Construct(ty, arguments) => {
            let arguments = list(arguments, names)?;
            let name = match ty.base {
                TypeBase::Name(name) if ty.dims.is_empty() => name,
                TypeBase::Name(_) | TypeBase::Struct(_) => return Ok(Value::List(arguments)),
            };
            construct(name, &arguments)
                .unwrap_or_else(|| constant::call(name, &arguments))
                .map_err(|why| fault(why, name))
        }
        ExprKind::Call(name, arguments) => {
            let arguments = list(arguments, names)?;
            constant::call(name.text, &arguments).map_err(|why| fault(why, name.text))
        }
        ExprKind::Assign(op, ..) => {
            let text = op.map_or("=", Binary::name);
            Err(Problem::new(e.mark, format!("has an unexpected `{text}`")))
        }
        ExprKind::Step(step, _) => {
            let text = if step.increment { "+" } else { "-" };
            Err(Problem::new(e.mark, format!("has an unexpected `{text}`")))
        }
        ExprKind::Comma(..) => Err(Problem::new(e.mark, "has an unexpected `,`")),
    }
}

/// Returns what is wrong with an expression that no `#if` may have: its operators are `defined`,
/// those of one operand, and those of two on integers (GLSL 4.60 §3.3).
fn no_condition(kind: &ExprKind<'_>) -> Option<String> {
    let operator = match kind {
        ExprKind::Choose(_) => "?:",
        ExprKind::Binary(Binary::Xor, ..) => "^^",
        ExprKind::Index(..) => "[]",
        ExprKind::Member(..) | ExprKind::Length(_) => ".",
        ExprKind::List(_) => "{}",
        ExprKind::Call(name, _) => {
            return Some(format!("calls `{}`, which is no macro with parameters", name.text));
        }
        ExprKind::Construct(ty, _) => {
            let name = ty.base_name().unwrap_or("struct");
            return Some(format!("calls `{name}`, which is no macro with parameters"));
        }
        ExprKind::Number(_)
        | ExprKind::Bool(_)
        | ExprKind::Name(_)
        | ExprKind::Unary(..)
        | ExprKind::Binary(..)
        | ExprKind::Assign(..)
        | ExprKind::Step(..)
        | ExprKind::Comma(..) => return None,
    };
    Some(format!("has `{operator}`, which is no operator of conditions"))
}

fn list<N: Names>(items: &[Expr<'_>], names: &mut N) -> Result<Vec<Value>, Problem> {
    items.iter().map(|item| evaluate(item, names)).collect()
}

// GLSL 4.60 §5.9: `==` and `!=` compare vectors, matrices and arrays as a whole.
fn of_operands(op: Binary, a: &Value, b: &Value) -> Result<Value, Fault> {
    let result = constant::binary(op.name(), a, b)?;
    Ok(match op {
        Binary::Equal => Value::Bool(are_all(&result, true)),
        Binary::NotEqual => Value::Bool(!are_all(&result, false)),
        _ => result,
    })
}

/// Whether all components of the result of a comparison are a truth.
fn are_all(result: &Value, truth: bool) -> bool {
    match result {
        Value::List(items) => items.iter().all(|item| are_all(item, truth)),
        scalar => scalar.truth() == Some(truth),
    }
}

/// Evaluates an operator in an `#if` condition, where booleans are integers.
// Comparisons and logic yield 1 or 0.
fn in_directive(op: Binary, a: &Value, b: &Value) -> Result<Value, Fault> {
    let logic = matches!(op, Binary::And | Binary::Or | Binary::Xor);
    let operand = |v: &Value| if logic { v.convert(Kind::Bool) } else { Ok(v.clone()) };
    constant::binary(op.name(), &operand(a)?, &operand(b)?)?.convert(Kind::Long)
}

/// Converts a value to a scalar type; integers of 8 and 16 bits wrap.
pub(crate) fn converted(value: &Value, scalar: Scalar) -> Result<Value, Fault> {
    let wrapped = |value: Value| match (value, scalar.kind, scalar.width) {
        (Value::Int(v), ScalarKind::Sint, 1) => Value::Int(i32::from(v as i8)),
        (Value::Int(v), ScalarKind::Sint, 2) => Value::Int(i32::from(v as i16)),
        (Value::Uint(v), ScalarKind::Uint, 1) => Value::Uint(u32::from(v as u8)),
        (Value::Uint(v), ScalarKind::Uint, 2) => Value::Uint(u32::from(v as u16)),
        (other, ..) => other,
    };
    Ok(match value.convert(scalar.into())? {
        Value::List(items) => Value::List(items.into_iter().map(wrapped).collect()),
        single => wrapped(single),
    })
}

/// Evaluates a scalar or vector constructor; `None` if the name is not such a type.
// scalar ( x )    vector ( x )    vector ( components of all arguments in order )
// (§5.4.1, §5.4.2). Matrices have no value here: no length is made of one.
fn construct(name: &str, args: &[Value]) -> Option<Result<Value, Fault>> {
    let (scalar, size) = match builtin(name)? {
        Builtin::Data(Type::Scalar(scalar)) => (scalar, None),
        Builtin::Data(Type::Vector { scalar, rows }) => (scalar, Some(usize::from(rows))),
        _ => return None,
    };
    let mut components = Vec::new();
    for arg in args {
        match converted(arg, scalar) {
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

// §5.5; letters of different sets (`xg`) pass as well.
fn swizzle(value: &Value, name: &str, span: Span) -> Result<Value, Problem> {
    let wrong = || Problem::new(span, format!("selects `{name}`, which is not a component"));
    let Value::List(items) = value else { return Err(wrong()) };
    let mut picked = Vec::new();
    for letter in name.chars() {
        let sets = ["xyzw", "rgba", "stpq"];
        let index = sets.iter().find_map(|set| set.find(letter)).ok_or_else(wrong)?;
        picked.push(items.get(index).ok_or_else(wrong)?.clone());
    }
    Ok(if picked.len() == 1 { picked.swap_remove(0) } else { Value::List(picked) })
}

fn problem(fault: Fault, text: &str, span: Span) -> Problem {
    let message = match fault {
        Fault::DivisionByZero => "divides by zero".to_string(),
        Fault::Overflow => "overflows".to_string(),
        Fault::Mismatch => format!("has operands that do not fit `{text}`"),
        Fault::Unsupported => format!("calls `{text}`, which landfall does not evaluate"),
    };
    Problem { fault: true, ..Problem::new(span, message) }
}

fn number(text: &str, span: Span) -> Result<Value, Problem> {
    match literal(text) {
        Ok((value, _)) => Ok(value),
        Err(NotANumber::Malformed) => {
            Err(Problem::new(span, format!("has `{text}`, which is not a number")))
        }
        Err(NotANumber::TooLarge) => {
            Err(Problem::new(span, format!("has `{text}`, which does not fit 32 bits")))
        }
    }
}

/// The reason a literal has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotANumber {
    /// The spelling is not that of a number.
    Malformed,
    /// An integer that does not fit 32 bits, without a suffix for 64.
    TooLarge,
}

/// Parses a literal to its value and type (GLSL 4.60 §4.1.3 and §4.1.4).
///
/// # Errors
/// The literal is malformed or too large.
pub fn literal(text: &str) -> Result<(Value, Scalar), NotANumber> {
    let lower = text.to_ascii_lowercase();
    // floating-constant: digits . digits [e sign digits] [f | lf | hf]     (§4.1.4)
    // integer-constant: (0x hex-digits | 0 octal-digits | digits) [u | l | ul | s | us]  (§4.1.3)
    // `hf`, `l` and `s` are of GL_EXT_shader_explicit_arithmetic_types.
    let hex = lower.starts_with("0x");
    if !hex && (lower.contains(['.', 'e']) || lower.ends_with('f')) {
        let (digits, width) = match (lower.strip_suffix("lf"), lower.strip_suffix("hf")) {
            (Some(digits), _) => (digits, 8),
            (_, Some(digits)) => (digits, 2),
            _ => (lower.strip_suffix('f').unwrap_or(&lower), 4),
        };
        let value = digits.parse().map_err(|_| NotANumber::Malformed)?;
        return Ok((Value::Float(value), Scalar { kind: ScalarKind::Float, width }));
    }
    let digits = lower.trim_end_matches(['u', 'l', 's']);
    let suffix = &lower[digits.len()..];
    let (kind, width) = match suffix {
        "" => (ScalarKind::Sint, 4),
        "u" => (ScalarKind::Uint, 4),
        "l" => (ScalarKind::Sint, 8),
        "ul" => (ScalarKind::Uint, 8),
        "s" => (ScalarKind::Sint, 2),
        "us" => (ScalarKind::Uint, 2),
        _ => return Err(NotANumber::Malformed),
    };
    let bits = match digits {
        _ if hex => u64::from_str_radix(&digits[2..], 16),
        _ if digits.len() > 1 && digits.starts_with('0') => u64::from_str_radix(&digits[1..], 8),
        _ => digits.parse(),
    }
    .map_err(|_| NotANumber::Malformed)?;
    let value = match (kind, width) {
        (ScalarKind::Uint, 8) => Value::Ulong(bits),
        (_, 8) => Value::Long(bits as i64),
        _ if bits > u64::from(u32::MAX) => return Err(NotANumber::TooLarge),
        (ScalarKind::Uint, _) => Value::Uint(bits as u32),
        // A literal past 2^31 keeps its bits, so that `0xffffffff` is -1; kept wide for sizes.
        _ if bits > i32::MAX as u64 && !hex => Value::Long(bits as i64),
        _ => Value::Int(bits as u32 as i32),
    };
    Ok((value, Scalar { kind, width }))
}
