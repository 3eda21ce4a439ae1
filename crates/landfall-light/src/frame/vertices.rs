//! The corners of a scene's triangles, in camera and lighting space.

use glam::{DMat3, DMat4, DVec2, DVec3};

use super::VertexNormals;
use crate::Scene;
use crate::scene::Space;

/// All corners of a scene, object by object.
pub(super) struct Corners {
    /// The positions in camera space: x right, y up, -z ahead.
    pub seen: Vec<DVec3>,
    pub lit: Vec<VertexAttributes>,
    /// The first corner of each object.
    pub first: Vec<usize>,
}

/// The attributes of a corner, in lighting space.
#[derive(Clone, Copy)]
pub(super) struct VertexAttributes {
    pub position: DVec3,
    pub normal: DVec3,
    pub uv: DVec2,
}

impl Corners {
    pub fn new(scene: &Scene, normals: VertexNormals) -> Corners {
        // Positions in camera space for the rasteriser, attributes in the space that the scene
        // lights in.
        let view = Space::View.axes(&scene.camera);
        let lighting = scene.space.axes(&scene.camera);
        let mut corners = Corners { seen: Vec::new(), lit: Vec::new(), first: Vec::new() };
        for object in &scene.objects {
            corners.first.push(corners.seen.len());
            let seen = view.transform(&object.transform);
            let lit = lighting.transform(&object.transform);
            let turned = Turned::new(&lit, normals);
            for vertex in &object.mesh.vertices {
                corners.seen.push(seen.transform_point3(vertex.position));
                corners.lit.push(VertexAttributes {
                    position: lit.transform_point3(vertex.position),
                    normal: turned.normal(vertex.normal),
                    uv: vertex.uv,
                });
            }
        }
        corners
    }
}

/// The transform of an object's normals.
struct Turned {
    linear: DMat3,
    /// The coefficients of the fourth component, for the variant that uses it.
    fourth: DVec3,
    normals: VertexNormals,
}

impl Turned {
    fn new(transform: &DMat4, normals: VertexNormals) -> Turned {
        // Normals are transformed by the inverse transpose, which keeps them perpendicular under
        // any scale.
        let inverse = DMat3::from_mat4(*transform).inverse();
        // The last row of the transposed inverse, from the inverse translation.
        let fourth = -(inverse * transform.w_axis.truncate());
        Turned { linear: inverse.transpose(), fourth, normals }
    }

    fn normal(&self, normal: DVec3) -> DVec3 {
        let turned = self.linear * normal;
        match self.normals {
            VertexNormals::Transformed => turned,
            VertexNormals::Unit => turned.normalize_or_zero(),
            VertexNormals::UnitOfFour => {
                let four = turned.extend(self.fourth.dot(normal));
                // The published bug: normalised with four components, of which three are used.
                four.normalize_or_zero().truncate()
            }
        }
    }
}
