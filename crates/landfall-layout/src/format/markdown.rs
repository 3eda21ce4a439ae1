//! Markdown: a heading per shader and block, and a table of the leaves and padding.

use super::{EmitOptions, expand, phrases};
use crate::ShaderLayout;
use crate::layout::measure::element_size;
use crate::layout::{BlockLayout, Leaf, targets};
use crate::shape::{AddressSpace, Type};
use crate::source::Language;
use crate::text::escape::markdown_code as code;

pub(super) fn shader(shader: &ShaderLayout, options: &EmitOptions) -> String {
    let mut text = format!("# {}\n", code(&shader.title()));
    if let Some(note) = targets::note(shader.assumed_target) {
        text.push_str(&format!("\nNote: {note}.\n"));
    }
    if shader.blocks.is_empty() {
        text.push_str("\nNo blocks.\n");
    }
    for block in &shader.blocks {
        text.push_str(&heading(block, shader.language));
        if options.expand && expand::can_expand(block) {
            text.push_str("\n| offset | size | type | path |\n|--:|--:|---|---|\n");
            expand::for_each(block, |element| {
                text.push_str(&format!(
                    "| {} | {} | {} | {} |\n",
                    element.offset,
                    element_size(element.member, block.rules),
                    code(&phrases::type_name(&element.member.ty, shader.language)),
                    code(element.path),
                ));
            });
        } else if block.space == AddressSpace::Default {
            text.push_str("\n| type | path |\n|---|---|\n");
            for leaf in &block.leaves {
                let ty = leaf.ty.spelled(shader.language).to_string();
                text.push_str(&format!("| {} | {} |\n", code(&ty), code(&with_dims(leaf))));
            }
        } else {
            text.push_str("\n| offset | size | stride | type | path |\n|--:|--:|--:|---|---|\n");
            for leaf in &block.leaves {
                text.push_str(&leaf_row(leaf, shader.language));
            }
        }
        let summary = phrases::summary(block);
        if !summary.is_empty() {
            text.push_str(&format!("\n{summary}\n"));
        }
        if let Some(note) = phrases::reported_size(shader, block) {
            text.push_str(&format!("\nNote: {note}.\n"));
        }
        let opaque = phrases::opaque(block);
        if !opaque.is_empty() {
            let names: Vec<String> = opaque.iter().map(|path| code(path)).collect();
            text.push_str(&format!("\nOpaque, no bytes: {}\n", names.join(", ")));
        }
    }
    text
}

fn heading(block: &BlockLayout, language: Language) -> String {
    let mut text = format!("\n## {}\n", code(&phrases::block_name(block)));
    if block.space == AddressSpace::Default {
        text.push_str("\nSet one by one, no offsets.\n");
        return text;
    }
    text.push_str(&format!("\n{}", block.rules.name()));
    if !block.rules_declared {
        text.push_str(" (not declared: the driver's offsets may differ)");
    }
    let slot = phrases::slot(block, language);
    if !slot.is_empty() {
        text.push_str(&format!(", {slot}"));
    }
    if !block.count.is_empty() {
        text.push_str(&format!(", buffers {}", phrases::dims(&block.count)));
    }
    text.push('\n');
    text
}

fn leaf_row(leaf: &Leaf, language: Language) -> String {
    let mut strides = phrases::Spaced(&leaf.strides).to_string();
    if let (Type::Matrix { .. }, Some(stride)) = (&leaf.ty, leaf.matrix_stride) {
        let vectors = if leaf.row_major { "rows" } else { "columns" };
        let comma = if strides.is_empty() { "" } else { ", " };
        strides.push_str(&format!("{comma}{vectors} {stride}"));
    }
    let caution = phrases::naga(leaf).map(|naga| format!(" ({naga})")).unwrap_or_default();
    let number = |n: Option<u64>| n.map(|n| n.to_string()).unwrap_or_default();
    format!(
        "| {} | {} | {strides} | {} | {}{caution} |\n",
        number(leaf.offset),
        number(leaf.size),
        code(&leaf.ty.spelled(language).to_string()),
        code(&with_dims(leaf)),
    )
}

/// A path with its array lengths: `data[128].pos`.
fn with_dims(leaf: &Leaf) -> String {
    let mut dims = leaf.dims.iter();
    let mut parts = leaf.path.split("[]");
    let mut text = parts.next().unwrap_or("").to_string();
    for part in parts {
        text.push_str(&phrases::dims(&dims.next().cloned().into_iter().collect::<Vec<_>>()));
        text.push_str(part);
    }
    text
}

#[cfg(test)]
mod tests {
    use crate::examples::*;
    use crate::format::{EmitOptions, Format, document};
    use crate::shape::Rules;
    use crate::source::Language;

    #[test]
    fn a_block_is_a_table_of_its_leaves() {
        let shader = shader("a.frag", Language::Glsl, vec![padded(Rules::Std140), loose()]);
        let text = document(&shader, &EmitOptions::new(Format::Markdown));
        assert!(text.starts_with("# `a.frag`\n\n## `uniform B`\n\nstd140\n\n| offset |"), "{text}");
        assert!(
            text.contains("| 176 | 48 | 288 96, columns 16 | `mat3` | `o[2][3].m` |"),
            "{text}"
        );
        assert!(text.contains("| `vec3` | `lights[6].position` |"), "{text}");
        assert!(text.contains("Opaque, no bytes: `diffuse`"), "{text}");
    }
}
