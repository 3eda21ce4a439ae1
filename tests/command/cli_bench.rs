//! `landfall bench`: what it takes, what it writes, and what it refuses.

use std::path::Path;

use landfall_accuracy::bench::{Bench, BenchRow};
use snapbox::data::Inline;
use snapbox::str;

use crate::support::command::{self, Place, golden};

const SCENE: &str = "shaders/scenes/six_lights.json";
const SMALL: [&str; 4] = ["--size", "40x30", "--rounds", "3"];

fn bench(arguments: &[&str]) -> Bench {
    let arguments = [&["bench"], arguments, &SMALL, &["--format", "json"]].concat();
    let output = command::run(&arguments);
    assert_eq!(output.code, 0, "{}", output.err);
    serde_json::from_slice(&output.bytes).expect("a bench")
}

/// The largest error of what gave some number.
pub fn steps(row: &BenchRow) -> f64 {
    row.errors.max_steps.unwrap_or_else(|| panic!("no number: {row:?}"))
}

#[test]
fn a_scene_is_lit_by_what_is_compiled_and_by_shaders() {
    let folder = Place::new("bench-scene");
    let plot = folder.path("six.svg");
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
        "--backend",
        "cpu,gpu",
        "--plot",
        &plot,
    ]);
    assert!(found.failed.is_empty(), "{:?}", found.failed);
    let row = |variant: &str, backend: &str| {
        let found = found.rows.iter().find(|r| r.variant == variant && r.runner.backend == backend);
        found.unwrap_or_else(|| panic!("{variant} on {backend}"))
    };
    for name in ["seed", "robust", "tiles"] {
        // f32 at its best is some thousandths of a step off, and no fragment is no number.
        let errors = row(name, "rust").errors;
        let most = steps(row(name, "rust"));
        assert!(most > 0.0 && most < 0.01, "{name}: {errors:?}");
        assert_eq!((errors.non_finite, errors.undefined), (0, 0));
        assert_eq!(errors.channels, 3 * found.fragments);
    }
    // A power of less than 0.01 that is left out is 2.55 steps at most, and more than nothing.
    let coarse = row("coarse", "rust");
    assert!(steps(coarse) > steps(row("robust", "rust")));
    assert!(steps(coarse) < 2.6);
    assert!(coarse.work.powers < row("robust", "rust").work.powers);
    assert_eq!(row("seed", "rust").work.evaluations, Some(6.0));
    for backend in ["cpu", "gpu"] {
        let shader = row("shader", backend);
        assert!(steps(shader) < 0.01, "{:?}", shader.errors);
        assert!(shader.work.operations.is_some_and(|n| n > 100.0), "{:?}", shader.work);
        // What any device may do is more than what one does.
        let permitted = shader.permitted.and_then(|permitted| permitted.max_steps);
        assert!(permitted.is_some_and(|most| most > steps(shader)), "{shader:?}");
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
    let found = bench(&[scene, "--backend", "cpu", "--variant", variant]);
    let shader = found.rows.iter().find(|row| row.runner.backend == "cpu");
    let shader = shader.unwrap_or_else(|| panic!("{:?}", found.failed));
    // One slope a round, of any sign: it is a difference of times, which a busy machine can turn.
    assert!(shader.light.is_some_and(|spread| spread.median.is_finite()), "{shader:?}");
    assert_eq!(shader.light_rounds.as_ref().map(Vec::len), Some(3), "{shader:?}");
    assert!(shader.light_gross.is_some_and(|time| time > 0.0), "{shader:?}");
    // Far below 128 slots: only lights in use are evaluated.
    assert!(shader.work.evaluations.is_some_and(|n| n < 10.0), "{:?}", shader.work);
}

