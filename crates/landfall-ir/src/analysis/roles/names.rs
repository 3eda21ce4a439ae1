//! The meaning of names: the role of a member, and whether a structure is a light.
//!
//! Splits names with [`identifier`](crate::analysis::identifier); used by [`roles`](super).

use super::Role;
use crate::analysis::identifier::identifier_words;
use landfall_layout::shape::{ScalarKind, Type};

pub fn role(name: &str, ty: &Type) -> Option<Role> {
    let said = identifier_words(name);
    let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
    // Of the camera, of a texture or of a shadow: not the light's own, whatever else the name
    // says.
    let elsewhere = ["view", "camera", "cam", "eye", "map", "matrix", "space", "texture", "uv"];
    if says(&elsewhere) || says(&["shadow", "index", "pad", "padding", "bias"]) {
        return None;
    }
    let term = || {
        if says(&["ambient", "amb", "ka"]) {
            Some(Role::Ambient)
        } else if says(&["diffuse", "diff", "kd"]) {
            Some(Role::Diffuse)
        } else if says(&["specular", "spec", "ks"]) {
            Some(Role::Specular)
        } else {
            None
        }
    };
    match ty {
        // Vectors of three or four floats; `vec2` holds no position, direction or colour of a
        // light.
        Type::Vector { scalar, rows } if scalar.kind == ScalarKind::Float && *rows >= 3 => {
            if says(&["pos", "position", "positions", "location", "origin", "center", "centre"]) {
                Some(Role::Position)
            } else if says(&["dir", "dirs", "direction", "directions", "axis", "forward"]) {
                Some(Role::Direction)
            } else if says(&["attenuation", "atten", "att", "falloff"]) {
                Some(Role::Attenuation)
            } else if let Some(role) = term() {
                Some(role)
            } else if says(&["color", "colors", "colour", "colours", "col", "rgb", "tint"])
                || says(&["radiance", "emission", "intensity", "la", "ld", "l"])
            {
                Some(Role::Color)
            } else {
                None
            }
        }
        Type::Scalar(scalar) if scalar.kind == ScalarKind::Float => {
            // The coefficients before strengths: `constantFactor`, `linearIntensity`.
            if says(&["range", "radius", "distance", "reach"]) {
                Some(Role::Range)
            } else if says(&["constant", "const", "kc"]) {
                Some(Role::Constant)
            } else if says(&["linear", "lin", "kl"]) {
                Some(Role::Linear)
            } else if says(&["quadratic", "quad", "kq"]) {
                // Before the exponent of a cone: `quadraticExponent`.
                Some(Role::Quadratic)
            } else if says(&["exponent", "exp"]) {
                Some(Role::ConeExponent)
            } else if says(&["outer", "umbra"]) {
                Some(Role::OuterCone)
            } else if says(&["inner", "penumbra"]) {
                Some(Role::InnerCone)
            } else if says(&["cutoff", "cone", "angle", "phi", "theta", "hotspot"]) {
                Some(Role::Cone)
            } else if let Some(role) = term() {
                Some(role)
            } else if says(&["intensity", "strength", "power", "energy", "brightness", "factor"])
                || says(&["lumens", "lumen", "candela", "lux", "flux", "luminance"])
            {
                Some(Role::Intensity)
            } else if says(&["type", "kind"]) {
                Some(Role::Kind)
            } else if says(&["enabled", "enable", "active", "on"]) {
                Some(Role::Enabled)
            } else {
                None
            }
        }
        // Integers and booleans.
        Type::Scalar(_) => {
            if says(&["type", "kind", "mode"]) {
                Some(Role::Kind)
            } else if says(&["enabled", "enable", "active", "on", "visible"]) {
                Some(Role::Enabled)
            } else {
                None
            }
        }
        Type::Vector { .. }
        | Type::Atomic(_)
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => None,
    }
}

pub(super) fn is_light(said: &[String]) -> bool {
    let light = ["light", "lights", "lamp", "lamps", "sun", "spotlight", "sunlight", "flashlight"];
    said.iter().any(|word| light.contains(&word.as_str()))
}

/// Returns whether a name mentions light but does not name a light.
pub(super) fn is_about_something_else(said: &[String]) -> bool {
    let other = [
        "material", "camera", "vertex", "probe", "grid", "cluster", "tile", "map", "shadow",
        "shadows", "cascade", "volume", "surface", "ray", "hit", "result", "lighting",
    ];
    said.iter().any(|word| other.contains(&word.as_str()))
}
