//! Unique names for every type and module of the output.
//!
//! Reads the complete [`super::plan`], because a name depends on the others: the names of two
//! mirrors of one structure include their rules, a single one's does not. Mirrors are named
//! before helper types.

use rustc_hash::FxHashMap;

use super::Tables;
use super::names::{Scope, camel, module};
use super::plan::Plan;
use super::types::{GeneratedType, GeneratedTypeId, LeafType, Padded, RustType, Shape};
use crate::shape::{Scalar, ScalarKind};

/// The names of the output's top-level items.
pub(super) struct Names {
    /// The name of each [`GeneratedType`], by index.
    pub(super) made: Vec<String>,
    /// The structure of each mirror's members.
    pub(super) inits: FxHashMap<GeneratedTypeId, String>,
    /// The element type of each runtime-sized tail, by the mirror before it.
    pub(super) elements: FxHashMap<GeneratedTypeId, String>,
    /// The module of each block's table.
    pub(super) tables: Vec<String>,
    pub(super) mismatch: String,
    pub(super) too_short: String,
    pub(super) leaf: String,
    pub(super) lookup_error: String,
    pub(super) look_up: String,
}

pub(super) fn name_all(plan: &Plan<'_>, tables: Tables) -> Names {
    let mut scope = Scope::default();
    let mut made = vec![String::new(); plan.made.len()];
    name_mirrors(plan, &mut scope, &mut made);
    let mut inits = FxHashMap::default();
    for (id, _) in plan.mirrors() {
        inits.insert(id, scope.take(&format!("{}Init", made[id.0].trim_end_matches('_'))));
    }
    let mut elements = FxHashMap::default();
    for (id, mirror) in plan.mirrors() {
        if let Some(tail) = &mirror.tail {
            elements.insert(id, scope.take(&tail.name));
        }
    }
    // Inner types come before the types that contain them, so their names are known.
    for (at, one) in plan.made.iter().enumerate() {
        let wanted = match one {
            GeneratedType::Mirror(_) => continue,
            GeneratedType::Bits(bits) => bits.name().to_string(),
            GeneratedType::Leaf(leaf) => leaf_name(*leaf),
            GeneratedType::Padded(Padded { inner, stride, .. }) => {
                format!("{}Stride{stride}", type_name(inner, &made))
            }
            GeneratedType::Tight(tight) => {
                format!("{}Tight{}", type_name(&tight.head, &made), tight.len)
            }
        };
        made[at] = scope.take(&wanted);
    }
    let mut top = |wanted| scope.take(wanted);
    Names {
        made,
        inits,
        elements,
        mismatch: top("Mismatch"),
        too_short: top("TooShort"),
        leaf: top("Leaf"),
        lookup_error: top("LookupError"),
        look_up: top("look_up"),
        tables: match tables {
            Tables::Beside => table_names(plan, &mut scope),
            Tables::Without => Vec::new(),
        },
    }
}

fn name_mirrors(plan: &Plan<'_>, scope: &mut Scope, made: &mut [String]) {
    let mut by_name: FxHashMap<&str, Vec<GeneratedTypeId>> = FxHashMap::default();
    for (id, mirror) in plan.mirrors() {
        by_name.entry(&mirror.name).or_default().push(id);
    }
    // Unique names stay as they are.
    for (id, mirror) in plan.mirrors() {
        if by_name[mirror.name.as_str()].len() == 1 {
            made[id.0] = scope.take(&mirror.name);
        }
    }
    let mut groups: FxHashMap<&str, Vec<String>> = FxHashMap::default();
    for (id, mirror) in plan.mirrors() {
        let group = &by_name[mirror.name.as_str()];
        if group.len() > 1 {
            let names =
                groups.entry(&mirror.name).or_insert_with(|| marked(plan, &mirror.name, group));
            let at = group.binary_search(&id).expect("ids are collected in order");
            made[id.0] = scope.take(&names[at]);
        }
    }
}

