//! Prints the helper types of mirrors: `Bool`, `F16`, and the matrices and vectors for which no
//! glam type fits. [`super::strided`] prints the padded ones.

use std::fmt::Write as _;

use super::host::natural_leaf;
use super::print::{DERIVES, Printer, Text, conversion, default, doc, implement, list, signature};
use super::types::{Bits, Component, GeneratedType, LeafType, Shape, component};
use super::{Vectors, leaf, strided};

pub(super) fn small_types(out: &Printer<'_>, text: &mut Text) {
    for (id, made) in out.generated_types() {
        let name = out.name(id);
        match made {
            GeneratedType::Mirror(_) => {}
            GeneratedType::Bits(Bits::Bool) => bool_type(out, text, name),
            GeneratedType::Bits(bits) => bits_type(out, text, name, *bits),
            GeneratedType::Leaf(leaf) => leaf_type(out, text, name, *leaf),
            GeneratedType::Padded(one) => strided::padded(out, text, name, one),
            GeneratedType::Tight(tight) => strided::tight(out, text, name, tight),
        }
    }
}

fn bool_type(out: &Printer<'_>, text: &mut Text, name: &str) {
    let (public, derives) = (out.visibility(), out.derives());
    let _ = write!(
        text,
        "/// A `bool` as shaders store it: 4 bytes, where all but 0 is true.
{derives}#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
{public} struct {name}(u32);

#[allow(dead_code)]
impl {name} {{
    /// 1 or 0.
    #[inline]
    {public} const fn new(value: bool) -> Self {{
        Self(value as u32)
    }}
}}

impl From<bool> for {name} {{
    fn from(value: bool) -> Self {{
        Self::new(value)
    }}
}}

impl From<{name}> for bool {{
    fn from(value: {name}) -> Self {{
        value.0 != 0
    }}
}}

"
    );
}

// The limits are `f32` bits: 0x477f_f000 is 65520, halfway between the largest number and the next;
// 0x3880_0000 is 2^-14, the smallest normal number; 0x3300_0000 is 2^-25, half of the smallest
// subnormal one. 0x3800_0000 is the difference of the biases, 127 - 15, in the exponent.
// 0x7c00 is infinite, 0x7e00 a NaN that remains one whichever of its bits are lost.
/// Conversions of IEEE 754 binary16.
const F16: &str = "
    /// The nearest number, ties to even; infinite from 65520.
    PUBLIC fn from_f32(value: f32) -> Self {
        let bits = value.to_bits();
        let rest = bits & 0x7fff_ffff;
        let half = if rest > 0x7f80_0000 {
            0x7e00 | rest >> 13 & 0x3ff
        } else if rest >= 0x477f_f000 {
            0x7c00
        } else if rest >= 0x3880_0000 {
            let rest = rest - 0x3800_0000;
            (rest + 0xfff + (rest >> 13 & 1)) >> 13
        } else if rest > 0x3300_0000 {
            // A multiple of 2^-24.
            let shift = 126 - (rest >> 23);
            let whole = rest & 0x007f_ffff | 0x0080_0000;
            let (down, lost) = (whole >> shift, whole & ((1 << shift) - 1));
            let tie = 1 << (shift - 1);
            down + u32::from(lost > tie || lost == tie && down & 1 == 1)
        } else {
            0
        };
        Self((bits >> 16 & 0x8000 | half) as u16)
    }

    /// The same number.
    PUBLIC fn to_f32(self) -> f32 {
        let bits = u32::from(self.0);
        let (sign, rest) = ((bits & 0x8000) << 16, bits & 0x7fff);
        let positive = match rest >> 10 {
            0 => (rest as f32 / 16_777_216.0).to_bits(),
            31 => 0x7f80_0000 | (rest & 0x3ff) << 13,
            _ => (rest << 13) + 0x3800_0000,
        };
        f32::from_bits(sign | positive)
    }
";

