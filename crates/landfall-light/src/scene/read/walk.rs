//! Traverses JSON with the path of each value, and collects diagnostics.
//!
//! An invalid value is reported and read as `None`, and reading continues, so that one run reports
//! everything.

use landfall_layout::diagnostic::Code;
use std::ops::RangeInclusive;

use glam::DVec3;

use crate::scene::LARGEST;
pub(super) use crate::scene::obj::short;
use landfall_layout::diagnostic::{Diagnostic, Severity};
use landfall_layout::source::{Files, Span};
use landfall_layout::text::edit_distance::suggestion;
pub use landfall_layout::text::json::{Node, Value};

#[derive(Clone)]
pub(super) struct ValueAt<'n> {
    pub node: &'n Node,
    pub path: String,
}

impl<'n> ValueAt<'n> {
    pub fn root(node: &'n Node) -> ValueAt<'n> {
        ValueAt { node, path: String::new() }
    }

    fn name(&self) -> String {
        if self.path.is_empty() { "the scene".to_string() } else { format!("`{}`", self.path) }
    }
}

/// An object without unknown members.
pub(super) struct Object<'n> {
    pub at: ValueAt<'n>,
    entries: &'n [(String, usize, Node)],
}

impl<'n> Object<'n> {
    pub fn get(&self, key: &str) -> Option<ValueAt<'n>> {
        let (_, _, node) = self.entries.iter().find(|(name, _, _)| name == key)?;
        Some(ValueAt { node, path: join(&self.at.path, key) })
    }

    /// Reads a member, for which `default` stands if it is missing; `None` if it is wrong.
    pub fn or<T>(
        &self,
        key: &str,
        default: T,
        read: impl FnOnce(&ValueAt<'n>) -> Option<T>,
    ) -> Option<T> {
        self.get(key).map_or(Some(default), |at| read(&at))
    }

    /// Reads a member: `Some(None)` if it is missing, `None` if it is wrong.
    pub fn optional<T>(
        &self,
        key: &str,
        read: impl FnOnce(&ValueAt<'n>) -> Option<T>,
    ) -> Option<Option<T>> {
        self.or(key, None, |at| read(at).map(Some))
    }

    /// Returns the members present.
    pub fn keys(&self) -> impl Iterator<Item = &'n str> {
        self.entries.iter().map(|(key, _, _)| key.as_str())
    }
}

/// The most diagnostics; further ones replace the last.
const MAX_FINDINGS: usize = 1000;

#[derive(Default)]
pub(super) struct SceneWalk {
    pub files: Files,
    pub diagnostics: Vec<Diagnostic>,
    pub wrong: bool,
}

impl SceneWalk {
    /// Reports an error in a value; `what` follows its path.
    pub fn error(
        &mut self,
        code: Code,
        at: &ValueAt<'_>,
        what: impl AsRef<str>,
    ) -> &mut Diagnostic {
        let message = format!("{} {}", at.name(), what.as_ref());
        self.push(Diagnostic::error(code, self.span(at), message))
    }

    /// Reports a warning about a value; `what` follows its path.
    pub fn warning(
        &mut self,
        code: Code,
        at: &ValueAt<'_>,
        what: impl AsRef<str>,
    ) -> &mut Diagnostic {
        let message = format!("{} {}", at.name(), what.as_ref());
        self.push(Diagnostic::warning(code, self.span(at), message))
    }

    /// Returns the span of a value; only its start, if it takes several lines.
    fn span(&self, at: &ValueAt<'_>) -> Span {
        let Node { start, end, .. } = *at.node;
        let text = self.files.get(0).map_or("", |file| &file.text);
        match text.get(start..end) {
            Some(text) if text.contains('\n') => span(start, start + 1),
            _ => span(start, end),
        }
    }

    pub fn push(&mut self, found: Diagnostic) -> &mut Diagnostic {
        self.wrong |= found.severity == Severity::Error;
        // The number is bounded, as a list may have a fault in each of its items.
        self.diagnostics.truncate(MAX_FINDINGS - 1);
        self.diagnostics.push(found);
        self.diagnostics.last_mut().expect("one was just added")
    }

