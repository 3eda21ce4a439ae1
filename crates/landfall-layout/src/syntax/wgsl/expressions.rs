//! Const-expressions and override-expressions (§8), evaluated while parsing.

use super::constants::{self, ConstantError, Outcome};
use super::lexer::{Kind, WgslLexer, WgslToken};
use super::outline::Class;
use super::reader::{EXPRESSION_LEVEL, ModuleReader};
use super::report::{self, Refused};
use super::{numbers, predeclared, types};
use crate::shape::{ArrayLen, Type};
use crate::source::Span;
use crate::syntax::constant::{self, Fault, Value};

/// The context of an expression: in a template list `>` ends it.
// WGSL finds template lists before it parses (§3.9), so `array<f32, a>b>` ends at the first `>`.
// Here the parser knows by the name before `<` that a list is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExpressionContext {
    Template,
    Statement,
}

/// Parses and evaluates an expression; returns its value and span.
pub(super) fn read<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    within: ExpressionContext,
) -> Result<(Outcome, Span), Refused> {
    let start = lexer.peek().start;
    let (outcome, end) = binary(reader, lexer, within, 0)?;
    Ok((outcome, Span { file: 0, start, end }))
}

/// An outcome and the end of its text.
type Part = (Outcome, u32);

// Precedence climbing, as in C. WGSL's grammar is narrower: `a & b | c` and `a << b + c` need
// parentheses there. What it has groups the same here.
fn binary<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    within: ExpressionContext,
    weakest: u8,
) -> Result<Part, Refused> {
    let start = lexer.peek().start;
    let (mut left, mut end) = unary(reader, lexer)?;
    while let Some((op, strength)) = operator(lexer, within) {
        if strength <= weakest {
            break;
        }
        let first = lexer.next();
        // The lexer gives one sign a token; the second of `<<` is passed by its place.
        lexer.jump(first.start + op.len() as u32);
        let (right, right_end) =
            reader.deeper(report::span(first), EXPRESSION_LEVEL, |reader| {
                binary(reader, lexer, within, strength)
            })?;
        end = right_end;
        let at = Span { file: 0, start, end };
        left = match (op, left) {
            // §8.8: the right side matters only if the left does not decide the result.
            ("&&", Ok(Value::Bool(false))) => Ok(Value::Bool(false)),
            ("||", Ok(Value::Bool(true))) => Ok(Value::Bool(true)),
            (_, Ok(a)) => right.and_then(|b| {
                constant::binary(op, &a, &b).map_err(|fault| ConstantError::Fault(fault, at))
            }),
            (_, Err(trouble)) => Err(trouble),
        };
    }
    Ok((left, end))
}

/// Returns the next binary operator and its precedence.
// Longer operators first. `>>` and `>=` in a template list are the end of the list, and what
// follows.
fn operator(lexer: &mut WgslLexer<'_>, within: ExpressionContext) -> Option<(&'static str, u8)> {
    let token = lexer.peek();
    let Kind::Sign(first) = token.kind else { return None };
    let second = lexer.text().as_bytes().get(token.end as usize).copied();
    Some(match (first, second) {
        (b'>', _) if within == ExpressionContext::Template => return None,
        (b'|', Some(b'|')) => ("||", 1),
        (b'&', Some(b'&')) => ("&&", 2),
        (b'|', _) => ("|", 3),
        (b'^', _) => ("^", 4),
        (b'&', _) => ("&", 5),
        (b'=', Some(b'=')) => ("==", 6),
        (b'!', Some(b'=')) => ("!=", 6),
        (b'<', Some(b'<')) => ("<<", 8),
        (b'>', Some(b'>')) => (">>", 8),
        (b'<', Some(b'=')) => ("<=", 7),
        (b'>', Some(b'=')) => (">=", 7),
        (b'<', _) => ("<", 7),
        (b'>', _) => (">", 7),
        (b'+', _) => ("+", 9),
        (b'-', _) => ("-", 9),
        (b'*', _) => ("*", 10),
        (b'/', _) => ("/", 10),
        (b'%', _) => ("%", 10),
        _ => return None,
    })
}

// unary_expression: singular_expression | ( `-` | `!` | `~` | `*` | `&` ) unary_expression
// Pointers have no values here, so `*` and `&` are not read.
fn unary<'a>(reader: &mut ModuleReader<'a>, lexer: &mut WgslLexer<'a>) -> Result<Part, Refused> {
    let token = lexer.peek();
    let op = match token.kind {
        Kind::Sign(b'-') => "-",
        Kind::Sign(b'!') => "!",
        Kind::Sign(b'~') => "~",
        Kind::Word | Kind::Number | Kind::Sign(_) | Kind::End => {
            return postfix(reader, lexer);
        }
    };
    lexer.next();
    let (inner, end) =
        reader.deeper(report::span(token), EXPRESSION_LEVEL, |reader| unary(reader, lexer))?;
    let at = Span { file: 0, start: token.start, end };
    let outcome = inner.and_then(|value| {
        constant::unary(op, &value).map_err(|fault| ConstantError::Fault(fault, at))
    });
    Ok((outcome, end))
}

