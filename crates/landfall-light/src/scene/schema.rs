//! A scene as it is written: the types of its JSON Schema.
//!
//! [`read`](super::read()) takes the same keys, and tells more of what is wrong than a schema can;
//! `tests/light/scene/keys.rs` holds the two together.

#![expect(dead_code, reason = "only their schema is used")]

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde_json::{Map, Value, json};

use super::Space;
use super::read::ATTENUATIONS;

/// Above the largest `f32` by less than its last digit.
const LARGEST: f64 = 3.402_823_5e38;

/// The schema of a scene.
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text_of_input::<WrittenScene>("A scene of lights")
}

/// The input of `landfall render`: a camera, lights, materials and objects. Lengths are in the
/// scene's own unit, colours are linear with full scale 1, angles in degrees, directions those in
/// which light travels. File names are relative to the scene's directory.
#[derive(JsonSchema)]
struct WrittenScene {
    #[schemars(rename = "$schema")]
    schema: Option<String>,
    /// The name of the scene; by default the file name.
    name: Option<String>,
    description: Option<String>,
    /// Width and height in pixels; at most 2^24 pixels in all.
    #[schemars(inner(range(min = 1, max = 32768)))]
    size: [u32; 2],
    /// The colour of pixels without a fragment; black by default.
    background: Option<WrittenColor>,
    /// The space in which lighting is computed: the scene's own, the camera's, or the scene's axes
    /// with the camera at the origin.
    #[schemars(extend("default" = "world"))]
    space: Option<Space>,
    camera: WrittenCamera,
    lights: Option<WrittenLights>,
    materials: Option<Vec<WrittenMaterial>>,
    objects: Option<Vec<WrittenObject>>,
    generate: Option<WrittenGenerate>,
    /// The shader: a path, or an object for the renderer.
    shader: Option<TextOrObject>,
    /// The lighting model of the reference: a name, or an object.
    model: Option<TextOrObject>,
    /// The sources of the shader's members.
    bind: Option<Map<String, Value>>,
}

#[derive(JsonSchema)]
#[schemars(untagged)]
enum TextOrObject {
    Text(String),
    Object(Map<String, Value>),
}

/// A number in the range of a 32-bit float.
#[derive(JsonSchema)]
#[schemars(extend("minimum" = -LARGEST, "maximum" = LARGEST))]
struct WrittenNumber(f64);

#[derive(JsonSchema)]
#[schemars(extend("exclusiveMinimum" = 0, "maximum" = LARGEST))]
struct WrittenPositive(f64);

#[derive(JsonSchema)]
#[schemars(extend("minimum" = 0, "maximum" = LARGEST))]
struct WrittenIntensity(f64);

#[derive(JsonSchema)]
struct WrittenVector(#[schemars(inner(range(min = -1e18, max = 1e18)))] [f64; 3]);

#[derive(JsonSchema)]
#[schemars(extend("not" = {"const": [0, 0, 0]}))]
struct WrittenDirection(WrittenVector);

/// Red, green and blue, or one number for a grey.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum WrittenColor {
    Grey(WrittenIntensity),
    Channels([WrittenIntensity; 3]),
}

/// A perspective camera.
#[derive(JsonSchema)]
#[schemars(extend("allOf" = [{"oneOf": [{"required": ["front"]}, {"required": ["target"]}]}]))]
struct WrittenCamera {
    position: WrittenVector,
    /// The viewing direction.
    front: Option<WrittenDirection>,
    /// The position to look at, instead of `front`.
    target: Option<WrittenVector>,
    /// The up direction, not parallel to the viewing direction; the y axis by default.
    up: Option<WrittenDirection>,
    /// The vertical field of view in degrees.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    fov: f64,
    /// The distance of the near plane.
    #[schemars(extend("default" = 0.1))]
    near: Option<WrittenPositive>,
    /// The distance of the far plane, beyond the near one.
    #[schemars(extend("default" = 100))]
    far: Option<WrittenPositive>,
}

#[derive(JsonSchema)]
struct WrittenLights {
    ambient: Option<WrittenAmbient>,
    directional: Option<Vec<WrittenDirectional>>,
    point: Option<Vec<WrittenPoint>>,
    spot: Option<Vec<WrittenSpot>>,
}

/// Ambient light, counted once.
#[derive(JsonSchema)]
struct WrittenAmbient {
    color: WrittenColor,
    #[schemars(extend("default" = 1))]
    intensity: Option<WrittenIntensity>,
}

