//! Checks that a Rust field has a member's bytes where the shader reads them.
//!
//! [`compare`](super::compare) compares offsets; here a field and a member start at the same byte.
//! Structures on both sides are returned as pairs, to be compared field by field.

use std::rc::Rc;

use super::library::MirrorWriter;
use super::rust_type::{RustType, Shape, StructureLayout};
use super::suggest::suggested;
use crate::show;
pub use landfall_layout::layout::measure::{element_size, fixed, matrix_vector};
use landfall_layout::layout::{MemberLayout, occupied};
use landfall_layout::shape::{Rules, Scalar, ScalarKind, Type};
use landfall_layout::source::Language;

/// A mismatch of a field.
pub(super) struct FieldMismatch {
    /// The predicate of the message, after the field's name, with both numbers.
    pub text: String,
    pub help: String,
    /// The size and alignment of the field once the help is followed; `None` if unchanged.
    pub becomes: Option<(u64, u64)>,
    /// The structure of the elements, where its size is not the stride.
    pub element: Option<Rc<StructureLayout>>,
}

/// A member, or its elements below some array dimension.
#[derive(Clone, Copy)]
pub(super) struct MemberView<'a> {
    pub member: &'a MemberLayout,
    pub rules: Rules,
    pub language: Language,
    /// The first dimension included.
    pub dim: usize,
    /// What places the field in the buffer.
    pub writer: MirrorWriter,
}

/// Compares a field with a member; pairs of structures are added to `pairs`.
pub(super) fn fit<'a>(
    ty: &RustType,
    view: MemberView<'a>,
    pairs: &mut Vec<(Rc<StructureLayout>, &'a MemberLayout)>,
) -> Result<(), FieldMismatch> {
    match (view.member.dims.get(view.dim), view.member.strides.get(view.dim)) {
        (Some(len), Some(&stride)) => array(ty, view, fixed(len), stride, pairs),
        (_, _) => element(ty, view, pairs),
    }
}

fn array<'a>(
    ty: &RustType,
    view: MemberView<'a>,
    len: Option<u64>,
    stride: u64,
    pairs: &mut Vec<(Rc<StructureLayout>, &'a MemberLayout)>,
) -> Result<(), FieldMismatch> {
    let spelled = view.member.ty.innermost().spelled(view.language).to_string();
    let (inner, count) = match &ty.shape {
        Shape::Array { element, len } => (element, *len),
        Shape::Struct(laid) => match laid.fields.as_slice() {
            // A structure around one array, often for its alignment.
            [only] => return fit(&only.ty, view, pairs),
            _ => return Err(no_array(ty, view)),
        },
        Shape::Scalar { .. } => return Err(no_array(ty, view)),
    };
    // The elements are as far apart as the shader's: their number and contents remain.
    if inner.size == stride {
        if len.is_some_and(|len| len != count) {
            let len = len.unwrap_or(0);
            let text = format!("has {count} elements, the shader's has {len}");
            let (help, becomes) = match view.dim {
                0 => {
                    let size = stride.checked_mul(len);
                    (format!("make it {len} elements long"), size.map(|size| (size, ty.align)))
                }
                _ => remade(view, || format!("make its inner arrays {len} elements long")),
            };
            return Err(FieldMismatch { text, help, becomes, element: None });
        }
        return fit(inner, MemberView { dim: view.dim + 1, ..view }, pairs);
    }
    let whole = len.and_then(|len| stride.checked_mul(len));
    // `[[f32; 4]; 6]` for `float[2][3]`: the dimensions run on in one.
    let last = *view.member.strides.last().expect("an array has strides");
    let all: Option<u64> = view.member.dims[view.dim..]
        .iter()
        .try_fold(1u64, |product, len| product.checked_mul(fixed(len)?));
    if inner.size == last && all == Some(count) && whole == last.checked_mul(count) {
        return fit(inner, MemberView { dim: view.member.dims.len(), ..view }, pairs);
    }
    // Flat bytes or components, as many as there are bytes; or both sides without padding.
    let flat = scalar_of(ty).filter(|scalar| fits_component(scalar, view.member.ty.innermost()));
    if flat.is_some() && is_flat(ty) && whole.is_some_and(|whole| ty.size == whole) {
        return Ok(());
    }
    let packed = occupied(view.member.ty.innermost()) == last && whole.is_some();
    if flat.is_some() && packed && whole == Some(ty.size) {
        return Ok(());
    }
    let text = format!(
        "has elements {} bytes apart, the shader's `{spelled}`s are {stride} apart",
        inner.size
    );
    // The structure is reported as too small or too large, and is compared as well.
    if let Shape::Struct(laid) = &inner.shape {
        pairs.push((laid.clone(), view.member));
        let becomes = stride.checked_mul(len.unwrap_or(count)).map(|size| (size, ty.align));
        let help = format!("make `{}` {}", laid.name, show::bytes(stride));
        return Err(FieldMismatch { text, help, becomes, element: Some(laid.clone()) });
    }
    let (help, becomes) = remade(view, || format!("make each element {stride} bytes"));
    Err(FieldMismatch { text, help, becomes, element: None })
}