/// Parses a primary expression with any `.x` and `[i]` after it.
// singular_expression: primary_expression component_or_swizzle_specifier?
// component_or_swizzle_specifier: ( `[` expression `]` | `.` member_ident | `.` swizzle_name )+
fn postfix<'a>(reader: &mut ModuleReader<'a>, lexer: &mut WgslLexer<'a>) -> Result<Part, Refused> {
    let start = lexer.peek().start;
    let (mut outcome, mut end) = primary(reader, lexer)?;
    loop {
        if lexer.take(b'.') {
            let name = reader.reports.checked(report::word(lexer, "a name"))?;
            end = name.end;
            let at = Span { file: 0, start, end };
            outcome = outcome.and_then(|value| swizzle(&value, lexer.text_of(name), at));
        } else if lexer.peek().is(b'[') {
            let open = lexer.next();
            let (index, _) = reader.deeper(report::span(open), EXPRESSION_LEVEL, |reader| {
                read(reader, lexer, ExpressionContext::Statement)
            })?;
            end = lexer.peek().end;
            reader.expect(lexer, b']')?;
            let at = Span { file: 0, start, end };
            outcome = outcome.and_then(|value| element(&value, &index?, at));
        } else {
            return Ok((outcome, end));
        }
    }
}

fn swizzle(value: &Value, names: &str, at: Span) -> Outcome {
    let Value::List(items) = value else {
        return Err(ConstantError::Fault(Fault::Unsupported, at));
    };
    let component = |name: char| {
        let index = "xyzw".find(name).or_else(|| "rgba".find(name));
        index.and_then(|i| items.get(i)).cloned().ok_or(ConstantError::Fault(Fault::Mismatch, at))
    };
    let mut picked = names.chars().map(component).collect::<Result<Vec<_>, _>>()?;
    Ok(if picked.len() == 1 { picked.remove(0) } else { Value::List(picked) })
}

fn element(value: &Value, index: &Value, at: Span) -> Outcome {
    let (Value::List(items), Some(index)) = (value, index.integer()) else {
        return Err(ConstantError::Fault(Fault::Unsupported, at));
    };
    let item = usize::try_from(index).ok().and_then(|i| items.get(i));
    item.cloned().ok_or(ConstantError::Fault(Fault::Mismatch, at))
}

// primary_expression: template_elaborated_ident | call_phrase | literal | `(` expression `)`
fn primary<'a>(reader: &mut ModuleReader<'a>, lexer: &mut WgslLexer<'a>) -> Result<Part, Refused> {
    let token = lexer.next();
    let at = report::span(token);
    match token.kind {
        Kind::Number => match numbers::literal(lexer.text_of(token)) {
            Some(value) => Ok((Ok(value), token.end)),
            None => Err(reader.reports.refuse(report::bad_number(lexer, token))),
        },
        Kind::Sign(b'(') => {
            let (outcome, _) = reader.deeper(at, EXPRESSION_LEVEL, |reader| {
                read(reader, lexer, ExpressionContext::Statement)
            })?;
            let end = lexer.peek().end;
            reader.expect(lexer, b')')?;
            Ok((outcome, end))
        }
        Kind::Word => match lexer.text_of(token) {
            "true" => Ok((Ok(Value::Bool(true)), token.end)),
            "false" => Ok((Ok(Value::Bool(false)), token.end)),
            name => word(reader, lexer, token, name),
        },
        Kind::Sign(_) | Kind::End => {
            Err(reader.reports.refuse(report::unexpected(lexer, token, "an expression")))
        }
    }
}

