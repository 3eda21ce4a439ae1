//! A picture drawn by the OpenGL driver with a pair of shaders, old or ported:
//! loose uniforms set by name, blocks filled by landfall's layout, every value
//! made from the name of what it is given to.

#![allow(unsafe_code, reason = "every call into OpenGL is unsafe")]

use ::landfall::shape::{Scalar, ScalarKind};
use ::landfall::{AddressSpace, ArrayLen, BlockLayout, Leaf, Options, Source, Type, layout};
use glow::HasContext as _;

use super::driver::Driver;

const SIZE: i32 = 48;

/// Bits of the picture's components. `renamed` says which names the shaders had before: values
/// go by those.
pub fn draw(driver: &Driver, stages: [&Source; 2], renamed: &[(String, String)]) -> Vec<u32> {
    let gl = driver.gl();
    // SAFETY: the driver's context is current, and everything made here belongs to it.
    unsafe {
        let program = gl.create_program().expect("a program");
        for (source, kind) in stages.iter().zip([glow::VERTEX_SHADER, glow::FRAGMENT_SHADER]) {
            let shader = gl.create_shader(kind).expect("a shader");
            gl.shader_source(shader, &source.text.replace("set = 0, ", ""));
            gl.compile_shader(shader);
            let log = gl.get_shader_info_log(shader);
            assert!(
                gl.get_shader_compile_status(shader),
                "{}: {log}\n{}",
                source.path,
                source.text
            );
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        assert!(gl.get_program_link_status(program), "{}", gl.get_program_info_log(program));
        gl.use_program(Some(program));
        let mut slot = 0;
        for source in stages {
            let shader = layout(source, &Options::default());
            for block in &shader.blocks {
                match block.space {
                    AddressSpace::Default => set_loose(gl, program, block, renamed),
                    _ => fill_block(gl, program, block, &mut slot, renamed),
                }
            }
        }
        textures(gl, program, renamed);
        target(gl);
        triangle(gl, program);
        let mut bytes = vec![0u8; (SIZE * SIZE * 16) as usize];
        let pixels = glow::PixelPackData::Slice(Some(&mut bytes));
        gl.read_pixels(0, 0, SIZE, SIZE, glow::RGBA, glow::FLOAT, pixels);
        assert_eq!(gl.get_error(), glow::NO_ERROR);
        let words = bytes.chunks_exact(4);
        words.map(|b| u32::from_le_bytes(b.try_into().expect("four bytes"))).collect()
    }
}

/// Between 0.1 and 1.1, by name.
fn value(path: &str, component: u64) -> f32 {
    let hash =
        path.bytes().fold(0x811c_9dc5u32, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
    0.1 + ((hash.wrapping_add(component as u32 * 7919)) % 1000) as f32 / 1000.0
}

/// Components of a leaf's element in OpenGL's order: columns, then rows.
fn components(leaf: &Leaf, path: &str) -> (Scalar, u64, u64, Vec<f32>) {
    let (scalar, columns, rows) = match leaf.ty {
        Type::Scalar(scalar) => (scalar, 1, 1),
        Type::Vector { scalar, rows } => (scalar, 1, u64::from(rows)),
        Type::Matrix { scalar, columns, rows } => (scalar, u64::from(columns), u64::from(rows)),
        _ => panic!("no such uniform in the fixtures"),
    };
    let one = |c: u64, r: u64| match scalar.kind {
        // Near the identity: what it turns stays in the picture.
        ScalarKind::Float if columns > 1 => {
            f32::from(u8::from(c == r)) + value(path, c * rows + r) * 0.1 - 0.05
        }
        ScalarKind::Float => value(path, r),
        _ => 1.0 + f32::from(u8::from(value(path, r) > 0.6)),
    };
    let all = (0..columns).flat_map(|c| (0..rows).map(move |r| one(c, r))).collect();
    (scalar, columns, rows, all)
}

/// Every element of a leaf: its path and its offset.
fn elements(leaf: &Leaf) -> Vec<(String, u64)> {
    let mut all = vec![(leaf.path.clone(), leaf.offset.unwrap_or(0))];
    for (level, len) in leaf.dims.iter().enumerate() {
        let ArrayLen::Fixed(count) = len else { panic!("a fixed size") };
        let stride = leaf.strides.get(level).copied().unwrap_or(0);
        let of = |(path, offset): (String, u64)| {
            (0..u64::from(*count))
                .map(move |i| (path.replacen("[]", &format!("[{i}]"), 1), offset + i * stride))
        };
        all = all.into_iter().flat_map(of).collect();
    }
    all
}

unsafe fn set_loose(
    gl: &glow::Context,
    program: glow::Program,
    block: &BlockLayout,
    renamed: &[(String, String)],
) {
    for leaf in &block.leaves {
        for (path, _) in elements(leaf) {
            let (scalar, columns, rows, all) = components(leaf, &first_name(&path, renamed));
            let ints: Vec<i32> = all.iter().map(|v| *v as i32).collect();
            // SAFETY: the program is in use.
            unsafe {
                let at = gl.get_uniform_location(program, &path);
                let at = at.as_ref();
                match (scalar.kind, columns, rows) {
                    (ScalarKind::Float, 1, 1) => gl.uniform_1_f32_slice(at, &all),
                    (ScalarKind::Float, 1, 2) => gl.uniform_2_f32_slice(at, &all),
                    (ScalarKind::Float, 1, 3) => gl.uniform_3_f32_slice(at, &all),
                    (ScalarKind::Float, 1, _) => gl.uniform_4_f32_slice(at, &all),
                    (ScalarKind::Float, 3, 3) => gl.uniform_matrix_3_f32_slice(at, false, &all),
                    (ScalarKind::Float, 4, 4) => gl.uniform_matrix_4_f32_slice(at, false, &all),
                    (_, 1, 1) => gl.uniform_1_i32_slice(at, &ints),
                    _ => panic!("no such uniform in the fixtures"),
                }
            }
        }
    }
}

unsafe fn fill_block(
    gl: &glow::Context,
    program: glow::Program,
    block: &BlockLayout,
    slot: &mut u32,
    renamed: &[(String, String)],
) {
    let mut bytes = vec![0u8; block.size.expect("a block has a size") as usize];
    for leaf in &block.leaves {
        for (path, offset) in elements(leaf) {
            let (scalar, columns, rows, all) = components(leaf, &first_name(&path, renamed));
            for (index, number) in (0u64..).zip(&all) {
                let column = leaf.matrix_stride.unwrap_or(0) * (index / rows);
                assert!(columns == 1 || !leaf.row_major);
                let at = (offset + column + 4 * (index % rows)) as usize;
                let word = match scalar.kind {
                    ScalarKind::Float => number.to_bits(),
                    _ => *number as u32,
                };
                bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            }
        }
    }
    // SAFETY: the program is in use; the buffer is filled before it is bound.
    unsafe {
        let index = gl.get_uniform_block_index(program, &block.name);
        let Some(index) = index else { return };
        let buffer = gl.create_buffer().expect("a buffer");
        gl.bind_buffer(glow::UNIFORM_BUFFER, Some(buffer));
        gl.buffer_data_u8_slice(glow::UNIFORM_BUFFER, &bytes, glow::STATIC_DRAW);
        gl.bind_buffer_base(glow::UNIFORM_BUFFER, *slot, Some(buffer));
        gl.uniform_block_binding(program, index, *slot);
        *slot += 1;
    }
}

/// A texture of its own for every sampler, made from the name it had at first.
unsafe fn textures(gl: &glow::Context, program: glow::Program, renamed: &[(String, String)]) {
    // SAFETY: the program is in use.
    unsafe {
        let mut unit = 0;
        for index in 0..gl.get_program_parameter_i32(program, glow::ACTIVE_UNIFORMS) as u32 {
            let Some(uniform) = gl.get_active_uniform(program, index) else { continue };
            if uniform.utype != glow::SAMPLER_2D {
                continue;
            }
            let base = uniform.name.trim_end_matches("[0]");
            for element in 0..uniform.size {
                let name = if uniform.name.ends_with("[0]") {
                    format!("{base}[{element}]")
                } else {
                    base.to_string()
                };
                let first = first_name(&name, renamed);
                let texels: Vec<u8> =
                    (0..16 * 16 * 4).map(|i| (value(&first, i * 31) * 230.0) as u8).collect();
                gl.active_texture(glow::TEXTURE0 + unit);
                gl.bind_texture(glow::TEXTURE_2D, Some(gl.create_texture().expect("a texture")));
                gl.tex_image_2d(
                    glow::TEXTURE_2D,
                    0,
                    glow::RGBA8 as i32,
                    16,
                    16,
                    0,
                    glow::RGBA,
                    glow::UNSIGNED_BYTE,
                    glow::PixelUnpackData::Slice(Some(&texels)),
                );
                gl.tex_parameter_i32(
                    glow::TEXTURE_2D,
                    glow::TEXTURE_MIN_FILTER,
                    glow::LINEAR as i32,
                );
                let at = gl.get_uniform_location(program, &name);
                gl.uniform_1_i32(at.as_ref(), unit as i32);
                unit += 1;
            }
        }
    }
}

/// `layers_mask[1]` was `layers[1].mask`.
fn first_name(name: &str, renamed: &[(String, String)]) -> String {
    let (base, index) =
        name.split_once('[').map_or((name, String::new()), |(b, i)| (b, format!("[{i}")));
    let Some((old, _)) = renamed.iter().find(|(_, new)| new == base) else {
        return name.to_string();
    };
    match old.split_once('.') {
        Some((variable, fields)) => format!("{variable}{index}.{fields}"),
        None => format!("{old}{index}"),
    }
}

unsafe fn target(gl: &glow::Context) {
    // SAFETY: everything made here belongs to the current context.
    unsafe {
        let buffer = gl.create_renderbuffer().expect("a buffer");
        gl.bind_renderbuffer(glow::RENDERBUFFER, Some(buffer));
        gl.renderbuffer_storage(glow::RENDERBUFFER, glow::RGBA32F, SIZE, SIZE);
        gl.bind_framebuffer(glow::FRAMEBUFFER, Some(gl.create_framebuffer().expect("a target")));
        gl.framebuffer_renderbuffer(
            glow::FRAMEBUFFER,
            glow::COLOR_ATTACHMENT0,
            glow::RENDERBUFFER,
            Some(buffer),
        );
        assert_eq!(gl.check_framebuffer_status(glow::FRAMEBUFFER), glow::FRAMEBUFFER_COMPLETE);
        gl.viewport(0, 0, SIZE, SIZE);
        gl.clear_color(0.0, 0.0, 0.0, 0.0);
        gl.clear(glow::COLOR_BUFFER_BIT);
    }
}

/// A triangle over most of the picture: position, normal and texture coordinates by name.
unsafe fn triangle(gl: &glow::Context, program: glow::Program) {
    const CORNERS: [[f32; 8]; 3] = [
        [-0.9, -0.9, 0.1, 0.2, 0.1, 1.0, 0.0, 0.0],
        [0.9, -0.8, 0.2, -0.3, 0.2, 0.9, 1.0, 0.1],
        [0.0, 0.9, 0.0, 0.1, -0.4, 0.8, 0.4, 1.0],
    ];
    let bytes: Vec<u8> = CORNERS.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    // SAFETY: the vertex buffer holds the three corners the attributes describe.
    unsafe {
        gl.bind_vertex_array(Some(gl.create_vertex_array().expect("an array")));
        gl.bind_buffer(glow::ARRAY_BUFFER, Some(gl.create_buffer().expect("a buffer")));
        gl.buffer_data_u8_slice(glow::ARRAY_BUFFER, &bytes, glow::STATIC_DRAW);
        for (name, size, offset) in [("position", 3, 0), ("normal", 3, 12), ("uv", 2, 24)] {
            if let Some(at) = gl.get_attrib_location(program, name) {
                gl.enable_vertex_attrib_array(at);
                gl.vertex_attrib_pointer_f32(at, size, glow::FLOAT, false, 32, offset);
            }
        }
        gl.draw_arrays(glow::TRIANGLES, 0, 3);
    }
}
