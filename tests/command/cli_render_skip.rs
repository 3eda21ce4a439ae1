//! `landfall render --skip`: what it applies, what it measures, and the time that it says.

use std::process::Command;

use snapbox::str;

use crate::support::command::{self, Place, golden};

const SCENE: &str = "shaders/scenes/lights_1024_windowed.json";
const SHADER: &str = "shaders/many_lights/windowed_330.frag";

/// Runs the command and returns its plan in JSON, and the processor time of the whole process.
fn planned(scene: &str, size: &str, more: &[&str]) -> (serde_json::Value, f64) {
    let script = "TIMEFORMAT='%U %S'; time \"$@\"";
    let mut bash = Command::new("bash");
    bash.args(["-c", script, "bash", env!("CARGO_BIN_EXE_landfall"), "render", scene]);
    let output = bash.args(["--size", size, "--format", "json"]).args(more).output();
    let output = output.expect("bash is there");
    let err = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{err}");
    let seconds = err.lines().last().unwrap_or_default().split(' ');
    let seconds = seconds.map(|seconds| seconds.parse::<f64>().expect("seconds")).sum();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
    (report["plan"].clone(), seconds)
}

/// The seconds of a plan.
fn seconds(plan: &serde_json::Value, part: &str) -> f64 {
    plan["time"][part].as_f64().unwrap_or_else(|| panic!("{part}: {plan}"))
}

