//! Scenes of lights: read from JSON, rasterised, and moved into the space of their lighting.

mod frame;
mod hostile;
mod keys;
mod made;
mod obj;
mod reading;
mod upload;
mod wrong;

use std::path::{Path, PathBuf};

use landfall_layout::{Diagnostic, Error};
use landfall_light::Scene;
use landfall_light::scene::{Reading, read, read_file};

/// A scene with every kind of thing in it, which is right.
pub const RIGHT: &str = include_str!("../scene/right.json");

/// Reads a scene that names no files.
pub fn read_alone(text: &str) -> Reading {
    read("scene.json", text, &|name| Err(Error::new(name, "cannot be read: there are no files")))
}

/// A scene nothing is wrong with.
pub fn scene(text: &str) -> Scene {
    let reading = read_alone(text);
    let messages: Vec<&String> = reading.diagnostics.iter().map(|found| &found.message).collect();
    reading.scene.unwrap_or_else(|| panic!("{messages:#?}"))
}

/// The scene of that name of the repository.
pub fn of_repository(name: &str) -> Scene {
    let path = folder().join(name).with_extension("json");
    let reading = read_file(&path).expect("the scene is there");
    assert_eq!(reading.diagnostics, Vec::<Diagnostic>::new(), "{name}");
    reading.scene.expect("nothing is wrong with it")
}

/// All scenes of the repository.
pub fn names() -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .expect("the folder is there")
        .map(|entry| entry.expect("it can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .map(|path| path.file_stem().expect("it has a name").to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Where the scenes of the repository are.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/scenes")
}
