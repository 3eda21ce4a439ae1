//! What is written as JSON, held to its schema.

use jsonschema::Validator;
use serde_json::Value;

/// What validates by the text of a schema, which is one itself.
pub fn validator(schema: &str) -> Validator {
    let schema: Value = serde_json::from_str(schema).expect("a schema is JSON");
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    jsonschema::meta::validate(&schema).expect("a schema is a schema");
    jsonschema::validator_for(&schema).expect("a schema can be used")
}

/// Holds a JSON text to a schema.
pub fn holds(validator: &Validator, text: &str, of: &str) -> Value {
    let value: Value = serde_json::from_str(text).unwrap_or_else(|e| panic!("{of}: {e}\n{text}"));
    let errors: Vec<String> =
        validator.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(errors.is_empty(), "{of}:\n{}\n{text}", errors.join("\n"));
    value
}
