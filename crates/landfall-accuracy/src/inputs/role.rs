//! The role of an input in lighting, guessed from its name, type and path.
//!
//! Used by the scenes of `scene` and the findings of `classify`.

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InputRole {
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

impl InputRole {
    /// Whether it is a cosine that bounds a cone.
    pub fn is_cone(self) -> bool {
        matches!(self, InputRole::InnerCosine | InputRole::OuterCosine | InputRole::ConeCosine)
    }

    pub fn is_attenuation(self) -> bool {
        matches!(
            self,
            InputRole::Constant | InputRole::Linear | InputRole::Quadratic | InputRole::Attenuation
        )
    }

    pub fn is_position(self) -> bool {
        matches!(
            self,
            InputRole::LightPosition | InputRole::FragmentPosition | InputRole::ViewPosition
        )
    }

    pub fn is_direction(self) -> bool {
        use InputRole::*;
        matches!(self, Axis | ToLight | ToView | Normal | Halfway | Reflected)
    }
}

/// Returns the role of an input from its path, the rows of its vector (1 for a scalar) and whether
/// it is an integer.
pub fn role(path: &str, rows: usize, integer: bool) -> InputRole {
    let parts: Vec<Vec<String>> = path.split('.').map(words).collect();
    let Some((last, parents)) = parts.split_last() else { return InputRole::Other };
    let has = |word: &[&str]| last.iter().any(|w| word.contains(&w.as_str()));
    let under = |word: &[&str]| parents.iter().flatten().any(|w| word.contains(&w.as_str()));
    // The name of the structure tells what the member's does not: `pl.position`.
    let light = has(&["light", "lamp", "spot"])
        || under(&["light", "lights", "spot", "point", "lamp", "pl", "flashlight", "sun"]);
    let in_structure = !parents.is_empty();
    if integer {
        let counts = ["count", "num", "number", "nr", "used", "size", "lights"];
        return if has(&counts) { InputRole::Count } else { InputRole::Other };
    }
    match rows {
        3 | 4 => vector(last, light, in_structure, &has),
        1 => scalar(&has, &under, last),
        _ => InputRole::Other,
    }
}

fn vector(
    last: &[String],
    light: bool,
    in_structure: bool,
    has: &dyn Fn(&[&str]) -> bool,
) -> InputRole {
    let one = last.len() == 1;
    let view = has(&["view", "eye", "camera", "cam", "viewer"]);
    let direction = has(&["dir", "direction", "conedir", "axis", "to", "from"]);
    // Colours first, since `diffuse_light` and the like name a light too.
    if has(&["color", "colour", "ambient", "diffuse", "specular", "albedo", "tint", "radiance"]) {
        return InputRole::Color;
    }
    if has(&["attenuation", "att", "atten"]) {
        return InputRole::Attenuation;
    }
    if has(&["normal", "norm", "nrm"]) || one && has(&["n"]) {
        return InputRole::Normal;
    }
    if has(&["half", "halfway"]) || one && has(&["h"]) {
        return InputRole::Halfway;
    }
    if has(&["reflect", "reflected", "refl", "mirror"]) || one && has(&["r"]) {
        return InputRole::Reflected;
    }
    if view && direction || one && has(&["v"]) {
        return InputRole::ToView;
    }
    if view {
        return InputRole::ViewPosition;
    }
    if direction {
        let spot = has(&["spot", "cone", "conedir", "axis"]);
        return if in_structure || spot || !light { InputRole::Axis } else { InputRole::ToLight };
    }
    if one && has(&["l"]) {
        return InputRole::ToLight;
    }
    if has(&["pos", "position", "point", "frag", "vertex", "world", "p", "surface"]) {
        let frag = has(&["frag", "fragment", "vertex", "world", "surface"]);
        return if light && !frag { InputRole::LightPosition } else { InputRole::FragmentPosition };
    }
    InputRole::Other
}

fn scalar(
    has: &dyn Fn(&[&str]) -> bool,
    under: &dyn Fn(&[&str]) -> bool,
    last: &[String],
) -> InputRole {
    let one = last.len() == 1;
    let cone = has(&["cutoff", "cone", "cut"]);
    if has(&["shininess", "shine", "gloss", "glossiness", "power"]) {
        return InputRole::Shininess;
    }
    if has(&["outer"]) {
        return InputRole::OuterCosine;
    }
    if has(&["inner"]) {
        return InputRole::InnerCosine;
    }
    if cone {
        return InputRole::ConeCosine;
    }
    if has(&["constant", "kc"]) || one && has(&["c"]) {
        return InputRole::Constant;
    }
    if has(&["linear", "kl"]) {
        return InputRole::Linear;
    }
    if has(&["quadratic", "quad", "kq"]) || has(&["exponent"]) && under(&["att", "attenuation"]) {
        return InputRole::Quadratic;
    }
    if has(&["exponent"]) {
        return InputRole::Shininess;
    }
    if has(&["intensity", "strength", "energy", "reflectance", "gain"]) {
        return InputRole::Intensity;
    }
    if has(&["distance", "dist", "radius", "range"]) || one && has(&["d"]) {
        return InputRole::Distance;
    }
    if has(&["cos", "theta", "cosine", "ndotl", "ndoth", "vdotr", "facing", "nl"]) {
        return InputRole::Cosine;
    }
    InputRole::Other
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
            ("light.position", 3, InputRole::LightPosition),
            ("spotLight.pl.position", 3, InputRole::LightPosition),
            ("data[3].pos", 3, InputRole::FragmentPosition),
            ("lights.data[3].pos", 3, InputRole::LightPosition),
            ("fragPos", 3, InputRole::FragmentPosition),
            ("v_frag_pos", 3, InputRole::FragmentPosition),
            ("u_view_pos", 3, InputRole::ViewPosition),
            ("viewDir", 3, InputRole::ToView),
            ("lightDir", 3, InputRole::ToLight),
            ("light.direction", 3, InputRole::Axis),
            ("light.conedir", 3, InputRole::Axis),
            ("v_normal", 3, InputRole::Normal),
            ("light.cutOff", 1, InputRole::ConeCosine),
            ("light.outerCutOff", 1, InputRole::OuterCosine),
            ("light.att.exponent", 1, InputRole::Quadratic),
            ("u_specular_highlight_shininess", 1, InputRole::Shininess),
            ("material.diffuse", 4, InputRole::Color),
        ] {
            assert_eq!(role(path, rows, false), wanted, "{path}");
        }
        assert_eq!(role("actually_used_count", 1, true), InputRole::Count);
    }
}
