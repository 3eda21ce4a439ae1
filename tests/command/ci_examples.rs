//! The examples for CI in the book and the hooks for pre-commit do what they are there for.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use landfall_lint::render::read_json;

const CI: &str = include_str!("../../docs/src/ci.md");
const HOOKS: &str = include_str!("../../.pre-commit-hooks.yaml");

/// The command lines of landfall in the examples of a text.
fn commands(text: &str) -> Vec<String> {
    let starts = ["- run: ", "- ", "entry: ", "exec "];
    let command = |line: &str| {
        let line = line.trim();
        let line = starts.iter().find_map(|start| line.strip_prefix(start)).unwrap_or(line);
        line.starts_with("landfall ").then(|| line.to_string())
    };
    text.lines().filter_map(command).collect()
}

/// Those in the fences of the book's page.
fn examples() -> Vec<String> {
    let fences = CI.split("```").skip(1).step_by(2);
    fences.flat_map(commands).collect()
}

/// A project with a few shaders and their locks.
fn project(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ci-{name}"));
    let _ = fs::remove_dir_all(&folder);
    let shaders = folder.join("shaders");
    fs::create_dir_all(&shaders).expect("the target directory can be written");
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/light_arrays");
    for file in ["point_lights_330.frag", "directional_lights_330.frag", "lights.wgsl"] {
        fs::copy(from.join(file), shaders.join(file)).expect("it can be copied");
    }
    // The search for a configuration ends here.
    fs::write(folder.join("landfall.toml"), "").expect("it can be written");
    let output = run(&folder, "landfall lock shaders");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder
}

fn run(folder: &Path, command: &str) -> Output {
    let words: Vec<&str> = command.split_whitespace().collect();
    assert_eq!(words[0], "landfall");
    Command::new(env!("CARGO_BIN_EXE_landfall"))
        .args(&words[1..])
        .current_dir(folder)
        .env_remove("GITHUB_STEP_SUMMARY")
        .env("LANDFALL_CACHE_KEY", "the key of these tests")
        .output()
        .expect("the command of this package")
}

fn succeeds(folder: &Path, command: &str) {
    let output = run(folder, command);
    let told = [&output.stdout[..], &output.stderr].concat();
    assert_eq!(output.status.code(), Some(0), "{command}\n{}", String::from_utf8_lossy(&told));
}

#[test]
fn every_example_runs_and_writes_its_reports() {
    let folder = project("readme");
    let examples = examples();
    assert!(examples.len() >= 5, "{examples:?}");
    for example in &examples {
        let shards = if example.contains("matrix.shard") { 1..=4 } else { 1..=1 };
        for shard in shards {
            succeeds(&folder, &example.replace("${{ matrix.shard }}", &shard.to_string()));
        }
    }
    let written = |name: &str| fs::read_to_string(folder.join(name)).expect("a report");
    for shard in 1..=4 {
        read_json("report.json", &written(&format!("report-{shard}.json"))).expect("a report");
    }
    assert!(written("landfall.sarif").contains("\"2.1.0\""));
    assert!(written("landfall.xml").contains("<testsuites"));
}

#[test]
fn every_hook_succeeds_and_fails_when_a_layout_drifts() {
    let folder = project("hooks");
    let hooks = commands(HOOKS);
    assert_eq!(hooks.len(), HOOKS.matches("- id: ").count());
    hooks.iter().for_each(|hook| succeeds(&folder, hook));
    let file = folder.join("shaders/lights.wgsl");
    let text = fs::read_to_string(&file).expect("text");
    let drifted = text.replacen("intensity: f32", "intensity: vec4<f32>", 1);
    assert_ne!(text, drifted);
    fs::write(&file, drifted).expect("it can be written");
    for hook in &hooks {
        assert_eq!(run(&folder, hook).status.code(), Some(1), "{hook}");
    }
}
