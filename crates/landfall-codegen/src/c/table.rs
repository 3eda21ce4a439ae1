//! The section of one block beside its structure: macros for sizes, offsets and bindings, and
//! the table of names.

use rustc_hash::FxHashSet;

use super::comments::safe;
use super::names::{FreeNames, Names, snake};
use super::types::Mirror;
use crate::runtime_tail::tail_size;
use landfall_layout::ShaderLayout;
use landfall_layout::layout::measure::fixed;
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::{ArrayLen, Scalar, ScalarKind, Type};

/// The most array dimensions that a row of the table holds.
pub(super) const MAX_DIMS: usize = 8;

/// The parameters of offset macros, one per dimension.
const INDICES: [&str; MAX_DIMS] = ["i", "j", "k", "l", "m", "n", "o", "p"];

/// The macros, the table and the search of one block.
#[derive(Clone, Debug)]
pub(super) struct Section {
    /// The prefix of its macros.
    pub macros: String,
    pub text: String,
    /// The section's contents, to skip repeated sections.
    pub facts: String,
}

/// The names and contents of the sections written so far.
#[derive(Debug, Default)]
pub(super) struct Earlier {
    facts: FxHashSet<String>,
    macros: FreeNames,
}

/// Writes a block's section; `None` when an earlier section already describes the same block.
pub(super) fn section(
    block: &BlockLayout,
    shader: &ShaderLayout,
    mirror: &Mirror,
    earlier: &mut Earlier,
    names: &mut Names,
) -> Option<Section> {
    let leaves: Vec<_> =
        block.leaves.iter().map(|l| (&l.path, l.offset, &l.dims, &l.strides)).collect();
    // Everything that the section is printed from.
    let facts = format!(
        "{} {:?} {:?} {:?} {:?} {:?} {leaves:?}",
        block.name, mirror.structure, block.size, block.group, block.binding, block.count
    );
    if !earlier.facts.insert(facts.clone()) {
        return None;
    }
    let macros = macros(block, earlier, names);
    let mut text = heading(block, shader);
    constants(block, mirror, &macros, names, &mut text);
    tail(mirror, &macros, names, &mut text);
    offsets(block, &macros, names, &mut text);
    rows(block, shader, &macros, names, &mut text);
    Some(Section { macros, text, facts })
}

/// The prefix of a block's macros: its name, with its instance or a number added if taken.
fn macros(block: &BlockLayout, earlier: &mut Earlier, names: &Names) -> String {
    let mut wanted = names.upper(&block.name);
    if let (true, Some(instance)) = (earlier.macros.contains(&wanted), &block.instance) {
        wanted = format!("{wanted}_{}", names.upper_part(instance));
    }
    earlier.macros.claim(wanted)
}

fn heading(block: &BlockLayout, shader: &ShaderLayout) -> String {
    let instance = block.instance.as_ref().map_or(String::new(), |name| format!(" {name}"));
    let declared = if block.rules_declared {
        ""
    } else {
        ".\n * The shader does not say so: its offsets are the driver's until it does"
    };
    let kind = block.space.name();
    let rules = block.rules.name();
    format!(
        "/* {kind} {}{instance} of {}, {rules}{declared}. */\n",
        block.name,
        safe(&shader.title())
    )
}

fn constants(
    block: &BlockLayout,
    mirror: &Mirror,
    macros: &str,
    names: &mut Names,
    text: &mut String,
) {
    let mut define = |name: &str, value: String| {
        let name = names.global.claim(format!("{macros}_{name}"));
        text.push_str(&format!("#define {name} {value}\n"));
    };
    define("SIZE", number(crate::runtime_tail::buffer_size(block).unwrap_or(0)));
    define("DATA_SIZE", number(block.data_size.unwrap_or(0)));
    if let Some(group) = block.group {
        define("GROUP", number(group.into()));
    }
    if let Some(binding) = block.binding {
        define("BINDING", number(binding.into()));
    }
    if let [ArrayLen::Fixed(count)] = block.count.as_slice() {
        define("BUFFERS", number((*count).into()));
    }
    if let Some((field, stride)) = &mirror.tail {
        let sizes = tail_size(block, field.offset, *stride);
        // `n` is converted before it is multiplied, as sizes may exceed an `int`.
        let end = format!("{} + {} * (size_t)(n)", number(field.offset), number(*stride));
        let end = match sizes.must_round(field.offset, *stride) {
            false => end,
            true => format!("({end} + {}) / {1} * {1}", sizes.multiple - 1, sizes.multiple),
        };
        let least = number(sizes.least);
        define("SIZE_FOR(n)", format!("({end} < {least} ? (size_t){least} : {end})"));
    }
    // Of the block's own members that are arrays: C programs loop over these.
    for member in block.members.iter().filter(|member| !member.dims.is_empty()) {
        let name = snake(&member.name).to_ascii_uppercase();
        if let Some(count) = member.dims.first().and_then(fixed) {
            define(&format!("{name}_COUNT"), number(count));
        }
        define(&format!("{name}_STRIDE"), number(member.strides[0]));
    }
}

