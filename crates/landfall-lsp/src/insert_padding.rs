//! Declares the padding behind a member as members of their own, which moves nothing.

use std::ops::Range;

use landfall_layout::Language;

use crate::declarations::{DeclarationKind, PlacedDeclaration};
use crate::hints::end_of_declarator;
use crate::words::words;

/// Most words of padding that are declared: more are an alignment that somebody meant.
const LIMIT: u64 = 16;

/// The place and text to insert behind a member; `None` where no floats fill its padding, under each rules
/// that it is laid out by.
pub fn padding_members(
    declaration: &PlacedDeclaration,
    text: &str,
    language: Language,
) -> Option<(Range<u32>, String)> {
    let [placement] = declaration.distinct()[..] else { return None };
    let bytes = &placement.bytes;
    let end = bytes.offset + bytes.size?;
    let count = bytes.after / 4;
    let is_of_words = bytes.after % 4 == 0 && end % 4 == 0 && (1..=LIMIT).contains(&count);
    if declaration.kind != DeclarationKind::Member || !is_of_words {
        return None;
    }
    let behind = end_of_declarator(text, declaration.span.end) as usize;
    let line = text[..declaration.span.start as usize].rfind('\n').map_or(0, |end| end + 1);
    let indent: String = text[line..].chars().take_while(|c| matches!(c, ' ' | '\t')).collect();
    let names = (0..count).map(|number| format!("_pad_{}_{number}", declaration.name));
    let names: Vec<String> = names.collect();
    if words(text).iter().any(|word| names.iter().any(|name| name == word.text)) {
        return None;
    }
    let ends_with = |c: char| text[behind..].trim_start().starts_with(c);
    let each = |declare: &dyn Fn(&String) -> String| -> String {
        names.iter().map(|name| format!("\n{indent}{}", declare(name))).collect()
    };
    let (at, new) = match language {
        Language::Wgsl if ends_with(',') => {
            let comma = behind + text[behind..].find(',')? + 1;
            (comma, each(&|name| format!("{name}: f32,")))
        }
        Language::Wgsl => (behind, format!(",{}", each(&|name| format!("{name}: f32,")))),
        Language::Glsl if ends_with(';') => {
            let semicolon = behind + text[behind..].find(';')? + 1;
            (semicolon, each(&|name| format!("float {name};")))
        }
        Language::Glsl | Language::SpirV => return None,
    };
    Some((at as u32..at as u32, new))
}

#[cfg(test)]
mod tests {
    use landfall_layout::{Options, ShaderLayout, Source, layout};

    use super::*;
    use crate::declarations::declarations;

    fn laid_out(path: &str, text: &str) -> ShaderLayout {
        let shader = layout(&Source::new(path, text), &Options::default());
        assert!(!shader.has_errors(), "{:?}", shader.diagnostics);
        shader
    }

    /// The text with all padding declared, and how often some was.
    fn filled(path: &str, text: &str) -> (String, usize) {
        let (mut text, mut count) = (text.to_string(), 0);
        loop {
            let shader = laid_out(path, &text);
            let all = declarations(&shader);
            let next = all.iter().find_map(|one| padding_members(one, &text, shader.language));
            let Some((at, new)) = next else { return (text, count) };
            text.insert_str(at.start as usize, &new);
            count += 1;
        }
    }

    #[test]
    fn members_that_fill_padding_move_nothing() {
        let glsl = "#version 450\nstruct Light {\n    vec3 pos;\n    vec3 color; // tint\n};\n\
            layout(std140) uniform B {\n    Light all[4];\n    vec2 at;\n    mat4 view;\n    float f, g;\n} b;\n\
            void main() {}\n";
        let wgsl = "struct Light { pos: vec3f, color: vec3f }\n\
            struct B {\n  sun: Light,\n  power: f32\n}\n@group(0) @binding(0) var<uniform> b: B;\n";
        for (path, text, expected) in [("a.frag", glsl, 4), ("a.wgsl", wgsl, 3)] {
            let (new, count) = filled(path, text);
            assert_eq!(count, expected, "{new}");
            let (before, after) = (laid_out(path, text), laid_out(path, &new));
            let leaves = |shader: &ShaderLayout| -> Vec<(String, Option<u64>)> {
                let all = shader.blocks.iter().flat_map(|block| &block.leaves);
                let ours = all.filter(|leaf| !leaf.path.contains("_pad_"));
                ours.map(|leaf| (leaf.path.clone(), leaf.offset)).collect()
            };
            assert_eq!(leaves(&before), leaves(&after), "{new}");
            assert_eq!(before.blocks[0].size, after.blocks[0].size);
        }
    }
}
