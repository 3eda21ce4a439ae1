//! Templates: texts with placeholders that a program fills in before it compiles them.

use std::ops::Range;

/// Returns the first placeholder of a text outside comments and the messages of `#error`:
/// `{{ name }}` and `{% if x %}` of Tera, Jinja and Handlebars, `${name}` of JavaScript.
pub(crate) fn placeholder(text: &str) -> Option<Range<usize>> {
    let has = |mark: &str| memchr::memmem::find(text.as_bytes(), mark.as_bytes()).is_some();
    if !["{{", "{%", "${"].into_iter().any(has) {
        return None;
    }
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        let length = match rest.as_bytes() {
            [b'/', b'/', ..] => rest.find('\n').unwrap_or(rest.len()),
            // A message is for people.
            [b'#', ..] if rest[1..].trim_start_matches([' ', '\t']).starts_with("error") => {
                rest.find('\n').unwrap_or(rest.len())
            }
            [b'/', b'*', ..] => rest[2..].find("*/").map_or(rest.len(), |end| end + 4),
            [b'{', b'{', ..] if is_expression(rest) => return Some(at..end(at, rest, "}}")),
            [b'{', b'%', ..] => return Some(at..end(at, rest, "%}")),
            [b'$', b'{', ..] => return Some(at..end(at, rest, "}")),
            _ => rest.chars().next().map_or(1, char::len_utf8),
        };
        // Whatever stands between placeholders is passed sign by sign.
        at += length;
    }
    None
}

/// The end of a placeholder that begins with `rest`: its closing sign in the line, or the line's.
fn end(at: usize, rest: &str, close: &str) -> usize {
    let line = rest.split(['\r', '\n']).next().unwrap_or_default();
    at + line.find(close).map_or(line.trim_end().len(), |found| found + close.len())
}

/// Whether two braces hold an expression of a template rather than the elements of nested arrays.
fn is_expression(rest: &str) -> bool {
    // Only as far as an expression goes: a text may be braces alone.
    let Some(length) = rest[2..].find(['{', '}', ';', '\r', '\n']) else { return false };
    let (inside, after) = rest[2..].split_at(length);
    let inside = inside.trim();
    let begins = |c: char| c.is_alphabetic() || "_#/>^!&-~@".contains(c);
    // A list of elements has commas outside calls and filters.
    let is_list = inside.contains(',') && !inside.contains(['(', '|']);
    after.starts_with("}}") && inside.starts_with(begins) && !is_list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placeholders_are_told_from_code_and_comments() {
        for (text, found) in [
            ("float a[{{ count }}];", "{{ count }}"),
            ("const int N = {{n}};", "{{n}}"),
            ("x = {{ names | join(\", \") }};", "{{ names | join(\", \") }}"),
            ("{{#if fog}}\nfloat a;\n{{/if}}", "{{#if fog}}"),
            ("a {%- if x -%} b", "{%- if x -%}"),
            ("// {{ no }}\n/* ${no} */ float a = ${a};", "${a}"),
            ("{% for x in\n y %}", "{% for x in"),
        ] {
            assert_eq!(placeholder(text).map(|range| &text[range]), Some(found), "{text}");
        }
        for text in [
            "float a[2][2] = {{1, 2}, {3, 4}};",
            "float a[1][2] = {{x, y}};",
            "vec2 a[2][1] = {{-x}, {y}};",
            "void f() {{ return; }}",
            "void f() {{ a(); }}",
            "// {{ a }} and ${b}\n/* {% if %} */\n#{N}",
            "# error {{ a }} ${b}\nint c;",
            "int a = b %c; { % }",
            "",
        ] {
            assert_eq!(placeholder(text), None, "{text}");
        }
    }
}
