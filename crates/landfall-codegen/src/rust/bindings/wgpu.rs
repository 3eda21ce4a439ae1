//! Bindings for wgpu: bind groups with their layouts, the pipeline layout, vertex buffers, entry
//! points, stages, constants and shader modules.

use std::fmt::Write as _;

use landfall_layout::diagnostic::{Code, Diagnostic};
use landfall_layout::interface::ResourceKind;
use landfall_layout::source::Stage;
use landfall_layout::text::escape;

use super::super::names::{Scope, screaming, snake};
use super::program::{Binding, Program};
use super::text::{Module, PUB, WIDTH, indented, lines};
use super::wgpu_stages::{self, StageNames};
use super::wgpu_types::{Bound, bound, stages};
use super::{BindingOptions, WgpuMajor, constants, source, vertex, wgpu_types};
use crate::runtime_tail::buffer_size;

/// Prints a program; returns errors about what wgpu cannot bind.
pub(super) fn program(
    program: &Program<'_>,
    options: &BindingOptions,
    major: WgpuMajor,
    out: &mut Module,
) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut scope = Scope::default();
    for entry in program.shaders.iter().flat_map(|shader| &shader.entries) {
        let Some(stage) = entry.stage else { continue };
        if wgpu_types::flag(stage).is_none() {
            let message = format!("wgpu has no {} stage", stage.name().replace('_', " "));
            found.push(Diagnostic::error(Code::NoBinding, entry.span, message));
        }
    }
    for shader in &program.shaders {
        source::with_module(program, shader, options, &mut scope, out);
    }
    let entries = entry_points(program, &mut scope, out);
    for group in program.groups() {
        bind_group(program, group, options, out, &mut found);
    }
    pipeline_layout(program, major, out);
    let mut names = Vec::new();
    for shader in &program.shaders {
        for entry in &shader.entries {
            let vertex = vertex::for_wgpu(entry, major, &mut scope, out, &mut found);
            let known = entries.iter().find(|(name, _)| **name == *entry.name);
            let constant = known.expect("each is named").1.clone();
            names.push(StageNames { entry, constant, vertex, has_constants: false });
        }
    }
    // Constants belong to a shader, and so to each of its entry points.
    let several = program.shaders.len() > 1;
    let mut stages = names.iter_mut();
    for shader in &program.shaders {
        let is_printed = constants::structure(shader, several, &mut scope, out, &mut found);
        for stage in stages.by_ref().take(shader.entries.len()) {
            stage.has_constants = is_printed;
        }
    }
    wgpu_stages::stages(program, &names, major, &mut scope, out);
    for error in &mut found {
        if error.path.is_none() {
            error.path = program.shaders.first().map(|shader| shader.layout.path.clone());
        }
    }
    found
}

/// Prints the names of entry points and their workgroup sizes; returns the constants of the names.
fn entry_points<'p>(
    program: &Program<'p>,
    scope: &mut Scope,
    out: &mut Module,
) -> Vec<(&'p str, String)> {
    let mut names: Vec<(&str, String)> = Vec::new();
    for entry in program.shaders.iter().flat_map(|shader| &shader.entries) {
        let stage = entry.stage.map_or("", Stage::name);
        let shown = escape::name(&entry.name);
        let name = screaming(&entry.name);
        // All of GLSL's are `main`.
        if names.iter().all(|(known, _)| **known != *entry.name) {
            let about = match program.shaders.len() {
                1 => format!("The name of the {stage} entry point `{shown}`."),
                _ => format!("The name of the entry point `{shown}`."),
            };
            let of = scope.take(&format!("{name}_ENTRY"));
            let value = format!("{:?}", &*entry.name);
            out.constant(&about, &format!("{of}: &str"), &value);
            names.push((&entry.name, of));
        }
        let Some(size) = entry.workgroup_size else { continue };
        // One that an override decides is not known before the pipeline is made.
        let [Some(x), Some(y), Some(z)] = size else { continue };
        let of = scope.take(&format!("{name}_WORKGROUP_SIZE"));
        let about = format!("The invocations of a workgroup of `{shown}` along each axis.");
        out.constant(&about, &format!("{of}: [u32; 3]"), &format!("[{x}, {y}, {z}]"));
    }
    names
}

