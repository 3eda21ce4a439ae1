//! Values of keys that are lists or tables of words.

use landfall_layout::Diagnostic;
use landfall_layout::diagnostic::Code;
use landfall_lint::settings::Target as Limits;

use super::toml::{Keys, Text};

/// A table of strings; `what` they are is for messages.
pub fn strings(
    keys: &Keys<'_>,
    key: &'static str,
    example: &str,
    what: &str,
) -> Vec<(String, String)> {
    let rows = keys.rows(key, example).into_iter();
    rows.filter_map(|(old, row)| match row.text() {
        Some(new) => Some((old.value, new.value)),
        None => {
            let message = format!("the {what} of `{}` is {}, not a string", old.value, row.kind());
            keys.add(Diagnostic::error(Code::WrongType, row.span(), message));
            None
        }
    })
    .collect()
}

/// A target, with an error for another word.
pub fn target(keys: &Keys<'_>, text: &Text) -> Option<Limits> {
    let found = Limits::from_name(&text.value);
    if found.is_none() {
        keys.unknown(Code::UnknownTarget, "target", text, &Limits::ALL.map(Limits::name));
    }
    found
}

/// Parses strings with the parser of a flag.
pub fn pairs(
    keys: &Keys<'_>,
    key: &'static str,
    parse: impl Fn(&str) -> Result<(String, String), String>,
) -> Vec<(String, String)> {
    let texts = keys.texts(key).unwrap_or_default();
    texts.iter().filter_map(|text| keys.parsed(Code::WrongValue, text, &parse)).collect()
}
