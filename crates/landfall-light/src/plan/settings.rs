//! Constants of a shader for a scene: unused kinds of light compiled out, arrays as long as needed.
//!
//! Set before the shader is compiled, laid out and mirrored; read from a [`Plan`](super::Plan).

use serde::Serialize;

// The numbers of lights that a shader must hold, if each draw uploads its own lights: the loop
// bound and array length of each kind, 0 if it can be left out.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "CompiledObject"))]
pub struct Compiled {
    pub ambient: bool,
    pub directional: u32,
    pub point: u32,
    pub spot: u32,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    pub name: String,
    /// The kind of constant.
    pub place: ConstantKind,
    pub value: Value,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstantKind {
    /// A macro that the text defines only if it is undefined.
    Define,
    /// A specialisation constant, or an override of WGSL.
    Override,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    Has(bool),
    /// The array length; at least one, since no shader language has empty arrays.
    Length(u32),
}

impl Setting {
    /// Returns the value in `-D NAME=` or `-O NAME=`.
    pub fn text(&self) -> String {
        match (self.value, self.place) {
            (Value::Has(has), ConstantKind::Define) => u32::from(has).to_string(),
            (Value::Has(has), ConstantKind::Override) => has.to_string(),
            (Value::Length(length), _) => length.to_string(),
        }
    }
}

impl Compiled {
    /// Returns the settings for a shader's text, inferred from the names of its constants:
    /// `HAS_POINT_LIGHTS`, `MAX_SPOT_LIGHTS`, `POINT_LIGHT_MAX_NUM`. Other names are ignored.
    pub fn settings(&self, text: &str) -> Vec<Setting> {
        let constants = constants(text).into_iter();
        let setting = |(name, place): (&str, ConstantKind)| {
            Some(Setting { name: name.to_string(), place, value: self.value(name)? })
        };
        constants.filter_map(setting).collect()
    }

    fn value(&self, name: &str) -> Option<Value> {
        let lower = name.to_ascii_lowercase();
        // Words of the name, so that `MAX_POINTS` is found and `viewPOINT` is not.
        let words: Vec<&str> = lower.split('_').collect();
        let says = |any: &[&str]| any.iter().any(|word| words.contains(word));
        // `spot` is tested after `point`; a name with both is a constant of point lights.
        // First which lights the name is of, then what it says about them.
        let count = if says(&["directional", "dir", "sun", "suns"]) {
            self.directional
        } else if says(&["point", "points"]) {
            self.point
        } else if says(&["spot", "spots"]) {
            self.spot
        } else if says(&["ambient"]) {
            u32::from(self.ambient)
        } else {
            return None;
        };
        if says(&["has", "use", "uses", "with", "enable"]) {
            Some(Value::Has(count > 0))
        } else if says(&["max", "num", "nr", "count", "slots", "size", "length"]) {
            // An array of length 0 is an error of GLSL and WGSL.
            Some(Value::Length(count.max(1)))
        } else {
            None
        }
    }
}

/// Returns the distinct constants of a text that can be set from outside. The text is only split
/// into words: a constant in a comment is found too, and setting it has no effect.
fn constants(text: &str) -> Vec<(&str, ConstantKind)> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut found: Vec<(&str, ConstantKind)> = Vec::new();
    for line in text.lines() {
        let mut words = line.split(|c| !is_name(c)).filter(|word| !word.is_empty());
        let name = match words.next() {
            Some("ifndef") => words.next().map(|name| (name, ConstantKind::Define)),
            // `layout(constant_id = 0) const bool NAME = true;`
            Some("layout") if words.next() == Some("constant_id") => {
                let name = words.skip_while(|word| *word != "const").nth(2);
                name.map(|name| (name, ConstantKind::Override))
            }
            // `override NAME: bool = true;`, behind `@id(0)` too
            Some("override") => words.next().map(|name| (name, ConstantKind::Override)),
            Some("id") => match words.nth(1) {
                Some("override") => words.next().map(|name| (name, ConstantKind::Override)),
                _ => None,
            },
            _ => None,
        };
        found.extend(name.filter(|(name, _)| !found.iter().any(|(known, _)| known == name)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_found_in_both_languages_and_set_by_their_names() {
        let compiled = Compiled { ambient: false, directional: 0, point: 3, spot: 1 };
        let glsl = "#ifndef POINT_LIGHT_MAX_NUM\n#define POINT_LIGHT_MAX_NUM 128\n#endif\n\
                    layout(constant_id = 1) const bool HAS_DIRECTIONAL_LIGHTS = true;\n\
                    #ifndef GAMMA\n#ifndef USE_SPOT\n#ifndef POINT_LIGHT_MAX_NUM\n";
        let texts = |text: &str| -> Vec<String> {
            let settings = compiled.settings(text).into_iter();
            settings.map(|s| format!("{:?} {}={}", s.place, s.name, s.text())).collect()
        };
        assert_eq!(
            texts(glsl),
            [
                "Define POINT_LIGHT_MAX_NUM=3",
                "Override HAS_DIRECTIONAL_LIGHTS=false",
                "Define USE_SPOT=1"
            ]
        );
        let wgsl = "override MAX_DIRECTIONAL_LIGHTS: u32 = 4;\n@id(3) override has_ambient: bool;\n\
                    const MAX_POINT_LIGHTS = 4;\n";
        assert_eq!(
            texts(wgsl),
            ["Override MAX_DIRECTIONAL_LIGHTS=1", "Override has_ambient=false"]
        );
    }
}
