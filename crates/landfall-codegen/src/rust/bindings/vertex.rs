//! Vertex structures: the inputs of a vertex shader in one interleaved buffer.

use std::fmt::Write as _;

use landfall_layout::diagnostic::{Code, Diagnostic};
use landfall_layout::interface::{EntryPoint, Input};
use landfall_layout::shape::{ArrayLen, Scalar, ScalarKind, Type};
use landfall_layout::source::Stage;
use landfall_layout::text::escape;

use super::super::names::{Scope, camel, snake};
use super::WgpuMajor;
use super::text::{Module, PUB, indented, lines};

/// One attribute: what one location holds.
pub(super) struct Attribute {
    pub location: u32,
    pub scalar: Scalar,
    pub components: u8,
    /// The offset in the structure.
    pub offset: u64,
}

/// A field of the structure.
pub(super) struct Field<'a> {
    pub input: &'a Input,
    /// `[f32; 3]`, `[[f32; 4]; 4]`.
    pub ty: String,
    pub offset: u64,
}

/// The fields, attributes and size of a vertex.
pub(super) struct Vertex<'a> {
    pub fields: Vec<Field<'a>>,
    pub attributes: Vec<Attribute>,
    /// Bytes after the last field.
    pub padding: u64,
    pub size: u64,
}

/// Lays the inputs of an entry point out, the widest components first, so that none needs padding.
fn vertex<'a>(entry: &'a EntryPoint, found: &mut Vec<Diagnostic>) -> Option<Vertex<'a>> {
    let mut parts = Vec::new();
    for input in &entry.inputs {
        match part(input) {
            Ok(part) => parts.push((input, part)),
            Err(error) => found.push(error),
        }
    }
    if parts.is_empty() {
        return None;
    }
    // A stable sort: inputs of one width stay in the order of the shader.
    parts.sort_by_key(|(_, part)| std::cmp::Reverse(part.scalar.width));
    // WebGPU: the stride of a vertex buffer is a multiple of 4.
    let widest = parts.first().map_or(4, |(_, part)| u64::from(part.scalar.width)).max(4);
    let mut vertex = Vertex { fields: Vec::new(), attributes: Vec::new(), padding: 0, size: 0 };
    for (input, part) in parts {
        let offset = vertex.size;
        let bytes = u64::from(part.scalar.width) * u64::from(part.components);
        // An array takes a location for each element, a matrix one for each column (GLSL 4.60
        // §4.4.1).
        for at in 0..part.locations {
            vertex.attributes.push(Attribute {
                location: part.location + at,
                scalar: part.scalar,
                components: part.components,
                offset: vertex.size,
            });
            vertex.size += bytes;
        }
        vertex.fields.push(Field { input, ty: part.ty, offset });
    }
    let size = vertex.size.next_multiple_of(widest);
    vertex.padding = size - vertex.size;
    vertex.size = size;
    vertex.attributes.sort_by_key(|attribute| attribute.location);
    Some(vertex)
}

/// An input as attributes.
struct VertexInput {
    location: u32,
    locations: u32,
    scalar: Scalar,
    components: u8,
    ty: String,
}

fn part(input: &Input) -> Result<VertexInput, Diagnostic> {
    let name = escape::name(&input.name);
    let error = |message: String| Diagnostic::error(Code::NoBinding, input.span, message);
    let Some(location) = input.location else {
        return Err(error(format!("input `{name}` has no location"))
            .with_help("write `layout(location = N)`"));
    };
    let (mut ty, mut locations) = (&input.ty, 1u32);
    let mut lengths = Vec::new();
    while let Type::Array { element, len } = ty {
        let ArrayLen::Fixed(len) = len else {
            return Err(error(format!("the number of elements of input `{name}` is not known")));
        };
        locations = locations.saturating_mul(*len);
        lengths.push(u64::from(*len));
        ty = element;
    }
    let (scalar, components) = match ty {
        Type::Scalar(scalar) => (*scalar, 1),
        Type::Vector { scalar, rows } => (*scalar, *rows),
        Type::Matrix { scalar, columns, rows } => {
            locations = locations.saturating_mul(u32::from(*columns));
            lengths.push(u64::from(*columns));
            (*scalar, *rows)
        }
        Type::Atomic(_) | Type::Address(_) | Type::Struct(_) | Type::Array { .. } => {
            return Err(error(format!("input `{name}` is no number, vector or matrix")));
        }
    };
    // A `dvec3` or `dvec4` takes two locations: elements of an array would be two apart.
    let wide = components > 2 && scalar == Scalar::F64;
    let component = match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => "f32",
        (ScalarKind::Float, 8) => "f64",
        (ScalarKind::Float, 2) => "u16",
        (ScalarKind::Sint, 4) => "i32",
        (ScalarKind::Uint, 4) => "u32",
        _ => return Err(error(format!("no vertex format fits input `{name}`"))),
    };
    // There is no format of three 16-bit floats.
    if wide && locations > 1 || scalar == Scalar::F16 && components == 3 {
        return Err(error(format!("no vertex format fits input `{name}`")));
    }
    let mut ty = match components {
        1 => component.to_string(),
        _ => format!("[{component}; {components}]"),
    };
    // The innermost dimension is the first one in Rust's spelling as well.
    for len in lengths.into_iter().rev() {
        ty = format!("[{ty}; {len}]");
    }
    Ok(VertexInput { location, locations, scalar, components, ty })
}