    /// Reports a value of the wrong type.
    pub fn kind(&mut self, at: &ValueAt<'_>, wanted: &str) {
        let found = match &at.node.value {
            Value::Number(number) => short(number),
            Value::Text(text) => format!("{:?}", short(text)),
            other => other.noun().to_string(),
        };
        if let Value::Text(text) = &at.node.value {
            // JSON has no infinity, so that some write it as text.
            if text.parse::<f64>().is_ok_and(|number| !number.is_finite()) {
                self.error(Code::NotFinite, at, format!("is {found}, not a finite number"));
                return;
            }
        }
        self.error(Code::WrongValue, at, format!("is {found}, but must be {wanted}"));
    }

    /// Reads an object; reports unknown members.
    pub fn object<'n>(&mut self, at: &ValueAt<'n>, known: &[&str]) -> Option<Object<'n>> {
        let Value::Object(entries) = &at.node.value else {
            self.kind(at, "an object");
            return None;
        };
        for (key, start, _) in entries.iter().filter(|(key, _, _)| !known.contains(&key.as_str())) {
            let whose = at.name();
            let message = format!("`{}` is not a member of {whose}", short(key));
            // With its quotes; a key with escapes is longer in the text, and marked in part.
            let end = start + key.len() + 2;
            let text_end = self.files.get(0).map_or(end, |file| file.text.len());
            let mut found =
                Diagnostic::error(Code::UnknownMember, span(*start, end.min(text_end)), message);
            found.help = suggestion(key, known.iter().copied())
                .or_else(|| Some(format!("its members are {}", list(known))));
            self.push(found);
        }
        Some(Object { at: at.clone(), entries })
    }

    /// Reads a required member.
    pub fn needed<'n>(&mut self, object: &Object<'n>, key: &str) -> Option<ValueAt<'n>> {
        let found = object.get(key);
        if found.is_none() {
            self.error(Code::MissingMember, &object.at, format!("has no `{key}`"));
        }
        found
    }

    pub fn list<'n>(&mut self, at: &ValueAt<'n>) -> Option<Vec<ValueAt<'n>>> {
        let Value::List(nodes) = &at.node.value else {
            self.kind(at, "a list");
            return None;
        };
        let item = |(i, node)| ValueAt { node, path: format!("{}[{i}]", at.path) };
        Some(nodes.iter().enumerate().map(item).collect())
    }

    pub fn items<'n, const N: usize>(&mut self, at: &ValueAt<'n>) -> Option<[ValueAt<'n>; N]> {
        match <[ValueAt<'n>; N]>::try_from(self.list(at)?) {
            Ok(items) => Some(items),
            Err(items) => {
                let what = format!("is a list of {}, but must be one of {N}", items.len());
                self.error(Code::WrongCount, at, what);
                None
            }
        }
    }

    /// Reads a number that fits an `f32`.
    pub fn number(&mut self, at: &ValueAt<'_>) -> Option<f64> {
        let Value::Number(written) = &at.node.value else {
            self.kind(at, "a number");
            return None;
        };
        let number: f64 = written.parse().ok()?;
        if (number as f32).is_finite() {
            return Some(number);
        }
        let what =
            format!("is {}, which does not fit an `f32`: the largest is 3.4e38", short(written));
        self.error(Code::ValueOutOfRange, at, what);
        None
    }

    /// Reads a number above zero, also as an `f32`.
    pub fn positive(&mut self, at: &ValueAt<'_>) -> Option<f64> {
        let number = self.number(at)?;
        if number as f32 > 0.0 {
            return Some(number);
        }
        self.error(Code::ValueOutOfRange, at, format!("is {number}, but must be above 0"));
        None
    }

    /// Reads a number that is zero or more.
    pub fn not_negative(&mut self, at: &ValueAt<'_>, code: Code, why: &str) -> Option<f64> {
        let number = self.number(at)?;
        if number >= 0.0 {
            return Some(number);
        }
        self.error(code, at, format!("is {number}: {why}"));
        None
    }

    /// Reads an integer.
    pub fn whole(&mut self, at: &ValueAt<'_>, range: RangeInclusive<u32>) -> Option<u32> {
        let number = self.number(at)?;
        let (low, high) = (*range.start(), *range.end());
        if number.fract() == 0.0 && number >= f64::from(low) && number <= f64::from(high) {
            return Some(number as u32);
        }
        let what = format!("is {number}, but must be a whole number from {low} to {high}");
        self.error(Code::ValueOutOfRange, at, what);
        None
    }

    /// Reads three coordinates.
    pub fn vector(&mut self, at: &ValueAt<'_>) -> Option<DVec3> {
        let items: [ValueAt<'_>; 3] = self.items(at)?;
        let numbers = items.map(|item| {
            let number = self.number(&item)?;
            if number.abs() <= LARGEST {
                return Some(number);
            }
            let what = format!("is {number}: squares of numbers beyond 1e18 overflow an `f32`");
            self.error(Code::ValueOutOfRange, &item, what);
            None
        });
        Some(DVec3::new(numbers[0]?, numbers[1]?, numbers[2]?))
    }

    /// Reads a vector that is not zero.
    pub fn some_vector(&mut self, at: &ValueAt<'_>) -> Option<DVec3> {
        let vector = self.vector(at)?;
        if vector.abs().max_element() as f32 > 0.0 {
            return Some(vector);
        }
        self.error(Code::ZeroDirection, at, "has no length, so it has no direction");
        None
    }

    /// Reads a vector and normalises it.
    pub fn direction(&mut self, at: &ValueAt<'_>) -> Option<DVec3> {
        self.some_vector(at).and_then(unit)
    }

    /// Reads a colour: three numbers, or one for a grey.
    pub fn color(&mut self, at: &ValueAt<'_>) -> Option<DVec3> {
        if let Value::Number(_) = at.node.value {
            return self.channel(at).map(DVec3::splat);
        }
        let Value::List(_) = at.node.value else {
            self.kind(at, "a colour: `[red, green, blue]`, or one number for a grey");
            return None;
        };
        let items: [ValueAt<'_>; 3] = self.items(at)?;
        let channels = items.map(|item| self.channel(&item));
        Some(DVec3::new(channels[0]?, channels[1]?, channels[2]?))
    }

    fn channel(&mut self, at: &ValueAt<'_>) -> Option<f64> {
        self.not_negative(at, Code::NegativeColor, "a colour is 0 or more")
    }

    pub fn text<'n>(&mut self, at: &ValueAt<'n>) -> Option<&'n str> {
        if let Value::Text(text) = &at.node.value {
            return Some(text);
        }
        self.kind(at, "a string");
        None
    }

    pub fn boolean(&mut self, at: &ValueAt<'_>) -> Option<bool> {
        if let Value::Bool(value) = at.node.value {
            return Some(value);
        }
        self.kind(at, "true or false");
        None
    }

    /// Reads one of several words.
    pub fn one_of<T: Copy>(&mut self, at: &ValueAt<'_>, words: &[(&str, T)]) -> Option<T> {
        let word = self.text(at)?;
        if let Some(found) = words.iter().find(|(name, _)| *name == word) {
            return Some(found.1);
        }
        let names: Vec<&str> = words.iter().map(|(name, _)| *name).collect();
        self.unknown_word(at, word, &names);
        None
    }

    pub fn unknown_word(&mut self, at: &ValueAt<'_>, word: &str, names: &[&str]) {
        let found =
            self.error(Code::WrongValue, at, format!("is {:?}, an unknown value", short(word)));
        found.help = suggestion(word, names.iter().copied())
            .or_else(|| Some(format!("expected one of {}", list(names))));
    }
}

/// Returns a vector's direction, however short it is.
pub(super) fn unit(vector: DVec3) -> Option<DVec3> {
    (vector / vector.abs().max_element()).try_normalize()
}

fn span(start: usize, end: usize) -> Span {
    Span { file: 0, start: start as u32, end: end as u32 }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}

fn list(names: &[&str]) -> String {
    let names: Vec<String> =
        names.iter().filter(|name| **name != "$schema").map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

pub(super) fn round_to_four_digits(number: f64) -> f64 {
    let scale = 10_f64.powi(3 - number.abs().log10().floor().clamp(-300.0, 300.0) as i32);
    (number * scale).round() / scale
}
