//! Prints the mirrors: the structure, `new`, `Default`.
//!
//! `new` takes host types (a `glam::Mat3`, a `bool`, an array without padding) and converts them
//! to the shader's representation; [`natural`] and [`conversion`] map each type.
//! [`super::tail`] adds the items of runtime-sized blocks.

use std::fmt::Write as _;

use super::print::{DERIVES, FieldValue, Printer, assignment, default, doc, literal, signature};
use super::types::{
    Bits, Component, GeneratedType, GeneratedTypeId, Mirror, RustType, Shape, component,
};
use super::{Vectors, leaf, tail};

/// The most parameters of a function that clippy accepts.
const MANY: usize = 7;

pub(super) fn mirrors(out: &Printer<'_>, text: &mut String) {
    for (id, mirror) in out.plan.mirrors() {
        structure(out, text, id, mirror);
        new(out, text, id, mirror);
        default(text, out.name(id));
        if let Some(runtime) = &mirror.tail {
            tail::tail(out, text, id, mirror, runtime);
        }
    }
}

fn structure(out: &Printer<'_>, text: &mut String, id: GeneratedTypeId, mirror: &Mirror) {
    let docs = &out.plan.docs[&id];
    let public = out.visibility();
    doc(text, "", &docs.lines());
    let _ = writeln!(text, "#[repr(C)]\n{DERIVES}");
    let gaps = mirror.gaps();
    if mirror.fields.is_empty() && gaps.iter().all(Option::is_none) {
        let _ = writeln!(text, "{public} struct {} {{}}\n", out.name(id));
        return;
    }
    let _ = writeln!(text, "{public} struct {} {{", out.name(id));
    for (at, gap) in gaps.iter().enumerate() {
        if let Some(gap) = gap {
            let (offset, size) = (gap.offset, gap.size);
            let _ = writeln!(text, "    #[doc(hidden)]");
            let _ = writeln!(text, "    {public} _pad_{offset}: [u8; {size}],");
        }
        if let Some(field) = mirror.fields.get(at) {
            doc(text, "    ", &docs.fields[at]);
            let (head, ty) = (format!("{public} {}", field.name), out.ty(&field.ty));
            assignment(text, "    ", &head, ":", &format!("{ty},"));
        }
    }
    text.push_str("}\n\n");
}

fn new(out: &Printer<'_>, text: &mut String, id: GeneratedTypeId, mirror: &Mirror) {
    if mirror.fields.is_empty() {
        return;
    }
    let many = mirror.fields.len() > MANY;
    let allowed = if many { "dead_code, clippy::too_many_arguments" } else { "dead_code" };
    let _ = writeln!(text, "#[allow({allowed})]\nimpl {} {{", out.name(id));
    text.push_str("    /// From its members; padding is zero.\n");
    let parameters: Vec<String> = mirror
        .in_text_order()
        .iter()
        .map(|f| format!("{}: {}", f.name, natural(out, &f.ty).unwrap_or_else(|| out.ty(&f.ty))))
        .collect();
    let head = format!("{} fn new", out.visibility());
    signature(text, "    ", &head, &parameters, " -> Self {");
    let mut fields = Vec::new();
    for (at, gap) in mirror.gaps().iter().enumerate() {
        if let Some(gap) = gap {
            fields.push(FieldValue {
                name: format!("_pad_{}", gap.offset),
                value: format!("[0; {}]", gap.size),
                method: String::new(),
            });
        }
        if let Some(field) = mirror.fields.get(at) {
            let (name, value) = (field.name.clone(), field.name.clone());
            fields.push(FieldValue { name, value, method: conversion(out, &field.ty) });
        }
    }
    literal(text, "        ", &fields);
    text.push_str("    }\n}\n\n");
}

/// The host type of a value stored as `ty`; `None` if it is `ty`.
pub(super) fn natural(out: &Printer<'_>, ty: &RustType) -> Option<String> {
    match ty {
        RustType::Named(_) => None,
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
                Some(format!("[{}; {}]", out.ty(&tight.element), tight.len))
            }
        },
    }
}

fn natural_leaf(out: &Printer<'_>, leaf: super::types::LeafType) -> String {
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

/// The method call that converts a value of the [`natural`] type to `ty`; empty if they are equal.
pub(super) fn conversion(out: &Printer<'_>, ty: &RustType) -> String {
    if natural(out, ty).is_none() {
        return String::new();
    }
    match ty {
        RustType::Named(_) => String::new(),
        RustType::GeneratedType(_) => ".into()".to_string(),
        RustType::Array(element, _) => match &**element {
            RustType::Array(..) => format!(".map(|x| x{})", conversion(out, element)),
            RustType::GeneratedType(_) | RustType::Named(_) => ".map(Into::into)".to_string(),
        },
    }
}
