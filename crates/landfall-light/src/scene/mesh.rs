//! Meshes by formula: cube, plane and sphere, each one unit wide around its origin.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::{Mesh, Vertex};

/// Returns a cube of edge 1 around the origin: four corners and the whole texture on every face.
pub fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-0.5, 0.5] {
            let mut normal = DVec3::ZERO;
            normal[axis] = 2.0 * side;
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            // Counter-clockwise seen from outside.
            let around = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
            let first = mesh.vertices.len() as u32;
            for (along_a, along_b) in around {
                let mut position = DVec3::ZERO;
                position[axis] = side;
                position[a] = along_a;
                // On the opposite face the corners go around the other way.
                position[b] = if side > 0.0 { along_b } else { -along_b };
                let uv = cube_uv(axis, position);
                mesh.vertices.push(Vertex { position, normal, uv });
            }
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangles.push([first + 2, first + 3, first]);
        }
    }
    mesh
}

/// Returns the texture coordinates of the cube of common tutorials: v upwards on the sides along z,
/// y along u on those along x.
fn cube_uv(axis: usize, at: DVec3) -> DVec2 {
    match axis {
        0 => dvec2(at.y + 0.5, 0.5 - at.z),
        1 => dvec2(at.x + 0.5, 0.5 - at.z),
        _ => dvec2(at.x + 0.5, at.y + 0.5),
    }
}

/// Returns a horizontal square of edge 1 around the origin, facing up, with the texture repeated
/// along each edge.
pub fn plane(repeat: f64) -> Mesh {
    let corners = [(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)];
    let vertices = corners.map(|(x, z)| Vertex {
        position: dvec3(x, 0.0, z),
        normal: DVec3::Y,
        uv: dvec2(x + 0.5, 0.5 - z) * repeat,
    });
    Mesh { vertices: vertices.to_vec(), triangles: vec![[0, 1, 2], [2, 3, 0]] }
}

/// Returns a sphere of diameter 1 around the origin, of segments around y and rings from pole to
/// pole, with exact normals. At least 3 segments and 2 rings.
pub fn sphere(segments: u32, rings: u32) -> Mesh {
    let (segments, rings) = (segments.max(3), rings.max(2));
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        let down = f64::from(ring) / f64::from(rings);
        let (radius, height) = match ring {
            0 => (0.0, 1.0),
            _ if ring == rings => (0.0, -1.0),
            _ => (PI * down).sin_cos(),
        };
        for segment in 0..=segments {
            let around = f64::from(segment) / f64::from(segments);
            // The two columns of corners at the seam coincide.
            let angle = 2.0 * PI * f64::from(segment % segments) / f64::from(segments);
            let (sin, cos) = angle.sin_cos();
            let normal = dvec3(radius * sin, height, radius * cos);
            let uv = dvec2(around, 1.0 - down);
            mesh.vertices.push(Vertex { position: normal * 0.5, normal, uv });
        }
    }
    let at = |ring: u32, segment: u32| ring * (segments + 1) + segment;
    for ring in 0..rings {
        for segment in 0..segments {
            let (upper, lower) = (at(ring, segment), at(ring + 1, segment));
            // At the poles one edge of each quad has no length, so one of its triangles is left
            // out.
            if ring > 0 {
                mesh.triangles.push([upper, lower, upper + 1]);
            }
            if ring + 1 < rings {
                mesh.triangles.push([upper + 1, lower, lower + 1]);
            }
        }
    }
    mesh
}
