//! The examples for CI in the book and the hooks for pre-commit do what they are there for.

use std::fs;
use std::path::Path;

use crate::support::command::{Place, Ran};

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
fn project(name: &str) -> Place {
    let project = Place::new(&format!("ci-{name}"));
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/light_arrays");
    for file in ["point_lights_330.frag", "directional_lights_330.frag", "lights.wgsl"] {
        let text = fs::read(from.join(file)).expect("a shader of this repository");
        project.write(&format!("shaders/{file}"), text);
    }
    succeeds(&project, "landfall lock shaders");
    project
}

fn run(project: &Place, command: &str) -> Ran {
    let words: Vec<&str> = command.split_whitespace().collect();
    assert_eq!(words[0], "landfall");
    project.run(&words[1..])
}

fn succeeds(project: &Place, command: &str) {
    let ran = run(project, command);
    assert_eq!(ran.code, 0, "{command}\n{}{}", ran.out, ran.err);
}

#[test]
fn every_example_runs_and_writes_its_reports() {
    let project = project("readme");
    let examples = examples();
    assert!(examples.len() >= 5, "{examples:?}");
    for example in &examples {
        succeeds(&project, example);
    }
    let written = |name: &str| project.read(name);
    assert!(written("landfall.sarif").contains("\"2.1.0\""));
    assert!(written("landfall.xml").contains("<testsuites"));
}

#[test]
fn every_hook_succeeds_and_fails_when_a_layout_drifts() {
    let project = project("hooks");
    let hooks = commands(HOOKS);
    assert_eq!(hooks.len(), HOOKS.matches("- id: ").count());
    hooks.iter().for_each(|hook| succeeds(&project, hook));
    let text = project.read("shaders/lights.wgsl");
    let drifted = text.replacen("intensity: f32", "intensity: vec4<f32>", 1);
    assert_ne!(text, drifted);
    project.write("shaders/lights.wgsl", drifted);
    for hook in &hooks {
        assert_eq!(run(&project, hook).code, 1, "{hook}");
    }
}

/// Patterns of hooks have every ending of a shader; the book those of glslang.
#[test]
fn hooks_run_for_every_shader_lock_and_configuration() {
    let page = include_str!("../../docs/src/languages.md");
    let page = page.split_once("## Which files a search reads").expect("a section").1;
    let table = page.split("\n\n").nth(2).expect("a table");
    let endings = table.split("`.").skip(1).filter_map(|rest| rest.split_once('`'));
    let endings: Vec<&str> =
        endings.map(|(ending, _)| ending).filter(|e| !e.contains('.')).collect();
    assert!(endings.len() > 30, "{endings:?}");
    let words = |pattern: &str| -> Vec<String> {
        pattern.split(['(', ')', '|']).map(str::to_string).collect()
    };
    for ending in &endings {
        assert!(words(HOOKS).iter().any(|word| word == ending), "{ending}");
    }
    let book = CI.lines().find(|line| line.trim().starts_with("files: '")).expect("a pattern");
    for word in ["vert", "tesc", "rmiss", "mesh", "glsl", "wgsl"] {
        assert!(words(book).iter().any(|other| other == word), "{word}");
    }
    assert!(book.contains("landfall\\.toml$") && book.contains("layouts/"), "{book}");
}
