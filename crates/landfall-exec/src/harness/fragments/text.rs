//! Adapts the user's GLSL for OpenGL so that inputs are fetched from a texture:
//! [`rewrite`](crate::harness::rewrite) turns the inputs into variables, and a new `main` fills
//! them and calls the old one.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::sync::Arc;

use super::{ATLAS, Input, InputKind, PIXEL, SIZE};
use crate::harness::rewrite::{MAIN, ReplacedBuiltin, RewriteTargets, rewritten, root};
use crate::harness::verify::request::without_qualifier;
use landfall_layout::source::{Language, ReadOptions, Source, Target};
use landfall_layout::syntax::glsl::ast::{Item, Storage, TypeBase};
pub use landfall_layout::syntax::glsl::raw;
pub use landfall_layout::syntax::glsl::raw::RawText;

/// The name that replaces `gl_FragCoord`.
const COORDINATE: &str = "landfall_FragCoord";

/// The output of the new `main`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Writes {
    /// The shader's own output.
    Result,
    /// White unless the shader discards.
    White,
}

/// Adds `#version 100` to a text without `#version` that declares precisions, as OpenGL ES
/// compilers take it.
pub(super) fn versioned<'s>(source: &'s Source, options: &ReadOptions) -> Cow<'s, Source> {
    if source.language != Language::Glsl
        || raw::read(source, options).version_directive(&source.text).is_some()
    {
        return Cow::Borrowed(source);
    }
    let flat = raw::flattened(source, options);
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let precise =
        flat.split(|c| !is_word(c)).any(|word| matches!(word, "lowp" | "mediump" | "highp"));
    match precise {
        true => {
            let text = Arc::from(format!("#version 100\n{}", source.text));
            Cow::Owned(Source { text, ..source.clone() })
        }
        false => Cow::Borrowed(source),
    }
}

/// Returns whether the text samples with coordinates from 0 to 1, and so needs the texture's size.
pub(super) fn wants_size(source: &Source, options: &ReadOptions) -> bool {
    let raw = raw::read(source, options);
    !fetches(raw.version, raw.es)
}

/// Returns whether row 0 of `gl_FragCoord` is the bottom one.
pub(super) fn is_opengl(source: &Source, options: &ReadOptions) -> bool {
    let raw = || raw::read(source, options).target;
    source.language == Language::Glsl && raw() != Some(Target::Vulkan)
}

/// Returns whether `texelFetch` is available: GLSL 1.30 and ES 3.00.
fn fetches(version: u32, es: bool) -> bool {
    if es { version >= 300 } else { version >= 130 }
}

/// Returns the text for OpenGL's compiler.
pub(super) fn text(
    source: &Source,
    options: &ReadOptions,
    inputs: &[Input],
    writes: Writes,
) -> String {
    let pixel = inputs.iter().find(|input| input.name == PIXEL).map(|_| ReplacedBuiltin {
        name: PIXEL.to_string(),
        own: COORDINATE.to_string(),
        ty: "vec4",
    });
    let wanted = RewriteTargets {
        late: inputs.iter().map(|input| root(&input.name).to_string()).collect(),
        builtins: pixel.into_iter().collect(),
        blocks: Vec::new(),
    };
    let mut rewritten = rewritten(source, options, &wanted);
    let mut out = std::mem::take(&mut rewritten.text);
    let raw = &rewritten.raw;
    let es = raw.es;
    let highp = if es { "highp " } else { "" };
    let int = highp;
    let _ = writeln!(out, "uniform {highp}sampler2D {ATLAS};");
    let fetches = fetches(raw.version, es);
    let count = inputs.len();
    // The inputs lie one below the other in the texture.
    if fetches {
        let _ = writeln!(
            out,
            "{highp}vec4 landfall_texel({int}int k) {{\n    \
             {int}int rows = textureSize({ATLAS}, 0).y / {};\n    \
             return texelFetch({ATLAS}, ivec2(gl_FragCoord.xy) + ivec2(0, k * rows), 0);\n}}",
            count.max(1)
        );
    } else {
        // Fragment coordinates are the middles of pixels, and so of texels.
        let _ = writeln!(
            out,
            "uniform {highp}vec2 {SIZE};\n\
             {highp}vec4 landfall_texel({highp}float k) {{\n    \
             return texture2D({ATLAS}, (gl_FragCoord.xy + vec2(0.0, k * {SIZE}.y)) / \
             vec2({SIZE}.x, {count}.0 * {SIZE}.y));\n}}",
        );
    }
    out.push_str("void main() {\n");
    for (number, input) in inputs.iter().enumerate() {
        let name = match input.name.as_str() {
            PIXEL => COORDINATE.to_string(),
            name => rewritten.renamed(name),
        };
        let number = if fetches { number.to_string() } else { format!("{number}.0") };
        let part = ["x", "xy", "xyz", "xyzw"][usize::from(input.components.clamp(1, 4)) - 1];
        let vector = |prefix: &str, scalar: &str| match input.components {
            1 => scalar.to_string(),
            n => format!("{prefix}vec{n}"),
        };
        let texel = format!("landfall_texel({number}).{part}");
        let value = match input.kind {
            InputKind::Float => texel,
            InputKind::Sint => format!("{}({texel})", vector("i", "int")),
            InputKind::Uint => format!("{}({texel})", vector("u", "uint")),
        };
        let _ = writeln!(out, "    {name} = {value};");
    }
    // What is initialised by an input has its value only here.
    for assignment in &rewritten.late {
        let _ = writeln!(out, "    {assignment}");
    }
    let _ = writeln!(out, "    {MAIN}();");
    if writes == Writes::White {
        // The new outputs overwrite the shader's own.
        let name = outputs(raw, &rewritten.flat.text);
        let _ = writeln!(out, "    {name};");
    }
    out.push_str("}\n");
    // OpenGL has no descriptor sets.
    without_qualifier(&out, "set")
}

