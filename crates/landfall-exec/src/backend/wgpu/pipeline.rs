//! Creates shader modules and pipelines, each once.
//!
//! Used by [`run`](super::run). The pipeline layout follows the job's resources, so that SPIR-V,
//! which wgpu does not parse, is bound like a module.

#![allow(unsafe_code, reason = "SPIR-V goes to the driver as it is")]

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use naga::front::wgsl;
use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType,
    BufferBindingType, ComputePipeline, ComputePipelineDescriptor, Features,
    PipelineCompilationOptions, PipelineLayout, PipelineLayoutDescriptor, PrimitiveTopology,
    RenderPipeline, RenderPipelineDescriptor, SamplerBindingType, ShaderModule, ShaderStages,
    TextureFormat, TextureSampleType, TextureViewDimension,
};

use super::device::OpenDevice;
use super::{needs, spirv};
use crate::backend::limits::check_stages;
use crate::backend::{Failure, Grid, Job, Resource, ResourceKind, Texel};
use landfall_ir::Module;
use landfall_layout::source::{ExecutableStage, Stage};

/// The pipelines of one device.
#[derive(Default)]
pub(super) struct Pipelines {
    modules: HashMap<ModuleKey, ShaderModule>,
    pipelines: HashMap<Key, Arc<Pipeline>>,
}

/// A pipeline and its bind groups.
pub(super) struct Pipeline {
    /// The layout of each group up to the last; `None` for empty ones.
    pub(super) groups: Vec<Option<BindGroupLayout>>,
    pub(super) kind: PipelineKind,
}

pub(super) enum PipelineKind {
    Compute(ComputePipeline),
    Render(RenderPipeline),
}

/// The number of pipelines kept; beyond it all are dropped.
const KEPT: usize = 64;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    stages: Vec<(Stage, String, ModuleKey)>,
    bindings: Vec<(u32, u32, BoundAs)>,
    immediates: u32,
    target: Option<(Texel, bool)>,
}

/// The source of a shader module: a module by its identity, SPIR-V by its words.
#[derive(Clone, Debug)]
enum ModuleKey {
    Module(Arc<Module>),
    Spirv(Arc<[u32]>),
    Corners,
}

impl PartialEq for ModuleKey {
    fn eq(&self, other: &ModuleKey) -> bool {
        match (self, other) {
            (ModuleKey::Module(one), ModuleKey::Module(two)) => Arc::ptr_eq(one, two),
            (ModuleKey::Spirv(one), ModuleKey::Spirv(two)) => one == two,
            (ModuleKey::Corners, ModuleKey::Corners) => true,
            (ModuleKey::Module(_) | ModuleKey::Spirv(_) | ModuleKey::Corners, _) => false,
        }
    }
}

impl Eq for ModuleKey {}

impl std::hash::Hash for ModuleKey {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        match self {
            ModuleKey::Module(module) => Arc::as_ptr(module).hash(state),
            ModuleKey::Spirv(words) => words.hash(state),
            ModuleKey::Corners => 0.hash(state),
        }
    }
}

/// The way a resource is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum BoundAs {
    Uniform,
    Storage { writable: bool },
    Texture,
    Sampler,
}

impl Pipelines {
    /// Returns the pipeline of a job, created on first use.
    pub(super) fn get(&mut self, open: &OpenDevice, job: &Job) -> Result<Arc<Pipeline>, Failure> {
        let key = key(job)?;
        if let Some(pipeline) = self.pipelines.get(&key) {
            return Ok(Arc::clone(pipeline));
        }
        if self.pipelines.len() >= KEPT {
            *self = Pipelines::default();
        }
        let mut stages = Vec::with_capacity(key.stages.len());
        for (stage, entry, code) in &key.stages {
            stages.push((*stage, entry.as_str(), self.module(open, *stage, entry, code)?));
        }
        // Every stage sees every binding: of SPIR-V it is not known which stage reads what.
        let visible = key.stages.iter().fold(ShaderStages::NONE, |all, s| all | visibility(s.0));
        let (groups, layout) = layout(open, &key, visible)?;
        let kind = open.checked("the pipeline", || Ok(pipeline(open, &key, &stages, &layout)));
        // wgpu's message has the binding without the name.
        let kind = kind.map_err(|failure| match unbound(&key) {
            Some(message) => Failure { message, ..failure },
            None => failure,
        })?;
        let pipeline = Arc::new(Pipeline { groups, kind });
        self.pipelines.insert(key, Arc::clone(&pipeline));
        Ok(pipeline)
    }

