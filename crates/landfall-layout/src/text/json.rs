//! A JSON parser that keeps the byte range of every value, so that faults in a lock can be located.
//!
//! Feeds [`lock`](crate::lock), [`buffer::read_json`](crate::buffer::read_json) and the scene parser in
//! `landfall_light`. It also distinguishes a truncated text from one that is not JSON.

/// A value and its byte range.
#[derive(Debug)]
pub struct Node {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
    /// The value.
    pub value: Value,
}

/// A JSON value.
#[derive(Debug)]
pub enum Value {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// A number as written.
    Number(String),
    /// A string.
    Text(String),
    /// An array.
    List(Vec<Node>),
    /// An object: each key with the offset of its first byte.
    Object(Vec<(String, usize, Node)>),
}

/// An error in JSON text.
#[derive(Debug)]
pub enum Fault {
    /// The text ends before the value is complete.
    Truncated,
    /// An unexpected character.
    Expected {
        /// Byte offset in the text.
        at: usize,
        /// The expected syntax.
        wanted: &'static str,
    },
    /// A key that occurs twice in one object.
    Twice {
        /// Byte offset in the text.
        at: usize,
        /// The repeated key.
        key: String,
    },
    /// Nesting deeper than the limit.
    Deep {
        /// Byte offset in the text.
        at: usize,
    },
}

/// The nesting limit: structures nest 128 deep, each an object in a list.
const DEEPEST: u32 = 320;

impl Value {
    /// Returns the noun used in messages.
    pub fn noun(&self) -> &'static str {
        match self {
            Value::Null => "null",
            Value::Bool(_) => "true or false",
            Value::Number(_) => "a number",
            Value::Text(_) => "a string",
            Value::List(_) => "a list",
            Value::Object(_) => "an object",
        }
    }
}

/// Parses a whole text.
pub fn parse(text: &str) -> Result<Node, Fault> {
    let mut reader = JsonReader { text, at: 0 };
    let node = reader.value(0)?;
    reader.blanks();
    match reader.peek() {
        None => Ok(node),
        Some(_) => Err(reader.expected("nothing more")),
    }
}

struct JsonReader<'t> {
    text: &'t str,
    at: usize,
}

