//! C# files, compiled by Mono's compiler without a warning and run.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use landfall_codegen::languages::CSHARP;

use super::{Block, Case, Leaf, hold, output_of, said, write_moved, write_shaders};
use crate::support::image::{Shape, TAIL};

/// Compiles files of a directory to a program.
fn compile(directory: &Path, files: &[&str], program: &str) {
    let mut mcs = Command::new("mcs");
    mcs.current_dir(directory).args(["-unsafe", "-langversion:7.2", "-warnaserror", "-nologo"]);
    output_of(mcs.arg(format!("-out:{program}")).args(files));
}

fn mono(directory: &Path, program: &str) -> Command {
    let mut command = Command::new("mono");
    command.arg(program).current_dir(directory);
    command
}

const SUPPORT: &str = "using System;
static class Program
{
    static System.IO.Stream output = Console.OpenStandardOutput();
    static void Set(ref float to, ulong k) { to = k + 1; }
    static void Set(ref double to, ulong k) { to = k + 1; }
    static void Set(ref int to, ulong k) { to = (int)(k + 1); }
    static void Set(ref uint to, ulong k) { to = (uint)(k + 1); }
    static void Set(ref long to, ulong k) { to = (long)(k + 1); }
    static void Set(ref ulong to, ulong k) { to = k + 1; }
    static void Set(ref short to, ulong k) { to = unchecked((short)(k % 65521 + 1)); }
    static void Set(ref ushort to, ulong k) { to = (ushort)(k % 65521 + 1); }
    static void Set(ref sbyte to, ulong k) { to = unchecked((sbyte)(k % 251 + 1)); }
    static void Set(ref byte to, ulong k) { to = (byte)(k % 251 + 1); }
    static void Set(ref Bool32 to, ulong k) { to = k % 3 == 0; }
    static void Write(byte[] bytes)
    {
        output.Write(BitConverter.GetBytes((ulong)bytes.Length), 0, 8);
        output.Write(bytes, 0, bytes.Length);
    }
";

fn program(case: &Case) -> String {
    let mut text = SUPPORT.to_string();
    if !case.output.text.contains("public struct Bool32") {
        text =
            text.replace("    static void Set(ref Bool32 to, ulong k) { to = k % 3 == 0; }\n", "");
    }
    for (number, Block { name, leaves, has_tail, .. }) in case.blocks.iter().enumerate() {
        let has_head = leaves.iter().any(|leaf| !leaf.is_in_tail());
        let size = match has_tail {
            true => format!("{name}.SizeFor({TAIL})"),
            false => format!("{name}.ByteSize"),
        };
        let _ = writeln!(
            text,
            "    static void Block{number}()\n    {{\n        ulong k = 0;\n        \
             var bytes = new byte[{size}];"
        );
        if has_head {
            let _ = writeln!(text, "        var block = default({name});");
        }
        for leaf in leaves {
            text.push_str(&fill(leaf, name));
        }
        if has_head {
            text.push_str("        block.CopyTo(bytes, 0);\n");
        }
        text.push_str("        Write(bytes);\n    }\n");
    }
    text.push_str("    static void Main()\n    {\n        Layouts.Check();\n");
    for number in 0..case.blocks.len() {
        let _ = writeln!(text, "        Block{number}();");
    }
    text.push_str("    }\n}\n");
    text
}

/// The statements that fill a leaf.
fn fill(leaf: &Leaf, block: &str) -> String {
    let Shape { columns, rows, width, .. } = Shape::of(&leaf.oracle);
    let mut text = String::from("        ");
    for (i, count) in leaf.counts().iter().enumerate() {
        let _ = write!(text, "for (long i{i} = 0; i{i} < {count}; i{i}++) ");
    }
    let mut at = if leaf.is_in_tail() { block.to_string() } else { "block".to_string() };
    let mut index = 0;
    for (segment, (name, dims)) in leaf.segments().iter().enumerate() {
        let mut list: Vec<String> = (index..index + dims).map(|i| format!("i{i}")).collect();
        index += dims;
        if segment == 0 && leaf.is_in_tail() {
            list.insert(0, "bytes".to_string());
        }
        let call = if *dims == 0 { String::new() } else { format!("({})", list.join(", ")) };
        let _ = write!(at, ".{name}{call}");
    }
    let statements = match (columns, rows) {
        (1, 1) => format!("Set(ref {at}, k++);"),
        (1, _) => ["X", "Y", "Z", "W"][..rows as usize]
            .iter()
            .map(|field| format!("Set(ref {at}.{field}, k++); "))
            .collect(),
        _ => {
            let number = if width == 8 { "double" } else { "float" };
            format!(
                "for (int c = 0; c < {columns}; c++) for (int r = 0; r < {rows}; r++) \
                 {{ {at}[c, r] = ({number})(k++ + 1); if ({at}[c, r] != k) throw new Exception(); }}"
            )
        }
    };
    let _ = writeln!(text, "{{ {statements} }}");
    text
}

#[test]
fn random_blocks_are_filled_where_glslang_reads_them() {
    hold(CSHARP, false, |directory, case| {
        super::write(directory, "blocks.cs", &case.output.text);
        super::write(directory, "main.cs", &program(case));
        compile(directory, &["blocks.cs", "main.cs"], "main.exe");
        output_of(&mut mono(directory, "main.exe"))
    });
}

#[test]
fn every_shader_of_this_repository_and_hostile_names_compile() {
    let directory = write_shaders(CSHARP, "cs");
    let main = "static class Program { static void Main() { Layouts.Check(); } }\n";
    super::write(&directory, "main.cs", main);
    compile(&directory, &["blocks.cs", "main.cs"], "blocks.exe");
    output_of(&mut mono(&directory, "blocks.exe"));
    let main = "static class Program { static void Main() { Words.Check(); } }\n";
    super::write(&directory, "main.cs", main);
    compile(&directory, &["hostile.cs", "main.cs"], "hostile.exe");
    output_of(&mut mono(&directory, "hostile.exe"));
}

#[test]
fn a_field_that_moved_fails_the_check_and_no_index_leaves_the_array() {
    let text = "layout(std430) buffer B { vec3 a; vec3 b; float w[2]; int t[]; };";
    let output = super::generate(CSHARP, &[&crate::c_header::lay_out("b.comp", text)]).text;
    let change = ("[FieldOffset(16)]", "[FieldOffset(20)]");
    let directory = write_moved(CSHARP, text, change, "moved.cs");
    let check = "static class Program { static void Main() { Layouts.Check(); } }\n";
    super::write(&directory, "main.cs", check);
    compile(&directory, &["moved.cs", "main.cs"], "moved.exe");
    let log = said(&mut mono(&directory, "moved.exe")).expect_err("`b` moved");
    assert!(log.contains("offset of b in B is 20, in the shader 16"), "{log}");

    let outside = "using System;
static class Program
{
    static void Refuses(Action what)
    {
        try { what(); } catch (IndexOutOfRangeException) { return; }
        throw new Exception(\"taken\");
    }
    static void Main()
    {
        var b = default(B);
        var bytes = new byte[B.SizeFor(3)];
        Refuses(() => { b.w(2) = 1; });
        Refuses(() => { b.w(-1) = 1; });
        Refuses(() => { B.t(bytes, 3) = 1; });
        Refuses(() => { B.t(new byte[0], 0) = 1; });
        B.t(bytes, 2) = 7;
        if (bytes.Length != B.TailOffset + 3 * B.TailStride || bytes[B.TailOffset + 8] != 7)
        {
            throw new Exception(\"elsewhere\");
        }
    }
}
";
    super::write(&directory, "b.cs", &output);
    super::write(&directory, "outside.cs", outside);
    compile(&directory, &["b.cs", "outside.cs"], "outside.exe");
    output_of(&mut mono(&directory, "outside.exe"));
}
