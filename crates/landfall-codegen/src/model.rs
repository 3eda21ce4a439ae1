//! What the smaller languages are written from: the structures of all blocks with the bytes of their
//! members, each named once.
//!
//! Reads the [layout](landfall_layout::layout) model. Every structure stands behind those that it contains.

mod header;
mod names;

use std::fmt::Write as _;

use rustc_hash::{FxHashMap, FxHashSet};

pub(super) use header::header;
pub(super) use names::{Naming, free};

use super::c::comments;
use super::refusal::{Refusal, blocks, length_constants};
use super::runtime_tail::{TailSize, buffer_size, tail_size};
use landfall_layout::diagnostic::Code;
use landfall_layout::layout::{BlockLayout, MemberLayout, measure};
use landfall_layout::shape::{Rules, Scalar, Type};
use landfall_layout::{Diagnostic, Severity, ShaderLayout};
use names::Names;

/// The structures of all blocks of some shaders.
pub(super) struct Model {
    pub structures: Vec<Structure>,
    /// The constants of all shaders that lengths are written with, by their names in the language.
    /// Those whose name is another's are left out.
    pub constants: Vec<(String, u32)>,
    /// An error for every block that is left out.
    pub diagnostics: Vec<Diagnostic>,
}

/// A structure or block; of a block with a runtime-sized tail, the part before it.
pub(super) struct Structure {
    /// The name in the language.
    pub name: String,
    pub shader_name: String,
    /// The lines of the shader's comment.
    pub comment: Vec<String>,
    pub rules: Rules,
    /// In ascending order of offset.
    pub members: Vec<Member>,
    /// Bytes up to the tail.
    pub size: u64,
    /// The alignment in bytes under which fields and explicit padding have their offsets.
    pub align: u64,
    pub tail: Option<Tail>,
    /// Whether it is a block, not only a part of one.
    pub is_block: bool,
}

impl Structure {
    /// "`Light`: 48 bytes before its runtime-sized tail, std140".
    pub fn about(&self) -> String {
        let upto = if self.tail.is_some() { " before its runtime-sized tail" } else { "" };
        format!("`{}`: {} bytes{upto}, {}", self.shader_name, self.size, self.rules.name())
    }

    /// The members; that of a runtime-sized tail last, with the stride of that.
    pub fn all_members(&self) -> impl Iterator<Item = (&Member, Option<u64>)> {
        let tail = self.tail.iter().map(|tail| (&tail.member, Some(tail.stride)));
        self.members.iter().map(|member| (member, None)).chain(tail)
    }

    /// The members that are arrays, with their strides, outermost first.
    pub fn strides(&self) -> impl Iterator<Item = (&Member, Vec<u64>)> {
        let all = self.all_members().map(|(member, runtime)| (member, member.strides(runtime)));
        all.filter(|(_, strides)| !strides.is_empty())
    }
}

/// The runtime-sized array after a structure.
pub(super) struct Tail {
    /// Its `ty` is that of an element.
    pub member: Member,
    pub stride: u64,
    pub sizes: TailSize,
}

impl Tail {
    /// The size of a buffer as an expression: `max` is the language's expression for the greater of
    /// the size of `n` elements and the least size, which the API demands.
    pub fn size(&self, max: &str) -> String {
        let TailSize { multiple, .. } = self.sizes;
        match self.sizes.must_round(self.member.offset, self.stride) {
            true => format!("({max} + {}) / {multiple} * {multiple}", multiple - 1),
            false => max.to_string(),
        }
    }
}

pub(super) struct Member {
    /// The name in the language.
    pub name: String,
    pub shader_name: String,
    /// The type in the shader's spelling.
    pub shader_type: String,
    /// The lines of the shader's comment.
    pub comment: Vec<String>,
    pub offset: u64,
    pub ty: MemberType,
}

impl Member {
    /// The array strides, outermost first; `runtime` is that of a runtime-sized tail.
    pub fn strides(&self, runtime: Option<u64>) -> Vec<u64> {
        runtime.into_iter().chain(self.ty.dims.iter().map(|dim| dim.stride)).collect()
    }
}

