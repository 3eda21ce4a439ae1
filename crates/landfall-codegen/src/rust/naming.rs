//! Unique names for every type and module of the output, spelled as each module spells them.
//!
//! Reads the complete [`super::plan`], because the names of a module depend on each other: the
//! names of two mirrors of one structure include their rules, a single one's does not. Mirrors are
//! named before helper types. A module's names do not depend on other modules.

use rustc_hash::FxHashMap;

use super::Tables;
use super::names::{Scope, camel, module};
use super::plan::Plan;
use super::types::{
    Component, GeneratedType, GeneratedTypeId, LeafType, Module, Padded, RustType, Shape, component,
};
use landfall_layout::shape::{AddressSpace, Scalar, ScalarKind};

/// The type of a row of a table, in the module of helpers.
pub(super) const LEAF: &str = "Leaf";
/// The error of a lookup, there too.
pub(super) const LOOKUP_ERROR: &str = "LookupError";

/// The names of the generated items as one module spells them.
#[derive(Default)]
pub(super) struct Names {
    /// The name of each [`GeneratedType`], by index; empty if this module does not use it.
    pub(super) made: Vec<String>,
    /// The structure of each mirror's members.
    pub(super) inits: FxHashMap<GeneratedTypeId, String>,
    /// The element type of each runtime-sized tail, by the mirror before it.
    pub(super) elements: FxHashMap<GeneratedTypeId, String>,
    /// The module of each block's table; empty if this module has none.
    pub(super) tables: Vec<String>,
    /// The path of the module of helpers.
    pub(super) support: String,
    pub(super) mismatch: String,
    pub(super) too_short: String,
    /// The names that a number was appended to.
    pub(super) numbered: Vec<Numbered>,
}

/// A name that another item of its module has already.
pub(super) struct Numbered {
    pub(super) wanted: String,
    pub(super) given: String,
    pub(super) of: NumberedItem,
}

/// An item whose name got a number because another item has it.
pub(super) enum NumberedItem {
    Mirror(GeneratedTypeId),
    /// The table of the block of this index.
    Table(usize),
}

/// The names of the helpers.
pub(super) fn name_support(plan: &Plan<'_>) -> Names {
    let mut scope = Scope::default();
    scope.reserve(&[LEAF, LOOKUP_ERROR, "Mismatch", "TooShort", "look_up"]);
    let mut names = Names {
        made: vec![String::new(); plan.made.len()],
        mismatch: "Mismatch".to_string(),
        too_short: "TooShort".to_string(),
        ..Names::default()
    };
    name_helpers(plan, Module::Support, &mut scope, &mut names.made);
    names
}

/// The names of a module that holds or imports mirrors. `support` is the path of the helpers, which
/// are spelled with it unless the module imports them and has no item of their name.
pub(super) fn name_module(
    plan: &Plan<'_>,
    here: Module,
    tables: Tables,
    support: &str,
    helpers: &Names,
    imports: bool,
) -> Names {
    // Mirrors come first, then what is derived from them, tables and helpers: the names that
    // programs use most are the least likely to get a number.
    let mut scope = Scope::default();
    if !imports {
        // In the file itself the module of helpers is an item, too.
        scope.reserve(&[support]);
    }
    let mut names = Names {
        made: vec![String::new(); plan.made.len()],
        support: support.to_string(),
        ..Names::default()
    };
    name_mirrors(plan, here, &mut scope, &mut names);
    for (id, mirror) in plan.mirrors_in(here) {
        if !mirror.fields.is_empty() {
            let init = format!("{}Init", names.made[id.0].trim_end_matches('_'));
            names.inits.insert(id, scope.take(&init));
        }
        if let Some(tail) = &mirror.tail {
            names.elements.insert(id, scope.take(&tail.name));
        }
    }
    names.tables = vec![String::new(); plan.blocks.len()];
    if tables == Tables::Beside {
        name_tables(plan, here, &mut scope, &mut names);
    }
    // An import by `*` is hidden by an item of the module with the same name.
    let spelled = |scope: &Scope, name: &str| match imports && scope.is_free(name) {
        true => name.to_string(),
        false => format!("{support}::{name}"),
    };
    for (at, name) in helpers.made.iter().enumerate() {
        if !name.is_empty() {
            names.made[at] = spelled(&scope, name);
        }
    }
    // Types of this module that are no mirrors, such as arrays of mirrors with padding.
    name_helpers(plan, here, &mut scope, &mut names.made);
    names.mismatch = spelled(&scope, "Mismatch");
    names.too_short = spelled(&scope, "TooShort");
    names
}

/// Names the types of a module that are no mirrors. Inner types come before the types that contain
/// them, so their names are known.
fn name_helpers(plan: &Plan<'_>, here: Module, scope: &mut Scope, made: &mut [String]) {
    for id in plan.types_in(here) {
        let helper = plan.module_of(id) == Module::Support;
        if helper != (here == Module::Support) {
            continue;
        }
        let wanted = match plan.get(id) {
            GeneratedType::Mirror(_) => continue,
            GeneratedType::Bits(bits) => bits.name().to_string(),
            GeneratedType::Leaf(leaf) => leaf_name(*leaf),
            GeneratedType::Padded(Padded { inner, stride, .. }) => {
                format!("{}Stride{stride}", type_name(inner, made))
            }
            GeneratedType::Tight(tight) => {
                format!("{}Tight{}", type_name(&tight.head, made), tight.len)
            }
        };
        made[id.0] = scope.take(&wanted);
    }
}