#[test]
fn help_needs_no_scene() {
    let help = command::run(&["render", "--skip", "help"]);
    help.code(0).stdout_eq(str![[r#"
parts of --skip, separated by commas:
  used               drop lights without effect, and compile the shader for the
                     kinds of light that are left
  gates[=STEPS]      count the work saved if the shader skipped lights and
                     highlights that contribute exactly zero; with STEPS also
                     highlights below STEPS/255
  tiles[=PIXELS]     a list of lights for each tile of the picture, exact;
                     default 8 pixels
  budget=STEPS       drop lights that together contribute at most STEPS/255 to
                     any fragment, by the bounds of the lighting model
  budget-srgb=STEPS  as `budget`, for an sRGB target
  always             apply parts even where they cost more than they save

"#]]);
    let missing = command::run(&["render", "--skip", SCENE]);
    missing.code(2).stdout_eq("").stderr_eq(str![[r#"
error[cannot-run]: `SCENE.json` is missing
  |
  = help: the scene is first, since `--skip` takes a value: `landfall render SCENE.json --skip`


"#]]);
}

/// Processor time that a plan takes and does not say would be missing from what is not its own:
/// reading and rasterising the scene, which a command takes as long without the plan.
#[test]
fn a_plan_whose_cost_is_not_counted_is_caught() {
    let folder = Place::new("render-skip-time");
    let shader = std::fs::canonicalize(SHADER).expect("a shader of ours");
    let one_place = folder.path("one_place.json");
    std::fs::write(&one_place, lights_at_one_place(&shader)).expect("written");
    let other = |scene: &str, size: &str, parts: &str| {
        let (plan, whole) = planned(scene, size, &["--skip", parts]);
        let said = seconds(&plan, "total") + seconds(&plan, "checking");
        println!("{parts}: {whole:.3} s, of which it says {said:.3}");
        (whole - said, whole)
    };
    // Where lights are at one place, nearly all of the time is that of planning; by the budget, that
    // of measuring.
    let budget = "tiles=8,budget=0.5,always";
    for (scene, size, parts) in [
        (&one_place[..], "1280x720", &["tiles=8,always", "tiles=8"][..]),
        (SCENE, "320x180", &[budget]),
    ] {
        for parts in parts {
            // A busy machine adds to the time of either now and then; what is not counted is missing each time.
            let unsaid = |_| {
                // It leaves out nothing, and lights everything.
                let (without, _) = other(scene, size, "used");
                let (with, whole) = other(scene, size, parts);
                with - without - (0.04 + 0.04 * whole)
            };
            let is_said = (0..5).map(unsaid).any(|beyond| beyond <= 0.0);
            assert!(is_said, "{parts}: time is missing from what is said");
        }
    }
}

/// A scene of a plane with lights at its middle, which reach a few pixels.
fn lights_at_one_place(shader: &std::path::Path) -> String {
    let light = |number: u32| {
        let x = f64::from(number) * 0.01;
        serde_json::json!({"position": [x, 0.3, 0], "color": 1, "intensity": 1, "range": 0.5})
    };
    let lights: Vec<serde_json::Value> = (0..24).map(light).collect();
    serde_json::json!({
        "name": "one place", "size": [64, 36], "shader": shader,
        "camera": {"position": [0, 15, 40], "target": [0, 0, 0], "fov": 55},
        "materials": [{"name": "floor", "diffuse": 0.5, "specular": 0.2, "shininess": 32}],
        "objects": [{"mesh": "plane", "material": "floor", "scale": [120, 1, 120]}],
        "lights": {"point": lights},
    })
    .to_string()
}

#[test]
fn exact_parts_that_pay_are_applied_and_change_no_bit() {
    let folder = Place::new("render-skip");
    let picture = |name: &str, more: &[&str]| {
        let path = folder.path(name);
        let arguments = ["render", SCENE, "--size", "320x180", "--out", &path, "--details"];
        let start = if more.is_empty() { 6 } else { 7 };
        let ran = command::run(&[&arguments[..start], more].concat());
        assert_eq!(ran.code, 0, "{}", ran.err);
        (folder.bytes(name), ran.out)
    };
    let (all, _) = picture("all.pfm", &[]);
    for (name, parts) in [("own.pfm", &["--skip"][..]), ("tiles.pfm", &["--skip", "tiles=16"])] {
        let (some, said) = picture(name, parts);
        assert!(some == all, "{parts:?}");
        assert!(said.contains("exact: the shader's code was shown"), "{said}");
        assert!(said.contains("without skipping, estimated from"), "{said}");
        assert!(!said.contains("checked"), "{said}");
    }
    // Six lights without a range are not worth planning.
    let few =
        ["render", "shaders/scenes/six_lights.json", "--size", "80x60", "--details", "--skip"];
    let few = command::run(&few);
    few.code(0);
    assert!(few.out.contains("not applied: fewer than 8 lights have a range"), "{}", few.out);
}

/// The light of one pixel is not in the model, and no sample would meet it.
#[test]
fn a_shader_that_adds_light_at_one_pixel_is_measured_at_every_fragment() {
    let folder = Place::new("render-skip-pixel");
    let text = std::fs::read_to_string(SHADER).expect("a shader of ours");
    let loops = "sum += point_light(pointLights[i], FragPos, normal, viewDir);";
    let more = "if (int(gl_FragCoord.x) == 33 && int(gl_FragCoord.y) == 10) sum += vec3(0.01);";
    assert!(text.contains(loops), "the loop over point lights");
    let shader = folder.path("pixel.frag");
    std::fs::write(&shader, text.replace(loops, &format!("{loops} {more}"))).expect("written");
    let arguments =
        ["render", SCENE, "--shader", &shader, "--size", "96x54", "--details", "--skip"];
    for (parts, code) in [("tiles=8,always", 1), ("budget=0.5", 0)] {
        let ran = command::run(&[&arguments[..], &[parts]].concat());
        assert_eq!(ran.code, code, "{parts}: {}{}", ran.out, ran.err);
        assert!(ran.out.contains("not applied: without these lights"), "{}", ran.out);
        // 1,024 lights of 0.01, less those of the pixel's tile.
        let steps = ran.out.split("differs by up to ").nth(1).and_then(|r| r.split(' ').next());
        let steps: f64 = steps.and_then(|steps| steps.parse().ok()).unwrap_or_default();
        assert!((2000.0..2612.0).contains(&steps), "{}", ran.out);
    }
    let alone = command::run(&arguments);
    alone.code(0);
    assert!(alone.out.contains("  tiles=8  not applied: "), "{}", alone.out);
}

#[test]
fn a_plan_that_the_shader_contradicts_is_not_applied() {
    let folder = Place::new("render-contradicted");
    let windowed = std::fs::read_to_string("shaders/many_lights/windowed.wgsl");
    let windowed = windowed.expect("it is there");
    let shader = folder.path("longer.wgsl");
    let longer = windowed
        .replace(
            "let s = d2 / max(range * range, 1.0e-30);",
            "let s = d2 / max(1.44 * range * range, 1.0e-30);",
        )
        .replace("d2 >= light.range * light.range", "d2 >= 1.44 * light.range * light.range");
    assert_ne!(longer, windowed);
    std::fs::write(&shader, longer).expect("it is written");
    let arguments =
        ["render", SCENE, "--shader", &shader, "--size", "32x18", "--details", "--skip"];
    let told = command::run(&[&arguments[..], &["tiles=4,always"]].concat());
    assert_eq!(told.code, 1, "{}{}", told.out, told.err);
    let plan: Vec<&str> = told.out.lines().skip_while(|l| !l.starts_with("plan")).collect();
    golden().eq(plan.join("\n"), str![[r#"
plan  346 fragments, 354,304 light evaluations instead of 354,304
  1 draw
  tiles=4  not applied: without these lights the shader's result changes by 0.85 steps, more than the permitted 0.00
    3,986 tests of a light against a region
  checked  differs by up to 0.85 steps of 1/255 from the picture with all lights, at all 346 fragments of this backend
  time  [..] from the start of planning to the picture: [..] planning, [..] lighting
        [..] of the [..] without skipping, measured
"#]]);
    golden().eq(&told.err, str![[r#"
warning[bind]: skipping changes the picture by 0.85 steps of 1/255, more than the plan's bound: the shader does not compute the model inferred from its members, and nothing is skipped; name its model with `--model`


"#]]);
}