/// Appends the marks that distinguish mirrors of the same name. The caller numbers names that
/// stay equal.
fn marked(plan: &Plan<'_>, name: &str, group: &[GeneratedTypeId]) -> Vec<String> {
    let mut names = vec![name.to_string(); group.len()];
    for slot in 0..4 {
        let marks: Vec<&str> = group.iter().map(|id| plan.docs[id].marks()[slot]).collect();
        let mut common_marks: FxHashMap<String, Option<&str>> = FxHashMap::default();
        for (name, mark) in names.iter().zip(&marks) {
            let common = common_marks.entry(name.clone()).or_insert(Some(mark));
            *common = common.filter(|one| one == mark);
        }
        for (name, mark) in names.iter_mut().zip(marks) {
            if common_marks[name.as_str()].is_none() {
                name.push_str(mark);
            }
        }
    }
    names
}

fn table_names(plan: &Plan<'_>, scope: &mut Scope) -> Vec<String> {
    let mut counts: FxHashMap<String, u32> = FxHashMap::default();
    let names: Vec<String> = plan.blocks.iter().map(|block| module(&block.layout.name)).collect();
    for name in &names {
        *counts.entry(name.clone()).or_default() += 1;
    }
    let blocks = plan.blocks.iter().zip(names);
    blocks
        .map(|(block, name)| {
            let instance = block.layout.instance.as_deref();
            let both = instance.filter(|_| counts[&name] > 1 || !scope.is_free(&name));
            match both {
                Some(instance) => scope.take(&module(&format!("{}_{instance}", block.layout.name))),
                None => scope.take(&name),
            }
        })
        .collect()
}

/// A type's name as part of another's: `Vec3`, `F32`, `LightX4`.
fn type_name(ty: &RustType, made: &[String]) -> String {
    match ty {
        RustType::Named(name) => camel(name.rsplit("::").next().unwrap_or(name)),
        RustType::Array(element, len) => format!("{}X{len}", type_name(element, made)),
        RustType::GeneratedType(id) => made[id.0].clone(),
    }
}

/// The name of a leaf type: `Mat3Stride16`, `Vec4Packed`, `DVec3Unaligned`.
fn leaf_name(leaf: LeafType) -> String {
    let mut name = match leaf.shape {
        Shape::Scalar => scalar_name(leaf.scalar).to_string(),
        Shape::Vector { rows } => format!("{}Vec{rows}", prefix(leaf.scalar)),
        Shape::Matrix { columns, rows, stride, row_major } => {
            let size =
                if columns == rows { columns.to_string() } else { format!("{columns}x{rows}") };
            let order = if row_major { "RowMajor" } else { "" };
            format!("{}Mat{size}{order}Stride{stride}", prefix(leaf.scalar))
        }
    };
    if leaf.unaligned {
        name.push_str("Unaligned");
    } else if matches!(leaf.shape, Shape::Vector { .. }) {
        name.push_str("Packed");
    }
    name
}

fn prefix(scalar: Scalar) -> &'static str {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => "",
        (ScalarKind::Float, 8) => "D",
        (ScalarKind::Sint, 4) => "I",
        (ScalarKind::Uint, 4) => "U",
        (ScalarKind::Bool, _) => "B",
        _ => scalar_name(scalar),
    }
}

fn scalar_name(scalar: Scalar) -> &'static str {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => "Bool",
        (ScalarKind::Sint, 1) => "I8",
        (ScalarKind::Sint, 2) => "I16",
        (ScalarKind::Sint, 8) => "I64",
        (ScalarKind::Sint, _) => "I32",
        (ScalarKind::Uint, 1) => "U8",
        (ScalarKind::Uint, 2) => "U16",
        (ScalarKind::Uint, 8) => "U64",
        (ScalarKind::Uint, _) => "U32",
        (ScalarKind::Float, 2) => "F16",
        (ScalarKind::Float, 8) => "F64",
        (ScalarKind::Float, _) => "F32",
        (ScalarKind::Bfloat, _) => "Bf16",
        (ScalarKind::FloatE5m2, _) => "F8E5m2",
        (ScalarKind::FloatE4m3, _) => "F8E4m3",
    }
}
