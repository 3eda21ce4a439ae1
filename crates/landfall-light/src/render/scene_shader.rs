//! The shader that a scene names, and how it is read.

use serde_json::{Map, Value};

use crate::{FrameOptions, Scene, VertexNormals};
use landfall_layout::Error;

/// The keys of a scene's `shader` object.
const KEYS: [&str; 4] = ["path", "entry", "define", "normals"];

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneShader {
    /// Its path, from the scene's directory.
    pub path: Option<String>,
    pub entry: Option<String>,
    pub defines: Vec<(String, String)>,
    /// What its vertex shader does to normals.
    pub frame: FrameOptions,
}

impl SceneShader {
    /// Reads the `shader` of a scene; `about` is the scene's path in messages.
    ///
    /// # Errors
    /// An unknown key, or a value of another type.
    pub fn new(scene: &Scene, about: &str) -> Result<SceneShader, Error> {
        match &scene.shader {
            Some(Value::String(name)) => {
                Ok(SceneShader { path: Some(name.clone()), ..SceneShader::default() })
            }
            Some(Value::Object(map)) => of_object(map, about),
            Some(_) | None => Ok(SceneShader::default()),
        }
    }
}

fn of_object(map: &Map<String, Value>, about: &str) -> Result<SceneShader, Error> {
    let wrong = |what: String| Error::new(about, what);
    if let Some(key) = map.keys().find(|key| !KEYS.contains(&key.as_str())) {
        let all = KEYS.map(|name| format!("`{name}`")).join(", ");
        return Err(wrong(format!("has the unknown key `shader.{key}`; the keys are {all}")));
    }
    let text = |key: &str| match map.get(key) {
        None => Ok(None),
        Some(Value::String(text)) => Ok(Some(text.clone())),
        Some(_) => Err(wrong(format!("has a `shader.{key}` that is not a string"))),
    };
    let entry = text("entry")?;
    let normals = match text("normals")?.as_deref() {
        None | Some("transformed") => VertexNormals::Transformed,
        Some("unit") => VertexNormals::Unit,
        Some("unit_of_four") => VertexNormals::UnitOfFour,
        Some(other) => {
            let known = "`transformed` (of any length), `unit` (normalised) and `unit_of_four` \
                         (normalised as a `vec4`, a mistake found in published shaders)";
            return Err(wrong(format!(
                "has the unknown `shader.normals` of `{other}`; the values are {known}"
            )));
        }
    };
    let mut defines = Vec::new();
    match map.get("define") {
        None => {}
        Some(Value::Object(given)) => {
            for (name, value) in given {
                let value = match value {
                    Value::String(text) => text.clone(),
                    other => other.to_string(),
                };
                // The last one first, as `render` reads them.
                defines.insert(0, (name.clone(), value));
            }
        }
        Some(_) => return Err(wrong("has a `shader.define` that is not an object".to_string())),
    }
    Ok(SceneShader { path: text("path")?, entry, defines, frame: FrameOptions { normals } })
}