/// The fields of the structure with their documentation.
fn structure_text(vertex: &Vertex<'_>) -> String {
    let mut names = Scope::default();
    let mut text = String::new();
    for field in &vertex.fields {
        let location = field.input.location.unwrap_or(0);
        let half = match field.input.ty.innermost() {
            Type::Scalar(scalar) | Type::Vector { scalar, .. } if scalar.width == 2 => {
                "; the bits of 16-bit floats"
            }
            _ => "",
        };
        let _ = writeln!(
            text,
            "    /// Location {location}, at byte {}{half}.\n    {PUB} {}: {},",
            field.offset,
            names.take(&snake(&field.input.name)),
            field.ty
        );
    }
    if vertex.padding > 0 {
        let _ = writeln!(
            text,
            "    /// Bytes that nothing reads.\n    {PUB} {}: [u8; {}],",
            names.take("padding"),
            vertex.padding
        );
    }
    text
}

const DERIVES: &str =
    "#[repr(C)]\n#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]";

/// Prints the structure of an entry point's vertices; returns its name and layout.
pub(super) fn structure<'a>(
    entry: &'a EntryPoint,
    scope: &mut Scope,
    out: &mut Module,
    found: &mut Vec<Diagnostic>,
) -> Option<(String, Vertex<'a>)> {
    if entry.stage != Some(Stage::Vertex) {
        return None;
    }
    let vertex = vertex(entry, found)?;
    let name = scope.take(&format!("{}Vertex", camel(&entry.name)));
    out.item(
        &format!("A vertex of `{}`.", escape::name(&entry.name)),
        &format!("{DERIVES}\n{PUB} struct {name} {{\n{}}}", structure_text(&vertex)),
    );
    Some((name, vertex))
}

/// Prints the vertex of an entry point for wgpu; returns the structure's name, if it has inputs.
pub(super) fn for_wgpu(
    entry: &EntryPoint,
    major: WgpuMajor,
    scope: &mut Scope,
    out: &mut Module,
    found: &mut Vec<Diagnostic>,
) -> Option<String> {
    let (name, vertex) = structure(entry, scope, out, found)?;
    let attributes: Vec<String> = vertex
        .attributes
        .iter()
        .map(|one| {
            format!(
                "wgpu::VertexAttribute {{\n    format: wgpu::VertexFormat::{},\n    offset: {},\n    \
                 shader_location: {},\n}}",
                format_of(one),
                one.offset,
                one.location
            )
        })
        .collect();
    // wgpu 30 takes slots without a buffer, so each layout is an `Option`.
    let (ty, open, close) = match major >= WgpuMajor::V30 {
        true => ("Option<wgpu::VertexBufferLayout<'static>>", "Some(", ")"),
        false => ("wgpu::VertexBufferLayout<'static>", "", ""),
    };
    out.item(
        "",
        &format!(
            "impl {name} {{\n    /// The attributes, by location.\n    \
             {PUB} const ATTRIBUTES: [wgpu::VertexAttribute; {}] = {};\n\n    \
             /// The layout of a buffer of these vertices, as `VertexState::buffers` takes it.\n    \
             {PUB} const fn layout(\n        step_mode: wgpu::VertexStepMode,\n    ) -> {ty} {{\n        \
             {open}wgpu::VertexBufferLayout {{\n            array_stride: {},\n            \
             step_mode,\n            attributes: &Self::ATTRIBUTES,\n        }}{close}\n    }}\n}}",
            attributes.len(),
            indented(&lines(&attributes), 1).trim(),
            vertex.size,
        ),
    );
    Some(name)
}

fn format_of(one: &Attribute) -> String {
    let (name, bits) = match (one.scalar.kind, one.scalar.width) {
        (ScalarKind::Sint, _) => ("Sint", 32),
        (ScalarKind::Uint, _) => ("Uint", 32),
        (_, 2) => ("Float", 16),
        (_, 8) => ("Float", 64),
        _ => ("Float", 32),
    };
    match one.components {
        1 => format!("{name}{bits}"),
        components => format!("{name}{bits}x{components}"),
    }
}
