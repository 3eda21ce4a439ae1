//! An application that is written as the book describes, by the generated file alone: it clears a buffer,
//! sums lights and draws, each with a pipeline of its own, and compares every value with what the same
//! formulas give here. Prints the numbers of right and wrong values.

#![deny(warnings)]

/// The mirrors and bindings of `application/scene.wgsl`.
mod gpu {
    #![allow(dead_code)]
    include!(env!("LANDFALL_GENERATED"));
}

use bytemuck::Zeroable as _;
use gpu::wgpu_bindings::{scene_clear, scene_shade, scene_sum};
use wgpu::*;

const OBJECTS: u64 = 3;
/// Pixels in a row, of 16 bytes each, so that a row has 256.
const WIDTH: u32 = 16;

fn main() {
    #[cfg(feature = "v29")]
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    #[cfg(feature = "v30")]
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&RequestAdapterOptions::default()));
    let adapter = adapter.expect("an adapter");
    let (device, queue) =
        pollster::block_on(adapter.request_device(&DeviceDescriptor::default())).expect("a device");

    let mut view = [[0.0; 4]; 4];
    for (i, column) in view.iter_mut().enumerate() {
        column[i] = 1.0;
    }
    let camera = gpu::Viewer::new(gpu::ViewerInit { view, eye: [1.0, 2.0, 3.0], exposure: 0.5 });
    let lights: Vec<gpu::Light> = (0..5)
        .map(|i| {
            let i = i as f32;
            gpu::Light::new(gpu::LightInit {
                position: [i, 0.5, 0.25],
                reach: 2.0 + i,
                color: [1.0, i, 3.0],
            })
        })
        .collect();
    let mut header = gpu::LightsHeader::zeroed();
    header.count = lights.len() as u32;
    let object = |id: u32| {
        let of = id as f32;
        gpu::Object::new(gpu::ObjectInit {
            tint: [of, of * 2.0, 0.5],
            weights: [[0.0, of + 4.0, 0.0, 0.0], [0.0, 0.0, of * 8.0, 0.0]],
            id,
        })
    };

    let buffer = |size: u64, usage: BufferUsages| {
        device.create_buffer(&BufferDescriptor {
            label: None,
            size,
            usage: usage | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let camera_buffer = buffer(size_of_val(&camera) as u64, BufferUsages::UNIFORM);
    queue.write_buffer(&camera_buffer, 0, bytemuck::bytes_of(&camera));
    let tail = header.to_bytes(&lights);
    let lights_buffer = buffer(tail.len() as u64, BufferUsages::STORAGE);
    queue.write_buffer(&lights_buffer, 0, &tail);
    let stride = scene_sum::Group2::OBJECT_SLOT_STRIDE;
    let objects = buffer(OBJECTS * stride, BufferUsages::UNIFORM);
    for id in 0..OBJECTS {
        queue.write_buffer(&objects, id * stride, bytemuck::bytes_of(&object(id as u32)));
    }
    let count = OBJECTS * 4 + 1;
    let outcomes_size = count * size_of::<gpu::Outcome>() as u64;
    let outcomes = buffer(outcomes_size, BufferUsages::STORAGE | BufferUsages::COPY_SRC);

    let clear = scene_clear::Group2 { words: outcomes.as_entire_buffer_binding() }
        .bind(&device, &scene_clear::Group2::layout(&device));
    let clear_pipeline = scene_clear::clear_pipeline(
        &device,
        &scene_clear::shader_module(&device),
        &scene_clear::Constants { scale: None, bias: 0.0 }.entries(),
    );

    let group0 = scene_sum::Group0 { camera: camera_buffer.as_entire_buffer_binding() }
        .bind(&device, &scene_sum::Group0::layout(&device));
    let group1 = scene_sum::Group1 { lights: lights_buffer.as_entire_buffer_binding() }
        .bind(&device, &scene_sum::Group1::layout(&device));
    let group2 = scene_sum::Group2 {
        object: scene_sum::Group2::object_slot(&objects),
        outcomes: outcomes.as_entire_buffer_binding(),
    }
    .bind(&device, &scene_sum::Group2::layout(&device));
    let constants = scene_sum::Constants { scale: Some(4.0), bias: 0.25 }.entries();
    let module = scene_sum::shader_module(&device);
    let sum_pipeline = scene_sum::sum_pipeline(&device, &module, &constants);

    let draw0 = scene_shade::Group0 { camera: camera_buffer.as_entire_buffer_binding() }
        .bind(&device, &scene_shade::Group0::layout(&device));
    let draw2 = scene_shade::Group2 { object: scene_shade::Group2::object_slot(&objects) }
        .bind(&device, &scene_shade::Group2::layout(&device));
    let draw_constants = scene_shade::Constants { scale: None, bias: 0.125 }.entries();
    let draw_module = scene_shade::shader_module(&device);
    let targets = [Some(TextureFormat::Rgba32Float.into())];
    let draw_pipeline = device.create_render_pipeline(&scene_shade::render_pipeline(
        &scene_shade::pipeline_layout(&device),
        scene_shade::corner_vertex_state(&draw_module, &draw_constants),
        Some(scene_shade::shade_fragment_state(&draw_module, &draw_constants, &targets)),
    ));
    let corner = |x: f32, y: f32| scene_shade::CornerVertex {
        place: [x, y],
        value: [0.5, 1.0, 1.5],
        flags: [9, 6],
    };
    let corners = [corner(-1.0, -1.0), corner(3.0, -1.0), corner(-1.0, 3.0)];
    let vertices = buffer(size_of_val(&corners) as u64, BufferUsages::VERTEX);
    queue.write_buffer(&vertices, 0, bytemuck::cast_slice(&corners));
    let extent = Extent3d { width: WIDTH, height: 1, depth_or_array_layers: 1 };
    let picture = device.create_texture(&TextureDescriptor {
        label: None,
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: TextureFormat::Rgba32Float,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
        view_formats: &[],
    });

    let mut commands = device.create_command_encoder(&Default::default());
    {
        let mut pass = commands.begin_compute_pass(&Default::default());
        pass.set_pipeline(&clear_pipeline);
        pass.set_bind_group(scene_clear::Group2::INDEX, &clear, &[]);
        pass.dispatch_workgroups(outcomes_size.div_ceil(64) as u32, 1, 1);
        pass.set_pipeline(&sum_pipeline);
        pass.set_bind_group(scene_sum::Group0::INDEX, &group0, &[]);
        pass.set_bind_group(scene_sum::Group1::INDEX, &group1, &[]);
        for id in 0..OBJECTS {
            pass.set_bind_group(scene_sum::Group2::INDEX, &group2, &[(id * stride) as u32]);
            pass.dispatch_workgroups(4 / scene_sum::SUM_WORKGROUP_SIZE[0], 1, 1);
        }
    }
    {
        let view = picture.create_view(&Default::default());
        let mut pass = commands.begin_render_pass(&RenderPassDescriptor {
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&draw_pipeline);
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.set_bind_group(scene_shade::Group0::INDEX, &draw0, &[]);
        for id in 0..OBJECTS {
            pass.set_scissor_rect(4 * id as u32, 0, 4, 1);
            pass.set_bind_group(scene_shade::Group2::INDEX, &draw2, &[(id * stride) as u32]);
            pass.draw(0..3, 0..1);
        }
    }
    let read = buffer(outcomes_size + 256, BufferUsages::MAP_READ);
    commands.copy_texture_to_buffer(
        picture.as_image_copy(),
        TexelCopyBufferInfo {
            buffer: &read,
            layout: TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(256),
                rows_per_image: None,
            },
        },
        extent,
    );
    commands.copy_buffer_to_buffer(&outcomes, 0, &read, 256, outcomes_size);
    queue.submit([commands.finish()]);
    read.slice(..).map_async(MapMode::Read, |mapped| mapped.expect("it can be mapped"));
    device.poll(PollType::wait_indefinitely()).expect("the device works");
    #[cfg(feature = "v29")]
    let bytes = read.slice(..).get_mapped_range();
    #[cfg(feature = "v30")]
    let bytes = read.slice(..).get_mapped_range().expect("it is mapped");
    let pixels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes[..256]);
    let found: Vec<gpu::Outcome> = bytemuck::pod_collect_to_vec(&bytes[256..]);

    let (mut right, mut wrong) = (0, 0);
    let mut compare = |what: &str, found: &[f32], expected: &[f32]| {
        for (found, expected) in found.iter().zip(expected) {
            match found == expected {
                true => right += 1,
                false => {
                    wrong += 1;
                    println!("{what}: {found} instead of {expected}");
                }
            }
        }
    };
    let mut all = [0.0f32; 3];
    for light in &lights {
        for i in 0..3 {
            all[i] += light.color[i] * light.reach + light.position[i];
        }
    }
    for id in 0..OBJECTS as usize {
        for at in 0..4 {
            let outcome = &found[id * 4 + at];
            let expected = all.map(|sum| sum * (at + 1) as f32);
            compare("sum", &outcome.sum, &expected);
            compare("id", &[outcome.id as f32], &[id as f32]);
            compare("lit", &outcome.lit, &[(id as f32 + 4.0) * 4.0, 3.25]);
            let of = id as f32;
            let expected = [1.125 + of, 2.125 + of * 2.0, 3.625, 3.0 + of * 8.0];
            compare("pixel", &pixels[id * 4 + at], &expected);
        }
    }
    // Nobody wrote the last one after it was cleared.
    compare("cleared", &[found[count as usize - 1].id as f32], &[7.0]);
    compare("background", &pixels[15], &[0.0, 0.0, 0.0, 1.0]);
    println!("{}: {right} values right, {wrong} wrong", adapter.get_info().name);
    std::process::exit(i32::from(wrong > 0));
}
