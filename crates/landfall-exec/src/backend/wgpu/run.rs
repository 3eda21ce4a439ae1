//! Runs one job on one device: fills buffers, runs, reads back.

use crate::processor::Stopwatch;
use std::num::NonZeroU64;

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferBinding,
    BufferDescriptor, BufferUsages, CommandEncoder, Extent3d, Features, MapMode, PollError,
    PollType, Sampler, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
    TextureView,
};

use super::device::OpenDevice;
use super::pipeline::{Pipeline, PipelineKind, Pipelines, format};
use super::timing::Timestamps;
use crate::backend::devices::Limits;
use crate::backend::limits::{check_grid, check_resource, twice};
use crate::backend::{Failure, Grid, Job, JobOutput, Resource, ResourceKind};

pub(super) fn run(
    open: &OpenDevice,
    pipelines: &mut Pipelines,
    limits: &Limits,
    job: &Job,
    timestamps: Option<&Timestamps>,
) -> Result<JobOutput, Failure> {
    let begun = Stopwatch::start();
    open.alive()?;
    check(open, limits, job)?;
    let pipeline = pipelines.get(open, job)?;
    let (resources_on_gpu, back) = open.checked("the job", || {
        let resources_on_gpu: Vec<GpuResource> =
            job.resources.iter().map(|r| GpuResource::new(open, r)).collect();
        let groups = bind(open, &pipeline, &job.resources, &resources_on_gpu);
        let mut encoder = open.device.create_command_encoder(&Default::default());
        let image = record(open, &mut encoder, &pipeline, &groups, job, timestamps);
        let back = Back::record(open, &mut encoder, &resources_on_gpu, image.as_ref());
        timestamps.into_iter().for_each(|timestamps| timestamps.record(&mut encoder));
        open.queue.submit([encoder.finish()]);
        back.map();
        timestamps.into_iter().for_each(Timestamps::map);
        Ok((resources_on_gpu, back))
    })?;
    // The wait is of the wall clock, the limit of the processor time.
    loop {
        let left = job.limit.saturating_sub(begun.elapsed());
        let wait = PollType::Wait { submission_index: None, timeout: Some(left) };
        match open.device.poll(wait) {
            Ok(_) => break,
            Err(PollError::Timeout) if begun.elapsed() < job.limit => {}
            Err(PollError::Timeout) => return Err(Failure::timed_out(job.limit)),
            Err(cause @ PollError::WrongSubmissionIndex(..)) => {
                return Err(Failure::died("wgpu lost the submitted job", cause.to_string()));
            }
        }
    }
    open.alive()?;
    back.read(&resources_on_gpu)
}

/// Checks the job before anything is created.
fn check(open: &OpenDevice, limits: &Limits, job: &Job) -> Result<(), Failure> {
    for (at, resource) in job.resources.iter().enumerate() {
        let before = &job.resources[..at];
        let Resource { name, group, binding, kind } = resource;
        // Push constants have no binding, and loose uniforms are not bound.
        let pushes = |r: &Resource| matches!(r.kind, ResourceKind::PushConstant(_));
        let placed = |r: &Resource| !pushes(r) && !matches!(r.kind, ResourceKind::Loose(_));
        if pushes(resource) {
            if before.iter().any(pushes) {
                return Err(twice("the push constants"));
            }
        } else if placed(resource) {
            let here = |r: &&Resource| placed(r) && (r.group, r.binding) == (*group, *binding);
            if let Some(other) = before.iter().find(here) {
                let place =
                    format!("group {group}, binding {binding} (`{}`, `{name}`)", other.name);
                return Err(twice(&place));
            }
        }
        let some = |bytes: &[u8]| match bytes {
            [] => Err(Failure::refused(format!("the block `{name}` has no bytes to bind"), "")),
            _ => Ok(()),
        };
        match kind {
            ResourceKind::Uniform(bytes) | ResourceKind::Storage { bytes, .. } => some(bytes)?,
            ResourceKind::PushConstant(bytes) => {
                some(bytes)?;
                if !open.device.features().contains(Features::IMMEDIATES) {
                    let message = format!(
                        "this adapter has no push constants, but `{name}` is a push constant block"
                    );
                    return Err(Failure::refused(message, ""));
                }
            }
            ResourceKind::Texture { texels, .. } if texels.is_empty() => {
                let message = format!("the texture `{name}` has no texels to bind");
                return Err(Failure::refused(message, ""));
            }
            ResourceKind::Texture { .. } | ResourceKind::Sampler | ResourceKind::Loose(_) => {}
        }
        check_resource(resource, limits)?;
    }
    check_grid(job.grid, limits)
}

/// A resource on the device.
enum GpuResource {
    /// A buffer, its bound size, and the size that is read back.
    Buffer {
        buffer: Buffer,
        bound: u64,
        back: Option<usize>,
    },
    Texture(TextureView),
    Sampler(Sampler),
    /// Immediates, and resources that wgpu does not bind.
    Unplaced,
}

