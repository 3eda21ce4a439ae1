//! Bindings for Vulkan through ash: descriptor sets, push constants, vertices, specialisation
//! constants and entry points.

use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::interface::{Dimension, ResourceKind};
use landfall_layout::shape::{AddressSpace, ScalarKind};
use landfall_layout::source::Stage;
use landfall_layout::text::escape;

use super::super::names::{Scope, screaming};
use super::program::{Binding, Program};
use super::text::{Module, PUB, indented, lines};
use super::vertex::{self, Attribute};
use super::{BindingOptions, source};

/// Prints a program; returns errors about what Vulkan cannot bind.
pub(super) fn program(
    program: &Program<'_>,
    options: &BindingOptions,
    out: &mut Module,
) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut scope = Scope::default();
    entry_points(program, &mut scope, out);
    for set in program.groups() {
        descriptor_set(program, set, options, out, &mut found);
    }
    if let Some((size, by)) = program.push_constants() {
        out.item(
            "The stages and bytes of the push constants.",
            &format!(
                "{PUB} const PUSH_CONSTANTS: ash::vk::PushConstantRange = \
                 ash::vk::PushConstantRange {{\n    stage_flags: {},\n    offset: 0,\n    size: \
                 {size},\n}};",
                indented(&stages(&by), 1).trim()
            ),
        );
    }
    for shader in &program.shaders {
        for entry in &shader.entries {
            let Some((name, vertex)) = vertex::structure(entry, &mut scope, out, &mut found) else {
                continue;
            };
            let attributes: Vec<String> = vertex.attributes.iter().map(attribute).collect();
            out.item(
                "",
                &format!(
                    "impl {name} {{\n    /// The attributes of binding 0, by location.\n    \
                     {PUB} const ATTRIBUTES: [ash::vk::VertexInputAttributeDescription; {}] = {};\n\n    \
                     /// Binding 0, a buffer of these vertices.\n    \
                     {PUB} const fn binding(\n        input_rate: ash::vk::VertexInputRate,\n    ) \
                     -> ash::vk::VertexInputBindingDescription {{\n        \
                     ash::vk::VertexInputBindingDescription {{\n            binding: 0,\n            \
                     stride: {},\n            input_rate,\n        }}\n    }}\n}}",
                    attributes.len(),
                    indented(&lines(&attributes), 1).trim(),
                    vertex.size,
                ),
            );
        }
        // What is found of a vertex structure has no file yet.
        for error in found.iter_mut().filter(|error| error.path.is_none()) {
            error.path = Some(shader.layout.path.clone());
        }
        let constants = shader.layout.interface.iter().flat_map(|interface| &interface.constants);
        for one in constants {
            let Some(id) = one.id else { continue };
            let about =
                format!("The number of the specialisation constant `{}`.", escape::name(&one.name));
            let name = scope.take(&format!("{}_CONSTANT_ID", screaming(&one.name)));
            out.constant(&about, &format!("{name}: u32"), &id.to_string());
        }
        // Vulkan takes SPIR-V; the text is for programs that compile it themselves.
        source::source(program, shader, options, &mut scope, out);
    }
    found
}

fn entry_points(program: &Program<'_>, scope: &mut Scope, out: &mut Module) {
    let mut names: Vec<&str> = Vec::new();
    for entry in program.shaders.iter().flat_map(|shader| &shader.entries) {
        // Entry points of one name, as GLSL's `main`, share a constant.
        if !names.contains(&&*entry.name) {
            names.push(&entry.name);
            let name = scope.take(&format!("{}_ENTRY", screaming(&entry.name)));
            let about = format!("The name of the entry point `{}`.", escape::name(&entry.name));
            let ty = format!("{name}: &core::ffi::CStr");
            out.constant(&about, &ty, &format!("c{:?}", &*entry.name));
        }
        let Some([Some(x), Some(y), Some(z)]) = entry.workgroup_size else { continue };
        let name = scope.take(&format!("{}_WORKGROUP_SIZE", screaming(&entry.name)));
        let about = "The invocations of a workgroup along each axis.";
        out.constant(about, &format!("{name}: [u32; 3]"), &format!("[{x}, {y}, {z}]"));
    }
}

fn descriptor_set(
    program: &Program<'_>,
    set: u32,
    options: &BindingOptions,
    out: &mut Module,
    found: &mut Vec<Diagnostic>,
) {
    let mut entries = Vec::new();
    let mut rows = Vec::new();
    for one in program.in_group(set) {
        let described = descriptor(one, options);
        // A binding is reported once and left out; the file is not written then.
        let (binding, ty, count) = match described {
            Ok(described) => described,
            Err(error) => {
                found.push(error);
                continue;
            }
        };
        rows.push(format!("- {binding}: `{}`", escape::name(&one.resource.name)));
        entries.push(format!(
            "ash::vk::DescriptorSetLayoutBinding {{\n    binding: {binding},\n    descriptor_type: \
             ash::vk::DescriptorType::{ty},\n    descriptor_count: {count},\n    stage_flags: {},\n    \
             p_immutable_samplers: core::ptr::null(),\n    _marker: core::marker::PhantomData,\n}}",
            indented(&stages(&one.stages), 1).trim(),
        ));
    }
    // All bindings of the set were reported.
    if entries.is_empty() {
        return;
    }
    out.item(
        &format!("The bindings of descriptor set {set}:\n\n{}", rows.join("\n")),
        &format!(
            "{PUB} const SET_{set}: [ash::vk::DescriptorSetLayoutBinding<'static>; {}] = {};",
            entries.len(),
            lines(&entries)
        ),
    );
}

