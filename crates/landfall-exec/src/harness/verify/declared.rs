//! The declaration of one block: the user's own tokens, macros expanded, with the structures and
//! constants that it needs, and nothing else of the shader. In GLSL ES 3.00, which WebGL 2 takes, or
//! as a shader that `landfall port` takes where it does not take the whole.

use rustc_hash::FxHashSet;

use super::partner;
use super::request::{opened, without_qualifier};
use crate::harness::probe::{glsl, pixels};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{AddressSpace, Rules, Type};
use landfall_layout::source::{Language, ReadOptions, Source, Stage};
use landfall_layout::syntax::glsl::ast::{Item, Storage, TypeBase};
use landfall_layout::syntax::glsl::raw;

/// The `#version` line, and the precision of everything: others could lose bits of a sentinel.
pub(super) const HEAD: &str = "#version 300 es\nprecision highp float;\nprecision highp int;\n";

/// Returns why WebGL 2 has no such block, if it has none.
pub(super) fn refusal(source: &Source, block: &BlockLayout) -> Option<String> {
    let lacks = |what: &str| Some(format!("WebGL 2 has no {what}"));
    if source.language == Language::Wgsl {
        return Some("WebGL does not accept WGSL".to_string());
    }
    match block.space {
        AddressSpace::Storage => return lacks("storage buffers"),
        AddressSpace::PushConstant => return lacks("push constants"),
        _ => {}
    }
    if block.rules != Rules::Std140 {
        return lacks(&format!("{} blocks, only std140", block.rules.name()));
    }
    if block.count.len() > 1 || block.members.iter().any(nests_arrays) {
        return lacks("arrays of arrays");
    }
    block.leaves.iter().find_map(|leaf| match &leaf.ty {
        Type::Scalar(scalar) | Type::Vector { scalar, .. } | Type::Matrix { scalar, .. }
            if scalar.width != 4 =>
        {
            lacks(&format!("type `{}`", leaf.ty.spelled(Language::Glsl)))
        }
        _ => None,
    })
}

fn nests_arrays(member: &MemberLayout) -> bool {
    member.dims.len() > 1 || member.members.iter().any(nests_arrays)
}

/// Returns the declaration of a block as a text of its own in GLSL ES 3.00, without `main`.
///
/// # Errors
/// Fails if GLSL ES 3.00 cannot declare it so.
pub(super) fn text(
    source: &Source,
    options: &ReadOptions,
    block: &BlockLayout,
) -> Result<String, String> {
    let declarations = declarations(source, options, block)?;
    let mut text = String::from(HEAD);
    for words in &declarations {
        let placed = |pair: &&[String]| matches!(&*pair[0], "offset" | "align") && pair[1] == "=";
        if let Some(pair) = words.windows(2).find(placed) {
            return Err(format!("GLSL ES 3.00 has no `{}` in `layout(…)`", pair[0]));
        }
        let words = words.iter().map(String::as_str);
        // The precisions are those of the head.
        let words: Vec<&str> =
            words.filter(|word| !matches!(*word, "lowp" | "mediump" | "highp")).collect();
        // Qualifiers of Vulkan and of later versions, which do not affect offsets.
        let dropped = ["set", "binding", "constant_id"];
        let fold = |text: String, word: &&str| without_qualifier(&text, word);
        text.push_str(&dropped.iter().fold(words.join(" "), fold));
        text.push('\n');
    }
    Ok(text)
}

/// Returns the declaration of a block as a shader of its own in the user's version of GLSL.
///
/// # Errors
/// Fails if it is not found.
pub(super) fn alone(
    source: &Source,
    options: &ReadOptions,
    block: &BlockLayout,
) -> Result<Source, String> {
    // The declarations may need an extension.
    let directive = |line: &&str| {
        let name = line.trim_start().strip_prefix('#').map(str::trim_start);
        name.is_some_and(|name| name.starts_with("version") || name.starts_with("extension"))
    };
    let mut text = String::new();
    for line in source.text.lines().filter(directive) {
        text.push_str(line);
        text.push('\n');
    }
    if glsl::Head::from_text(&source.text).es {
        text.push_str("precision highp float;\nprecision highp int;\n");
    }
    for words in declarations(source, options, block)? {
        text.push_str(&words.join(" "));
        text.push('\n');
    }
    text.push_str("void main() {}\n");
    Ok(Source { text: text.into(), ..source.clone() })
}

