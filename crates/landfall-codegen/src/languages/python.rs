//! Layouts as a Python module: a NumPy `dtype` for each structure and block, with its offsets.

use std::fmt::Write as _;

use rustc_hash::FxHashSet;

use crate::assertions;
use crate::c::names::snake;
use crate::language::{CodeOptions, CodeOutput, OutputLanguage};
use crate::model::{
    Element, Member, MemberType, Model, Naming, Placement, Structure, Tail, comment, free, header,
    listed,
};
use landfall_layout::ShaderLayout;
use landfall_layout::shape::{Scalar, ScalarKind};

/// Python with NumPy.
pub const PYTHON: OutputLanguage = OutputLanguage {
    name: "python",
    title: "Python",
    about: "A Python module of NumPy data types, offsets checked on import",
    options: &["--prefix"],
    write,
    assert: assertions::none,
};

const NAMING: Naming = Naming {
    reserved: "False None True and as assert async await break class continue def del elif else \
        except finally for from global if import in is lambda nonlocal not or pass raise return \
        try while with yield match case type print max len np ImportError __all__ __name__ __file__ \
        __doc__ __builtins__ _structure _padded _allocate",
    types: "",
    members: "",
    is_reserved: |_| false,
};

const SUPPORT: &str = r#"import numpy as np


def _structure(size, members):
    """A structure of `size` bytes; a member has a name, format, offset and size in bytes."""
    dtype = np.dtype(
        {
            "names": [member[0] for member in members],
            "formats": [member[1] for member in members],
            "offsets": [member[2] for member in members],
            "itemsize": size,
        }
    )
    for name, _, offset, bytes_of in members:
        found, at = dtype.fields[name][:2]
        if (found.itemsize, at) != (bytes_of, offset):
            raise ImportError(
                f"`{name}` has {found.itemsize} bytes at {at}, in the shader {bytes_of} at {offset}"
            )
    if dtype.itemsize != size:
        raise ImportError(f"a structure has {dtype.itemsize} bytes, in the shader {size}")
    return dtype


def _padded(element, stride):
    """An element of an array with padding up to the next one."""
    return np.dtype(
        {"names": ["value"], "formats": [element], "offsets": [0], "itemsize": stride}
    )


def _allocate(head, element, offset, size, n):
    """A zeroed buffer of `size` bytes, and views of its head and of `n` elements behind it."""
    buffer = np.zeros(size, np.uint8)
    front = np.ndarray((), head, buffer) if head.itemsize else None
    tail = np.ndarray((n,) + element.shape, element.base, buffer, offset)
    return buffer, front, tail
"#;

fn write(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    let model = Model::new(shaders, NAMING, &options.prefix, Placement::Contiguous, PYTHON.title);
    let mut taken: FxHashSet<String> = model.structures.iter().map(|s| s.name.clone()).collect();
    // All names of the module are one namespace in Python.
    taken.extend(NAMING.reserved.split_whitespace().map(str::to_string));
    let mut text = header(shaders, "#", &["Needs NumPy 1.20."]);
    text.push('\n');
    text.push_str(SUPPORT);
    for structure in &model.structures {
        print(&model, structure, &mut taken, &mut text);
    }
    let constants = model.constants.iter().filter(|(name, _)| taken.insert(name.clone()));
    for (at, (name, value)) in constants.enumerate() {
        if at == 0 {
            text.push_str("\n\n# Constants of the shaders, by which they give lengths.\n");
        }
        let _ = writeln!(text, "{name} = {value}");
    }
    CodeOutput { text, diagnostics: model.diagnostics }
}

fn print(model: &Model, structure: &Structure, taken: &mut FxHashSet<String>, text: &mut String) {
    let Structure { name, size, .. } = structure;
    text.push_str("\n\n");
    comment("#", &structure.comment, "", text);
    let _ =
        writeln!(text, "# `{}`: {size} bytes, {}", structure.shader_name, structure.rules.name());
    let _ = writeln!(text, "{name} = _structure(\n    {size},\n    [");
    for member in &structure.members {
        comment("#", &member.comment, "        ", text);
        let Member { shader_name, shader_type, offset, ty, .. } = member;
        let format = format(model, ty);
        let bytes = ty.whole();
        let _ = writeln!(
            text,
            "        (\"{shader_name}\", {format}, {offset}, {bytes}),  # {shader_type}"
        );
    }
    text.push_str("    ],\n)\n");
    let upper = snake(name).to_ascii_uppercase();
    let constant = free(format!("{upper}_SIZE"), taken);
    let _ = writeln!(text, "{constant} = {size}");
    let offsets: Vec<String> = structure
        .all_members()
        .map(|(member, _)| format!("\"{}\": {}", member.shader_name, member.offset))
        .collect();
    let constant = free(format!("{upper}_OFFSETS"), taken);
    let _ = writeln!(text, "{constant} = {{{}}}", offsets.join(", "));
    let strides: Vec<String> = structure
        .strides()
        .map(|(member, strides)| format!("\"{}\": {}", member.shader_name, tuple(&strides)))
        .collect();
    let constant = free(format!("{upper}_STRIDES"), taken);
    let _ = writeln!(text, "{constant} = {{{}}}", strides.join(", "));
    if let Some(tail) = &structure.tail {
        print_tail(model, structure, tail, taken, text);
    }
}