    fn module(
        &mut self,
        open: &OpenDevice,
        stage: Stage,
        entry: &str,
        code: &ModuleKey,
    ) -> Result<ShaderModule, Failure> {
        if let Some(module) = self.modules.get(code) {
            return Ok(module.clone());
        }
        let doing = format!("the {} shader", stage.name());
        let made = open.checked(&doing, || match code {
            ModuleKey::Module(module) => match needs::lacking(&module.ir, open.device.features()) {
                Some(failure) => Err(failure),
                None => Ok(of_module(open, module.ir.clone())),
            },
            ModuleKey::Corners => Ok(of_module(open, corners().clone())),
            ModuleKey::Spirv(words) => {
                let workgroup_size = spirv::workgroup_size(words)?;
                if !open.device.features().contains(Features::PASSTHROUGH_SHADERS) {
                    return Err(Failure::refused("this adapter does not accept SPIR-V", ""));
                }
                let entry = wgpu::PassthroughShaderEntryPoint {
                    name: Cow::Borrowed(entry),
                    workgroup_size,
                };
                let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
                    label: None,
                    entry_points: Cow::Owned(vec![entry]),
                    spirv: Some(Cow::Borrowed(words)),
                    ..Default::default()
                };
                // SAFETY: the words are whole instructions of a third-party compiler; a driver
                // that crashes on them ends only this process, which `subprocess` allows for.
                Ok(unsafe { open.device.create_shader_module_passthrough(descriptor) })
            }
        })?;
        self.modules.insert(code.clone(), made.clone());
        Ok(made)
    }
}

fn of_module(open: &OpenDevice, ir: naga::Module) -> ShaderModule {
    open.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(Cow::Owned(ir)),
    })
}

/// Returns the vertex shader for a lone fragment shader: a triangle over the whole image.
fn corners() -> &'static naga::Module {
    static CORNERS: OnceLock<naga::Module> = OnceLock::new();
    CORNERS.get_or_init(|| {
        // The corners are (-1, -1), (3, -1) and (-1, 3).
        let text = "@vertex fn main(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
            return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
        }";
        wgsl::parse_str(text).expect("it is written above")
    })
}

fn key(job: &Job) -> Result<Key, Failure> {
    let mut stages = Vec::new();
    for code in &job.stages {
        let stage = code.stage;
        let from = match (&code.spirv, &code.module) {
            (Some(words), _) => ModuleKey::Spirv(Arc::clone(words)),
            (None, Some(module)) => ModuleKey::Module(Arc::clone(module)),
            (None, None) => {
                let message = format!(
                    "wgpu needs a module or SPIR-V, but the {} stage has neither",
                    stage.name()
                );
                return Err(Failure::refused(message, ""));
            }
        };
        stages.push((stage, code.entry.clone(), from));
    }
    check_stages(job)?;
    let target = match job.grid {
        Grid::Groups(_) => None,
        Grid::Image { texel, .. } => {
            if stages.iter().all(|row| row.0 != Stage::Vertex) {
                stages.push((Stage::Vertex, "main".to_string(), ModuleKey::Corners));
            }
            Some((texel, false))
        }
        Grid::Points { texel, .. } => Some((texel, true)),
    };
    let mut bindings: Vec<(u32, u32, BoundAs)> = job.resources.iter().filter_map(binding).collect();
    // The order of the resources makes no other pipeline.
    bindings.sort_by_key(|&(group, binding, _)| (group, binding));
    let immediates = job.resources.iter().map(|resource| match &resource.kind {
        // Immediates are written in words of four bytes.
        ResourceKind::PushConstant(bytes) => bytes.len().next_multiple_of(4),
        ResourceKind::Uniform(_)
        | ResourceKind::Storage { .. }
        | ResourceKind::Texture { .. }
        | ResourceKind::Sampler
        | ResourceKind::Loose(_) => 0,
    });
    let immediates = immediates.sum::<usize>().try_into().unwrap_or(u32::MAX);
    Ok(Key { stages, bindings, immediates, target })
}

fn binding(resource: &Resource) -> Option<(u32, u32, BoundAs)> {
    let kind = match &resource.kind {
        ResourceKind::Uniform(_) => BoundAs::Uniform,
        ResourceKind::Storage { writable, .. } => BoundAs::Storage { writable: *writable },
        ResourceKind::Texture { .. } => BoundAs::Texture,
        ResourceKind::Sampler => BoundAs::Sampler,
        ResourceKind::PushConstant(_) | ResourceKind::Loose(_) => return None,
    };
    Some((resource.group, resource.binding, kind))
}

fn visibility(stage: Stage) -> ShaderStages {
    match ExecutableStage::from_stage(stage) {
        Some(ExecutableStage::Vertex) => ShaderStages::VERTEX,
        Some(ExecutableStage::Fragment) => ShaderStages::FRAGMENT,
        Some(ExecutableStage::Compute) => ShaderStages::COMPUTE,
        None => ShaderStages::NONE,
    }
}

