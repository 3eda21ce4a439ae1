//! Chooses the reads that verify a block: every leaf by constant and by dynamic index, at its
//! first, middle and last element, through copies and as an argument.
//!
//! Reads [`layout`](landfall_layout::layout()); the expected byte of each read comes from the
//! layout to be verified, which need not be the shader's own.

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;

use super::sentinel::Grain;
use crate::backend::BackendKind;
use landfall_layout::layout::{BlockLayout, Leaf, MemberLayout};
use landfall_layout::named;
use landfall_layout::shape::{AddressSpace, ArrayLen, Scalar, ScalarKind, Struct, Type};
use landfall_layout::source::Language;

/// Number of elements of a runtime-sized tail.
pub const TAIL: u32 = 3;

/// Maximum number of words one probe of a driver returns: the time of its compiler grows faster
/// than the length of a function.
const DRIVER_WORDS: u32 = 250;

/// Minimum and maximum of the words one probe of the interpreter returns. Every probe holds the
/// whole shader, so that their number must not grow with it; a word takes some registers of 256
/// bytes.
const INTERPRETER_WORDS: [u32; 2] = [1 << 14, 1 << 17];

/// Maximum number of elements of an array that is copied as a whole.
const LARGEST_COPY: u64 = 64;

/// Maximum size of a probed buffer in bytes: sentinels beyond it would not be distinct 32-bit
/// floats.
pub const LARGEST_BUFFER: u64 = 32 << 20;

named! {
    /// The way in which a leaf is read or written.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum AccessMode {
        /// `data[3].pos.x`.
        Constant = "constant",
        /// `data[i].pos[j]`, with indices known only at run time.
        Dynamic = "dynamic",
        /// From a copy of the structure or array that contains it.
        Copied = "copied",
        /// From such a structure passed to a function.
        Passed = "passed",
        /// Assigned, in a storage block.
        Written = "written",
    }
}

/// One component read or written in one way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Read {
    /// The index of the leaf in the block.
    pub leaf: usize,
    /// The indices of the dimensions on its path.
    pub element: Vec<u32>,
    /// The column of a matrix.
    pub column: Option<u8>,
    /// The component of a vector or of a matrix's column.
    pub row: Option<u8>,
    pub way: AccessMode,
    /// The word in the results; 64 bits take two, except where [`Grain::Double`] identifies them.
    pub slot: u32,
    /// The expected byte.
    pub byte: u64,
    pub scalar: Scalar,
}

/// The reads of one run.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The reads; their slots follow [`Plan::indices`].
    pub reads: Vec<Read>,
    /// The index values of dynamic reads, ascending, which are the first words of the results.
    pub indices: Vec<u32>,
    /// The number of words of the results, indices included.
    pub words: u32,
    /// The units of the buffer that its values identify.
    pub grain: Grain,
}

/// A leaf that no probe reads.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Unprobed {
    /// The path.
    pub path: String,
    /// The reason.
    pub reason: String,
}

/// The runs that probe a block.
#[derive(Clone, Debug, Default)]
pub struct Plans {
    /// Runs that read.
    pub reads: Vec<Plan>,
    /// Runs that write.
    pub writes: Vec<Plan>,
    /// Leaves that are left out.
    pub unprobed: Vec<Unprobed>,
}

/// The access to a member of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// Whether it may be read.
    pub read: bool,
    /// Whether it may be written.
    pub write: bool,
}

