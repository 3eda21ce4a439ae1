//! Layouts as Zig: extern structures with explicit padding, sizes and offsets checked at compile
//! time.

use std::fmt::Write as _;

use crate::assertions;
use crate::language::{CodeOptions, CodeOutput, OutputLanguage};
use crate::model::{
    Element, Member, MemberType, Model, Naming, Placement, Structure, Tail, comment, gaps, header,
    listed,
};
use crate::scalar_names::ScalarNames;
use landfall_layout::ShaderLayout;

/// Zig.
pub const ZIG: OutputLanguage = OutputLanguage {
    name: "zig",
    title: "Zig",
    about: "Zig extern structures, offsets checked at compile time",
    options: &["--prefix"],
    write,
    assert: assertions::zig,
};

const NAMING: Naming = Naming {
    reserved: "addrspace align allowzero and anyframe anytype asm async await break callconv catch \
        comptime const continue defer else enum errdefer error export extern false fn for if inline \
        linksection noalias noinline nosuspend null opaque or orelse packed pub resume return \
        struct suspend switch test threadlocal true try type undefined union unreachable \
        usingnamespace var volatile while anyerror anyopaque bool comptime_float comptime_int \
        isize usize noreturn void c_char c_int c_uint c_long c_ulong c_short c_ushort c_longlong \
        c_ulonglong c_longdouble f16 f32 f64 f80 f128 Padded T stride",
    types: "bytes n rest wanted Tail strides size_for tail_offset tail_stride value",
    members: "size_for tail_offset tail_stride Tail strides",
    is_reserved: |name| {
        // `u8`, `i7`: integers of any width.
        name.strip_prefix(['i', 'u'])
            .is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|c| c.is_ascii_digit()))
    },
};

const SCALARS: ScalarNames = ScalarNames::NUMBERED;

const SUPPORT: &str = "
/// An element of an array with padding up to the next one.
fn Padded(comptime T: type, comptime stride: usize) type {
    return extern struct {
        value: T,
        _padding: [stride - @sizeOf(T)]u8 = @splat(0),
    };
}
";

fn write(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    let model = Model::new(shaders, NAMING, &options.prefix, Placement::Contiguous, ZIG.title);
    let mut text = header(shaders, "//", &["Needs Zig 0.14."]);
    for (name, value) in &model.constants {
        let _ = writeln!(text, "\n/// A constant of the shader, by which it gives lengths.");
        let _ = writeln!(text, "pub const {name}: usize = {value};");
    }
    text.push_str(SUPPORT);
    for structure in &model.structures {
        print(&model, structure, &mut text);
    }
    CodeOutput { text, diagnostics: model.diagnostics }
}

fn print(model: &Model, structure: &Structure, text: &mut String) {
    let Structure { name, size, align, .. } = structure;
    text.push('\n');
    comment("///", &structure.comment, "", text);
    let _ = writeln!(text, "/// {}.", structure.about());
    let kind = if structure.size == 0 { "struct" } else { "extern struct" };
    let _ = writeln!(text, "pub const {name} = {kind} {{");
    let mut members = structure.members.iter();
    let taken: Vec<&str> = structure.all_members().map(|(m, _)| m.name.as_str()).collect();
    // Between the fields in order, each with the padding before it; the last gap stands behind all.
    for gap in gaps(structure) {
        if let Some((offset, bytes)) = gap {
            let mut padding = format!("_padding_{offset}");
            while taken.contains(&padding.as_str()) {
                padding.push('_');
            }
            let _ = writeln!(text, "    {padding}: [{bytes}]u8 = @splat(0),");
        }
        if let Some(member) = members.next() {
            field(model, member, *align, text);
        }
    }
    let strides: String = structure
        .members
        .iter()
        .filter(|member| !member.ty.dims.is_empty())
        .map(|member| {
            let list = listed(&member.strides(None));
            format!("        pub const {} = [_]usize{{ {list} }};\n", member.name)
        })
        .collect();
    if !strides.is_empty() {
        let _ = write!(
            text,
            "\n    /// Array strides in bytes, outermost first.\n    pub const strides = struct \
             {{\n{strides}    }};\n"
        );
    }
    if let Some(tail) = &structure.tail {
        print_tail(model, structure, tail, text);
    }
    text.push_str("};\n");
    let _ = writeln!(text, "\ncomptime {{");
    for member in &structure.members {
        let Member { name: field, offset, .. } = member;
        let actual = format!("@offsetOf({name}, \"{field}\")");
        check(&actual, *offset, &format!("offset of {field} in {name}"), text);
    }
    check(&format!("@sizeOf({name})"), *size, &format!("size of {name}"), text);
    if let Some(tail) = &structure.tail {
        let actual = format!("@sizeOf({name}.Tail)");
        check(&actual, tail.stride, &format!("size of an element of {}", tail.member.name), text);
    }
    text.push_str("}\n");
}

