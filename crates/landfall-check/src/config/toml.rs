//! Reads a TOML file with the spans of its values, and collects all errors in it.

use landfall_layout::diagnostic::Code;
use std::cell::RefCell;
use std::ops::Range;

use landfall_layout::finding::Place;
use landfall_layout::source::Files;
use landfall_layout::text::edit_distance::suggestion;
use landfall_layout::{Diagnostic, Span};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A TOML file.
pub struct Document {
    files: Files,
    found: RefCell<Vec<Diagnostic>>,
}

/// A string in the file, with its span.
#[derive(Clone, Debug)]
pub struct Text {
    pub value: String,
    pub span: Span,
}

/// A table whose keys are read by name; keys that are never read are reported as unknown.
pub struct Keys<'d> {
    document: &'d Document,
    table: &'d DeTable<'d>,
    /// The name of the table in messages: empty for the file, or `[[table]]`.
    name: &'static str,
    span: Span,
    used: RefCell<Vec<&'static str>>,
}

type Value<'d> = Spanned<DeValue<'d>>;

impl Document {
    pub fn new(path: &str, text: String) -> Document {
        let mut files = Files::default();
        files.add(path, text.into());
        Document { files, found: RefCell::default() }
    }

    /// Reads the top-level keys; returns the errors with the file if there are any.
    pub fn read<T>(self, read: impl FnOnce(&Keys<'_>) -> T) -> Result<T, (Vec<Diagnostic>, Files)> {
        let text = self.files.get(0).map(|file| file.text.clone()).unwrap_or_default();
        let result = match DeTable::parse(&text) {
            Ok(table) => {
                let keys = Keys::new(&self, table.get_ref(), "", span(0..0));
                let result = read(&keys);
                keys.finish();
                Some(result)
            }
            Err(cause) => {
                let at = cause.span().unwrap_or(0..0);
                // Messages may have several lines; findings have one.
                let message = cause.message().lines().collect::<Vec<_>>().join(", ");
                self.add(Diagnostic::error(Code::Syntax, span(at), message));
                None
            }
        };
        let mut found = self.found.into_inner();
        match result {
            Some(result) if found.is_empty() => Ok(result),
            _ => {
                // Readers ask for keys in an order of their own; errors are shown in that of the
                // file.
                found.sort_by_key(|d| d.labels.first().map_or(0, |label| label.at.start));
                Err((found, self.files))
            }
        }
    }

    fn add(&self, found: Diagnostic) {
        self.found.borrow_mut().push(found);
    }
}

fn span(range: Range<usize>) -> Span {
    Span { file: 0, start: range.start as u32, end: range.end as u32 }
}

impl<'d> Keys<'d> {
    fn new(
        document: &'d Document,
        table: &'d DeTable<'d>,
        name: &'static str,
        span: Span,
    ) -> Keys<'d> {
        Keys { document, table, name, span, used: RefCell::default() }
    }

    /// Reports keys that were never read.
    fn finish(&self) {
        let used = self.used.borrow();
        for key in self.table.keys() {
            let name = key.get_ref().as_ref();
            if used.contains(&name) {
                continue;
            }
            let whose = match self.name {
                "" => "the configuration".to_string(),
                name => format!("`{name}`"),
            };
            let known = used.iter().copied();
            // Common misspellings: `mirror_group`, `mirror-groups`.
            let help = suggestion(&name.replace('_', "-"), known.clone())
                .unwrap_or_else(|| format!("{whose} has {}", quoted(known)));
            let message = format!("{whose} has no key `{name}`");
            self.add(
                Diagnostic::error(Code::UnknownKey, span(key.span()), message).with_help(help),
            );
        }
    }

    pub fn add(&self, found: Diagnostic) {
        self.document.add(found);
    }

    /// The span of the table.
    pub fn span(&self) -> Span {
        self.span
    }

    pub fn place(&self) -> Place {
        self.place_of(self.span)
    }

    pub fn place_of(&self, span: Span) -> Place {
        Place::new(&self.document.files, span)
    }

    /// The source text of a value.
    pub fn written(&self, span: Span) -> &str {
        self.document.files.text(span)
    }

    fn get(&self, key: &'static str) -> Option<&'d Value<'d>> {
        // A key that is asked for is a known one, whether it is there or not.
        self.used.borrow_mut().push(key);
        self.table.get(key)
    }

    fn wrong_type(&self, key: &str, value: &Value<'_>, expected: &str, example: &str) {
        let message = format!("`{key}` is {}, not {expected}", a(value.get_ref()));
        self.add(
            Diagnostic::error(Code::WrongType, span(value.span()), message)
                .with_help(format!("write `{key} = {example}`")),
        );
    }

    pub fn text(&self, key: &'static str) -> Option<Text> {
        let value = self.get(key)?;
        let text = value.get_ref().as_str();
        if text.is_none() {
            self.wrong_type(
                key,
                value,
                "a string",
                &format!("\"{}\"", self.written(span(value.span()))),
            );
        }
        Some(Text { value: text?.to_string(), span: span(value.span()) })
    }