/// Returns the help that gives the whole field the type that fits, and its size and alignment then.
fn remade(view: MemberView<'_>, otherwise: impl Fn() -> String) -> (String, Option<(u64, u64)>) {
    match suggested(MemberView { dim: 0, ..view }) {
        Some(fit) => (format!("make it `{}`", fit.text), Some((fit.size, fit.align))),
        None => (otherwise(), None),
    }
}

fn no_array(ty: &RustType, view: MemberView<'_>) -> FieldMismatch {
    let stride = || "make it an array with the stride of the shader's array".to_string();
    let (help, becomes) = remade(view, stride);
    FieldMismatch {
        text: format!(
            "is {} bytes and not an array, the shader's is `{}`",
            ty.size,
            view.member.ty.spelled(view.language)
        ),
        help,
        becomes,
        element: None,
    }
}

fn element<'a>(
    ty: &RustType,
    view: MemberView<'a>,
    pairs: &mut Vec<(Rc<StructureLayout>, &'a MemberLayout)>,
) -> Result<(), FieldMismatch> {
    let innermost = view.member.ty.innermost();
    match innermost {
        Type::Struct(s) => {
            if let Shape::Struct(laid) = &ty.shape {
                pairs.push((laid.clone(), view.member));
                return Ok(());
            }
            // Flat bytes or words: their contents are unknown here.
            let size = element_size(view.member, view.rules);
            match scalar_of(ty).is_some() && ty.size >= size {
                true => Ok(()),
                false => Err(FieldMismatch {
                    text: format!("is {} bytes, the shader's `{}` is {size}", ty.size, s.name),
                    help: "make it a structure with the same members".to_string(),
                    becomes: Some((size, ty.align)),
                    element: None,
                }),
            }
        }
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Array { .. } => leaf(ty, view),
    }
}

/// A scalar, vector or matrix.
fn leaf(ty: &RustType, view: MemberView<'_>) -> Result<(), FieldMismatch> {
    let leaf = view.member.ty.innermost();
    let spelled = leaf.spelled(view.language).to_string();
    let (scalar, offsets) = components(view.member);
    let width = u64::from(scalar.width);
    let end = offsets.last().map_or(0, |last| last + width);
    let columns = matrix_vector(view.member).zip(view.member.matrix_stride);
    let misfit = |text: String| {
        let (help, becomes) = remade(view, || format!("declare it as the shader's `{spelled}`"));
        FieldMismatch { text, help, becomes, element: None }
    };
    // The distance of columns says more than a component that is missing.
    if let Some((vector, stride)) = columns {
        let name = if view.member.row_major { "rows" } else { "columns" };
        if let Some(apart) = column_stride(ty, vector.count).filter(|apart| *apart != stride) {
            return Err(misfit(format!(
                "is {} bytes with {name} {apart} apart, the shader's `{spelled}` is {} with {name} \
                 {stride} apart",
                ty.size,
                stride * vector.count,
            )));
        }
    }
    // What is at each byte of the field, against what the shader reads there.
    let mut found = Vec::new();
    flatten(ty, 0, &mut found);
    let bytes = found.iter().all(|(_, width, _)| *width == 1) && width > 1;
    if ty.size < end {
        let size = show::bytes(ty.size);
        return Err(misfit(format!("is {size}, the shader's `{spelled}` is {end}")));
    }
    // Flat bytes: their contents are unknown here.
    if bytes && found.len() > 1 {
        return Ok(());
    }
    for offset in &offsets {
        let Some((_, own, kind)) = found.iter().find(|(at, ..)| at == offset) else {
            let text = format!("has no component at byte {offset}, the shader's `{spelled}` has");
            return Err(misfit(text));
        };
        if *own != width {
            let own = show::bytes(*own);
            let text = format!("has components of {own}, the shader's `{spelled}` of {width}");
            return Err(misfit(text));
        }
        if kind.is_float() != scalar.kind.is_float() {
            let name = if kind.is_float() { "a float" } else { "an integer" };
            let text = format!("is {name}, the shader reads its bits as `{spelled}`");
            return Err(misfit(text));
        }
    }
    Ok(())
}

