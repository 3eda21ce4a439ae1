//! The role of an input in lighting, guessed from its name, type and path.
//!
//! Used by the scenes of `scene` and the findings of `classify`.

/// The role of an input in lighting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Role {
    LightPosition,
    FragmentPosition,
    ViewPosition,
    /// The direction of a light's beam.
    Axis,
    /// The direction from the fragment to the light.
    ToLight,
    /// The direction from the fragment to the eye.
    ToView,
    Normal,
    Halfway,
    Reflected,
    Color,
    Constant,
    Linear,
    Quadratic,
    /// Constant, linear and quadratic coefficient in one vector.
    Attenuation,
    InnerCosine,
    OuterCosine,
    /// The cosine of a cone with a single angle.
    ConeCosine,
    /// The cosine of an angle between two directions.
    Cosine,
    Shininess,
    Intensity,
    Distance,
    Count,
    Other,
}

impl Role {
    /// Whether it is a cosine that bounds a cone.
    pub fn is_cone(self) -> bool {
        matches!(self, Role::InnerCosine | Role::OuterCosine | Role::ConeCosine)
    }

    /// Whether it is an attenuation coefficient.
    pub fn is_attenuation(self) -> bool {
        matches!(self, Role::Constant | Role::Linear | Role::Quadratic | Role::Attenuation)
    }

    /// Whether it is a position.
    pub fn is_position(self) -> bool {
        matches!(self, Role::LightPosition | Role::FragmentPosition | Role::ViewPosition)
    }

    /// Whether it is a direction.
    pub fn is_direction(self) -> bool {
        use Role::*;
        matches!(self, Axis | ToLight | ToView | Normal | Halfway | Reflected)
    }
}

/// Returns the role of an input from its path, the rows of its vector (1 for a scalar) and whether
/// it is an integer.
pub fn role(path: &str, rows: usize, integer: bool) -> Role {
    let parts: Vec<Vec<String>> = path.split('.').map(words).collect();
    let Some((last, parents)) = parts.split_last() else { return Role::Other };
    let has = |word: &[&str]| last.iter().any(|w| word.contains(&w.as_str()));
    let under = |word: &[&str]| parents.iter().flatten().any(|w| word.contains(&w.as_str()));
    let light = has(&["light", "lamp", "spot"])
        || under(&["light", "lights", "spot", "point", "lamp", "pl", "flashlight", "sun"]);
    let in_structure = !parents.is_empty();
    if integer {
        let counts = ["count", "num", "number", "nr", "used", "size", "lights"];
        return if has(&counts) { Role::Count } else { Role::Other };
    }
    match rows {
        3 | 4 => vector(last, light, in_structure, &has),
        1 => scalar(&has, &under, last),
        _ => Role::Other,
    }
}

fn vector(last: &[String], light: bool, in_structure: bool, has: &dyn Fn(&[&str]) -> bool) -> Role {
    let one = last.len() == 1;
    let view = has(&["view", "eye", "camera", "cam", "viewer"]);
    let direction = has(&["dir", "direction", "conedir", "axis", "to", "from"]);
    if has(&["color", "colour", "ambient", "diffuse", "specular", "albedo", "tint", "radiance"]) {
        return Role::Color;
    }
    if has(&["attenuation", "att", "atten"]) {
        return Role::Attenuation;
    }
    if has(&["normal", "norm", "nrm"]) || one && has(&["n"]) {
        return Role::Normal;
    }
    if has(&["half", "halfway"]) || one && has(&["h"]) {
        return Role::Halfway;
    }
    if has(&["reflect", "reflected", "refl", "mirror"]) || one && has(&["r"]) {
        return Role::Reflected;
    }
    if view && direction || one && has(&["v"]) {
        return Role::ToView;
    }
    if view {
        return Role::ViewPosition;
    }
    if direction {
        let spot = has(&["spot", "cone", "conedir", "axis"]);
        return if in_structure || spot || !light { Role::Axis } else { Role::ToLight };
    }
    if one && has(&["l"]) {
        return Role::ToLight;
    }
    if has(&["pos", "position", "point", "frag", "vertex", "world", "p", "surface"]) {
        let frag = has(&["frag", "fragment", "vertex", "world", "surface"]);
        return if light && !frag { Role::LightPosition } else { Role::FragmentPosition };
    }
    Role::Other
}

