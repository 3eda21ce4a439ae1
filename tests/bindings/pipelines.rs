//! Makes a pipeline of every entry point with the generated layouts, and again with each layout
//! changed in one place, which wgpu must refuse. Prints one line a program and exits with 1 if
//! anything is not as expected.

#![deny(warnings)]

/// The bindings of every shader, and `programs()`, which lists them.
mod generated {
    #![allow(dead_code)]
    use super::*;
    include!(env!("LANDFALL_GENERATED"));
}

use wgpu::*;

/// What is known of a program.
pub struct Program {
    pub name: &'static str,
    pub groups: Vec<(u32, Vec<BindGroupLayoutEntry>)>,
    pub immediates: u32,
    /// Whether wgpu computes the sizes that WGSL defines.
    pub is_exact: bool,
    pub module: fn(&Device) -> ShaderModule,
    pub layout: fn(&Device) -> PipelineLayout,
    pub pipelines: Vec<Pipeline>,
}

/// A pipeline to be made of a program.
pub enum Pipeline {
    Compute { entry: &'static str, constants: Vec<(&'static str, f64)> },
    Render(Render),
}

pub struct Render {
    /// The vertex shader, if the module has none that fits.
    pub vertex_module: Option<fn(&Device) -> ShaderModule>,
    pub vertex: &'static str,
    pub fragment: Option<&'static str>,
    pub buffer: Option<(u64, Vec<VertexAttribute>)>,
    pub targets: Vec<TextureFormat>,
    pub has_depth: bool,
    pub samples: u32,
    pub constants: Vec<(&'static str, f64)>,
}

fn main() {
    let (device, adapter) = open();
    println!("{adapter}");
    let mut failed = false;
    for program in generated::programs() {
        let mut faults = 0;
        let layout = checked(&device, || (program.layout)(&device));
        let module = checked(&device, || (program.module)(&device));
        let (layout, module) = match (layout, module) {
            (Ok(layout), Ok(module)) => (layout, module),
            (Err(error), _) | (_, Err(error)) => {
                println!("{}: FAILED: {error}", program.name);
                failed = true;
                continue;
            }
        };
        if let Err(error) = all(&device, &program, &layout, &module) {
            println!("{}: FAILED: {error}", program.name);
            failed = true;
            continue;
        }
        for (what, groups, immediates) in mutants(&program) {
            let made = checked(&device, || pipeline_layout(&device, &groups, immediates));
            let made = made.and_then(|layout| all(&device, &program, &layout, &module));
            faults += 1;
            if made.is_ok() {
                println!("{}: FAILED: accepted {what}", program.name);
                failed = true;
            }
        }
        faults += vertex_faults(&device, &program, &layout, &module, &mut failed);
        println!(
            "{}: {} pipelines, {faults} faults refused",
            program.name,
            program.pipelines.len()
        );
    }
    std::process::exit(i32::from(failed));
}

fn open() -> (Device, String) {
    #[cfg(feature = "v27")]
    let instance = Instance::new(&InstanceDescriptor::default());
    #[cfg(feature = "v28")]
    let instance = Instance::new(&InstanceDescriptor::default());
    #[cfg(any(feature = "v29", feature = "v30"))]
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    let options = RequestAdapterOptions::default();
    let adapter = pollster::block_on(instance.request_adapter(&options)).expect("an adapter");
    #[cfg(feature = "v27")]
    let wanted = Features::PUSH_CONSTANTS;
    #[cfg(not(feature = "v27"))]
    let wanted = Features::IMMEDIATES;
    let wanted = wanted
        | Features::SHADER_F16
        | Features::SHADER_F64
        | Features::VERTEX_ATTRIBUTE_64BIT
        | Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
    let descriptor = DeviceDescriptor {
        required_features: adapter.features() & wanted,
        required_limits: adapter.limits(),
        ..Default::default()
    };
    let device = pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
    let info = adapter.get_info();
    (device.0, format!("{}, {}", info.name, info.driver_info))
}

/// A module of WGSL.
fn wgsl(device: &Device, text: &'static str) -> ShaderModule {
    let source = ShaderSource::Wgsl(text.into());
    device.create_shader_module(ShaderModuleDescriptor { label: None, source })
}

/// A module of GLSL.
fn glsl(device: &Device, text: &'static str, stage: naga::ShaderStage) -> ShaderModule {
    let source = ShaderSource::Glsl { shader: text.into(), stage, defines: Default::default() };
    device.create_shader_module(ShaderModuleDescriptor { label: None, source })
}

/// Runs what may be invalid.
fn checked<T>(device: &Device, make: impl FnOnce() -> T) -> Result<T, String> {
    #[cfg(feature = "v27")]
    let (made, error) = {
        device.push_error_scope(ErrorFilter::Validation);
        let made = make();
        (made, pollster::block_on(device.pop_error_scope()))
    };
    #[cfg(not(feature = "v27"))]
    let (made, error) = {
        let scope = device.push_error_scope(ErrorFilter::Validation);
        let made = make();
        (made, pollster::block_on(scope.pop()))
    };
    match error {
        None => Ok(made),
        Some(error) => Err(error.to_string()),
    }
}

/// Makes all pipelines of a program.
fn all(
    device: &Device,
    program: &Program,
    layout: &PipelineLayout,
    module: &ShaderModule,
) -> Result<(), String> {
    for pipeline in &program.pipelines {
        match pipeline {
            Pipeline::Compute { entry, constants } => drop(checked(device, || {
                device.create_compute_pipeline(&ComputePipelineDescriptor {
                    label: None,
                    layout: Some(layout),
                    module,
                    entry_point: Some(entry),
                    compilation_options: options(constants),
                    cache: None,
                })
            })?),
            Pipeline::Render(of) => render(device, of, of.buffer.as_ref(), layout, module)?,
        }
    }
    Ok(())
}

fn options<'a>(constants: &'a [(&'a str, f64)]) -> PipelineCompilationOptions<'a> {
    PipelineCompilationOptions { constants, ..Default::default() }
}

fn render(
    device: &Device,
    of: &Render,
    buffer: Option<&(u64, Vec<VertexAttribute>)>,
    layout: &PipelineLayout,
    module: &ShaderModule,
) -> Result<(), String> {
    let other = of.vertex_module.map(|module| module(device));
    let buffers: Vec<_> = buffer
        .iter()
        .map(|(array_stride, attributes)| VertexBufferLayout {
            array_stride: *array_stride,
            step_mode: VertexStepMode::Vertex,
            attributes,
        })
        .collect();
    #[cfg(feature = "v30")]
    let buffers: Vec<_> = buffers.into_iter().map(Some).collect();
    let targets: Vec<_> = of.targets.iter().map(|format| Some((*format).into())).collect();
    let constants = |own: bool| if own { options(&of.constants) } else { Default::default() };
    let descriptor = RenderPipelineDescriptor {
        label: None,
        layout: Some(layout),
        vertex: VertexState {
            module: other.as_ref().unwrap_or(module),
            entry_point: Some(of.vertex),
            compilation_options: constants(other.is_none()),
            buffers: &buffers,
        },
        primitive: Default::default(),
        depth_stencil: depth(of.has_depth),
        multisample: MultisampleState { count: of.samples, ..Default::default() },
        fragment: of.fragment.map(|entry| FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: constants(true),
            targets: &targets,
        }),
        #[cfg(feature = "v27")]
        multiview: None,
        #[cfg(not(feature = "v27"))]
        multiview_mask: None,
        cache: None,
    };
    checked(device, || device.create_render_pipeline(&descriptor)).map(drop)
}

fn depth(wanted: bool) -> Option<DepthStencilState> {
    #[cfg(any(feature = "v27", feature = "v28"))]
    let (write, compare) = (true, CompareFunction::Less);
    #[cfg(any(feature = "v29", feature = "v30"))]
    let (write, compare) = (Some(true), Some(CompareFunction::Less));
    wanted.then(|| DepthStencilState {
        format: TextureFormat::Depth32Float,
        depth_write_enabled: write,
        depth_compare: compare,
        stencil: Default::default(),
        bias: Default::default(),
    })
}

type Groups = Vec<(u32, Vec<BindGroupLayoutEntry>)>;

fn pipeline_layout(device: &Device, groups: &Groups, immediates: u32) -> PipelineLayout {
    let count = groups.iter().map(|(group, _)| group + 1).max().unwrap_or(0);
    let layouts: Vec<BindGroupLayout> = (0..count)
        .map(|group| {
            let of = groups.iter().find(|(known, _)| *known == group);
            let entries = of.map_or(&[][..], |(_, entries)| entries);
            device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: None, entries })
        })
        .collect();
    #[cfg(any(feature = "v27", feature = "v28"))]
    let layouts: Vec<_> = layouts.iter().collect();
    #[cfg(any(feature = "v29", feature = "v30"))]
    let layouts: Vec<_> = layouts.iter().map(Some).collect();
    device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &layouts,
        #[cfg(feature = "v27")]
        push_constant_ranges: &match immediates {
            0 => vec![],
            size => {
                vec![PushConstantRange { stages: ShaderStages::VERTEX_FRAGMENT, range: 0..size }]
            }
        },
        #[cfg(not(feature = "v27"))]
        immediate_size: immediates,
    })
}

