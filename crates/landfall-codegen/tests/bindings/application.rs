//! An application that is written as the book describes, of the last two versions of wgpu.

use std::fs;

use landfall_codegen::rust::{Api, WgpuMajor};

use crate::{TESTS, assert_formatted, generated, run, scratch};

#[test]
fn an_application_of_wgpu_30_computes_and_draws_by_its_bindings_alone() {
    runs_the_application(WgpuMajor::V30, 30);
}

#[test]
#[ignore = "compiles an older wgpu: ./tests/run bindings"]
fn an_application_of_wgpu_29_computes_and_draws_by_its_bindings_alone() {
    runs_the_application(WgpuMajor::V29, 29);
}

fn runs_the_application(major: WgpuMajor, number: u32) {
    let folder = scratch(&format!("application{number}"));
    let file = folder.join("scene.rs");
    let text = generated(&[format!("{TESTS}/application/scene.wgsl")], Api::WgpuMajor(major));
    fs::write(&file, text).expect("scratch can be written to");
    assert_formatted(&folder, std::slice::from_ref(&file));
    let (ran, said, errors) = run(&format!("wgpu{number}-application"), &file);
    assert!(ran, "{said}\n{errors}");
    println!("{said}");
    // 10 values for each of 4 invocations and pixels of 3 objects, and 5 of what stays as it was.
    assert!(said.contains(": 125 values right, 0 wrong"), "{said}");
}
