//! The user's GLSL with inputs that are fetched from a texture, for OpenGL: declarations of
//! inputs become variables, `main` a function, and a new `main` fills the ones and calls the
//! other.
//!
//! Everything else stays as it was written; includes are put in and macros expanded first, so
//! that a declaration made by a macro is found.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::sync::Arc;

use super::{ATLAS, Input, InputKind, PIXEL, SIZE};
use crate::parse::glsl::lexer::Kind;
use crate::parse::glsl::raw::{self, RawToken};
use crate::run::verify::{code, partner};
use crate::source::{Language, ReadOptions, Source, Target};

/// The name of what was `main`.
const MAIN: &str = "landfall_main";

/// What stands for `gl_FragCoord` where that is an input.
const COORDINATE: &str = "landfall_FragCoord";

/// Words before a type that mean something of inputs alone.
const INPUT_WORDS: [&str; 8] =
    ["in", "varying", "flat", "smooth", "noperspective", "centroid", "sample", "invariant"];

/// What the new `main` does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Writes {
    /// What the shader does.
    Result,
    /// White wherever the shader does not discard.
    White,
}

/// A text without `#version` that has precisions is of OpenGL ES, whose compilers take it so.
pub(super) fn versioned<'s>(source: &'s Source, options: &ReadOptions) -> Cow<'s, Source> {
    if source.language != Language::Glsl || source.text.contains("#version") {
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

/// Whether the text fetches by coordinates from 0 to 1, and so wants to know the size.
pub(super) fn wants_size(source: &Source, options: &ReadOptions) -> bool {
    let raw = raw::read(source, options);
    !fetches(raw.version, raw.es)
}

/// Whether `gl_FragCoord` counts from the bottom.
pub(super) fn is_opengl(source: &Source, options: &ReadOptions) -> bool {
    let raw = || raw::read(source, options).target;
    source.language == Language::Glsl && raw() != Some(Target::Vulkan)
}

/// `texelFetch` is of GLSL 1.30 and ES 3.00.
fn fetches(version: u32, es: bool) -> bool {
    if es { version >= 300 } else { version >= 130 }
}

/// The text for OpenGL's compiler.
pub(super) fn text(
    source: &Source,
    options: &ReadOptions,
    inputs: &[Input],
    writes: Writes,
) -> String {
    let flat = Source { text: Arc::from(raw::flattened(source, options)), ..source.clone() };
    // Macros are gone, and definitions of the command line with them.
    let raw = raw::read(&flat, &ReadOptions::default());
    let mut rewriter = Rewriter { text: &flat.text, out: String::new(), ..Rewriter::default() };
    rewriter.roots = inputs.iter().map(|input| root(&input.name).to_string()).collect();
    rewriter.pixel = inputs.iter().any(|input| input.name == PIXEL);
    let highp = if raw.es { "highp " } else { "" };
    let tokens = &raw.tokens;
    let mut at = 0;
    let mut declared = !rewriter.pixel;
    while at < tokens.len() {
        if tokens[at].directive.is_none() && !std::mem::replace(&mut declared, true) {
            let _ = writeln!(rewriter.out, "{highp}vec4 {COORDINATE};");
        }
        if let Some(directive) = tokens[at].directive {
            let same = |t: &&RawToken| t.directive == Some(directive);
            let count = tokens[at..].iter().take_while(same).count();
            let line = &flat.text[tokens[at].start..tokens[at + count - 1].end];
            let _ = writeln!(rewriter.out, "{line}");
            at += count;
            continue;
        }
        let word = |token: &RawToken| &flat.text[token.start..token.end];
        let found = partner::statement(&tokens[at..], &word);
        let statement = &tokens[at..at + found.end];
        at += found.end;
        rewriter.statement(statement, found.function);
    }
    let Rewriter { mut out, blocks, late, .. } = rewriter;
    let es = raw.es;
    let int = highp;
    let _ = writeln!(out, "uniform {highp}sampler2D {ATLAS};");
    let fetches = fetches(raw.version, es);
    let count = inputs.len();
    if fetches {
        let _ = writeln!(
            out,
            "{highp}vec4 landfall_texel({int}int k) {{\n    \
             {int}int rows = textureSize({ATLAS}, 0).y / {};\n    \
             return texelFetch({ATLAS}, ivec2(gl_FragCoord.xy) + ivec2(0, k * rows), 0);\n}}",
            count.max(1)
        );
    } else {
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
            name => renamed(name, &blocks),
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
    for assignment in late {
        let _ = writeln!(out, "    {assignment}");
    }
    let _ = writeln!(out, "    {MAIN}();");
    if writes == Writes::White {
        // All that is written before is written over.
        let name = outputs(tokens, &flat.text);
        let _ = writeln!(out, "    {name};");
    }
    out.push_str("}\n");
    code::without(&out, "set")
}

/// The name a path begins with.
fn root(path: &str) -> &str {
    path.split(['.', '[']).next().unwrap_or(path)
}

/// An input as `main` can write it: a member of a block is named by OpenGL after the block.
fn renamed(path: &str, blocks: &[(String, Option<String>)]) -> String {
    let Some((block, rest)) = path.split_once('.') else { return path.to_string() };
    match blocks.iter().find(|(name, _)| name == block) {
        Some((_, Some(instance))) => format!("{instance}.{rest}"),
        Some((_, None)) => rest.to_string(),
        None => path.to_string(),
    }
}

/// A statement that makes the first output white.
fn outputs(tokens: &[RawToken], text: &str) -> String {
    let word = |token: &RawToken| &text[token.start..token.end];
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at].directive.is_some() {
            at += 1;
            continue;
        }
        let found = partner::statement(&tokens[at..], &word);
        let words: Vec<&str> = tokens[at..at + found.end].iter().map(word).collect();
        at += found.end;
        let mut depth = 0u32;
        let head = words.iter().take_while(|word| !matches!(**word, "{" | "=" | ";"));
        let out = head.into_iter().any(|word| {
            match *word {
                "(" => depth += 1,
                ")" => depth = depth.saturating_sub(1),
                _ => {}
            }
            depth == 0 && *word == "out"
        });
        if let (true, Some(end)) = (out && !found.function, words.iter().rposition(|w| *w == ";")) {
            let ty = words.iter().find(|w| w.starts_with("vec") || **w == "float");
            let first = words[..end].iter().position(|w| *w == "=" || *w == "[" || *w == ",");
            let name = words[..first.unwrap_or(end)].last();
            if let (Some(ty), Some(name)) = (ty, name) {
                let element = if words.contains(&"[") { "[0]" } else { "" };
                return format!("{name}{element} = {ty}(1.0)");
            }
        }
    }
    let data = tokens.iter().any(|token| word(token) == "gl_FragData");
    if data { "gl_FragData[0] = vec4(1.0)" } else { "gl_FragColor = vec4(1.0)" }.to_string()
}

