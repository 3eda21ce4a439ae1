//! Structures as headers of C and C++ declare them, with the place of each field's name.
//!
//! A reader of declarations, not of the language: macros are not expanded, both branches of `#if` count,
//! and what is no structure is passed over.

use std::ops::Range;

/// A structure of a header.
#[derive(Debug, PartialEq, Eq)]
pub struct HeaderStructure {
    /// The name with its namespaces: `engine::PointLight`.
    pub name: String,
    /// The bytes of the name without them.
    pub span: Range<u32>,
    /// The names of its fields, in order.
    pub fields: Vec<(String, Range<u32>)>,
}

/// Returns the structures of a header.
pub fn structures(text: &str) -> Vec<HeaderStructure> {
    let mut reader = HeaderReader { text, tokens: tokens(text), at: 0, found: Vec::new() };
    while reader.at < reader.tokens.len() {
        reader.scope(&[], None);
        // A `}` too many.
        reader.at += 1;
    }
    reader.found
}

/// The files that a header includes by `#include "…"`.
pub fn included(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| {
        let rest = line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("include")?;
        rest.trim_start().strip_prefix('"')?.split_once('"').map(|(name, _)| name)
    })
}

/// The keywords of declarations in a structure that are no fields.
const NO_FIELDS: [&str; 6] = ["static", "static_assert", "using", "friend", "typedef", "template"];

/// The keywords that begin structures.
const HEADS: [&str; 3] = ["struct", "class", "union"];

struct HeaderReader<'t> {
    text: &'t str,
    tokens: Vec<Range<usize>>,
    at: usize,
    found: Vec<HeaderStructure>,
}

