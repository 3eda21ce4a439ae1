//! Generates the other stage that a probe's pipeline needs.
//!
//! A vertex probe needs a fragment stage. In OpenGL, a fragment probe needs a vertex stage that
//! writes each input the user's own `main` reads, though that is dead code: it is made from the
//! user's declarations, with `in` turned into `out`.

use std::ops::Range;

use landfall_layout::source::{Language, ReadOptions, Source, Stage};
use landfall_layout::syntax::glsl::ast::{Item, Storage, TypeBase};
pub use landfall_layout::syntax::glsl::raw;
pub use landfall_layout::syntax::glsl::raw::{RawDeclaration, RawText, RawToken};

/// Returns a minimal fragment stage in the version of the given text.
pub(crate) fn fragment(of: &Source, options: &ReadOptions) -> Source {
    let raw = raw::read(of, options);
    // ES links stages of one version only.
    let version = raw.version_directive(&of.text);
    let version = match of.language {
        Language::Glsl | Language::SpirV => version.unwrap_or("#version 450"),
        Language::Wgsl => "#version 450",
    };
    let text = format!(
        "{version}\nprecision highp int;\n#if __VERSION__ > 320\nlayout(location = 0)\n#endif\n\
         out highp uvec4 landfall_pixel;\nvoid main() {{ landfall_pixel = uvec4(0u); }}\n"
    );
    let (language, stage) = (Language::Glsl, Some(Stage::Fragment));
    Source { language, stage, ..Source::new(&of.path, text) }
}

/// Returns a vertex stage that declares the inputs of a fragment shader as outputs and covers the
/// image.
pub(crate) fn vertex(of: &Source, options: &ReadOptions) -> String {
    let raw = raw::read(of, options);
    let mut text = String::with_capacity(1024);
    let mut directives = directives(&raw).into_iter().peekable();
    for declaration in raw.declarations(&of.text) {
        let Some(&first) = declaration.tokens.first() else { continue };
        // A directive applies to what follows it, so each keeps its place.
        while let Some(directive) = directives.next_if(|directive| directive.start < first) {
            append_directive(&mut text, of, &raw, &directive);
        }
        append(&mut text, of, &raw, &declaration);
    }
    directives.for_each(|directive| append_directive(&mut text, of, &raw, &directive));
    // `gl_VertexID` exists from GLSL 1.30 and ES 3.00 on.
    let has_vertex_id = raw.version >= 130 || raw.es && raw.version != 100;
    text.push_str(match has_vertex_id {
        true => {
            "void main() {\n    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, \
             gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n}\n"
        }
        false => "void main() { gl_Position = vec4(0.0, 0.0, 0.0, 1.0); }\n",
    });
    text
}

/// Returns the directives that the compiler obeys, as token ranges.
fn directives(raw: &RawText) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for (at, token) in raw.tokens.iter().enumerate().filter(|(_, token)| token.active) {
        let Some(number) = token.directive else { continue };
        match all.last_mut() {
            Some(last) if raw.tokens[last.start].directive == Some(number) => last.end = at + 1,
            _ => all.push(at..at + 1),
        }
    }
    all
}

/// Copies a directive, except for conditions, which have been evaluated already.
fn append_directive(text: &mut String, of: &Source, raw: &RawText, directive: &Range<usize>) {
    let tokens = &raw.tokens[directive.clone()];
    let word = |token: &RawToken| &of.text[token.start..token.end];
    let name = tokens.get(1).map_or("", word);
    if !matches!(name, "if" | "ifdef" | "ifndef" | "elif" | "else" | "endif") {
        text.push_str(&of.text[tokens[0].start..tokens[tokens.len() - 1].end]);
        text.push('\n');
    }
}

/// Copies declarations of types, constants and precision unchanged, and inputs as outputs.
fn append(text: &mut String, of: &Source, raw: &RawText, declaration: &RawDeclaration<'_>) {
    let qualifiers = match &declaration.item {
        Item::Variables(variables) => Some(&variables.qualifiers),
        Item::Interface(block) => Some(&block.qualifiers),
        _ => None,
    };
    let storage = qualifiers.map_or(Storage::Plain, |qualifiers| qualifiers.storage);
    let kept = match &declaration.item {
        Item::Variables(variables) => {
            matches!(variables.ty.base, TypeBase::Struct(_))
                || matches!(storage, Storage::In | Storage::Const | Storage::Varying)
        }
        Item::Interface(_) => storage == Storage::In,
        Item::Precision(_) => true,
        _ => false,
    };
    if !kept {
        return;
    }
    let count = qualifiers.map_or(0, |qualifiers| qualifiers.tokens.len());
    let mut before = None;
    for (nth, &at) in declaration.tokens.iter().enumerate() {
        let token = &raw.tokens[at];
        // A space where the text has something between.
        if before.is_some_and(|before| token.start > before) {
            text.push(' ');
        }
        before = Some(token.end);
        text.push_str(match &of.text[token.start..token.end] {
            "in" if nth < count && storage == Storage::In => "out",
            word => word,
        });
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

    #[test]
    fn conditions_inside_of_declarations_are_obeyed() {
        let source = Source::new(
            "a.frag",
            "#version 450\n#define WIDE 1\nstruct S {\n#if WIDE\n    vec4 a;\n#else\n    \
             vec2 a;\n#endif\n};\n#if 0\nin vec2 b;\n#else\nin vec3 b;\n#endif\nvoid main() {}\n",
        );
        let text = vertex(&source, &ReadOptions::default());
        let body = text.split("void main").next().expect("there is a start");
        let own = "#version 450\n#define WIDE 1\nstruct S { vec4 a; };\nout vec3 b;\n";
        assert_eq!(body, own);
    }
}
