//! The kinds of GLSL's opaque types, from their names (GLSL 4.60 §4.1.7, GL_KHR_vulkan_glsl).

use super::ast::Qualifiers;
use super::layout_ids;
use crate::interface::{Access, Comparison, Dimension, ResourceKind, Sampled, Texture};
use crate::syntax::stripped;

/// The kind of a uniform of an opaque type.
// [i | u | f16] (sampler | image | texture) DIMENSION [MS] [Array] [Shadow]
// Read from the end, where the suffixes stand in this order.
pub(super) fn kind(name: &str, qualifiers: &Qualifiers<'_>) -> ResourceKind {
    match name {
        "sampler" => return ResourceKind::Sampler { comparison: false, filtering: true },
        "samplerShadow" => return ResourceKind::Sampler { comparison: true, filtering: true },
        "atomic_uint" => return ResourceKind::AtomicCounter,
        "samplerExternalOES" => return ResourceKind::ExternalTexture,
        _ if name.starts_with("accelerationStructure") => {
            return ResourceKind::AccelerationStructure;
        }
        _ if name.contains("subpassInput") => return ResourceKind::InputAttachment,
        _ => {}
    }
    let (sampled, bare) = match name.as_bytes() {
        // `image2D` begins with an `i` of its own.
        [b'i', rest @ ..] if !rest.starts_with(b"mage") => (Sampled::Sint, &name[1..]),
        [b'u', ..] => (Sampled::Uint, &name[1..]),
        _ => (Sampled::Float, name.strip_prefix("f16").unwrap_or(name)),
    };
    let family = ["sampler", "image", "texture"].into_iter().find(|f| bare.starts_with(f));
    let Some(family) = family else { return ResourceKind::Other };
    let dimensions = &bare[family.len()..];
    let (dimensions, shadow) = stripped(dimensions, dimensions.strip_suffix("Shadow"));
    if dimensions == "Buffer" {
        return ResourceKind::TexelBuffer { storage: family == "image" };
    }
    let (dimensions, arrayed) = stripped(dimensions, dimensions.strip_suffix("Array"));
    let (dimensions, multisampled) = stripped(dimensions, dimensions.strip_suffix("MS"));
    let dimension = match dimensions {
        "1D" => Dimension::D1,
        "2D" => Dimension::D2,
        "3D" => Dimension::D3,
        "Cube" => Dimension::Cube,
        "2DRect" => Dimension::Rectangle,
        _ => return ResourceKind::Other,
    };
    let sampled = if shadow { Sampled::Depth } else { sampled };
    let texture = Texture { sampled, dimension, arrayed, multisampled };
    match family {
        "sampler" if shadow => ResourceKind::Combined(texture, Comparison::With),
        "sampler" => ResourceKind::Combined(texture, Comparison::Without),
        "texture" => ResourceKind::Texture(texture),
        _ => ResourceKind::StorageTexture {
            texture,
            format: qualifiers
                .layout
                .iter()
                .find_map(|id| layout_ids::image_format(&id.name.text.to_ascii_lowercase())),
            access: access(qualifiers),
        },
    }
}

/// The access that `readonly` and `writeonly` leave.
pub(super) fn access(qualifiers: &Qualifiers<'_>) -> Access {
    match (qualifiers.readonly, qualifiers.writeonly) {
        (true, false) => Access::Read,
        (false, true) => Access::Write,
        // Both leave nothing but queries of its size.
        (true, true) | (false, false) => Access::ReadWrite,
    }
}
