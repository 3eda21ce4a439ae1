//! Prints compile-time assertions that mirrors match the shader's layout: the size of each type,
//! the offset of each field.
//!
//! Explicit padding makes them hold for any alignment of glam's types.

use std::fmt::Write as _;

use super::print::{Printer, Text, call};
use super::types::{GeneratedType, RustType, UserType};

pub(super) fn checks(out: &Printer<'_>, text: &mut Text) {
    for (id, made) in out.generated_types() {
        let name = out.name(id);
        match made {
            GeneratedType::Bits(_) => {}
            GeneratedType::Leaf(leaf) => size(out, text, name, leaf.size()),
            GeneratedType::Padded(padded) => size(out, text, name, padded.stride),
            GeneratedType::Tight(tight) => size(out, text, name, tight.size),
            GeneratedType::Mirror(mirror) => {
                let docs = &out.plan.docs[&id];
                let of = format!("`{}` in {}", docs.shader_name, docs.input);
                assert(out, text, &size_of(name), mirror.size, &format!("size of {of}"));
                for field in &mirror.fields {
                    let actual = format!("core::mem::offset_of!({name}, {})", field.name);
                    let what = format!("offset of `{}` of {of}", field.name);
                    assert(out, text, &actual, field.offset, &what);
                }
                // A field of the program's own type is checked as well, in arrays and padding, too.
                let fields = mirror.fields.iter().map(|field| (&field.ty, &field.name));
                let tail = mirror.tail.iter().map(|tail| (&tail.element, &tail.member));
                for (ty, name) in fields.chain(tail) {
                    if let Some(user) = user_type(out, ty) {
                        user_check(out, text, user, &format!("`{name}` of {of}"));
                    }
                }
            }
        }
    }
}

/// The type of the program in a field's type.
fn user_type<'a>(out: &'a Printer<'_>, ty: &'a RustType) -> Option<&'a UserType> {
    match ty {
        RustType::Named(_) => None,
        RustType::User(user) => Some(user),
        RustType::Array(element, _) => user_type(out, element),
        RustType::GeneratedType(id) => match out.plan.get(*id) {
            GeneratedType::Padded(padded) => user_type(out, &padded.inner),
            GeneratedType::Tight(tight) => user_type(out, &tight.element),
            // They have checks of their own.
            GeneratedType::Bits(_) | GeneratedType::Leaf(_) | GeneratedType::Mirror(_) => None,
        },
    }
}

/// Prints the assertions on a type of the program.
fn user_check(out: &Printer<'_>, text: &mut Text, user: &UserType, of: &str) {
    let UserType { path, size, align } = user;
    assert(out, text, &size_of(path), *size, &format!("size of `{path}`, the type for {of}"));
    // A larger alignment would move the field, or pad the mirror.
    let what = format!("alignment of `{path}`, the type for {of}, is more than {align}");
    let _ = writeln!(
        text,
        "#[rustfmt::skip]\nconst _: () = assert!(core::mem::align_of::<{path}>() <= {align}, {:?});",
        what.replace(['{', '}'], "_")
    );
}

fn size(out: &Printer<'_>, text: &mut Text, name: &str, bytes: u64) {
    assert(out, text, &size_of(name), bytes, &format!("size of `{name}`"));
}

fn size_of(name: &str) -> String {
    format!("core::mem::size_of::<{name}>()")
}

fn assert(out: &Printer<'_>, text: &mut Text, actual: &str, expected: u64, what: &str) {
    let mismatch = &out.names.mismatch;
    // `{:?}` escapes quotes in paths.
    let arguments = [format!("{what:?}"), expected.to_string(), actual.to_string()];
    let mut message = text.same();
    call(&mut message, "    ", &format!("{mismatch}::new"), &arguments, ".text()");
    let line = format!("    {actual} == {expected},");
    let condition = match line.len() <= text.width {
        true => line,
        false => format!("    {actual}\n        == {expected},"),
    };
    if actual.len() + 8 >= text.width {
        // Only a name is left to break; matching rustfmt here is not worth it.
        text.push_str("#[rustfmt::skip]\n");
    }
    let _ =
        writeln!(text, "const _: () = assert!(\n{condition}\n    \"{{}}\",\n{});", message.text);
}

/// Prints the type of an assertion's message, which must be a literal or built in const code.
pub(super) fn mismatch(text: &mut Text) {
    let name = "Mismatch";
    let _ = write!(
        text,
        "/// The message of a failed assertion: what differs, in the shader and in its mirror.
pub(super) struct {name} {{
    text: [u8; 512],
    len: usize,
}}

impl {name} {{
    pub(super) const fn new(what: &str, shader: usize, mirror: usize) -> Self {{
        let empty = Self {{
            text: [0; 512],
            len: 0,
        }};
        empty
            .word(what)
            .word(\": \")
            .number(shader)
            .word(\" bytes in the shader, \")
            .number(mirror)
            .word(\" in its mirror\")
    }}

    const fn word(mut self, word: &str) -> Self {{
        let bytes = word.as_bytes();
        let mut at = 0;
        while at < bytes.len() && self.len < self.text.len() {{
            self.text[self.len] = bytes[at];
            self.len += 1;
            at += 1;
        }}
        self
    }}

    const fn number(self, number: usize) -> Self {{
        let before = if number < 10 {{
            self
        }} else {{
            self.number(number / 10)
        }};
        match core::str::from_utf8(&[b'0' + (number % 10) as u8]) {{
            Ok(digit) => before.word(digit),
            Err(_) => before,
        }}
    }}

    pub(super) const fn text(&self) -> &str {{
        match core::str::from_utf8(self.text.split_at(self.len).0) {{
            Ok(text) => text,
            Err(_) => \"a mirror is not laid out as its shader\",
        }}
    }}
}}

"
    );
}
