//! Fills a scene of lights through the generated mirrors, and finds every value where the
//! generated tables say the shader reads it.

mod gpu {
    include!(concat!(env!("OUT_DIR"), "/lights.rs"));
    // A module for each shader; their names do not clash here.
    pub use lights_frag::*;
    pub use particles_comp::*;
}

use bytemuck::Zeroable;
use glam::{Mat3, Mat4, Vec3};

/// For the parts of a program that are in Zig.
const IN_ZIG: &str = include_str!(concat!(env!("OUT_DIR"), "/lights.zig"));

fn main() {
    assert!(IN_ZIG.contains("pub const PointLight = extern struct {"));
    let mut lights = gpu::Lights::zeroed();
    for (i, light) in lights.lights.iter_mut().enumerate().take(3) {
        let i = i as f32;
        *light = gpu::PointLight::new(gpu::PointLightInit {
            position: Vec3::new(i, 2.0, 3.0),
            color: Vec3::new(1.0, i, 0.5),
            intensity: 10.0 + i,
            range: 25.0,
        });
    }
    lights.used = 3;
    let bytes = bytemuck::bytes_of(&lights);
    println!("lights: {} bytes", bytes.len());
    assert_eq!(bytes.len(), gpu::lights::SIZE);
    for i in 0..3 {
        let at = gpu::lights::lights_position(i);
        assert_eq!(floats(bytes, at, 3), [i as f32, 2.0, 3.0]);
        assert_eq!(floats(bytes, gpu::lights::lights_color(i), 3), [1.0, i as f32, 0.5]);
        assert_eq!(floats(bytes, gpu::lights::lights_intensity(i), 1), [10.0 + i as f32]);
        println!("lights[{i}].position: bytes {at} to {}", at + 11);
    }
    let by_name = gpu::lights::lookup("lights[2].color").expect("the shader has that member");
    assert_eq!(by_name.offset, gpu::lights::lights_color(2));

    let normals = Mat3::from_cols_array(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
    let camera = gpu::Camera::new(gpu::CameraInit {
        view: Mat4::IDENTITY,
        normals,
        eye: Vec3::new(0.5, 1.5, 2.5),
        fog: true,
        fog_density: [0.1, 0.2, 0.3],
    });
    let bytes = bytemuck::bytes_of(&camera);
    // Columns of a mat3 stand 16 bytes apart in std140, and so do the elements of a float array.
    assert_eq!(floats(bytes, gpu::camera::NORMALS + 16, 3), [4.0, 5.0, 6.0]);
    assert_eq!(floats(bytes, gpu::camera::fog_density(2), 1), [0.3]);
    assert_eq!(bytes[gpu::camera::FOG], 1);
    println!("camera: {} bytes", bytes.len());

    const NEW: gpu::Particle = gpu::Particle::new(gpu::ParticleInit {
        position: Vec3::ONE,
        age: 7.0,
        velocity: Vec3::ZERO,
        flags: 1,
    });
    let particles = [NEW; 5];
    let header = gpu::ParticlesHeader::new(gpu::ParticlesHeaderInit { alive: 5 });
    let mut bytes = vec![0; gpu::ParticlesHeader::size_for(particles.len())];
    header.write_to(&particles, &mut bytes).expect("the buffer has that size");
    println!("particles: {} bytes for {}", bytes.len(), particles.len());
}

/// The floats the shader reads at that byte.
fn floats(bytes: &[u8], at: usize, count: usize) -> Vec<f32> {
    bytes[at..at + 4 * count]
        .chunks_exact(4)
        .map(|word| f32::from_le_bytes(word.try_into().expect("four bytes")))
        .collect()
}
