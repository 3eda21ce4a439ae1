//! The name of a block's member in its mirror.
//!
//! Follows the naming of [`super::plan`]; used by [`format::diff`](landfall_layout::format::diff).

use super::names::{Scope, camel, snake};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::Type;

/// The field that mirrors a member: `PointLight::color` for `data[].color`, the mirror itself for
/// an empty path. `None` if it has no mirror.
///
/// Does not include the suffix that [`rust`](super::rust()) adds where two mirrors of one file
/// have the same name.
pub fn field(block: &BlockLayout, path: &str) -> Option<String> {
    block.size?;
    let mut owner = camel(&block.name);
    if path.is_empty() {
        return Some(owner);
    }
    let mut members = block.members.as_slice();
    let mut parts = path.split('.').peekable();
    // As the walk of the planner: each structure names the owner of what follows.
    while let Some(part) = parts.next() {
        let name = part.split('[').next().unwrap_or(part);
        let at = members.iter().position(|member| *member.name == *name)?;
        if parts.peek().is_none() {
            return Some(format!("{owner}::{}", field_names(members).swap_remove(at)));
        }
        let member = &members[at];
        let Type::Struct(s) = member.ty.innermost() else { return None };
        owner = camel(if s.name.is_empty() { &member.name } else { &s.name });
        members = &member.members;
    }
    None
}

fn field_names(members: &[MemberLayout]) -> Vec<String> {
    let mut names = Scope::default();
    members.iter().map(|member| names.take(&snake(&member.name))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rust::{RustOptions, rust};
    use landfall_layout::{Options, Source, layout};

    #[test]
    fn a_field_is_named_as_the_mirror_names_it() {
        let text = "struct PointLight { vec3 position; vec3 color; };
            layout(std140) uniform PointLightBlock { PointLight data[4]; };";
        let shader = layout(&Source::new("a.frag", text), &Options::default());
        let block = &shader.blocks[0];
        assert_eq!(field(block, "data[].color").as_deref(), Some("PointLight::color"));
        assert_eq!(field(block, "data[]").as_deref(), Some("PointLightBlock::data"));
        assert_eq!(field(block, "").as_deref(), Some("PointLightBlock"));
        assert_eq!(field(block, "data[].gone"), None);
        let text = rust(&[&shader], &RustOptions::default()).text;
        for written in ["pub struct PointLight {", "pub struct PointLightBlock {", "pub color:"] {
            assert!(text.contains(written), "{written}\n{text}");
        }
    }
}
