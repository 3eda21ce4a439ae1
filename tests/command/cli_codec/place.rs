//! The block of these tests.

use crate::support::command::Place;

pub const LIGHTS: &str = "#version 330 core
struct PointLight { vec3 pos; vec3 color; float intensity, constant, linear, quadratic; };
layout(std140) uniform PointLightBlock {
    PointLight data[128];
    int actually_used_count;
} u_lights;
";

/// A folder with a shader that has this block.
pub fn place(name: &str) -> Place {
    let place = Place::new(&format!("codec-{name}"));
    place.write("a.frag", LIGHTS);
    place
}