impl<'t> HeaderReader<'t> {
    fn token(&self, token: &Range<usize>) -> &'t str {
        &self.text[token.clone()]
    }

    fn is_name(&self, token: &Range<usize>) -> bool {
        self.token(token).starts_with(|c: char| c == '_' || c.is_alphabetic())
    }

    /// Reads up to the `}` of a namespace or structure, or to the end.
    fn scope(&mut self, names: &[&str], structure: Option<usize>) {
        let mut statement: Vec<Range<usize>> = Vec::new();
        while let Some(token) = self.tokens.get(self.at).cloned() {
            let last = statement.last().map_or("", |last| self.token(last));
            match self.token(&token) {
                "}" => return,
                ";" => {
                    self.end(&statement, names, structure);
                    statement.clear();
                }
                "{" => self.braces(&mut statement, names),
                "(" => {
                    self.skip();
                    match last {
                        "alignas" | "_Alignas" | "__attribute__" | "__declspec" => {
                            statement.pop();
                        }
                        _ => statement.push(token),
                    }
                }
                "[" => self.skip(),
                "<" if last != "operator" && self.is_name(statement.last().unwrap_or(&(0..0))) => {
                    self.skip();
                }
                ":" if matches!(last, "public" | "private" | "protected") => statement.clear(),
                // The width of a bit-field, and the value of a field, up to the next declarator.
                "=" | ":" if last != "operator" && !self.has(&statement, &HEADS) => self.value(),
                _ => statement.push(token),
            }
            self.at += 1;
        }
    }

    /// Goes to the end of a value, before the next declarator.
    fn value(&mut self) {
        while let Some(next) = self.tokens.get(self.at + 1) {
            let next = self.token(next);
            if matches!(next, "," | ";" | "}") {
                return;
            }
            self.at += 1;
            if matches!(next, "(" | "[" | "{") {
                self.skip();
            }
        }
    }

    fn has(&self, statement: &[Range<usize>], words: &[&str]) -> bool {
        statement.iter().any(|token| words.contains(&self.token(token)))
    }

    /// Reads braces by what stands before them.
    fn braces(&mut self, statement: &mut Vec<Range<usize>>, names: &[&str]) {
        let is = |keyword: &[&str]| {
            statement.iter().position(|token| keyword.contains(&self.token(token)))
        };
        if let Some(namespace) = is(&["namespace"]) {
            let own = statement[namespace + 1..].iter().map(|token| self.token(token));
            let inner: Vec<&str> =
                names.iter().copied().chain(own.filter(|name| *name != "::")).collect();
            self.at += 1;
            self.scope(&inner, None);
            statement.clear();
        } else if self.has(statement, &["("]) {
            self.skip();
            statement.clear();
        } else if self.has(statement, &["enum"]) {
            self.skip();
            statement.clear();
            statement.push(0..0);
        } else if let Some(keyword) = is(&HEADS) {
            let head = statement[keyword + 1..].iter();
            let head = head.take_while(|token| self.token(token) != ":");
            let head = head.filter(|token| self.is_name(token) && self.token(token) != "final");
            let name = head.last().cloned();
            let index = self.found.len();
            let span = name.unwrap_or(self.tokens[self.at].start..self.tokens[self.at].start);
            let path: Vec<&str> =
                names.iter().copied().chain(Some(&self.text[span.clone()])).collect();
            self.found.push(HeaderStructure {
                name: path.join("::"),
                span: span.start as u32..span.end as u32,
                fields: Vec::new(),
            });
            self.at += 1;
            self.scope(&path, Some(index));
            // What is behind names variables of it, or by `typedef` the structure itself.
            statement.retain(|token| self.token(token) == "typedef");
            statement.push(span.clone());
            if span.is_empty() && !self.has(statement, &["typedef"]) {
                self.found[index].name.clear();
            }
        } else if self.has(statement, &["extern"]) && statement.len() == 1 {
            self.at += 1;
            self.scope(names, None);
            statement.clear();
        } else {
            // The value of a field.
            self.skip();
        }
    }

    /// Takes the fields of a declaration that has ended, or the name that it gives a structure.
    fn end(&mut self, statement: &[Range<usize>], names: &[&str], structure: Option<usize>) {
        let first = statement.first().map_or("", |token| self.token(token));
        if self.has(statement, &["("]) {
            return;
        }
        if let ([own], Some(index)) = (statement, structure) {
            // The members of a structure without a name are those of the one around it.
            let is_own = |one: &HeaderStructure| {
                own.is_empty() && one.span.is_empty() && one.span.start as usize == own.start
            };
            if let Some(found) = self.found.iter().rposition(is_own).filter(|at| *at > index) {
                let fields = std::mem::take(&mut self.found[found].fields);
                self.found[index].fields.extend(fields);
            }
            return;
        }
        if let ("typedef", [_, own, name]) = (first, statement) {
            let is_own = |one: &&mut HeaderStructure| {
                (one.span.start as usize, one.span.end as usize) == (own.start, own.end)
            };
            if let Some(found) = self.found.iter_mut().rev().find(is_own) {
                let path: Vec<&str> =
                    names.iter().copied().chain(Some(&self.text[name.clone()])).collect();
                found.name = path.join("::");
                found.span = name.start as u32..name.end as u32;
            }
            return;
        }
        let is_forward = statement.len() == 2 && (first == "enum" || HEADS.contains(&first));
        let is_field = !is_forward && !self.has(statement, &NO_FIELDS);
        let Some(index) = structure.filter(|_| is_field) else { return };
        let parts = statement.split(|token| self.token(token) == ",").enumerate();
        let names = parts.filter_map(|(number, part)| {
            let name = part.iter().rev().find(|token| self.is_name(token))?;
            // A type alone declares nothing.
            (number > 0 || part.len() > 1).then_some(name)
        });
        let fields: Vec<(String, Range<u32>)> = names
            .map(|name| (self.token(name).to_string(), name.start as u32..name.end as u32))
            .collect();
        self.found[index].fields.extend(fields);
    }

    /// Goes to the bracket that closes the one at the place that is read.
    fn skip(&mut self) {
        let pairs = [("(", ")"), ("[", "]"), ("{", "}"), ("<", ">")];
        let open = self.token(&self.tokens[self.at].clone());
        let Some((open, close)) = pairs.into_iter().find(|pair| pair.0 == open) else { return };
        let mut depth = 0_usize;
        while let Some(token) = self.tokens.get(self.at) {
            let token = &self.text[token.clone()];
            if token == open {
                depth += 1;
            } else if token == close {
                depth -= 1;
            }
            // An operator, where no type ends with `>`.
            if depth == 0 || open == "<" && token == ";" {
                return;
            }
            self.at += 1;
        }
        self.at = self.tokens.len().saturating_sub(1);
    }
}