/// The type of a member: an element, and the dimensions of arrays around it.
pub(super) struct MemberType {
    pub element: Element,
    /// Bytes of an element.
    pub size: u64,
    /// Outermost first.
    pub dims: Vec<Dim>,
}

#[derive(Clone, Copy)]
pub(super) struct Dim {
    pub len: u64,
    pub stride: u64,
}

/// An element of an array, or what is in none.
#[derive(Clone, Copy)]
pub(super) enum Element {
    Scalar(Scalar),
    Vector {
        scalar: Scalar,
        rows: u8,
    },
    Matrix(Matrix),
    /// Its index in [`Model::structures`].
    Structure(usize),
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Matrix {
    pub scalar: Scalar,
    pub columns: u8,
    pub rows: u8,
    /// Bytes from a column (row, if row-major) to the next.
    pub stride: u64,
    pub row_major: bool,
}

/// How a language places members.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Placement {
    /// One behind the other: a member cannot begin in the padding of the one before.
    Contiguous,
    /// By offsets.
    Offsets,
}

impl Model {
    /// The structures of the blocks of `shaders`; loose uniforms have none.
    pub fn new(
        shaders: &[&ShaderLayout],
        naming: Naming,
        prefix: &str,
        placement: Placement,
        language: &str,
    ) -> Model {
        let mut maker = Maker {
            model: Model { structures: Vec::new(), constants: Vec::new(), diagnostics: Vec::new() },
            names: Names::new(naming, prefix),
            known: FxHashMap::default(),
            placement,
        };
        for (shader, block) in blocks(shaders) {
            // Structures that a block brought in before it was refused go with it.
            let mark = maker.model.structures.len();
            if let Err(refusal) = maker.block(block, shader) {
                maker.roll_back(mark);
                let output = format!("{language} output");
                let found = refusal.diagnostic(Code::NotMirrored, &output, block, shader);
                maker.model.diagnostics.push(found);
            }
        }
        // Behind the names of all structures.
        let constants = length_constants(shaders, |name| maker.names.of_constant(name));
        let free = constants.into_iter().filter(|(name, _)| maker.names.claim(name));
        maker.model.constants = free.collect();
        maker.model
    }

    /// The largest alignment that a language may give to a type.
    pub fn natural_align(&self, ty: &MemberType) -> u64 {
        match ty.element {
            Element::Structure(at) => self.structures[at].align,
            Element::Scalar(scalar)
            | Element::Vector { scalar, .. }
            | Element::Matrix(Matrix { scalar, .. }) => scalar.width.into(),
        }
    }
}

impl MemberType {
    /// Bytes of the whole, with padding after the last element.
    pub fn whole(&self) -> u64 {
        self.dims.first().map_or(self.size, |dim| dim.len * dim.stride)
    }
}

impl Matrix {
    /// The number of stored vectors, and of components in each.
    pub fn stored(self) -> (u8, u8) {
        if self.row_major { (self.rows, self.columns) } else { (self.columns, self.rows) }
    }
}

/// Numbers with commas between them.
pub(super) fn listed(numbers: &[u64]) -> String {
    numbers.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
}

/// Writes line comments that begin with `marker`.
pub(super) fn comment(marker: &str, lines: &[String], indent: &str, text: &mut String) {
    for line in lines {
        let _ = writeln!(text, "{indent}{marker} {line}");
    }
}

/// The padding before each member of a structure and after the last one: offset and size.
pub(super) fn gaps(structure: &Structure) -> Vec<Option<(u64, u64)>> {
    let mut end = 0;
    let places = structure.members.iter().map(|m| (m.offset, m.offset + m.ty.whole()));
    places
        .chain([(structure.size, structure.size)])
        .map(|(start, next)| {
            let gap = (start > end).then(|| (end, start - end));
            end = next;
            gap
        })
        .collect()
}