impl GpuResource {
    fn new(open: &OpenDevice, resource: &Resource) -> GpuResource {
        match &resource.kind {
            // A uniform buffer is bound at its exact size: a larger one would hide that the shader
            // needs more than the layout has.
            ResourceKind::Uniform(bytes) => {
                let buffer = filled(open, bytes, BufferUsages::UNIFORM);
                GpuResource::Buffer { buffer, bound: bytes.len() as u64, back: None }
            }
            // WebGPU binds storage buffers in multiples of four bytes.
            ResourceKind::Storage { bytes, writable } => {
                let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
                let bound = bytes.len().next_multiple_of(4) as u64;
                let back = writable.then_some(bytes.len());
                GpuResource::Buffer { buffer: filled(open, bytes, usage), bound, back }
            }
            ResourceKind::PushConstant(_) | ResourceKind::Loose(_) => GpuResource::Unplaced,
            ResourceKind::Texture { width, height, texels } => {
                let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
                let texture = image(open, (*width, *height), TextureFormat::Rgba32Float, usage);
                open.queue.write_texture(
                    texture.as_image_copy(),
                    bytemuck::cast_slice(texels),
                    wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(width * TEXEL),
                        rows_per_image: None,
                    },
                    texture.size(),
                );
                GpuResource::Texture(texture.create_view(&Default::default()))
            }
            ResourceKind::Sampler => {
                // As the interpreter samples: the nearest texel, repeating.
                let repeat = wgpu::AddressMode::Repeat;
                GpuResource::Sampler(open.device.create_sampler(&wgpu::SamplerDescriptor {
                    address_mode_u: repeat,
                    address_mode_v: repeat,
                    address_mode_w: repeat,
                    ..Default::default()
                }))
            }
        }
    }
}

/// Bytes of a texel of four 32-bit components.
const TEXEL: u32 = 16;

fn filled(open: &OpenDevice, bytes: &[u8], usage: BufferUsages) -> Buffer {
    // Buffers are written in words of four bytes.
    let mut padded = bytes.to_vec();
    padded.resize(bytes.len().next_multiple_of(4), 0);
    let size = padded.len() as u64;
    let usage = usage | BufferUsages::COPY_DST;
    let descriptor = BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
    let buffer = open.device.create_buffer(&descriptor);
    open.queue.write_buffer(&buffer, 0, &padded);
    buffer
}

fn image(
    open: &OpenDevice,
    (width, height): (u32, u32),
    format: TextureFormat,
    usage: TextureUsages,
) -> Texture {
    open.device.create_texture(&TextureDescriptor {
        label: None,
        size: Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

fn bind(
    open: &OpenDevice,
    pipeline: &Pipeline,
    resources: &[Resource],
    resources_on_gpu: &[GpuResource],
) -> Vec<Option<BindGroup>> {
    let of_group = |group: usize| {
        let here = resources.iter().zip(resources_on_gpu);
        let here = here.filter(move |(resource, _)| resource.group as usize == group);
        let entries: Vec<BindGroupEntry<'_>> = here
            .filter_map(|(resource, gpu_resource)| {
                let resource_bound = match gpu_resource {
                    GpuResource::Buffer { buffer, bound, .. } => {
                        let size = NonZeroU64::new(*bound);
                        BindingResource::Buffer(BufferBinding { buffer, offset: 0, size })
                    }
                    GpuResource::Texture(view) => BindingResource::TextureView(view),
                    GpuResource::Sampler(sampler) => BindingResource::Sampler(sampler),
                    GpuResource::Unplaced => return None,
                };
                Some(BindGroupEntry { binding: resource.binding, resource: resource_bound })
            })
            .collect();
        entries
    };
    (0..)
        .zip(&pipeline.groups)
        .map(|(group, layout)| {
            let layout = layout.as_ref()?;
            let entries = of_group(group);
            let descriptor = BindGroupDescriptor { label: None, layout, entries: &entries };
            Some(open.device.create_bind_group(&descriptor))
        })
        .collect()
}

/// Records the pass, and copies its image for read-back.
fn record(
    open: &OpenDevice,
    encoder: &mut CommandEncoder,
    pipeline: &Pipeline,
    groups: &[Option<BindGroup>],
    job: &Job,
    timestamps: Option<&Timestamps>,
) -> Option<Texture> {
    let immediates = job.resources.iter().find_map(|resource| match &resource.kind {
        ResourceKind::PushConstant(bytes) => {
            let mut padded = bytes.clone();
            padded.resize(bytes.len().next_multiple_of(4), 0);
            Some(padded)
        }
        ResourceKind::Uniform(_)
        | ResourceKind::Storage { .. }
        | ResourceKind::Texture { .. }
        | ResourceKind::Sampler
        | ResourceKind::Loose(_) => None,
    });
    let (size, texel, vertices) = match job.grid {
        Grid::Groups([x, y, z]) => {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: None,
                timestamp_writes: timestamps.map(Timestamps::compute),
            });
            if let PipelineKind::Compute(pipeline) = &pipeline.kind {
                pass.set_pipeline(pipeline);
            }
            for (index, group) in (0..).zip(groups) {
                pass.set_bind_group(index, group.as_ref(), &[]);
            }
            if let Some(bytes) = &immediates {
                pass.set_immediates(0, bytes);
            }
            pass.dispatch_workgroups(x, y, z);
            return None;
        }
        Grid::Image { width, height, texel } => ((width, height), texel, 3),
        Grid::Points { count, texel } => ((count, 1), texel, count),
    };
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let target = image(open, size, format(texel), usage);
    let view = target.create_view(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                // Discarded fragments leave zeros.
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })],
        timestamp_writes: timestamps.map(Timestamps::render),
        ..Default::default()
    });
    if let PipelineKind::Render(pipeline) = &pipeline.kind {
        pass.set_pipeline(pipeline);
    }
    for (index, group) in (0..).zip(groups) {
        pass.set_bind_group(index, group.as_ref(), &[]);
    }
    if let Some(bytes) = &immediates {
        pass.set_immediates(0, bytes);
    }
    pass.draw(0..vertices, 0..1);
    drop(pass);
    Some(target)
}

