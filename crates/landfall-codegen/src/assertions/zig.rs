//! Assertions in Zig: a file that imports the program's.

use std::fmt::Write as _;

use super::{AssertionWriter, HostStructure, is_path, quoted};
use crate::language::CodeOptions;

pub(super) const ZIG: AssertionWriter = AssertionWriter {
    field: str::to_string,
    is_structure: |name| is_path(name, "."),
    example: "engine.PointLight",
    write,
};

const SUPPORT: &str = "
fn same(comptime is: usize, comptime allowed: []const usize, comptime message: []const u8) void {
    for (allowed) |one| {
        if (is == one) return;
    }
    @compileError(std.fmt.comptimePrint(\"{d}, not {d}: {s}\", .{ is, allowed[allowed.len - 1], message }));
}
";

fn write(structures: &[HostStructure], options: &CodeOptions) -> String {
    let mut text = "\nconst std = @import(\"std\");\n".to_string();
    // Zig has no includes: files of the program are imported, and named after themselves.
    for file in &options.c.includes {
        let stem = file.rsplit('/').next().unwrap_or(file);
        let name = stem.strip_suffix(".zig").unwrap_or(stem);
        let _ = writeln!(text, "const {name} = @import({});", quoted(file));
    }
    text.push_str(SUPPORT);
    for HostStructure { host, what, fields, sizes, size_message } in structures {
        let _ = writeln!(text, "\n// {host}: {what}\ncomptime {{");
        for field in fields {
            let name = quoted(&field.name);
            let at = format!("@offsetOf({host}, {name})");
            same(&mut text, &at, &[field.offset], &field.name, &field.offset_message);
            let size = format!("@sizeOf(@FieldType({host}, {name}))");
            same(&mut text, &size, &field.sizes, &field.name, &field.size_message);
        }
        same(&mut text, &format!("@sizeOf({host})"), sizes, host, size_message);
        text.push_str("}\n");
    }
    text
}

fn same(text: &mut String, is: &str, allowed: &[u64], name: &str, message: &str) {
    if !allowed.is_empty() {
        let allowed: Vec<String> = allowed.iter().map(u64::to_string).collect();
        let (allowed, message) = (allowed.join(", "), quoted(&format!("{name}: {message}")));
        let _ = writeln!(text, "    same({is}, &.{{ {allowed} }}, {message});");
    }
}
