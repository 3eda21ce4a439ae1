//! What wgpu calls the kinds of resources, their formats and stages.

use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::interface::{Access, Dimension, ResourceKind, Sampled, Texture};
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::Stage;

use super::BindingOptions;
use super::program::Binding;

/// A resource as it stands in a layout and in a bind group.
pub(super) struct Bound {
    pub binding: u32,
    /// A `wgpu::BindingType`.
    pub ty: String,
    /// An `Option<NonZeroU32>`.
    pub count: String,
    /// The type of its field.
    pub field: String,
    /// The `wgpu::BindingResource`, with `FIELD` for the field.
    pub resource: String,
}

/// What wgpu calls a resource.
pub(super) fn bound(one: &Binding<'_>, options: &BindingOptions) -> Result<Bound, Diagnostic> {
    let name = &one.resource.name;
    let Some(binding) = one.resource.binding else {
        let error = one.error(format!("`{name}` has no binding, which wgpu needs"));
        return Err(error.with_help("write `layout(set = 0, binding = N)`"));
    };
    let (ty, family) = binding_type(one, options)?;
    let Some(count) = one.count(options) else {
        let error = one.error(format!("wgpu needs the number of elements of `{name}`"));
        return Err(error.with_help(format!("give it: `--count {name}=N`")));
    };
    let is_array = !one.resource.count.is_empty();
    let (field, resource) = match (family, is_array) {
        (ResourceFamily::Buffer, false) => ("wgpu::BufferBinding<'a>", "Buffer(FIELD.clone())"),
        (ResourceFamily::Buffer, true) => ("&'a [wgpu::BufferBinding<'a>]", "BufferArray(FIELD)"),
        (ResourceFamily::Sampler, false) => ("&'a wgpu::Sampler", "Sampler(FIELD)"),
        (ResourceFamily::Sampler, true) => ("&'a [&'a wgpu::Sampler]", "SamplerArray(FIELD)"),
        (ResourceFamily::Texture, false) => ("&'a wgpu::TextureView", "TextureView(FIELD)"),
        (ResourceFamily::Texture, true) => {
            ("&'a [&'a wgpu::TextureView]", "TextureViewArray(FIELD)")
        }
        (ResourceFamily::External, _) => ("&'a wgpu::ExternalTexture", "ExternalTexture(FIELD)"),
        (ResourceFamily::Acceleration, _) => ("&'a wgpu::Tlas", "AccelerationStructure(FIELD)"),
    };
    Ok(Bound {
        binding,
        ty,
        count: match is_array {
            true => format!("core::num::NonZeroU32::new({count})"),
            false => "None".to_string(),
        },
        field: field.to_string(),
        resource: format!("wgpu::BindingResource::{resource}"),
    })
}

/// What a resource is bound as.
#[derive(Clone, Copy)]
enum ResourceFamily {
    Buffer,
    Sampler,
    Texture,
    External,
    Acceleration,
}

fn binding_type(
    one: &Binding<'_>,
    options: &BindingOptions,
) -> Result<(String, ResourceFamily), Diagnostic> {
    let name = &one.resource.name;
    let none = |what: &str, help: &str| {
        let error = one.error(format!("wgpu has no {what}, such as `{name}`"));
        if help.is_empty() { error } else { error.with_help(help) }
    };
    let unfilterable = one.is_named(&options.unfilterable);
    Ok(match &one.resource.kind {
        ResourceKind::Buffer(space, access) => {
            (buffer(one, options, *space, *access)?, ResourceFamily::Buffer)
        }
        ResourceKind::Sampler { comparison: true, .. } => (
            "wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)".into(),
            ResourceFamily::Sampler,
        ),
        ResourceKind::Sampler { filtering, .. } => {
            let kind = if *filtering && !unfilterable { "Filtering" } else { "NonFiltering" };
            (
                format!("wgpu::BindingType::Sampler(wgpu::SamplerBindingType::{kind})"),
                ResourceFamily::Sampler,
            )
        }
        ResourceKind::Texture(texture) => {
            let sample = match texture.sampled {
                // WebGPU: a multisampled texture is not filterable.
                Sampled::Float => {
                    let filterable = !texture.multisampled && !unfilterable;
                    format!("Float {{ filterable: {filterable} }}")
                }
                Sampled::Sint => "Sint".to_string(),
                Sampled::Uint => "Uint".to_string(),
                Sampled::Depth => "Depth".to_string(),
            };
            let ty = format!(
                "wgpu::BindingType::Texture {{\n    sample_type: wgpu::TextureSampleType::{sample},\n    \
                 view_dimension: wgpu::TextureViewDimension::{},\n    multisampled: {},\n}}",
                view(*texture).ok_or_else(|| none("texture of these dimensions", ""))?,
                texture.multisampled
            );
            (ty, ResourceFamily::Texture)
        }
        ResourceKind::StorageTexture { texture, format, access } => {
            let Some(format) = format.and_then(texture_format) else {
                let error = one.error(format!("wgpu needs the format of image `{name}`"));
                return Err(error.with_help("write a format of wgpu: `layout(rgba8)`"));
            };
            let access = match access {
                Access::Read => "ReadOnly",
                Access::Write => "WriteOnly",
                Access::ReadWrite => "ReadWrite",
                Access::Atomic => "Atomic",
            };
            let ty = format!(
                "wgpu::BindingType::StorageTexture {{\n    \
                 access: wgpu::StorageTextureAccess::{access},\n    \
                 format: wgpu::TextureFormat::{format},\n    \
                 view_dimension: wgpu::TextureViewDimension::{},\n}}",
                view(*texture).ok_or_else(|| none("image of these dimensions", ""))?,
            );
            (ty, ResourceFamily::Texture)
        }
        ResourceKind::ExternalTexture => {
            ("wgpu::BindingType::ExternalTexture".into(), ResourceFamily::External)
        }
        ResourceKind::AccelerationStructure => (
            "wgpu::BindingType::AccelerationStructure {\n    vertex_return: false,\n}".into(),
            ResourceFamily::Acceleration,
        ),
        ResourceKind::Combined(..) => {
            let help = "separate it, as `landfall port --to naga` does";
            return Err(none("texture with a sampler of its own", help));
        }
        ResourceKind::TexelBuffer { .. } => return Err(none("texel buffers", "")),
        ResourceKind::InputAttachment => return Err(none("input attachments", "")),
        ResourceKind::AtomicCounter => return Err(none("atomic counters", "use a `buffer` block")),
        ResourceKind::Other => return Err(none("handles in structures", "")),
        _ => return Err(none("binding of this kind", "")),
    })
}

