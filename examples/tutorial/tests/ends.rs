//! The program ends without an error.

#[test]
fn the_program_ends_without_an_error() {
    let out = std::process::Command::new(env!("CARGO_BIN_EXE_tutorial"))
        .output()
        .expect("cargo builds the program");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
}