fn check(actual: &str, expected: u64, what: &str, text: &mut String) {
    let _ = writeln!(
        text,
        "    if ({actual} != {expected}) @compileError(\"{what} is not {expected}, as in the shader\");"
    );
}

fn field(model: &Model, member: &Member, align: u64, text: &mut String) {
    comment("///", &member.comment, "    ", text);
    let Member { name, shader_type, offset, ty, .. } = member;
    // A type that Zig would align further than the structure has its alignment lowered.
    let lowered =
        if model.natural_align(ty) > align { format!(" align({align})") } else { String::new() };
    let ty = spelled(model, ty);
    let _ = writeln!(text, "    /// {shader_type}, offset {offset}");
    let _ = writeln!(text, "    {name}: {ty}{lowered},");
}

fn print_tail(model: &Model, structure: &Structure, tail: &Tail, text: &mut String) {
    let Tail { member, stride, sizes } = tail;
    let shader_type = &member.shader_type;
    // A type of the file must not be shadowed.
    let mut name = member.name.clone();
    let is_taken = |name: &String| {
        model.structures.iter().any(|other| other.name == *name)
            || structure.members.iter().any(|other| other.name == *name)
            || model.constants.iter().any(|(constant, _)| *constant == *name)
            || ["bytes", "n", "rest", "wanted"].contains(&name.as_str())
    };
    while is_taken(&name) {
        name.push('_');
    }
    let offset = structure.size;
    let least = sizes.least;
    let bytes = tail.size("wanted");
    let mut element = spelled(model, &member.ty);
    if member.ty.whole() != *stride {
        element = format!("Padded({element}, {stride})");
    }
    let _ = write!(
        text,
        "
    pub const tail_offset: usize = {offset};
    pub const tail_stride: usize = {stride};
    /// One element of `{shader}`.
    pub const Tail = {element};

    /// Bytes of a buffer in which a shader counts `n` elements; at least {least}.
    pub fn size_for(n: usize) usize {{
        const wanted = @max({offset} + n * {stride}, {least});
        return {bytes};
    }}

",
        shader = member.shader_name,
    );
    comment("///", &member.comment, "    ", text);
    let _ = write!(
        text,
        "    /// {shader_type}, offset {offset}: the elements that a shader counts in `bytes`.
    pub fn {name}(bytes: []align(@alignOf(Tail)) u8) []Tail {{
        const rest: []align(@alignOf(Tail)) u8 = @alignCast(bytes[{offset}..]);
        return @as([*]Tail, @ptrCast(rest.ptr))[0 .. rest.len / {stride}];
    }}
"
    );
}

/// The Zig type of a member.
fn spelled(model: &Model, ty: &MemberType) -> String {
    let (mut text, mut size) = match ty.element {
        Element::Scalar(scalar) => (SCALARS.of(scalar).to_string(), ty.size),
        Element::Vector { scalar, rows } => (format!("[{rows}]{}", SCALARS.of(scalar)), ty.size),
        Element::Matrix(matrix) => {
            let (vectors, lanes) = matrix.stored();
            let mut vector = format!("[{lanes}]{}", SCALARS.of(matrix.scalar));
            if u64::from(lanes) * u64::from(matrix.scalar.width) != matrix.stride {
                vector = format!("Padded({vector}, {})", matrix.stride);
            }
            (format!("[{vectors}]{vector}"), ty.size)
        }
        Element::Structure(at) => (model.structures[at].name.clone(), ty.size),
    };
    // From the innermost dimension outwards: padding where the stride is longer than an element.
    for dim in ty.dims.iter().rev() {
        if size != dim.stride {
            text = format!("Padded({text}, {})", dim.stride);
        }
        text = format!("[{}]{text}", dim.len);
        size = dim.len * dim.stride;
    }
    text
}
