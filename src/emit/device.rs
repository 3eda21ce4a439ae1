//! The device that ran something, as JSON has it.

use serde::Serialize;

use crate::run::reader::Device;

/// A reader and what it ran on.
#[derive(Serialize)]
pub(super) struct JsonDevice<'a> {
    reader: &'a str,
    adapter: &'a str,
    driver: &'a str,
    version: &'a str,
    software: bool,
}

impl<'a> From<&'a Device> for JsonDevice<'a> {
    fn from(device: &'a Device) -> JsonDevice<'a> {
        JsonDevice {
            reader: device.reader,
            adapter: &device.adapter,
            driver: &device.driver,
            version: &device.version,
            software: device.software,
        }
    }
}
