//! The user's WGSL for WebGPU in a browser: unchanged, behind a vertex shader that draws a point for
//! each fragment.

use std::fmt::Write as _;

use landfall_ir::module::HandleKind;
use landfall_layout::AddressSpace;
use landfall_layout::named;
use naga::{Interpolation, Sampling};

use super::{FragmentShader, Input, InputKind};

/// A fragment shader in WGSL, and what a pipeline of WebGPU wants for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WgslTexts {
    /// The vertex shader. Its attribute 0 is the place of the point, a `vec2<f32>` in clip space;
    /// those after it are the inputs with a location, in the order of
    /// [`Batch::inputs`](super::Batch::inputs), as floats.
    pub vertex: String,
    /// The user's text.
    pub fragment: String,
    /// The name of its entry point.
    pub entry: String,
    /// Group and binding of each block, in the order of [`Batch::blocks`](super::Batch::blocks).
    pub blocks: Vec<(u32, u32, BufferKind)>,
    /// Group and binding of each texture, in the order of [`Batch::textures`](super::Batch::textures).
    pub textures: Vec<(u32, u32)>,
    /// Group and binding of each sampler.
    pub samplers: Vec<(u32, u32)>,
}

named! {
    /// The type of a buffer's binding (WebGPU's `GPUBufferBindingType`).
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum BufferKind {
        Uniform = "uniform",
        ReadOnlyStorage = "read-only-storage",
        Storage = "storage",
    }
}

impl FragmentShader {
    /// Returns the shader's own text with a vertex shader for it; `None` for GLSL.
    ///
    /// # Errors
    /// What WebGPU does not have.
    pub fn wgsl(&self) -> Result<Option<WgslTexts>, String> {
        let Some((fragment, entry)) = &self.wgsl else { return Ok(None) };
        let blocks = self.blocks().iter().zip(&self.writable).map(|(block, writable)| {
            let kind = match block.layout.space {
                AddressSpace::Uniform => BufferKind::Uniform,
                AddressSpace::Storage => match writable {
                    true => BufferKind::Storage,
                    false => BufferKind::ReadOnlyStorage,
                },
                other => {
                    let (name, space) = (&block.layout.name, other.name());
                    return Err(format!("`{name}` is a {space} block; browsers have none"));
                }
            };
            Ok((block.group, block.binding, kind))
        });
        let places = |kind| -> Vec<(u32, u32)> {
            let handles = self.module.handles().iter().filter(|handle| handle.kind == kind);
            handles.map(|handle| (handle.group, handle.binding)).collect()
        };
        Ok(Some(WgslTexts {
            vertex: vertex(&self.inputs),
            fragment: fragment.clone(),
            entry: entry.clone(),
            blocks: blocks.collect::<Result<_, String>>()?,
            textures: places(HandleKind::Texture),
            samplers: places(HandleKind::Sampler),
        }))
    }
}

/// Returns a vertex shader whose outputs are the inputs with a location.
fn vertex(inputs: &[Input]) -> String {
    let mut outputs = String::new();
    let mut attributes = String::new();
    let mut values = String::new();
    let located = inputs.iter().filter_map(|input| Some((input, input.location?)));
    for (number, (input, location)) in located.enumerate() {
        let scalar = match input.kind {
            InputKind::Float => "f32",
            InputKind::Sint => "i32",
            InputKind::Uint => "u32",
        };
        let ty = |scalar: &str| match input.components {
            1 => scalar.to_string(),
            count => format!("vec{count}<{scalar}>"),
        };
        let (own, given) = (ty(scalar), ty("f32"));
        let interpolated = &input.interpolation;
        let _ = writeln!(outputs, "    @location({location}) {interpolated}v{number}: {own},");
        // Attribute 0 is the place of the point.
        let _ = writeln!(attributes, "    @location({}) v{number}: {given},", number + 1);
        let _ = write!(values, ", {own}(v{number})");
    }
    format!(
        "struct Point {{\n    @builtin(position) position: vec4<f32>,\n{outputs}}}\n\n\
         @vertex\nfn point(\n    @location(0) place: vec2<f32>,\n{attributes}) -> Point {{\n    \
         return Point(vec4<f32>(place, 0.0, 1.0){values});\n}}\n"
    )
}

/// Returns the attribute of an input, with a space behind it; the stages have to agree in it.
pub(super) fn attribute(
    interpolation: Option<Interpolation>,
    sampling: Option<Sampling>,
) -> String {
    let Some(interpolation) = interpolation else { return String::new() };
    let kind = match interpolation {
        Interpolation::Perspective => "perspective",
        Interpolation::Linear => "linear",
        Interpolation::Flat => "flat",
        Interpolation::PerVertex => "per_vertex",
    };
    let sampling = sampling.map(|sampling| match sampling {
        Sampling::Center => "center",
        Sampling::Centroid => "centroid",
        Sampling::Sample => "sample",
        Sampling::First => "first",
        Sampling::Either => "either",
    });
    match sampling {
        Some(sampling) => format!("@interpolate({kind}, {sampling}) "),
        None => format!("@interpolate({kind}) "),
    }
}
