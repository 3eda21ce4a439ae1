//! The identifiers allowed in `layout(…)`: GLSL 4.60 §4.4, GLSL ES 3.20 §4.4, GL_KHR_vulkan_glsl
//! and the extensions of the Khronos registry.

use crate::text::edit_distance;
use crate::text::word_filter::WordFilter;

/// Whether some version or extension has an identifier with that name, in lower case.
pub(super) fn is_known(name: &str) -> bool {
    KNOWN.contains(&name)
        || is_image_format(name)
        || PREFIXES.iter().any(|prefix| name.starts_with(prefix))
}

/// Returns the help for a misspelt identifier.
pub(super) fn suggestion(name: &str) -> Option<String> {
    // Every short name is close to others.
    let all = KNOWN.iter().chain(IMAGE_FORMATS).copied();
    let long = all.filter(|known| known.len() > 3);
    (name.len() > 3).then(|| edit_distance::suggestion(name, long)).flatten()
}

/// Whether an entry of `layout(…)` is the format of an image: `rgba8`.
pub(super) fn is_image_format(name: &str) -> bool {
    const FILTER: WordFilter = WordFilter::NONE.with(IMAGE_FORMATS);
    FILTER.may_contain(name) && IMAGE_FORMATS.contains(&name)
}

/// The format of an image with that name.
pub(in crate::syntax) fn image_format(name: &str) -> Option<&'static str> {
    IMAGE_FORMATS.iter().copied().find(|format| *format == name)
}

/// Prefixes of families: image formats, blend equations, interlocks and the like.
const PREFIXES: &[&str] = &[
    "blend_support_",
    "derivative_group_",
    "early_and_late_fragment_tests",
    "local_size_",
    "noncoherent",
    "pixel_interlock_",
    "quad_",
    "sample_interlock_",
    "shading_rate_",
    "shaderrecord",
    "stencil_ref_",
    "tile_",
    "xfb_",
];

const KNOWN: &[&str] = &[
    // Blocks and members.
    "std140",
    "std430",
    "scalar",
    "shared",
    "packed",
    "row_major",
    "column_major",
    "binding",
    "offset",
    "align",
    "set",
    "push_constant",
    "buffer_reference",
    "buffer_reference_align",
    "constant_id",
    "input_attachment_index",
    "location",
    "component",
    "index",
    // Geometry and tessellation.
    "points",
    "lines",
    "lines_adjacency",
    "triangles",
    "triangles_adjacency",
    "line_strip",
    "triangle_strip",
    "invocations",
    "max_vertices",
    "max_primitives",
    "stream",
    "vertices",
    "isolines",
    "quads",
    "equal_spacing",
    "fractional_even_spacing",
    "fractional_odd_spacing",
    "cw",
    "ccw",
    "point_mode",
    // Fragments.
    "origin_upper_left",
    "pixel_center_integer",
    "early_fragment_tests",
    "post_depth_coverage",
    "depth_any",
    "depth_greater",
    "depth_less",
    "depth_unchanged",
    "override_coverage",
    "full_quads",
    // Several views, handles, images.
    "num_views",
    "viewport_relative",
    "secondary_view_offset_relative",
    "passthrough",
    "bindless_sampler",
    "bound_sampler",
    "bindless_image",
    "bound_image",
    "commandbindablenv",
    "hitobjectshaderrecordnv",
    "hitobjectshaderrecordext",
    "yuv",
    "subpasscoherent",
    "size1x8",
    "size1x16",
    "size1x32",
    "size2x32",
    "size4x32",
];

/// The formats of images (GLSL 4.60 §4.4.7, GL_EXT_shader_image_int64).
const IMAGE_FORMATS: &[&str] = &[
    "rgba32f",
    "rgba16f",
    "rg32f",
    "rg16f",
    "r11f_g11f_b10f",
    "r32f",
    "r16f",
    "rgba16",
    "rgb10_a2",
    "rgba8",
    "rg16",
    "rg8",
    "r16",
    "r8",
    "rgba16_snorm",
    "rgba8_snorm",
    "rg16_snorm",
    "rg8_snorm",
    "r16_snorm",
    "r8_snorm",
    "rgba32i",
    "rgba16i",
    "rgba8i",
    "rg32i",
    "rg16i",
    "rg8i",
    "r32i",
    "r16i",
    "r8i",
    "r64i",
    "rgba32ui",
    "rgba16ui",
    "rgb10_a2ui",
    "rgba8ui",
    "rg32ui",
    "rg16ui",
    "rg8ui",
    "r32ui",
    "r16ui",
    "r8ui",
    "r64ui",
];
