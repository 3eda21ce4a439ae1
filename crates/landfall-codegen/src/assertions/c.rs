//! Assertions in C11 and C++17: a header to include behind the structures.

use std::fmt::Write as _;

use super::{AssertionWriter, HostStructure, is_path, quoted};
use crate::c::include;
use crate::language::CodeOptions;

pub(super) const C: AssertionWriter = AssertionWriter {
    field: str::to_string,
    is_structure: |name| is_path(name.strip_prefix("struct ").unwrap_or(name), "::"),
    example: "engine::PointLight` or `struct point_light",
    write,
};

/// In C a failed assertion does not tell the number that it compared; a selection that has no case
/// for it does, in its type.
const SUPPORT: &str = "
#ifdef __cplusplus
#include <cstddef>
#include <type_traits>
#define LANDFALL_SAME(is, must_be, message) static_assert((is) == (must_be), message)
#define LANDFALL_SIZE_OF(type, member) sizeof(type::member)
#else
#include <stddef.h>
#define LANDFALL_SAME(is, must_be, message) \\
    _Static_assert((is) == (must_be), message); \\
    _Static_assert(_Generic((char (*)[(is) + ((is) == (must_be))])0, \\
                            char (*)[(must_be) + 1]: 1), message)
#define LANDFALL_SIZE_OF(type, member) sizeof(((type *)0)->member)
#endif
";

fn write(structures: &[HostStructure], options: &CodeOptions) -> String {
    let mut text = "#pragma once\n".to_string();
    for header in options.c.includes.iter().filter_map(|header| include(header)) {
        text.push_str(&header);
    }
    text.push_str(SUPPORT);
    for HostStructure { host, what, fields, sizes, size_message } in structures {
        let _ = writeln!(text, "\n// {host}: {what}");
        let _ = writeln!(
            text,
            "#ifdef __cplusplus\nstatic_assert(std::is_standard_layout<{host}>::value,\n    \
             \"the members of {host} have no fixed place: no bases with members, no virtual functions, one access\");\n#endif"
        );
        for field in fields {
            let name = &field.name;
            let at = format!("offsetof({host}, {name})");
            same(&mut text, &at, &[field.offset], &format!("{name}: {}", field.offset_message));
            let size = format!("LANDFALL_SIZE_OF({host}, {name})");
            same(&mut text, &size, &field.sizes, &format!("{name}: {}", field.size_message));
        }
        let name = host.strip_prefix("struct ").unwrap_or(host);
        same(&mut text, &format!("sizeof({host})"), sizes, &format!("{name}: {size_message}"));
    }
    text.push_str("\n#undef LANDFALL_SAME\n#undef LANDFALL_SIZE_OF\n");
    text
}

fn same(text: &mut String, is: &str, allowed: &[u64], message: &str) {
    let message = quoted(message);
    let _ = match allowed {
        [] => Ok(()),
        [must_be] => writeln!(text, "LANDFALL_SAME({is}, {must_be}u,\n    {message});"),
        // Where it is the first, nothing is left to compare.
        [other, must_be, ..] => writeln!(
            text,
            "LANDFALL_SAME({is} == {other}u ? {must_be}u : {is}, {must_be}u,\n    {message});"
        ),
    };
}
