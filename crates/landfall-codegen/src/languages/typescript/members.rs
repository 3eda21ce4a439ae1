//! The accessors of a member: property or methods, and a typed array where its bytes have no holes.

use std::fmt::Write as _;

use rustc_hash::FxHashSet;

use super::comment;
use crate::model::{Element, Matrix, Member, MemberType, Model, free};
use crate::scalar_names::ScalarNames;
use landfall_layout::shape::{Scalar, ScalarKind};

/// As methods of `DataView` and typed arrays have them.
const SCALARS: ScalarNames = ScalarNames {
    sint: ["Int8", "Int16", "Int32", "BigInt64"],
    uint: ["Uint8", "Uint16", "Uint32", "BigUint64"],
    float: ["", "", "Float32", "Float64"],
};

/// How values of a scalar are read and written.
struct DataViewAccess {
    /// The part of a `DataView` method's name, and of a typed array's: `Float32`.
    method: &'static str,
    /// The TypeScript type of a value.
    ty: &'static str,
    width: u64,
    is_bool: bool,
}

impl DataViewAccess {
    fn read(&self, at: &str) -> String {
        // The last argument says little-endian, and is absent for bytes.
        let end = if self.width == 1 { "" } else { ", true" };
        let is = if self.is_bool { " !== 0" } else { "" };
        format!("this.view.get{}({at}{end}){is}", self.method)
    }

    fn write(&self, at: &str, value: &str) -> String {
        let end = if self.width == 1 { "" } else { ", true" };
        let bit = if self.is_bool { " ? 1 : 0" } else { "" };
        format!("this.view.set{}({at}, {value}{bit}{end})", self.method)
    }
}

/// Prints the accessors; `runtime` is the stride of a runtime-sized outer dimension.
pub(super) fn member(
    model: &Model,
    member: &Member,
    runtime: Option<u64>,
    taken: &mut FxHashSet<String>,
    text: &mut String,
) {
    let Member { name, shader_type, ty, .. } = member;
    let offset = member.offset;
    let mut parameters = Vec::new();
    let mut at = if offset == 0 { "this.at".to_string() } else { format!("this.at + {offset}") };
    let length = runtime.map(|stride| {
        let length = free(format!("{name}Length"), taken);
        let _ = write!(
            text,
            "
  /** How many elements of `{}` a shader counts in `view`. */
  get {length}(): number {{
    return Math.max(0, Math.floor((this.view.byteLength - this.at - {offset}) / {stride}));
  }}
",
            member.shader_name
        );
        (format!("this.{length}"), stride)
    });
    let dims = ty.dims.iter().map(|dim| (dim.len.to_string(), dim.stride));
    for (i, (len, stride)) in length.iter().cloned().chain(dims).enumerate() {
        parameters.push(format!("i{i}: number"));
        let _ = write!(at, " + index(i{i}, {len}) * {stride}");
    }
    let mut lines = member.comment.clone();
    lines.push(format!("{shader_type}, offset {offset}"));
    text.push('\n');
    comment(&lines, "  ", text);
    let leaf = match ty.element {
        Element::Structure(of) => {
            let of = &model.structures[of].name;
            let (get, list) = getter(&parameters);
            let _ = write!(
                text,
                "  {get}{name}({list}): {of} {{\n    return new {of}(this.view, {at});\n  }}\n"
            );
            return;
        }
        Element::Scalar(scalar) | Element::Vector { scalar, .. } => access(scalar),
        Element::Matrix(matrix) => access(matrix.scalar),
    };
    accessors(member, &leaf, &parameters, &at, taken, text);
    // A typed array shows bytes as they are: only where components follow each other.
    if let Some(tight) = tight(ty, runtime) {
        let view = free(format!("{name}Array"), taken);
        let count = match &length {
            Some((length, _)) => format!("{length} * {tight}"),
            None => tight.to_string(),
        };
        // A typed array would show a `bool` as its 32 bits, and of one component there is the
        // property.
        if leaf.is_bool || (count == "1" && runtime.is_none()) {
            return;
        }
        let _ = write!(
            text,
            "
  /** All components of `{}`, in the order of their bytes. */
  {view}(): {array}Array {{
    return new {array}Array(this.view.buffer, this.view.byteOffset + this.at + {offset}, {count});
  }}
",
            member.shader_name,
            array = leaf.method,
        );
    }
}

fn getter(parameters: &[String]) -> (&'static str, String) {
    (if parameters.is_empty() { "get " } else { "" }, parameters.join(", "))
}

