//! The walk along a path, one member, index or component at a time.

use std::sync::Arc;

use super::{Step, StepKind};
use crate::layout::byte::component_name;
use crate::layout::measure::{
    array_size, element_size, fixed, matrix_vector, own_size, reach, size_in_dimension, structure,
};
use crate::layout::path::{PathError, PathErrorKind};
use crate::layout::rules;
use crate::layout::rules::Rule;
use crate::layout::{BlockLayout, LARGEST_BLOCK, MemberLayout};
use crate::shape::{Rules, Scalar, Type};
use crate::source::Language;
use crate::text::edit_distance::nearest;

#[derive(Clone, Copy)]
enum WalkPosition<'a> {
    /// At the start of a block.
    Members(&'a [MemberLayout]),
    /// At a member with that many of its dimensions indexed.
    Member(&'a MemberLayout, usize),
    /// At a vector, or a column of a matrix.
    Vector(VectorComponents),
    Component(Scalar),
}

/// The components of a vector, or of a column of a matrix.
#[derive(Clone, Copy)]
struct VectorComponents {
    scalar: Scalar,
    count: u64,
    /// Distance between components in bytes.
    stride: u64,
}

impl VectorComponents {
    fn of_vector(scalar: Scalar, rows: u8) -> VectorComponents {
        VectorComponents { scalar, count: rows.into(), stride: scalar.width.into() }
    }
}

/// A walk from the start of a block.
pub(super) struct ExplainWalk<'a> {
    block: &'a BlockLayout,
    language: Language,
    /// The steps so far.
    pub steps: Vec<Step>,
    /// The path so far.
    pub path: String,
    /// Offset of the current position from the start of the block.
    pub at: u64,
    place: WalkPosition<'a>,
    /// Number of segments of the user's path resolved so far.
    pub resolved: usize,
}