/// Writes the function that returns the elements of the runtime-sized tail.
fn tail(mirror: &Mirror, macros: &str, names: &mut Names, text: &mut String) {
    let Some((field, stride)) = &mirror.tail else { return };
    let lower = macros.to_ascii_lowercase();
    let function = names.global.claim(format!("{lower}_{}", field.name));
    let mut element = field.ty.base.clone();
    if !field.ty.brackets.is_empty() {
        let brackets: String = field.ty.brackets.iter().map(|n| format!("[{n}]")).collect();
        let name = names.global.claim(format!("{function}_element"));
        text.push_str(&format!("typedef {element} {name}{brackets};\n"));
        element = name;
    }
    if field.ty.is_user && mirror.structure.is_none() {
        text.push_str(&field.assert_type(*stride, false));
    }
    text.push_str(&format!(
        "/* The elements of `{}` in the bytes of a block. */\n\
         static inline {element} *{function}(void *block)\n{{\n    \
         return ({element} *)((unsigned char *)block + {});\n}}\n",
        field.member,
        number(field.offset),
    ));
}

/// Writes the offset macros.
fn offsets(block: &BlockLayout, macros: &str, names: &mut Names, text: &mut String) {
    for leaf in &block.leaves {
        let path = leaf.path.replace("[]", "");
        let parts: Vec<String> = path.split('.').map(|part| names.upper_part(part)).collect();
        let name = names.global.claim(format!("{macros}_{}_OFFSET", parts.join("_")));
        let offset = number(leaf.offset.unwrap_or(0));
        if leaf.dims.is_empty() {
            text.push_str(&format!("#define {name} {offset}\n"));
            continue;
        }
        let indices = &INDICES[..leaf.dims.len()];
        // An index is converted before it is multiplied, as offsets may exceed an `int`.
        let terms = leaf.strides.iter().zip(indices);
        let terms: String =
            terms.map(|(stride, i)| format!(" + {} * (size_t)({i})", number(*stride))).collect();
        text.push_str(&format!("#define {name}({}) ({offset}{terms})\n", indices.join(", ")));
    }
}

/// Writes the table of names and its lookup function.
fn rows(
    block: &BlockLayout,
    shader: &ShaderLayout,
    macros: &str,
    names: &mut Names,
    text: &mut String,
) {
    let table = names.global.claim(format!("{macros}_LEAVES"));
    text.push_str(&format!("static const landfall_leaf {table}[] = {{\n"));
    for leaf in &block.leaves {
        text.push_str(&row(leaf, shader));
    }
    text.push_str("};\n");
    let lookup = names.global.claim(format!("{}_lookup", macros.to_ascii_lowercase()));
    text.push_str(&format!(
        "/* Byte offset of a path of this block, or -1; see landfall_lookup. */\n\
         static inline int64_t {lookup}(const char *path, const landfall_leaf **found)\n{{\n    \
         return landfall_lookup({table}, sizeof({table}) / sizeof({table}[0]), path, found);\n}}\n",
    ));
}

fn row(leaf: &Leaf, shader: &ShaderLayout) -> String {
    let (scalar, columns, rows) = match &leaf.ty {
        Type::Scalar(scalar) | Type::Atomic(scalar) => (Some(*scalar), 1, 1),
        Type::Vector { scalar, rows } => (Some(*scalar), 1, *rows),
        Type::Matrix { scalar, columns, rows } => (Some(*scalar), *columns, *rows),
        Type::Address(_) => (None, 1, 1),
        Type::Struct(_) | Type::Array { .. } => unreachable!("a leaf has no parts"),
    };
    let kind = scalar.map_or("LANDFALL_ADDRESS", kind);
    let width = scalar.map_or(8, |scalar| scalar.width);
    let dims = leaf.dims.iter();
    let dims = dims.map(|len| fixed(len).map_or("0".to_string(), number)).collect();
    let strides = leaf.strides.iter().map(|stride| number(*stride)).collect();
    // Before C23 braces with nothing between them initialise nothing.
    let list = |list: Vec<String>| if list.is_empty() { "0".to_string() } else { list.join(", ") };
    format!(
        "    {{ \"{}\", \"{}\", {kind}, {width}, {columns}, {rows}, {}, {}, {}, {}, {}, {{ {} }}, {{ {} }} }},\n",
        leaf.path,
        safe(&leaf.ty.spelled(shader.language).to_string()),
        u8::from(leaf.row_major),
        number(leaf.matrix_stride.unwrap_or(0)),
        number(leaf.offset.unwrap_or(0)),
        number(leaf.size.unwrap_or(0)),
        leaf.dims.len(),
        list(dims),
        list(strides),
    )
}

fn kind(scalar: Scalar) -> &'static str {
    match scalar.kind {
        ScalarKind::Bool => "LANDFALL_BOOL",
        ScalarKind::Sint => "LANDFALL_INT",
        ScalarKind::Uint => "LANDFALL_UINT",
        ScalarKind::Float => "LANDFALL_FLOAT",
        ScalarKind::Bfloat => "LANDFALL_BFLOAT",
        ScalarKind::FloatE5m2 => "LANDFALL_FLOAT_E5M2",
        ScalarKind::FloatE4m3 => "LANDFALL_FLOAT_E4M3",
    }
}

/// An unsigned C literal, `ull` if it needs more than 32 bits.
fn number(value: u64) -> String {
    if value <= u64::from(u32::MAX) { format!("{value}u") } else { format!("{value}ull") }
}
