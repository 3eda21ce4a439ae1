//! `array-stride-waste`: arrays whose elements fill a quarter or half of their stride.

use std::sync::Arc;

use super::definition::{Check, Lint, Subject};
use super::show::{bytes, number};
use super::walk::{Visit, declared, per_member};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::occupied;
use landfall_layout::layout::rules::type_layout;
use landfall_layout::shape::{ArrayLen, MatrixLayout, Type};

pub(super) const LINT: Lint = Lint {
    code: "array-stride-waste",
    // It costs memory, not correctness, and packing costs an index.
    level: Level::Allow,
    what: "an array of scalars or small vectors that could be packed into larger vectors",
    why: "std140 places the elements of every array 16 bytes apart: a `float[64]` takes 1024 \
          bytes, three quarters of them padding, of the 16384 that every implementation guarantees \
          for a uniform block. Packed into `vec4 w[16]` it takes 256. Allowed by default, because \
          it wastes memory but is correct.",
    example: "\
#version 330 core
layout(std140) uniform Kernel {
    float w[64]; // 1024 bytes
};
void main() {}
",
    fix: "Declare `vec4 w[16]` and read `w[i / 4][i % 4]`.",
    check: Check::Shader(|subject, _| per_member(subject, waste)),
};

fn waste(subject: &Subject<'_>, visit: &Visit<'_>) -> Option<Finding> {
    // Where the driver chooses the layout, no offset is certain.
    if !visit.block.rules_declared {
        return None;
    }
    let member = visit.member();
    let element = member.ty.innermost();
    // The innermost dimension is the one that is packed.
    let stride = *member.strides.last()?;
    let own = occupied(element);
    let packed = packing(element)?;
    // At least half of every element is padding.
    if stride < 2 * own {
        return None;
    }
    let new = with_last_dimension(&member.ty, &packed)?;
    let type_layout = type_layout(&new, visit.block.rules, MatrixLayout::Column).ok()?;
    let language = subject.shader.language;
    let spelled = element.spelled(language);
    let declaration = declared(&member.name, &new, language);
    let read = reading(&member.name, member.dims.len(), new.dims().len(), &packed);
    let (message, help) = match (member.size, type_layout.size) {
        (Some(old), Some(new)) if new < old => (
            format!(
                "`{}` is {}: its elements are {}, {stride} apart",
                member.name,
                bytes(old),
                bytes(own),
            ),
            format!(
                "declare `{declaration}` and read {read}: {}, {} saved",
                bytes(new),
                number(old - new)
            ),
        ),
        (Some(_), _) => return None,
        // A runtime-sized array has a stride, but no size.
        (None, _) => (
            format!(
                "each `{spelled}` of `{}` takes up {stride} bytes and holds {own}",
                member.name
            ),
            format!(
                "declare `{declaration}` and read {read}: {stride} bytes for {} elements",
                packed.count
            ),
        ),
    };
    Some(
        visit
            .finding(subject, LINT.code, message)
            .with_text(format!("array stride {stride}"))
            .with_help(help),
    )
}

/// A larger vector, and the number of elements it holds.
struct StridePacking {
    vector: Type,
    count: u32,
    /// The number of components of one element.
    rows: u8,
}

/// Returns the vector of up to 16 bytes that holds several elements.
fn packing(element: &Type) -> Option<StridePacking> {
    let (scalar, rows) = match *element {
        Type::Scalar(scalar) => (scalar, 1u8),
        Type::Vector { scalar, rows } => (scalar, rows),
        // An atomic stands alone; matrices and structures do not pack.
        Type::Atomic(_)
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => return None,
    };
    // No vector has more than four components; two doubles fill the stride of std140.
    let components: u8 = if scalar.width == 8 { 2 } else { 4 };
    let count = components / rows;
    (count >= 2).then(|| StridePacking {
        vector: Type::Vector { scalar, rows: components },
        count: count.into(),
        rows,
    })
}

/// Returns the array with its innermost dimension packed; `None` if its length is an override.
fn with_last_dimension(ty: &Type, packed: &StridePacking) -> Option<Type> {
    let Type::Array { element, len } = ty else { return None };
    if let Type::Array { .. } = &**element {
        let element = Arc::new(with_last_dimension(element, packed)?);
        return Some(Type::Array { element, len: len.clone() });
    }
    let len = match len {
        // One vector takes them all.
        ArrayLen::Fixed(n) if *n <= packed.count => return Some(packed.vector.clone()),
        ArrayLen::Fixed(n) => ArrayLen::Fixed(n.div_ceil(packed.count)),
        ArrayLen::Runtime => ArrayLen::Runtime,
        ArrayLen::Override(_) => return None,
    };
    Some(Type::Array { element: Arc::new(packed.vector.clone()), len })
}

/// Returns the expression that reads an element: `` `w[i / 4][i % 4]` ``, `` `w[i / 2].xy` or `.zw`
/// ``.
fn reading(name: &str, old: usize, new: usize, packed: &StridePacking) -> String {
    // The indices are `i`, `j`, `k` from outside, so the packed dimension has the next one.
    let outer = ["[i]", "[j]", "[k]"].iter().cycle().take(old - 1).copied().collect::<String>();
    let index = ["i", "j", "k"][(old - 1) % 3];
    let count = packed.count;
    match (packed.rows, new < old) {
        (1, false) => format!("`{name}{outer}[{index} / {count}][{index} % {count}]`"),
        (1, true) => format!("`{name}{outer}[{index}]`"),
        (_, false) => format!("`{name}{outer}[{index} / {count}].xy` or `.zw`"),
        (_, true) => format!("`{name}{outer}.xy` or `.zw`"),
    }
}
