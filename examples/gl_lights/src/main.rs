//! Draws with 128 point lights in OpenGL, without a window.
//!
//! The uniform buffer is the bytes of the mirror that `build.rs` generates. The fragment shader
//! draws the lights that it reads into a picture of floats, beside the floor they light; the
//! program fails if a member that comes back is not the one that was written.

/// The generated mirrors: `Lights` and `PointLight`, and a module of offsets for each.
mod gpu {
    include!(concat!(env!("OUT_DIR"), "/lights.rs"));
}

mod context;

use std::error::Error;

use bytemuck::Zeroable as _;
use glam::Vec3;
use glow::HasContext as _;

/// Columns of the picture: one a light.
const WIDTH: usize = 128;
/// Rows: position and intensity, colour and radius, the lit floor.
const HEIGHT: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = scene();
    let upload = bytemuck::bytes_of(&scene);
    println!("uniform buffer: {} bytes, {} lights", upload.len(), scene.count);

    let gl = context::open()?;
    // SAFETY: the context is current on this thread.
    println!("driver: {}", unsafe { gl.get_parameter_string(glow::RENDERER) });
    let pixels = draw(&gl, upload)?;
    let pixel = |column: usize, row: usize| &pixels[4 * (row * WIDTH + column)..][..4];
    for (index, light) in scene.lights.iter().enumerate() {
        let written = [light.position.extend(light.intensity), light.color.extend(light.radius)];
        for (row, written) in written.iter().enumerate() {
            let seen = pixel(index, row);
            if seen != written.to_array() {
                let message = format!("light {index}: wrote {written}, the shader reads {seen:?}");
                return Err(message.into());
            }
        }
    }
    println!("read back: {WIDTH} lights, every member as written");

    let lit = (0..WIDTH).flat_map(|column| &pixel(column, 2)[..3]);
    let mean = lit.sum::<f32>() / (3 * WIDTH) as f32;
    if !mean.is_finite() || mean <= 0.0 {
        return Err(format!("the floor is lit by {mean}").into());
    }
    println!("floor: {WIDTH} points, mean {mean:.3}");
    Ok(())
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
    scene.count = scene.lights.len() as i32;
    scene
}

/// Draws the picture with `upload` in the block `Lights`; returns its floats, row by row.
fn draw(gl: &glow::Context, upload: &[u8]) -> Result<Vec<f32>, Box<dyn Error>> {
    let (width, height) = (WIDTH as i32, HEIGHT as i32);
    let mut pixels = vec![0.0_f32; 4 * WIDTH * HEIGHT];
    // SAFETY: plain calls into the current context; what is read back has the size of the buffer.
    unsafe {
        let program = program(gl)?;
        gl.use_program(Some(program));
        let block = gl.get_uniform_block_index(program, "Lights").ok_or("no block `Lights`")?;
        gl.uniform_block_binding(program, block, 0);
        let buffer = gl.create_buffer()?;
        gl.bind_buffer_base(glow::UNIFORM_BUFFER, 0, Some(buffer));
        gl.buffer_data_u8_slice(glow::UNIFORM_BUFFER, upload, glow::STATIC_DRAW);

        let picture = gl.create_renderbuffer()?;
        gl.bind_renderbuffer(glow::RENDERBUFFER, Some(picture));
        gl.renderbuffer_storage(glow::RENDERBUFFER, glow::RGBA32F, width, height);
        let framebuffer = gl.create_framebuffer()?;
        gl.bind_framebuffer(glow::FRAMEBUFFER, Some(framebuffer));
        let (color, target) = (glow::COLOR_ATTACHMENT0, glow::RENDERBUFFER);
        gl.framebuffer_renderbuffer(glow::FRAMEBUFFER, color, target, Some(picture));
        if gl.check_framebuffer_status(glow::FRAMEBUFFER) != glow::FRAMEBUFFER_COMPLETE {
            return Err("the driver does not draw to floats".into());
        }
        gl.viewport(0, 0, width, height);
        let vertices = gl.create_vertex_array()?;
        gl.bind_vertex_array(Some(vertices));
        gl.draw_arrays(glow::TRIANGLES, 0, 3);
        let to = glow::PixelPackData::Slice(Some(bytemuck::cast_slice_mut(&mut pixels)));
        gl.read_pixels(0, 0, width, height, glow::RGBA, glow::FLOAT, to);
        match gl.get_error() {
            glow::NO_ERROR => {}
            error => return Err(format!("OpenGL error {error:#x}").into()),
        }
    }
    Ok(pixels)
}

/// Compiles and links the two shaders.
///
/// # Safety
/// The context must be current.
unsafe fn program(gl: &glow::Context) -> Result<glow::Program, Box<dyn Error>> {
    let stages = [
        (glow::VERTEX_SHADER, include_str!("../shaders/screen.vert")),
        (glow::FRAGMENT_SHADER, include_str!("../shaders/lights.frag")),
    ];
    // SAFETY: as the caller promises.
    unsafe {
        let program = gl.create_program()?;
        for (stage, text) in stages {
            let shader = gl.create_shader(stage)?;
            gl.shader_source(shader, text);
            gl.compile_shader(shader);
            if !gl.get_shader_compile_status(shader) {
                return Err(gl.get_shader_info_log(shader).into());
            }
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        if !gl.get_program_link_status(program) {
            return Err(gl.get_program_info_log(program).into());
        }
        Ok(program)
    }
}
