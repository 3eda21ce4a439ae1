//! Prints the tables from names to offsets: one module per block, and their shared items.

use std::fmt::Write as _;

use landfall_layout::layout::Leaf;
use landfall_layout::layout::measure::{fixed, fixed_elements};

use super::names::{Scope, screaming, snake};
use super::naming::{LEAF, LOOKUP_ERROR};
use super::plan::PlannedBlock;
use super::print::{Items, Printer, Text, indices, signature, slice};

/// The items of every table beside its leaves.
const OWN_ITEMS: &[&str] = &["SIZE", "DATA_SIZE", "GROUP", "BINDING", "COUNT", "LEAVES", "lookup"];

pub(super) fn tables(out: &Printer<'_>, text: &mut Text) {
    for (at, block) in out.plan.blocks.iter().enumerate() {
        if out.plan.module_of_table(at) == out.module {
            table(out, text, block, &out.names.tables[at]);
        }
    }
}

fn table(out: &Printer<'_>, text: &mut Text, block: &PlannedBlock<'_>, name: &str) {
    let (public, layout) = (out.visibility(), block.layout);
    let _ = write!(
        text,
        "/// Offsets in `{}` of `{}`.
#[allow(dead_code, clippy::module_inception, clippy::too_many_arguments)]
{public} mod {name} {{
",
        layout.name, block.input
    );
    let support = &out.names.support;
    for item in [LEAF, LOOKUP_ERROR] {
        let _ = writeln!(text, "    use super::{support}::{item};");
    }
    text.push('\n');
    let mut constant = |name: &str, ty: &str, value: u64, about: &str| {
        let _ = writeln!(text, "    /// {about}");
        let _ = writeln!(text, "    {public} const {name}: {ty} = {value};");
    };
    let size = match layout.split_tail().1.is_some() {
        true => "Bytes a buffer must hold, with one element in the runtime-sized tail.",
        false => "Bytes a buffer must hold.",
    };
    constant("SIZE", "usize", crate::runtime_tail::buffer_size(layout).unwrap_or(0), size);
    constant("DATA_SIZE", "usize", layout.data_size.unwrap_or(0), "End of the last member.");
    if let Some(group) = layout.group {
        constant("GROUP", "u32", group.into(), "Descriptor set or bind group.");
    }
    if let Some(binding) = layout.binding {
        constant("BINDING", "u32", binding.into(), "Binding.");
    }
    if let Some(count) = fixed_elements(&layout.count).filter(|_| !layout.count.is_empty()) {
        constant("COUNT", "usize", count, "Blocks in the array; each is a buffer of its own.");
    }
    let mut scope = Scope::default();
    scope.reserve(OWN_ITEMS);
    // A line is left empty before the constants that follow a function, and before each function.
    let mut after_function = true;
    for leaf in &layout.leaves {
        let shown = leaf.ty.spelled(block.shader.language);
        let size = leaf.size.unwrap_or(0);
        let words = leaf.path.replace("[]", "").replace('.', "_");
        if leaf.dims.is_empty() {
            let name = free(&mut scope, screaming(&words), "_OFFSET");
            let offset = leaf.offset.unwrap_or(0);
            let line = if std::mem::take(&mut after_function) { "\n" } else { "" };
            let _ = writeln!(text, "{line}    /// `{}`: `{shown}`, size {size}.", leaf.path);
            let _ = writeln!(text, "    {public} const {name}: usize = {offset};");
        } else {
            let name = free(&mut scope, snake(&words), "_offset");
            let of = indices(leaf.dims.len());
            let shown_path = with_indices(&leaf.path, &of);
            let _ = writeln!(text, "\n    /// `{shown_path}`: `{shown}`, size {size}.");
            function(text, public, &name, leaf, &of);
            after_function = true;
        }
    }
    let head = format!("    {public} fn lookup");
    let _ = writeln!(
        text,
        "\n    /// The leaf of that path, its offset that of the element asked for."
    );
    let returns = format!(" -> Result<{LEAF}, {LOOKUP_ERROR}> {{");
    signature(text, "", &head, &["path: &str".to_string()], &returns);
    let _ = writeln!(text, "        super::{support}::look_up(&LEAVES, path)\n    }}");
    rows(out, text, block);
    text.push_str("}\n\n");
}

/// Claims a name, with `suffix` if it collides with one of [`OWN_ITEMS`].
fn free(scope: &mut Scope, wanted: String, suffix: &str) -> String {
    if OWN_ITEMS.contains(&wanted.as_str()) {
        scope.take(&format!("{wanted}{suffix}"))
    } else {
        scope.take(&wanted)
    }
}

/// A path with index names: `data[i].color`.
fn with_indices(path: &str, names: &[String]) -> String {
    let mut parts = path.split("[]");
    let mut shown = parts.next().unwrap_or("").to_string();
    for (part, name) in parts.zip(names) {
        let _ = write!(shown, "[{name}]{part}");
    }
    shown
}

fn function(text: &mut Text, public: &str, name: &str, leaf: &Leaf, indices: &[String]) {
    let parameters: Vec<String> = indices.iter().map(|i| format!("{i}: usize")).collect();
    signature(text, "    ", &format!("{public} const fn {name}"), &parameters, " -> usize {");
    // An `assert!` in a `const fn` also fails at compile time, where the index is constant. The
    // length of a runtime-sized array is not known here.
    for (index, len) in indices.iter().zip(&leaf.dims) {
        if let Some(len) = fixed(len) {
            let _ = writeln!(text, "        assert!({index} < {len});");
        }
    }
    let offset = leaf.offset.filter(|offset| *offset > 0);
    // offset + i * stride + j * stride …, without what is zero or one.
    let terms: Vec<String> = indices
        .iter()
        .zip(&leaf.strides)
        .map(|(index, stride)| match stride {
            1 => index.clone(),
            _ => format!("{index} * {stride}"),
        })
        .chain(offset.map(|offset| offset.to_string()))
        .collect();
    let sum = terms.join(" + ");
    // The expression is indented by 8 columns.
    let sum = match 8 + sum.len() <= text.width {
        true => sum,
        false => terms.join("\n            + "),
    };
    let _ = writeln!(text, "        {sum}\n    }}");
}

fn rows(out: &Printer<'_>, text: &mut Text, block: &PlannedBlock<'_>) {
    let public = out.visibility();
    let mut leaves: Vec<&Leaf> = block.layout.leaves.iter().collect();
    // The order of `look_up`'s binary search: by bytes, since it compares paths without their
    // indices, which the paths of leaves do not have.
    leaves.sort_by(|a, b| a.path.cmp(&b.path));
    let count = leaves.len();
    text.push_str("\n    /// Every leaf, sorted by path.\n");
    let head = format!("    {public} static LEAVES: [{LEAF}; {count}] = [");
    match leaves[..] {
        [] => {
            let _ = writeln!(text, "{head}];");
        }
        // rustfmt keeps the brackets on the lines of a single element.
        [one] => {
            text.push_str(&head);
            row(text, "    ", one, block);
            text.push_str("];\n");
        }
        [..] => {
            let _ = writeln!(text, "{head}");
            for leaf in leaves {
                text.push_str("        ");
                row(text, "        ", leaf, block);
                text.push_str(",\n");
            }
            text.push_str("    ];\n");
        }
    }
}

fn row(text: &mut Text, indent: &str, leaf: &Leaf, block: &PlannedBlock<'_>) {
    let dims: Vec<String> = leaf.dims.iter().map(|len| format!("{:?}", fixed(len))).collect();
    let strides: Vec<String> = leaf.strides.iter().map(u64::to_string).collect();
    let width = text.width;
    let _ = write!(
        text,
        "{LEAF} {{
{indent}    path: {:?},
{indent}    ty: {:?},
{indent}    offset: {},
{indent}    size: {},
{indent}    dims: {},
{indent}    strides: {},
{indent}    matrix_stride: {:?},
{indent}    row_major: {},
{indent}}}",
        leaf.path,
        leaf.ty.spelled(block.shader.language).to_string(),
        leaf.offset.unwrap_or(0),
        leaf.size.unwrap_or(0),
        slice(&dims, &format!("{indent}    "), Items::OneALine, width),
        slice(&strides, &format!("{indent}    "), Items::Filled, width),
        leaf.matrix_stride,
        leaf.row_major,
    );
}

