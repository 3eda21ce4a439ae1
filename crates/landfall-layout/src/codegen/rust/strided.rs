//! Prints the elements of arrays whose stride exceeds their size, and arrays
//! whose last element has no padding after it.

use std::fmt::Write as _;

use super::mirror;
use super::mirror::natural;
use super::print::{DERIVES, Printer, assignment, conversion, default, implement, signature};
use super::types::{Padded, Tight};

pub(super) fn padded(out: &Printer<'_>, text: &mut String, name: &str, padded: &Padded) {
    let (public, inner) = (out.visibility(), out.ty(&padded.inner));
    let Padded { size, stride, .. } = padded;
    let pad = stride - size;
    let (values, array) = (format!("[{inner}; N]"), "[Self; N]");
    let _ = write!(
        text,
        "/// An element of {size} bytes and {pad} bytes of padding.
#[repr(C)]
{DERIVES}
{public} struct {name} {{
    /// The element.
    {public} value: {inner},
    _pad_{size}: [u8; {pad}],
}}

#[allow(dead_code)]
impl {name} {{
    /// Elements with their padding.
"
    );
    let head = format!("{public} fn array<const N: usize>");
    signature(text, "    ", &head, &[format!("values: {values}")], &format!(" -> {array} {{"));
    text.push_str(
        "        values.map(Self::from)\n    }\n\n    /// Elements without their padding.\n",
    );
    let head = format!("{public} fn values<const N: usize>");
    signature(text, "    ", &head, &[format!("array: {array}")], &format!(" -> {values} {{"));
    text.push_str("        array.map(|element| element.value)\n    }\n}\n\n");
    default(text, name);
    implement(text, &format!("From<{inner}>"), name);
    let _ = write!(
        text,
        "    fn from(value: {inner}) -> Self {{
        Self {{
            value,
            _pad_{size}: [0; {pad}],
        }}
    }}
}}

"
    );
    conversion(text, name, &inner, "element", "element.value");
    if let Some(plain) = natural(out, &padded.inner) {
        implement(text, &format!("From<{plain}>"), name);
        let method = mirror::conversion(out, &padded.inner);
        signature(text, "    ", "fn from", &[format!("value: {plain}")], " -> Self {");
        let (head, tail) = (format!("let value: {inner}"), format!("value{method};"));
        assignment(text, "        ", &head, " =", &tail);
        text.push_str("        Self::from(value)\n    }\n}\n\n");
    }
    implement(text, "core::ops::Deref", name);
    let _ = write!(
        text,
        "    type Target = {inner};

    fn deref(&self) -> &Self::Target {{
        &self.value
    }}
}}

"
    );
    implement(text, "core::ops::DerefMut", name);
    text.push_str(
        "    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.value
    }
}

",
    );
}

pub(super) fn tight(out: &Printer<'_>, text: &mut String, name: &str, tight: &Tight) {
    let public = out.visibility();
    let (element, head, len) = (out.ty(&tight.element), out.ty(&tight.head), tight.len);
    let last = len - 1;
    let of = format!("[{element}; {len}]");
    let _ = write!(
        text,
        "/// An array of {len} elements: what follows it begins in the padding of the last one.
#[repr(C)]
{DERIVES}
{public} struct {name} {{
    head: [{head}; {last}],
    last: {element},
}}

"
    );
    default(text, name);
    implement(text, &format!("From<{of}>"), name);
    signature(text, "    ", "fn from", &[format!("values: {of}")], " -> Self {");
    let _ = write!(
        text,
        "        let mut array = Self::default();
        for (at, value) in values.into_iter().enumerate() {{
            array[at] = value;
        }}
        array
    }}
}}

"
    );
    conversion(text, name, &of, "array", "core::array::from_fn(|at| array[at])");
    // A padded element of `head` dereferences to the element.
    implement(text, "core::ops::Index<usize>", name);
    let _ = write!(
        text,
        "    type Output = {element};

    fn index(&self, at: usize) -> &Self::Output {{
        match at {{
            {last} => &self.last,
            _ => &self.head[at],
        }}
    }}
}}

"
    );
    implement(text, "core::ops::IndexMut<usize>", name);
    let _ = write!(
        text,
        "    fn index_mut(&mut self, at: usize) -> &mut Self::Output {{
        match at {{
            {last} => &mut self.last,
            _ => &mut self.head[at],
        }}
    }}
}}

"
    );
}
