//! Layouts as C#: structures whose fields have explicit offsets, and a check of them.

mod members;
mod support;

use std::fmt::Write as _;

use crate::assertions;
use crate::language::{CodeOptions, CodeOutput, OutputLanguage};
use crate::model::{Member, Model, Naming, Placement, Structure, Tail, comment, header, listed};
use landfall_layout::ShaderLayout;
use support::Support;

/// C#.
pub const CSHARP: OutputLanguage = OutputLanguage {
    name: "csharp",
    title: "C#",
    about: "C# structures with explicit offsets, and a method that checks them",
    options: &["--prefix"],
    write,
    assert: assertions::csharp,
};

const NAMING: Naming = Naming {
    reserved: "abstract as base bool break byte case catch char checked class const continue \
        decimal default delegate do double else enum event explicit extern false finally fixed \
        float for foreach goto if implicit in int interface internal is lock long namespace new \
        null object operator out override params private protected public readonly ref return \
        sbyte sealed short sizeof stackalloc static string struct switch this throw true try \
        typeof uint ulong unchecked unsafe ushort using virtual void volatile while add alias and \
        async await dynamic file get global init managed nint not notnull nuint or partial record \
        remove required scoped select set unmanaged value var when where with yield System Math \
        Marshal IntPtr StructLayout LayoutKind FieldOffset IndexOutOfRangeException \
        InvalidOperationException FieldOffsetAttribute StructLayoutAttribute",
    types: "self to at bytes n i what actual expected value column row columnPlace rowPlace x y z \
        w X Y Z W Bits i0 i1 i2 i3 i4 i5 i6 i7",
    members: "ByteSize Offsets Strides CopyTo ToBytes Check SizeFor TailOffset TailStride Equals \
        GetHashCode GetType ToString MemberwiseClone ReferenceEquals Finalize",
    is_reserved: |_| false,
};

fn write(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    let model = Model::new(shaders, NAMING, &options.prefix, Placement::Offsets, CSHARP.title);
    let mut support = Support::new(&model, &options.prefix);
    let mut structures = String::new();
    for structure in &model.structures {
        print(&model, structure, &mut support, &mut structures);
    }
    let mut text = header(
        shaders,
        "//",
        &["Needs C# 7.3 with unsafe code allowed, and a little-endian machine."],
    );
    text.push_str("\nusing System;\nusing System.Runtime.InteropServices;\n");
    if let [_, ..] = model.constants.as_slice() {
        let name = support.constants_class();
        let _ = writeln!(text, "\n// Constants of the shaders, by which they give lengths.");
        let _ = writeln!(text, "public static class {name}\n{{");
        for (name, value) in &model.constants {
            let _ = writeln!(text, "    public const uint {name} = {value};");
        }
        text.push_str("}\n");
    }
    text.push_str(&structures);
    text.push_str(&support.text());
    CodeOutput { text, diagnostics: model.diagnostics }
}

fn print(model: &Model, structure: &Structure, support: &mut Support, text: &mut String) {
    let Structure { name, size, .. } = structure;
    text.push('\n');
    comment("//", &structure.comment, "", text);
    let _ = writeln!(text, "// {}.", structure.about());
    // A block of a runtime-sized array alone has no structure, only functions on buffers.
    let only_tail = *size == 0;
    if only_tail {
        let _ = writeln!(text, "public static unsafe class {name}\n{{");
    } else {
        let _ = writeln!(
            text,
            "[StructLayout(LayoutKind.Explicit, Pack = 1, Size = {size})]\npublic unsafe struct \
             {name}\n{{"
        );
        let _ = writeln!(text, "    public const int ByteSize = {size};");
    }
    constants(structure, text);
    for member in &structure.members {
        text.push('\n');
        members::member(model, name, member, support, text);
    }
    if let Some(tail) = &structure.tail {
        print_tail(model, structure, tail, support, text);
    }
    if !only_tail {
        copies_and_check(model, structure, support, text);
    }
    text.push_str("}\n");
}

fn constants(structure: &Structure, text: &mut String) {
    let _ = writeln!(text, "\n    public static class Offsets\n    {{");
    for (member, _) in structure.all_members() {
        let _ = writeln!(text, "        public const int {} = {};", member.name, member.offset);
    }
    let _ = writeln!(text, "    }}\n\n    // Array strides in bytes, outermost first.");
    let _ = writeln!(text, "    public static class Strides\n    {{");
    for (member, strides) in structure.strides() {
        let (name, list) = (&member.name, listed(&strides));
        let _ = writeln!(text, "        public static readonly int[] {name} = {{ {list} }};");
    }
    text.push_str("    }\n");
}

fn print_tail(
    model: &Model,
    structure: &Structure,
    tail: &Tail,
    support: &mut Support,
    text: &mut String,
) {
    let Tail { member, stride, sizes } = tail;
    let least = sizes.least;
    let offset = structure.size;
    let bytes = tail.size(&format!("Math.Max({offset} + n * {stride}, {least})"));
    let _ = write!(
        text,
        "
    public const int TailOffset = {offset};
    public const int TailStride = {stride};

    // Bytes of a buffer in which a shader counts `n` elements of `{}`; at least {least}.
    public static long SizeFor(long n)
    {{
        return {bytes};
    }}

",
        member.shader_name
    );
    members::of_tail(model, member, *stride, support, text);
}

/// The methods that copy a structure, and the one that compares it with the shader.
fn copies_and_check(
    model: &Model,
    structure: &Structure,
    support: &mut Support,
    text: &mut String,
) {
    let Structure { name, size, .. } = structure;
    // `sizeof` is of the memory that `CopyTo` copies, `Marshal` of the offsets compared below. Both
    // are to agree with the shader.
    let _ = write!(
        text,
        "
    public void CopyTo(byte[] to, int at)
    {{
        fixed ({name}* self = &this)
        {{
            Marshal.Copy((IntPtr)self, to, at, ByteSize);
        }}
    }}

    public byte[] ToBytes()
    {{
        var to = new byte[ByteSize];
        CopyTo(to, 0);
        return to;
    }}

    // Throws if a size or offset is not the shader's.
    public static void Check()
    {{
        {check}.Same(\"size of {name}\", sizeof({name}), {size});
        {check}.Same(\"marshalled size of {name}\", Marshal.SizeOf(typeof({name})), {size});
",
        check = support.check(),
    );
    let check = support.check();
    // Arrays are methods, which have no offset to compare.
    for Member { name: field, offset, ty, .. } in &structure.members {
        if ty.dims.is_empty() {
            let actual = format!("(int)Marshal.OffsetOf(typeof({name}), \"{field}\")");
            let _ = writeln!(
                text,
                "        {check}.Same(\"offset of {field} in {name}\", {actual}, {offset});"
            );
        }
        let element = members::spelled(model, ty, support);
        let _ = writeln!(
            text,
            "        {check}.Same(\"size of {field} in {name}\", sizeof({element}), {});",
            ty.size
        );
    }
    text.push_str("    }\n");
}