#[derive(Default)]
struct Rewriter<'t> {
    text: &'t str,
    out: String,
    /// Blocks of inputs, and their instances.
    blocks: Vec<(String, Option<String>)>,
    /// Assignments that wait for the inputs.
    late: Vec<String>,
    /// Names of inputs.
    roots: Vec<String>,
    /// Whether the pixel is one of them.
    pixel: bool,
}

impl<'t> Rewriter<'t> {
    fn word(&self, token: &RawToken) -> &'t str {
        &self.text[token.start..token.end]
    }

    fn statement(&mut self, tokens: &[RawToken], function: bool) {
        let mut depth = 0u32;
        let mut head = Vec::new();
        for token in tokens {
            match self.word(token) {
                "(" => depth += 1,
                ")" => depth = depth.saturating_sub(1),
                "{" | "=" if depth == 0 => break,
                word if depth == 0 => head.push(word),
                _ => {}
            }
        }
        let has = |name: &str| head.contains(&name);
        let of_inputs = has("in") && !(head.len() <= 3 && has(";")) || has("varying");
        let own = head.iter().any(|word| word.starts_with("gl_"));
        // `invariant normal;` of an input.
        let again = matches!(head[..], ["invariant" | "centroid", name, ";"] if self.roots.iter().any(|r| r == name));
        if own && of_inputs && self.pixel && has(PIXEL) {
            return;
        }
        if function || !(of_inputs || again) || own {
            return self.other(tokens, &head, function);
        }
        if again {
            return;
        }
        let opening = tokens.iter().position(|token| self.word(token) == "{");
        match opening {
            Some(opening) => self.block(tokens, opening),
            None => {
                let words = self.plain(tokens);
                let _ = writeln!(self.out, "{}", words.join(" "));
            }
        }
    }

    /// The words of a declaration without what is of inputs alone.
    fn plain(&self, tokens: &[RawToken]) -> Vec<&'t str> {
        let mut words = Vec::new();
        let mut at = 0;
        while at < tokens.len() {
            let word = self.word(&tokens[at]);
            at += 1;
            if word == "layout" {
                let close = tokens[at..].iter().position(|t| self.word(t) == ")");
                at += close.map_or(0, |close| close + 1);
            } else if !INPUT_WORDS.contains(&word) {
                words.push(word);
            }
        }
        words
    }

    /// A block of inputs: a structure and a variable, or a variable for each member.
    fn block(&mut self, tokens: &[RawToken], opening: usize) {
        let name = match opening.checked_sub(1) {
            Some(before) => self.word(&tokens[before]).to_string(),
            None => String::new(),
        };
        let close = tokens.iter().rposition(|token| self.word(token) == "}");
        let close = close.unwrap_or(tokens.len() - 1);
        let members = self.plain(&tokens[opening + 1..close]).join(" ");
        let rest = self.plain(&tokens[close + 1..]);
        match rest.first().filter(|word| **word != ";") {
            Some(instance) => {
                self.blocks.push((name.clone(), Some((*instance).to_string())));
                let rest = rest.join(" ");
                let _ = writeln!(self.out, "struct landfall_{name} {{ {members} }};");
                let _ = writeln!(self.out, "landfall_{name} {rest}");
            }
            None => {
                self.blocks.push((name, None));
                let _ = writeln!(self.out, "{members}");
            }
        }
    }

    /// What declares no input, as it stands.
    fn other(&mut self, tokens: &[RawToken], head: &[&str], function: bool) {
        if self.waits(tokens, head, function) {
            return;
        }
        let mut before = tokens.first().map_or(0, |token| token.start);
        let mut last = "";
        for token in tokens {
            let gap = &self.text[before..token.start];
            self.out.push_str(if gap.contains('\n') {
                "\n"
            } else if gap.is_empty() {
                ""
            } else {
                " "
            });
            before = token.end;
            let word = self.word(token);
            let is_main = word == "main" && last == "void" && token.kind == Kind::Name;
            self.out.push_str(match word {
                _ if is_main => MAIN,
                PIXEL if self.pixel => COORDINATE,
                word => word,
            });
            last = word;
        }
        self.out.push('\n');
    }

    /// Splits `vec3 n = normalize(v);` where `v` is an input, which has no value there yet.
    fn waits(&mut self, tokens: &[RawToken], head: &[&str], function: bool) -> bool {
        let words: Vec<&str> = tokens.iter().map(|token| self.word(token)).collect();
        let Some(equals) = words.iter().position(|word| *word == "=") else { return false };
        let fixed = ["const", "uniform", "out", "buffer", "shared"];
        if function || equals == 0 || head.iter().any(|word| fixed.contains(word)) {
            return false;
        }
        let reads = words[equals..].iter().any(|word| self.roots.iter().any(|root| root == word));
        let mut depth = 0i32;
        let several = words[equals..].iter().any(|word| {
            match *word {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            depth == 0 && *word == ","
        });
        if !reads || several {
            return false;
        }
        let _ = writeln!(self.out, "{};", words[..equals].join(" "));
        self.late.push(format!("{} {}", words[equals - 1], words[equals..].join(" ")));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(name: &str, components: u8) -> Input {
        Input { name: name.to_string(), location: Some(0), components, kind: InputKind::Float }
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
