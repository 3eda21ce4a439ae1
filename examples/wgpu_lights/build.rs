//! Generates `lights.rs`, the mirrors of the shader's structures, into `OUT_DIR`.

fn main() -> Result<(), landfall::BuildError> {
    landfall::Build::new().shader("shaders/lights.wgsl").mirrors("lights.rs").run()
}
