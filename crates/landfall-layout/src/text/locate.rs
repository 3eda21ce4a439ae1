//! Locates values in JSON text, for messages about them.

use std::ops::Range;

use super::json::{Node, Value, parse};

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
    find(text, &parse(text).ok()?, path, None)
}

fn find(text: &str, node: &Node, path: &str, key: Option<Range<usize>>) -> Option<JsonRange> {
    match &node.value {
        _ if path.is_empty() => Some(JsonRange { key, value: node.start..node.end }),
        Value::Object(entries) => {
            // A dot stands between names, but not before the first.
            let path = path.strip_prefix('.').unwrap_or(path);
            // Of keys such as `a` and `a[0]` either may match.
            entries.iter().find_map(|(name, at, node)| {
                // A key may be a path itself, of which `.` and `[` are parts.
                let rest = path.strip_prefix(name.as_str())?;
                if !rest.is_empty() && !rest.starts_with(['.', '[']) {
                    return None;
                }
                // Between the quote that ends a key and the value are a colon and blanks.
                let end = at + text[*at..node.start].rfind('"')? + 1;
                find(text, node, rest, Some(*at..end))
            })
        }
        Value::List(items) => {
            let (index, rest) = path.strip_prefix('[')?.split_once(']')?;
            find(text, items.get(index.parse::<usize>().ok()?)?, rest, None)
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::Text(_) => None,
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
}