/// Returns a leaf's component type, and the byte offsets of its components.
pub(super) fn components(member: &MemberLayout) -> (Scalar, Vec<u64>) {
    match *member.ty.innermost() {
        Type::Scalar(scalar) | Type::Atomic(scalar) => (scalar, vec![0]),
        Type::Vector { scalar, rows } => {
            (scalar, (0..u64::from(rows)).map(|row| row * u64::from(scalar.width)).collect())
        }
        Type::Matrix { scalar, .. } => {
            let width = u64::from(scalar.width);
            let vector = matrix_vector(member).expect("a matrix has columns");
            let stride = member.matrix_stride.unwrap_or(vector.bytes);
            let of =
                |column| (0..vector.bytes / width).map(move |row| column * stride + row * width);
            (scalar, (0..vector.count).flat_map(of).collect())
        }
        Type::Address(_) => (Scalar::U64, vec![0]),
        Type::Struct(_) | Type::Array { .. } => (Scalar::U32, Vec::new()),
    }
}

/// Returns the stride of columns in a type with as many columns; `None` if it has no columns.
fn column_stride(ty: &RustType, count: u64) -> Option<u64> {
    match &ty.shape {
        Shape::Array { element, len } if *len >= count => match element.shape {
            Shape::Array { .. } | Shape::Struct(_) => Some(element.size),
            Shape::Scalar { .. } => None,
        },
        Shape::Struct(laid) => match laid.fields.as_slice() {
            [only] => column_stride(&only.ty, count),
            _ => None,
        },
        Shape::Array { .. } | Shape::Scalar { .. } => None,
    }
}

/// The most components examined; no leaf has more than 16, a padded one twice that.
const MAX_COMPONENTS: usize = 64;

fn flatten(ty: &RustType, at: u64, found: &mut Vec<(u64, u64, ScalarKind)>) {
    // What is empty has no components, however often it is repeated.
    if found.len() >= MAX_COMPONENTS || ty.size == 0 {
        return;
    }
    match &ty.shape {
        Shape::Scalar { kind, .. } => found.push((at, ty.size, *kind)),
        Shape::Array { element, len } => {
            for index in 0..(*len).min(MAX_COMPONENTS as u64) {
                flatten(element, at + index * element.size, found);
            }
        }
        Shape::Struct(laid) => {
            for field in laid.fields.iter().take(MAX_COMPONENTS) {
                flatten(&field.ty, at + field.offset, found);
            }
        }
    }
}

/// Returns the only scalar type in a type: name, width, kind.
fn scalar_of(ty: &RustType) -> Option<(&'static str, u64, ScalarKind)> {
    match &ty.shape {
        Shape::Scalar { kind, name } => Some((name, ty.size, *kind)),
        Shape::Array { element, .. } => scalar_of(element),
        Shape::Struct(_) => None,
    }
}

/// Returns whether a type is an array of scalars.
fn is_flat(ty: &RustType) -> bool {
    match &ty.shape {
        Shape::Array { element, .. } => matches!(element.shape, Shape::Scalar { .. }),
        Shape::Scalar { .. } | Shape::Struct(_) => false,
    }
}

/// Returns whether a flat array of it can hold a leaf's components.
fn fits_component(scalar: &(&'static str, u64, ScalarKind), leaf: &Type) -> bool {
    let own = match leaf {
        Type::Scalar(own) | Type::Atomic(own) => *own,
        Type::Vector { scalar, .. } | Type::Matrix { scalar, .. } => *scalar,
        Type::Address(_) => Scalar::U64,
        // Words of a structure.
        Type::Struct(_) | Type::Array { .. } => return true,
    };
    let (_, width, kind) = *scalar;
    width == 1 || (width == u64::from(own.width) && kind.is_float() == own.kind.is_float())
}
