//! Whole scenes with a hazard in them: lit by both forms of a shader on every backend and held
//! against the reference.
//!
//! A scene of a row is laid over `scenes/floor.json`: a grey floor, seen from 6 above through
//! 16 by 12 pixels of edge 1, so that the middle of each is a half in `f32`.

use landfall_exec::backend::Backend;
use landfall_interp::{Cpu, Settings};
use landfall_layout::{Error, Language, Options, Source};
use landfall_light::bind::{BindError, OverflowPolicy};
use landfall_light::picture::Transfer;
use landfall_light::picture::compare::{Compare, compare};
use landfall_light::render::tally::Tally;
use landfall_light::render::truth::Truth;
use landfall_light::render::{Draw, RenderError, RenderOptions, Rendered, Renderer};
use landfall_light::scene::{Reading, read};
use landfall_light::{Frame, FrameOptions, Scene, Upload, VertexNormals};
use serde_json::Value;

use super::backends::with_readers;
use super::{list, rows, text};
use crate::made::Made;
use crate::support::sample::{everything, sampled};

const FLOOR: &str = include_str!("../../hazards/scenes/floor.json");

/// A scene as a row has it: members laid over the floor's; `written` is changed in its text
/// afterwards, for what no JSON object can hold.
pub fn written(case: &Value, over: &Value) -> String {
    let mut scene: Value = serde_json::from_str(FLOOR).expect("the floor is JSON");
    for (key, value) in over.as_object().expect("a scene is an object") {
        scene[key] = value.clone();
    }
    let text = scene.to_string();
    match case["written"].as_array().map(Vec::as_slice) {
        Some([Value::String(from), Value::String(to)]) => {
            assert_eq!(text.matches(from.as_str()).count(), 1, "{from} in {text}");
            text.replace(from.as_str(), to)
        }
        _ => text,
    }
}

/// Reads a scene that names no files.
pub fn reading(scene: &str) -> Reading {
    read("row.json", scene, &|name| Err(Error::new(name, "is no file of a row")))
}

/// A shader with what a case says of it.
pub fn renderer(case: &Value, path: &str, scene: &Scene) -> Result<Renderer, RenderError> {
    let source = Source::read(path).expect("the shader is there");
    let mut layout = Options::default();
    let given = |key: &str| {
        let all = case[key].as_object().into_iter().flatten();
        all.map(|(name, value)| (name.clone(), value.as_str().expect("a text").to_string()))
    };
    match source.language {
        Language::Glsl => layout.read.defines = given("defines").collect(),
        Language::Wgsl => layout.read.overrides = given("overrides").collect(),
        Language::SpirV => panic!("a scene has a text"),
    }
    let bind = scene.bind.iter().collect();
    Renderer::new(&source, &RenderOptions { layout, entry: None, bind })
}

