//! Generates `lights.rs`, the mirrors of the shader's block, into `OUT_DIR`.

fn main() -> Result<(), landfall::BuildError> {
    landfall::Build::new().shader("shaders/lights.frag").mirrors("lights.rs").run()
}