fn scalar(has: &dyn Fn(&[&str]) -> bool, under: &dyn Fn(&[&str]) -> bool, last: &[String]) -> Role {
    let one = last.len() == 1;
    let cone = has(&["cutoff", "cone", "cut"]);
    if has(&["shininess", "shine", "gloss", "glossiness", "power"]) {
        return Role::Shininess;
    }
    if has(&["outer"]) {
        return Role::OuterCosine;
    }
    if has(&["inner"]) {
        return Role::InnerCosine;
    }
    if cone {
        return Role::ConeCosine;
    }
    if has(&["constant", "kc"]) || one && has(&["c"]) {
        return Role::Constant;
    }
    if has(&["linear", "kl"]) {
        return Role::Linear;
    }
    if has(&["quadratic", "quad", "kq"]) || has(&["exponent"]) && under(&["att", "attenuation"]) {
        return Role::Quadratic;
    }
    if has(&["exponent"]) {
        return Role::Shininess;
    }
    if has(&["intensity", "strength", "energy", "reflectance", "gain"]) {
        return Role::Intensity;
    }
    if has(&["distance", "dist", "radius", "range"]) || one && has(&["d"]) {
        return Role::Distance;
    }
    if has(&["cos", "theta", "cosine", "ndotl", "ndoth", "vdotr", "facing", "nl"]) {
        return Role::Cosine;
    }
    Role::Other
}

/// Splits a name: `u_lightPos[2]` becomes `u`, `light`, `pos`; letters and digits stay together.
fn words(name: &str) -> Vec<String> {
    let name = name.split('[').next().unwrap_or(name);
    let mut all: Vec<String> = Vec::new();
    let mut word = String::new();
    let mut lower = false;
    for c in name.chars() {
        if c == '_' || !c.is_alphanumeric() || c.is_uppercase() && lower {
            all.extend((!word.is_empty()).then(|| std::mem::take(&mut word)));
        }
        if c.is_alphanumeric() {
            word.extend(c.to_lowercase());
        }
        lower = c.is_lowercase() || c.is_ascii_digit();
    }
    all.extend((!word.is_empty()).then_some(word));
    // `cutOff` is one word; prefixes give the storage of a variable, not its role.
    let mut joined: Vec<String> = Vec::new();
    for word in all {
        match joined.last_mut() {
            Some(last) if last == "cut" && word == "off" => *last = "cutoff".to_string(),
            _ => joined.push(word),
        }
    }
    let prefix = ["u", "v", "in", "a", "f", "out", "my"];
    while joined.len() > 1 && prefix.contains(&joined[0].as_str()) {
        joined.remove(0);
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_names_have_their_roles() {
        for (path, rows, wanted) in [
            ("light.position", 3, Role::LightPosition),
            ("spotLight.pl.position", 3, Role::LightPosition),
            ("data[3].pos", 3, Role::FragmentPosition),
            ("lights.data[3].pos", 3, Role::LightPosition),
            ("fragPos", 3, Role::FragmentPosition),
            ("v_frag_pos", 3, Role::FragmentPosition),
            ("u_view_pos", 3, Role::ViewPosition),
            ("viewDir", 3, Role::ToView),
            ("lightDir", 3, Role::ToLight),
            ("light.direction", 3, Role::Axis),
            ("light.conedir", 3, Role::Axis),
            ("v_normal", 3, Role::Normal),
            ("light.cutOff", 1, Role::ConeCosine),
            ("light.outerCutOff", 1, Role::OuterCosine),
            ("light.att.exponent", 1, Role::Quadratic),
            ("u_specular_highlight_shininess", 1, Role::Shininess),
            ("material.diffuse", 4, Role::Color),
        ] {
            assert_eq!(role(path, rows, false), wanted, "{path}");
        }
        assert_eq!(role("actually_used_count", 1, true), Role::Count);
    }
}