/// The functions that read and write a scalar, vector or matrix.
fn accessors(
    member: &Member,
    leaf: &DataViewAccess,
    parameters: &[String],
    at: &str,
    taken: &mut FxHashSet<String>,
    text: &mut String,
) {
    let name = &member.name;
    let (get, list) = getter(parameters);
    // With indices there is no property: a method that is named after it.
    let (set, comma) = match parameters {
        [] => (format!("set {name}"), ""),
        _ => {
            let mut chars = name.chars();
            let first = chars.next().map(|c| c.to_ascii_uppercase()).into_iter();
            let capital: String = first.chain(chars).collect();
            (free(format!("set{capital}"), taken), ", ")
        }
    };
    let value = leaf.ty;
    let (returned, given, read, write) = match member.ty.element {
        Element::Scalar(_) | Element::Structure(_) => (
            value.to_string(),
            value.to_string(),
            format!("    return {};\n", leaf.read(at)),
            format!("    {};\n", leaf.write(at, "value")),
        ),
        Element::Vector { rows, .. } => {
            let place = |row: u8| match u64::from(row) * leaf.width {
                0 => "at".to_string(),
                bytes => format!("at + {bytes}"),
            };
            let parts: Vec<String> = (0..rows).map(|row| leaf.read(&place(row))).collect();
            // `exactly` has checked the length: `!` is for `noUncheckedIndexedAccess`, under which
            // elements may be `undefined`.
            let writes: String = (0..rows)
                .map(|row| format!("    {};\n", leaf.write(&place(row), &format!("value[{row}]!"))))
                .collect();
            (
                format!("[{}]", vec![value; rows.into()].join(", ")),
                format!("ArrayLike<{value}>"),
                format!("    const at = {at};\n    return [{}];\n", parts.join(", ")),
                format!("    const at = {at};\n    exactly(value, {rows});\n{writes}"),
            )
        }
        Element::Matrix(matrix) => {
            let (place, count) = component(&matrix, leaf.width);
            let Matrix { columns, rows, .. } = matrix;
            let loops = |body: &str| {
                format!(
                    "    for (let c = 0; c < {columns}; c++) {{\n      for (let r = 0; r < {rows}; \
                     r++) {{\n        {body};\n      }}\n    }}\n"
                )
            };
            let read = loops(&format!("values.push({})", leaf.read(&place)));
            let write = loops(&leaf.write(&place, &format!("value[c * {rows} + r]!")));
            (
                format!("{value}[]"),
                format!("ArrayLike<{value}>"),
                format!(
                    "    const at = {at};\n    const values: {value}[] = [];\n{read}    return \
                     values;\n"
                ),
                format!("    const at = {at};\n    exactly(value, {count});\n{write}"),
            )
        }
    };
    // A setter has no type of its own, a method has.
    let nothing = if parameters.is_empty() { "" } else { ": void" };
    let _ = write!(
        text,
        "  {get}{name}({list}): {returned} {{\n{read}  }}\n\n  {set}({list}{comma}value: {given})\
         {nothing} {{\n{write}  }}\n"
    );
}

/// The place of component `r` of column `c`, and the number of components.
fn component(matrix: &Matrix, width: u64) -> (String, u64) {
    let (vector, lane) = if matrix.row_major { ("r", "c") } else { ("c", "r") };
    let count = u64::from(matrix.columns) * u64::from(matrix.rows);
    (format!("at + {vector} * {} + {lane} * {width}", matrix.stride), count)
}

/// The number of components of all elements, if there is no padding between them; of one element of
/// a runtime-sized array.
fn tight(ty: &MemberType, runtime: Option<u64>) -> Option<u64> {
    let (width, mut components) = match ty.element {
        Element::Scalar(scalar) => (u64::from(scalar.width), 1),
        Element::Vector { scalar, rows } => (u64::from(scalar.width), u64::from(rows)),
        Element::Matrix(matrix) => {
            let (vectors, lanes) = matrix.stored();
            let width = u64::from(matrix.scalar.width);
            if u64::from(lanes) * width != matrix.stride {
                return None;
            }
            (width, u64::from(vectors) * u64::from(lanes))
        }
        Element::Structure(_) => return None,
    };
    // From the innermost dimension outwards: each stride is that of all that lies within.
    for dim in ty.dims.iter().rev() {
        if dim.stride != components * width {
            return None;
        }
        components *= dim.len;
    }
    match runtime {
        Some(stride) if stride != components * width => None,
        Some(_) | None => Some(components),
    }
}

/// How a scalar is read and written; of those that `DataView` lacks, the bits.
fn access(scalar: Scalar) -> DataViewAccess {
    let is_bool = scalar.kind == ScalarKind::Bool;
    let method = SCALARS.of(scalar);
    let ty = match (is_bool, method) {
        (true, _) => "boolean",
        (false, "BigInt64" | "BigUint64") => "bigint",
        (false, _) => "number",
    };
    DataViewAccess { method, ty, width: scalar.width.into(), is_bool }
}
