//! The fields of a structure, and methods that return references to elements of arrays.

use std::fmt::Write as _;

use super::comment;
use super::support::Support;
use crate::model::{Element, Member, MemberType, Model};

/// Prints a field, or the method of an array.
pub(super) fn member(
    model: &Model,
    owner: &str,
    member: &Member,
    support: &mut Support,
    text: &mut String,
) {
    let Member { name, shader_type, offset, ty, .. } = member;
    let element = spelled(model, ty, support);
    comment("//", &member.comment, "    ", text);
    let _ = writeln!(text, "    // {shader_type}, offset {offset}");
    if ty.dims.is_empty() {
        let _ = writeln!(text, "    [FieldOffset({offset})] public {element} {name};");
        return;
    }
    let dims: Vec<(String, u64)> =
        ty.dims.iter().map(|dim| (dim.len.to_string(), dim.stride)).collect();
    // C# 7.3 has no arrays of structures within a structure: a method computes the place.
    let AccessorPlace { parameters, place } = access(*offset, &dims, support);
    let _ = write!(
        text,
        "    public ref {element} {name}({parameters})
    {{
        fixed ({owner}* self = &this)
        {{
            return ref *({element}*)((byte*)self + {place});
        }}
    }}
"
    );
}

/// Prints the method of a runtime-sized array, which reads a buffer.
pub(super) fn of_tail(
    model: &Model,
    member: &Member,
    stride: u64,
    support: &mut Support,
    text: &mut String,
) {
    let Member { name, shader_type, offset, ty, .. } = member;
    let element = spelled(model, ty, support);
    // How many elements there are is known from the buffer alone.
    let mut dims = vec![(format!("(bytes.LongLength - {offset}) / {stride}"), stride)];
    dims.extend(ty.dims.iter().map(|dim| (dim.len.to_string(), dim.stride)));
    let AccessorPlace { parameters, place } = access(*offset, &dims, support);
    comment("//", &member.comment, "    ", text);
    let _ = write!(
        text,
        "    // {shader_type}, offset {offset}: an element in a buffer.
    public static ref {element} {name}(byte[] bytes, {parameters})
    {{
        fixed (byte* self = bytes)
        {{
            return ref *({element}*)(self + {place});
        }}
    }}
"
    );
}

/// The parameters of a method, and the place of the element in bytes.
struct AccessorPlace {
    parameters: String,
    place: String,
}

fn access(offset: u64, dims: &[(String, u64)], support: &Support) -> AccessorPlace {
    let parameters: Vec<String> = (0..dims.len()).map(|i| format!("long i{i}")).collect();
    let mut place = offset.to_string();
    for (i, (len, stride)) in dims.iter().enumerate() {
        let _ = write!(place, " + {}.Index(i{i}, {len}) * {stride}", support.check());
    }
    AccessorPlace { parameters: parameters.join(", "), place }
}

/// The C# type of an element.
pub(super) fn spelled(model: &Model, ty: &MemberType, support: &mut Support) -> String {
    match ty.element {
        Element::Scalar(scalar) => support.scalar(scalar),
        Element::Vector { scalar, rows } => support.vector(scalar, rows),
        Element::Matrix(matrix) => support.matrix(matrix),
        Element::Structure(at) => model.structures[at].name.clone(),
    }
}