struct Maker {
    model: Model,
    names: Names,
    /// The index of each structure by its name in the shader and its contents.
    known: FxHashMap<String, usize>,
    placement: Placement,
}

impl Maker {
    fn roll_back(&mut self, mark: usize) {
        for dropped in self.model.structures.drain(mark..) {
            self.names.release(&dropped.name);
        }
        self.known.retain(|_, at| *at < mark);
    }

    fn block(&mut self, block: &BlockLayout, shader: &ShaderLayout) -> Result<(), Refusal> {
        Refusal::check(block)?;
        let (fixed, tail) = block.split_tail();
        let size = buffer_size(block).unwrap_or(0);
        let end = tail.and_then(|member| member.offset).unwrap_or(size);
        let members = MirroredMembers { members: fixed, tail, size: end };
        let at = self.structure(&block.name, &members, block, shader)?;
        let structure = &mut self.model.structures[at];
        structure.is_block = true;
        // A structure that several blocks have keeps the comment of the first that has one.
        if structure.comment.is_empty() {
            structure.comment = comments::lines(&block.comment, shader);
        }
        Ok(())
    }

    /// The index of the structure with these members, which is added if it is new.
    fn structure(
        &mut self,
        shader_name: &str,
        parts: &MirroredMembers<'_>,
        block: &BlockLayout,
        shader: &ShaderLayout,
    ) -> Result<usize, Refusal> {
        let mut sorted: Vec<&MemberLayout> = parts.members.iter().collect();
        sorted.sort_by_key(|member| member.offset);
        let mut types = Vec::with_capacity(sorted.len());
        // What makes two structures one: the name and all that is printed of the members.
        // Structures within are known already, by their number.
        let mut key = format!("{shader_name} {}", parts.size);
        if parts.tail.is_some() {
            // They decide how long a buffer must be.
            key.push_str(block.rules.name());
        }
        for member in sorted.iter().copied().chain(parts.tail) {
            let ty = self.member_type(member, block, shader)?;
            let dims: String =
                ty.dims.iter().map(|dim| format!("[{}/{}]", dim.len, dim.stride)).collect();
            key.push_str(&format!(";{} {:?} {dims}", member.name, member.offset));
            key.push_str(&match ty.element {
                Element::Structure(at) => format!(" #{at}"),
                _ => {
                    format!(" {} {:?}", spelled(member, shader), member.matrix_stride)
                        + if member.row_major { " rows" } else { "" }
                }
            });
            types.push(ty);
        }
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let tail_type = parts.tail.and_then(|_| types.pop());
        if self.placement == Placement::Contiguous {
            contiguous(&sorted, &types, parts.size)?;
        }
        let (wanted, name) = self.names.of_type(shader_name);
        if wanted != name {
            let message = format!(
                "`{shader_name}` of {} is named `{name}`: another type is `{wanted}`",
                comments::safe(&shader.title())
            );
            let found = Diagnostic::without_place(Code::NumberedName, Severity::Warning, message);
            self.model.diagnostics.push(found);
        }
        let mut taken = FxHashSet::default();
        let mut made = |member: &MemberLayout, ty, names: &Names| Member {
            name: names.of_member(&member.name, &name, &mut taken),
            shader_name: member.name.to_string(),
            shader_type: spelled(member, shader),
            comment: comments::lines(&member.comment, shader),
            offset: member.offset.expect("a placed block's members are placed"),
            ty,
        };
        let members: Vec<Member> =
            sorted.iter().zip(types).map(|(member, ty)| made(member, ty, &self.names)).collect();
        let tail = parts.tail.zip(tail_type).map(|(member, ty)| {
            let stride = member.strides[0];
            let sizes = tail_size(block, parts.size, stride);
            Tail { member: made(member, ty, &self.names), stride, sizes }
        });
        // What a language may align a member to; less where the offsets do not allow it, as in
        // scalar layout.
        let natural = members.iter().map(|m| self.model.natural_align(&m.ty)).max().unwrap_or(1);
        let align = self.fitting(&members, parts.size, natural);
        self.model.structures.push(Structure {
            name,
            shader_name: shader_name.to_string(),
            comment: Vec::new(),
            rules: block.rules,
            members,
            size: parts.size,
            align,
            tail,
            is_block: false,
        });
        let at = self.model.structures.len() - 1;
        self.known.insert(key, at);
        Ok(at)
    }