/// Returns a statement that makes the first output white.
fn outputs(raw: &RawText, text: &str) -> String {
    for declaration in raw.declarations(text) {
        let Item::Variables(variables) = &declaration.item else { continue };
        let (TypeBase::Name(ty), Some(first)) = (&variables.ty.base, variables.names.first())
        else {
            continue;
        };
        let colored = ty.starts_with("vec") || *ty == "float";
        if variables.qualifiers.storage == Storage::Out && colored {
            let array = !(first.dims.is_empty() && variables.ty.dims.is_empty());
            let element = if array { "[0]" } else { "" };
            return format!("{}{element} = {ty}(1.0)", first.name.text);
        }
    }
    // Without a variable of its own, the shader writes a built-in one.
    let data = raw.tokens.iter().any(|token| &text[token.start..token.end] == "gl_FragData");
    if data { "gl_FragData[0] = vec4(1.0)" } else { "gl_FragColor = vec4(1.0)" }.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(name: &str, components: u8) -> Input {
        let (name, interpolation) = (name.to_string(), String::new());
        Input { name, location: Some(0), components, kind: InputKind::Float, interpolation }
    }

    fn rewritten(text_in: &str, inputs: &[Input]) -> String {
        let source = Source::new("a.frag", text_in);
        text(&source, &ReadOptions::default(), inputs, Writes::Result)
    }

    #[test]
    fn inputs_become_variables_and_main_a_function() {
        let text = rewritten(
            "#version 450\n#define V vec3\nlayout(early_fragment_tests) in;\n\
             layout(location = 0) in V place;\nlayout(location = 1) in Stage { flat int id; vec2 uv[2]; } stage;\n\
             in Bare { smooth vec3 n; };\nout vec4 color;\nfloat f(in float x) { return x; }\n\
             void main() { color = vec4(f(place.x)); }\n",
            &[input("place", 3), input("Stage.uv[1]", 2), input("Bare.n", 3)],
        );
        for line in [
            "layout(early_fragment_tests) in;",
            "vec3 place ;",
            "struct landfall_Stage { int id ; vec2 uv [ 2 ] ; };",
            "landfall_Stage stage ;",
            "vec3 n ;",
            "float f(in float x) { return x; }",
            "void landfall_main() { color = vec4(f(place.x)); }",
            "    place = landfall_texel(0).xyz;",
            "    stage.uv[1] = landfall_texel(1).xy;",
            "    n = landfall_texel(2).xyz;",
            "    landfall_main();",
        ] {
            assert!(text.lines().any(|other| other == line), "{line}\n--\n{text}");
        }
    }

    #[test]
    fn a_variable_that_begins_as_an_input_waits_for_it() {
        let text = rewritten(
            "#version 330\nin vec3 v;\nvec3 n = normalize(v);\nfloat k = 2.0;\nvoid main() {}\n",
            &[input("v", 3)],
        );
        assert!(
            text.contains("vec3 n;\n") && text.contains("    n = normalize ( v ) ;\n"),
            "{text}"
        );
        assert!(text.contains("float k = 2.0;\n"), "{text}");
    }
}
