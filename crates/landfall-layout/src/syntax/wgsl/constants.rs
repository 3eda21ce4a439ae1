//! Module-scope constants and overrides, evaluated when a size depends on them.

use super::expressions::{self, ExpressionContext};
use super::lexer::WgslLexer;
use super::outline::Class;
use super::reader::{EXPRESSION_LEVEL, Known, ModuleReader};
use super::report::{self, Refused};
use super::types::{self, Meaning};
use super::{attributes, fallback, numbers};
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{Scalar, Type};
use crate::source::Span;
use crate::syntax::constant::{self, Fault, Kind, Value};

/// The value of an expression, or the reason it has none.
pub(super) type Outcome = Result<Value, ConstantError>;

/// The reason a parsed expression has no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ConstantError {
    /// Evaluation failed; the span is the part at fault.
    Fault(Fault, Span),
    /// It depends on an override without a value: the override's index in the outline.
    Valueless(usize),
    /// It contains an undeclared name.
    Unknown(Span),
    /// It contains a declaration that is not a constant: its index in the outline.
    NotConstant(Span, usize),
    /// A part of it failed to parse; the error is reported.
    Refused,
}

/// The depth from which constants that depend on one another are evaluated in text order.
// Well below the limit on nesting, so that the constants which `sweep` reads have room of their
// own.
const DEEP_CHAIN: u32 = 64;

// Constants are evaluated where they are first used. In a chain of thousands each use would nest in
// the one before; `sweep` evaluates in an order in which what is used is known.
pub(super) fn value_of(reader: &mut ModuleReader<'_>, index: usize, at: Span) -> Outcome {
    reader.used_override |= reader.outline.items[index].class == Class::Override;
    match reader.constants.get(&index) {
        Some(Known::Done(outcome)) => return outcome.clone(),
        Some(Known::Broken) => return Err(ConstantError::Refused),
        Some(Known::Open) => {
            let item = &reader.outline.items[index];
            let message = format!("`{}` depends on its own value", item.name);
            reader.reports.push(
                Diagnostic::error(Code::RecursiveConstant, at, message)
                    .with_label(item.name_span, "defined here"),
            );
            return Err(ConstantError::Refused);
        }
        None => {}
    }
    let read = match reader.outline.items[index].class {
        Class::Const => constant,
        Class::Override => override_value,
        Class::Struct | Class::Alias | Class::Var | Class::Fn => {
            return Err(ConstantError::NotConstant(at, index));
        }
    };
    if reader.depth > DEEP_CHAIN && !reader.swept {
        reader.swept = true;
        sweep(reader, index, at);
    }
    reader.constants.insert(index, Known::Open);
    let result = reader.deeper(at, EXPRESSION_LEVEL, |reader| read(reader, index));
    let outcome = result.unwrap_or(Err(ConstantError::Refused));
    reader.constants.insert(index, Known::Done(outcome.clone()));
    outcome
}

/// Evaluates the constants beside a deep one, so that it needs no nesting: those before it, and from
/// the last those after it, as what a module imports follows it.
fn sweep(reader: &mut ModuleReader<'_>, index: usize, at: Span) {
    let after = (index + 1..reader.outline.items.len()).rev();
    for other in (0..index).chain(after) {
        let constant = reader.outline.items[other].class == Class::Const;
        if constant && !reader.constants.contains_key(&other) {
            let _ = value_of(reader, other, at);
        }
    }
}

/// Parses `const NAME: TYPE = VALUE;`.
// global_value_decl: `const` optionally_typed_ident `=` expression
fn constant(reader: &mut ModuleReader<'_>, index: usize) -> Result<Outcome, Refused> {
    let mut lexer = WgslLexer::new(reader.text, reader.outline.items[index].rest);
    let kind = declared_kind(reader, &mut lexer)?;
    reader.expect(&mut lexer, b'=')?;
    let (outcome, at) = expressions::read(reader, &mut lexer, ExpressionContext::Statement)?;
    reader.expect(&mut lexer, b';')?;
    Ok(typed(outcome, kind, at))
}

/// Parses `@id(N) override NAME: TYPE = VALUE;`. Buffers are laid out by the default; the value set
/// by `-O` counts where there is none.
// global_value_decl: attribute* `override` optionally_typed_ident ( `=` expression )?
fn override_value(reader: &mut ModuleReader<'_>, index: usize) -> Result<Outcome, Refused> {
    let outline = reader.outline;
    let item = &outline.items[index];
    let id = attributes::number(attributes::of_item(reader, item)?.id);
    let mut lexer = WgslLexer::new(reader.text, item.rest);
    let kind = declared_kind(reader, &mut lexer)?;
    // The last setting counts, by the override's name or its `@id`.
    let set = reader
        .options
        .overrides
        .iter()
        .rev()
        .find(|(key, _)| key == item.name || id.is_some_and(|id| key.parse() == Ok(id)));
    let given = match set.map(|(_, text)| (text, parse_setting(text))) {
        Some((text, None)) => {
            let message = format!("`{}` is set to `{text}`, which is not a number", item.name);
            let diagnostic = Diagnostic::error(Code::OverrideValue, item.name_span, message)
                .with_help(format!("pass a number, such as `-O {}=4`", item.name));
            return Err(reader.reports.refuse(diagnostic));
        }
        Some((_, given)) => given,
        None => None,
    };
    let outcome = if lexer.take(b'=') {
        let (outcome, at) = expressions::read(reader, &mut lexer, ExpressionContext::Statement)?;
        typed(outcome, kind, at)
    } else {
        match given {
            Some(value) => typed(Ok(value), kind, item.name_span),
            None => Err(ConstantError::Valueless(index)),
        }
    };
    let value = outcome.as_ref().ok().and_then(Value::integer).and_then(|v| i64::try_from(v).ok());
    reader.note_override(item.name, id, value);
    Ok(outcome)
}

