//! Why a path such as `data[3].color` lands where it does: the chain of rules,
//! round-ups and strides from the start of the block.
//!
//! Reads the [model](super), [`rules`](super::rules) and [`path`](super::path),
//! feeds [`emit`](crate::emit).

use std::sync::Arc;

use super::byte::component_name;
use super::padding::{array_size, element_size, fixed, matrix_vector, own_size, reach, structure};
use super::path::{PathError, PathErrorKind, Segment, segments};
use super::rules::{self, Rule};
use super::{BlockLayout, MemberLayout};
use crate::parse::nearest;
use crate::shape::{AddressSpace, ArrayLen, Majorness, Rules, Scalar, Type};
use crate::source::Language;

/// The way to one path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// The path without the block's name, one spelling for each place.
    pub path: String,
    /// The type there, in the shader's spelling.
    pub ty: String,
    /// One step for each member, index or component on the way.
    pub steps: Vec<Step>,
    /// First byte, from the start of the block; of the first element where the path has `[]`.
    pub offset: u64,
    /// Bytes from the first to the last; `None` when runtime-sized.
    pub size: Option<u64>,
}

/// One member, index or component.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// The path up to and with this step.
    pub path: String,
    /// The type there, in the shader's spelling.
    pub ty: String,
    /// Offset from the start of the block before this step.
    pub base: u64,
    /// What the step adds to it: to be read as `base + adds`.
    pub adds: u64,
    /// Why it adds that.
    pub kind: StepKind,
}

/// Why a step adds what it adds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// A member of a block or structure.
    Member {
        /// The rule that gives its alignment.
        rule: Rule,
        /// The alignment its type has by the rule.
        own_align: u64,
        /// The alignment in force: `align = N` or `@align(N)` may raise it.
        align: u64,
        /// The member before it; `None` for the first.
        after: Option<Arc<str>>,
        /// Where that one ends, in the block or structure.
        previous_end: u64,
        /// Whether `offset = N` puts it elsewhere than the next multiple of its alignment.
        written: bool,
        /// Bytes it occupies; `None` when runtime-sized.
        size: Option<u64>,
        /// Bytes its type takes by itself, when `@size(N)` raises them.
        own_size: Option<u64>,
    },
    /// An element of an array.
    Element {
        /// Which; `None` for every.
        index: Option<u64>,
        /// Number of elements; `None` when runtime-sized.
        len: Option<u64>,
        /// From one element to the next.
        stride: u64,
        /// Bytes of an element, before rounding up to the stride.
        element_size: u64,
        /// What the size is rounded up to.
        align: u64,
        /// The rule that gives the stride.
        rule: Rule,
    },
    /// A column of a matrix stored by columns.
    Column {
        /// Which.
        index: u64,
        /// From one column to the next.
        stride: u64,
        /// Bytes of a column that hold components.
        column_size: u64,
    },
    /// A column of a matrix stored by rows: its components lie a row apart.
    ColumnAcrossRows {
        /// Which.
        index: u64,
        /// Bytes of a component.
        width: u64,
        /// From one component to the next.
        stride: u64,
    },
    /// A component of a vector or column.
    Component {
        /// Which.
        index: u64,
        /// From one component to the next.
        stride: u64,
    },
}

/// Explains where a path lands in a block. The path may begin with the block's or instance's name.
///
/// # Errors
/// The path is malformed or leads nowhere in this block, or the block is loose uniforms.
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
    let mut walk = Walk {
        block,
        language,
        steps: Vec::new(),
        path: String::new(),
        at: 0,
        place: Place::Members(&block.members),
        resolved: all.len() - segments.len(),
    };
    walk.name(first)?;
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

/// `u_lights.data[3]` and `LightBlock.data[3]` mean `data[3]`, unless a member has that name.
fn without_block_name<'a>(block: &BlockLayout, segments: &'a [Segment]) -> &'a [Segment] {
    let Some(Segment::Name(first)) = segments.first() else { return segments };
    let is_member = block.members.iter().any(|m| *m.name == **first);
    let is_block = *block.name == **first || block.instance.as_deref() == Some(first.as_str());
    if is_member || !is_block {
        return segments;
    }
    // An array of blocks: each element is a buffer of its own, its index adds no bytes.
    let names = segments[1..].iter().take(block.count.len());
    let indices = names.take_while(|s| matches!(s, Segment::Index(_))).count();
    &segments[1 + indices..]
}