/// Prints the structure of a bind group.
fn bind_group(
    program: &Program<'_>,
    group: u32,
    options: &BindingOptions,
    out: &mut Module,
    found: &mut Vec<Diagnostic>,
) {
    let mut fields = String::new();
    let mut layouts = Vec::new();
    let mut entries = Vec::new();
    let mut names = Scope::default();
    let mut slots = String::new();
    for one in program.in_group(group) {
        let Bound { binding, ty, count, field, resource } = match bound(one, options) {
            Ok(bound) => bound,
            Err(error) => {
                found.push(error);
                continue;
            }
        };
        let name = names.take(&snake(&one.resource.name));
        let _ = writeln!(fields, "    /// {}", about(one, binding));
        let _ = writeln!(fields, "    {PUB} {name}: {field},");
        layouts.push(format!(
            "wgpu::BindGroupLayoutEntry {{\n    binding: {binding},\n    visibility: {},\n    ty: \
             {},\n    count: {count},\n}}",
            stages(&one.stages),
            indented(&ty, 1).trim(),
        ));
        if one.is_named(&options.dynamic_offsets) {
            slots.push_str(&slot(one, &name));
        }
        let resource = resource.replace("FIELD", &format!("self.{name}"));
        let mut line = format!("resource: {resource},");
        // An entry stands 5 levels deep in its module.
        if let (true, Some(at)) = (line.len() > WIDTH - 20, line.find('(')) {
            let inside = &line[at + 1..line.len() - 2];
            line = format!("{}(\n        {inside},\n    ),", &line[..at]);
        }
        entries.push(format!("wgpu::BindGroupEntry {{\n    binding: {binding},\n    {line}\n}}"));
    }
    if layouts.is_empty() {
        return;
    }
    let count = layouts.len();
    out.item(
        &format!("The resources of bind group {group}."),
        &format!("#[derive(Clone, Debug)]\n{PUB} struct Group{group}<'a> {{\n{fields}}}"),
    );
    let layouts = indented(&lines(&layouts), 1);
    let entries = indented(&lines(&entries), 3);
    let label = format!("{} group {group}", program.name);
    out.item(
        "",
        &format!(
            "impl Group{group}<'_> {{\n    \
             /// The number of the group in the pipeline layout.\n    \
             {PUB} const INDEX: u32 = {group};\n    \
             /// The entries of the group's layout.\n    \
             {PUB} const ENTRIES: [wgpu::BindGroupLayoutEntry; {count}] = {};\n\n    \
             /// Creates the group's layout.\n    \
             {PUB} fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {{\n        \
             device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {{\n            \
             label: Some({label:?}),\n            \
             entries: &Self::ENTRIES,\n        }})\n    }}\n\n    \
             /// Creates a bind group of these resources.\n    \
             {PUB} fn bind(\n        &self,\n        device: &wgpu::Device,\n        \
             layout: &wgpu::BindGroupLayout,\n    ) -> wgpu::BindGroup {{\n        \
             device.create_bind_group(&wgpu::BindGroupDescriptor {{\n            \
             label: Some({label:?}),\n            layout,\n            \
             entries: &{},\n        }})\n    }}\n{slots}}}",
            layouts.trim(),
            entries.trim(),
        ),
    );
}

/// The distance of slots of a buffer with a dynamic offset, and the binding of one slot: without a
/// size a binding reaches to the end of the buffer, and no offset but 0 is valid.
fn slot(one: &Binding<'_>, name: &str) -> String {
    let Some(size) = one.block.filter(|_| !is_open(one)).and_then(buffer_size) else {
        return String::new();
    };
    let stride = size.next_multiple_of(DYNAMIC_OFFSET_ALIGNMENT);
    let (constant, shown) = (screaming(name), escape::name(&one.resource.name));
    format!(
        "\n    /// The bytes from one slot of `{shown}` to the next: dynamic offsets are multiples of \
         {DYNAMIC_OFFSET_ALIGNMENT}.\n    \
         {PUB} const {constant}_SLOT_STRIDE: u64 = {stride};\n\n    \
         /// Binds one slot of `{shown}`, {size} bytes at the dynamic offset.\n    \
         {PUB} fn {name}_slot(buffer: &wgpu::Buffer) -> wgpu::BufferBinding<'_> {{\n        \
         let size = core::num::NonZeroU64::new({size});\n        \
         wgpu::BufferBinding {{\n            buffer,\n            offset: 0,\n            size,\n        \
         }}\n    }}\n"
    )
}

