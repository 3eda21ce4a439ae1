//! Locates values in JSON text, for messages about them.
//!
//! The text was parsed before, so it is known to be valid JSON.

use std::ops::Range;

/// The byte ranges of a JSON value and of the key directly before it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JsonRange {
    /// The key before the value, if any.
    pub key: Option<Range<usize>>,
    /// The value.
    pub value: Range<usize>,
}

/// Returns the value at a path whose keys are spelled as written: `data[1].pos[2]`, which also
/// matches `{"data[1].pos": […]}`.
pub fn locate(text: &str, path: &str) -> Option<JsonRange> {
    // From the start, value by value: errors are few, so that no index pays.
    let scan = LocateScan { text };
    scan.find(scan.space(0), path, None)
}

/// Returns the offset of a line and column, both from 1, the column in bytes.
pub(crate) fn at_line(text: &str, line: usize, column: usize) -> Range<usize> {
    let lines = text.split_inclusive('\n').take(line.saturating_sub(1));
    let line_start = lines.map(str::len).sum::<usize>();
    let start = (line_start + column.saturating_sub(1)).min(text.len());
    start..(start + 1).min(text.len())
}

struct LocateScan<'t> {
    text: &'t str,
}

impl LocateScan<'_> {
    fn find(&self, start: usize, path: &str, key: Option<Range<usize>>) -> Option<JsonRange> {
        if path.is_empty() {
            return Some(JsonRange { key, value: start..self.end(start)? });
        }
        match self.byte(start)? {
            // A dot stands between names, but not before the first.
            b'{' => self.in_object(start, path.strip_prefix('.').unwrap_or(path)),
            b'[' => self.in_array(start, path),
            _ => None,
        }
    }

    fn in_object(&self, start: usize, path: &str) -> Option<JsonRange> {
        let mut at = self.space(start + 1);
        while self.byte(at)? == b'"' {
            let key = at..self.end(at)?;
            let value = self.space(self.space(key.end) + 1);
            let name: String = serde_json::from_str(self.text.get(key.clone())?).ok()?;
            // A key may be a path itself, of which `.` and `[` are parts.
            let rest = path.strip_prefix(name.as_str());
            let whole = |rest: &&str| rest.is_empty() || rest.starts_with(['.', '[']);
            if let Some(rest) = rest.filter(whole) {
                // Of keys such as `a` and `a[0]` either may match.
                if let Some(found) = self.find(value, rest, Some(key)) {
                    return Some(found);
                }
            }
            at = self.next(value)?;
        }
        None
    }

    fn in_array(&self, start: usize, path: &str) -> Option<JsonRange> {
        let (index, rest) = path.strip_prefix('[')?.split_once(']')?;
        let mut at = self.space(start + 1);
        for _ in 0..index.parse::<usize>().ok()? {
            if self.byte(at)? == b']' {
                return None;
            }
            at = self.next(at)?;
        }
        if self.byte(at)? == b']' { None } else { self.find(at, rest, None) }
    }

    fn byte(&self, at: usize) -> Option<u8> {
        self.text.as_bytes().get(at).copied()
    }

    fn space(&self, at: usize) -> usize {
        let rest = &self.text.as_bytes()[at.min(self.text.len())..];
        at + rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count()
    }

    /// Returns the offset after a value and its comma.
    fn next(&self, value: usize) -> Option<usize> {
        let at = self.space(self.end(value)?);
        Some(if self.byte(at)? == b',' { self.space(at + 1) } else { at })
    }

    /// Returns the end of a value.
    fn end(&self, start: usize) -> Option<usize> {
        let (mut at, mut depth) = (start, 0usize);
        loop {
            match self.byte(at)? {
                b'"' => at = self.string(at)?,
                b'{' | b'[' => {
                    depth += 1;
                    at += 1;
                }
                b'}' | b']' => {
                    depth = depth.checked_sub(1)?;
                    at += 1;
                }
                b',' | b':' => at += 1,
                byte if byte.is_ascii_whitespace() => at += 1,
                // A number or a word ends before a comma, a colon, a bracket or white space.
                _ => {
                    let word = |byte: &&u8| !b",:]}".contains(byte) && !byte.is_ascii_whitespace();
                    at += self.text.as_bytes()[at..].iter().take_while(word).count();
                }
            }
            if depth == 0 {
                return Some(at);
            }
        }
    }

    /// Returns the end of a string.
    fn string(&self, start: usize) -> Option<usize> {
        let mut at = start + 1;
        loop {
            match self.byte(at)? {
                b'"' => return Some(at + 1),
                b'\\' => at += 2,
                _ => at += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#" {
  "data": [ {"pos": [1, 2 ,3], "color\u0073": "a\"]}"}, {"pos.x":-1e5} ],
  "data[1].color" : [0,{} , [[true]]], "n":null
} "#;

    fn value(path: &str) -> Option<&'static str> {
        locate(TEXT, path).map(|found| &TEXT[found.value])
    }

    #[test]
    fn values_are_found_by_any_spelling_of_their_keys() {
        for (path, wanted) in [
            ("", TEXT.trim()),
            ("data[0].pos", "[1, 2 ,3]"),
            ("data[0].pos[1]", "2"),
            ("data[0].pos[2]", "3"),
            ("data[0].colors", r#""a\"]}""#),
            ("data[1]", r#"{"pos.x":-1e5}"#),
            ("data[1].pos.x", "-1e5"),
            ("data[1].color[2][0][0]", "true"),
            ("data[1].color[1]", "{}"),
            ("n", "null"),
        ] {
            assert_eq!(value(path), Some(wanted), "{path}");
        }
        for path in ["m", "n.x", "data[2]", "data[x]", "data[0].po", "data.pos", "data[1].color[3]"]
        {
            assert_eq!(value(path), None, "{path}");
        }
        let found = locate(TEXT, "data[1].pos.x").expect("it is there");
        assert_eq!(&TEXT[found.key.expect("a key")], "\"pos.x\"");
    }

    #[test]
    fn lines_and_columns_count_from_1() {
        let text = "{\n ab\n}";
        assert_eq!(&text[at_line(text, 1, 1)], "{");
        assert_eq!(&text[at_line(text, 2, 3)], "b");
        assert_eq!(&text[at_line(text, 3, 1)], "}");
        assert_eq!(at_line(text, 9, 9), text.len()..text.len());
        assert_eq!(at_line("", 1, 0), 0..0);
    }
}