#[test]
fn a_light_that_is_skipped_is_not_evaluated() {
    let shader = "shader=shaders/six_lights/phong_450.frag";
    let found =
        bench(&[SCENE, "--backend", "cpu", "--variant", shader, "--variant", "rust=rust:robust"]);
    let work =
        |backend: &str| found.rows.iter().find(|row| row.runner.backend == backend).unwrap().work;
    // Both skip lights that a fragment faces away from; Rust counts what it computes, of the
    // shader it is seen by marking lights.
    let (shader, rust) = (work("cpu"), work("rust"));
    assert_eq!(shader.slots, Some(6.0));
    assert!(rust.evaluations.is_some_and(|n| n < 6.0), "{rust:?}");
    let apart = shader.evaluations.zip(rust.evaluations).map(|(a, b)| (a - b).abs());
    assert!(apart.is_some_and(|apart| apart < 0.01), "{shader:?} {rust:?}");
}

#[test]
#[ignore = "measures for long: ./tests/run command"]
fn a_shader_that_is_culled_by_a_plan_looks_at_fewer_slots() {
    let shader = "shaders/many_lights/windowed_listed.wgsl";
    let scene = "shaders/scenes/lights_1024_windowed.json";
    let plain = format!("plain={shader}");
    let culled = format!("culled={shader}+plan:tiles");
    let rust = "rust=plan:tiles";
    let some = ["--size", "24x18", "--rounds", "3", "--format", "json", "--backend", "cpu"];
    let variants = ["--variant", &plain, "--variant", &culled, "--variant", rust];
    let output = command::run(&[&["bench", scene], &some[..], &variants].concat());
    assert_eq!(output.code, 0, "{}", output.err);
    let found: Bench = serde_json::from_slice(&output.bytes).expect("a bench");
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
    let found = bench(&[SCENE, "--backend", "cpu,gl", "--variant", variant]);
    assert_eq!(found.rows.len(), 1, "{:?}", found.rows);
    // f16 has 11 digits: sums of light near 1 are off by more than a tenth of a step.
    assert!(steps(&found.rows[0]) > 0.1, "{:?}", found.rows[0].errors);
    assert_eq!(found.rows[0].permitted, None);
    assert_eq!(found.failed[0].backend, "gl");
    golden().eq(&found.failed[0].reason, str!["only backend cpu rounds floats to f16"]);
}