fn buffer(
    one: &Binding<'_>,
    options: &BindingOptions,
    space: AddressSpace,
    access: Access,
) -> Result<String, Diagnostic> {
    let kind = match space {
        AddressSpace::Uniform => "wgpu::BufferBindingType::Uniform".to_string(),
        _ => match access {
            Access::Read => "wgpu::BufferBindingType::Storage { read_only: true }".to_string(),
            Access::Write | Access::ReadWrite | Access::Atomic => {
                "wgpu::BufferBindingType::Storage { read_only: false }".to_string()
            }
        },
    };
    // The least size of a binding: that of the block with one element of a tail.
    let Some(size) = one.block.and_then(crate::runtime_tail::buffer_size) else {
        return Err(one.error(format!("the size of `{}` is not known", one.resource.name)));
    };
    Ok(format!(
        "wgpu::BindingType::Buffer {{\n    ty: {kind},\n    has_dynamic_offset: {},\n    \
         min_binding_size: core::num::NonZeroU64::new({size}),\n}}",
        one.is_named(&options.dynamic_offsets)
    ))
}

fn view(texture: Texture) -> Option<&'static str> {
    Some(match (texture.dimension, texture.arrayed) {
        (Dimension::D1, false) => "D1",
        (Dimension::D2, false) => "D2",
        (Dimension::D2, true) => "D2Array",
        (Dimension::D3, _) => "D3",
        (Dimension::Cube, false) => "Cube",
        (Dimension::Cube, true) => "CubeArray",
        // Arrays of lines, rectangles.
        _ => return None,
    })
}

/// wgpu's name of a format in GLSL's spelling.
fn texture_format(format: &str) -> Option<String> {
    Some(match format {
        "r11f_g11f_b10f" => "Rg11b10Ufloat".to_string(),
        "rgb10_a2" => "Rgb10a2Unorm".to_string(),
        "rgb10_a2ui" => "Rgb10a2Uint".to_string(),
        "bgra8" => "Bgra8Unorm".to_string(),
        // wgpu has none of signed 64-bit integers.
        "r64i" => return None,
        _ => {
            // channels digits [ "f" | "i" | "ui" | "_snorm" ], as in `rgba8`, `r32ui`,
            // `rg16_snorm`.
            let (bare, snorm) = match format.strip_suffix("_snorm") {
                Some(bare) => (bare, true),
                None => (format, false),
            };
            let digits = bare.find(|c: char| c.is_ascii_digit())?;
            let channels = &bare[..digits];
            let end = bare.rfind(|c: char| c.is_ascii_digit())? + 1;
            let kind = match &bare[end..] {
                "" if snorm => "Snorm",
                "" => "Unorm",
                "f" => "Float",
                "i" => "Sint",
                "ui" => "Uint",
                _ => return None,
            };
            let mut letters = channels.chars();
            let first = letters.next()?.to_ascii_uppercase();
            format!("{first}{}{}{kind}", letters.as_str(), &bare[digits..end])
        }
    })
}

/// The `wgpu::ShaderStages` of a stage.
pub(super) fn flag(stage: Stage) -> Option<&'static str> {
    match stage {
        Stage::Vertex => Some("VERTEX"),
        Stage::Fragment => Some("FRAGMENT"),
        Stage::Compute => Some("COMPUTE"),
        Stage::Task => Some("TASK"),
        Stage::Mesh => Some("MESH"),
        // Tessellation, geometry and ray tracing.
        _ => None,
    }
}

/// The `wgpu::ShaderStages` of stages.
pub(super) fn stages(all: &[Stage]) -> String {
    let order = [Stage::Vertex, Stage::Fragment, Stage::Compute, Stage::Task, Stage::Mesh];
    let mut flags: Vec<&str> =
        order.into_iter().filter(|stage| all.contains(stage)).filter_map(flag).collect();
    // wgpu has a constant for these two; `|` of flags is no `const fn`, `union` is.
    if let ["VERTEX", "FRAGMENT", ..] = flags[..] {
        flags.splice(..2, ["VERTEX_FRAGMENT"]);
    }
    let mut flags = flags.into_iter();
    let first = flags.next().unwrap_or("NONE");
    let rest: String = flags.map(|flag| format!(".union(wgpu::ShaderStages::{flag})")).collect();
    format!("wgpu::ShaderStages::{first}{rest}")
}
