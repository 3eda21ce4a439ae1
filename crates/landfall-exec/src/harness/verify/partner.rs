//! The stage beside a probe, without which its pipeline is not whole.
//!
//! A vertex probe needs a fragment stage. A fragment probe needs, in OpenGL, a vertex
//! stage that writes each input the user's own `main` reads, though that is dead: made
//! from the user's declarations, `in` turned into `out`.

use std::sync::Arc;

use landfall_layout::source::{Language, ReadOptions, Source, Stage};
pub use landfall_layout::syntax::glsl::raw;
pub use landfall_layout::syntax::glsl::raw::RawToken;

/// A fragment stage that writes nothing of note, in the version of that text.
pub(crate) fn fragment(of: &Source) -> Source {
    let version = of.text.lines().find(|line| line.trim_start().starts_with("#version"));
    let version = match of.language {
        Language::Glsl => version.unwrap_or("#version 450"),
        Language::Wgsl => "#version 450",
    };
    let text = format!(
        "{version}\nprecision highp int;\n#if __VERSION__ > 320\nlayout(location = 0)\n#endif\n\
         out highp uvec4 landfall_pixel;\nvoid main() {{ landfall_pixel = uvec4(0u); }}\n"
    );
    Source {
        path: of.path.clone(),
        text: Arc::from(text),
        language: Language::Glsl,
        stage: Some(Stage::Fragment),
        foreign: None,
    }
}

/// A vertex stage that declares what a fragment shader reads, and covers the image.
pub(crate) fn vertex(of: &Source, options: &ReadOptions) -> String {
    let raw = raw::read(of, options);
    let tokens = &raw.tokens;
    let word = |token: &RawToken| &of.text[token.start..token.end];
    let mut text = String::with_capacity(1024);
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at].directive.is_some() {
            let directive = tokens[at].directive;
            let count = tokens[at..].iter().take_while(|t| t.directive == directive).count();
            text.push_str(&of.text[tokens[at].start..tokens[at + count - 1].end]);
            text.push('\n');
            at += count;
            continue;
        }
        let Statement { end, function } = statement(&tokens[at..], &word);
        let statement = &tokens[at..at + end];
        at += end;
        if !function && statement.first().is_some_and(|token| token.active) {
            append(&mut text, statement, &word);
        }
    }
    let input = if raw.version < 130 && !raw.es || raw.version == 100 { "attribute" } else { "" };
    if input.is_empty() {
        text.push_str(
            "void main() {\n    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, \
             gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n}\n",
        );
    } else {
        text.push_str("void main() { gl_Position = vec4(0.0, 0.0, 0.0, 1.0); }\n");
    }
    text
}

/// A statement outside of functions.
pub(crate) struct Statement {
    /// Tokens it has.
    pub end: usize,
    pub function: bool,
}

pub(crate) fn statement<'t>(
    tokens: &[RawToken],
    word: &impl Fn(&RawToken) -> &'t str,
) -> Statement {
    let (mut depth, mut function) = (0u32, false);
    let mut before = "";
    for (nth, token) in tokens.iter().enumerate() {
        if token.directive.is_some() {
            return Statement { end: nth.max(1), function };
        }
        let text = word(token);
        match text {
            "{" => {
                function |= depth == 0 && before == ")";
                depth += 1;
            }
            "(" | "[" => depth += 1,
            ")" | "]" => depth = depth.saturating_sub(1),
            "}" => {
                depth = depth.saturating_sub(1);
                if depth == 0 && function {
                    return Statement { end: nth + 1, function };
                }
            }
            ";" if depth == 0 => return Statement { end: nth + 1, function },
            _ => {}
        }
        before = text;
    }
    Statement { end: tokens.len().max(1), function }
}

/// Takes over declarations of types, constants and precision as they are, and inputs as outputs.
fn append<'t>(text: &mut String, statement: &[RawToken], word: &impl Fn(&RawToken) -> &'t str) {
    let mut depth = 0u32;
    let mut head = Vec::new();
    for token in statement {
        match word(token) {
            "(" => depth += 1,
            ")" => depth = depth.saturating_sub(1),
            "{" | "=" if depth == 0 => break,
            other if depth == 0 => head.push(other),
            _ => {}
        }
    }
    let has = |name: &str| head.contains(&name);
    let input = has("in") && !(head.len() <= 3 && has(";"));
    if !(input || has("struct") || has("const") || has("precision") || has("varying")) {
        return;
    }
    let (mut depth, mut turned) = (0u32, false);
    let mut before = statement[0].start;
    for token in statement {
        if token.start > before {
            text.push(' ');
        }
        before = token.end;
        let mut part = word(token);
        match part {
            "(" | "{" => depth += 1,
            ")" | "}" => depth = depth.saturating_sub(1),
            "in" if depth == 0 && input && !turned => {
                part = "out";
                turned = true;
            }
            _ => {}
        }
        text.push_str(part);
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_become_outputs_and_bodies_go() {
        let source = Source::new(
            "a.frag",
            "#version 450\n#define N 2\nlayout(early_fragment_tests) in;\n\
             struct Surface { vec3 normal; };\nlayout(location = 0) flat in int id;\n\
             in Stage { vec2 uv[N]; } stage;\nuniform B { vec4 b; };\n\
             float f(in float x) { return x; }\nvoid main() { float y = f(b.x); }\n",
        );
        let text = vertex(&source, &ReadOptions::default());
        let body = text.split("void main").next().expect("there is a start");
        assert_eq!(
            body,
            "#version 450\n#define N 2\nstruct Surface { vec3 normal; };\n\
             layout(location = 0) flat out int id;\nout Stage { vec2 uv[N]; } stage;\n"
        );
    }
}
