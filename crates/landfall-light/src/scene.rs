//! Scenes: a camera, lights, materials and objects.
//!
//! Read from JSON by [`read()`], with meshes by formula or from OBJ files and optional random
//! lights; [`frame`](super::frame) rasterises it, [`upload`](super::upload) converts it for
//! shaders. Lengths are in the scene's own unit, colours linear with full scale 1, directions those
//! in which light travels.

mod generate;
mod mesh;
mod obj;
mod read;
#[cfg(feature = "schema")]
mod schema;

use glam::DVec3;
use landfall_layout::named;
use serde_json::{Map, Value};

pub use generate::{Generate, RandomCubes, RandomLights, generate};
pub use mesh::{cube, plane, sphere};
pub use obj::{MAX_TRIANGLES, ObjFault, ObjMesh, read_obj};
pub use read::{FileOpener, MAX_PIXELS, Reading, read, read_file};
#[cfg(feature = "schema")]
pub use schema::schema;

/// The largest coordinate or length: squares of larger ones overflow an `f32`.
const LARGEST: f64 = landfall_ir::analysis::hazard::threshold::COORDINATE.value;

#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub name: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The colour of pixels without a fragment.
    pub background: DVec3,
    pub camera: Camera,
    pub lights: Lights,
    pub materials: Vec<Material>,
    pub objects: Vec<Object>,
    /// The space in which lighting is computed.
    pub space: Space,
    /// The shader in the scene's JSON: a path relative to the scene's directory, or an object for
    /// the renderer.
    pub shader: Option<Value>,
    /// The lighting model of the reference, in the scene's JSON.
    pub model: Option<Value>,
    /// The sources of the shader's members, in the scene's JSON.
    pub bind: Option<Map<String, Value>>,
}

/// The space of the positions and directions that a shader gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename_all = "kebab-case"))]
pub enum Space {
    #[default]
    /// The scene's own space.
    World,
    /// The camera is at the origin, looking along -z, y up.
    View,
    /// The scene's axes with the camera at the origin: exact far from the scene's origin.
    CameraRelative,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    pub position: DVec3,
    /// The viewing direction, a unit vector.
    pub front: DVec3,
    /// The up direction; not parallel to `front`.
    pub up: DVec3,
    /// The vertical field of view in degrees.
    pub fov: f64,
    pub near: f64,
    pub far: f64,
}

#[derive(Clone, Debug, PartialEq, Default)]
pub struct Lights {
    pub ambient: Option<Ambient>,
    pub directional: Vec<DirectionalLight>,
    pub point: Vec<PointLight>,
    pub spot: Vec<SpotLight>,
}

named! {
    /// The kinds of lights that a scene may have several of, in the order of the sum.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum Kind {
        Directional = "directional",
        Point = "point",
        Spot = "spot",
    }

    const ALL;
    fn from_name;
}

impl Lights {
    /// Returns the number of lights of each kind.
    pub fn counts(&self) -> [usize; 3] {
        [self.directional.len(), self.point.len(), self.spot.len()]
    }

    /// Leaves that many lights of each kind.
    pub fn truncate(&mut self, [directional, point, spot]: [usize; 3]) {
        self.directional.truncate(directional);
        self.point.truncate(point);
        self.spot.truncate(spot);
    }

    /// Returns a light without its cone; `None` for one without a position.
    pub fn positioned(&self, kind: Kind, number: usize) -> Option<&PointLight> {
        match kind {
            Kind::Directional => None,
            Kind::Point => Some(&self.point[number]),
            Kind::Spot => Some(&self.spot[number].point),
        }
    }

    pub fn emission(&self, kind: Kind, number: usize) -> &Emission {
        match self.positioned(kind, number) {
            Some(point) => &point.emission,
            None => &self.directional[number].emission,
        }
    }
}

impl Camera {
    /// Returns the rotation from the scene's axes to the camera's: x right, y up, -z ahead.
    pub fn rotation(&self) -> glam::DMat3 {
        // The columns are the camera's axes in the scene; the transpose of a rotation is its
        // inverse.
        let front = self.front.normalize();
        let right = front.cross(self.up).normalize();
        glam::DMat3::from_cols(right, right.cross(front), -front).transpose()
    }
}

