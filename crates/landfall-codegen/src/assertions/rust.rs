//! Assertions in Rust: constants that do not evaluate where a structure differs.

use std::fmt::Write as _;

use super::{AssertionWriter, HostStructure, is_path, quoted};
use crate::language::CodeOptions;
use crate::rust::names::snake;

pub(super) const RUST: AssertionWriter = AssertionWriter {
    field: snake,
    is_structure: |name| is_path(name.strip_prefix("::").unwrap_or(name), "::"),
    example: "crate::engine::PointLight",
    write,
};

fn write(structures: &[HostStructure], _: &CodeOptions) -> String {
    let mut text = String::new();
    for HostStructure { host, what, fields, sizes, size_message } in structures {
        let _ = writeln!(text, "\n// {host}: {what}\nconst _: () = {{");
        let _ = writeln!(text, "    type Structure = {host};");
        // A function's result type gives the size of a member without a value of the structure.
        if fields.iter().any(|field| !field.sizes.is_empty()) {
            text.push_str(
                "    const fn size_of_field<F>(_: fn(Structure) -> F) -> usize {\n        \
                 ::core::mem::size_of::<F>()\n    }\n",
            );
        }
        for field in fields {
            let name = &field.name;
            let at = format!("::core::mem::offset_of!(Structure, {name})");
            same(&mut text, &at, &[field.offset], &format!("{name}: {}", field.offset_message));
            let size = format!("size_of_field(|structure| structure.{name})");
            same(&mut text, &size, &field.sizes, &format!("{name}: {}", field.size_message));
        }
        same(
            &mut text,
            "::core::mem::size_of::<Structure>()",
            sizes,
            &format!("{host}: {size_message}"),
        );
        text.push_str("};\n");
    }
    text
}

/// An assertion, which has the message, and an array of as many elements, in whose type the
/// compiler tells the number.
fn same(text: &mut String, is: &str, allowed: &[u64], message: &str) {
    // A block with a runtime-sized array has no size to be asserted.
    let Some(must_be) = allowed.last() else { return };
    let any: Vec<String> = allowed.iter().map(|one| format!("{is} == {one}")).collect();
    let any = any.join(" || ");
    let _ = writeln!(text, "    assert!(\n        {any},\n        {}\n    );", quoted(message));
    let _ = writeln!(
        text,
        "    let _: [(); {must_be}] = [(); if {any} {{ {must_be} }} else {{ {is} }}];"
    );
}
