//! CSV (RFC 4180, except that lines end in LF only): one row per leaf.

use std::fmt::{Display, Write as _};

use super::{EmitOptions, expand};
use crate::ShaderLayout;
use crate::layout::measure::{element_size, fixed};
use crate::layout::{BlockLayout, Leaf, targets};
use crate::shape::AddressSpace;
use crate::text::escape::name;

pub(super) const HEADER: &str = "shader,block,instance,address_space,rules,rules_declared,group,\
binding,block_size,path,type,offset,size,dims,strides,matrix_stride,row_major,naga_offset,\
assumed_target\n";

pub(super) fn shader(shader: &ShaderLayout, options: &EmitOptions) -> String {
    let mut text = String::new();
    for block in &shader.blocks {
        let start = block_cells(shader, block);
        if options.expand && expand::can_expand(block) {
            expand::for_each(block, |element| {
                let member = element.member;
                text.push_str(&start);
                cell(&mut text, element.path);
                cell(&mut text, member.ty.innermost().spelled(shader.language));
                cell(&mut text, element.offset);
                cell(&mut text, element_size(member, block.rules));
                // Patterns have dimensions and strides, elements have indices in their paths.
                text.push_str(",,");
                optional(&mut text, member.matrix_stride);
                optional(&mut text, member.matrix_stride.map(|_| member.row_major));
                text.push(',');
                end_of_row(&mut text, shader);
            });
        } else {
            for leaf in &block.leaves {
                text.push_str(&start);
                leaf_cells(&mut text, leaf, shader);
            }
        }
    }
    text
}

/// The leading cells of all rows of a block.
fn block_cells(shader: &ShaderLayout, block: &BlockLayout) -> String {
    let mut text = quoted(name(&shader.title()).into_owned());
    cell(&mut text, &block.name);
    optional(&mut text, block.instance.as_ref());
    cell(&mut text, block.space.name());
    let placed = block.space != AddressSpace::Default;
    optional(&mut text, placed.then(|| block.rules.name()));
    cell(&mut text, block.rules_declared);
    optional(&mut text, block.group);
    optional(&mut text, block.binding);
    optional(&mut text, block.size);
    text
}

fn leaf_cells(text: &mut String, leaf: &Leaf, shader: &ShaderLayout) {
    cell(text, &leaf.path);
    cell(text, leaf.ty.spelled(shader.language));
    optional(text, leaf.offset);
    optional(text, leaf.size);
    // `?` is a length that the shader does not specify.
    several(text, leaf.dims.iter().map(fixed));
    several(text, leaf.strides.iter().copied().map(Some));
    optional(text, leaf.matrix_stride);
    optional(text, leaf.matrix_stride.map(|_| leaf.row_major));
    optional(text, leaf.naga.as_ref().map(|naga| naga.offset));
    end_of_row(text, shader);
}

fn end_of_row(text: &mut String, shader: &ShaderLayout) {
    optional(text, shader.assumed_target.map(targets::key));
    text.push('\n');
}

/// Appends a comma and a cell.
fn cell(text: &mut String, value: impl Display) {
    text.push(',');
    let start = text.len();
    let _ = write!(text, "{value}");
    if text[start..].contains(SPECIAL) {
        let field = text.split_off(start);
        text.push_str(&quoted(field));
    }
}

fn optional(text: &mut String, value: Option<impl Display>) {
    match value {
        Some(value) => cell(text, value),
        None => text.push(','),
    }
}

/// Appends a cell of numbers separated by spaces.
fn several(text: &mut String, values: impl Iterator<Item = Option<u64>>) {
    text.push(',');
    for (i, value) in values.enumerate() {
        if i > 0 {
            text.push(' ');
        }
        let _ = match value {
            Some(value) => write!(text, "{value}"),
            None => write!(text, "?"),
        };
    }
}

/// Characters that a field must be quoted for.
const SPECIAL: [char; 4] = [',', '"', '\n', '\r'];

/// Quotes a field that holds a comma, quote or line break, doubling its quotes (RFC 4180 §2.6 and
/// §2.7).
pub fn quoted(field: String) -> String {
    if field.contains(SPECIAL) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples;
    use crate::format::{Format, document};
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
             data[].color,vec3,16,12,128,48,,,,"
        );
        assert!(rows.iter().all(|row| row.split(',').count() == 19));
    }

    #[test]
    fn fields_are_quoted_where_they_must_be() {
        assert_eq!(quoted("array<f32, 4>".into()), "\"array<f32, 4>\"");
        assert_eq!(quoted("say \"hi\"".into()), "\"say \"\"hi\"\"\"");
        assert_eq!(quoted("plain".into()), "plain");
    }
}