#[derive(JsonSchema)]
struct WrittenEmission {
    /// The single colour, for shaders with a colour and an intensity; `diffuse` by default.
    color: Option<WrittenColor>,
    /// The factor of `color`; 1 by default.
    intensity: Option<WrittenIntensity>,
    /// The colour of the light's own ambient term; black by default.
    ambient: Option<WrittenColor>,
    /// The colour of the diffuse term; `color` times `intensity` by default.
    diffuse: Option<WrittenColor>,
    /// The colour of the specular term; as the diffuse term by default.
    specular: Option<WrittenColor>,
}

/// Of each light but the ambient one: it has a colour, and an intensity only beside `color`.
fn emits() -> Value {
    let diffuse = json!({"required": ["diffuse"], "not": {"required": ["intensity"]}});
    json!([{"anyOf": [{"required": ["color"]}, diffuse]}])
}

/// A directional light.
#[derive(JsonSchema)]
#[schemars(extend("allOf" = emits()))]
struct WrittenDirectional {
    /// The direction of travel; normalised.
    direction: WrittenDirection,
    /// false: keep the direction's length as written.
    normalize: Option<bool>,
    #[schemars(flatten)]
    emission: WrittenEmission,
}

/// A point light.
#[derive(JsonSchema)]
#[schemars(extend("allOf" = emits()))]
struct WrittenPoint {
    #[schemars(flatten)]
    lit: WrittenPlace,
}

#[derive(JsonSchema)]
struct WrittenPlace {
    position: WrittenVector,
    /// The attenuation; none by default.
    attenuation: Option<WrittenAttenuation>,
    /// The distance at which the light ends, in lighting models that fade lights out (with a
    /// `window`).
    range: Option<WrittenPositive>,
    #[schemars(flatten)]
    emission: WrittenEmission,
}

/// A spotlight.
#[derive(JsonSchema)]
#[schemars(extend("allOf" = emits()))]
struct WrittenSpot {
    #[schemars(flatten)]
    lit: WrittenPlace,
    /// The direction of the axis; normalised.
    direction: WrittenDirection,
    /// false: keep the direction's length as written.
    normalize: Option<bool>,
    cone: WrittenCone,
}

/// 1 / (constant + linear d + quadratic d^2), or a row of the table that tutorials copy from the
/// Ogre wiki.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum WrittenAttenuation {
    Coefficients(WrittenCoefficients),
    Row { distance: WrittenRow },
}

#[derive(JsonSchema)]
#[schemars(extend("not" = {
    "properties": {"constant": {"const": 0}, "linear": {"const": 0}, "quadratic": {"const": 0}},
    "required": ["constant"],
    "additionalProperties": true,
}))]
struct WrittenCoefficients {
    #[schemars(extend("default" = 1))]
    constant: Option<WrittenIntensity>,
    #[schemars(extend("default" = 0))]
    linear: Option<WrittenIntensity>,
    #[schemars(extend("default" = 0))]
    quadratic: Option<WrittenIntensity>,
}

/// A distance of the table.
#[derive(JsonSchema)]
#[schemars(extend("enum" = ATTENUATIONS.map(|row| row[0] as u32)))]
struct WrittenRow(f64);

/// The half angles of a cone: full intensity inside the inner angle, none outside the outer one.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum WrittenCone {
    Degrees {
        #[schemars(range(min = 0, max = 180))]
        inner_degrees: f64,
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 180))]
        outer_degrees: f64,
    },
    Cosines {
        #[schemars(range(min = -1, max = 1))]
        inner_cos: f64,
        #[schemars(extend("minimum" = -1, "exclusiveMaximum" = 1))]
        outer_cos: f64,
    },
    /// A hard edge.
    Half {
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 180))]
        half_degrees: f64,
    },
}

/// A material.
#[derive(JsonSchema)]
struct WrittenMaterial {
    name: String,
    /// The colour of ambient reflection; as `diffuse` by default.
    ambient: Option<WrittenSurface>,
    /// The colour of diffuse reflection.
    diffuse: WrittenSurface,
    /// The colour of specular reflection; black by default.
    specular: Option<WrittenSurface>,
    /// The exponent of the highlight.
    #[schemars(extend("default" = 32))]
    shininess: Option<WrittenIntensity>,
    /// The factor of the highlight in some lighting models; in others any value above 0 turns the
    /// highlight on.
    #[schemars(extend("default" = 1))]
    reflectance: Option<WrittenIntensity>,
}

#[derive(JsonSchema)]
#[schemars(untagged)]
enum WrittenSurface {
    Color(WrittenColor),
    Texture(WrittenTexture),
}

