//! Layouts as a script for Godot: a class of functions over a `PackedByteArray` for each structure and
//! block.

use std::fmt::Write as _;

use crate::assertions;
use crate::language::{CodeOptions, CodeOutput, OutputLanguage};
use crate::model::{Element, Matrix, Member, Model, Naming, Placement, Structure, comment, header};
use crate::scalar_names::ScalarNames;
use landfall_layout::ShaderLayout;
use landfall_layout::shape::ScalarKind;

/// GDScript of Godot 4.
pub const GDSCRIPT: OutputLanguage = OutputLanguage {
    name: "gdscript",
    title: "GDScript",
    about: "A Godot script that reads and writes members in a `PackedByteArray`",
    options: &["--prefix"],
    write,
    assert: assertions::none,
};

const NAMING: Naming = Naming {
    reserved: "if elif else for while match when break continue pass return class class_name extends \
        is in as self super signal func static const enum var breakpoint preload await yield assert \
        void PI TAU INF NAN true false null not and or bool int float maxi",
    // What Godot calls so, shaders do too.
    types: "String StringName NodePath Vector2 Vector2i Vector3 Vector3i Vector4 Vector4i Rect2 Rect2i \
        Transform2D Transform3D Plane Quaternion AABB Basis Projection Color RID Callable Signal \
        Dictionary Array Variant PackedByteArray PackedInt32Array PackedInt64Array PackedFloat32Array \
        PackedFloat64Array Object RefCounted Resource Node Material Environment Sky Mesh Texture \
        Shader Image Curve Gradient Range Input Engine Time Window Viewport Control Button Label \
        Timer Theme Font Tween Thread Mutex Semaphore Decal Skin SIZE bytes at value n",
    // `get_` and `set_` of these are Godot's own.
    members: "meta meta_list script property_list instance_id deferred indexed method_list signal_list \
        signal_connection_list incoming_connections reference_count block_signals \
        message_translation translation_domain",
    is_reserved: |_| false,
};

/// The ends of the names of Godot's functions.
const SCALARS: ScalarNames = ScalarNames {
    sint: ["s8", "s16", "s32", "s64"],
    uint: ["u8", "u16", "u32", "u64"],
    float: ["", "half", "float", "double"],
};

fn write(shaders: &[&ShaderLayout], options: &CodeOptions) -> CodeOutput {
    let model = Model::new(shaders, NAMING, &options.prefix, Placement::Offsets, GDSCRIPT.title);
    let notes = [
        "Needs Godot 4. `at` is the byte where a structure begins: 0 for a block, `at_NAME` for a",
        "structure in another.",
    ];
    let mut text = header(shaders, "#", &notes);
    for (name, value) in &model.constants {
        let _ = writeln!(text, "\n## A constant of the shader, by which it gives lengths.");
        let _ = writeln!(text, "const {name} := {value}");
    }
    for structure in &model.structures {
        class(&model, structure, &mut text);
    }
    CodeOutput { text, diagnostics: model.diagnostics }
}

fn class(model: &Model, structure: &Structure, text: &mut String) {
    let Structure { name, size, .. } = structure;
    text.push('\n');
    comment("##", &structure.comment, "", text);
    let _ = writeln!(text, "## {}.\nclass {name}:\n\tconst SIZE := {size}", structure.about());
    if structure.is_block {
        create(structure, text);
    }
    for (member, runtime) in structure.all_members() {
        functions(model, member, runtime, text);
    }
}

/// Writes what makes a buffer of a block.
fn create(structure: &Structure, text: &mut String) {
    let (parameter, bytes) = match &structure.tail {
        Some(_) => ("n: int", "size_for(n)"),
        None => ("", "SIZE"),
    };
    if let Some(tail) = &structure.tail {
        let (stride, least) = (tail.stride, tail.sizes.least);
        let _ = write!(
            text,
            "\n\t## Bytes of a buffer in which a shader counts `n` elements of `{}`; at least {least}.\n\t\
             static func size_for(n: int) -> int:\n\t\treturn {}\n",
            tail.member.shader_name,
            tail.size(&format!("maxi(SIZE + n * {stride}, {least})")),
        );
    }
    let _ = write!(
        text,
        "\n\t## A zeroed buffer.\n\tstatic func create({parameter}) -> PackedByteArray:\n\t\t\
         var buffer := PackedByteArray()\n\t\tbuffer.resize({bytes})\n\t\tbuffer.fill(0)\n\t\t\
         return buffer\n"
    );
}