/// Plans the reads and writes of a block of a shader in `language` with the given access to its
/// members on a backend. The expected bytes are those of `expected`, whose leaves have the same
/// paths.
pub fn plans(
    block: &BlockLayout,
    expected: &BlockLayout,
    access: &[Access],
    language: Language,
    backend: BackendKind,
) -> Plans {
    let mut plans = Plans::default();
    let most = match backend {
        BackendKind::Cpu => {
            let [least, most] = INTERPRETER_WORDS;
            u32::try_from(block.leaves.len()).unwrap_or(most).clamp(least, most)
        }
        BackendKind::Gl | BackendKind::Gpu | BackendKind::WebGl | BackendKind::WebGpu => {
            DRIVER_WORDS
        }
    };
    let tops: FxHashMap<&str, usize> =
        block.members.iter().enumerate().map(|(at, m)| (&*m.name, at)).collect();
    let by_path: BTreeMap<&str, &Leaf> =
        expected.leaves.iter().map(|leaf| (leaf.path.as_str(), leaf)).collect();
    // A buffer has one kind of contents, so each grain has runs of its own, and so have reads and
    // writes.
    let mut batches: BTreeMap<(bool, Grain), ReadBatch> = BTreeMap::new();
    for (index, leaf) in block.leaves.iter().enumerate() {
        let expected = match by_path.get(leaf.path.as_str()) {
            None => {
                plans.leave_out(leaf, "the given layout has no member of this path");
                continue;
            }
            Some(expected) => expected,
        };
        let scalar = match component(leaf) {
            Ok(scalar) => scalar,
            Err(reason) => {
                plans.leave_out(leaf, reason);
                continue;
            }
        };
        let Some(elements) = elements(leaf) else {
            plans.leave_out(leaf, "the size of its array is not known");
            continue;
        };
        let at = top_name(leaf).and_then(|name| tops.get(name).copied());
        let top = at.map(|at| &block.members[at]);
        let none = Access { read: false, write: false };
        let access = at.and_then(|at| access.get(at)).copied().unwrap_or(none);
        if access == none {
            plans.leave_out(
                leaf,
                "it is `readonly` and `writeonly`, so no shader can read or write it",
            );
            continue;
        }
        for way in ways(leaf, top, block.space, access) {
            // Two elements of a copy reveal as much as all.
            let copied = matches!(way, AccessMode::Copied | AccessMode::Passed);
            let elements = if copied { &elements[..elements.len().min(2)] } else { &elements };
            for element in elements {
                for (column, row) in components(&leaf.ty) {
                    let Some(byte) = byte_of(expected, element, column, row, scalar) else {
                        plans.leave_out(leaf, "the given layout has another type for this member");
                        continue;
                    };
                    let read = Read {
                        leaf: index,
                        element: element.clone(),
                        column,
                        row,
                        way,
                        slot: 0,
                        byte,
                        scalar,
                    };
                    let writes = way == AccessMode::Written;
                    let grain = grain(scalar, language);
                    let batch = batches.entry((writes, grain)).or_default();
                    // The values that one run writes have to differ.
                    let most = if writes { most.min(grain.written()) } else { most };
                    let full = batch.add(read, grain, most);
                    if full {
                        let plan = std::mem::take(batch).finish(grain);
                        if writes { &mut plans.writes } else { &mut plans.reads }.push(plan);
                    }
                }
            }
        }
    }
    for ((writes, grain), batch) in batches {
        if !batch.reads.is_empty() {
            let plan = batch.finish(grain);
            if writes { &mut plans.writes } else { &mut plans.reads }.push(plan);
        }
    }
    plans.unprobed.dedup();
    plans
}

impl Plans {
    fn leave_out(&mut self, leaf: &Leaf, reason: impl Into<String>) {
        self.unprobed.push(Unprobed { path: leaf.path.clone(), reason: reason.into() });
    }
}

/// The reads collected for one run.
#[derive(Default)]
struct ReadBatch {
    reads: Vec<Read>,
    words: u32,
}

impl ReadBatch {
    /// Adds a read and returns whether the batch has `most` words.
    fn add(&mut self, read: Read, grain: Grain, most: u32) -> bool {
        self.words += words_of(read.scalar, grain);
        self.reads.push(read);
        self.words >= most
    }

    fn finish(mut self, grain: Grain) -> Plan {
        let mut indices: Vec<u32> = Vec::new();
        let mut known = FxHashSet::default();
        let used = self.reads.iter().flat_map(|read| {
            let (column, row) = (read.column.map(u32::from), read.row.map(u32::from));
            read.element.iter().copied().chain(column).chain(row)
        });
        for index in used {
            if known.insert(index) {
                indices.push(index);
            }
        }
        // In order, so that a slot is found by bisection.
        indices.sort_unstable();
        let mut slot = indices.len() as u32;
        for read in &mut self.reads {
            read.slot = slot;
            slot += words_of(read.scalar, grain);
        }
        Plan { reads: self.reads, indices, words: slot, grain }
    }
}

/// Returns the number of words of a component in the results.
fn words_of(scalar: Scalar, grain: Grain) -> u32 {
    if scalar.width == 8 && grain == Grain::Word { 2 } else { 1 }
}

/// Returns the units of a buffer that values of a component can identify.
fn grain(scalar: Scalar, language: Language) -> Grain {
    match (scalar.kind, scalar.width) {
        (_, 1) => Grain::Byte,
        (_, 2) => Grain::Half,
        // naga's WGSL has no function that returns the bits of an f64.
        (ScalarKind::Float, 8) if language == Language::Wgsl => Grain::Double,
        _ => Grain::Word,
    }
}

/// Returns the component type of a leaf, if a value can identify it.
fn component(leaf: &Leaf) -> Result<Scalar, String> {
    let scalar = match &leaf.ty {
        Type::Scalar(scalar) | Type::Atomic(scalar) => *scalar,
        Type::Vector { scalar, .. } | Type::Matrix { scalar, .. } => *scalar,
        Type::Address(name) => return Err(format!("it is the address of a `{name}`, not a value")),
        Type::Struct(_) | Type::Array { .. } => {
            return Err("it is a structure or array, not a scalar, vector or matrix".to_string());
        }
    };
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, 4)
        | (ScalarKind::Sint | ScalarKind::Uint, 1 | 2 | 4 | 8)
        | (ScalarKind::Float, 2 | 4 | 8) => Ok(scalar),
        _ => Err(format!(
            "no backend has the type `{}`",
            Type::Scalar(scalar).spelled(Language::Glsl)
        )),
    }
}

