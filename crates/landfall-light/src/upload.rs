//! The numbers of a scene for a shader: in lighting space, rounded to `f32`.
//!
//! Made from a [`Scene`]; the binding map writes it to blocks and the reference computes from it,
//! so that neither is charged with the rounding of the upload.

use glam::DVec3;

use super::scene::{
    Ambient, Attenuation, Axes, Cone, DirectionalLight, Emission, Lights, Material, PointLight,
    Scene, Space, SpotLight, Surface,
};

/// Lights and materials as uploaded: every number is an `f32`, widened.
///
/// Only the angles of a [`Cone`] in degrees stay as in the scene: no shader gets them, and values
/// computed from them instead of from their cosines have a rounding of their own. Directions stay
/// those in which light travels; a shader that needs the opposite gets the negative, which is
/// exact.
#[derive(Clone, Debug, PartialEq)]
pub struct Upload {
    /// The space of its positions and directions.
    pub space: Space,
    /// The position of the camera in that space.
    pub camera: DVec3,
    /// The lights in that space.
    pub lights: Lights,
    pub materials: Vec<Material>,
}

impl Upload {
    /// Converts a scene to the space of its lighting, in `f64`, and rounds once.
    pub fn new(scene: &Scene) -> Upload {
        let axes = scene.space.axes(&scene.camera);
        let lights = &scene.lights;
        Upload {
            space: scene.space,
            camera: rounded(axes.point(scene.camera.position)),
            lights: Lights {
                ambient: lights.ambient.map(ambient),
                directional: lights.directional.iter().map(|l| directional(&axes, l)).collect(),
                point: lights.point.iter().map(|l| point(&axes, l)).collect(),
                spot: lights.spot.iter().map(|l| spot(&axes, l)).collect(),
            },
            materials: scene.materials.iter().map(material).collect(),
        }
    }
}

fn ambient(light: Ambient) -> Ambient {
    Ambient { color: rounded(light.color), intensity: round(light.intensity) }
}

fn directional(axes: &Axes, light: &DirectionalLight) -> DirectionalLight {
    DirectionalLight {
        direction: rounded(axes.direction(light.direction)),
        emission: emission(&light.emission),
    }
}

fn point(axes: &Axes, light: &PointLight) -> PointLight {
    let Attenuation { constant, linear, quadratic, range } = light.attenuation;
    PointLight {
        position: rounded(axes.point(light.position)),
        emission: emission(&light.emission),
        attenuation: Attenuation {
            constant: round(constant),
            linear: round(linear),
            quadratic: round(quadratic),
            range: range.map(round),
        },
    }
}

fn spot(axes: &Axes, light: &SpotLight) -> SpotLight {
    let Cone { inner_cos, outer_cos, degrees } = light.cone;
    SpotLight {
        point: point(axes, &light.point),
        direction: rounded(axes.direction(light.direction)),
        cone: Cone { inner_cos: round(inner_cos), outer_cos: round(outer_cos), degrees },
    }
}

fn emission(emission: &Emission) -> Emission {
    Emission {
        ambient: rounded(emission.ambient),
        diffuse: rounded(emission.diffuse),
        specular: rounded(emission.specular),
        color: rounded(emission.color),
        intensity: round(emission.intensity),
    }
}

fn material(material: &Material) -> Material {
    Material {
        name: material.name.clone(),
        ambient: surface(&material.ambient),
        diffuse: surface(&material.diffuse),
        specular: surface(&material.specular),
        shininess: round(material.shininess),
        reflectance: round(material.reflectance),
    }
}

fn surface(surface: &Surface) -> Surface {
    match surface {
        Surface::Constant(color) => Surface::Constant(rounded(*color)),
        Surface::Texture(texture) => Surface::Texture(texture.clone()),
    }
}

fn rounded(vector: DVec3) -> DVec3 {
    vector.as_vec3().as_dvec3()
}

fn round(number: f64) -> f64 {
    f64::from(number as f32)
}