impl<'a> ExplainWalk<'a> {
    /// Starts at the block, with `resolved` segments of the path spent on its name.
    pub fn new(block: &'a BlockLayout, language: Language, resolved: usize) -> ExplainWalk<'a> {
        let place = WalkPosition::Members(&block.members);
        ExplainWalk { block, language, steps: vec![], path: String::new(), at: 0, place, resolved }
    }

    fn fail<T>(&self, kind: PathErrorKind) -> Result<T, PathError> {
        Err(PathError { kind, resolved: self.resolved })
    }

    fn step(&mut self, text: &str, ty: String, adds: u64, kind: StepKind) {
        self.path.push_str(text);
        self.steps.push(Step { path: self.path.clone(), ty, base: self.at, adds, kind });
        self.at += adds;
        self.resolved += 1;
    }

    fn spelled(&self, ty: &Type) -> String {
        ty.spelled(self.language).to_string()
    }

    fn here(&self) -> String {
        self.steps.last().map(|step| step.ty.clone()).unwrap_or_default()
    }

    /// Steps to a member, or to a component by its letter.
    pub fn name(&mut self, name: &str) -> Result<(), PathError> {
        match self.place {
            WalkPosition::Members(members) => self.member(members, name),
            WalkPosition::Member(member, indexed) if indexed == member.dims.len() => {
                match member.ty.innermost() {
                    Type::Struct(_) => self.member(&member.members, name),
                    Type::Vector { scalar, rows } => {
                        self.component(name, VectorComponents::of_vector(*scalar, *rows))
                    }
                    _ => self.no_member(name),
                }
            }
            WalkPosition::Vector(components) => self.component(name, components),
            WalkPosition::Member(..) | WalkPosition::Component(_) => self.no_member(name),
        }
    }

    fn no_member(&self, name: &str) -> Result<(), PathError> {
        let (path, ty) = (self.path.clone(), self.here());
        self.fail(PathErrorKind::NotAStructure { path, ty, name: name.to_string() })
    }

    fn member(&mut self, members: &'a [MemberLayout], name: &str) -> Result<(), PathError> {
        let Some(i) = members.iter().position(|m| *m.name == *name) else {
            return match self.place {
                WalkPosition::Member(member, _) => self.fail(self.unknown_in(member, name)),
                _ => self.fail(unknown(self.block, name)),
            };
        };
        let member = &members[i];
        let (kind, offset) =
            (StepKind::of_member(members, i, self.block.rules), member.offset.unwrap_or(0));
        let text = if self.path.is_empty() { name.to_string() } else { format!(".{name}") };
        self.step(&text, self.spelled(&member.ty), offset, kind);
        self.place = WalkPosition::Member(member, 0);
        Ok(())
    }

    fn unknown_in(&self, member: &MemberLayout, name: &str) -> PathErrorKind {
        if let Type::Struct(s) = member.ty.innermost() {
            if s.opaque.iter().any(|o| **o == *name) {
                return PathErrorKind::Opaque { name: format!("{}.{name}", self.path) };
            }
        }
        let owner = format!("`{}`, a `{}`,", self.path, self.spelled(member.ty.innermost()));
        unknown_member(owner, name, &member.members)
    }

    /// Steps to an element, column or component by its index.
    pub fn index(&mut self, index: Option<u64>) -> Result<(), PathError> {
        let not_an_array = PathErrorKind::NotAnArray { path: self.path.clone(), ty: self.here() };
        match self.place {
            WalkPosition::Member(member, indexed) if indexed < member.dims.len() => {
                self.element(member, indexed, index)
            }
            WalkPosition::Member(member, _) => match (member.ty.innermost(), index) {
                (Type::Vector { scalar, rows }, Some(index)) => {
                    self.nth_component(index, None, VectorComponents::of_vector(*scalar, *rows))
                }
                (Type::Matrix { .. }, Some(index)) => self.column(member, index),
                _ => self.fail(not_an_array),
            },
            WalkPosition::Vector(components) => match index {
                Some(index) => self.nth_component(index, None, components),
                None => self.fail(not_an_array),
            },
            WalkPosition::Members(_) | WalkPosition::Component(_) => self.fail(not_an_array),
        }
    }

    fn in_range(&self, index: u64, len: u64, what: &'static str) -> Result<(), PathError> {
        if index < len {
            return Ok(());
        }
        self.fail(PathErrorKind::OutOfRange { path: self.path.clone(), index, len, what })
    }

    fn element(
        &mut self,
        member: &'a MemberLayout,
        indexed: usize,
        index: Option<u64>,
    ) -> Result<(), PathError> {
        let len = fixed(&member.dims[indexed]);
        if let (Some(index), Some(len)) = (index, len) {
            self.in_range(index, len, "elements")?;
        }
        let stride = member.strides[indexed];
        // The index of a runtime-sized array has no limit: a product past 2^62 could overflow in
        // the sums of later steps. What the message gives as length is what a block of 4 GiB holds.
        let Some(adds) = index.unwrap_or(0).checked_mul(stride).filter(|n| *n < 1 << 62) else {
            let (path, index) = (self.path.clone(), index.unwrap_or(0));
            let len = LARGEST_BLOCK / stride.max(1);
            return self.fail(PathErrorKind::OutOfRange { path, index, len, what: "elements" });
        };
        let below = element_of(array_at(member, indexed));
        let kind = StepKind::of_element(member, indexed, index, self.block.rules);
        let text = index.map_or_else(|| "[]".to_string(), |i| format!("[{i}]"));
        self.step(&text, self.spelled(below), adds, kind);
        self.place = WalkPosition::Member(member, indexed + 1);
        Ok(())
    }

    fn column(&mut self, member: &'a MemberLayout, index: u64) -> Result<(), PathError> {
        let Type::Matrix { scalar, columns, rows } = member.ty.innermost() else {
            return Ok(());
        };
        self.in_range(index, u64::from(*columns), "columns")?;
        let width = u64::from(scalar.width);
        let stride = member.matrix_stride.unwrap_or(0);
        // Row-major: components of one row are adjacent, those of a column one row apart.
        let (adds, apart) =
            if member.row_major { (index * width, stride) } else { (index * stride, width) };
        let kind = StepKind::of_column(member, index, width);
        let column = Type::Vector { scalar: *scalar, rows: *rows };
        self.step(&format!("[{index}]"), self.spelled(&column), adds, kind);
        let components =
            VectorComponents { scalar: *scalar, count: u64::from(*rows), stride: apart };
        self.place = WalkPosition::Vector(components);
        Ok(())
    }

    fn component(&mut self, name: &str, components: VectorComponents) -> Result<(), PathError> {
        // GLSL 4.60 §5.5: three sets of letters for the same components. A swizzle of several
        // letters has no single offset and is no step.
        let index = ["xyzw", "rgba", "stpq"].iter().find_map(|set| {
            let mut letters = name.chars();
            match (letters.next(), letters.next()) {
                (Some(letter), None) => set.find(letter),
                _ => None,
            }
        });
        match index {
            Some(index) if (index as u64) < components.count => {
                self.nth_component(index as u64, Some(name), components)
            }
            _ => self.no_member(name),
        }
    }

    fn nth_component(
        &mut self,
        index: u64,
        name: Option<&str>,
        VectorComponents { scalar, count, stride }: VectorComponents,
    ) -> Result<(), PathError> {
        self.in_range(index, count, "components")?;
        let text = format!(".{}", name.unwrap_or(component_name(index)));
        let ty = self.spelled(&Type::Scalar(scalar));
        self.step(&text, ty, index * stride, StepKind::Component { index, stride });
        self.place = WalkPosition::Component(scalar);
        Ok(())
    }

    /// Returns the size in bytes of the current position; `None` if runtime-sized.
    pub fn size(&self) -> Option<u64> {
        match self.place {
            WalkPosition::Members(_) => self.block.size,
            WalkPosition::Member(member, 0) => member.size,
            WalkPosition::Member(member, indexed) if indexed < member.dims.len() => {
                array_size(member, indexed, self.block.rules)
            }
            WalkPosition::Member(member, _) => Some(element_size(member, self.block.rules)),
            WalkPosition::Vector(VectorComponents { scalar, count, stride }) => {
                // From the first byte of the first component to the last one of the last. Between
                // the components of a column of a row-major matrix lie those of other columns.
                Some((count - 1) * stride + u64::from(scalar.width))
            }
            WalkPosition::Component(scalar) => Some(scalar.width.into()),
        }
    }
}

impl StepKind {
    /// The reason for the offset of the member at an index of a block or structure; not for loose
    /// uniforms, which have no offsets.
    #[must_use]
    pub fn of_member(members: &[MemberLayout], index: usize, rules: Rules) -> StepKind {
        let member = &members[index];
        let previous = index.checked_sub(1).map(|i| &members[i]);
        let previous_end = match previous.and_then(|m| Some((m.offset?, m.size?))) {
            Some((offset, size)) => offset + size,
            // After a runtime-sized member: the furthest end so far.
            None => structure(&members[..index], rules).data_size,
        };
        let offset = member.offset.unwrap_or(0);
        let align = member.align.unwrap_or(1);
        let own = own_size(member, rules);
        StepKind::Member {
            rule: rule_of(&member.ty, rules, member),
            own_align: own_align(member, rules),
            align,
            after: previous.map(|m| m.name.clone()),
            previous_end,
            // The rules place a member at the next multiple of its alignment; any other place was
            // written.
            written: offset != previous_end.next_multiple_of(align),
            size: member.size,
            own_size: (reach(member) > own).then_some(own),
        }
    }

