//! Typed access to parsed JSON, with an error for each missing or mistyped value.
//!
//! Walks the nodes of [`json`](crate::text::json) for [`read`](super::read()).

use crate::error::Error;
use crate::layout::LARGEST_BLOCK;
use crate::lock::FIRST_SCHEMA_VERSION;
use crate::text::edit_distance::nearest;
use crate::text::escape::is_bidi;
use crate::text::json::{Fault, Node, Value};

/// The help for a lock that was edited.
pub(super) const WRITE_AGAIN: &str =
    "locks are not edited by hand: write it again with `landfall lock`";

/// A JSON text, for error locations.
#[derive(Clone, Copy)]
pub(super) struct JsonText<'t> {
    pub path: &'t str,
    pub text: &'t str,
}

/// A JSON object and its offset.
#[derive(Clone, Copy)]
pub(super) struct Object<'n> {
    pub entries: &'n [(String, usize, Node)],
    pub at: usize,
}

impl<'n> Object<'n> {
    /// The value of a key; `None` if it is absent or null.
    pub(super) fn get(&self, key: &str) -> Option<&'n Node> {
        // Null stands for absence, as serialisers write options.
        let found = self.entries.iter().find(|(name, _, _)| name == key).map(|(_, _, node)| node);
        found.filter(|node| !matches!(node.value, Value::Null))
    }

    /// Rejects unknown keys.
    pub(super) fn known(&self, place: &JsonText<'_>, keys: &[&str]) -> Result<(), Error> {
        match self.entries.iter().find(|(key, _, _)| !keys.contains(&key.as_str())) {
            None => Ok(()),
            Some((key, at, _)) => {
                let error = place.error(*at, &format!("has an unknown key `{key}`"));
                Err(match nearest(key, keys.iter().copied()) {
                    Some(near) => error.with_help(format!("there is a key `{near}`")),
                    None => error.with_help(WRITE_AGAIN),
                })
            }
        }
    }
}

impl JsonText<'_> {
    fn line(&self, at: usize) -> usize {
        // Only for errors, so that no table of lines is kept.
        memchr::memchr_iter(b'\n', &self.text.as_bytes()[..at.min(self.text.len())]).count() + 1
    }

    fn column(&self, at: usize) -> usize {
        let before = &self.text[..at.min(self.text.len())];
        before.chars().rev().take_while(|c| *c != '\n').count() + 1
    }

    /// An error at a byte offset: `has an unknown key at line 12`.
    pub(super) fn error(&self, at: usize, message: &str) -> Error {
        Error::new(self.path, format!("{message}, at line {}", self.line(at)))
    }

    /// An error about inconsistent JSON.
    pub(super) fn contradiction(&self, at: u32, message: &str) -> Error {
        let line = self.line(at as usize);
        Error::new(self.path, format!("contradicts itself at line {line}: {message}"))
            .with_help(WRITE_AGAIN)
    }

    pub(super) fn fault(&self, fault: &Fault) -> Error {
        match fault {
            Fault::Truncated => {
                let last = self.line(self.text.trim_end().len());
                Error::new(
                    self.path,
                    format!("is cut short: it ends in the middle, at line {last}"),
                )
                .with_help(
                    "restore it from version control, or write it again with `landfall lock`",
                )
            }
            Fault::Expected { at, wanted } => {
                let (line, column) = (self.line(*at), self.column(*at));
                let found = self.text[*at..].chars().next().map(String::from).unwrap_or_default();
                // A line end or a control character would spoil the message.
                let found = found.escape_debug();
                let message = format!(
                    "is not JSON: line {line}, column {column} has `{found}` where {wanted} should be"
                );
                Error::new(self.path, message).with_help(WRITE_AGAIN)
            }
            Fault::Twice { at, key } => self
                .error(*at, &format!("has the key `{key}` twice in one object"))
                .with_help(WRITE_AGAIN),
            Fault::Deep { at } => {
                self.error(*at, "is not a layout: it is nested too deeply").with_help(WRITE_AGAIN)
            }
        }
    }

    fn kind(&self, node: &Node, what: &str, wanted: &str) -> Error {
        let found = node.value.noun();
        let message = format!("has {found} where {what} must be {wanted}");
        self.error(node.start, &message).with_help(WRITE_AGAIN)
    }

    pub(super) fn object<'n>(&self, node: &'n Node, what: &str) -> Result<Object<'n>, Error> {
        match &node.value {
            Value::Object(entries) => Ok(Object { entries, at: node.start }),
            _ => Err(self.kind(node, what, "an object")),
        }
    }

    pub(super) fn list<'n>(&self, node: &'n Node, what: &str) -> Result<&'n [Node], Error> {
        match &node.value {
            Value::List(items) => Ok(items),
            _ => Err(self.kind(node, &format!("`{what}`"), "a list")),
        }
    }

    pub(super) fn text<'n>(&self, node: &'n Node, what: &str) -> Result<&'n str, Error> {
        match &node.value {
            // Paths may hold any characters; names of shaders and drivers may not.
            Value::Text(text) if what != "path" && text.contains(is_format_control) => {
                let message = format!("has a control character in `{what}`");
                Err(self.error(node.start, &message).with_help(WRITE_AGAIN))
            }
            Value::Text(text) => Ok(text),
            _ => Err(self.kind(node, &format!("`{what}`"), "a string")),
        }
    }

    pub(super) fn truth(&self, node: &Node, what: &str) -> Result<bool, Error> {
        match &node.value {
            Value::Bool(truth) => Ok(*truth),
            _ => Err(self.kind(node, &format!("`{what}`"), "true or false")),
        }
    }

    /// A number of bytes: an integer of at most [`LARGEST_BLOCK`].
    pub(super) fn number(&self, node: &Node, what: &str) -> Result<u64, Error> {
        let Value::Number(written) = &node.value else {
            return Err(self.kind(node, &format!("`{what}`"), "a whole number"));
        };
        written.parse().ok().filter(|number| *number <= LARGEST_BLOCK).ok_or_else(|| {
            let message = format!(
                "has {written} where `{what}` must be a whole number up to {LARGEST_BLOCK}"
            );
            self.error(node.start, &message).with_help(WRITE_AGAIN)
        })
    }

    /// Checks the schema version first, since a newer format may differ in anything.
    pub(super) fn version(&self, root: &Object<'_>, newest: u32) -> Result<(), Error> {
        let Some(node) = root.get("schema_version") else {
            return Err(Error::new(self.path, "is not a lock: it has no `schema_version`")
                .with_help("name a lock, or JSON that `landfall layout --format json` wrote"));
        };
        let version = self.number(node, "schema_version")?;
        if (u64::from(FIRST_SCHEMA_VERSION)..=u64::from(newest)).contains(&version) {
            return Ok(());
        }
        let message = format!(
            "has schema version {version}, but this landfall ({}) reads up to {newest}",
            env!("CARGO_PKG_VERSION")
        );
        let help = if version > u64::from(newest) {
            "update landfall: a newer one wrote this file"
        } else {
            "write it again with `landfall lock`"
        };
        Err(self.error(node.start, &message).with_help(help))
    }
}

/// Whether a character is a control or bidirectional formatting character.
fn is_format_control(c: char) -> bool {
    c.is_control() || is_bidi(c)
}