/// Returns the first, middle and last element of every dimension, the other dimensions at their
/// first.
fn elements(leaf: &Leaf) -> Option<Vec<Vec<u32>>> {
    let mut dims: Vec<Vec<u32>> = Vec::with_capacity(leaf.dims.len());
    for len in &leaf.dims {
        let length = match len {
            ArrayLen::Fixed(length) => *length,
            ArrayLen::Runtime => TAIL,
            ArrayLen::Override(_) => return None,
        };
        let last = length.checked_sub(1)?;
        let mut chosen = vec![0, last / 2, last];
        chosen.dedup();
        dims.push(chosen);
    }
    let firsts: Vec<u32> = dims.iter().map(|dim| dim[0]).collect();
    let lasts: Vec<u32> = dims.iter().filter_map(|dim| dim.last().copied()).collect();
    let mut chosen = vec![firsts.clone(), lasts.clone()];
    // First and last coincide in arrays of one element.
    chosen.dedup();
    // Strides show in one dimension at a time, so that not every combination is needed.
    for (at, dim) in dims.iter().enumerate() {
        for &index in dim {
            let mut element = firsts.clone();
            element[at] = index;
            if !chosen.contains(&element) {
                chosen.push(element);
            }
        }
    }
    Some(chosen)
}

/// Returns column and row of every component.
fn components(ty: &Type) -> Vec<(Option<u8>, Option<u8>)> {
    match ty {
        Type::Vector { rows, .. } => (0..*rows).map(|row| (None, Some(row))).collect(),
        Type::Matrix { columns, rows, .. } => (0..*columns)
            .flat_map(|column| (0..*rows).map(move |row| (Some(column), Some(row))))
            .collect(),
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => vec![(None, None)],
    }
}

/// Returns the offset of a component of an element from the start of the block.
pub fn byte_of(
    leaf: &Leaf,
    element: &[u32],
    column: Option<u8>,
    row: Option<u8>,
    scalar: Scalar,
) -> Option<u64> {
    if leaf.strides.len() != element.len() {
        return None;
    }
    let mut byte = leaf.offset?;
    for (index, stride) in element.iter().zip(&leaf.strides) {
        byte = byte.checked_add(u64::from(*index).checked_mul(*stride)?)?;
    }
    let width = u64::from(scalar.width);
    let (column, row) = (u64::from(column.unwrap_or(0)), u64::from(row.unwrap_or(0)));
    let inside = match leaf.matrix_stride {
        Some(stride) if leaf.row_major => row * stride + column * width,
        Some(stride) => column * stride + row * width,
        None => row * width,
    };
    byte.checked_add(inside)
}

/// Returns the block's members by name.
pub(crate) fn members(block: &BlockLayout) -> FxHashMap<&str, &MemberLayout> {
    block.members.iter().map(|member| (&*member.name, member)).collect()
}

/// Returns the name of the block's member that contains a leaf.
pub fn top_name(leaf: &Leaf) -> Option<&str> {
    leaf.path.split(['.', '[']).next()
}

fn ways(
    leaf: &Leaf,
    top: Option<&MemberLayout>,
    space: AddressSpace,
    access: Access,
) -> Vec<AccessMode> {
    let mut ways = Vec::new();
    if access.read {
        ways.push(AccessMode::Constant);
        let indexed =
            !leaf.dims.is_empty() || !matches!(leaf.ty, Type::Scalar(_) | Type::Atomic(_));
        if indexed {
            ways.push(AccessMode::Dynamic);
        }
        match top.map(|top| (top, top.ty.innermost())) {
            Some((_, Type::Struct(structure))) if can_be_copied(structure) => {
                // A copy of an unnamed structure cannot be declared.
                if !structure.name.is_empty() {
                    ways.extend([AccessMode::Copied, AccessMode::Passed]);
                }
            }
            Some((top, _)) if !top.dims.is_empty() && is_small(top) && !has_atomic(&top.ty) => {
                ways.push(AccessMode::Copied);
            }
            Some(_) | None => {}
        }
    }
    if access.write && space == AddressSpace::Storage && !matches!(leaf.ty, Type::Atomic(_)) {
        ways.push(AccessMode::Written);
    }
    ways
}

/// Returns whether a structure can be copied: WGSL's atomics and GLSL's samplers cannot.
fn can_be_copied(structure: &Struct) -> bool {
    structure.opaque.is_empty()
        && structure.members.iter().all(|member| match member.ty.innermost() {
            Type::Struct(inner) => can_be_copied(inner),
            ty => !has_atomic(ty),
        })
}

fn is_small(member: &MemberLayout) -> bool {
    let count = member.dims.iter().try_fold(1u64, |product, len| match len {
        ArrayLen::Fixed(length) => product.checked_mul(u64::from(*length)),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    });
    count.is_some_and(|count| count <= LARGEST_COPY)
}

fn has_atomic(ty: &Type) -> bool {
    match ty {
        Type::Atomic(_) => true,
        Type::Array { element, .. } => has_atomic(element),
        Type::Struct(structure) => structure.members.iter().any(|member| has_atomic(&member.ty)),
        Type::Scalar(_) | Type::Vector { .. } | Type::Matrix { .. } | Type::Address(_) => false,
    }
}
