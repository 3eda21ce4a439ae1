//! Groups shaders into programs by their file names.

use landfall_layout::ShaderLayout;
use landfall_layout::source::{Language, Stage};

/// The key of a program.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Program {
    directory: String,
    /// The file's name without its stage.
    name: String,
    pipeline: Pipeline,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Pipeline {
    Graphics,
    Compute,
    RayTracing,
}

/// Returns the program of a shader: its directory, and its file name without the stage. `None` for
/// WGSL modules, which contain all stages, and for texts without a stage.
pub(super) fn program(shader: &ShaderLayout) -> Option<Program> {
    if shader.language != Language::Glsl {
        return None;
    }
    let pipeline = match shader.stage? {
        Stage::Vertex
        | Stage::TessellationControl
        | Stage::TessellationEvaluation
        | Stage::Geometry
        | Stage::Fragment
        | Stage::Task
        | Stage::Mesh => Pipeline::Graphics,
        Stage::Compute => Pipeline::Compute,
        Stage::RayGeneration
        | Stage::Intersection
        | Stage::AnyHit
        | Stage::ClosestHit
        | Stage::Miss
        | Stage::Callable => Pipeline::RayTracing,
        _ => return None,
    };
    let (directory, name) = base_name(&shader.path);
    Some(Program { directory, name, pipeline })
}

/// Returns the directory of a file, and its name without stage and extensions.
pub(super) fn base_name(path: &str) -> (String, String) {
    let path = path.replace('\\', "/");
    let (directory, file) = path.rsplit_once('/').unwrap_or(("", &path));
    (directory.to_string(), stem(file))
}

/// Returns a file's name without its extensions and stage names: `lights.vert`, `lights_vs.glsl`,
/// `lights.frag.glsl` and `fs_lights.glsl` are all `lights`.
fn stem(file: &str) -> String {
    let mut parts: Vec<&str> = file.split('.').collect();
    // What is behind the first dot is an extension if it is the last part or says a stage.
    while parts.len() > 1 {
        let last = parts[parts.len() - 1];
        let inner = parts.len() > 2 && is_stage(parts[parts.len() - 2]);
        parts.pop();
        if !inner && !is_stage(last) {
            break;
        }
        if !inner {
            break;
        }
    }
    let name = parts.join(".");
    let words: Vec<&str> = name.split(['_', '-']).filter(|word| !is_stage(word)).collect();
    words.join("_")
}

fn is_stage(word: &str) -> bool {
    Stage::from_name(word).is_some()
        || matches!(word.to_ascii_lowercase().as_str(), "pixel" | "geo" | "tessc" | "tesse")
}

#[cfg(test)]
mod tests {
    use super::stem;

    #[test]
    fn a_program_is_named_without_its_stage() {
        for file in ["lights.vert", "lights_vs.glsl", "lights.frag.glsl", "fs-lights.glsl"] {
            assert_eq!(stem(file), "lights", "{file}");
        }
        assert_eq!(stem("scene_330.vert"), "scene_330");
        assert_eq!(stem("vert.glsl"), "");
        assert_eq!(stem("5.1.light_casters.fs"), "5.1.light_casters");
    }
}
