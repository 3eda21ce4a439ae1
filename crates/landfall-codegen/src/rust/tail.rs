//! Prints the items of a block with a runtime-sized tail beside the mirror of the rest: the
//! element type, the size function, and the writer.

use std::fmt::Write as _;

use super::print::{Printer, Text, assignment, doc, signature};
use super::types::{GeneratedTypeId, Mirror, RuntimeTail};

pub(super) fn tail(
    out: &Printer<'_>,
    text: &mut Text,
    id: GeneratedTypeId,
    mirror: &Mirror,
    tail: &RuntimeTail,
) {
    let (header, element) = (out.name(id), &out.names.elements[&id]);
    let (public, too_short) = (out.visibility(), &out.names.too_short);
    let RuntimeTail { member, stride, sizes, .. } = tail;
    let least = sizes.least;
    let offset = mirror.size;
    doc(text, "", &[format!("One element of `{member}`: offset {offset}, stride {stride}.")]);
    let ty = out.ty(&tail.element);
    text.push_str("#[allow(dead_code)]\n");
    assignment(text, "", &format!("{public} type {element}"), " =", &format!("{ty};"));
    text.push('\n');
    let times = if *stride == 1 { String::new() } else { format!(" * {stride}") };
    let before = if offset == 0 { String::new() } else { format!("{offset} + ") };
    let size = match sizes.must_round(offset, *stride) {
        false => format!("{before}n{times}"),
        true => format!("({before}n{times}).next_multiple_of({})", sizes.multiple),
    };
    let mut lines =
        vec![format!("Bytes of a buffer in which a shader counts `n` elements of `{member}`.")];
    // How many elements a shader counts in the least size, which is rounded up: more than one, and
    // it has to be said.
    lines.push(match (least - offset) / stride {
        0 | 1 => format!("The least size is {least} bytes."),
        count => format!("WebGPU demands {least} bytes, in which a shader counts {count}."),
    });
    let mut about = text.same();
    doc(&mut about, "    ", &lines);
    let about = about.text;
    let _ = write!(
        text,
        "#[allow(dead_code)]
impl {header} {{
{about}    {public} const fn size_for(n: usize) -> usize {{
        match {size} {{
            size if size < {least} => {least},
            size => size,
        }}
    }}

    /// Copies this and `elements` to the start of `bytes`, and returns how many bytes that took.
"
    );
    let parameters =
        ["&self".to_string(), format!("elements: &[{element}]"), "bytes: &mut [u8]".to_string()];
    let returns = format!(" -> Result<usize, {too_short}> {{");
    signature(text, "    ", &format!("{public} fn write_to"), &parameters, &returns);
    // Without members before the tail there is nothing to copy.
    let own = match offset {
        0 => String::new(),
        _ => format!("                to[..{offset}].copy_from_slice(bytemuck::bytes_of(self));\n"),
    };
    let rest = if offset == 0 { "to".to_string() } else { format!("to[{offset}..]") };
    let _ = write!(
        text,
        "        let tail = bytemuck::cast_slice::<_, u8>(elements);
        let needed = {before}tail.len();
        let got = bytes.len();
        match bytes.get_mut(..needed) {{
            None => Err({too_short} {{ needed, got }}),
            Some(to) => {{
{own}                {rest}.copy_from_slice(tail);
                Ok(needed)
            }}
        }}
    }}
}}

"
    );
    vectors(out, text, (header, element), offset);
}

/// Prints the functions that return the bytes of a whole buffer.
fn vectors(out: &Printer<'_>, text: &mut Text, (header, element): (&str, &str), offset: u64) {
    let public = out.visibility();
    // Whoever includes two files has no clash of `alloc`.
    let _ = write!(
        text,
        "const _: () = {{
    extern crate alloc;

    #[allow(dead_code, clippy::wrong_self_convention)]
    impl {header} {{
        /// The bytes of a buffer in which a shader counts these elements: `size_for` of them, zero
        /// behind the last element.
"
    );
    let elements = format!("elements: &[{element}]");
    let parameters = ["&self".to_string(), elements.clone()];
    let returns = " -> alloc::vec::Vec<u8> {";
    signature(text, "        ", &format!("{public} fn to_bytes"), &parameters, returns);
    text.push_str(
        "            let mut bytes = alloc::vec::Vec::new();
            self.write_into(elements, &mut bytes);
            bytes
        }

        /// Puts those bytes in place of what a vector holds, into the memory that it has.
",
    );
    let bytes = "bytes: &mut alloc::vec::Vec<u8>".to_string();
    let parameters = ["&self".to_string(), elements, bytes];
    signature(text, "        ", &format!("{public} fn write_into"), &parameters, " {");
    let own = match offset {
        0 => "",
        _ => "            bytes.extend_from_slice(bytemuck::bytes_of(self));\n",
    };
    let _ = write!(
        text,
        "            let size = Self::size_for(elements.len());
            bytes.clear();
            bytes.reserve(size);
{own}            bytes.extend_from_slice(bytemuck::cast_slice(elements));
            bytes.resize(size, 0);
        }}
    }}
}};

"
    );
}

/// Prints the error type of the writers.
pub(super) fn too_short(out: &Printer<'_>, text: &mut Text) {
    let (public, name) = (out.visibility(), "TooShort");
    let _ = write!(
        text,
        "/// A block does not fit into the bytes it was to be written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
{public} struct {name} {{
    /// Bytes it takes.
    {public} needed: usize,
    /// Bytes there are.
    {public} got: usize,
}}

impl core::fmt::Display for {name} {{
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {{
        let {name} {{ needed, got }} = self;
        write!(f, \"the block takes {{needed}} bytes, there are {{got}}\")
    }}
}}

impl core::error::Error for {name} {{}}

"
    );
}
