//! Where a driver is outside of what is permitted: by backend, version and case, with the
//! reason. One that is mended must be taken from the list.

use landfall_exec::backend::Device;

/// Backend, part of its version, case, and what it does.
const KNOWN: [(&str, &str, &str, &str); 2] = [
    ("gl", "Mesa 22.3.6", "asin", "a polynomial that is 1.8e-4 off; GLSL bounds no asin"),
    ("gl", "Mesa 22.3.6", "mix", "computes a + (b - a) * c, which loses b where a is large"),
];

/// The cases this driver is known to get wrong.
pub fn known_faults(device: &Device) -> Vec<&'static str> {
    let driver = format!("{} {}", device.driver, device.version);
    let listed = KNOWN.iter().filter(|(backend, version, _, _)| {
        device.backend.name() == *backend && driver.contains(version)
    });
    listed.map(|(_, _, case, _)| *case).collect()
}
