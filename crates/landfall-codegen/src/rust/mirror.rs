//! Prints the mirrors: the structure, the structure of its members, `new`, `Default`.
//!
//! `new` takes all members by name, so that members that change places in the shader keep their
//! bytes, and a new one does not compile until it has a value. [`super::host`] maps the types.
//! [`super::tail`] adds the items of runtime-sized blocks.

use std::fmt::Write as _;

use super::header::{is_long, is_long_count};
use super::host::{natural, stored};
use super::print::{
    DERIVES, FieldValue, Printer, Text, assignment, conversion, default, doc, literal, signature,
};
use super::tail;
use super::types::{GeneratedTypeId, Mirror};

pub(super) fn mirrors(out: &Printer<'_>, text: &mut Text) {
    for (id, mirror) in out.mirrors() {
        structure(out, text, id, mirror);
        init(out, text, id, mirror);
        default(text, out.name(id));
        if let Some(runtime) = &mirror.tail {
            tail::tail(out, text, id, mirror, runtime);
        }
    }
}

fn structure(out: &Printer<'_>, text: &mut Text, id: GeneratedTypeId, mirror: &Mirror) {
    let docs = &out.plan.docs[&id];
    let public = out.visibility();
    doc(text, "", &docs.lines());
    let _ = writeln!(text, "{}#[repr(C)]\n{DERIVES}", out.derives());
    // All padding is a field, since `Pod` allows none that is implicit.
    let gaps = mirror.gaps();
    if mirror.fields.is_empty() && gaps.iter().all(Option::is_none) {
        let _ = writeln!(text, "{public} struct {} {{}}\n", out.name(id));
        return;
    }
    let _ = writeln!(text, "{public} struct {} {{", out.name(id));
    // Before each field its gap; the last gap is the padding at the end.
    for (at, gap) in gaps.iter().enumerate() {
        if let Some(gap) = gap {
            let (offset, size) = (gap.offset, gap.size);
            let _ = writeln!(text, "    #[doc(hidden)]");
            let needed = feature(is_long_count(size));
            let _ = writeln!(text, "    {public} _pad_{offset}: [u8; {size}],{needed}");
        }
        if let Some(field) = mirror.fields.get(at) {
            doc(text, "    ", &docs.fields[at]);
            let (head, ty) = (format!("{public} {}", field.name), out.ty(&field.ty));
            assignment(text, "    ", &head, ":", &format!("{ty},"));
            if is_long(&field.ty) {
                text.text.pop();
                let _ = writeln!(text, "{}", feature(true));
            }
        }
    }
    text.push_str("}\n\n");
}

/// What an array needs, in the line that the compiler quotes where it is missing.
fn feature(is_needed: bool) -> &'static str {
    if is_needed { " // needs `min_const_generics` of bytemuck" } else { "" }
}

/// Prints the structure of a mirror's members, and the constructor that takes it.
fn init(out: &Printer<'_>, text: &mut Text, id: GeneratedTypeId, mirror: &Mirror) {
    if mirror.fields.is_empty() {
        return;
    }
    let (name, init, public) = (out.name(id), &out.names.inits[&id], out.visibility());
    doc(text, "", &[format!("The members of [`{name}`] by name, for `{name}::new`.")]);
    text.push_str("#[derive(Clone, Copy, Debug, PartialEq)]\n#[allow(dead_code)]\n");
    text.push_str(&out.derives());
    let _ = writeln!(text, "{public} struct {init} {{");
    let docs = &out.plan.docs[&id];
    // In the order of the shader's text, in which a program is written, too.
    for field in mirror.in_text_order() {
        let ty = natural(out, &field.ty).unwrap_or_else(|| out.ty(&field.ty));
        doc(text, "    ", &[format!("`{}`.", docs.declared[field.order])]);
        assignment(text, "    ", &format!("{public} {}", field.name), ":", &format!("{ty},"));
    }
    let _ = writeln!(text, "}}\n\n#[allow(dead_code)]\nimpl {name} {{");
    text.push_str("    /// From its members; padding is zero.\n    #[inline]\n");
    let head = format!("{public} const fn new");
    signature(text, "    ", &head, &[format!("init: {init}")], " -> Self {");
    let mut fields = Vec::new();
    for (at, gap) in mirror.gaps().iter().enumerate() {
        if let Some(gap) = gap {
            let (name, value) = (format!("_pad_{}", gap.offset), format!("[0; {}]", gap.size));
            fields.push(FieldValue { name, value });
        }
        if let Some(field) = mirror.fields.get(at) {
            let value = stored(out, &field.ty, &format!("init.{}", field.name), "            ");
            fields.push(FieldValue { name: field.name.clone(), value });
        }
    }
    literal(text, "        ", &fields);
    text.push_str("    }\n}\n\n");
    conversion(text, init, name, "init", "Self::new(init)");
}