/// The type of an element of the tail, and functions that size and allocate a buffer.
fn print_tail(
    model: &Model,
    structure: &Structure,
    tail: &Tail,
    taken: &mut FxHashSet<String>,
    text: &mut String,
) {
    let Structure { name, size, .. } = structure;
    let Tail { member, stride, sizes } = tail;
    let lower = snake(name).to_ascii_lowercase();
    let element = free(format!("{name}Tail"), taken);
    let size_for = free(format!("{lower}_size_for"), taken);
    let allocate = free(format!("{lower}_allocate"), taken);
    let mut ty = format(model, &member.ty);
    // The runtime-sized dimension is not in `member.ty`, and its stride may be longer, too.
    if member.ty.whole() != *stride {
        ty = format!("_padded({ty}, {stride})");
    }
    text.push('\n');
    comment("#", &member.comment, "", text);
    let _ = write!(
        text,
        "# One element of `{}`: offset {size}, stride {stride}
{element} = np.dtype({ty})
if {element}.itemsize != {stride}:
    raise ImportError(f\"an element has {{{element}.itemsize}} bytes, in the shader {stride}\")


def {size_for}(n):
    \"\"\"Bytes of a buffer in which a shader counts `n` elements of `{shader}`; at least {least}.\"\"\"
    return {bytes}


def {allocate}(n):
    \"\"\"A zeroed buffer for `n` elements, a view of `{name}` in it or None, and one of them.\"\"\"
    return _allocate({name}, {element}, {size}, {size_for}(n), n)
",
        member.shader_name,
        shader = member.shader_name,
        least = sizes.least,
        bytes = tail
            .size(&format!("max({size} + n * {stride}, {})", sizes.least))
            .replace(" / ", " // "),
    );
}

/// The NumPy format of a member.
fn format(model: &Model, ty: &MemberType) -> String {
    let (mut element, mut shape, mut size) = match ty.element {
        Element::Scalar(scalar) => (quoted(scalar), vec![], u64::from(scalar.width)),
        Element::Vector { scalar, rows } => (quoted(scalar), vec![u64::from(rows)], ty.size),
        Element::Matrix(matrix) => {
            // The columns of a matrix (or rows) are the innermost dimension of an array of its
            // vectors.
            let components = u64::from(matrix.stored().1);
            let size = components * u64::from(matrix.scalar.width);
            (quoted(matrix.scalar), vec![components], size)
        }
        Element::Structure(at) => (model.structures[at].name.clone(), vec![], ty.size),
    };
    let columns = match ty.element {
        Element::Matrix(matrix) => Some((u64::from(matrix.stored().0), matrix.stride)),
        Element::Scalar(_) | Element::Vector { .. } | Element::Structure(_) => None,
    };
    let dims = ty.dims.iter().map(|dim| (dim.len, dim.stride)).chain(columns);
    // From the innermost dimension outwards: an element shorter than its stride gets padding, and
    // what is within becomes one format.
    for (len, stride) in dims.collect::<Vec<_>>().into_iter().rev() {
        if size != stride {
            element = format!("_padded({}, {stride})", shaped(&element, &shape));
            shape.clear();
        }
        shape.insert(0, len);
        size = len * stride;
    }
    shaped(&element, &shape)
}

fn tuple(numbers: &[u64]) -> String {
    match numbers {
        [one] => format!("({one},)"),
        _ => format!("({})", listed(numbers)),
    }
}

fn shaped(element: &str, shape: &[u64]) -> String {
    match shape {
        [] => element.to_string(),
        _ => format!("({element}, {})", tuple(shape)),
    }
}

/// NumPy's little-endian type of a scalar; of those that it does not have, the bits.
fn quoted(scalar: Scalar) -> String {
    let kind = match (scalar.kind, scalar.width) {
        (ScalarKind::Sint, _) => 'i',
        (ScalarKind::Float, 2 | 4 | 8) => 'f',
        // A `bool` of a buffer is a 32-bit integer.
        _ => 'u',
    };
    format!("\"<{kind}{}\"", scalar.width)
}