    /// A required string.
    pub fn needed(&self, key: &'static str) -> Option<Text> {
        if !self.table.contains_key(key) {
            self.used.borrow_mut().push(key);
            let message = format!("`{}` has no `{key}`", self.name);
            let found = Diagnostic::error(Code::MissingKey, self.span, message);
            self.add(found.with_help(format!("add `{key} = \"…\"`")));
            return None;
        }
        self.text(key)
    }

    pub fn bool(&self, key: &'static str) -> Option<bool> {
        let value = self.get(key)?;
        let found = value.get_ref().as_bool();
        if found.is_none() {
            self.wrong_type(key, value, "true or false", "true");
        }
        found
    }

    /// A finite number of at least 0.
    pub fn number(&self, key: &'static str) -> Option<f64> {
        let value = self.get(key)?;
        let Some(found) = number(value.get_ref()) else {
            self.wrong_type(key, value, "a number", "1.5");
            return None;
        };
        if !found.is_finite() || found < 0.0 {
            let message = format!("`{key}` is {found}, not a finite number of at least 0");
            self.add(Diagnostic::error(Code::WrongValue, span(value.span()), message));
            return None;
        }
        Some(found)
    }

    /// A table as JSON.
    pub fn json_table(&self, key: &'static str, example: &str) -> Option<serde_json::Value> {
        let value = self.get(key)?;
        if !matches!(value.get_ref(), DeValue::Table(_)) {
            self.wrong_type(key, value, "a table", example);
            return None;
        }
        let found = json(value.get_ref());
        if found.is_none() {
            let message = format!("`{key}` holds a date or a number that is not finite");
            let found = Diagnostic::error(Code::WrongValue, span(value.span()), message);
            self.add(found.with_help(format!("write `{key} = {example}`")));
        }
        found
    }

    pub fn texts(&self, key: &'static str) -> Option<Vec<Text>> {
        let value = self.get(key)?;
        self.text_list(key, value)
    }

    fn text_list(&self, key: &str, value: &Value<'_>) -> Option<Vec<Text>> {
        let Some(list) = value.get_ref().as_array() else {
            let written = self.written(span(value.span()));
            let item =
                if value.get_ref().is_str() { written.to_string() } else { "\"…\"".into() };
            self.wrong_type(key, value, "an array of strings", &format!("[{item}]"));
            return None;
        };
        let mut texts = Vec::new();
        for item in list {
            match item.get_ref().as_str() {
                Some(text) => texts.push(Text { value: text.to_string(), span: span(item.span()) }),
                None => {
                    let message =
                        format!("`{key}` contains {}, but takes strings only", a(item.get_ref()));
                    let help = format!("write `\"{}\"`", self.written(span(item.span())));
                    let found = Diagnostic::error(Code::WrongType, span(item.span()), message);
                    self.add(found.with_help(help));
                }
            }
        }
        Some(texts)
    }

    /// An array of arrays of strings.
    pub fn text_lists(&self, key: &'static str) -> Vec<Vec<Text>> {
        let Some(value) = self.get(key) else { return Vec::new() };
        let example = "[[\"SHADOWS=1\"], [\"SHADOWS=2\"]]";
        match value.get_ref().as_array() {
            Some(lists) if lists.iter().all(|list| list.get_ref().is_array()) => {
                lists.iter().filter_map(|list| self.text_list(key, list)).collect()
            }
            _ => {
                self.wrong_type(key, value, "an array of arrays of strings", example);
                Vec::new()
            }
        }
    }