#[test]
fn a_variant_of_another_model_is_held_against_its_own() {
    let facing = r#"robust={"family": "multi", "specular_gate": "facing"}"#;
    let robust = "robust=shaders/six_lights/phong_450.frag";
    let one = |more: &[&str]| {
        let found = bench(&[&[SCENE, "--backend", "cpu", "--variant", robust], more].concat());
        steps(&found.rows[0])
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
    let refused = |arguments: &[&str], said: Inline| {
        let ran = command::run(&[&["bench"], arguments, &SMALL[2..]].concat());
        ran.code(2).stdout_eq("").stderr_eq(said);
    };
    refused(
        &["no_such_scene.json"],
        str![[r#"
error[unreadable-file]: `no_such_scene.json` cannot be read: no such file or directory


"#]],
    );
    refused(
        &[SCENE, "--variant", "a=rust:sturdy"],
        str![[r#"
error[bad-request]: `--variant a` is not a compiled kernel: `sturdy`
  |
  = help: the kernels are `seed`, `robust`, `ungated` and `robust=POWER`, POWER < 1


"#]],
    );
    refused(
        &[SCENE, "--variant", "a=plan:sometimes"],
        str![[r#"
error[bad-request]: `--variant a` is not a plan: `sometimes`: unknown part; expected one of used, gates[=STEPS], tiles[=PIXELS], budget=STEPS, budget-srgb=STEPS, always


"#]],
    );
    refused(
        &[SCENE, "--variant", "a=no_such.frag"],
        str![[r#"
error[unreadable-file]: `no_such.frag` cannot be read: no such file or directory


"#]],
    );
    refused(
        &[SCENE, "--variant", "a=rust:seed", "--model-of", "b=multi"],
        str![[r#"
error[bad-request]: `--model-of` sets the model of `b`, which is not a variant


"#]],
    );
    let output = command::run(&["bench", SCENE, "--rounds", "1"]);
    assert_eq!(output.code, 2);
    // The name of one would stand for two.
    let twice = ["--variant", "a=rust:seed", "--variant", "a=rust:robust"];
    refused(
        &[&[SCENE][..], &twice].concat(),
        str![[r#"
error[bad-request]: `--variant a=rust:robust` repeats the name of `--variant a=rust:seed`
  |
  = help: give each a distinct name


"#]],
    );
    let models = ["--model-of", "a=multi", "--model-of", "a=array"];
    refused(
        &[&[SCENE], &twice[..2], &models].concat(),
        str![[r#"
error[bad-request]: `--model-of a=array` repeats the name of `--model-of a=multi`
  |
  = help: give each a distinct name


"#]],
    );
    refused(
        &["shaders/six_lights/phong_450.frag"],
        str![[r#"
error[bad-request]: `shaders/six_lights/phong_450.frag` is a shader, not a scene
  |
  = help: measure a function of a shader with `--fn NAME`


"#]],
    );
}

#[test]
fn a_refusal_says_whether_it_is_the_file_or_the_arguments() {
    let folder = Place::new("bench-codes");
    let directory = folder.0.display().to_string();
    let code = |arguments: &[&str]| {
        let output = command::run(&[&["bench"], arguments].concat());
        let said = &output.err;
        assert_eq!(output.code, 2, "{arguments:?}\n{said}");
        let code = said.strip_prefix("error[").and_then(|rest| rest.split_once(']'));
        code.unwrap_or_else(|| panic!("{said}")).0.to_string()
    };
    assert_eq!(code(&["no_such_scene.json"]), "unreadable-file");
    assert_eq!(code(&[&directory]), "unreadable-file");
    assert_eq!(code(&[SCENE, "--variant", "a=no_such.frag"]), "unreadable-file");
    assert_eq!(code(&[SCENE, "--variant", &format!("a={directory}")]), "unreadable-file");
    assert_eq!(code(&[SCENE, "--variant", "a=rust:sturdy"]), "bad-request");
    assert_eq!(code(&[SCENE, "--model", "matt"]), "bad-request");
    // As the other commands that run functions say it.
    for command in ["stress", "run"] {
        let more: &[&str] = if command == "run" { &["--args", "[]"] } else { &[] };
        let output = command::run(&[&[command, "gone.frag", "--fn", "f"], more].concat());
        output.code(2).stderr_eq(str![[r#"
error[unreadable-file]: `gone.frag` cannot be read: no such file or directory


"#]]);
    }
}

/// clap waives what an option requires where that conflicts with another that is there.
#[test]
fn options_of_functions_are_refused_for_scenes_and_the_other_way_round() {
    let of_scenes: [[&str; 2]; 5] = [
        ["--size", "40x30"],
        ["--model", "multi"],
        ["--model-of", "a=multi"],
        ["--bind", "{}"],
        ["--most", "600"],
    ];
    let of_functions: [[&str; 2]; 6] = [
        ["--truth", "a"],
        ["--seed", "2"],
        ["--samples", "9"],
        ["--domain", "{}"],
        ["--data", "{}"],
        ["--texture", "t=[1,1,1,1]"],
    ];
    let refused = |arguments: &[&str]| {
        let output = command::run(&[&["bench", SCENE, "--rounds", "3"], arguments].concat());
        assert_eq!(output.code, 2, "{arguments:?}");
        // By the command line, before anything is read.
        assert!(output.err.contains("Usage: "), "{}", output.err);
    };
    for function in &of_functions {
        refused(function);
        for scene in &of_scenes {
            refused(&[&scene[..], function].concat());
        }
    }
    for scene in &of_scenes {
        refused(&[&scene[..], &["--fn", "f"]].concat());
    }
}

/// The line of a report that names a backend without results.
fn missing(said: &str) -> &str {
    said.lines().find(|line| line.starts_with("every shader on ")).unwrap_or(said)
}

#[test]
fn a_reader_that_is_missing_is_no_success_and_no_rows_are_no_plot() {
    let folder = Place::new("bench-missing");
    let plot = folder.0.join("keep.svg");
    std::fs::write(&plot, "kept").unwrap();
    let shown = plot.display().to_string();
    let shader = ["--variant", "s=shaders/six_lights/phong_450.frag", "--adapter", "no such one"];
    let some = [&["bench", SCENE], &SMALL[..], &shader, &["--plot", &shown]].concat();
    let output = command::run(&[&some[..], &["--backend", "gpu"]].concat());
    let said = &output.out;
    assert_eq!(output.code, 2, "{said}");
    golden().eq(
        missing(said),
        str!["every shader on gpu: no GPU adapter matches `no such one`; there are llvmpipe"],
    );
    assert!(!said.contains("interleaved rounds"), "{said}");
    assert_eq!(std::fs::read_to_string(&plot).unwrap(), "kept");
    // What there is is printed, and drawn.
    let output = command::run(&[&some[..], &["--backend", "cpu,gpu"]].concat());
    let said = &output.out;
    assert_eq!(output.code, 2, "{said}");
    golden().eq(
        missing(said),
        str!["every shader on gpu: no GPU adapter matches `no such one`; there are llvmpipe"],
    );
    assert!(said.contains("\n*  s "), "{said}");
    assert!(std::fs::read_to_string(&plot).unwrap().contains("<svg"));
}

#[test]
fn a_reader_that_is_named_twice_measures_once() {
    let variant = "s=shaders/six_lights/phong_450.frag";
    let found = bench(&[SCENE, "--backend", "cpu,cpu", "--variant", variant]);
    assert_eq!(found.rows.len(), 1, "{:?}", found.rows);
}

#[test]
fn what_is_wrong_with_a_scene_is_said_once() {
    let folder = Place::new("bench-warned");
    let scene = std::fs::read_to_string(SCENE).unwrap();
    let scene = scene.replace("\"fov\": 45", "\"fov\": 0.8");
    // Textures and shaders are named from where the scene is.
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let scene = scene.replace("\"../", &format!("\"{}/", base.display()));
    let path = folder.path("narrow.json");
    std::fs::write(&path, scene).unwrap();
    let variants = ["a", "b", "c"].map(|name| format!("{name}=shaders/six_lights/phong_450.frag"));
    let mut arguments = vec!["bench", &path, "--backend", "cpu", "--model-of", "b=multi"];
    variants.iter().for_each(|variant| arguments.extend(["--variant", variant]));
    let output = command::run(&[&arguments[..], &SMALL].concat());
    let said = &output.err;
    assert_eq!(output.code, 0, "{said}");
    assert_eq!(said.matches("suspicious-unit").count(), 1, "{said}");
}

#[test]
fn a_shader_that_gives_no_number_has_no_error_and_is_not_the_best() {
    // Of 128 lights two are there; the published form takes the others too, which are zeros.
    let scene = "shaders/scenes/two_of_128.json";
    let more = ["--backend", "cpu", "-D", "POINT_LIGHT_COUNT=128", "--variant"];
    let variant = "s=shaders/seed/light_arrays_450.frag";
    let output =
        command::run(&[&["bench", scene, "--details"], &SMALL[..], &more, &[variant]].concat());
    let said = &output.out;
    assert!(said.contains("\n- no result is a number\n"), "{said}");
    // The columns of a variant may take several lines.
    let lines: Vec<&str> = said.lines().filter(|line| line.contains("  s  ")).collect();
    assert!(lines.iter().all(|line| !line.starts_with('*')), "{said}");
    let cells = lines.iter().flat_map(|line| line.split_whitespace());
    assert_eq!(cells.filter(|cell| *cell == "-").count(), 2, "{said}");
    let found = bench(&[&[scene], &more[..], &[variant]].concat());
    let errors = found.rows[0].errors;
    assert_eq!((errors.channels, errors.max_steps, errors.p999_steps), (0, None, None));
    assert_eq!(errors.non_finite + errors.undefined, found.fragments);
}

#[test]
fn csv_has_a_line_a_variant() {
    let output = command::run(
        &[&["bench", SCENE, "--variant", "a=rust:seed", "--format", "csv"], &SMALL[..]].concat(),
    );
    let text = &output.out;
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(text.starts_with("variant,backend,device,clock,ns_per_light"), "{text}");
    assert!(text.lines().nth(1).is_some_and(|line| line.starts_with("a,rust,")), "{text}");
}
