//! `landfall bench`: what it takes, what it writes, and what it refuses.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use landfall::accuracy::bench::Bench;

fn landfall(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.args(arguments).output().expect("the binary was built for this test")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bench-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

const SCENE: &str = "shaders/scenes/six_lights.json";
const SMALL: [&str; 4] = ["--size", "40x30", "--rounds", "3"];

fn bench(arguments: &[&str]) -> Bench {
    let arguments = [&["bench"], arguments, &SMALL, &["--format", "json"]].concat();
    let output = landfall(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a bench")
}

#[test]
fn a_scene_is_lit_by_what_is_compiled_and_by_shaders() {
    let folder = folder("scene");
    let plot = folder.join("six.svg").display().to_string();
    let found = bench(&[
        SCENE,
        "--variant",
        "seed=rust:seed",
        "--variant",
        "robust=rust:robust",
        "--variant",
        "coarse=rust:robust=0.01",
        "--variant",
        "tiles=plan:tiles,always",
        "--variant",
        "shader=shaders/seed/six_lights_450.frag",
        "--reader",
        "cpu,gpu",
        "--plot",
        &plot,
    ]);
    assert!(found.failed.is_empty(), "{:?}", found.failed);
    let row = |variant: &str, reader: &str| {
        let found = found.rows.iter().find(|r| r.variant == variant && r.runner.reader == reader);
        found.unwrap_or_else(|| panic!("{variant} on {reader}"))
    };
    for name in ["seed", "robust", "tiles"] {
        // f32 at its best is some thousandths of a step off, and no fragment is no number.
        let errors = row(name, "rust").errors;
        assert!(errors.max_steps > 0.0 && errors.max_steps < 0.01, "{name}: {errors:?}");
        assert_eq!((errors.non_finite, errors.undefined), (0, 0));
        assert_eq!(errors.channels, 3 * found.fragments);
    }
    // A power of less than 0.01 that is left out is 2.55 steps at most, and more than nothing.
    let coarse = row("coarse", "rust");
    assert!(coarse.errors.max_steps > row("robust", "rust").errors.max_steps);
    assert!(coarse.errors.max_steps < 2.6);
    assert!(coarse.work.powers < row("robust", "rust").work.powers);
    assert_eq!(row("seed", "rust").work.evaluations, Some(6.0));
    for reader in ["cpu", "gpu"] {
        let shader = row("shader", reader);
        assert!(shader.errors.max_steps < 0.01, "{:?}", shader.errors);
        assert!(shader.work.operations.is_some_and(|n| n > 100.0), "{:?}", shader.work);
        // What any device may do is more than what one does.
        let permitted = shader.permitted.and_then(|permitted| permitted.max_steps);
        assert!(permitted.is_some_and(|most| most > shader.errors.max_steps), "{shader:?}");
        assert_eq!(shader.work.evaluations, Some(6.0));
        assert!(shader.work.bytes.is_some_and(|n| n > 100));
        assert!(shader.subtracted);
    }
    assert_eq!((found.lights, found.rows[0].fragment.rounds), (6, 3));
    let drawn = std::fs::read_to_string(&plot).unwrap();
    let drawn = roxmltree::Document::parse(&drawn).unwrap();
    assert!(drawn.descendants().any(|node| node.text() == Some("coarse")));
}

#[test]
fn lights_of_a_shader_that_counts_them_cost_a_slope() {
    let variant = "all=shaders/light_arrays/all_lights_450.frag";
    let scene = "shaders/scenes/two_of_128.json";
    let found = bench(&[scene, "--reader", "cpu", "--variant", variant]);
    let shader = found.rows.iter().find(|row| row.runner.reader == "cpu");
    let shader = shader.unwrap_or_else(|| panic!("{:?}", found.failed));
    assert!(shader.light.is_some_and(|spread| spread.median > 0.0), "{shader:?}");
    // Far below 128 slots: only lights in use are evaluated.
    assert!(shader.work.evaluations.is_some_and(|n| n < 10.0), "{:?}", shader.work);
}

#[test]
fn a_light_that_is_skipped_is_not_evaluated() {
    let shader = "shader=shaders/six_lights/phong_450.frag";
    let found =
        bench(&[SCENE, "--reader", "cpu", "--variant", shader, "--variant", "rust=rust:robust"]);
    let work =
        |reader: &str| found.rows.iter().find(|row| row.runner.reader == reader).unwrap().work;
    // Both skip lights that a fragment faces away from; Rust counts what it computes, of the
    // shader it is seen by marking lights.
    let (shader, rust) = (work("cpu"), work("rust"));
    assert_eq!(shader.slots, Some(6.0));
    assert!(rust.evaluations.is_some_and(|n| n < 6.0), "{rust:?}");
    let apart = shader.evaluations.zip(rust.evaluations).map(|(a, b)| (a - b).abs());
    assert!(apart.is_some_and(|apart| apart < 0.01), "{shader:?} {rust:?}");
}

#[test]
fn a_shader_that_is_culled_by_a_plan_looks_at_fewer_slots() {
    let shader = "shaders/many_lights/windowed_listed.wgsl";
    let scene = "shaders/scenes/lights_1024_windowed.json";
    let plain = format!("plain={shader}");
    let culled = format!("culled={shader}+plan:tiles");
    let rust = "rust=plan:tiles";
    let some = ["--size", "24x18", "--rounds", "3", "--format", "json", "--reader", "cpu"];
    let variants = ["--variant", &plain, "--variant", &culled, "--variant", rust];
    let output = landfall(&[&["bench", scene], &some[..], &variants].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let found: Bench = serde_json::from_slice(&output.stdout).expect("a bench");
    let row = |variant: &str| found.rows.iter().find(|row| row.variant == variant).unwrap();
    let [plain, culled, rust] = ["plain", "culled", "rust"].map(row);
    assert_eq!(plain.work.slots, Some(1024.0));
    assert!(culled.work.slots.is_some_and(|slots| slots < 512.0), "{:?}", culled.work);
    // What is culled gives nothing: it is not evaluated anyway, and the colours are the same.
    assert_eq!(plain.errors, culled.errors);
    for work in [plain.work, culled.work] {
        let (lights, error) = work.evaluations.zip(work.evaluations_error).unwrap();
        let counted = rust.work.evaluations.unwrap();
        assert!(error > 0.0 && error < 0.2 * counted, "{work:?}");
        assert!((lights - counted).abs() < 4.0 * error, "{lights} and {counted}, {error}");
    }
}

#[test]
fn a_shader_in_half_precision_is_the_evaluators_alone() {
    let variant = "half=shaders/six_lights/phong_450.frag:half";
    let found = bench(&[SCENE, "--reader", "cpu,gl", "--variant", variant]);
    assert_eq!(found.rows.len(), 1, "{:?}", found.rows);
    // f16 has 11 digits: sums of light near 1 are off by more than a tenth of a step.
    assert!(found.rows[0].errors.max_steps > 0.1, "{:?}", found.rows[0].errors);
    assert_eq!(found.rows[0].permitted, None);
    assert_eq!(found.failed[0].reader, "gl");
    assert!(found.failed[0].reason.contains("only the evaluator"), "{:?}", found.failed);
}

#[test]
fn a_variant_of_another_model_is_held_against_its_own() {
    let facing = r#"robust={"family": "multi", "specular_gate": "facing"}"#;
    let robust = "robust=shaders/six_lights/phong_450.frag";
    let one = |more: &[&str]| {
        let found = bench(&[&[SCENE, "--reader", "cpu", "--variant", robust], more].concat());
        found.rows[0].errors.max_steps
    };
    // It gates highlights by the side the light is on, which the published model does not.
    let (published, own) = (one(&["--model", "multi"]), one(&["--model-of", facing]));
    assert!(own < 2e-3 && own < published, "{own} {published}");
}

#[test]
fn few_fragments_of_a_large_scene_are_taken_and_said() {
    let found = bench(&[SCENE, "--most", "600", "--variant", "seed=rust:seed"]);
    // 600 evaluations by six lights, and no more than every second fragment more.
    assert!((50..=100).contains(&found.fragments), "{}", found.fragments);
    assert!(found.subject.contains(&format!("{} of ", found.fragments)), "{}", found.subject);
}

#[test]
fn what_cannot_be_measured_is_refused_by_name() {
    let refused = |arguments: &[&str], wanted: &str| {
        let output = landfall(&[&["bench"], arguments, &SMALL[2..]].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}\n{said}");
        assert!(said.contains(wanted), "{arguments:?}\n{said}");
    };
    refused(&["no_such_scene.json"], "no_such_scene.json");
    refused(&[SCENE, "--variant", "a=rust:sturdy"], "forms are `seed`, `robust`");
    refused(&[SCENE, "--variant", "a=plan:sometimes"], "sometimes");
    refused(&[SCENE, "--variant", "a=no_such.frag"], "no_such.frag");
    refused(&[SCENE, "--variant", "a=rust:seed", "--model-of", "b=multi"], "`--model-of`");
    let output = landfall(&["bench", SCENE, "--rounds", "1"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn csv_has_a_line_a_variant() {
    let output = landfall(
        &[&["bench", SCENE, "--variant", "a=rust:seed", "--format", "csv"], &SMALL[..]].concat(),
    );
    let text = text(&output.stdout);
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(text.starts_with("variant,reader,device,clock,ns_per_light"), "{text}");
    assert!(text.lines().nth(1).is_some_and(|line| line.starts_with("a,rust,")), "{text}");
}