fn unknown(block: &BlockLayout, name: &str) -> PathErrorKind {
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

/// Where a walk stands.
#[derive(Clone, Copy)]
enum Place<'a> {
    /// At the start of a block.
    Members(&'a [MemberLayout]),
    /// At a member, that many of its dimensions indexed.
    Member(&'a MemberLayout, usize),
    /// At a vector, or a column of a matrix.
    Vector(Components),
    /// At a component.
    Component(Scalar),
}

/// The components of a vector, or of a column of a matrix.
#[derive(Clone, Copy)]
struct Components {
    scalar: Scalar,
    count: u64,
    /// From one to the next.
    stride: u64,
}

impl Components {
    fn of_vector(scalar: Scalar, rows: u8) -> Components {
        Components { scalar, count: rows.into(), stride: scalar.width.into() }
    }
}

struct Walk<'a> {
    block: &'a BlockLayout,
    language: Language,
    steps: Vec<Step>,
    path: String,
    at: u64,
    place: Place<'a>,
    resolved: usize,
}

impl<'a> Walk<'a> {
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

    fn name(&mut self, name: &str) -> Result<(), PathError> {
        match self.place {
            Place::Members(members) => self.member(members, name),
            Place::Member(member, indexed) if indexed == member.dims.len() => {
                match member.ty.innermost() {
                    Type::Struct(_) => self.member(&member.members, name),
                    Type::Vector { scalar, rows } => {
                        self.component(name, Components::of_vector(*scalar, *rows))
                    }
                    Type::Scalar(_)
                    | Type::Atomic(_)
                    | Type::Matrix { .. }
                    | Type::Address(_)
                    | Type::Array { .. } => self.no_member(name),
                }
            }
            Place::Vector(components) => self.component(name, components),
            Place::Member(..) | Place::Component(_) => self.no_member(name),
        }
    }

    fn no_member(&self, name: &str) -> Result<(), PathError> {
        let (path, ty) = (self.path.clone(), self.here());
        self.fail(PathErrorKind::NotAStructure { path, ty, name: name.to_string() })
    }

    fn member(&mut self, members: &'a [MemberLayout], name: &str) -> Result<(), PathError> {
        let Some(i) = members.iter().position(|m| *m.name == *name) else {
            return match self.place {
                Place::Member(member, _) => self.fail(self.unknown_in(member, name)),
                _ => self.fail(unknown(self.block, name)),
            };
        };
        let member = &members[i];
        let rules = self.block.rules;
        let previous = i.checked_sub(1).map(|i| &members[i]);
        let previous_end = match previous.and_then(|m| Some((m.offset?, m.size?))) {
            Some((offset, size)) => offset + size,
            // After a runtime-sized member, the furthest end so far.
            None => structure(&members[..i], rules).data_size,
        };
        let offset = member.offset.unwrap_or(0);
        let align = member.align.unwrap_or(1);
        let own = own_size(member, rules);
        let kind = StepKind::Member {
            rule: rule_of(&member.ty, rules, member),
            own_align: own_align(member, rules),
            align,
            after: previous.map(|m| m.name.clone()),
            previous_end,
            written: offset != previous_end.next_multiple_of(align),
            size: member.size,
            own_size: (reach(member) > own).then_some(own),
        };
        let text = if self.path.is_empty() { name.to_string() } else { format!(".{name}") };
        self.step(&text, self.spelled(&member.ty), offset, kind);
        self.place = Place::Member(member, 0);
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

    fn index(&mut self, index: Option<u64>) -> Result<(), PathError> {
        let not_an_array = PathErrorKind::NotAnArray { path: self.path.clone(), ty: self.here() };
        match self.place {
            Place::Member(member, indexed) if indexed < member.dims.len() => {
                self.element(member, indexed, index)
            }
            Place::Member(member, _) => match (member.ty.innermost(), index) {
                (Type::Vector { scalar, rows }, Some(index)) => {
                    self.nth_component(index, None, Components::of_vector(*scalar, *rows))
                }
                (Type::Matrix { .. }, Some(index)) => self.column(member, index),
                _ => self.fail(not_an_array),
            },
            Place::Vector(components) => match index {
                Some(index) => self.nth_component(index, None, components),
                None => self.fail(not_an_array),
            },
            Place::Members(_) | Place::Component(_) => self.fail(not_an_array),
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
        let rules = self.block.rules;
        let stride = member.strides[indexed];
        let Some(adds) = index.unwrap_or(0).checked_mul(stride).filter(|n| *n < 1 << 62) else {
            let (path, index) = (self.path.clone(), index.unwrap_or(0));
            let len = super::LARGEST_BLOCK / stride.max(1);
            return self.fail(PathErrorKind::OutOfRange { path, index, len, what: "elements" });
        };
        let mut array = &member.ty;
        for _ in 0..indexed {
            array = element_of(array);
        }
        let below = element_of(array);
        let kind = StepKind::Element {
            index,
            len,
            stride,
            element_size: unrounded_element(member, indexed, rules),
            align: own_align(member, rules),
            rule: rule_of(array, rules, member),
        };
        let text = index.map_or_else(|| "[]".to_string(), |i| format!("[{i}]"));
        self.step(&text, self.spelled(below), adds, kind);
        self.place = Place::Member(member, indexed + 1);
        Ok(())
    }

    fn column(&mut self, member: &'a MemberLayout, index: u64) -> Result<(), PathError> {
        let Type::Matrix { scalar, columns, rows } = member.ty.innermost() else {
            return Ok(());
        };
        self.in_range(index, u64::from(*columns), "columns")?;
        let width = u64::from(scalar.width);
        let stride = member.matrix_stride.unwrap_or(0);
        let (adds, apart, kind) = if member.row_major {
            let kind = StepKind::ColumnAcrossRows { index, width, stride };
            (index * width, stride, kind)
        } else {
            let column_size = matrix_vector(member).map_or(0, |vector| vector.bytes);
            (index * stride, width, StepKind::Column { index, stride, column_size })
        };
        let column = Type::Vector { scalar: *scalar, rows: *rows };
        self.step(&format!("[{index}]"), self.spelled(&column), adds, kind);
        let components = Components { scalar: *scalar, count: u64::from(*rows), stride: apart };
        self.place = Place::Vector(components);
        Ok(())
    }

    fn component(&mut self, name: &str, components: Components) -> Result<(), PathError> {
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
        Components { scalar, count, stride }: Components,
    ) -> Result<(), PathError> {
        self.in_range(index, count, "components")?;
        let text = format!(".{}", name.unwrap_or(component_name(index)));
        let ty = self.spelled(&Type::Scalar(scalar));
        self.step(&text, ty, index * stride, StepKind::Component { index, stride });
        self.place = Place::Component(scalar);
        Ok(())
    }

    /// Bytes from the first to the last of the place the walk ended at.
    fn size(&self) -> Option<u64> {
        match self.place {
            Place::Members(_) => self.block.size,
            Place::Member(member, 0) => member.size,
            Place::Member(member, indexed) if indexed < member.dims.len() => {
                array_size(member, indexed, self.block.rules)
            }
            Place::Member(member, _) => Some(element_size(member, self.block.rules)),
            Place::Vector(Components { scalar, count, stride }) => {
                Some((count - 1) * stride + u64::from(scalar.width))
            }
            Place::Component(scalar) => Some(scalar.width.into()),
        }
    }
}

fn element_of(ty: &Type) -> &Type {
    match ty {
        Type::Array { element, .. } => element,
        plain => plain,
    }
}

/// The rule a type is laid out by, as it stands in `member`.
fn rule_of(ty: &Type, rules: Rules, member: &MemberLayout) -> Rule {
    let majorness = if member.row_major { Majorness::Row } else { Majorness::Column };
    rules::extent(ty, rules, majorness).map_or(Rule::Structure, |extent| extent.rule)
}

/// The alignment a member's type has by the rules, without `align = N` or `@align(N)` of its own.
fn own_align(member: &MemberLayout, rules: Rules) -> u64 {
    let array = match rules {
        Rules::Std140 if !member.dims.is_empty() => 16,
        Rules::Std140 | Rules::Std430 | Rules::Scalar | Rules::Wgsl => 1,
    };
    let ty = member.ty.innermost();
    let own = match ty {
        Type::Struct(_) => structure(&member.members, rules).align,
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Array { .. } => {
            let majorness = if member.row_major { Majorness::Row } else { Majorness::Column };
            rules::extent(ty, rules, majorness).map_or(1, |extent| extent.align.bytes())
        }
    };
    own.max(array)
}

/// Bytes of an element of a dimension before they are rounded up to the stride.
fn unrounded_element(member: &MemberLayout, indexed: usize, rules: Rules) -> u64 {
    match (member.dims.get(indexed + 1), member.strides.get(indexed + 1)) {
        (Some(ArrayLen::Fixed(_)), Some(_)) => {
            array_size(member, indexed + 1, rules).unwrap_or_default()
        }
        (Some(ArrayLen::Runtime | ArrayLen::Override(_)), Some(stride)) => *stride,
        _ => match member.ty.innermost() {
            Type::Struct(_) => structure(&member.members, rules).data_size,
            Type::Scalar(_)
            | Type::Atomic(_)
            | Type::Vector { .. }
            | Type::Matrix { .. }
            | Type::Address(_)
            | Type::Array { .. } => element_size(member, rules),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::super::byte::{ByteOwner, owner_of_byte};
    use super::*;
    use crate::layout::examples::*;

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
