//! Lights a floor by 128 point lights with wgpu, without a window unless `--window` asks for one
//! (`cargo run -p wgpu_lights --features window -- --window`).
//!
//! The uniform buffer is the bytes of the mirror that `build.rs` generates. One compute pass
//! copies the lights that the shader reads into a buffer, a second one lights 64 points; the
//! program fails if a member that comes back is not the one that was written.

/// The generated mirrors: `Lights` and `PointLight`, and a module of offsets for each; and the
/// bindings of the two programs that the shader's entry points make.
mod gpu {
    include!(concat!(env!("OUT_DIR"), "/lights.rs"));
}

#[cfg(feature = "window")]
mod window;

use std::error::Error;

use bytemuck::Zeroable as _;
use glam::Vec3;
use gpu::wgpu_bindings::floor;
use wgpu::util::DeviceExt as _;

/// Points of the floor that are lit.
const POINTS: usize = 64;
/// Floats of a light that the shader copies: two `vec4f`.
const FLOATS: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = scene();
    let upload = bytemuck::bytes_of(&scene);
    println!("uniform buffer: {} bytes, {} lights", upload.len(), scene.count);

    let gpu = Gpu::open(&instance(), None)?;
    let (seen, lit) = gpu.run(upload, scene.lights.len())?;
    for (index, (light, seen)) in scene.lights.iter().zip(seen.chunks_exact(FLOATS)).enumerate() {
        let [x, y, z] = light.position.to_array();
        let [r, g, b] = light.color.to_array();
        let written = [x, y, z, light.intensity, r, g, b, light.radius];
        if seen != written {
            return Err(
                format!("light {index}: wrote {written:?}, the shader reads {seen:?}").into()
            );
        }
    }
    println!("read back: {} lights, every member as written", seen.len() / FLOATS);

    let sum: f32 = lit.chunks_exact(4).map(|rgba| rgba[0] + rgba[1] + rgba[2]).sum();
    if !sum.is_finite() || sum <= 0.0 {
        return Err(format!("the floor is lit by {sum}").into());
    }
    println!("floor: {POINTS} points, mean {:.3}", sum / (3 * POINTS) as f32);
    if std::env::args().any(|argument| argument == "--window") { shown(upload) } else { Ok(()) }
}

/// Shows the floor until the window is closed.
#[cfg(feature = "window")]
fn shown(upload: &[u8]) -> Result<(), Box<dyn Error>> {
    window::show(upload)
}

#[cfg(not(feature = "window"))]
fn shown(_: &[u8]) -> Result<(), Box<dyn Error>> {
    Err("`--window` needs the feature `window`: cargo run --features window -- --window".into())
}

/// 128 lights in rows above the floor, no two alike.
fn scene() -> gpu::Lights {
    let mut scene = gpu::Lights::zeroed();
    for (index, light) in scene.lights.iter_mut().enumerate() {
        let i = index as f32;
        *light = gpu::PointLight::new(gpu::PointLightInit {
            position: Vec3::new((index % 64) as f32, 1.0 + i / 128.0, (index / 64) as f32),
            color: Vec3::new(1.0, i / 128.0, 1.0 - i / 128.0),
            intensity: 0.5 + i,
            radius: 4.0 + i / 2.0,
        });
    }
    scene.count = scene.lights.len() as u32;
    scene
}

/// Vulkan, Metal or DX12.
fn instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}

struct Gpu {
    /// Says what a window's surface can show.
    #[cfg(feature = "window")]
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Gpu {
    /// Opens the default adapter, or one that can draw to the surface.
    fn open(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface>,
    ) -> Result<Gpu, Box<dyn Error>> {
        let options =
            wgpu::RequestAdapterOptions { compatible_surface: surface, ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options))?;
        println!("adapter: {}", adapter.get_info().name);
        let opened = adapter.request_device(&wgpu::DeviceDescriptor::default());
        let (device, queue) = pollster::block_on(opened)?;
        Ok(Gpu {
            #[cfg(feature = "window")]
            adapter,
            device,
            queue,
        })
    }

    /// A uniform buffer with these bytes.
    fn uniform(&self, upload: &[u8]) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("lights"),
            contents: upload,
            usage: wgpu::BufferUsages::UNIFORM,
        })
    }

    /// Runs both entry points; returns the lights that the shader reads and the lit points.
    fn run(&self, upload: &[u8], lights: usize) -> Result<(Vec<f32>, Vec<f32>), Box<dyn Error>> {
        let uniform = self.uniform(upload);
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let seen = self.buffer(lights * FLOATS, storage);
        let lit = self.buffer(POINTS * 4, storage);

        let group = floor::Group0 {
            scene: uniform.as_entire_buffer_binding(),
            seen: seen.as_entire_buffer_binding(),
            lit: lit.as_entire_buffer_binding(),
        }
        .bind(&self.device, &floor::Group0::layout(&self.device));

        let mut encoder = self.device.create_command_encoder(&Default::default());
        let size = floor::COPY_LIGHTS_WORKGROUP_SIZE;
        self.dispatch(&mut encoder, floor::COPY_LIGHTS_ENTRY, size, &group, lights);
        let size = floor::LIGHT_FLOOR_WORKGROUP_SIZE;
        self.dispatch(&mut encoder, floor::LIGHT_FLOOR_ENTRY, size, &group, POINTS);
        let copies = [&seen, &lit].map(|buffer| {
            let mapped = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
            let copy = self.buffer(buffer.size() as usize / 4, mapped);
            encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
            copy
        });
        self.queue.submit([encoder.finish()]);

        for copy in &copies {
            copy.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("the buffer maps"));
        }
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        let floats = |copy: &wgpu::Buffer| -> Result<Vec<f32>, Box<dyn Error>> {
            Ok(bytemuck::cast_slice(&copy.get_mapped_range(..)?).to_vec())
        };
        Ok((floats(&copies[0])?, floats(&copies[1])?))
    }

    /// An unfilled buffer of `floats` floats.
    fn buffer(&self, floats: usize, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4 * floats as u64,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Records `entry` for so many invocations.
    fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        entry: &str,
        [width, ..]: [u32; 3],
        group: &wgpu::BindGroup,
        invocations: usize,
    ) {
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&floor::pipeline_layout(&self.device)),
            module: &floor::shader_module(&self.device),
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        });
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(floor::Group0::INDEX, group, &[]);
        pass.dispatch_workgroups((invocations as u32).div_ceil(width), 1, 1);
    }
}
