//! Attributes (§11) that layouts and bindings depend on; others are skipped.

use super::constants;
use super::expressions::{self, ExpressionContext};
use super::lexer::WgslLexer;
use super::outline::OutlineItem;
use super::reader::ModuleReader;
use super::report::{self, Refused};
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::Written;

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
        let name = reader.reports.checked(report::word(lexer, "a name"))?;
        if !lexer.take(b'(') {
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
                reader.reports.checked(report::skip_past(lexer, b'(', b')'))?;
                continue;
            }
        };
        *place = Some(argument(reader, lexer, lexer.text_of(name))?);
    }
    Ok(attributes)
}

/// Parses the `N)` of `(N)`.
fn argument<'a>(
    reader: &mut ModuleReader<'a>,
    lexer: &mut WgslLexer<'a>,
    name: &str,
) -> Result<Written, Refused> {
    let (outcome, span) = expressions::read(reader, lexer, ExpressionContext::Statement)?;
    lexer.take(b',');
    reader.expect(lexer, b')')?;
    let value = constants::integer(reader, outcome, span).map_err(|trouble| {
        let what = format!("`@{name}`");
        constants::refuse(reader, trouble, span, Code::InvalidAttribute, &what)
    })?;
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

/// The number of an attribute.
pub(super) fn number(written: Option<Written>) -> Option<u32> {
    u32::try_from(written?.value).ok()
}