/// The axes of a lighting space in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    pub origin: DVec3,
    /// The rotation from the scene's axes.
    pub turn: glam::DMat3,
}

impl Space {
    pub fn axes(self, camera: &Camera) -> Axes {
        match self {
            Space::World => Axes { origin: DVec3::ZERO, turn: glam::DMat3::IDENTITY },
            Space::View => Axes { origin: camera.position, turn: camera.rotation() },
            Space::CameraRelative => Axes { origin: camera.position, turn: glam::DMat3::IDENTITY },
        }
    }
}

impl Axes {
    /// Converts a point of the scene to this space. The origin is subtracted first, which is exact
    /// far from the scene's origin.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.turn * (point - self.origin)
    }

    /// Converts a direction of the scene to this space, keeping its length.
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.turn * direction
    }

    /// Converts a transform to the scene into one to this space.
    pub fn transform(&self, transform: &glam::DMat4) -> glam::DMat4 {
        let linear = self.turn * glam::DMat3::from_mat4(*transform);
        let place = self.point(transform.w_axis.truncate());
        let mut into = glam::DMat4::from_mat3(linear);
        into.w_axis = place.extend(1.0);
        into
    }
}

/// Ambient light, counted once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    pub color: DVec3,
    /// The factor of the colour.
    pub intensity: f64,
}

/// The emission of a light. Shaders take either a colour for each term, or one colour and an
/// intensity; a scene gives one form and the other is derived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// The colour of its own ambient term, counted once for each light.
    pub ambient: DVec3,
    pub diffuse: DVec3,
    pub specular: DVec3,
    /// The single colour.
    pub color: DVec3,
    /// The factor of the single colour.
    pub intensity: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    /// The direction of travel: a unit vector in `f64`, or the scene's vector if it turns
    /// normalisation off.
    pub direction: DVec3,
    pub emission: Emission,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    pub position: DVec3,
    pub emission: Emission,
    pub attenuation: Attenuation,
}

/// `1 / (constant + linear d + quadratic d^2)`, with a window if there is a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    pub constant: f64,
    pub linear: f64,
    pub quadratic: f64,
    /// The range, where windowed models end the light by `(1 - (d / range)^4)^2`; others ignore it.
    pub range: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    pub point: PointLight,
    pub direction: DVec3,
    pub cone: Cone,
}

/// A cone by its half angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// The cosine of the angle up to which the light has full intensity; not below `outer_cos`.
    pub inner_cos: f64,
    /// The cosine of the angle beyond which there is no light.
    pub outer_cos: f64,
    /// Both angles in degrees, inner first, if the scene gives angles.
    pub degrees: Option<[f64; 2]>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name by which objects refer to it.
    pub name: String,
    pub ambient: Surface,
    pub diffuse: Surface,
    pub specular: Surface,
    /// The exponent of the highlight.
    pub shininess: f64,
    /// The factor or gate of the highlight in some models.
    pub reflectance: f64,
}

/// A colour over a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// The same colour everywhere.
    Constant(DVec3),
    /// An image of 8 bits per channel, nearest texel, repeating.
    Texture(Texture),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The texels in a row.
    pub width: u32,
    /// The rows.
    pub height: u32,
    /// Red, green and blue; `width * height` of them.
    pub texels: Vec<[u8; 3]>,
    /// Whether the bytes are sRGB codes; else linear.
    pub srgb: bool,
}

/// A mesh with a material and a transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    pub mesh: Mesh,
    pub material: usize,
    /// The transform from the mesh's space to the scene's.
    pub transform: glam::DMat4,
}

/// Triangles with positions, normals and texture coordinates at their corners.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Mesh {
    pub vertices: Vec<Vertex>,
    /// Three corners for each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    pub position: DVec3,
    /// The normal, not necessarily of unit length.
    pub normal: DVec3,
    pub uv: glam::DVec2,
}
