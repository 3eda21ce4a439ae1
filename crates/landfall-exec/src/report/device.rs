//! The device of a run as reports name it, for people and in JSON.

use std::fmt::Write as _;

use serde::Serialize;

use crate::backend::{BackendKind, Device};

/// Returns the adapter's name as reports for people spell it.
///
/// JSON and lock files keep the name that the interpreter had when they were defined.
pub fn adapter(device: &Device) -> &str {
    if device.backend == BackendKind::Cpu { "interpreter" } else { &device.adapter }
}

/// Returns the adapter, its driver and their version, for people.
pub fn about(device: &Device) -> String {
    let mut text = adapter(device).to_string();
    if !device.driver.is_empty() {
        let _ = write!(text, " · {}", device.driver);
    }
    if !device.version.is_empty() {
        let _ = write!(text, " {}", device.version);
    }
    text
}

/// A requested backend, and its device if available.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JsonBackend<'a> {
    backend: BackendKind,
    /// The adapter's name; `landfall evaluator` is the interpreter of landfall.
    adapter: Option<&'a str>,
    driver: Option<&'a str>,
    version: Option<&'a str>,
    software: Option<bool>,
}

impl<'a> JsonBackend<'a> {
    /// The backend, and the device where it has one.
    pub fn new(backend: BackendKind, device: Option<&'a Device>) -> JsonBackend<'a> {
        JsonBackend {
            backend,
            adapter: device.map(|device| device.adapter.as_str()),
            driver: device.map(|device| device.driver.as_str()),
            version: device.map(|device| device.version.as_str()),
            software: device.map(|device| device.software),
        }
    }
}
