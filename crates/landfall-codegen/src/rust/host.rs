//! The types that a program has for values of the shader: a `glam::Mat3` for three columns 16 bytes
//! apart, a `bool` for 4 bytes, an array without padding; and the expressions that store them.

use std::fmt::Write as _;

use super::print::{Printer, assignment, indices};
use super::types::{Bits, Component, GeneratedType, LeafType, RustType, Shape, component};
use super::{Vectors, leaf};

/// The host type of a value stored as `ty`; `None` if it is `ty`.
pub(super) fn natural(out: &Printer<'_>, ty: &RustType) -> Option<String> {
    match ty {
        RustType::Named(_) | RustType::User(_) => None,
        RustType::Array(element, len) => natural(out, element).map(|ty| format!("[{ty}; {len}]")),
        RustType::GeneratedType(id) => match out.plan.get(*id) {
            GeneratedType::Mirror(_) => None,
            GeneratedType::Bits(Bits::Bool) => Some("bool".to_string()),
            GeneratedType::Bits(Bits::F16 | Bits::Bf16 | Bits::F8E5m2 | Bits::F8E4m3) => None,
            GeneratedType::Leaf(leaf) => Some(natural_leaf(out, *leaf)),
            GeneratedType::Padded(padded) => {
                Some(natural(out, &padded.inner).unwrap_or_else(|| out.ty(&padded.inner)))
            }
            GeneratedType::Tight(tight) => {
                let element = natural(out, &tight.element);
                let element = element.unwrap_or_else(|| out.ty(&tight.element));
                Some(format!("[{element}; {}]", tight.len))
            }
        },
    }
}

/// The host type of a leaf that is a type of its own.
pub(super) fn natural_leaf(out: &Printer<'_>, leaf: LeafType) -> String {
    let scalar = match component(leaf.scalar) {
        Component::Bits(Bits::Bool) => "bool",
        Component::Bits(_) | Component::Plain(_) => out.component(leaf.scalar),
    };
    let glam = out.options.vectors == Vectors::Glam;
    match leaf.shape {
        Shape::Scalar => scalar.to_string(),
        Shape::Vector { rows } => match leaf::glam_vector(leaf.scalar, rows) {
            Some(ty) if glam => ty.to_string(),
            _ => format!("[{scalar}; {rows}]"),
        },
        Shape::Matrix { columns, rows, .. } => match leaf::glam_matrix(leaf.scalar, columns) {
            Some((ty, _)) if glam && columns == rows => ty.to_string(),
            _ => match leaf::glam_vector(leaf.scalar, rows) {
                Some(column) if glam => format!("[{column}; {columns}]"),
                _ => format!("[[{scalar}; {rows}]; {columns}]"),
            },
        },
    }
}

/// The constant expression of type `ty` that stores `value` of the [`natural`] type. Its lines
/// after the first are indented by `indent`.
pub(super) fn stored(out: &Printer<'_>, ty: &RustType, value: &str, indent: &str) -> String {
    if natural(out, ty).is_none() {
        return value.to_string();
    }
    // The dimensions, and what each element is stored as.
    let (mut of, mut lens) = (ty, Vec::new());
    while let RustType::Array(element, len) = of {
        lens.push(*len);
        of = element;
    }
    let helper = out.ty(of);
    if lens.is_empty() {
        return format!("{helper}::new({value})");
    }
    // `map` is no `const fn`, so each dimension is a loop.
    let names = indices(lens.len());
    let inside = format!("{indent}    ");
    let mut text = out.text();
    let _ = write!(text, "{{\n{inside}let from = {value};\n");
    // An array needs elements before the loops replace them: all are the first one.
    let first = format!("{helper}::new(from{})", "[0]".repeat(lens.len()));
    let all = lens.iter().rev().fold(first, |all, len| format!("[{all}; {len}]"));
    assignment(&mut text, &inside, "let mut to", " =", &format!("{all};"));
    for (depth, (name, len)) in names.iter().zip(&lens).enumerate() {
        let at = format!("{inside}{}", "    ".repeat(depth));
        let _ = write!(text, "{at}let mut {name} = 0;\n{at}while {name} < {len} {{\n");
    }
    let at = format!("{inside}{}", "    ".repeat(lens.len()));
    let element: String = names.iter().map(|name| format!("[{name}]")).collect();
    let (to, value) = (format!("to{element}"), format!("{helper}::new(from{element});"));
    assignment(&mut text, &at, &to, " =", &value);
    for (depth, name) in names.iter().enumerate().rev() {
        let at = format!("{inside}{}", "    ".repeat(depth));
        let _ = write!(text, "{at}    {name} += 1;\n{at}}}\n");
    }
    let _ = write!(text, "{inside}to\n{indent}}}");
    text.text
}
