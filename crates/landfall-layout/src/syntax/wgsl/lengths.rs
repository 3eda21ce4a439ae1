//! Array lengths: the `N` of `array<E, N>`.

use std::sync::Arc;

use super::constants::{self, ConstantError};
use super::expressions::{self, ExpressionContext};
use super::lexer::{Kind, WgslLexer};
use super::reader::{Known, ModuleReader};
use super::report::Refused;
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{ArrayLen, LengthConstant};
use crate::source::Span;

pub(super) struct Length {
    pub(super) len: ArrayLen,
    /// The override it depends on, by its index in the outline.
    pub(super) waits_for: Option<usize>,
    /// The span of the expression, if it contains an override.
    pub(super) overridden: Option<Span>,
}

/// Parses a length inside a template list.
// An element count is a const-expression, or an override-expression in workgroup memory (§6.2.9).
pub(super) fn read<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
) -> Result<Length, Refused> {
    reader.used_override = false;
    let (outcome, at) = expressions::read(reader, lexer, ExpressionContext::Template)?;
    let overridden = reader.used_override.then_some(at);
    if overridden.is_none() {
        note_constants(reader, at);
    }
    let text = reader.slice(at);
    let count = match constants::integer(reader, outcome, at) {
        Ok(count) => count,
        Err(ConstantError::Valueless(index)) => {
            // Without a value the length stays open, so that the rest of the block is still laid
            // out.
            let len = ArrayLen::Override(Arc::from(text));
            return Ok(Length { len, waits_for: Some(index), overridden });
        }
        Err(trouble) => {
            let what = "an array length";
            return Err(constants::refuse(reader, trouble, at, Code::ArraySize, what));
        }
    };
    let Some(count) = count else {
        let message = format!("an array length must be an integer, found `{text}`");
        return Err(reader.reports.refuse(Diagnostic::error(Code::ArraySize, at, message)));
    };
    let shown = || match text == count.to_string() {
        true => format!("`{text}`"),
        false => format!("`{text}`, which is {count}"),
    };
    match u32::try_from(count) {
        Ok(0) | Err(_) if count < 1 => {
            let message =
                format!("an array must have at least 1 element, but this has {}", shown());
            let diagnostic = Diagnostic::error(Code::ArraySize, at, message);
            let help = match overridden {
                Some(_) => "give the override another default, or pass `-O NAME=VALUE`",
                None => "write `array<T>` for a runtime-sized array, or a length of at least 1",
            };
            Err(reader.reports.refuse(diagnostic.with_help(help)))
        }
        Ok(count) => Ok(Length { len: ArrayLen::Fixed(count), waits_for: None, overridden }),
        Err(_) => {
            let message = format!("an array has at most {} elements, not {}", u32::MAX, shown());
            Err(reader.reports.refuse(Diagnostic::error(Code::ArraySize, at, message)))
        }
    }
}

/// Records the constants that a length is written with.
// Read as words again: the evaluation has values, not the names they came from.
fn note_constants(reader: &mut ModuleReader<'_>, at: Span) {
    let outline = reader.outline;
    let mut lexer = WgslLexer::new(reader.text, at.start);
    let mut is_component = false;
    while let Some(token) = lexer.next_before(at.end) {
        let index = outline.names.get(lexer.text_of(token));
        let value = index.and_then(|index| match reader.constants.get(index) {
            Some(Known::Done(Ok(value))) => u32::try_from(value.integer()?).ok(),
            Some(Known::Done(Err(_)) | Known::Open | Known::Broken) | None => None,
        });
        // After a dot stands a component of a vector.
        if let Some(value) = value.filter(|_| token.kind == Kind::Word && !is_component) {
            let name = Arc::from(lexer.text_of(token));
            reader.length_constants.push(LengthConstant { name, value });
        }
        is_component = token.is(b'.');
    }
}