    /// The largest alignment, at most `natural`, under which every member has its offset.
    fn fitting(&self, members: &[Member], size: u64, natural: u64) -> u64 {
        let mut align = natural;
        let fits = |align: u64| {
            members
                .iter()
                .all(|m| m.offset.is_multiple_of(self.model.natural_align(&m.ty).min(align)))
                && size.is_multiple_of(align)
        };
        // By halves down to 1, which fits every offset.
        while align > 1 && !fits(align) {
            align /= 2;
        }
        align
    }

    /// The type of a member without a runtime-sized dimension.
    fn member_type(
        &mut self,
        member: &MemberLayout,
        block: &BlockLayout,
        shader: &ShaderLayout,
    ) -> Result<MemberType, Refusal> {
        let element = match member.ty.innermost() {
            // A structure's own size, which `Contiguous` languages pad to, not the stride of an
            // array of it.
            Type::Struct(s) => {
                let size = measure::element_size(member, block.rules);
                let name = if s.name.is_empty() { &member.name } else { &s.name };
                let parts = MirroredMembers { members: &member.members, tail: None, size };
                Element::Structure(self.structure(name, &parts, block, shader)?)
            }
            Type::Scalar(scalar) | Type::Atomic(scalar) => Element::Scalar(*scalar),
            Type::Vector { scalar, rows } => Element::Vector { scalar: *scalar, rows: *rows },
            Type::Matrix { scalar, columns, rows } => Element::Matrix(Matrix {
                scalar: *scalar,
                columns: *columns,
                rows: *rows,
                stride: member.matrix_stride.expect("a placed matrix has a stride"),
                row_major: member.row_major,
            }),
            Type::Address(_) => Element::Scalar(Scalar::U64),
            Type::Array { .. } => unreachable!("the innermost type is no array"),
        };
        let size = match element {
            Element::Scalar(scalar) => scalar.width.into(),
            Element::Vector { scalar, rows } => u64::from(scalar.width) * u64::from(rows),
            Element::Matrix(matrix) => matrix.stride * u64::from(matrix.stored().0),
            Element::Structure(at) => self.model.structures[at].size,
        };
        // A runtime-sized dimension is that of a tail, which has its stride; blocks with overrides
        // are refused.
        let dims = member.dims.iter().zip(&member.strides);
        let dims =
            dims.filter_map(|(len, &stride)| Some(Dim { len: measure::fixed(len)?, stride }));
        Ok(MemberType { element, size, dims: dims.collect() })
    }
}

/// The members of a structure, and where they end.
struct MirroredMembers<'m> {
    members: &'m [MemberLayout],
    tail: Option<&'m MemberLayout>,
    size: u64,
}

fn spelled(member: &MemberLayout, shader: &ShaderLayout) -> String {
    member.ty.spelled(shader.language).to_string()
}

/// Checks that no member begins in the padding of the one before.
fn contiguous(members: &[&MemberLayout], types: &[MemberType], size: u64) -> Result<(), Refusal> {
    let starts = members.iter().skip(1).map(|m| (m.offset, format!("`{}`", m.name)));
    // The last member is held to the end of the structure.
    let starts = starts.chain([(Some(size), "what follows".to_string())]);
    for ((member, ty), (next, what)) in members.iter().zip(types).zip(starts) {
        let (end, next) = (member.offset.unwrap_or(0) + ty.whole(), next.unwrap_or(0));
        if end > next {
            let why = format!(
                "`{}` ends at byte {end} with the padding of its last element, but {what} begins \
                 at byte {next}",
                member.name
            );
            return Err(Refusal { span: member.span, why });
        }
    }
    Ok(())
}