    /// A string out of a fixed set.
    pub fn choice(&self, key: &'static str, words: &[&'static str]) -> Option<&'static str> {
        let text = self.text(key)?;
        let found = words.iter().find(|word| **word == text.value).copied();
        if found.is_none() {
            self.unknown(Code::WrongValue, key, &text, words);
        }
        found
    }

    /// Reports a string outside its fixed set.
    pub fn unknown(&self, code: Code, what: &str, text: &Text, known: &[&'static str]) {
        let message = format!("unknown {what} `{}`", text.value);
        let help = suggestion(&text.value, known.iter().copied())
            .unwrap_or_else(|| format!("known are {}", quoted(known.iter().copied())));
        self.add(Diagnostic::error(code, text.span, message).with_help(help));
    }

    /// A string parsed like the value of a flag.
    pub fn parsed<T>(
        &self,
        code: Code,
        text: &Text,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> Option<T> {
        match parse(&text.value) {
            Ok(value) => Some(value),
            Err(cause) => {
                let message = format!("`{}` cannot be parsed", text.value);
                self.add(Diagnostic::error(code, text.span, message).with_help(cause));
                None
            }
        }
    }

    pub fn bad_glob(&self, text: &Text, cause: &str) {
        let message = format!("`{}` is not a glob: {cause}", text.value);
        self.add(
            Diagnostic::error(Code::BadGlob, text.span, message)
                .with_help("escape literal `[`, `{`, `*` and `?` with `\\`"),
        );
    }

    /// The tables of `[[key]]`.
    pub fn tables<T>(
        &self,
        key: &'static str,
        name: &'static str,
        read: impl Fn(&Keys<'_>) -> Option<T>,
    ) -> Vec<T> {
        let Some(value) = self.get(key) else { return Vec::new() };
        let list = value.get_ref().as_array();
        let is_tables = list.is_some_and(|list| list.iter().all(|item| item.get_ref().is_table()));
        let Some(list) = list.filter(|_| is_tables) else {
            let message = format!("`{key}` is {}, not an array of tables", a(value.get_ref()));
            let found = Diagnostic::error(Code::WrongType, span(value.span()), message);
            self.add(found.with_help(format!("write it under `[[{key}]]`")));
            return Vec::new();
        };
        let mut tables = Vec::new();
        for item in list {
            let Some(table) = item.get_ref().as_table() else { continue };
            let keys = Keys::new(self.document, table, name, span(item.span()));
            tables.extend(read(&keys));
            keys.finish();
        }
        tables
    }

    /// The table of `[key]`.
    pub fn table<T>(
        &self,
        key: &'static str,
        example: &str,
        read: impl FnOnce(&Keys<'_>) -> T,
    ) -> Option<T> {
        let value = self.get(key)?;
        let Some(table) = value.get_ref().as_table() else {
            self.wrong_type(key, value, "a table", example);
            return None;
        };
        let keys = Keys::new(self.document, table, key, span(value.span()));
        let result = read(&keys);
        keys.finish();
        Some(result)
    }

    /// The rows of a table of arrays of strings.
    pub fn text_rows(&self, key: &'static str, example: &str) -> Vec<(Text, Vec<Text>)> {
        let rows = self.rows(key, example).into_iter();
        rows.filter_map(|(name, row)| {
            let list = self.text_list(&name.value, row.value)?;
            Some((name, list))
        })
        .collect()
    }

    /// The rows of a table with arbitrary keys: key with span, and value.
    pub fn rows(&self, key: &'static str, example: &str) -> Vec<(Text, Row<'d>)> {
        let Some(value) = self.get(key) else { return Vec::new() };
        let Some(table) = value.get_ref().as_table() else {
            self.wrong_type(key, value, "a table", example);
            return Vec::new();
        };
        let mut rows: Vec<(Text, Row<'d>)> = table
            .iter()
            .map(|(name, value)| {
                let text = Text { value: name.get_ref().to_string(), span: span(name.span()) };
                (text, Row { value })
            })
            .collect();
        // In the order of the file.
        rows.sort_by_key(|(name, _)| name.span.start);
        rows
    }

    /// The value of a key, of any type.
    pub fn row(&self, key: &'static str) -> Option<Row<'d>> {
        self.get(key).map(|value| Row { value })
    }
}

/// A value of any type.
#[derive(Clone, Copy)]
pub struct Row<'d> {
    value: &'d Value<'d>,
}

impl Row<'_> {
    pub fn span(&self) -> Span {
        span(self.value.span())
    }

    pub fn text(&self) -> Option<Text> {
        let text = self.value.get_ref().as_str()?;
        Some(Text { value: text.to_string(), span: self.span() })
    }

    /// The digits and base of an integer.
    pub fn integer(&self) -> Option<(&str, u32)> {
        let integer = self.value.get_ref().as_integer()?;
        Some((integer.as_str(), integer.radix()))
    }

    /// The length of an array or a table.
    pub fn len(&self) -> Option<usize> {
        let value = self.value.get_ref();
        let table = || value.as_table().map(|table| table.len());
        value.as_array().map(|list| list.len()).or_else(table)
    }

    /// The name of its type with an article.
    pub fn kind(&self) -> &'static str {
        a(self.value.get_ref())
    }
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|n| n as f64)
        }
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    }
}

/// A value as JSON; `None` for dates and numbers that are not finite.
fn json(value: &DeValue<'_>) -> Option<serde_json::Value> {
    Some(match value {
        DeValue::String(text) => text.to_string().into(),
        DeValue::Boolean(is) => (*is).into(),
        DeValue::Integer(_) | DeValue::Float(_) => {
            serde_json::Number::from_f64(number(value)?)?.into()
        }
        DeValue::Array(list) => {
            list.iter().map(|value| json(value.get_ref())).collect::<Option<Vec<_>>>()?.into()
        }
        DeValue::Table(table) => {
            let rows = table
                .iter()
                .map(|(key, value)| Some((key.get_ref().to_string(), json(value.get_ref())?)));
            serde_json::Value::Object(rows.collect::<Option<_>>()?)
        }
        DeValue::Datetime(_) => return None,
    })
}

fn a(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) => "an integer",
        DeValue::Float(_) => "a float",
        DeValue::Boolean(_) => "a boolean",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

/// Formats names as `` `a`, `b` ``.
fn quoted<'w>(words: impl Iterator<Item = &'w str>) -> String {
    words.map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}
