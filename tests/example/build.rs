//! The mirrors of the shaders, made anew whenever a shader or an include changes.

fn main() -> Result<(), landfall::BuildError> {
    landfall::Build::new()
        .shader("shaders/lights.frag")
        .shader("shaders/particles.comp")
        .include("shaders/include")
        .define("MAX_LIGHTS", "128")
        .mirrors("lights.rs")
        .c_header("lights.h")
        .emit(landfall::codegen::languages::ZIG, "lights.zig")
        .run()
}