/// Parses a constant, a constructor, or a call of a builtin function.
// Declared names hide predeclared ones (§5). Text is parsed to its end even where the value is
// known to be missing: only a syntax error ends it.
fn word<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    token: WgslToken,
    name: &str,
) -> Result<Part, Refused> {
    let at = report::span(token);
    if let Some(&index) = reader.outline.names.get(name) {
        return match reader.outline.items[index].class {
            Class::Const | Class::Override => {
                Ok((constants::value_of(reader, index, at), token.end))
            }
            Class::Struct | Class::Alias => constructor(reader, lexer, token),
            Class::Var | Class::Fn => {
                let mut end = token.end;
                if lexer.take(b'(') {
                    end = arguments(reader, lexer)?.1;
                }
                Ok((Err(ConstantError::NotConstant(at, index)), end))
            }
        };
    }
    if predeclared::lookup(name).is_some() {
        return constructor(reader, lexer, token);
    }
    // `bitcast<T>(…)` is skipped here and evaluated by naga.
    let template = lexer.peek().is(b'<') && name == "bitcast";
    if template {
        lexer.next();
        types::read(reader, lexer)?;
        reader.expect(lexer, b'>')?;
    }
    if !lexer.take(b'(') {
        return Ok((Err(ConstantError::Unknown(at)), token.end));
    }
    let (values, end) = arguments(reader, lexer)?;
    let whole = Span { file: 0, start: token.start, end };
    let outcome = values.and_then(|values| {
        let result = constant::call(name, &values);
        result.map_err(|fault| ConstantError::Fault(fault, whole))
    });
    Ok((outcome, end))
}

/// Parses the values after a `(` up to and including its `)`.
// argument_expression_list: `(` ( expression ( `,` expression )* `,`? )? `)`
fn arguments<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
) -> Result<(Result<Vec<Value>, ConstantError>, u32), Refused> {
    let mut values = Ok(Vec::new());
    loop {
        let next = lexer.peek();
        if lexer.take(b')') {
            return Ok((values, next.end));
        }
        let (outcome, _) = reader.deeper(report::span(next), EXPRESSION_LEVEL, |reader| {
            read(reader, lexer, ExpressionContext::Statement)
        })?;
        values = match (values, outcome) {
            (Ok(mut values), Ok(value)) => {
                values.push(value);
                Ok(values)
            }
            (Err(trouble), _) | (Ok(_), Err(trouble)) => Err(trouble),
        };
        let end = lexer.peek().end;
        if !lexer.take(b',') {
            reader.expect(lexer, b')')?;
            return Ok((values, end));
        }
    }
}

/// Parses `u32(x)`, `vec2<f32>(x, y)`, `vec3(x)`, `array(a, b)`.
fn constructor<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    token: WgslToken,
) -> Result<Part, Refused> {
    let name = lexer.text_of(token);
    let at = report::span(token);
    // `vec3(1, 2, 3)` and `array(a, b)` infer their component; a vector without one has its values
    // as they are.
    let templated = lexer.peek().is(b'<') || !matches!(name, "vec2" | "vec3" | "vec4" | "array");
    let ty = if templated { Some(types::constructed(reader, lexer, token)?) } else { None };
    reader.expect(lexer, b'(')?;
    let (values, end) = arguments(reader, lexer)?;
    let whole = Span { file: 0, start: at.start, end };
    let outcome = values.and_then(|values| {
        let made = match &ty {
            Some(ty) => ty.as_ref().map_or(Err(Fault::Unsupported), |ty| construct(ty, values)),
            None => match name.as_bytes() {
                [b'v', b'e', b'c', rows] => vector(usize::from(rows - b'0'), values),
                _ => Ok(Value::List(values)),
            },
        };
        made.map_err(|fault| ConstantError::Fault(fault, whole))
    });
    Ok((outcome, end))
}

fn construct(ty: &Type, values: Vec<Value>) -> Result<Value, Fault> {
    match ty {
        Type::Scalar(scalar) => match values.as_slice() {
            // `T()` is the zero value of T.
            [] => constants::convert(&Value::Abstract(0), *scalar),
            [value] => constants::convert(value, *scalar),
            _ => Err(Fault::Mismatch),
        },
        Type::Vector { scalar, rows } => {
            let values = if values.is_empty() { vec![Value::Abstract(0)] } else { values };
            constants::convert(&vector(usize::from(*rows), values)?, *scalar)
        }
        Type::Array { len: ArrayLen::Fixed(n), .. } if values.len() == *n as usize => {
            let list = Value::List(values);
            match constants::component(ty) {
                Some(scalar) => constants::convert(&list, scalar),
                None => Ok(list),
            }
        }
        Type::Array { .. }
        | Type::Atomic(_)
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_) => Err(Fault::Unsupported),
    }
}

/// Builds a vector from scalars and vectors; a single scalar fills it.
fn vector(rows: usize, values: Vec<Value>) -> Result<Value, Fault> {
    let mut components = Vec::with_capacity(rows);
    for value in values {
        match value {
            Value::List(items) => components.extend(items),
            scalar => components.push(scalar),
        }
    }
    if let [only] = components.as_slice() {
        components = vec![only.clone(); rows];
    }
    if components.len() != rows {
        return Err(Fault::Mismatch);
    }
    Ok(Value::List(components))
}
