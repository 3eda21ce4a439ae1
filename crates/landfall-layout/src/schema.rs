//! JSON Schemas of the types that are serialised, and of those that describe an input: the files that `landfall schema` prints.

use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value};

/// Returns the schema (draft 2020-12) of what `T` serialises to.
pub fn text<T: JsonSchema>(title: &str) -> String {
    of::<T>(title, SchemaSettings::draft2020_12().for_serialize())
}

/// Returns the schema (draft 2020-12) of a file that `T` describes: an [`Option`] may be absent.
pub fn text_of_input<T: JsonSchema>(title: &str) -> String {
    of::<T>(title, SchemaSettings::draft2020_12().for_deserialize())
}

fn of<T: JsonSchema>(title: &str, settings: SchemaSettings) -> String {
    let settings = settings.with_transform(RecursiveTransform(strict));
    let mut root = settings.into_generator().into_root_schema_for::<T>();
    root.insert("title".to_string(), title.into());
    serde_json::to_string_pretty(&root).expect("keys are strings") + "\n"
}

/// Takes no key that the type lacks, and null only where the type writes it.
fn strict(schema: &mut Schema) {
    let Some(object) = schema.as_object_mut() else { return };
    // Widths of Rust's numbers.
    object.remove("format");
    if let Some(Value::String(text)) = object.get_mut("description") {
        // Comments are wrapped, descriptions are not.
        *text = text.replace("\n\n", "\0").replace('\n', " ").replace('\0', "\n\n");
    }
    let is_nullable = object
        .get("type")
        .and_then(Value::as_array)
        .is_some_and(|types| types.iter().any(|ty| ty == "null"));
    if let Some(Value::Array(words)) = object.get_mut("enum").filter(|_| is_nullable) {
        words.push(Value::Null);
    }
    for key in ["anyOf", "oneOf"] {
        divide(object, key);
    }
    let required = object.get("required").cloned();
    let is_required = |key: &str| {
        let keys = required.as_ref().and_then(Value::as_array);
        keys.is_some_and(|keys| keys.iter().any(|required| required == key))
    };
    if let Some(Value::Object(properties)) = object.get_mut("properties") {
        // What may be absent is never written as null.
        let optional = properties.iter_mut().filter(|(key, _)| !is_required(key));
        optional.for_each(|(_, property)| without_null(property));
        object.entry("additionalProperties").or_insert(false.into());
    }
}

/// Gives the properties of an object to each of its forms, which then know all keys.
fn divide(object: &mut Map<String, Value>, key: &str) {
    if !object.contains_key("properties") || !object.contains_key(key) {
        return;
    }
    let shared = ["properties", "required"].map(|key| (key, object.remove(key)));
    let forms = object.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten();
    for form in forms.filter_map(Value::as_object_mut) {
        for (key, shared) in &shared {
            match (form.get_mut(*key), shared) {
                (Some(Value::Object(own)), Some(Value::Object(shared))) => {
                    own.extend(shared.clone());
                }
                (Some(Value::Array(own)), Some(Value::Array(shared))) => {
                    own.splice(0..0, shared.clone());
                }
                (None, Some(shared)) => _ = form.insert((*key).to_string(), shared.clone()),
                _ => {}
            }
        }
    }
}

fn without_null(property: &mut Value) {
    let Some(object) = property.as_object_mut() else { return };
    if let Some(Value::Array(types)) = object.get_mut("type") {
        types.retain(|ty| ty != "null");
        if let [ty] = &types[..] {
            let ty = ty.clone();
            object.insert("type".to_string(), ty);
        }
    }
    if let Some(Value::Array(words)) = object.get_mut("enum") {
        words.retain(|word| !word.is_null());
    }
    if let Some(Value::Array(forms)) = object.get_mut("anyOf") {
        forms.retain(|form| form["type"] != "null");
        if let [Value::Object(form)] = &forms[..] {
            let form = form.clone();
            object.remove("anyOf");
            object.extend(form);
        }
    }
}