/// Writes the functions of a member; `runtime` is the stride of a runtime-sized tail.
fn functions(model: &Model, member: &Member, runtime: Option<u64>, text: &mut String) {
    let Member { name, shader_type, offset, ty, .. } = member;
    let (mut indices, mut place) = (String::new(), format!("at + {offset}"));
    // GDScript has no structures: a member is a function of the byte at which its structure begins.
    for (i, stride) in member.strides(runtime).into_iter().enumerate() {
        let _ = write!(indices, ", i{i}: int");
        let _ = write!(place, " + i{i} * {stride}");
    }
    text.push('\n');
    comment("##", &member.comment, "\t", text);
    let Some(value) = EncodedValue::from_element(ty.element) else {
        let Element::Structure(at) = ty.element else { unreachable!("all others are values") };
        let _ = write!(
            text,
            "\t## Where a `{}` begins, of `{shader_type}` at offset {offset}.\n\t\
             static func at_{name}(at: int{indices}) -> int:\n\t\treturn {place}\n",
            model.structures[at].name
        );
        return;
    };
    let ty = value.ty;
    let _ = write!(
        text,
        "\t## {shader_type}, offset {offset}.\n\t\
         static func get_{name}(bytes: PackedByteArray, at: int{indices}) -> {ty}:\n\t\t\
         at = {place}\n\t\treturn {}\n\n\t\
         static func set_{name}(bytes: PackedByteArray, at: int{indices}, value: {ty}) -> void:\n\t\t\
         at = {place}\n{}",
        value.read(),
        value.write(),
    );
}

/// A value of GDScript, and where its components lie.
struct EncodedValue {
    ty: &'static str,
    /// The end of `encode_` and `decode_`.
    scalar: &'static str,
    /// Column by column, the bytes of the components.
    columns: Vec<Vec<u64>>,
}

impl EncodedValue {
    fn from_element(element: Element) -> Option<EncodedValue> {
        let (of, columns, rows, matrix) = match element {
            Element::Scalar(scalar) => (scalar, 1, 1, None),
            Element::Vector { scalar, rows } => (scalar, 1, rows, None),
            Element::Matrix(matrix) => (matrix.scalar, matrix.columns, matrix.rows, Some(matrix)),
            Element::Structure(_) => return None,
        };
        let width = u64::from(of.width);
        let place = |column: u64, row: u64| match matrix {
            Some(Matrix { stride, row_major: true, .. }) => row * stride + column * width,
            Some(Matrix { stride, .. }) => column * stride + row * width,
            None => row * width,
        };
        let column = |at: u8| (0..rows).map(|row| place(at.into(), row.into())).collect();
        let scalar = SCALARS.of(of);
        let is_float = matches!(scalar, "half" | "float" | "double");
        let ty = match (scalar, columns, rows) {
            ("u32", 1, 1) if of.kind == ScalarKind::Bool => "bool",
            (_, 1, 1) if is_float => "float",
            (_, 1, 1) => "int",
            // Values of Godot where one has these components in 32 bits; `Basis` and `Projection`
            // are stored by columns there.
            ("float", 1, 2) => "Vector2",
            ("float", 1, 3) => "Vector3",
            ("float", 1, 4) => "Vector4",
            ("float", 3, 3) => "Basis",
            ("float", 4, 4) => "Projection",
            ("s32" | "u32", 1, 2) => "Vector2i",
            ("s32" | "u32", 1, 3) => "Vector3i",
            ("s32" | "u32", 1, 4) => "Vector4i",
            // Component by component, columns one behind the other.
            _ if is_float => "PackedFloat64Array",
            _ => "PackedInt64Array",
        };
        // Components of vectors are signed.
        let scalar = if ty.ends_with('i') { "s32" } else { scalar };
        Some(EncodedValue { ty, scalar, columns: (0..columns).map(column).collect() })
    }

    /// The expression that reads it at `at`.
    fn read(&self) -> String {
        let decode = |byte: &u64| format!("bytes.decode_{}({})", self.scalar, behind(*byte));
        let column = |column: &Vec<u64>| column.iter().map(decode).collect::<Vec<_>>().join(", ");
        let columns: Vec<String> = self.columns.iter().map(column).collect();
        match self.ty {
            "bool" => format!("{} != 0", columns[0]),
            "int" | "float" => columns[0].clone(),
            "Basis" => format!("Basis(Vector3({}))", columns.join("), Vector3(")),
            "Projection" => format!("Projection(Vector4({}))", columns.join("), Vector4(")),
            "PackedFloat64Array" | "PackedInt64Array" => {
                format!("{}([{}])", self.ty, columns.join(", "))
            }
            ty => format!("{ty}({})", columns[0]),
        }
    }

    /// The lines that write `value` at `at`.
    fn write(&self) -> String {
        let mut text = String::new();
        let mut number = 0;
        for (column, bytes) in self.columns.iter().enumerate() {
            for (row, byte) in bytes.iter().enumerate() {
                let component = match self.ty {
                    "bool" => "1 if value else 0".to_string(),
                    "int" | "float" => "value".to_string(),
                    "Basis" | "Projection" => format!("value.{}.{}", XYZW[column], XYZW[row]),
                    "PackedFloat64Array" | "PackedInt64Array" => format!("value[{number}]"),
                    _ => format!("value.{}", XYZW[row]),
                };
                number += 1;
                let (scalar, at) = (self.scalar, behind(*byte));
                let _ = writeln!(text, "\t\tbytes.encode_{scalar}({at}, {component})");
            }
        }
        text
    }
}

const XYZW: [&str; 4] = ["x", "y", "z", "w"];

fn behind(byte: u64) -> String {
    if byte == 0 { "at".to_string() } else { format!("at + {byte}") }
}
