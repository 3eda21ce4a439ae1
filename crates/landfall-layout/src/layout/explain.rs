//! Explanations of offsets: the rules, alignments and strides that place a path such as
//! `data[3].color`.
//!
//! Reads the [model](super), [`rules`](super::rules) and [`path`](super::path),
//! feeds [`format`](mod@crate::format).

mod walk;

use std::sync::Arc;

use super::BlockLayout;
use super::path::{PathError, PathErrorKind, Segment, segments};
use super::rules::Rule;
use crate::shape::AddressSpace;
use crate::source::Language;
use walk::{ExplainWalk, unknown};

/// The explanation of one path.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Explanation {
    /// The canonical path, without the block's name.
    pub path: String,
    /// The type in the shader's spelling.
    pub ty: String,
    /// One step for each member, index or component of the path.
    pub steps: Vec<Step>,
    /// Offset from the start of the block; that of the first element where the path has `[]`.
    pub offset: u64,
    /// Size in bytes; `None` if runtime-sized.
    pub size: Option<u64>,
}

/// A member, index or component of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Step {
    /// The path up to and including this step.
    pub path: String,
    /// The type in the shader's spelling.
    pub ty: String,
    /// Offset from the start of the block before this step.
    pub base: u64,
    /// Bytes this step adds to `base`.
    pub adds: u64,
    /// The reason for `adds`.
    pub kind: StepKind,
}

/// The reason a step adds its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StepKind {
    /// A member of a block or structure.
    Member {
        /// The rule that determines the alignment.
        rule: Rule,
        /// The alignment of the type by that rule.
        own_align: u64,
        /// The alignment in effect, which `align = N` or `@align(N)` may raise.
        align: u64,
        /// The preceding member; `None` for the first.
        after: Option<Arc<str>>,
        /// End of the preceding member, from the start of the block or structure.
        previous_end: u64,
        /// Whether `offset = N` places the member elsewhere than at the next multiple of its
        /// alignment.
        written: bool,
        /// Size in bytes; `None` if runtime-sized.
        size: Option<u64>,
        /// Size of the type in bytes, where `@size(N)` raises it.
        own_size: Option<u64>,
    },
    /// An element of an array.
    Element {
        /// The index; `None` for every element.
        index: Option<u64>,
        /// Number of elements; `None` if runtime-sized.
        len: Option<u64>,
        /// Distance between elements in bytes.
        stride: u64,
        /// Size of an element in bytes, before rounding up to the stride.
        element_size: u64,
        /// The alignment the size is rounded up to.
        align: u64,
        /// The rule that determines the stride.
        rule: Rule,
    },
    /// A column of a column-major matrix.
    Column {
        /// The index.
        index: u64,
        /// Distance between columns in bytes.
        stride: u64,
        /// Bytes of a column that hold components.
        column_size: u64,
    },
    /// A column of a row-major matrix, whose components are one row apart.
    ColumnAcrossRows {
        /// The index.
        index: u64,
        /// Size of a component in bytes.
        width: u64,
        /// Distance between components in bytes.
        stride: u64,
    },
    /// A component of a vector or column.
    Component {
        /// The index.
        index: u64,
        /// Distance between components in bytes.
        stride: u64,
    },
}

/// Explains the offset of a path in a block. The path may begin with the block's or instance's
/// name.
///
/// # Errors
/// The path is malformed or does not exist in the block, or the block holds loose uniforms.
pub fn explain(
    block: &BlockLayout,
    path: &str,
    language: Language,
) -> Result<Explanation, PathError> {
    let all = segments(path)?;
    let segments = without_block_name(block, &all);
    let Some((Segment::Name(first), rest)) = segments.split_first() else {
        return Err(PathError { kind: unknown(block, path), resolved: 0 });
    };
    let mut walk = ExplainWalk::new(block, language, all.len() - segments.len());
    walk.name(first)?;
    // Only after the first name, so that an unknown member is reported as such.
    if block.space == AddressSpace::Default {
        let kind = PathErrorKind::Loose { path: path.to_string() };
        return Err(PathError { kind, resolved: walk.resolved });
    }
    for segment in rest {
        match segment {
            Segment::Name(name) => walk.name(name)?,
            Segment::Index(index) => walk.index(*index)?,
        }
    }
    let size = walk.size();
    let ty = walk.steps.last().map(|step| step.ty.clone()).unwrap_or_default();
    Ok(Explanation { path: walk.path, ty, steps: walk.steps, offset: walk.at, size })
}

/// Strips the block or instance name: `u_lights.data[3]` and `LightBlock.data[3]` mean `data[3]`,
/// unless a member has that name.
fn without_block_name<'a>(block: &BlockLayout, segments: &'a [Segment]) -> &'a [Segment] {
    let Some(Segment::Name(first)) = segments.first() else { return segments };
    let is_member = block.members.iter().any(|m| *m.name == **first);
    let is_block = *block.name == **first || block.instance.as_deref() == Some(first.as_str());
    if is_member || !is_block {
        return segments;
    }
    // An array of blocks: each element is a separate buffer, so its index adds no bytes.
    let names = segments[1..].iter().take(block.count.len());
    let indices = names.take_while(|s| matches!(s, Segment::Index(_))).count();
    &segments[1 + indices..]
}