/// The layouts with one fault each.
fn mutants(program: &Program) -> Vec<(String, Groups, u32)> {
    let mut all = Vec::new();
    for (at, (group, entries)) in program.groups.iter().enumerate() {
        for (index, entry) in entries.iter().enumerate() {
            let name = format!("group {group} binding {}", entry.binding);
            let mut add = |what: String, new: Option<BindGroupLayoutEntry>| {
                let mut groups = program.groups.clone();
                match new {
                    Some(new) => groups[at].1[index] = new,
                    None => drop(groups[at].1.remove(index)),
                }
                all.push((format!("{name} {what}"), groups, program.immediates));
            };
            add("left out".to_string(), None);
            add("elsewhere".to_string(), Some(BindGroupLayoutEntry { binding: 99, ..*entry }));
            for stage in [ShaderStages::VERTEX, ShaderStages::FRAGMENT, ShaderStages::COMPUTE] {
                if entry.visibility.contains(stage) {
                    let visibility = entry.visibility - stage;
                    let new = BindGroupLayoutEntry { visibility, ..*entry };
                    add(format!("hidden from {stage:?}"), Some(new));
                }
            }
            for ty in wrong(&entry.ty, program.is_exact) {
                add(format!("as {ty:?}"), Some(BindGroupLayoutEntry { ty, ..*entry }));
            }
        }
    }
    all
}