impl JsonReader<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\r' | b'\n')) {
            self.at += 1;
        }
    }

    fn expected(&self, wanted: &'static str) -> Fault {
        match self.peek() {
            None => Fault::Truncated,
            Some(_) => Fault::Expected { at: self.at, wanted },
        }
    }

    fn value(&mut self, depth: u32) -> Result<Node, Fault> {
        self.blanks();
        let start = self.at;
        let value = match self.peek() {
            Some(b'{' | b'[') if depth >= DEEPEST => return Err(Fault::Deep { at: start }),
            Some(b'{') => self.object(depth)?,
            Some(b'[') => self.list(depth)?,
            Some(b'"') => Value::Text(self.string()?),
            Some(b'-' | b'0'..=b'9') => self.number()?,
            Some(b't') => self.word("true", Value::Bool(true))?,
            Some(b'f') => self.word("false", Value::Bool(false))?,
            Some(b'n') => self.word("null", Value::Null)?,
            _ => return Err(self.expected("a value")),
        };
        Ok(Node { start, end: self.at, value })
    }

    fn word(&mut self, word: &'static str, value: Value) -> Result<Value, Fault> {
        let rest = &self.text.as_bytes()[self.at..];
        if rest.starts_with(word.as_bytes()) {
            self.at += word.len();
            return Ok(value);
        }
        // The text may end within a word: then it was cut off, and is not wrong.
        if word.as_bytes().starts_with(rest) {
            return Err(Fault::Truncated);
        }
        Err(self.expected("a value"))
    }

    fn number(&mut self) -> Result<Value, Fault> {
        let start = self.at;
        // All characters that a number may have; serde_json knows which orders of them are one.
        while matches!(self.peek(), Some(b'-' | b'+' | b'.' | b'e' | b'E' | b'0'..=b'9')) {
            self.at += 1;
        }
        let written = &self.text[start..self.at];
        if serde_json::from_str::<serde_json::Number>(written).is_err() {
            if self.peek().is_none() {
                return Err(Fault::Truncated);
            }
            let wanted = match written.parse::<f64>() {
                Ok(number) if number.is_infinite() => "a number in the range of `f64`",
                _ => "a number",
            };
            return Err(Fault::Expected { at: start, wanted });
        }
        Ok(Value::Number(written.to_string()))
    }

    fn string(&mut self) -> Result<String, Fault> {
        let start = self.at;
        let bytes = self.text.as_bytes();
        self.at += 1;
        while let Some(byte) = self.peek() {
            match byte {
                b'"' => {
                    self.at += 1;
                    let whole = &self.text[start..self.at];
                    let wanted = "a string without unknown escapes";
                    // Escapes are serde_json's, too: only the end of the string is found here.
                    return serde_json::from_str(whole)
                        .map_err(|_| Fault::Expected { at: start, wanted });
                }
                // A `\` and whatever it escapes, which may be a quote.
                b'\\' => self.at = (self.at + 2).min(bytes.len()),
                0..0x20 => return Err(self.expected("the `\"` that ends a string")),
                _ => self.at += 1,
            }
        }
        Err(Fault::Truncated)
    }

    fn list(&mut self, depth: u32) -> Result<Value, Fault> {
        self.at += 1;
        let mut items = Vec::new();
        self.blanks();
        if self.peek() == Some(b']') {
            self.at += 1;
            return Ok(Value::List(items));
        }
        loop {
            items.push(self.value(depth + 1)?);
            self.blanks();
            match self.peek() {
                Some(b',') => self.at += 1,
                Some(b']') => {
                    self.at += 1;
                    return Ok(Value::List(items));
                }
                _ => return Err(self.expected("`,` or `]`")),
            }
        }
    }

    fn object(&mut self, depth: u32) -> Result<Value, Fault> {
        self.at += 1;
        let mut entries: Vec<(String, usize, Node)> = Vec::new();
        // Objects are small, so that a list keeps the order; the set finds keys that occur twice.
        let mut many = std::collections::HashSet::new();
        self.blanks();
        if self.peek() == Some(b'}') {
            self.at += 1;
            return Ok(Value::Object(entries));
        }
        loop {
            self.blanks();
            if self.peek() != Some(b'"') {
                return Err(self.expected("a key in quotes"));
            }
            let at = self.at;
            let key = self.string()?;
            if !many.insert(key.clone()) {
                return Err(Fault::Twice { at, key });
            }
            self.blanks();
            if self.peek() != Some(b':') {
                return Err(self.expected("`:`"));
            }
            self.at += 1;
            entries.push((key, at, self.value(depth + 1)?));
            self.blanks();
            match self.peek() {
                Some(b',') => self.at += 1,
                Some(b'}') => {
                    self.at += 1;
                    return Ok(Value::Object(entries));
                }
                _ => return Err(self.expected("`,` or `}`")),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_beginning_of_a_document_is_truncated() {
        let text = r#"{"a": [1, -2.5e3, true, null], "b\n": {"c": false}, "d": "x\\y"}"#;
        assert!(parse(text).is_ok());
        for end in 0..text.len() {
            assert!(matches!(parse(&text[..end]), Err(Fault::Truncated)), "{}", &text[..end]);
        }
    }

    #[test]
    fn what_is_no_json_is_pointed_at() {
        for (text, at) in [
            ("{\"a\" 1}", 5),
            ("[1 2]", 3),
            ("[01]", 1),
            ("[1,]", 3),
            ("{\"a\":1,}", 7),
            ("{a:1}", 1),
            ("[] x", 3),
            ("[tree]", 1),
            ("\"a\nb\"", 2),
            ("[\"\\q\"]", 1),
        ] {
            match parse(text) {
                Err(Fault::Expected { at: found, .. }) => assert_eq!(found, at, "{text}"),
                other => panic!("{text}: {other:?}"),
            }
        }
        assert!(matches!(parse("{\"a\":1,\"a\":2}"), Err(Fault::Twice { at: 7, .. })));
    }

    #[test]
    fn nesting_without_end_is_refused() {
        assert!(matches!(parse(&"[".repeat(1 << 20)), Err(Fault::Deep { at: 320 })));
    }
}