/// The binding, type and number of a descriptor.
fn descriptor(
    one: &Binding<'_>,
    options: &BindingOptions,
) -> Result<(u32, &'static str, u64), Diagnostic> {
    let name = &one.resource.name;
    let Some(binding) = one.resource.binding else {
        let error = one.error(format!("`{name}` has no binding, which Vulkan needs"));
        return Err(error.with_help("write `layout(set = 0, binding = N)`"));
    };
    let Some(count) = one.count(options) else {
        let error = one.error(format!("the number of elements of `{name}` is not known"));
        return Err(error.with_help(format!("give it: `--count {name}=N`")));
    };
    let is_dynamic = one.is_named(&options.dynamic_offsets);
    let ty = match &one.resource.kind {
        // Vulkan, Descriptor Types. No shader says whether an offset is dynamic: the options do.
        ResourceKind::Buffer(AddressSpace::Uniform, _) if is_dynamic => "UNIFORM_BUFFER_DYNAMIC",
        ResourceKind::Buffer(AddressSpace::Uniform, _) => "UNIFORM_BUFFER",
        ResourceKind::Buffer(..) if is_dynamic => "STORAGE_BUFFER_DYNAMIC",
        ResourceKind::Buffer(..) => "STORAGE_BUFFER",
        ResourceKind::Sampler { .. } => "SAMPLER",
        ResourceKind::Texture(texture) | ResourceKind::Combined(texture, _)
            if texture.dimension == Dimension::Rectangle =>
        {
            return Err(one.error(format!("Vulkan has no rectangle textures, such as `{name}`")));
        }
        ResourceKind::Texture(_) => "SAMPLED_IMAGE",
        ResourceKind::Combined(..) | ResourceKind::ExternalTexture => "COMBINED_IMAGE_SAMPLER",
        ResourceKind::StorageTexture { .. } => "STORAGE_IMAGE",
        ResourceKind::TexelBuffer { storage: false } => "UNIFORM_TEXEL_BUFFER",
        ResourceKind::TexelBuffer { storage: true } => "STORAGE_TEXEL_BUFFER",
        ResourceKind::InputAttachment => "INPUT_ATTACHMENT",
        ResourceKind::AccelerationStructure => "ACCELERATION_STRUCTURE_KHR",
        // Atomic counters, handles in structures.
        _ => {
            return Err(one.error(format!("Vulkan has no descriptor for `{name}`")));
        }
    };
    Ok((binding, ty, count))
}

/// The `vk::ShaderStageFlags` of stages.
fn stages(all: &[Stage]) -> String {
    let flags: Vec<String> =
        all.iter().map(|stage| format!("ash::vk::ShaderStageFlags::{}", flag(*stage))).collect();
    match &flags[..] {
        [one] => one.clone(),
        _ => {
            // `|` of flags is no `const fn`, `as_raw` is.
            let raw: Vec<String> = flags.iter().map(|flag| format!("{flag}.as_raw()")).collect();
            format!("ash::vk::ShaderStageFlags::from_raw(\n    {},\n)", raw.join("\n        | "))
        }
    }
}

fn flag(stage: Stage) -> &'static str {
    match stage {
        Stage::Vertex => "VERTEX",
        Stage::TessellationControl => "TESSELLATION_CONTROL",
        Stage::TessellationEvaluation => "TESSELLATION_EVALUATION",
        Stage::Geometry => "GEOMETRY",
        Stage::Fragment => "FRAGMENT",
        Stage::Compute => "COMPUTE",
        Stage::Task => "TASK_EXT",
        Stage::Mesh => "MESH_EXT",
        Stage::RayGeneration => "RAYGEN_KHR",
        Stage::Intersection => "INTERSECTION_KHR",
        Stage::AnyHit => "ANY_HIT_KHR",
        Stage::ClosestHit => "CLOSEST_HIT_KHR",
        Stage::Miss => "MISS_KHR",
        Stage::Callable => "CALLABLE_KHR",
        // `Stage` may get more variants.
        _ => "ALL",
    }
}

fn attribute(one: &Attribute) -> String {
    let letters = ["R", "G", "B", "A"];
    let bits = u32::from(one.scalar.width) * 8;
    let channels: String = letters
        .iter()
        .take(usize::from(one.components))
        .map(|letter| format!("{letter}{bits}"))
        .collect();
    // Attributes are read as they are declared: normalised formats are up to the program.
    let kind = match one.scalar.kind {
        ScalarKind::Sint => "SINT",
        ScalarKind::Uint => "UINT",
        _ => "SFLOAT",
    };
    format!(
        "ash::vk::VertexInputAttributeDescription {{\n    location: {},\n    binding: 0,\n    format: \
         ash::vk::Format::{channels}_{kind},\n    offset: {},\n}}",
        one.location, one.offset
    )
}