/// The names and signs of a text, without comments, literals and preprocessor lines.
fn tokens(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    let mut is_line_start = true;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let is_part = |c: char| c == '_' || c.is_alphanumeric();
        let (is_token, length) = match c {
            _ if c.is_whitespace() => (false, c.len_utf8()),
            '#' if is_line_start => (false, directive(rest)),
            '/' if rest.starts_with("//") => (false, rest.find('\n').unwrap_or(rest.len())),
            '/' if rest.starts_with("/*") => {
                (false, rest.find("*/").map_or(rest.len(), |end| end + 2))
            }
            '"' | '\'' => (false, literal(rest, c)),
            _ if is_part(c) => (true, rest.find(|c| !is_part(c)).unwrap_or(rest.len())),
            ':' if rest.starts_with("::") => (true, 2),
            _ => (true, c.len_utf8()),
        };
        if is_token {
            found.push(at..at + length);
        }
        is_line_start = c == '\n' || is_line_start && !is_token;
        at += length;
    }
    found
}

/// The length of a preprocessor line, with those that `\` continues.
fn directive(text: &str) -> usize {
    let mut length = 0;
    for line in text.split_inclusive('\n') {
        length += line.len();
        if !line.trim_end().ends_with('\\') {
            // The end of the line begins the next.
            return length - usize::from(line.ends_with('\n'));
        }
    }
    length
}

fn literal(text: &str, quote: char) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '\n' => return at,
            _ if c == quote => return at + 1,
            _ => {}
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The structures by name with the names of their fields, each taken from its place.
    fn read(text: &str) -> Vec<(String, String)> {
        let slice = |span: &Range<u32>| &text[span.start as usize..span.end as usize];
        let fields = |one: &HeaderStructure| {
            let names = one.fields.iter().map(|(name, span)| {
                assert_eq!(slice(span), name);
                name.as_str()
            });
            names.collect::<Vec<_>>().join(" ")
        };
        let named = structures(text).into_iter().filter(|one| !one.name.is_empty());
        let pairs = named.map(|one| {
            assert!(one.name.ends_with(slice(&one.span)), "{one:?}");
            (one.name.clone(), fields(&one))
        });
        pairs.collect()
    }

    #[test]
    fn fields_are_those_that_are_declared() {
        let text = "#pragma once\n#include \"math.h\"\n#define FIELD float \\\n  not_a_field;\n\
            // struct Comment { float no; };\n\
            namespace engine { namespace detail::more {\n\
            struct alignas(16) Light final : public Base<int> {\n\
              glm::vec3 position = {0, 0, 0}, m_tint{1.0f}; /* float no; */\n\
              float cutoff[2][3], *pointer; std::array<float, 3> range{};\n\
              [[maybe_unused]] alignas(8) unsigned int flags : 3, : 2, other : 4;\n\
              static constexpr int LIMIT = 4; using Real = float; enum Kind { Point, Spot } kind;\n\
              public: float area() const { return a < b ? 1.f : cutoff[0][0]; } Light() = default;\n\
              const char* name = \"a;}\\\"{\"; char c = '}';\n\
              union { struct { float u, v; }; float uv[2]; }; struct Later; enum Kind again;\n\
              struct { float x; } inner; struct Named { float y; } named[2];\n\
              bool operator<(const Light& other) const;\n\
              float last;\n\
            };\n} void f(int a) { struct Local { int b; }; }\nfloat g(); }\n\
            extern \"C\" { typedef struct tag { float a; } Old; typedef struct { int b, c; } Bare; }\n\
            struct Forward; struct Forward *pointer; union Both { float f; int i; };\n";
        let expected = [
            (
                "engine::detail::more::Light",
                "position m_tint cutoff pointer range flags other kind name c u v uv again inner named last",
            ),
            ("engine::detail::more::Light::Named", "y"),
            ("Old", "a"),
            ("Bare", "b c"),
            ("Both", "f i"),
        ];
        let expected = expected.map(|(name, fields)| (name.to_string(), fields.to_string()));
        assert_eq!(read(text), expected);
        assert_eq!(included(text).collect::<Vec<_>>(), ["math.h"]);
    }

    #[test]
    fn broken_text_ends() {
        for text in [
            "struct A { float",
            "}}} struct A { int b; };",
            "struct A { int b = (; } /*",
            "<",
            "\"",
            "{",
        ] {
            structures(text);
        }
        assert_eq!(read("}}} struct A { int b; };"), [("A".to_string(), "b".to_string())]);
    }
}
