//! CSV (RFC 4180, lines end in a newline alone): one row a leaf.

use super::{EmitOptions, expand};
use crate::ShaderLayout;
use crate::layout::measure::{element_size, fixed};
use crate::layout::{BlockLayout, Leaf, MemberLayout};
use crate::shape::{AddressSpace, ArrayLen};

pub(super) const HEADER: &str = "shader,block,instance,address_space,rules,rules_declared,group,\
binding,block_size,path,type,offset,size,dims,strides,matrix_stride,row_major,naga_offset\n";

pub(super) fn shader(shader: &ShaderLayout, options: &EmitOptions) -> String {
    let mut text = String::new();
    for block in &shader.blocks {
        let start = block_cells(shader, block);
        let mut row = |cells: [String; 9]| {
            let all = start.iter().chain(&cells);
            text.push_str(&all.map(|cell| quoted(cell)).collect::<Vec<_>>().join(","));
            text.push('\n');
        };
        if options.expand && expand::can_expand(block) {
            expand::for_each(block, |element| {
                let ty = element.member.ty.innermost().spelled(shader.language).to_string();
                let size = element_size(element.member, block.rules);
                row(element_cells(element.path, ty, element.offset, size, element.member));
            });
        } else {
            block.leaves.iter().for_each(|leaf| {
                row(leaf_cells(leaf, leaf.ty.spelled(shader.language).to_string()));
            });
        }
    }
    text
}

/// What all rows of a block begin with.
fn block_cells(shader: &ShaderLayout, block: &BlockLayout) -> [String; 9] {
    let loose = block.space == AddressSpace::Default;
    [
        shader.path.clone(),
        block.name.to_string(),
        block.instance.as_deref().unwrap_or("").to_string(),
        block.space.name().to_string(),
        if loose { String::new() } else { block.rules.name().to_string() },
        block.rules_declared.to_string(),
        optional(block.group),
        optional(block.binding),
        optional(block.size),
    ]
}

fn leaf_cells(leaf: &Leaf, ty: String) -> [String; 9] {
    let dims = leaf.dims.iter().map(length).collect::<Vec<_>>().join(" ");
    [
        leaf.path.clone(),
        ty,
        optional(leaf.offset),
        optional(leaf.size),
        dims,
        super::words::spaced(&leaf.strides),
        optional(leaf.matrix_stride),
        leaf.matrix_stride.map(|_| leaf.row_major.to_string()).unwrap_or_default(),
        optional(leaf.naga.as_ref().map(|naga| naga.offset)),
    ]
}

fn element_cells(
    path: &str,
    ty: String,
    offset: u64,
    size: u64,
    member: &MemberLayout,
) -> [String; 9] {
    [
        path.to_string(),
        ty,
        offset.to_string(),
        size.to_string(),
        String::new(),
        String::new(),
        optional(member.matrix_stride),
        member.matrix_stride.map(|_| member.row_major.to_string()).unwrap_or_default(),
        String::new(),
    ]
}

/// `?` stands for a length the text does not say.
fn length(len: &ArrayLen) -> String {
    fixed(len).map_or_else(|| "?".to_string(), |n| n.to_string())
}

fn optional(n: Option<impl ToString>) -> String {
    n.map(|n| n.to_string()).unwrap_or_default()
}

/// RFC 4180 §2.6 and 2.7: a field with a comma, quote or line break stands in quotes, its quotes
/// doubled.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emit::{Format, document};
    use crate::layout::examples;
    use crate::source::Language;

    #[test]
    fn one_row_a_leaf_with_the_block_before_it() {
        let shader = examples::shader("a.frag", Language::Glsl, vec![examples::point_lights()]);
        let text = document(&shader, &EmitOptions::new(Format::Csv));
        let rows: Vec<&str> = text.lines().collect();
        assert_eq!(rows.len(), 1 + 7);
        assert_eq!(
            rows[2],
            "a.frag,PointLightBlock,u_point_light_array,uniform,std140,true,,,6160,\
             data[].color,vec3,16,12,128,48,,,"
        );
        assert!(rows.iter().all(|row| row.split(',').count() == 18));
    }

    #[test]
    fn fields_are_quoted_where_they_must_be() {
        assert_eq!(quoted("array<f32, 4>"), "\"array<f32, 4>\"");
        assert_eq!(quoted("say \"hi\""), "\"say \"\"hi\"\"\"");
        assert_eq!(quoted("plain"), "plain");
    }
}