fn parse_setting(text: &str) -> Option<Value> {
    let text = text.trim();
    match text {
        "true" => return Some(Value::Bool(true)),
        "false" => return Some(Value::Bool(false)),
        _ => {}
    }
    match text.strip_prefix('-') {
        Some(rest) => constant::unary("-", &numbers::literal(rest)?).ok(),
        None => numbers::literal(text),
    }
}

/// Returns the component of the type in `: TYPE`, if present.
// optionally_typed_ident: ident ( `:` type_specifier )?
pub(super) fn declared_kind<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
) -> Result<Option<Scalar>, Refused> {
    if !lexer.take(b':') {
        return Ok(None);
    }
    let typed = types::read(reader, lexer)?;
    Ok(match typed.meaning {
        Meaning::Data(ty) => component(&ty),
        Meaning::Opaque | Meaning::Bindings(..) => None,
    })
}

/// Returns the component of a scalar, vector, or array of these; `None` for types that need no
/// conversion.
pub(super) fn component(ty: &Type) -> Option<Scalar> {
    match ty.innermost() {
        Type::Scalar(scalar) | Type::Atomic(scalar) | Type::Vector { scalar, .. } => Some(*scalar),
        Type::Matrix { .. } | Type::Address(_) | Type::Struct(_) | Type::Array { .. } => None,
    }
}

// Without a declared type the value keeps that of its expression, which may be abstract.
fn typed(outcome: Outcome, scalar: Option<Scalar>, at: Span) -> Outcome {
    match (outcome, scalar) {
        (Ok(value), Some(scalar)) => {
            convert(&value, scalar).map_err(|fault| ConstantError::Fault(fault, at))
        }
        (outcome, _) => outcome,
    }
}

pub(super) fn convert(value: &Value, scalar: Scalar) -> Result<Value, Fault> {
    let kind = Kind::from(scalar);
    // WGSL §6.1.2: an AbstractInt out of its target's range is an error and does not wrap.
    if let Value::Abstract(v) = *value {
        let held = match kind {
            Kind::Int => i32::try_from(v).is_ok(),
            Kind::Uint => u32::try_from(v).is_ok(),
            Kind::Ulong => v >= 0,
            Kind::Bool | Kind::Long | Kind::Float => true,
        };
        if !held {
            return Err(Fault::Overflow);
        }
    }
    value.convert(kind)
}

/// Returns the integer that an expression at `at` is; `None` for another value.
// What is not evaluated here is given to naga, if there is one; an answer is then positive.
pub(super) fn integer(
    reader: &ModuleReader<'_>,
    outcome: Outcome,
    at: Span,
) -> Result<Option<i128>, ConstantError> {
    match outcome {
        Ok(value) => Ok(value.integer()),
        Err(trouble @ ConstantError::Fault(Fault::Unsupported, _)) => {
            let value = fallback::positive(reader.outline, reader.text, at).ok_or(trouble)?;
            Ok(Some(value.into()))
        }
        Err(trouble) => Err(trouble),
    }
}

/// Reports why an expression that must be constant has no value.
// A constant without a value is an error only where one is needed; so it is reported here, by
// whoever needs it, in the words of that place (`what`).
pub(super) fn refuse(
    reader: &mut ModuleReader<'_>,
    trouble: ConstantError,
    at: Span,
    code: Code,
    what: &str,
) -> Refused {
    let text = reader.slice(at);
    let diagnostic = match trouble {
        ConstantError::Refused => return Refused,
        ConstantError::Valueless(index) => {
            let name = reader.outline.items[index].name;
            Diagnostic::error(
                code,
                at,
                format!("{what} `{text}` depends on an override without a value"),
            )
            .with_help(format!("`{name}` has no default: pass `-O {name}=VALUE`"))
        }
        ConstantError::Unknown(place) => {
            let name = reader.slice(place);
            let diagnostic =
                Diagnostic::error(Code::UnknownName, place, format!("`{name}` is not defined"));
            let known = reader.outline.items.iter().filter(|item| match item.class {
                Class::Const | Class::Override => true,
                Class::Struct | Class::Alias | Class::Var | Class::Fn => false,
            });
            report::misspelt(diagnostic, name, known.map(|item| item.name))
        }
        ConstantError::NotConstant(place, index) => {
            let item = &reader.outline.items[index];
            let message =
                format!("{what} must be constant, but `{}` is {}", item.name, item.class.name());
            Diagnostic::error(code, place, message)
                .with_label(item.name_span, "defined here")
                .with_help("use a `const` or an `override`")
        }
        ConstantError::Fault(fault, place) => {
            let message = match fault {
                Fault::DivisionByZero => format!("{what} divides by zero"),
                Fault::Overflow => format!("{what} overflows its type"),
                Fault::Mismatch => format!("{what} combines incompatible types"),
                Fault::Unsupported => format!("landfall cannot evaluate this for {what}"),
            };
            let diagnostic = Diagnostic::error(code, place, message);
            match fault {
                Fault::Unsupported if cfg!(feature = "naga") => {
                    diagnostic.with_help("replace the expression by its value")
                }
                Fault::Unsupported => diagnostic.with_help(
                    "replace the expression by its value, or enable landfall's feature `naga`, which evaluates more",
                ),
                Fault::DivisionByZero | Fault::Overflow | Fault::Mismatch => diagnostic,
            }
        }
    };
    reader.reports.refuse(diagnostic)
}
