//! Zig files, compiled to an object and linked with a C program that prints the bytes.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use landfall_codegen::languages::ZIG;

use super::{Block, Case, Leaf, hold, installed, output_of, said, write_moved, write_shaders};
use crate::support::image::{Shape, TAIL};

/// Compiles a file of a directory to `code.o`.
fn zig(directory: &Path, file: &str) -> Command {
    let mut command = Command::new(installed("zig/ziglang/zig"));
    let cache = super::directory(ZIG, "cache");
    command.current_dir(directory).args(["build-obj", "-fPIC", "-femit-bin=code.o"]);
    command.arg("--cache-dir").arg(&cache).arg("--global-cache-dir").arg(&cache).arg(file);
    command
}

const SUPPORT: &str = "const blocks = @import(\"blocks.zig\");

fn isPadded(comptime T: type) bool {
    return @typeInfo(T) == .@\"struct\" and @hasField(T, \"value\") and @hasField(T, \"_padding\");
}

/// A pointer to what is in an element with padding.
fn into(p: anytype) if (isPadded(@TypeOf(p.*))) @TypeOf(&p.value) else @TypeOf(p) {
    return if (comptime isPadded(@TypeOf(p.*))) &p.value else p;
}

fn set(p: anytype, k: *u64, is_bool: bool) void {
    const T = @TypeOf(p.*);
    const n = k.*;
    k.* += 1;
    p.* = switch (T) {
        f32, f64 => @floatFromInt(n + 1),
        f16 => @bitCast(@as(u16, @intCast(n % 65521 + 1))),
        u32 => if (is_bool) @intFromBool(n % 3 == 0) else @intCast(n + 1),
        i32, i64, u64 => @intCast(n + 1),
        u16 => @intCast(n % 65521 + 1),
        i16 => @bitCast(@as(u16, @intCast(n % 65521 + 1))),
        u8 => @intCast(n % 251 + 1),
        i8 => @bitCast(@as(u8, @intCast(n % 251 + 1))),
        else => @compileError(\"no such type\"),
    };
}
";

fn program(case: &Case) -> String {
    let mut text = SUPPORT.to_string();
    for (number, Block { name, leaves, has_tail, .. }) in case.blocks.iter().enumerate() {
        let size = match has_tail {
            true => format!("blocks.{name}.size_for({TAIL})"),
            false => format!("@sizeOf(blocks.{name})"),
        };
        let _ = write!(
            text,
            "export fn size{number}() u64 {{
    return {size};
}}

export fn fill{number}(all: [*]align(16) u8) void {{
    const bytes = all[0..{size}];
    var k: u64 = 0;
"
        );
        let has_head = leaves.iter().any(|leaf| !leaf.is_in_tail());
        if has_head {
            let _ = writeln!(text, "    const block: *blocks.{name} = @ptrCast(bytes.ptr);");
        }
        for leaf in leaves {
            text.push_str(&fill(leaf, name));
        }
        text.push_str("}\n\n");
    }
    text
}

/// The statements that fill a leaf.
fn fill(leaf: &Leaf, block: &str) -> String {
    let Shape { columns, rows, .. } = Shape::of(&leaf.oracle);
    let mut text = String::from("    ");
    for (i, count) in leaf.counts().iter().enumerate() {
        let _ = write!(text, "for (0..{count}) |j{i}| {{ ");
    }
    let mut at = "block".to_string();
    let mut index = 0;
    for (segment, (name, dims)) in leaf.segments().iter().enumerate() {
        if segment == 0 && leaf.is_in_tail() {
            let _ = write!(at, "s.{block}.{name}(bytes)");
        } else {
            let _ = write!(at, ".{name}");
        }
        for _ in 0..*dims {
            at = format!("into(&{at}[j{index}])");
            index += 1;
        }
    }
    let is_bool = leaf.is_bool;
    let own = leaf.segments().last().is_some_and(|(_, dims)| *dims > 0);
    let statement = match (columns, rows, leaf.oracle.row_major) {
        // An element of an array is a pointer already.
        (1, 1, _) if own => format!("set({at}, &k, {is_bool});"),
        (1, 1, _) => format!("set(&{at}, &k, {is_bool});"),
        (1, _, _) => format!("for (0..{rows}) |r| set(&{at}[r], &k, {is_bool});"),
        (_, _, false) => {
            format!(
                "for (0..{columns}) |c| {{ for (0..{rows}) |r| set(&into(&{at}[c])[r], &k, false); }}"
            )
        }
        (_, _, true) => {
            format!(
                "for (0..{columns}) |c| {{ for (0..{rows}) |r| set(&into(&{at}[r])[c], &k, false); }}"
            )
        }
    };
    let _ = writeln!(text, "{statement}{}", " }".repeat(leaf.counts().len()));
    text
}

/// A C program that prints the size and the bytes of each block.
fn printer(count: usize) -> String {
    let mut text = String::from("#include <stdint.h>\n#include <stdio.h>\n#include <stdlib.h>\n");
    for number in 0..count {
        let _ = writeln!(
            text,
            "uint64_t size{number}(void); void fill{number}(unsigned char *);\n\
             static void print{number}(void) {{ uint64_t size = size{number}(); unsigned char *bytes \
             = calloc(1, size + 16); fill{number}(bytes); fwrite(&size, 8, 1, stdout); \
             fwrite(bytes, 1, size, stdout); free(bytes); }}"
        );
    }
    text.push_str("int main(void)\n{\n");
    for number in 0..count {
        let _ = writeln!(text, "    print{number}();");
    }
    text.push_str("    return 0;\n}\n");
    text
}

#[test]
fn random_blocks_are_filled_where_glslang_reads_them() {
    hold(ZIG, true, |directory, case| {
        super::write(directory, "blocks.zig", &case.output.text);
        super::write(directory, "code.zig", &program(case));
        super::write(directory, "main.c", &printer(case.blocks.len()));
        output_of(&mut zig(directory, "code.zig"));
        let mut gcc = Command::new("gcc");
        output_of(gcc.current_dir(directory).args(["main.c", "code.o", "-o", "main"]));
        output_of(&mut Command::new(directory.join("main")))
    });
}

#[test]
fn every_shader_of_this_repository_and_hostile_names_compile() {
    let directory = write_shaders(ZIG, "zig");
    let main = "const blocks = @import(\"blocks.zig\");\nconst hostile = @import(\"hostile.zig\");\n\
        comptime {\n    _ = blocks;\n    _ = hostile;\n}\n\
        export fn fill(bytes: [*]align(16) u8) f32 {\n    \
        return hostile.n_.bytes_(bytes[0..64])[1].value[0] + hostile.data.Tail__(bytes[0..64])[0].Tail__;\n}\n";
    super::write(&directory, "main.zig", main);
    output_of(&mut zig(&directory, "main.zig"));
}

#[test]
fn a_field_that_moved_stops_the_compiler() {
    let text = "layout(std140) uniform B { vec3 a; vec3 b; };";
    let change = ("    _padding_12: [4]u8 = @splat(0),\n", "");
    let directory = write_moved(ZIG, text, change, "b.zig");
    let log = said(&mut zig(&directory, "b.zig")).expect_err("`b` moved");
    assert!(log.contains("offset of b in B is not 16, as in the shader"), "{log}");
}