/// Returns the words of each declaration that a block needs, and of its own.
fn declarations(
    source: &Source,
    options: &ReadOptions,
    block: &BlockLayout,
) -> Result<Vec<Vec<String>>, String> {
    let flat = Source { text: raw::flattened(source, options).into(), ..source.clone() };
    let mut read = ReadOptions::default();
    read.target = options.target;
    let raw = raw::read(&flat, &read);
    let code = raw.code();
    let word = |at: &usize| &flat.text[raw.tokens[*at].start..raw.tokens[*at].end];
    let declarations = raw.declarations(&flat.text);
    let own = declarations.iter().position(
        |declaration| matches!(&declaration.item, Item::Block(found) if found.name.text == &*block.name),
    );
    let own = own.ok_or_else(|| format!("its declaration of `{}` is not found", block.name))?;
    let own_storage = match block.space {
        AddressSpace::Storage => Storage::Buffer,
        _ => Storage::Uniform,
    };
    // Each declaration that is kept may need earlier ones.
    let mut needed: FxHashSet<&str> = FxHashSet::default();
    let mut kept: Vec<Vec<usize>> = Vec::new();
    for (nth, declaration) in declarations[..=own].iter().enumerate().rev() {
        let tokens = match &declaration.item {
            Item::Block(_) if nth == own => declaration.tokens.clone(),
            // `layout(std140) uniform;` applies to the blocks after it.
            Item::Defaults(qualifiers) if qualifiers.storage == own_storage => {
                kept.push(declaration.tokens.clone());
                continue;
            }
            Item::Variables(variables) => {
                let structure = match &variables.ty.base {
                    TypeBase::Struct(structure) => Some(structure),
                    TypeBase::Name(_) => None,
                };
                let constant = variables.qualifiers.storage == Storage::Const;
                let mut names = variables.names.iter().map(|name| name.name.text);
                match structure {
                    _ if constant && names.any(|name| needed.contains(name)) => {
                        declaration.tokens.clone()
                    }
                    // Without variables of its type.
                    Some(structure) if needed.contains(structure.name.text) => {
                        // The last token is the `;`.
                        let last = declaration.tokens.last().copied();
                        code[structure.tokens.clone()].iter().copied().chain(last).collect()
                    }
                    _ => continue,
                }
            }
            _ => continue,
        };
        needed.extend(tokens.iter().map(word));
        kept.push(tokens);
    }
    let words = |tokens: &Vec<usize>| tokens.iter().map(|at| word(at).to_string()).collect();
    Ok(kept.iter().rev().map(words).collect())
}

/// Returns a program that declares the block: the user's own text if it is GLSL ES 3.00, otherwise
/// the declaration alone.
pub(super) fn whole(
    source: &Source,
    options: &ReadOptions,
    block: &BlockLayout,
    stage: Stage,
) -> Vec<(Stage, String)> {
    let head = glsl::Head::from_text(&source.text);
    let vertex = stage == Stage::Vertex;
    if head.es && head.version == 300 {
        let own = (stage, opened(source, options).text.to_string());
        // In the order of the pipeline.
        return match vertex {
            true => {
                let fragment = partner::fragment(source, options);
                vec![own, (Stage::Fragment, fragment.text.to_string())]
            }
            false => vec![(Stage::Vertex, partner::vertex(source, options)), own],
        };
    }
    let Ok(mut text) = text(source, options, block) else { return Vec::new() };
    text.push_str("void main() {}\n");
    vec![(Stage::Vertex, pixels::COVERING.to_string()), (Stage::Fragment, text)]
}

#[cfg(test)]
mod tests {
    use landfall_layout::{Options, layout};

    use super::*;

    fn declared(text: &str, name: &str) -> Result<String, String> {
        let source = Source::new("a.frag", text);
        let shader = layout(&source, &Options::default());
        let block = shader.blocks.iter().find(|block| &*block.name == name).expect("the block");
        if let Some(reason) = refusal(&source, block) {
            return Err(reason);
        }
        super::text(&source, &ReadOptions::default(), block)
    }

    #[test]
    fn a_block_keeps_what_it_needs_and_nothing_else() {
        let text = "#version 450\n#define COUNT (N * 2)\nconst int N = 2;\nconst double D = 1.0lf;\n\
             layout(std140) uniform;\nstruct Unused { dvec2 a; };\n\
             struct Light { mediump vec3 color; float range; };\n\
             layout(location = 0) out vec4 c;\nuniform sampler1D t;\n\
             layout(set = 1, binding = 2) uniform Lights {\n#if 1\n    Light all[COUNT];\n#endif\n\
             layout(row_major) mat3 m; } u;\nlayout(binding = 3) uniform Other { vec4 o; };\n\
             void main() { c = vec4(D); }\n";
        let expected = format!(
            "{HEAD}const int N = 2 ;\nlayout ( std140 ) uniform ;\n\
             struct Light {{ vec3 color ; float range ; }} ;\n \
             uniform Lights {{ Light all [ ( N * 2 ) ] ; layout ( row_major ) mat3 m ; }} u ;\n"
        );
        assert_eq!(declared(text, "Lights"), Ok(expected));
    }

    #[test]
    fn what_webgl_lacks_is_named() {
        for (declaration, reason) in [
            ("layout(std430) buffer B { vec4 a; };", "WebGL 2 has no storage buffers"),
            ("layout(std140) uniform B { dvec2 a; };", "WebGL 2 has no type `dvec2`"),
            ("layout(std140) uniform B { float a[2][3]; };", "WebGL 2 has no arrays of arrays"),
            (
                "layout(std140) uniform B { layout(offset = 16) float a; };",
                "GLSL ES 3.00 has no `offset` in `layout(…)`",
            ),
        ] {
            let text = format!("#version 450\n{declaration}\nvoid main() {{}}\n");
            assert_eq!(declared(&text, "B"), Err(reason.to_string()));
        }
    }
}
