//! What a scene is: a camera, lights, materials and objects, as written.
//!
//! Read from JSON by [`read()`], its meshes made by formula or from OBJ files, lamps by seed if it
//! says so; [`frame`](super::frame) makes fragments of it, [`upload`](super::upload) what is
//! uploaded. Lengths are in the scene's own unit, colours linear with 1 full scale,
//! directions those in which light travels.

mod generate;
mod mesh;
mod obj;
mod read;

use glam::DVec3;
use serde_json::{Map, Value};

pub use generate::{Generate, RandomCubes, RandomLights, generate};
pub use mesh::{cube, plane, sphere};
pub use obj::{ObjFault, ObjMesh, read_obj};
pub use read::{MOST_PIXELS, Open, Reading, read, read_file};

/// Largest coordinate or length: the square of what is larger has no `f32`.
const LARGEST: f64 = landfall_ir::analysis::hazard::threshold::COORDINATE.value;

/// A camera, lights, materials and objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// What people call it.
    pub name: String,
    /// Pixels in a row, and rows.
    pub size: [u32; 2],
    /// Colour where nothing is seen.
    pub background: DVec3,
    /// Who looks.
    pub camera: Camera,
    /// What shines.
    pub lights: Lights,
    /// What surfaces are made of.
    pub materials: Vec<Material>,
    /// What is seen.
    pub objects: Vec<Object>,
    /// The space lighting is computed in.
    pub space: Space,
    /// The shader to light it, as the scene says: a path from the scene's folder, or an object
    /// that the renderer reads.
    pub shader: Option<Value>,
    /// The lighting model the reference is to compute, as the scene says.
    pub model: Option<Value>,
    /// Which number of the scene goes to which member of the shader, as the scene says.
    pub bind: Option<Map<String, Value>>,
}

/// The space in which a shader is given positions and directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Space {
    /// The scene's own.
    #[default]
    World,
    /// The camera at the origin, looking along -z, y up.
    View,
    /// The scene's axes with the camera at the origin: exact far from the origin.
    CameraRelative,
}

/// A camera with a perspective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is.
    pub position: DVec3,
    /// Where it looks: a unit vector.
    pub front: DVec3,
    /// What is up; not along `front`.
    pub up: DVec3,
    /// Vertical field of view in degrees.
    pub fov: f64,
    /// Distance of the near plane.
    pub near: f64,
    /// Distance of the far plane.
    pub far: f64,
}

/// The lights of a scene.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Lights {
    /// Light from everywhere.
    pub ambient: Option<Ambient>,
    /// Suns.
    pub directional: Vec<DirectionalLight>,
    /// Lamps.
    pub point: Vec<PointLight>,
    /// Lamps with a cone.
    pub spot: Vec<SpotLight>,
}

impl Camera {
    /// The turn from the scene's axes to the camera's: x right, y up, -z where it looks.
    pub fn turn(&self) -> glam::DMat3 {
        let front = self.front.normalize();
        let right = front.cross(self.up).normalize();
        glam::DMat3::from_cols(right, right.cross(front), -front).transpose()
    }
}

/// Where the axes of a lighting space are in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// Its origin.
    pub origin: DVec3,
    /// The turn from the scene's axes to its own.
    pub turn: glam::DMat3,
}

impl Space {
    /// Its axes, for what that camera sees.
    pub fn axes(self, camera: &Camera) -> Axes {
        match self {
            Space::World => Axes { origin: DVec3::ZERO, turn: glam::DMat3::IDENTITY },
            Space::View => Axes { origin: camera.position, turn: camera.turn() },
            Space::CameraRelative => Axes { origin: camera.position, turn: glam::DMat3::IDENTITY },
        }
    }
}

impl Axes {
    /// Where a point of the scene is in this space. The origin is taken away first, so that
    /// nothing is lost far from it.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.turn * (point - self.origin)
    }

    /// A direction of the scene in this space, as long as it was.
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.turn * direction
    }

    /// A transform into the scene, into this space instead.
    pub fn transform(&self, transform: &glam::DMat4) -> glam::DMat4 {
        let linear = self.turn * glam::DMat3::from_mat4(*transform);
        let place = self.point(transform.w_axis.truncate());
        let mut into = glam::DMat4::from_mat3(linear);
        into.w_axis = place.extend(1.0);
        into
    }
}

/// Light from everywhere, counted once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Its colour.
    pub color: DVec3,
    /// What its colour is multiplied with.
    pub intensity: f64,
}

/// What a light sends out. Shaders take either a colour for each term, or one colour and an
/// intensity; a scene that gives one of them has the other derived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Colour of its own ambient term, counted once a light.
    pub ambient: DVec3,
    /// Colour of the diffuse term.
    pub diffuse: DVec3,
    /// Colour of the specular term.
    pub specular: DVec3,
    /// The one colour.
    pub color: DVec3,
    /// What the one colour is multiplied with.
    pub intensity: f64,
}

/// Light of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    /// Where it travels: a unit vector as far as `f64` goes, or what the scene says if told not
    /// to normalise.
    pub direction: DVec3,
    /// What it sends.
    pub emission: Emission,
}

/// Light from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Where it is.
    pub position: DVec3,
    /// What it sends.
    pub emission: Emission,
    /// How it weakens.
    pub attenuation: Attenuation,
}

/// `1 / (constant + linear d + quadratic d^2)`, with a window where there is a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    /// Per nothing.
    pub constant: f64,
    /// Per distance.
    pub linear: f64,
    /// Per distance squared.
    pub quadratic: f64,
    /// Where a windowed model ends the light, `(1 - (d / range)^4)^2`; other models ignore it.
    pub range: Option<f64>,
}

/// Light from a point, inside a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    /// The lamp.
    pub lamp: PointLight,
    /// Where it points.
    pub direction: DVec3,
    /// How wide it is.
    pub cone: Cone,
}

/// A cone by its half angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Cosine of the angle inside which the light is whole; not below `outer_cos`.
    pub inner_cos: f64,
    /// Cosine of the angle outside which there is none.
    pub outer_cos: f64,
    /// Both angles in degrees, inner first, where the scene gave angles.
    pub degrees: Option<[f64; 2]>,
}

/// What a surface is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name objects use.
    pub name: String,
    /// Colour of ambient reflection.
    pub ambient: Surface,
    /// Colour of diffuse reflection.
    pub diffuse: Surface,
    /// Colour of specular reflection.
    pub specular: Surface,
    /// The power of the highlight.
    pub shininess: f64,
    /// What some models multiply or gate the highlight with.
    pub reflectance: f64,
}

/// A colour over a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// The same everywhere.
    Constant(DVec3),
    /// From an image of 8 bits a channel, nearest texel, repeating.
    Texture(Texture),
}

/// A small image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Texels in a row.
    pub width: u32,
    /// Rows, from the first.
    pub height: u32,
    /// Red, green, blue; `width * height` of them.
    pub texels: Vec<[u8; 3]>,
    /// Whether the bytes are sRGB codes; else linear.
    pub srgb: bool,
}

/// A mesh at its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its triangles.
    pub mesh: Mesh,
    /// Number of its material.
    pub material: usize,
    /// From the mesh's space to the scene's.
    pub transform: glam::DMat4,
}

/// Triangles with positions, normals and texture coordinates at their corners.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Mesh {
    /// Corners.
    pub vertices: Vec<Vertex>,
    /// Three corners a triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where it is.
    pub position: DVec3,
    /// Its normal; need not be of unit length.
    pub normal: DVec3,
    /// Texture coordinates.
    pub uv: glam::DVec2,
}
