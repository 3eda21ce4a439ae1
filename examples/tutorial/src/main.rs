//! Writes the uniform block of the tutorial: standard output is its bytes, made by the generated
//! mirror. `landfall decode` shows them; see `docs/src/tutorial.md`.

/// The generated mirrors: `Lights` and `PointLight`, and a module of offsets for each.
mod gpu {
    include!(concat!(env!("OUT_DIR"), "/lights.rs"));
}

use std::io::{self, Write as _};

use glam::Vec3;

/// Where the lights of the scene are.
const POSITIONS: [Vec3; 4] = [
    Vec3::new(0.7, 0.2, 2.0),
    Vec3::new(2.3, -3.3, -4.0),
    Vec3::new(-4.0, 2.0, -12.0),
    Vec3::new(0.0, 0.0, -3.0),
];

fn main() -> io::Result<()> {
    let light = |position| {
        gpu::PointLight::new(gpu::PointLightInit {
            position,
            ambient: Vec3::splat(0.05),
            diffuse: Vec3::splat(0.8),
            specular: Vec3::splat(1.0),
            constant: 1.0,
            linear: 0.09,
            quadratic: 0.032,
        })
    };
    let lights = gpu::Lights::new(gpu::LightsInit {
        point_lights: POSITIONS.map(light),
        view_pos: Vec3::new(0.0, 0.0, 3.0),
        shininess: 32.0,
    });

    // The buffer of a program: glBufferData(GL_UNIFORM_BUFFER, size, bytes, GL_DYNAMIC_DRAW).
    let bytes = bytemuck::bytes_of(&lights);
    assert_eq!(bytes.len(), gpu::lights::SIZE);
    // One value later: glBufferSubData(GL_UNIFORM_BUFFER, offset, 4, &quadratic).
    assert_eq!(gpu::lights::point_lights_quadratic(3), 308);
    io::stdout().write_all(bytes)
}