/// WebGPU §3.6.2, default limits: minUniformBufferOffsetAlignment and
/// minStorageBufferOffsetAlignment.
const DYNAMIC_OFFSET_ALIGNMENT: u64 = 256;

/// A resource in the documentation of its field.
fn about(one: &Binding<'_>, binding: u32) -> String {
    let name = escape::name(&one.resource.name);
    match (one.block, &one.resource.kind) {
        (Some(block), _) => {
            let of = match *block.name == *one.resource.name {
                true => String::new(),
                false => format!(", a `{}`", escape::name(&block.name)),
            };
            let least = if is_open(one) { "at least " } else { "" };
            format!(
                "Binding {binding}, `{name}`{of}: {least}{} bytes.",
                buffer_size(block).unwrap_or(0)
            )
        }
        (None, ResourceKind::Sampler { comparison: true, .. }) => {
            format!("Binding {binding}, `{name}`: a sampler that compares.")
        }
        (None, _) => format!("Binding {binding}, `{name}`."),
    }
}

/// Whether a buffer ends in a runtime-sized array.
fn is_open(one: &Binding<'_>) -> bool {
    one.block.is_some_and(|block| block.split_tail().1.is_some())
}

/// Prints the function that creates the pipeline layout.
fn pipeline_layout(program: &Program<'_>, major: WgpuMajor, out: &mut Module) {
    let groups = program.groups();
    let count = groups.last().map_or(0, |last| last + 1);
    // Since wgpu 29 a pipeline layout may leave a group out; before, a group below the last one
    // that is used needs a layout without entries.
    let optional = major >= WgpuMajor::V29;
    let mut layouts = Vec::new();
    let mut empty = false;
    for group in 0..count {
        layouts.push(match (groups.contains(&group), optional) {
            (true, true) => format!("Some(&Group{group}::layout(device))"),
            (true, false) => format!("&Group{group}::layout(device)"),
            (false, true) => "None".to_string(),
            (false, false) => {
                empty = true;
                "&unused".to_string()
            }
        });
    }
    let unused = match empty {
        true => {
            "    let unused = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {\n        \
             label: Some(\"unused\"),\n        entries: &[],\n    });\n"
        }
        false => "",
    };
    let push = program.push_constants();
    // wgpu 28 has immediates in place of push constants: bytes for all stages.
    let ranges = match (&push, major) {
        (None, WgpuMajor::V27) => "push_constant_ranges: &[]".to_string(),
        (Some((size, by)), WgpuMajor::V27) => {
            out.item(
                "The stages and bytes of the push constants.",
                &format!(
                    "{PUB} const PUSH_CONSTANT_RANGE: wgpu::PushConstantRange = \
                     wgpu::PushConstantRange {{\n    stages: {},\n    range: 0..{size},\n}};",
                    stages(by)
                ),
            );
            "push_constant_ranges: &[PUSH_CONSTANT_RANGE]".to_string()
        }
        (None, _) => "immediate_size: 0".to_string(),
        (Some((size, _)), _) => {
            let about = "The bytes of the immediates.";
            out.constant(about, "IMMEDIATE_SIZE: u32", &size.to_string());
            "immediate_size: IMMEDIATE_SIZE".to_string()
        }
    };
    let line = layouts.join(", ");
    // The columns that the field's name leaves.
    let layouts = match line.len() <= WIDTH - "        bind_group_layouts: &[],".len() {
        true => format!("[{line}]"),
        false => indented(&lines(&layouts), 2).trim().to_string(),
    };
    out.item(
        "Creates the layout of the pipelines.",
        &format!(
            "{PUB} fn pipeline_layout(device: &wgpu::Device) -> wgpu::PipelineLayout {{\n{unused}    \
             device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {{\n        \
             label: Some({:?}),\n        bind_group_layouts: &{layouts},\n        {ranges},\n    \
             }})\n}}",
            program.name
        ),
    );
}