/// Returns a message about a resource of the module that the job does not bind.
fn unbound(key: &Key) -> Option<String> {
    key.stages.iter().find_map(|(_, _, code)| {
        let ModuleKey::Module(module) = code else { return None };
        module.ir.global_variables.iter().find_map(|(_, global)| {
            let place = global.binding?;
            let (group, binding) = (place.group, place.binding);
            if key.bindings.iter().any(|row| (row.0, row.1) == (group, binding)) {
                return None;
            }
            let name = global.name.as_deref().unwrap_or("a block");
            Some(format!(
                "the shader reads `{name}` (group {group}, binding {binding}), but nothing is \
                 bound to it"
            ))
        })
    })
}

type Groups = Vec<Option<BindGroupLayout>>;

fn layout(
    open: &OpenDevice,
    key: &Key,
    visible: ShaderStages,
) -> Result<(Groups, PipelineLayout), Failure> {
    let writable_in_vertex = open.device.features().contains(Features::VERTEX_WRITABLE_STORAGE);
    let entry = |&(_, binding, kind): &(u32, u32, BoundAs)| {
        let buffer =
            |ty| BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let mut visibility = visible;
        let ty = match kind {
            BoundAs::Uniform => buffer(BufferBindingType::Uniform),
            BoundAs::Storage { writable } => {
                // By default, WebGPU lets a vertex stage write no buffer.
                if writable && !writable_in_vertex {
                    visibility -= ShaderStages::VERTEX;
                }
                buffer(BufferBindingType::Storage { read_only: !writable })
            }
            BoundAs::Texture => BindingType::Texture {
                // Filtering of 32-bit floats is a feature of its own, and the nearest texel needs
                // none.
                sample_type: TextureSampleType::Float { filterable: false },
                view_dimension: TextureViewDimension::D2,
                multisampled: false,
            },
            BoundAs::Sampler => BindingType::Sampler(SamplerBindingType::NonFiltering),
        };
        BindGroupLayoutEntry { binding, visibility, ty, count: None }
    };
    open.checked("the bindings", || {
        // A group without bindings has a place in the layout, too.
        let last = key.bindings.iter().map(|row| row.0 + 1).max().unwrap_or(0);
        let groups: Groups = (0..last)
            .map(|group| {
                let here = key.bindings.iter().filter(|row| row.0 == group);
                let entries: Vec<BindGroupLayoutEntry> = here.map(entry).collect();
                let descriptor = BindGroupLayoutDescriptor { label: None, entries: &entries };
                (!entries.is_empty()).then(|| open.device.create_bind_group_layout(&descriptor))
            })
            .collect();
        let bind_group_layouts: Vec<Option<&BindGroupLayout>> =
            groups.iter().map(Option::as_ref).collect();
        let layout = open.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &bind_group_layouts,
            immediate_size: key.immediates,
        });
        Ok((groups, layout))
    })
}

fn pipeline(
    open: &OpenDevice,
    key: &Key,
    stages: &[(Stage, &str, ShaderModule)],
    layout: &PipelineLayout,
) -> PipelineKind {
    let of = |stage| {
        let found = stages.iter().find(|row| row.0 == stage);
        let (_, entry, module) = found.expect("the key was made with the stages of its grid");
        (module, Some(*entry))
    };
    let Some((texel, points)) = key.target else {
        let (module, entry_point) = of(Stage::Compute);
        return PipelineKind::Compute(open.device.create_compute_pipeline(
            &ComputePipelineDescriptor {
                label: None,
                layout: Some(layout),
                module,
                entry_point,
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            },
        ));
    };
    let (vertex, vertex_entry) = of(Stage::Vertex);
    let (fragment, fragment_entry) = of(Stage::Fragment);
    let topology =
        if points { PrimitiveTopology::PointList } else { PrimitiveTopology::TriangleList };
    PipelineKind::Render(open.device.create_render_pipeline(&RenderPipelineDescriptor {
        label: None,
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: vertex,
            entry_point: vertex_entry,
            compilation_options: PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState { topology, ..Default::default() },
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: fragment,
            entry_point: fragment_entry,
            compilation_options: PipelineCompilationOptions::default(),
            targets: &[Some(format(texel).into())],
        }),
        multiview_mask: None,
        cache: None,
    }))
}

/// Returns the format of the render target.
pub(super) fn format(texel: Texel) -> TextureFormat {
    match texel {
        Texel::Float => TextureFormat::Rgba32Float,
        Texel::Uint => TextureFormat::Rgba32Uint,
    }
}