/// A small image of 8 bits per channel, nearest texel, repeating. Its first row is at texture
/// coordinate 0.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum WrittenTexture {
    /// The two alternating colours.
    Checker {
        checker: [WrittenTexel; 2],
        /// The texels in a row, and the rows.
        #[schemars(range(min = 1, max = 1024), extend("default" = 2))]
        cells: Option<u32>,
        /// Whether the bytes are sRGB codes; else linear.
        #[schemars(extend("default" = false))]
        srgb: Option<bool>,
    },
    /// Rows of letters, each a colour of the palette.
    Rows {
        #[schemars(length(min = 1), inner(length(min = 1)))]
        rows: Vec<String>,
        #[schemars(extend("propertyNames" = {"minLength": 1, "maxLength": 1}))]
        palette: BTreeMap<String, WrittenTexel>,
        /// Whether the bytes are sRGB codes; else linear.
        #[schemars(extend("default" = false))]
        srgb: Option<bool>,
    },
    /// A PNG file, its first row at the top; alpha is dropped.
    Png {
        png: String,
        /// Whether the bytes are sRGB codes; else linear.
        #[schemars(extend("default" = false))]
        srgb: Option<bool>,
    },
}

#[derive(JsonSchema)]
struct WrittenTexel(#[schemars(inner(range(min = 0, max = 255)))] [u8; 3]);

/// A mesh with a transform: scaled, then rotated, then translated.
#[derive(JsonSchema)]
struct WrittenObject {
    name: Option<String>,
    mesh: WrittenMesh,
    /// The name of the material; optional if there is only one.
    material: Option<String>,
    /// The origin by default.
    position: Option<WrittenVector>,
    rotation: Option<WrittenRotation>,
    scale: Option<WrittenScale>,
}

/// Counter-clockwise around an axis that points at the viewer.
#[derive(JsonSchema)]
struct WrittenRotation {
    axis: WrittenDirection,
    degrees: WrittenNumber,
}

/// One factor, or one for each axis; none is 0.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum WrittenScale {
    Factor(#[schemars(range(min = -1e18, max = 1e18), extend("not" = {"const": 0}))] f64),
    Axes(#[schemars(extend("not" = {"contains": {"const": 0}}))] WrittenVector),
}

/// Cube and plane have edges of 1, the sphere a diameter of 1, all around the origin; the plane
/// faces up.
#[derive(JsonSchema)]
#[schemars(untagged)]
enum WrittenMesh {
    Named(NamedMesh),
    Plane {
        plane: WrittenPlane,
    },
    Sphere {
        sphere: WrittenSphere,
    },
    /// A Wavefront OBJ file; faces without normals are flat.
    Obj {
        obj: String,
    },
}

#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
enum NamedMesh {
    Cube,
    Plane,
    Sphere,
}

#[derive(JsonSchema)]
struct WrittenPlane {
    /// The repetitions of the texture along each edge.
    #[schemars(extend("default" = 1))]
    repeat: Option<WrittenPositive>,
}

#[derive(JsonSchema)]
struct WrittenSphere {
    /// The segments around the y axis.
    #[schemars(range(min = 3, max = 1024), extend("default" = 32))]
    segments: Option<u32>,
    /// The rings from pole to pole.
    #[schemars(range(min = 2, max = 1024), extend("default" = 16))]
    rings: Option<u32>,
}

/// Random point lights and cubes over a floor, the same on every machine for a seed.
#[derive(JsonSchema)]
struct WrittenGenerate {
    #[schemars(range(max = u32::MAX))]
    seed: u32,
    /// The edges of the floor along x and z, centred at the origin.
    area: [WrittenPositive; 2],
    lights: Option<WrittenRandomLights>,
    cubes: Option<WrittenCubes>,
    floor: Option<WrittenFloor>,
}

/// Point lights with random colours, each with one of the attenuations.
#[derive(JsonSchema)]
struct WrittenRandomLights {
    #[schemars(range(max = 65536))]
    count: u32,
    /// The lowest and highest height.
    height: [WrittenPositive; 2],
    /// Rows of the table of attenuations.
    #[schemars(length(min = 1))]
    distances: Vec<WrittenRow>,
    /// The factor of every colour.
    #[schemars(extend("default" = 1))]
    gain: Option<WrittenPositive>,
    /// If given, the `range` of each light is where its brightest channel falls to this value.
    window: Option<WrittenPositive>,
    /// Whether the lights are left out, for a scene that lists them in `lights`; the cubes stand as
    /// with them.
    #[schemars(extend("default" = false))]
    omit: Option<bool>,
}

/// Cubes that stand on the floor, randomly rotated.
#[derive(JsonSchema)]
struct WrittenCubes {
    #[schemars(range(max = 65536))]
    count: u32,
    /// The shortest and longest edge.
    edge: [WrittenPositive; 2],
    /// The name of the material; optional if there is only one.
    material: Option<String>,
}

/// A plane over the whole area.
#[derive(JsonSchema)]
struct WrittenFloor {
    /// The name of the material; optional if there is only one.
    material: Option<String>,
}
