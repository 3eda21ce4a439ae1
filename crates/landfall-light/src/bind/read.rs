//! Overrides of a scene or a file for the inferred binding.
//!
//! `{"PointLightBlock.data[].pos": "point[].position", "dirLight.direction":
//! "-directional[0].direction", "exposure": 1, "shadowMap": null}`: keys are members by block and
//! path, or loose uniforms, textures and inputs by name; values are quantities, their negatives,
//! numbers, or `null` for zero.

use serde_json::{Map, Value};

use super::{BindError, BindingMap, BoundValue, Member, Quantity, Source};
use landfall_layout::text::edit_distance::suggestion;

/// Returns a map with some of its sources replaced.
///
/// # Errors
/// A key that the shader does not have, an unknown quantity, or a value of another type.
pub fn overridden(
    mut map: BindingMap,
    given: &Map<String, Value>,
) -> Result<BindingMap, BindError> {
    for (key, value) in given {
        let source = source(key, value)?;
        // A key may match several members: a block is a variable for each element of an array of
        // blocks.
        if !put(&mut map, key, &source) {
            return Err(unknown(&map, key));
        }
        let of_fragment = source.quantity().is_some_and(Quantity::is_of_fragment);
        let is_input = map.inputs.iter().any(|input| input.name == *key);
        let constant = matches!(source, Source::Number(_) | Source::Unknown);
        // A value that varies over the surface can only be an input, and an input only such a
        // value or a constant.
        if of_fragment != is_input && !constant {
            let why = match is_input {
                true => format!(
                    "is an input of the fragment shader, but `{source}` does not vary by fragment"
                ),
                false => format!(
                    "is not an input of the fragment shader, and `{source}` varies by fragment"
                ),
            };
            return Err(BindError::Misfit { key: key.clone(), why });
        }
    }
    Ok(map)
}

fn put(map: &mut BindingMap, key: &str, source: &Source) -> bool {
    let mut found = false;
    for member in &mut map.members {
        if member.key() == key || format!("{}.{}", member.name, member.path) == key {
            member.source = source.clone();
            found = true;
        }
    }
    for bound in map.textures.iter_mut().chain(&mut map.inputs) {
        if bound.name == key {
            bound.source = source.clone();
            found = true;
        }
    }
    found || element(map, key, source)
}

/// Adds one element of an array as a member of its own, after that of the pattern.
fn element(map: &mut BindingMap, key: &str, source: &Source) -> bool {
    let pattern = |path: &str| {
        let mut out = String::new();
        let mut depth = false;
        for c in path.chars() {
            // Leaves out what is between brackets: `data[3].pos` has the pattern `data[].pos`.
            depth = (depth || c == '[') && c != ']';
            if !depth || c == '[' {
                out.push(c);
            }
        }
        out
    };
    let wanted = pattern(key);
    let whole = |member: &&Member| wanted != key && member.key() == wanted;
    let Some(member) = map.members.iter().find(whole).cloned() else { return false };
    let path = key.strip_prefix(&format!("{}.", member.name)).unwrap_or(key).to_string();
    // Written after the pattern, as `BlockWriter` sorts arrays first.
    map.members.push(Member { path, source: source.clone(), ..member });
    true
}

fn unknown(map: &BindingMap, key: &str) -> BindError {
    let members = map.members.iter().map(Member::key);
    let bound = map.textures.iter().chain(&map.inputs).map(|BoundValue { name, .. }| name.clone());
    let all: Vec<String> = members.chain(bound).collect();
    let help = suggestion(key, all.iter().map(String::as_str));
    BindError::UnknownTarget { key: key.to_string(), help }
}

fn source(key: &str, value: &Value) -> Result<Source, BindError> {
    let number = |value: &Value| match value {
        Value::Bool(yes) => Some(f64::from(u8::from(*yes))),
        other => other.as_f64(),
    };
    let misfit = || {
        let why = "must be the name of a property of the scene, such as \"camera.position\", a \
                   number, an array of up to four numbers, or null";
        BindError::Misfit { key: key.to_string(), why: why.to_string() }
    };
    match value {
        Value::Null => Ok(Source::Number(vec![0.0])),
        Value::Bool(_) | Value::Number(_) => {
            Ok(Source::Number(vec![number(value).ok_or_else(misfit)?]))
        }
        Value::Array(items) if (1..=4).contains(&items.len()) => {
            let numbers: Option<Vec<f64>> = items.iter().map(number).collect();
            Ok(Source::Number(numbers.ok_or_else(misfit)?))
        }
        Value::String(word) => {
            let (negated, name) = match word.strip_prefix('-') {
                Some(rest) => (true, rest),
                None => (false, word.as_str()),
            };
            let quantity = Quantity::parse(name.trim()).ok_or_else(|| {
                let names = Quantity::names();
                let help = suggestion(name, names.iter().map(String::as_str));
                BindError::UnknownQuantity { key: key.to_string(), word: word.clone(), help }
            })?;
            Ok(Source::Scene { quantity, negated })
        }
        Value::Array(_) | Value::Object(_) => Err(misfit()),
    }
}