/// Types that are wrong in one property.
fn wrong(ty: &BindingType, is_exact: bool) -> Vec<BindingType> {
    match *ty {
        BindingType::Buffer { ty, has_dynamic_offset, min_binding_size } => {
            let size = min_binding_size.expect("every buffer has a least size").get();
            let buffer = |ty, size| BindingType::Buffer {
                ty,
                has_dynamic_offset,
                min_binding_size: std::num::NonZeroU64::new(size),
            };
            let mut all = if is_exact { vec![buffer(ty, size - 1)] } else { vec![] };
            all.extend(match ty {
                BufferBindingType::Uniform => {
                    vec![buffer(BufferBindingType::Storage { read_only: true }, size)]
                }
                BufferBindingType::Storage { read_only } => vec![
                    buffer(BufferBindingType::Uniform, size),
                    buffer(BufferBindingType::Storage { read_only: !read_only }, size),
                ],
            });
            all
        }
        BindingType::Sampler(SamplerBindingType::Comparison) => {
            vec![BindingType::Sampler(SamplerBindingType::Filtering)]
        }
        // What a sampler that does not filter is for is the texture's type.
        BindingType::Sampler(_) => vec![BindingType::Sampler(SamplerBindingType::Comparison)],
        BindingType::Texture { sample_type, view_dimension, multisampled } => {
            let texture = |sample_type, view_dimension| BindingType::Texture {
                sample_type,
                view_dimension,
                multisampled,
            };
            let other = match sample_type {
                TextureSampleType::Uint => TextureSampleType::Sint,
                _ => TextureSampleType::Uint,
            };
            let view = other_view(view_dimension);
            vec![texture(other, view_dimension), texture(sample_type, view)]
        }
        BindingType::StorageTexture { access, format, view_dimension } => {
            let texture = |access, format, view_dimension| BindingType::StorageTexture {
                access,
                format,
                view_dimension,
            };
            let format2 = match format {
                TextureFormat::R32Uint => TextureFormat::R32Float,
                _ => TextureFormat::R32Uint,
            };
            let access2 = match access {
                StorageTextureAccess::ReadOnly => StorageTextureAccess::WriteOnly,
                _ => StorageTextureAccess::ReadOnly,
            };
            let view = other_view(view_dimension);
            vec![
                texture(access, format2, view_dimension),
                texture(access2, format, view_dimension),
                texture(access, format, view),
            ]
        }
        _ => Vec::new(),
    }
}

fn other_view(view: TextureViewDimension) -> TextureViewDimension {
    match view {
        TextureViewDimension::D2 => TextureViewDimension::D2Array,
        _ => TextureViewDimension::D2,
    }
}

/// Vertex buffers with one fault each; returns how many.
fn vertex_faults(
    device: &Device,
    program: &Program,
    layout: &PipelineLayout,
    module: &ShaderModule,
    failed: &mut bool,
) -> usize {
    let mut count = 0;
    for pipeline in &program.pipelines {
        let Pipeline::Render(of) = pipeline else { continue };
        let Some((stride, attributes)) = &of.buffer else { continue };
        let mut faults = Vec::new();
        for at in 0..attributes.len() {
            let mut fewer = attributes.clone();
            fewer.remove(at);
            faults.push((format!("no attribute {at}"), *stride, fewer));
            let mut other = attributes.clone();
            other[at].format = match format!("{:?}", other[at].format).starts_with("Float") {
                true => VertexFormat::Uint32,
                false => VertexFormat::Float32,
            };
            faults.push((format!("another format of attribute {at}"), *stride, other));
        }
        faults.push(("a stride of 4 bytes less".to_string(), stride - 4, attributes.clone()));
        for (what, stride, attributes) in faults {
            count += 1;
            if render(device, of, Some(&(stride, attributes)), layout, module).is_ok() {
                println!("{}: FAILED: accepted {what}", program.name);
                *failed = true;
            }
        }
    }
    count
}