// 0x40 keeps a NaN one: without it the bits that remain could be those of an infinite number.
// Adding 0x7fff and the lowest bit that remains rounds to nearest, ties to even.
/// Conversions of bfloat16.
const BF16: &str = "
    /// The nearest number, ties to even.
    PUBLIC fn from_f32(value: f32) -> Self {
        let bits = value.to_bits();
        Self(match value.is_nan() {
            true => (bits >> 16 | 0x40) as u16,
            false => ((bits + 0x7fff + (bits >> 16 & 1)) >> 16) as u16,
        })
    }

    /// The same number.
    PUBLIC fn to_f32(self) -> f32 {
        f32::from_bits(u32::from(self.0) << 16)
    }
";

fn bits_type(out: &Printer<'_>, text: &mut Text, name: &str, bits: Bits) {
    let (public, derives) = (out.visibility(), out.derives());
    let (what, ty) = match bits {
        Bits::Bool => unreachable!("printed by `bool_type`"),
        Bits::F16 => ("A 16-bit float (IEEE 754 binary16)", "u16"),
        Bits::Bf16 => ("A 16-bit float with the 8 exponent bits of a 32-bit one", "u16"),
        Bits::F8E5m2 => ("An 8-bit float with 5 exponent bits", "u8"),
        Bits::F8E4m3 => ("An 8-bit float with 4 exponent bits", "u8"),
    };
    let _ = write!(
        text,
        "/// {what}, as its bits.
{derives}#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
{public} struct {name}({public} {ty});

#[allow(dead_code)]
impl {name} {{
    /// From its bits, such as `half::f16::to_bits` gives for 16-bit floats.
    {public} const fn from_bits(bits: {ty}) -> Self {{
        Self(bits)
    }}

    /// Its bits.
    {public} const fn to_bits(self) -> {ty} {{
        self.0
    }}
"
    );
    match bits {
        Bits::F16 => text.push_str(&F16.replace("PUBLIC", public)),
        Bits::Bf16 => text.push_str(&BF16.replace("PUBLIC", public)),
        Bits::Bool | Bits::F8E5m2 | Bits::F8E4m3 => {}
    }
    text.push_str("}\n\n");
}

/// A leaf as a plain array of components.
struct Plain {
    component: String,
    /// `f32`, `[f32; 3]`, or `[[f32; 3]; 2]`: two columns of three.
    ty: String,
}

fn leaf_type(out: &Printer<'_>, text: &mut Text, name: &str, leaf: LeafType) {
    let component = out.component(leaf.scalar).to_string();
    let ty = match leaf.shape {
        Shape::Scalar => component.clone(),
        Shape::Vector { rows } => format!("[{component}; {rows}]"),
        Shape::Matrix { columns, rows, .. } => format!("[[{component}; {rows}]; {columns}]"),
    };
    let plain = Plain { component, ty };
    let cell = match leaf.unaligned {
        // Without an alignment for its components, each is kept as bytes.
        true => format!("[u8; {}]", leaf.scalar.width),
        false => plain.component.clone(),
    };
    let stored = stored(leaf, &cell);
    doc(text, "", &[about(leaf)]);
    let transparent = "#[repr(transparent)]";
    let _ = write!(
        text,
        "{}{transparent}\n{DERIVES}\n{} struct {name}({stored});\n\n",
        out.derives(),
        out.visibility()
    );
    new(out, text, name, &plain, leaf);
    default(text, name);
    match leaf.shape {
        Shape::Scalar | Shape::Vector { .. } => vector(text, name, &plain, leaf),
        Shape::Matrix { .. } => matrix(text, name, &plain, leaf),
    }
    if matches!(self::component(leaf.scalar), Component::Bits(Bits::Bool)) {
        bools(text, name, &plain, leaf.shape);
    }
    if out.options.vectors == Vectors::Glam {
        glam(text, name, &plain, leaf);
    }
}

/// Prints `new`, a `const fn` from the host's type.
fn new(out: &Printer<'_>, text: &mut Text, name: &str, plain: &Plain, leaf: LeafType) {
    let (public, host) = (out.visibility(), natural_leaf(out, leaf));
    let glam = host.starts_with("glam::") || host.starts_with("[glam::");
    let bits = self::component(leaf.scalar);
    let bool = matches!(bits, Component::Bits(Bits::Bool));
    // A component as it is stored.
    let cell = |value: &str| match (leaf.unaligned, &bits) {
        (true, Component::Bits(Bits::Bool)) => format!("({value} as u32).to_ne_bytes()"),
        (true, Component::Bits(_)) => format!("{value}.0.to_ne_bytes()"),
        (true, Component::Plain(_)) => format!("{value}.to_ne_bytes()"),
        (false, Component::Bits(Bits::Bool)) => format!("{}::new({value})", plain.component),
        (false, Component::Bits(_) | Component::Plain(_)) => value.to_string(),
    };
    let of = if matches!(leaf.shape, Shape::Matrix { .. }) { "columns" } else { "value" };
    let _ = write!(text, "#[allow(dead_code)]\nimpl {name} {{\n    /// As shaders store it.\n");
    text.push_str("    #[inline]\n");
    let head = format!("{public} const fn new");
    signature(text, "    ", &head, &[format!("{of}: {host}")], " -> Self {");
    match leaf.shape {
        Shape::Scalar => {
            let _ = writeln!(text, "        Self({})", cell("value"));
        }
        Shape::Vector { .. } if !bool && !leaf.unaligned => {
            let value = if glam { "value.to_array()" } else { "value" };
            let _ = writeln!(text, "        Self({value})");
        }
        Shape::Vector { rows } => {
            if glam {
                text.push_str("        let value = value.to_array();\n");
            }
            let items: Vec<String> = (0..rows).map(|i| cell(&format!("value[{i}]"))).collect();
            let _ = writeln!(text, "        Self({})", list("        ", &items));
        }
        Shape::Matrix { columns, rows, stride, row_major } => {
            // An array of glam's vectors, one of glam's matrices, or an array of arrays.
            let column = match (glam, host.starts_with('[')) {
                (true, true) => "columns[c].to_array()",
                (true, false) => {
                    text.push_str("        let columns = columns.to_cols_array_2d();\n");
                    "columns[c]"
                }
                (false, _) => "columns[c]",
            };
            // The padding of each vector is zero.
            let zero = match (leaf.unaligned, &bits) {
                (true, _) => format!("[0; {}]", leaf.scalar.width),
                (false, Component::Plain(_)) => "0.0".to_string(),
                (false, Component::Bits(_)) => format!("{}(0)", plain.component),
            };
            // Components in a stride, those of the padding included.
            let lanes = stride / u64::from(leaf.scalar.width);
            let place = if row_major { "[r][c]" } else { "[c][r]" };
            // Generated loops are `while`: `for` is not allowed in a `const fn`.
            let _ = write!(
                text,
                "        let mut matrix = Self([[{zero}; {lanes}]; {}]);
        let mut c = 0;
        while c < {columns} {{
            let column = {column};
            let mut r = 0;
            while r < {rows} {{
                matrix.0{place} = {};
                r += 1;
            }}
            c += 1;
        }}
        matrix
",
                leaf.shape.stored().0,
                cell("column[r]"),
            );
        }
    }
    text.push_str("    }\n}\n\n");
}

/// The type of its only field.
fn stored(leaf: LeafType, cell: &str) -> String {
    match leaf.shape {
        Shape::Scalar => cell.to_string(),
        Shape::Vector { rows } => format!("[{cell}; {rows}]"),
        Shape::Matrix { stride, .. } => {
            let lanes = stride / u64::from(leaf.scalar.width);
            format!("[[{cell}; {lanes}]; {}]", leaf.shape.stored().0)
        }
    }
}

fn about(leaf: LeafType) -> String {
    let aligned = match leaf.unaligned {
        true => "aligned to 1 byte",
        false => "aligned like its components",
    };
    match leaf.shape {
        Shape::Scalar => format!("A scalar of {} bytes, {aligned}.", leaf.scalar.width),
        Shape::Vector { rows } => format!("A vector of {rows} components, {aligned}."),
        Shape::Matrix { columns, rows, stride, row_major } => {
            let lines = if row_major { "rows" } else { "columns" };
            format!(
                "A matrix of {columns} columns and {rows} rows, {aligned}; its {lines} are \
                 {stride} bytes apart."
            )
        }
    }
}

fn vector(text: &mut Text, name: &str, plain: &Plain, leaf: LeafType) {
    let ty = &plain.ty;
    let (to, from) = match leaf.unaligned {
        true => ("Self(bytemuck::cast(value))", "bytemuck::cast(value.0)"),
        false => ("Self(value)", "value.0"),
    };
    conversion(text, ty, name, "value", to);
    conversion(text, name, ty, "value", from);
}

fn matrix(text: &mut Text, name: &str, plain: &Plain, leaf: LeafType) {
    let ty = &plain.ty;
    let row_major = matches!(leaf.shape, Shape::Matrix { row_major: true, .. });
    let place = if row_major { "[r][c]" } else { "[c][r]" };
    let (cell, value) = match leaf.unaligned {
        true => ("bytemuck::cast(*value)", format!("bytemuck::cast(matrix.0{place})")),
        false => ("*value", format!("matrix.0{place}")),
    };
    implement(text, &format!("From<{ty}>"), name);
    let _ = write!(
        text,
        "    /// From its columns.
    fn from(columns: {ty}) -> Self {{
        let mut matrix = Self::default();
        for (c, column) in columns.iter().enumerate() {{
            for (r, value) in column.iter().enumerate() {{
                matrix.0{place} = {cell};
            }}
        }}
        matrix
    }}
}}

"
    );
    implement(text, &format!("From<{name}>"), ty);
    let _ = write!(
        text,
        "    /// Its columns.
    fn from(matrix: {name}) -> Self {{
        core::array::from_fn(|c| core::array::from_fn(|r| {value}))
    }}
}}