#[cfg(test)]
mod tests {
    use super::super::byte::{ByteOwner, owner_of_byte};
    use super::*;
    use crate::examples::*;
    use crate::shape::Rules;

    fn at(block: &BlockLayout, path: &str) -> (u64, Option<u64>) {
        let found = explain(block, path, Language::Glsl).expect(path);
        let sum: u64 = found.steps.iter().map(|step| step.adds).sum();
        assert_eq!(sum, found.offset, "{path}: the steps add up");
        (found.offset, found.size)
    }

    fn fault(block: &BlockLayout, path: &str) -> PathErrorKind {
        explain(block, path, Language::Glsl).expect_err(path).kind
    }

    #[test]
    fn the_color_of_the_fourth_light_is_at_160() {
        let block = point_lights();
        let found = explain(&block, "data[3].color", Language::Glsl).unwrap();
        assert_eq!((found.offset, found.size, found.ty.as_str()), (160, Some(12), "vec3"));
        match &found.steps[1].kind {
            StepKind::Element { index, len, stride, element_size, align, .. } => {
                assert_eq!((*index, *len), (Some(3), Some(128)));
                assert_eq!((*stride, *element_size, *align), (48, 44, 16));
            }
            other => panic!("{other:?}"),
        }
        match &found.steps[2].kind {
            StepKind::Member { rule, align, after, previous_end, written, .. } => {
                assert_eq!((*rule, *align, *previous_end), (Rule::Vector3, 16, 12));
                assert_eq!((after.as_deref(), *written), (Some("pos"), false));
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn parts_of_a_path_have_places_too() {
        let block = point_lights();
        assert_eq!(at(&block, "data"), (0, Some(6144)));
        assert_eq!(at(&block, "data[3]"), (144, Some(48)));
        assert_eq!(at(&block, "data[3].color.y"), (164, Some(4)));
        assert_eq!(at(&block, "data[3].color[2]"), (168, Some(4)));
        assert_eq!(at(&block, "data[].color"), (16, Some(12)));
        assert_eq!(at(&block, "u_point_light_array.actually_used_count"), (6144, Some(4)));
        assert_eq!(at(&block, "PointLightBlock.data[127]"), (6096, Some(48)));
        assert_eq!(at(&particles(), "particles"), (16, None));
        assert_eq!(at(&particles(), "particles[9].age"), (16 + 9 * 16 + 12, Some(4)));
    }

    #[test]
    fn columns_and_their_components_are_steps() {
        let block = padded(Rules::Std140);
        assert_eq!(at(&block, "o[1][2].m"), (144 + 5 * 96 + 32, Some(48)));
        assert_eq!(at(&block, "o[1][2].m[1]"), (144 + 5 * 96 + 48, Some(12)));
        assert_eq!(at(&block, "o[1][2].m[1].z"), (144 + 5 * 96 + 56, Some(4)));
        assert_eq!(at(&block, "o[1]"), (144 + 288, Some(288)));
        // Row-major: the components of a column are a row apart.
        assert_eq!(at(&block, "r[1][1]"), (720 + 48 + 4, Some(36)));
        assert_eq!(at(&block, "r[1][1].y"), (720 + 48 + 4 + 16, Some(4)));
    }

    #[test]
    fn explain_and_the_owner_of_a_byte_agree() {
        for rules in [Rules::Std140, Rules::Std430, Rules::Scalar, Rules::Wgsl] {
            for block in [padded(rules), doubles(rules), point_lights(), particles()] {
                for byte in 0..block.size.unwrap() {
                    if let ByteOwner::Component { path, offset, size, .. } =
                        owner_of_byte(&block, byte)
                    {
                        assert_eq!(at(&block, &path), (offset, Some(size)), "{path}");
                    }
                }
            }
        }
    }

    #[test]
    fn wrong_paths_say_what_is_wrong() {
        let block = point_lights();
        assert_eq!(
            fault(&block, "data[3].colour").to_string(),
            "`data[3]`, a `PointLight`, has no member `colour`"
        );
        assert_eq!(
            fault(&block, "data[3].colour").help().as_deref(),
            Some("there is a member `color`")
        );
        assert_eq!(
            fault(&block, "data[128].color").to_string(),
            "`data[128]` is out of range: `data` has 128 elements"
        );
        assert_eq!(
            fault(&block, "actually_used_count[0]").to_string(),
            "`actually_used_count` has type `int`, which cannot be indexed"
        );
        assert_eq!(
            fault(&block, "data.color").to_string(),
            "`data` has type `PointLight[128]`, which has no member or component `color`"
        );
        assert_eq!(
            fault(&block, "data[0].pos.w").to_string(),
            "`data[0].pos` has type `vec3`, which has no member or component `w`"
        );
        assert_eq!(fault(&loose(), "lights[2].position").code(), "loose-uniform");
        assert_eq!(fault(&loose(), "diffuse").code(), "opaque-member");
    }
}
