//! The device that ran something, as JSON has it.

use serde::Serialize;

use landfall_exec::backend::{BackendKind, Device};

/// A reader and what it ran on.
#[derive(Serialize)]
pub(super) struct JsonDevice<'a> {
    reader: &'a str,
    adapter: &'a str,
    driver: &'a str,
    version: &'a str,
    software: bool,
}

/// A reader that was asked, and what it ran on if it was there.
#[derive(Serialize)]
pub(super) struct JsonAsked<'a> {
    reader: &'a str,
    adapter: Option<&'a str>,
    driver: Option<&'a str>,
    version: Option<&'a str>,
    software: Option<bool>,
}

impl<'a> JsonAsked<'a> {
    pub(super) fn new(reader: BackendKind, device: Option<&'a Device>) -> JsonAsked<'a> {
        JsonAsked {
            reader: reader.name(),
            adapter: device.map(|device| device.adapter.as_str()),
            driver: device.map(|device| device.driver.as_str()),
            version: device.map(|device| device.version.as_str()),
            software: device.map(|device| device.software),
        }
    }
}

impl<'a> From<&'a Device> for JsonDevice<'a> {
    fn from(device: &'a Device) -> JsonDevice<'a> {
        JsonDevice {
            reader: device.reader.name(),
            adapter: &device.adapter,
            driver: &device.driver,
            version: &device.version,
            software: device.software,
        }
    }
}