"
    );
}

/// Prints conversions from and to glam's type, or columns of glam's vectors.
fn glam(text: &mut Text, name: &str, plain: &Plain, leaf: LeafType) {
    let ty = &plain.ty;
    match leaf.shape {
        Shape::Scalar => {}
        Shape::Vector { rows } => {
            if let Some(glam) = leaf::glam_vector(leaf.scalar, rows) {
                conversion(text, glam, name, "value", "value.to_array().into()");
                let back = format!("{glam}::from_array(value.into())");
                conversion(text, name, glam, "value", &back);
            }
        }
        Shape::Matrix { columns, rows, .. } => {
            // glam's matrices are square. Of others it has the columns.
            let square = leaf::glam_matrix(leaf.scalar, columns).filter(|_| columns == rows);
            if let Some((glam, _)) = square {
                conversion(text, glam, name, "matrix", "matrix.to_cols_array_2d().into()");
                let back = format!("{glam}::from_cols_array_2d(&matrix.into())");
                conversion(text, name, glam, "matrix", &back);
            } else if let Some(column) = leaf::glam_vector(leaf.scalar, rows) {
                let of = format!("[{column}; {columns}]");
                conversion(
                    text,
                    &of,
                    name,
                    "columns",
                    "Self::from(columns.map(|column| column.to_array()))",
                );
                let back = format!("<{ty}>::from(matrix).map(Into::into)");
                conversion(text, name, &of, "matrix", &back);
            }
        }
    }
}

/// Prints conversions from and to `bool`s.
fn bools(text: &mut Text, name: &str, plain: &Plain, shape: Shape) {
    let own = &plain.component;
    match shape {
        Shape::Scalar => {
            conversion(text, "bool", name, "value", &format!("{own}::from(value).into()"));
            conversion(text, name, "bool", "value", &format!("{own}::from(value).into()"));
        }
        Shape::Vector { rows } => {
            let of = format!("[bool; {rows}]");
            conversion(text, &of, name, "value", &format!("Self::from(value.map({own}::from))"));
            let back = format!("<[{own}; {rows}]>::from(value).map(Into::into)");
            conversion(text, name, &of, "value", &back);
        }
        Shape::Matrix { .. } => unreachable!("no language has matrices of bools"),
    }
}
