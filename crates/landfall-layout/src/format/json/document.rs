//! The version and the tool at the start of JSON documents.

use serde::Serialize;

use super::to_lines;
use crate::format::{NAME, SCHEMA_VERSION};

/// The tool's name and version in JSON documents.
#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Tool {
    #[cfg_attr(feature = "schema", schemars(extend("const" = NAME)))]
    name: &'static str,
    version: &'static str,
}

impl Tool {
    /// Landfall, with this crate's version.
    pub const LANDFALL: Tool = Tool { name: NAME, version: env!("CARGO_PKG_VERSION") };
}

// A document: its version and what wrote it stand before its body, whose description it has.
#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct VersionedJson<T> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    #[serde(flatten)]
    body: T,
}

/// Returns a document with this body, and a newline at its end.
#[doc(hidden)]
pub fn document<T: Serialize>(body: T) -> String {
    let document = VersionedJson { schema_version: SCHEMA_VERSION, tool: Tool::LANDFALL, body };
    to_lines(&document) + "\n"
}

/// The schema of a document with a body of this type.
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn document_schema<T: schemars::JsonSchema>(title: &str) -> String {
    crate::schema::text::<VersionedJson<T>>(title)
}
