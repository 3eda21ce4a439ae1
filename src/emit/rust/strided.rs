//! Prints the elements of arrays whose stride exceeds their size, and arrays
//! whose last element has no padding after it.

use std::fmt::Write as _;

use super::mirror::{converted, natural};
use super::print::{DERIVES, Printer, default, implement};
use super::small::conversion;
use super::types::{Padded, Tight};

pub(super) fn padded(out: &Printer<'_>, text: &mut String, name: &str, padded: &Padded) {
    let (public, inner) = (out.visibility(), out.ty(&padded.inner));
    let Padded { size, stride, .. } = padded;
    let pad = stride - size;
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
    {public} fn array<const N: usize>(values: [{inner}; N]) -> [Self; N] {{
        values.map(Self::from)
    }}

    /// Elements without their padding.
    {public} fn values<const N: usize>(array: [Self; N]) -> [{inner}; N] {{
        array.map(|element| element.value)
    }}
}}

"
    );
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
        let value = converted(out, &padded.inner, "value");
        let _ = write!(
            text,
            "    fn from(value: {plain}) -> Self {{
        let value: {inner} = {value};
        Self::from(value)
    }}
}}

"
        );
    }
    let _ = write!(
        text,
        "impl core::ops::Deref for {name} {{
    type Target = {inner};

    fn deref(&self) -> &Self::Target {{
        &self.value
    }}
}}

impl core::ops::DerefMut for {name} {{
    fn deref_mut(&mut self) -> &mut Self::Target {{
        &mut self.value
    }}
}}

"
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
    let _ = write!(
        text,
        "    fn from(values: {of}) -> Self {{
        let mut array = Self::default();
        for (at, value) in values.into_iter().enumerate() {{
            array[at] = value;
        }}
        array
    }}
}}

"
    );
    conversion(text, name, &of, "array", "core::array::from_fn(|at| array[at])");
    // An element with padding is reached through it, one without as itself.
    let _ = write!(
        text,
        "impl core::ops::Index<usize> for {name} {{
    type Output = {element};

    fn index(&self, at: usize) -> &Self::Output {{
        if at == {last} {{
            &self.last
        }} else {{
            &self.head[at]
        }}
    }}
}}

impl core::ops::IndexMut<usize> for {name} {{
    fn index_mut(&mut self, at: usize) -> &mut Self::Output {{
        if at == {last} {{
            &mut self.last
        }} else {{
            &mut self.head[at]
        }}
    }}
}}

"
    );
}
