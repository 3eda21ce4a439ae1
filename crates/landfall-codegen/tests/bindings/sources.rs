//! The embedded text of shaders that include files: glslang makes of it what it makes of the files.

use std::fs;
use std::path::Path;
use std::process::Command;

use landfall_codegen::rust::Api;

use crate::{TESTS, generated, scratch};

#[test]
fn embedded_text_with_includes_is_the_same_program() {
    let folder = scratch("sources");
    let path = format!("{TESTS}/shaders/glsl/total.comp");
    let text = generated(std::slice::from_ref(&path), Api::OpenGl);
    let (_, bindings) = text.split_once("pub mod gl_bindings {").expect("bindings");
    let program = folder.join("print.rs");
    let print = "fn main() { print!(\"{}\", gl_bindings::total::source()); }";
    // The module of all bindings is left out with its last brace.
    let bindings = bindings.trim_end().strip_suffix('}').expect("its end");
    fs::write(&program, format!("{print}\npub mod gl_bindings {{{bindings}"))
        .expect("scratch can be written to");
    let binary = folder.join("print");
    let compiled = Command::new("rustc")
        .args(["--edition", "2024", "-Dwarnings", "-Adead_code", "-o"])
        .arg(&binary)
        .arg(&program)
        .output()
        .expect("rustc is part of the toolchain");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let printed = Command::new(&binary).output().expect("it was compiled").stdout;
    let whole = folder.join("whole.comp");
    fs::write(&whole, &printed).expect("scratch can be written to");
    let whole_text = String::from_utf8(printed).expect("UTF-8");
    assert!(!whole_text.contains("GL_GOOGLE_include_directive"), "{whole_text}");
    assert_eq!(whole_text.matches("#include").count(), 1, "{whole_text}");
    assert!(whole_text.contains("\n// #include \"include/missing.glsl\"\n"), "{whole_text}");
    assert!(
        whole_text
            .contains("    return SCALE * value \\\n        * float(count); // \"quoted\" \\ é\n")
    );
    assert_eq!(spirv(Path::new(&path), &folder), spirv(&whole, &folder));
}

/// The SPIR-V that glslang makes of a shader, without names of files.
fn spirv(path: &Path, folder: &Path) -> Vec<u8> {
    let code = folder.join("code.spv");
    let out = Command::new("glslangValidator")
        .args(["-V", "--quiet", "-g0", "-o"])
        .arg(&code)
        .arg(path)
        .output()
        .expect("glslangValidator is installed");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stdout));
    fs::read(&code).expect("glslang wrote it")
}
