//! Generates `lights.rs` into `OUT_DIR`: the mirrors of the shader's structures, and what wgpu needs
//! to know of the shader.

use landfall::codegen::rust::{Api, Sources};

fn main() -> Result<(), landfall::BuildError> {
    landfall::Build::new()
        .shader("shaders/lights.wgsl")
        .bindings(Api::Wgpu)
        // A bind group of each has what its own entry points use.
        .program("floor", &["lights.wgsl:copy_lights", "lights.wgsl:light_floor"])
        .program("window", &["lights.wgsl:corner", "lights.wgsl:shade"])
        .sources(Sources::Embedded)
        .mirrors("lights.rs")
        .run()
}
