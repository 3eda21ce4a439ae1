//! Prints the elements of arrays whose stride exceeds their size, and arrays
//! whose last element has no padding after it.

use std::fmt::Write as _;

use super::host::{natural, stored};
use super::print::{
    DERIVES, FieldValue, Printer, Text, assignment, conversion, default, implement, literal,
    signature,
};
use super::types::{GeneratedType, Padded, RustType, Tight};

pub(super) fn padded(out: &Printer<'_>, text: &mut Text, name: &str, padded: &Padded) {
    let (public, inner) = (out.visibility(), out.ty(&padded.inner));
    let Padded { size, stride, .. } = padded;
    let pad = stride - size;
    let (values, array) = (format!("[{inner}; N]"), "[Self; N]");
    let derives = out.derives();
    let _ = write!(
        text,
        "/// An element of {size} bytes and {pad} bytes of padding.
{derives}#[repr(C)]
{DERIVES}
{public} struct {name} {{
    /// The element.
    {public} value: {inner},
    _pad_{size}: [u8; {pad}],
}}

#[allow(dead_code)]
impl {name} {{
    /// The element with its padding.
    #[inline]
"
    );
    // A caller gives the element as programs have it: a `bool`, a `glam::Vec3`.
    let host = natural(out, &padded.inner);
    let parameter = format!("value: {}", host.as_ref().unwrap_or(&inner));
    signature(text, "    ", &format!("{public} const fn new"), &[parameter], " -> Self {");
    let fields = [
        FieldValue {
            name: "value".to_string(),
            value: stored(out, &padded.inner, "value", "            "),
        },
        FieldValue { name: format!("_pad_{size}"), value: format!("[0; {pad}]") },
    ];
    literal(text, "        ", &fields);
    text.push_str("    }\n\n    /// Elements with their padding.\n");
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
    if let Some(host) = host {
        conversion(text, &host, name, "value", "Self::new(value)");
    }
    // Fields of the element are reached through the padding: `array[i].color`.
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

pub(super) fn tight(out: &Printer<'_>, text: &mut Text, name: &str, tight: &Tight) {
    let public = out.visibility();
    let (element, head, len) = (out.ty(&tight.element), out.ty(&tight.head), tight.len);
    let last = len - 1;
    let of = format!("[{element}; {len}]");
    let derives = out.derives();
    let _ = write!(
        text,
        "/// An array of {len} elements: what follows it begins in the padding of the last one.
{derives}#[repr(C)]
{DERIVES}
{public} struct {name} {{
    head: [{head}; {last}],
    last: {element},
}}

#[allow(dead_code)]
impl {name} {{
    /// From its elements.
    #[inline]
"
    );
    let host = natural(out, &tight.element).unwrap_or_else(|| element.clone());
    let parameter = format!("values: [{host}; {len}]");
    signature(text, "    ", &format!("{public} const fn new"), &[parameter], " -> Self {");
    // The elements before the last, with their padding; their type may be another than the last's.
    let padded = match &tight.head {
        RustType::GeneratedType(id) => matches!(out.plan.get(*id), GeneratedType::Padded(_)),
        RustType::Named(_) | RustType::User(_) | RustType::Array(..) => false,
    };
    let one = |at: &str, indent: &str| match padded {
        true => format!("{head}::new(values[{at}])"),
        false => stored(out, &tight.element, &format!("values[{at}]"), indent),
    };
    // The first element fills the array, which needs an initial value of its type; the loop
    // replaces the others.
    assignment(
        text,
        "        ",
        "let mut head",
        " =",
        &format!("[{}; {last}];", one("0", "        ")),
    );
    let _ = write!(text, "        let mut at = 1;\n        while at < {last} {{\n");
    assignment(text, "            ", "head[at]", " =", &format!("{};", one("at", "            ")));
    text.push_str("            at += 1;\n        }\n");
    let value = stored(out, &tight.element, &format!("values[{last}]"), "            ");
    let last_value = FieldValue { name: "last".to_string(), value };
    let head_value = FieldValue { name: "head".to_string(), value: "head".to_string() };
    literal(text, "        ", &[head_value, last_value]);
    text.push_str("    }\n}\n\n");
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