/// The buffers for read-back.
struct Back {
    /// By resource: its copy.
    buffers: Vec<Option<Buffer>>,
    /// The image, its bytes per row, and its size.
    image: Option<(Buffer, u32, (u32, u32))>,
}

impl Back {
    fn record(
        open: &OpenDevice,
        encoder: &mut CommandEncoder,
        resources_on_gpu: &[GpuResource],
        image: Option<&Texture>,
    ) -> Back {
        let room = |size| {
            let usage = BufferUsages::COPY_DST | BufferUsages::MAP_READ;
            let descriptor =
                BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
            open.device.create_buffer(&descriptor)
        };
        let buffers = resources_on_gpu.iter().map(|gpu_resource| match gpu_resource {
            GpuResource::Buffer { buffer, bound, back: Some(_) } => {
                let copy = room(*bound);
                encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, *bound);
                Some(copy)
            }
            GpuResource::Buffer { back: None, .. }
            | GpuResource::Texture(_)
            | GpuResource::Sampler(_)
            | GpuResource::Unplaced => None,
        });
        let buffers = buffers.collect();
        let image = image.map(|texture| {
            let size = texture.size();
            // WebGPU copies rows to multiples of 256 bytes.
            let stride = (size.width * TEXEL).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
            let copy = room(u64::from(stride) * u64::from(size.height));
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(stride),
                rows_per_image: None,
            };
            let to = wgpu::TexelCopyBufferInfo { buffer: &copy, layout };
            encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
            (copy, stride, (size.width, size.height))
        });
        Back { buffers, image }
    }

    /// Maps the buffers; they are readable when the job is done.
    fn map(&self) {
        let image = self.image.iter().map(|image| &image.0);
        for buffer in self.buffers.iter().flatten().chain(image) {
            // An error shows when the range is read.
            buffer.map_async(MapMode::Read, .., |_| {});
        }
    }

    fn read(&self, resources_on_gpu: &[GpuResource]) -> Result<JobOutput, Failure> {
        let bytes = |buffer: &Buffer| {
            let range = buffer.get_mapped_range(..);
            let unread = "the results cannot be read back";
            range.map(|view| view.to_vec()).map_err(|e| Failure::died(unread, e.to_string()))
        };
        let mut buffers = Vec::with_capacity(resources_on_gpu.len());
        for (gpu_resource, copy) in resources_on_gpu.iter().zip(&self.buffers) {
            buffers.push(match (gpu_resource, copy) {
                (GpuResource::Buffer { back: Some(length), .. }, Some(copy)) => {
                    let mut bytes = bytes(copy)?;
                    // More was bound than the resource has bytes.
                    bytes.truncate(*length);
                    Some(bytes)
                }
                _ => None,
            });
        }
        let mut pixels = Vec::new();
        if let Some((copy, stride, (width, _))) = &self.image {
            for row in bytes(copy)?.chunks_exact(*stride as usize) {
                // Without the bytes that fill the row up.
                let row = &row[..(width * TEXEL) as usize];
                pixels.extend(row.chunks_exact(TEXEL as usize).map(|pixel| {
                    [0, 4, 8, 12].map(|at| {
                        u32::from_le_bytes([pixel[at], pixel[at + 1], pixel[at + 2], pixel[at + 3]])
                    })
                }));
            }
        }
        Ok(JobOutput { buffers, pixels })
    }
}
