//! Layouts as an Odin package: structures with explicit padding, sizes and offsets checked at
//! compile time.

use std::fmt::Write as _;

use rustc_hash::FxHashSet;

use crate::language::{CodeOptions, CodeOutput, OutputLanguage};
use crate::model::{
    Element, Member, MemberType, Model, Naming, Placement, Structure, Tail, comment, free, gaps,
    header, numbered_type,
};
use landfall_layout::ShaderLayout;
use landfall_layout::shape::{Scalar, ScalarKind};

/// Odin.
pub const ODIN: OutputLanguage = OutputLanguage {
    name: "odin",
    title: "Odin",
    about: "An Odin package of structures, offsets checked at compile time",
    options: &["--prefix"],
    write,
};

const NAMING: Naming = Naming {
    reserved: "asm auto_cast bit_field bit_set break case cast context continue defer distinct do \
        dynamic else enum fallthrough for foreign if import in map matrix not_in or_break \
        or_continue or_else or_return package proc return struct switch transmute typeid union \
        using when where any bool b8 b16 b32 b64 byte rune string cstring string16 cstring16 \
        uintptr rawptr int uint i8 u8 i16 u16 i32 u32 i64 u64 i128 u128 f16 f32 f64 complex32 \
        complex64 complex128 quaternion64 quaternion128 quaternion256 true false nil size_of \
        align_of offset_of type_of len cap max min abs clamp mem raw_data slice Padded layouts T \
        N",
    types: "n bytes least",
    members: "",
    is_reserved: |name| {
        // `i16le`, `u32be`, `f64le`.
        let bare = name.strip_suffix("le").or_else(|| name.strip_suffix("be"));
        bare.and_then(|name| name.strip_prefix(['i', 'u', 'f']))
            .is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|c| c.is_ascii_digit()))
    },
};

const SUPPORT: &str = "
package layouts

// An element of an array with padding up to the next one.
Padded :: struct($T: typeid, $N: int) {
\tvalue: T,
\t_: [N]u8,
}
";

fn write(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    let model = Model::new(shaders, NAMING, &options.prefix, Placement::Contiguous, ODIN.title);
    let mut taken: FxHashSet<String> = model.structures.iter().map(|s| s.name.clone()).collect();
    taken.extend(NAMING.reserved.split_whitespace().map(str::to_string));
    let mut text = header(shaders, "//", &[]);
    text.push_str(SUPPORT);
    for structure in &model.structures {
        print(&model, structure, &mut taken, &mut text);
    }
    CodeOutput { text, diagnostics: model.diagnostics }
}

fn print(model: &Model, structure: &Structure, taken: &mut FxHashSet<String>, text: &mut String) {
    let Structure { name, size, .. } = structure;
    let upto = if structure.tail.is_some() { " before its runtime-sized tail" } else { "" };
    text.push('\n');
    comment("//", &structure.comment, "", text);
    let shader = &structure.shader_name;
    let _ = writeln!(text, "// `{shader}`: {size} bytes{upto}, {}.", structure.rules.name());
    let packed = if structure.packed { " #packed" } else { "" };
    let _ = writeln!(text, "{name} :: struct{packed} {{");
    let mut members = structure.members.iter();
    for gap in gaps(structure) {
        if let Some((_, bytes)) = gap {
            let _ = writeln!(text, "\t_: [{bytes}]u8,");
        }
        if let Some(member) = members.next() {
            comment("//", &member.comment, "\t", text);
            let Member { name, shader_type, offset, ty, .. } = member;
            let ty = spelled(model, ty);
            let _ = writeln!(text, "\t{name}: {ty}, // {shader_type}, offset {offset}");
        }
    }
    text.push_str("}\n");
    let _ = writeln!(text, "#assert(size_of({name}) == {size})");
    for Member { name: field, offset, .. } in &structure.members {
        let _ = writeln!(text, "#assert(offset_of({name}, {field}) == {offset})");
    }
    for member in structure.members.iter().filter(|member| !member.ty.dims.is_empty()) {
        let constant = free(format!("{name}_{}_STRIDES", member.name), taken);
        let dims = &member.ty.dims;
        let list: Vec<String> = dims.iter().map(|dim| dim.stride.to_string()).collect();
        let _ = writeln!(text, "{constant} :: [{}]int{{{}}}", dims.len(), list.join(", "));
    }
    if let Some(tail) = &structure.tail {
        print_tail(model, structure, tail, taken, text);
    }
}

fn print_tail(
    model: &Model,
    structure: &Structure,
    tail: &Tail,
    taken: &mut FxHashSet<String>,
    text: &mut String,
) {
    let Tail { member, stride, sizes } = tail;
    let Structure { name, size: offset, .. } = structure;
    let least = sizes.least;
    let bytes = tail.size("least");
    let element = free(format!("{name}_Tail"), taken);
    let start = free(format!("{name}_TAIL_OFFSET"), taken);
    let size_for = free(format!("{name}_size_for"), taken);
    let elements = free(format!("{name}_{}", member.name), taken);
    let mut ty = spelled(model, &member.ty);
    if member.ty.whole() != *stride {
        ty = padded(&ty, member.ty.whole(), *stride);
    }
    let shader = &member.shader_name;
    text.push('\n');
    comment("//", &member.comment, "", text);
    let _ = write!(
        text,
        "// One element of `{shader}`: {}, offset {offset}, stride {stride}.
{element} :: {ty}
{start} :: {offset}
#assert(size_of({element}) == {stride})

// Bytes of a buffer in which a shader counts `n` elements of `{shader}`; at least {least}.
{size_for} :: proc \"contextless\" (n: int) -> int {{
\tleast := max({offset} + n * {stride}, {least})
\treturn {bytes}
}}

// The elements of `{shader}` that a shader counts in `bytes`.
{elements} :: proc \"contextless\" (bytes: []u8) -> []{element} {{
\tn := max(len(bytes) - {offset}, 0) / {stride}
\tif n == 0 {{
\t\treturn nil
\t}}
\treturn ([^]{element})(&bytes[{offset}])[:n]
}}
",
        member.shader_type,
    );
}

/// The Odin type of a member.
fn spelled(model: &Model, ty: &MemberType) -> String {
    let (mut text, mut size) = match ty.element {
        Element::Scalar(scalar) => (component(scalar).to_string(), ty.size),
        Element::Vector { scalar, rows } => (format!("[{rows}]{}", component(scalar)), ty.size),
        Element::Matrix(matrix) => {
            let (vectors, lanes) = matrix.stored();
            let vector = format!("[{lanes}]{}", component(matrix.scalar));
            let bytes = u64::from(lanes) * u64::from(matrix.scalar.width);
            (format!("[{vectors}]{}", padded(&vector, bytes, matrix.stride)), ty.size)
        }
        Element::Structure(at) => (model.structures[at].name.clone(), ty.size),
    };
    for dim in ty.dims.iter().rev() {
        text = format!("[{}]{}", dim.len, padded(&text, size, dim.stride));
        size = dim.len * dim.stride;
    }
    text
}

fn padded(element: &str, size: u64, stride: u64) -> String {
    match stride - size {
        0 => element.to_string(),
        bytes => format!("Padded({element}, {bytes})"),
    }
}

/// The Odin type of a scalar.
fn component(scalar: Scalar) -> &'static str {
    match scalar.kind {
        ScalarKind::Bool => "b32",
        _ => numbered_type(scalar),
    }
}
