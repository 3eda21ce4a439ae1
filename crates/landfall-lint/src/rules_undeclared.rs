//! `rules-undeclared`: blocks whose offsets the driver chooses.

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::settings::Target;
use super::show::{may_be_vulkan, place};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::Span;

pub(super) const LINT: Lint = Lint {
    code: "rules-undeclared",
    level: Level::Warn,
    what: "a block without std140 or std430, whose offsets the driver chooses",
    why: "Without a qualifier a block is `shared` (GLSL 4.60 §4.4.5): each driver may place its \
          members as it likes, and only a query (glGetActiveUniformsiv) returns where they are. \
          Offsets computed in any other way, by Landfall too, are right by chance only. Vulkan's \
          defaults are std140 and std430, so nothing is reported where `vulkan` is a target and no \
          OpenGL is, nor in shaders of version 4.50 on that Vulkan accepts unchanged: a binding \
          on every block, no loose uniforms. `--fix` writes the qualifier where there was none: \
          host code that queries the driver keeps working, as it receives the new offsets, and \
          host code that does not query must have assumed std140; but every stage of a program has \
          to declare the same, so fix them together. An explicit `shared` or `packed` is left for \
          the author to change.",
    example: "#version 330 core\n\
              uniform Light { vec3 color; float intensity; } u_light;\n\
              out vec4 shade;\n\
              void main() { shade = vec4(u_light.color * u_light.intensity, 1.0); }\n",
    fix: "Write `layout(std140)` before `uniform`, `layout(std430)` before `buffer`, in every \
          stage that declares the block.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    let opengl = |target: &Target| match target {
        Target::Gl33 | Target::Gles30 | Target::WebGl2 => true,
        Target::WebGpu | Target::Vulkan => false,
    };
    // A target of OpenGL counts more than that the text may be Vulkan's.
    let told = settings.targets.iter().any(opengl);
    let vulkan = settings.targets.contains(&Target::Vulkan) || may_be_vulkan(subject);
    if vulkan && !told {
        return Vec::new();
    }
    let blocks = subject.shader.blocks.iter();
    let undeclared = blocks.filter(|b| !b.rules_declared && !b.gathered);
    undeclared.map(|block| finding(subject, block)).collect()
}

fn finding(subject: &Subject<'_>, block: &BlockLayout) -> Finding {
    let rules = block.rules.name();
    let keyword = block.space.keyword();
    let declared = declaration(subject, block, keyword);
    let message = match declared {
        BlockPrefix::Chosen(word) => {
            format!("block `{}` is `{word}`: the driver chooses where its members are", block.name)
        }
        BlockPrefix::Bare(_) | BlockPrefix::Qualified(_) | BlockPrefix::Elsewhere => {
            format!(
                "block `{}` declares no layout rules: the driver chooses its offsets",
                block.name
            )
        }
    };
    let finding = Finding::at(LINT.code, block.name.as_ref(), place(subject, block.span), message)
        .with_text(format!("laid out as {rules} here"));
    match declared {
        BlockPrefix::Bare(at) => finding
            .with_help(format!("write `layout({rules}) {keyword} {}`", block.name))
            .with_edit(place(subject, at), format!("layout({rules}) ")),
        BlockPrefix::Qualified(at) => finding
            .with_help(format!("write `{rules}` into its `layout(…)`"))
            .with_edit(place(subject, at), format!("{rules}, ")),
        BlockPrefix::Chosen(word) => finding
            .with_note("host code has to query every offset from the driver")
            .with_help(format!("write `{rules}` instead of `{word}`")),
        BlockPrefix::Elsewhere => {
            finding.with_help(format!("write `layout({rules})` before its `{keyword}`"))
        }
    }
}

/// The text before a block's name, with the place for the qualifier.
enum BlockPrefix {
    /// `uniform NAME`: before the keyword.
    Bare(Span),
    /// `layout(binding = 0) uniform NAME`: behind the parenthesis.
    Qualified(Span),
    /// `layout(shared) uniform NAME`.
    Chosen(&'static str),
    /// Anything else: a macro, a comment in between.
    Elsewhere,
}

fn declaration(subject: &Subject<'_>, block: &BlockLayout, keyword: &str) -> BlockPrefix {
    let span = block.span;
    let text = subject.shader.files.get(span.file).map_or("", |file| &file.text);
    let before = text.get(..span.start as usize).unwrap_or("");
    // The name comes from a macro.
    if subject.shader.files.text(span) != &*block.name {
        return BlockPrefix::Elsewhere;
    }
    let head = before.trim_end();
    let Some(at) = head.strip_suffix(keyword).map(str::len) else { return BlockPrefix::Elsewhere };
    let point = |at: usize| Span { start: at as u32, end: at as u32, ..span };
    // The other qualifiers end where the declaration before this one does.
    let mut rest = head[..at].trim_end();
    loop {
        if let Some(inside) = rest.strip_suffix(')') {
            let Some(open) = inside.rfind('(') else { return BlockPrefix::Elsewhere };
            // A comment in the parentheses could hide what is written there.
            if !inside[..open].trim_end().ends_with("layout") || inside[open..].contains("//") {
                return BlockPrefix::Elsewhere;
            }
            let ids = &inside[open + 1..];
            let is = |word: &str| ids.split(',').any(|id| id.trim() == word);
            if let Some(word) = ["shared", "packed"].into_iter().find(|word| is(word)) {
                return BlockPrefix::Chosen(word);
            }
            return match ids.trim().is_empty() {
                true => BlockPrefix::Elsewhere,
                false => BlockPrefix::Qualified(point(open + 1)),
            };
        }
        let word = rest.rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_').next();
        match word {
            Some(word) if QUALIFIERS.contains(&word) => {
                rest = rest[..rest.len() - word.len()].trim_end();
            }
            // A macro, or the last word of a comment or directive on a line of its own.
            Some(word) if !word.is_empty() && ends_line(rest, before, at) => {
                return BlockPrefix::Bare(point(at));
            }
            Some("") | None if rest.is_empty() || rest.ends_with([';', '}', '/']) => {
                return BlockPrefix::Bare(point(at));
            }
            Some(_) if ends_line(rest, before, at) => return BlockPrefix::Bare(point(at)),
            Some(_) | None => return BlockPrefix::Elsewhere,
        }
    }
}

/// Returns whether a line break separates the rest from the declaration.
fn ends_line(rest: &str, before: &str, at: usize) -> bool {
    before[rest.len()..at].contains('\n')
}

/// The qualifiers that may precede the keyword of a block.
const QUALIFIERS: &[&str] =
    &["coherent", "volatile", "restrict", "readonly", "writeonly", "highp", "mediump", "lowp"];