    /// The reason for the stride of a dimension of an array member; `index` as in
    /// [`StepKind::Element`].
    #[must_use]
    pub fn of_element(
        member: &MemberLayout,
        dim: usize,
        index: Option<u64>,
        rules: Rules,
    ) -> StepKind {
        StepKind::Element {
            index,
            len: fixed(&member.dims[dim]),
            stride: member.strides[dim],
            element_size: unrounded_element(member, dim, rules),
            align: own_align(member, rules),
            rule: rule_of(array_at(member, dim), rules, member),
        }
    }

    /// The reason for the place of a column of a matrix member whose components have `width` bytes.
    #[must_use]
    pub fn of_column(member: &MemberLayout, index: u64, width: u64) -> StepKind {
        let stride = member.matrix_stride.unwrap_or(0);
        if member.row_major {
            return StepKind::ColumnAcrossRows { index, width, stride };
        }
        let column_size = matrix_vector(member).map_or(0, |vector| vector.bytes);
        StepKind::Column { index, stride, column_size }
    }
}

/// The type of a member below its first `dim` dimensions.
fn array_at(member: &MemberLayout, dim: usize) -> &Type {
    (0..dim).fold(&member.ty, |ty, _| element_of(ty))
}

fn element_of(ty: &Type) -> &Type {
    match ty {
        Type::Array { element, .. } => element,
        plain => plain,
    }
}

/// Returns the rule that lays out a type as declared in `member`.
fn rule_of(ty: &Type, rules: Rules, member: &MemberLayout) -> Rule {
    rules::type_layout(ty, rules, member.matrix_layout())
        .map_or(Rule::Structure, |type_layout| type_layout.rule)
}

/// Returns the alignment of a member's type, ignoring `align = N` or `@align(N)` on the member.
fn own_align(member: &MemberLayout, rules: Rules) -> u64 {
    // Rule 4: std140 aligns every array as a `vec4`, 16 bytes, whatever its elements.
    let array = match rules {
        Rules::Std140 if !member.dims.is_empty() => 16,
        Rules::Std140 | Rules::Std430 | Rules::Scalar | Rules::Wgsl | Rules::Explicit(_) => 1,
    };
    let ty = member.ty.innermost();
    let own = match ty {
        Type::Struct(_) => structure(&member.members, rules).align,
        _ => rules::type_layout(ty, rules, member.matrix_layout())
            .map_or(1, |type_layout| type_layout.align.bytes()),
    };
    own.max(array)
}

/// Returns the bytes of an element of a dimension before rounding up to the stride.
fn unrounded_element(member: &MemberLayout, dim: usize, rules: Rules) -> u64 {
    match member.ty.innermost() {
        Type::Struct(_) if dim + 1 == member.strides.len() => {
            structure(&member.members, rules).data_size
        }
        _ => size_in_dimension(member, dim, rules),
    }
}

/// Returns the error for a member name that the block does not have.
pub(super) fn unknown(block: &BlockLayout, name: &str) -> PathErrorKind {
    if block.opaque.iter().any(|o| **o == *name) {
        return PathErrorKind::Opaque { name: name.to_string() };
    }
    unknown_member(format!("block `{}`", block.name), name, &block.members)
}

fn unknown_member(owner: String, name: &str, members: &[MemberLayout]) -> PathErrorKind {
    PathErrorKind::UnknownMember {
        owner,
        name: name.to_string(),
        nearest: nearest(name, members.iter().map(|m| &*m.name)).map(Arc::from),
        members: members.iter().map(|m| m.name.clone()).collect(),
    }
}
