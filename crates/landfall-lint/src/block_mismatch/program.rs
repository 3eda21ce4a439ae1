//! Groups shaders into programs by their file names.

use landfall_layout::ShaderLayout;
use landfall_layout::source::{Language, Stage};

/// The key of a program.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Program {
    directory: String,
    /// The file's name without its stage.
    name: String,
    pipeline: PipelineClass,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum PipelineClass {
    Graphics,
    Compute,
    RayTracing,
}

/// Returns the program of a shader: its directory, and its file name without the stage. `None` for
/// texts without a stage, and for WGSL modules whose name says none: they contain all stages.
pub(super) fn program(shader: &ShaderLayout) -> Option<Program> {
    let (directory, file) = split(&shader.path);
    // A WGSL module may have all stages: only its name can say that it has one.
    let stage = shader.stage.filter(|_| shader.language == Language::Glsl);
    let pipeline = match stage.or_else(|| named_stage(&file))? {
        Stage::Vertex
        | Stage::TessellationControl
        | Stage::TessellationEvaluation
        | Stage::Geometry
        | Stage::Fragment
        | Stage::Task
        | Stage::Mesh => PipelineClass::Graphics,
        Stage::Compute => PipelineClass::Compute,
        Stage::RayGeneration
        | Stage::Intersection
        | Stage::AnyHit
        | Stage::ClosestHit
        | Stage::Miss
        | Stage::Callable => PipelineClass::RayTracing,
        _ => return None,
    };
    Some(Program { directory, name: stem(&file), pipeline })
}

/// Returns the directory of a file, and its name without stage and extensions.
pub(super) fn base_name(path: &str) -> (String, String) {
    let (directory, file) = split(path);
    (directory, stem(&file))
}

fn split(path: &str) -> (String, String) {
    let path = path.replace('\\', "/");
    let (directory, file) = path.rsplit_once('/').unwrap_or(("", &path));
    (directory.to_string(), file.to_string())
}

/// Returns a file's name without its extensions and stage names: `lights.vert`, `lights_vs.glsl`,
/// `lights.frag.wgsl`, `fs_lights.glsl` and `lightsVert.glsl` are all `lights`.
fn stem(file: &str) -> String {
    let name = without_extensions(file);
    let words: Vec<String> = name
        .split(['_', '-'])
        .filter(|word| !is_stage(word))
        .map(|word| match ending(word) {
            Some((rest, _)) => rest.to_string(),
            None => word.to_string(),
        })
        .collect();
    match words.join("_") {
        // `mesh.wgsl` and `task.wgsl` are names of things.
        rest if rest.is_empty() && named_stage(file).is_none() => name,
        rest => rest,
    }
}

/// Returns a file's name without its extensions, and without a stage before them.
fn without_extensions(file: &str) -> String {
    let mut parts: Vec<&str> = file.split('.').collect();
    // What is behind the first dot is an extension if it is the last part or says a stage.
    while parts.len() > 1 {
        let inner = parts.len() > 2 && is_stage(parts[parts.len() - 2]);
        parts.pop();
        if !inner {
            break;
        }
    }
    parts.join(".")
}

fn is_stage(word: &str) -> bool {
    Stage::from_name(word).is_some()
        || matches!(word.to_ascii_lowercase().as_str(), "pixel" | "geo" | "tessc" | "tesse")
}

/// Returns the stage that a file's name says: `sky.vert.wgsl`, `sky_fs.wgsl`, `skyVert.glsl`.
fn named_stage(file: &str) -> Option<Stage> {
    let words = file.split(['.', '_', '-']);
    // `mesh.wgsl` and `task.wgsl` are names of things.
    let stage = |word: &str| match Stage::from_name(word)? {
        stage @ (Stage::Vertex | Stage::Fragment | Stage::Compute) => Some(stage),
        _ => None,
    };
    words.into_iter().find_map(|word| stage(word).or_else(|| Some(ending(word)?.1)))
}

/// Returns a word without the stage that it ends with, and that stage: `skyVert`, `SkyPS`,
/// `skyfragment`.
fn ending(word: &str) -> Option<(&str, Stage)> {
    const ENDINGS: &[(&str, Stage)] = &[
        ("VertexShader", Stage::Vertex),
        ("FragmentShader", Stage::Fragment),
        ("PixelShader", Stage::Fragment),
        ("ComputeShader", Stage::Compute),
        ("Vertex", Stage::Vertex),
        ("Fragment", Stage::Fragment),
        ("Compute", Stage::Compute),
        ("Vert", Stage::Vertex),
        ("Frag", Stage::Fragment),
        ("Comp", Stage::Compute),
        ("VS", Stage::Vertex),
        ("FS", Stage::Fragment),
        ("PS", Stage::Fragment),
        ("vert", Stage::Vertex),
        ("frag", Stage::Fragment),
    ];
    ENDINGS.iter().find_map(|(ending, stage)| {
        let rest = word.strip_suffix(ending).filter(|rest| rest.len() > 1)?;
        // `GLVS` is a word of capitals.
        let clear = !ending.starts_with(char::is_uppercase)
            || rest.ends_with(|c: char| !c.is_ascii_uppercase());
        clear.then_some((rest, *stage))
    })
}

#[cfg(test)]
mod tests {
    use super::{named_stage, stem};
    use landfall_layout::source::Stage;

    #[test]
    fn a_wgsl_module_has_the_stage_of_its_name() {
        assert_eq!(named_stage("sky.vert.wgsl"), Some(Stage::Vertex));
        assert_eq!(named_stage("sky_fs.wgsl"), Some(Stage::Fragment));
        assert_eq!(named_stage("skyCompute.wgsl"), Some(Stage::Compute));
        for file in ["sky.wgsl", "mesh.wgsl", "task_list.wgsl", "evaluate.wgsl"] {
            assert_eq!(named_stage(file), None, "{file}");
        }
    }

    #[test]
    fn a_program_is_named_without_its_stage() {
        for file in [
            "lights.vert",
            "lights_vs.glsl",
            "lights.frag.glsl",
            "fs-lights.glsl",
            "lights.vert.wgsl",
            "lightsVert.glsl",
            "lightsFS.glsl",
            "lightsfrag.glsl",
        ] {
            assert_eq!(stem(file), "lights", "{file}");
        }
        assert_eq!(stem("GLVS.glsl"), "GLVS");
        assert_eq!(stem("mesh.wgsl"), "mesh");
        assert_eq!(stem("scene_330.vert"), "scene_330");
        assert_eq!(stem("vert.glsl"), "");
        assert_eq!(stem("5.1.light_casters.fs"), "5.1.light_casters");
    }
}
