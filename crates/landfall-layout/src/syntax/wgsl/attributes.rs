//! Attributes (§11) that layouts and bindings depend on; others are skipped.

use super::constants;
use super::constants::ConstantError;
use super::expressions;
use super::expressions::ExpressionContext;
use super::fallback;
use super::lexer::{Kind, WgslLexer};
use super::outline::OutlineItem;
use super::reader::ModuleReader;
use super::report;
use super::report::Refused;
use crate::diagnostic::Code;
use crate::diagnostic::Diagnostic;
use crate::shape::Written;
use crate::source::Span;
use crate::syntax::constant::Fault;

/// The attributes of a member or declaration that affect layouts and interfaces.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Attributes {
    pub(super) align: Option<Written>,
    pub(super) size: Option<Written>,
    pub(super) group: Option<Written>,
    pub(super) binding: Option<Written>,
    pub(super) id: Option<Written>,
    pub(super) location: Option<Written>,
}

pub(super) fn of_item<'a>(
    reader: &mut ModuleReader<'a>,
    item: &OutlineItem<'a>,
) -> Result<Attributes, Refused> {
    read(reader, &mut WgslLexer::new(reader.text, item.start))
}

pub(super) fn read<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
) -> Result<Attributes, Refused> {
    read_those(reader, lexer, WantedAttributes::OfLayouts)
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum WantedAttributes {
    OfLayouts,
    /// `@location` as well, whose errors do not matter to a layout.
    OfInputs,
}

// attribute: `@` ident_pattern_token argument_expression_list?
pub(super) fn read_those<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    wanted: WantedAttributes,
) -> Result<Attributes, Refused> {
    let mut attributes = Attributes::default();
    while lexer.take(b'@') {
        let name = lexer.next();
        if name.kind != Kind::Word {
            return Err(reader.reports.refuse(report::unexpected(lexer, name, "a name")));
        }
        if !lexer.peek().is(b'(') {
            continue;
        }
        // Attributes without arguments, and those of other uses, do not matter to a layout.
        let place = match lexer.text_of(name) {
            "align" => &mut attributes.align,
            "size" => &mut attributes.size,
            "group" => &mut attributes.group,
            "binding" => &mut attributes.binding,
            "id" => &mut attributes.id,
            "location" if wanted == WantedAttributes::OfInputs => &mut attributes.location,
            _ => {
                skip_arguments(reader, lexer)?;
                continue;
            }
        };
        *place = Some(argument(reader, lexer, lexer.text_of(name))?);
    }
    Ok(attributes)
}

/// Parses `(N)`.
// What is not evaluated here is given to naga, if there is one; an answer is then positive.
fn argument<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    name: &str,
) -> Result<Written, Refused> {
    lexer.next();
    let (outcome, span) = expressions::read(reader, lexer, ExpressionContext::Statement)?;
    lexer.take(b',');
    super::types::expect(reader, lexer, b')', "`)`")?;
    let value = match outcome {
        Ok(value) => value.integer(),
        Err(trouble @ ConstantError::Fault(Fault::Unsupported, _)) => {
            match fallback::positive(reader.outline, reader.text, span) {
                Some(value) => Some(value.into()),
                None => {
                    return Err(refuse(reader, trouble, span, name));
                }
            }
        }
        Err(trouble) => {
            return Err(refuse(reader, trouble, span, name));
        }
    };
    // §11: all of these are i32 or u32 and not negative.
    match value.and_then(|value| u32::try_from(value).ok()) {
        Some(value) => Ok(Written { value: value.into(), span }),
        None => {
            let text = reader.slice(span);
            let message = format!("`@{name}` must be a non-negative integer, found `{text}`");
            Err(reader.reports.refuse(Diagnostic::error(Code::InvalidAttribute, span, message)))
        }
    }
}

fn refuse(reader: &mut ModuleReader<'_>, trouble: ConstantError, at: Span, name: &str) -> Refused {
    constants::refuse(reader, trouble, at, Code::InvalidAttribute, &format!("`@{name}`"))
}

/// Skips the `(…)` of an attribute that does not affect layouts.
pub(super) fn skip_arguments<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
) -> Result<(), Refused> {
    let mut depth = 0u32;
    loop {
        let token = lexer.next();
        match token.kind {
            Kind::Sign(b'(') => depth += 1,
            Kind::Sign(b')') => depth -= 1,
            Kind::Sign(b';' | b'{' | b'}') | Kind::End => {
                return Err(reader.reports.refuse(report::unexpected(lexer, token, "`)`")));
            }
            Kind::Word | Kind::Number | Kind::Sign(_) => {}
        }
        if depth == 0 {
            return Ok(());
        }
    }
}