fn prepared(case: &Value, over: &Value, normals: VertexNormals) -> Made {
    let reading = reading(&written(case, over));
    let codes: Vec<&str> = reading.diagnostics.iter().map(|found| found.code.name()).collect();
    let warned: Vec<&str> =
        case["warned"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    assert_eq!(codes, warned, "{}: {:?}", text(case, "why"), reading.diagnostics);
    let scene = reading.scene.expect("warnings refuse no scene");
    let frame = Frame::new(&scene, &FrameOptions { normals });
    Made { upload: Upload::new(&scene), scene, frame }
}

fn rendered<R: Backend + ?Sized>(
    made: &Made,
    renderer: &Renderer,
    backend: &mut R,
    after: &mut dyn FnMut(&mut R, usize),
) -> Result<Rendered, RenderError> {
    let lights = renderer.lights(&made.upload, OverflowPolicy::Refuse)?;
    let fragments = made.frame.numbers();
    let draws = [Draw { fragments: &fragments, lights: &lights, tiles: None }];
    renderer.render(backend, &made.work(), &draws, after)
}

fn normals(case: &Value) -> VertexNormals {
    match case["normals"].as_str() {
        None => VertexNormals::Transformed,
        Some("unit") => VertexNormals::Unit,
        Some("unit-of-four") => VertexNormals::UnitOfFour,
        Some(other) => panic!("`{other}` are no normals"),
    }
}

/// A picture, and what the evaluator noted of it; drivers note nothing.
fn picture(made: &Made, renderer: &Renderer, backend: &mut dyn Backend) -> (Rendered, Vec<String>) {
    let fail = |error: RenderError| panic!("{error}");
    if backend.device().backend.name() != "cpu" {
        let rendered = rendered(made, renderer, backend, &mut |_, _| {});
        return (rendered.unwrap_or_else(fail), Vec::new());
    }
    let mut cpu = Cpu::new(Settings { watch: true, ..Settings::default() });
    let mut tally = Tally::default();
    let rendered =
        rendered(made, renderer, &mut cpu, &mut |cpu: &mut Cpu, _| tally.add(&cpu.notes));
    let kinds = tally.undefined.iter().map(|found| format!("{:?}", found.kind)).collect();
    (rendered.unwrap_or_else(fail), kinds)
}

/// What is wrong with a picture, if anything.
fn misfit(
    case: &Value,
    backend: &str,
    truth: &Truth,
    rendered: &Rendered,
    kinds: &[String],
) -> Option<String> {
    let expect = &case["expect"];
    let broken = rendered.picture.non_finite();
    if let Some(hazard) = expect["reference"].as_str() {
        let found: Vec<String> = truth.undefined.keys().map(|undef| format!("{undef:?}")).collect();
        if !found.iter().any(|found| found == hazard) {
            return Some(format!("the reference finds {found:?}, not {hazard}"));
        }
    }
    if text(expect, "class") == "undefined" {
        let wanted = list(expect, "kinds").iter().map(|kind| kind.as_str().expect("a kind"));
        let missing: Vec<&str> = wanted.filter(|w| !kinds.iter().any(|k| k == w)).collect();
        if backend == "cpu" && !missing.is_empty() {
            return Some(format!("{missing:?} is not noted, only {kinds:?}"));
        }
        let least = expect["non_finite"].as_u64().unwrap_or(0);
        return (broken < least).then(|| format!("only {broken} pixels are no number"));
    }
    let besides = expect["besides"].as_array().map_or(&[][..], Vec::as_slice);
    if broken > 0 || kinds.iter().any(|kind| !besides.iter().any(|known| known == kind)) {
        return Some(format!("{broken} pixels are no number; {kinds:?} is noted"));
    }
    if let Some(pixel) = expect["pixel"].as_object() {
        let at = |i: usize| pixel["at"][i].as_u64().expect("a column and a row") as usize;
        let seen = rendered.picture.pixels[at(1) * rendered.picture.width as usize + at(0)];
        let wanted = pixel["value"].as_f64().expect("a grey") as f32;
        if seen[..3].iter().any(|channel| (channel - wanted).abs() > 1e-5) {
            return Some(format!("{seen:?} for {wanted} at {}", pixel["at"]));
        }
    }
    let options = Compare { transfer: Transfer::Linear, leave_out: Some(&truth.leave_out) };
    let held = compare(&truth.picture, &rendered.picture, &options).expect("they are of one size");
    let most = held.linear.max;
    if held.pixels == 0 || !truth.picture.pixels.iter().any(|pixel| pixel[0] > 0.004) {
        Some("there is nothing to compare".to_string())
    } else if expect["within"].as_f64().is_some_and(|within| most > within) {
        Some(format!("{most} steps off at {:?}", held.linear.at))
    } else if expect["beyond"].as_f64().is_some_and(|beyond| most < beyond) {
        Some(format!("only {most} steps off: there is no hazard"))
    } else {
        None
    }
}

/// Lights every scene on one backend; how many pictures that were.
fn lit(backend: &mut dyn Backend) -> usize {
    let name = backend.device().backend.name();
    let (mut pictures, mut wrong) = (0, Vec::new());
    // Drivers compile a program for each.
    let rows = rows();
    for row in sampled(&rows, if name == "cpu" { 1 } else { 5 }) {
        for case in row["scenes"].as_array().into_iter().flatten() {
            if !["undefined", "finite"].contains(&text(&case["expect"], "class")) {
                continue;
            }
            let made = prepared(case, &case["scene"], normals(case));
            let model = serde_json::from_value(case["model"].clone()).expect("a model");
            let truth = match &case["as"] {
                Value::Null if case["normals"].is_null() => made.truth(&model),
                Value::Null => {
                    prepared(case, &case["scene"], VertexNormals::Transformed).truth(&model)
                }
                other => prepared(case, other, VertexNormals::Transformed).truth(&model),
            };
            for path in list(case, "run").iter().map(|path| path.as_str().expect("a file")) {
                if name == "gl" && path.ends_with(".wgsl") {
                    continue;
                }
                let shader = renderer(case, path, &made.scene);
                let shader = shader.unwrap_or_else(|error| panic!("{path}: {error}"));
                let (rendered, kinds) = picture(&made, &shader, backend);
                pictures += 1;
                if let Some(why) = misfit(case, name, &truth, &rendered, &kinds) {
                    let (id, said) = (text(row, "id"), text(case, "why"));
                    wrong.push(format!("{id}, {path}, {name} ({said}): {why}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {pictures} pictures:\n{}", wrong.len(), wrong.join("\n"));
    pictures
}

fn by(name: &str, least: usize) {
    let least = if everything() || name == "cpu" { least } else { least / 10 };
    with_readers(|backends| {
        let backend = backends.iter_mut().find(|backend| backend.device().backend.name() == name);
        let pictures = lit(&mut **backend.expect("every backend is there"));
        assert!(pictures >= least, "{pictures} pictures");
    });
}

/// The refusal of a scene by a shader, if it refuses.
pub fn refused_by(case: &Value, path: &str, scene: &Scene) -> Option<BindError> {
    let shader = match renderer(case, path, scene) {
        Ok(shader) => shader,
        Err(RenderError::Bind(error)) => return Some(error),
        Err(error) => panic!("{path}: {error}"),
    };
    shader.lights(&Upload::new(scene), OverflowPolicy::Refuse).err()
}

#[test]
fn the_evaluator_lights_every_hazard_as_its_row_says() {
    by("cpu", 50);
}

#[test]
fn opengl_lights_every_hazard_as_its_row_says() {
    by("gl", 25);
}

#[test]
fn vulkan_lights_every_hazard_as_its_row_says() {
    by("gpu", 50);
}