/// Prints what the tables of all blocks share.
pub(super) fn shared(out: &Printer<'_>, text: &mut Text) {
    leaf_types(out, text);
    look_up(text);
}

/// Prints the type of a leaf and the error type of lookups.
fn leaf_types(out: &Printer<'_>, text: &mut Text) {
    let public = out.visibility();
    let (leaf, error) = (LEAF, LOOKUP_ERROR);
    let _ = write!(
        text,
        "/// A scalar, vector or matrix of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(dead_code)]
{public} struct {leaf} {{
    /// Its name: `data[].color`.
    {public} path: &'static str,
    /// Its type as the shader spells it.
    {public} ty: &'static str,
    /// Bytes from the start of the block.
    {public} offset: usize,
    /// Bytes of one element.
    {public} size: usize,
    /// Elements of each array on the way, outermost first; as many as the buffer holds if `None`.
    {public} dims: &'static [Option<usize>],
    /// Bytes from one element to the next in each of those arrays.
    {public} strides: &'static [usize],
    /// Bytes from one column (row) of a matrix to the next.
    {public} matrix_stride: Option<usize>,
    /// Whether a matrix is stored by rows.
    {public} row_major: bool,
}}

/// Why a path names no leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(dead_code)]
{public} enum {error} {{
    /// The block has no leaf of that name.
    Unknown,
    /// An index is not below the number of elements.
    OutOfRange {{
        /// Which of the indices, from 0.
        dimension: usize,
        /// The index.
        index: usize,
        /// The number of elements.
        len: usize,
    }},
}}

impl core::fmt::Display for {error} {{
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {{
        match self {{
            Self::Unknown => write!(f, \"the block has no leaf of that name\"),
            Self::OutOfRange {{
                dimension,
                index,
                len,
            }} => {{
                write!(
                    f,
                    \"index {{index}} of dimension {{dimension}} is not below {{len}}\"
                )
            }}
        }}
    }}
}}

impl core::error::Error for {error} {{}}

"
    );
}

/// Prints the function that finds the leaf of a path.
fn look_up(text: &mut Text) {
    let (leaf, error) = (LEAF, LOOKUP_ERROR);
    text.push_str(
        "/// The leaf of a path among leaves sorted by theirs. An empty index means the first element.
#[allow(dead_code)]
",
    );
    let parameters = [format!("leaves: &[{leaf}]"), "path: &str".to_string()];
    let returns = format!(" -> Result<{leaf}, {error}> {{");
    signature(text, "", "pub(super) fn look_up", &parameters, &returns);
    let _ = write!(
        text,
        "    // A path without what stands in its brackets.
    fn pattern(path: &str) -> impl Iterator<Item = u8> + '_ {{
        let mut inside = false;
        path.bytes().filter(move |byte| {{
            let bracket = matches!(byte, b'[' | b']');
            let keep = bracket || !inside;
            inside = *byte == b'[' || inside && !bracket;
            keep
        }})
    }}
    let at = match leaves.binary_search_by(|leaf| pattern(leaf.path).cmp(pattern(path))) {{
        Ok(at) => at,
        Err(_) => return Err({error}::Unknown),
    }};
    let mut leaf = leaves[at];
    for (dimension, rest) in path.split('[').skip(1).enumerate() {{
        let digits = rest.split(']').next().unwrap_or(\"\");
        if digits.bytes().any(|digit| !digit.is_ascii_digit()) {{
            return Err({error}::Unknown);
        }}
        let index = match digits {{
            \"\" => 0,
            _ => digits.parse().unwrap_or(usize::MAX),
        }};
        let offset = index
            .checked_mul(leaf.strides[dimension])
            .and_then(|bytes| bytes.checked_add(leaf.offset));
        match (offset, leaf.dims[dimension].unwrap_or(usize::MAX)) {{
            (Some(offset), len) if index < len => leaf.offset = offset,
            (_, len) => {{
                return Err({error}::OutOfRange {{
                    dimension,
                    index,
                    len,
                }});
            }}
        }}
    }}
    Ok(leaf)
}}

"
    );
}