fn name_mirrors(plan: &Plan<'_>, here: Module, scope: &mut Scope, names: &mut Names) {
    let mirrors = plan.mirrors_in(here);
    // By name first: only mirrors that share one are marked.
    let mut by_name: FxHashMap<&str, Vec<GeneratedTypeId>> = FxHashMap::default();
    for (id, mirror) in &mirrors {
        by_name.entry(&mirror.name).or_default().push(*id);
    }
    // Unique names stay as they are.
    let mut rest = FxHashMap::default();
    for (id, mirror) in &mirrors {
        match &by_name[mirror.name.as_str()][..] {
            [_] => names.take(scope, mirror.name.clone(), NumberedItem::Mirror(*id)),
            group if group[0] == *id => {
                rest.extend(group.iter().copied().zip(marked(plan, here, &mirror.name, group)));
            }
            _ => {}
        }
    }
    for (id, _) in mirrors {
        if let Some(name) = rest.remove(&id) {
            names.take(scope, name, NumberedItem::Mirror(id));
        }
    }
}

impl Names {
    /// Claims a name, and notes if it got a number.
    fn take(&mut self, scope: &mut Scope, wanted: String, of: NumberedItem) {
        let given = scope.take(&wanted);
        match &of {
            NumberedItem::Mirror(id) => self.made[id.0].clone_from(&given),
            NumberedItem::Table(at) => self.tables[*at].clone_from(&given),
        }
        if given != wanted {
            self.numbered.push(Numbered { wanted, given, of });
        }
    }
}

/// Appends the marks that distinguish mirrors of the same name. The caller numbers names that
/// stay equal.
fn marked(plan: &Plan<'_>, here: Module, name: &str, group: &[GeneratedTypeId]) -> Vec<String> {
    let mut names = vec![name.to_string(); group.len()];
    let all: Vec<[&str; 4]> =
        group.iter().map(|id| plan.docs[id].marks(plan.rules_in(*id, here))).collect();
    // Each kind of mark is appended only where it tells apart mirrors whose names are equal so far.
    for slot in 0..4 {
        let marks: Vec<&str> = all.iter().map(|marks| marks[slot]).collect();
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

fn name_tables(plan: &Plan<'_>, here: Module, scope: &mut Scope, names: &mut Names) {
    let mut counts: FxHashMap<String, u32> = FxHashMap::default();
    let blocks = || plan.blocks.iter().enumerate().filter(|(at, _)| plan.has_table(*at, here));
    for (_, block) in blocks() {
        *counts.entry(module(&block.name)).or_default() += 1;
    }
    for (at, block) in blocks() {
        let name = module(&block.name);
        let instance = block.layout.instance.as_deref();
        // The instance's name where two blocks share theirs, or a mirror has it.
        let both = instance.filter(|_| counts[&name] > 1 || !scope.is_free(&name));
        let wanted = match both {
            Some(instance) => module(&format!("{}_{instance}", block.name)),
            // A structure that is laid out under several rules.
            None if block.layout.space == AddressSpace::Structure && counts[&name] > 1 => {
                module(&format!("{}_{}", block.name, block.layout.rules.name()))
            }
            None => name,
        };
        names.take(scope, wanted, NumberedItem::Table(at));
    }
}

/// A type's name as part of another's: `Vec3`, `F32`, `LightX4`.
fn type_name(ty: &RustType, made: &[String]) -> String {
    match ty {
        RustType::Named(name) => camel(last(name)),
        RustType::User(user) => camel(last(user.path.split('<').next().unwrap_or_default())),
        RustType::Array(element, len) => format!("{}X{len}", type_name(element, made)),
        RustType::GeneratedType(id) => last(&made[id.0]).to_string(),
    }
}

/// The last part of a path.
fn last(path: &str) -> &str {
    path.rsplit("::").next().unwrap_or(path)
}

/// The name of a leaf type: `Mat3Stride16`, `Vec4Packed`, `DVec3Unaligned`.
fn leaf_name(leaf: LeafType) -> String {
    let mut name = match leaf.shape {
        Shape::Scalar => scalar_name(leaf.scalar),
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

fn prefix(scalar: Scalar) -> String {
    let short = match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => "",
        (ScalarKind::Float, 8) => "D",
        (ScalarKind::Sint, 4) => "I",
        (ScalarKind::Uint, 4) => "U",
        (ScalarKind::Bool, _) => "B",
        _ => return scalar_name(scalar),
    };
    short.to_string()
}

fn scalar_name(scalar: Scalar) -> String {
    match component(scalar) {
        Component::Bits(bits) => bits.name().to_string(),
        Component::Plain(name) => name.to_ascii_uppercase(),
    }
}
