//! Functions called by the drivers over many lanes: the words that go in are those the function
//! sees, in every lane, wherever they stand for.
//!
//! Needs drivers (Debian packages `mesa-vulkan-drivers`, `libvulkan1`, `libegl1` and
//! `libgl1-mesa-dri`); a missing one fails.

use snapbox::str;

use crate::support::backends;
use crate::support::command::golden;

use std::path::Path;
use std::time::Duration;

use backends::with_readers;
use landfall_exec::backend::{Backend, Failure};
use landfall_exec::harness::call::kernel::KernelResult;
use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_exec::harness::call::{Request, call};
use landfall_interp::{Precision, Settings};
use landfall_layout::{Options, Source};
use serde_json::json;

const LIMIT: Duration = Duration::from_secs(120);

fn pure(name: &str, text: &str, function: &str) -> PureFunction {
    let request = PureRequest { function: function.to_string(), ..PureRequest::default() };
    let made = PureFunction::new(&Source::new(name, text), &Options::default(), &request);
    made.unwrap_or_else(|refusal| panic!("{:?}\n{text}", refusal.found))
}

/// Columns of random words, floats among them that lose nothing when halved.
fn columns(pure: &PureFunction, lanes: usize, seed: u64) -> Vec<Vec<u64>> {
    use landfall_layout::shape::ScalarKind;
    let mut random = fastrand::Rng::with_seed(seed);
    let scalars = pure.parameters.iter().flat_map(|parameter| parameter.ty.scalars());
    let columns = scalars.map(|scalar| {
        let mut word = || match (scalar.kind, scalar.width) {
            (ScalarKind::Bool, _) => u64::from(random.bool()),
            (ScalarKind::Float, 8) => random.f64().to_bits(),
            (ScalarKind::Float, _) => {
                let sign = if random.bool() { -1.0 } else { 1.0 };
                u64::from((sign * f32::from_bits(random.u32(0x3000_0000..0x4f00_0000))).to_bits())
            }
            (_, 8) => random.u64(..),
            _ => u64::from(random.u32(..)),
        };
        (0..lanes).map(|_| word()).collect()
    });
    columns.collect()
}

fn on(
    backend: &mut dyn Backend,
    pure: &PureFunction,
    columns: &[Vec<u64>],
    lanes: usize,
) -> Result<KernelResult, Failure> {
    let driven = pure.on(backend.device())?;
    driven.call(backend, columns, lanes, LIMIT)
}

/// Calls it on the backends named, and gives each the columns and what came back.
fn each(
    pure: &PureFunction,
    names: &[&str],
    lanes: usize,
    mut judge: impl FnMut(&str, &[Vec<u64>], &KernelResult),
) {
    let columns = columns(pure, lanes, 5);
    with_readers(|backends| {
        let mut asked = 0;
        for backend in backends.iter_mut().filter(|r| names.contains(&r.device().backend.name())) {
            let name = backend.device().backend.name();
            let called = on(backend.as_mut(), pure, &columns, lanes);
            let called = called.unwrap_or_else(|failure| panic!("{name}: {failure}"));
            for result in &called.results {
                assert!(result.iter().all(|column| column.len() == lanes), "{name}");
            }
            assert_eq!(called.discarded.len(), lanes, "{name}");
            judge(name, &columns, &called);
            asked += 1;
        }
        assert_eq!(asked, names.len());
    });
}

const ALL: [&str; 3] = ["cpu", "gl", "gpu"];

fn float(word: u64) -> f32 {
    f32::from_bits(word as u32)
}

#[test]
fn a_half_is_exact_in_every_lane_of_several_jobs() {
    let pure = pure(
        "half.frag",
        "#version 450\nfloat f(float x) { return x * 0.5; }\nvoid main() {}\n",
        "f",
    );
    // Not a multiple of any group or row, and more than a job takes.
    each(&pure, &ALL, 70_001, |name, columns, called| {
        for (lane, word) in columns[0].iter().enumerate() {
            let halved = called.results[0][0][lane];
            assert_eq!(float(halved), float(*word) * 0.5, "{name}, lane {lane}");
        }
    });
}

/// Gives back all it reads: the words that come out are those that went in.
fn echoed(pure: &PureFunction, names: &[&str]) {
    each(pure, names, 300, |name, columns, called| {
        let back: Vec<&Vec<u64>> = called.results.iter().flatten().collect();
        assert_eq!(back.len(), columns.len(), "{name}: {:?}", pure.parameters);
        for (nth, (given, back)) in columns.iter().zip(back).enumerate() {
            assert_eq!(given, back, "{name}, scalar {nth}");
        }
        assert!(!called.discarded.contains(&true), "{name}");
    });
}

#[test]
fn arguments_of_every_shape_come_back_as_they_went() {
    let text = "#version 450
struct Inner { bool lit; ivec2 cells; };
struct Light { vec3 color; float power[6]; Inner inner[2]; mat2x3 turn; };
struct All { Light light; uint count; dvec2 far; bvec3 which; mat3 normal; };
All f(Light light, uint count, dvec2 far, bvec3 which, mat3 normal) {
    return All(light, count, far, which, normal);
}
void main() {}
";
    echoed(&pure("shapes.frag", text, "f"), &ALL);
}

#[test]
fn out_parameters_come_back_after_the_result() {
    let text = "#version 450
float f(inout vec2 a, out int b, in int c) { b = c; float d = a.x; a = a.yx; return d; }
void main() {}
";
    each(&pure("outs.frag", text, "f"), &ALL, 100, |name, columns, called| {
        let [result, a, b] = &called.results[..] else { panic!("{name}") };
        assert_eq!(result[0], columns[0], "{name}");
        assert_eq!((&a[0], &a[1]), (&columns[1], &columns[0]), "{name}");
        assert_eq!(b[0], columns[2], "{name}");
    });
}

#[test]
fn members_of_blocks_are_given_however_they_are_stored() {
    let text = "#version 450
struct Light { vec3 position; bool on; };
layout(std140, row_major, binding = 0) uniform Named { mat3 turn; Light lights[6]; bvec2 which; } named;
layout(std430, binding = 1) readonly buffer Bare { mat2x3 bend; float gain[3]; int steps; };
struct All { mat3 turn; Light lights[6]; bvec2 which; mat2x3 bend; float gain[3]; int steps; };
All f() { return All(named.turn, named.lights, named.which, bend, gain, steps); }
void main() {}
";
    let pure = pure("blocks.frag", text, "f");
    each(&pure, &ALL, 200, |name, columns, called| {
        let back = &called.results[0];
        // `turn` is stored by rows; the result is by columns. Bools are stored as numbers.
        for (column, row) in (0..3).flat_map(|c| (0..3).map(move |r| (c, r))) {
            assert_eq!(back[column * 3 + row], columns[row * 3 + column], "{name} {column} {row}");
        }
        let bools: Vec<usize> = (0..6).map(|light| 9 + light * 4 + 3).chain([33, 34]).collect();
        for at in 9..columns.len() {
            let same = back[at].iter().zip(&columns[at]).all(|(back, given)| {
                if bools.contains(&at) { *back == u64::from(*given != 0) } else { back == given }
            });
            assert!(same, "{name}, scalar {at}");
        }
        assert_eq!(back.len(), columns.len(), "{name}");
    });
}

#[test]
fn inputs_of_every_stage_are_given() {
    let fragment = |head: &str, input: &str| {
        format!(
            "{head}\n{input} vec3 v_normal;\n{input} vec2 v_uv;\nuniform float gain;\n\
             struct All {{ vec2 p; vec2 uv; vec3 normal; float gain; }};\n\
             vec3 again = v_normal;\n\
             All f() {{ return All(gl_FragCoord.yx, v_uv, again, gain); }}\n\
             void main() {{ All all = f(); {} = vec4(all.p, all.uv.x, all.normal.x * all.gain); }}\n",
            if input == "in" { "color" } else { "gl_FragColor" }
        )
    };
    let texts = [
        ("old.frag", fragment("#version 120", "varying")),
        ("new.frag", fragment("#version 330\nout vec4 color;", "in")),
        (
            "es.frag",
            fragment("#version 100\nprecision highp float;", "varying")
                .replace("vec3 again = v_normal;", "")
                .replace("again", "v_normal"),
        ),
        (
            "es3.frag",
            fragment("#version 300 es\nprecision highp float;\nout vec4 color;", "in")
                .replace("vec3 again = v_normal;", "")
                .replace("again", "v_normal"),
        ),
        (
            "a.vert",
            "#version 450\nlayout(location = 0) in vec3 a;\nlayout(location = 1) in ivec2 b;\n\
             struct All { vec3 a; ivec2 b; int id; };\n\
             All f() { return All(a, b, gl_VertexID); }\n\
             void main() { All all = f(); gl_Position = vec4(all.a, all.b.x + all.id); }\n"
                .to_string(),
        ),
        (
            "a.comp",
            "#version 450\nlayout(local_size_x = 4, local_size_y = 3) in;\n\
             layout(std430) buffer To { uvec3 to; };\n\
             uvec3 f() { return gl_GlobalInvocationID.zyx; }\nvoid main() { to = f(); }\n"
                .to_string(),
        ),
    ];
    for (name, text) in &texts {
        let pure = pure(name, text, "f");
        assert!(!pure.parameters.is_empty(), "{name}");
        // By what their names say, not by where they stand.
        let mut before = Vec::new();
        let mut next = 0;
        for parameter in &pure.parameters {
            before.push((parameter.path.clone(), next));
            next += parameter.scalars.len();
        }
        let first = |path: &str| {
            let found = before.iter().find(|(known, _)| known == path);
            found.unwrap_or_else(|| panic!("{name}: no {path} in {before:?}")).1
        };
        each(&pure, &ALL, 500, |backend, columns, called| {
            let wanted: Vec<usize> = match *name {
                "a.vert" => {
                    let (a, b) = (first("a"), first("b"));
                    vec![a, a + 1, a + 2, b, b + 1, first("gl_VertexID")]
                }
                "a.comp" => [2, 1, 0].map(|i| first("gl_GlobalInvocationID") + i).to_vec(),
                _ => {
                    let (p, uv) = (first("gl_FragCoord"), first("v_uv"));
                    let n = first("v_normal");
                    vec![p + 1, p, uv, uv + 1, n, n + 1, n + 2, first("gain")]
                }
            };
            for (nth, at) in wanted.into_iter().enumerate() {
                assert_eq!(called.results[0][nth], columns[at], "{name}, {backend}, scalar {nth}");
            }
        });
    }
}

#[test]
fn constants_keep_their_values_and_old_outputs_come_back() {
    let constant = "#version 450\nlayout(constant_id = 3) const int N = 4;\n\
                    float f(float x) { return x * float(N); }\nvoid main() {}\n";
    each(&pure("constant.frag", constant, "f"), &ALL, 100, |name, columns, called| {
        for (back, given) in called.results[0][0].iter().zip(&columns[0]) {
            assert_eq!(float(*back), float(*given) * 4.0, "{name}");
        }
    });
    for head in ["", "#version 100\nprecision highp float;\n"] {
        let text = format!("{head}varying vec4 v;\nvoid main() {{ gl_FragColor = v.wzyx; }}\n");
        each(&pure("old.frag", &text, "main"), &ALL, 100, |name, columns, called| {
            let back = &called.results[0];
            assert!(back.iter().rev().eq(columns), "{name}");
        });
    }
}

#[test]
#[ignore = "drivers compile for a minute: ./tests/run exec"]
fn blocks_of_hundreds_of_lights_compile_within_seconds() {
    let text = "#version 450
struct Light { vec3 position; float range; vec3 color; int kind; mat3 turn; };
layout(std140, binding = 0) uniform Lights { Light lights[150]; int count; } all;
vec4 f(int i) { Light one = all.lights[clamp(i, 0, 149)];
    return vec4(one.turn[1] * 0.0 + one.color, float(one.kind & 255)); }
void main() {}
";
    let pure = pure("lights.frag", text, "f");
    // A value of all lights at once, taken apart word by word, keeps Mesa busy past the limit of a
    // job; and lavapipe (Mesa 22.3.6) more than 32 of them, however they are read.
    each(&pure, &["cpu", "gl"], 40, |name, columns, called| {
        let index = columns.len() - 1;
        let place = |path: &str| {
            let scalars = pure.parameters.iter().flat_map(|parameter| &parameter.scalars);
            scalars.enumerate().find(|(_, known)| *known == path).expect("it is a scalar").0
        };
        let given = if place("i") == 0 { 0 } else { index };
        for (lane, word) in columns[given].iter().enumerate() {
            let nth = (*word as u32 as i32).clamp(0, 149);
            let color = place(&format!("all.lights[{nth}].color.x"));
            assert_eq!(called.results[0][0][lane], columns[color][lane], "{name}, {lane}");
            let kind = columns[place(&format!("all.lights[{nth}].kind"))][lane] & 255;
            assert_eq!(float(called.results[0][3][lane]), kind as f32, "{name}, {lane}");
        }
    });
}

#[test]
fn a_lane_that_discards_gives_nothing_and_is_named() {
    let text = "#version 330\nuniform sampler2D tex;\nout vec4 color;
float f(float x, vec2 uv) { if (x < 0.0) discard; return x * texture(tex, uv).g; }
void main() { color = vec4(f(1.0, vec2(0.0))); }
";
    each(&pure("discards.frag", text, "f"), &["gl", "gpu"], 1000, |name, columns, called| {
        for (lane, word) in columns[0].iter().enumerate() {
            let x = float(*word);
            assert_eq!(called.discarded[lane], x < 0.0, "{name}, lane {lane}");
            let wanted = if x < 0.0 { 0.0 } else { x };
            assert_eq!(float(called.results[0][0][lane]), wanted, "{name}, lane {lane}");
        }
    });
}

#[test]
fn what_a_function_of_no_result_writes_comes_back() {
    let text = "#version 330\nin vec2 v_uv;\nlayout(location = 0) out vec4 color;\nvec2 seen;
void main() { seen = v_uv.yx; color = vec4(v_uv, seen); }
";
    let pure = pure("writes.frag", text, "main");
    let nth = |name: &str| pure.results.iter().position(|r| r.name == name).expect("it is written");
    each(&pure, &ALL, 100, |name, columns, called| {
        assert_eq!(called.results[nth("seen")][0], columns[1], "{name}");
        for (row, at) in [0, 1, 1, 0].into_iter().enumerate() {
            assert_eq!(called.results[nth("color")][row], columns[at], "{name}, {row}");
        }
    });
}

#[test]
fn wgsl_runs_by_whoever_takes_modules() {
    let text = "struct In { @builtin(position) at: vec4f, @location(0) uv: vec2f }
struct B { turn: mat2x2f, n: u32 }
@group(1) @binding(3) var<uniform> b: B;
@group(0) @binding(0) var t: texture_2d<f32>;
@group(0) @binding(1) var s: sampler;
@fragment fn shade(in: In) -> @location(0) vec4f {
    let one = textureSample(t, s, in.uv).r;
    return vec4f(b.turn[1] * one, in.uv.y, f32(b.n >> 8u));
}
";
    let pure = pure("shade.wgsl", text, "shade");
    each(&pure, &["cpu", "gpu"], 400, |name, columns, called| {
        let mut next = 0;
        let mut first = std::collections::HashMap::new();
        for parameter in &pure.parameters {
            first.insert(parameter.path.as_str(), next);
            next += parameter.scalars.len();
        }
        let (turn, n) = (first["b.turn"], first["b.n"]);
        for (back, at) in called.results[0].iter().zip([turn + 2, turn + 3, 5]) {
            assert_eq!(*back, columns[at], "{name}");
        }
        for (lane, word) in columns[n].iter().enumerate() {
            let wanted = (*word as u32 >> 8) as f32;
            assert_eq!(float(called.results[0][3][lane]), wanted, "{name}");
        }
    });
    with_readers(|backends| {
        let gl = backends
            .iter()
            .find(|backend| backend.device().backend.name() == "gl")
            .expect("it is here");
        let refused = pure.on(gl.device()).expect_err("OpenGL has no WGSL");
        golden().eq(refused.message, str!["OpenGL does not accept WGSL"]);
    });
}

#[test]
fn small_floats_and_long_integers_keep_their_values() {
    let text = "enable f16;
fn f(a: f16, b: vec2<f16>, c: u64, d: i64) -> f16 { return a * 2.0h + b.y; }
@compute @workgroup_size(1) fn main() {}
";
    let pure = pure("small.wgsl", text, "f");
    // Small numbers: halves of whole ones, whose sums a half holds.
    let lanes = 100;
    let word = |x: f32| u64::from(x.to_bits());
    let columns: Vec<Vec<u64>> = vec![
        (0..lanes).map(|i| word(i as f32 / 2.0)).collect(),
        vec![0; lanes],
        (0..lanes).map(|i| word(i as f32 / -4.0)).collect(),
        vec![u64::MAX; lanes],
        vec![1; lanes],
    ];
    with_readers(|backends| {
        for backend in backends.iter_mut().filter(|backend| backend.device().backend.name() != "gl")
        {
            let name = backend.device().backend.name();
            let called = on(backend.as_mut(), &pure, &columns, lanes);
            let called = called.unwrap_or_else(|failure| panic!("{name}: {failure}"));
            for (lane, back) in called.results[0][0].iter().enumerate() {
                assert_eq!(float(*back), lane as f32 * 0.75, "{name}, {lane}");
            }
        }
    });
}

#[test]
fn a_block_of_bytes_is_refused_by_name_where_it_cannot_be_given() {
    let text = "#version 450
#extension GL_EXT_scalar_block_layout : require
layout(scalar, binding = 0) uniform Tight { vec3 a; float b[3]; vec3 c; } tight;
vec3 f() { return tight.a + tight.b[1] + tight.c; }
void main() {}
";
    let pure = pure("tight.frag", text, "f");
    let words = pure.parameters.iter().any(|parameter| parameter.path.contains("words"));
    assert!(words, "it is given by member: {:?}", pure.parameters);
    with_readers(|backends| {
        for backend in backends.iter_mut() {
            let name = backend.device().backend.name();
            let columns = columns(&pure, 10, 1);
            match (name, on(backend.as_mut(), &pure, &columns, 10)) {
                ("gl", Err(failure)) => {
                    golden().eq(failure.message, str!["OpenGL: `Tight` has a byte layout that cannot be filled member by member; set it with --data"]);
                }
                ("gl", Ok(_)) => panic!("it has no way to give it"),
                (_, called) => {
                    called.unwrap_or_else(|failure| panic!("{name}: {failure}"));
                }
            }
        }
    });
}

#[test]
fn a_light_of_a_seed_shader_is_what_the_evaluator_makes_of_it() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/seed/caster_spot_soft_330.frag");
    let text = std::fs::read_to_string(path).expect("the shader is there");
    let pure = pure("caster_spot_soft_330.frag", &text, "main");
    let lanes = 2000;
    // Numbers of scenes: positions within 8, colours and cosines within 1.
    let mut random = fastrand::Rng::with_seed(3);
    let mut columns = Vec::new();
    for path in pure.parameters.iter().flat_map(|parameter| &parameter.scalars) {
        let large = ["FragPos", "osition", "viewPos"].iter().any(|part| path.contains(part));
        let (low, high) = if large { (-8.0, 8.0) } else { (0.1, 0.9) };
        let word =
            |random: &mut fastrand::Rng| u64::from((low + (high - low) * random.f32()).to_bits());
        columns.push((0..lanes).map(|_| word(&mut random)).collect::<Vec<u64>>());
    }
    let settings = Settings { precision: Precision::Both, ..Settings::default() };
    let truth = pure.call(&columns, lanes, &settings).expect("it runs");
    with_readers(|backends| {
        for backend in backends {
            let name = backend.device().backend.name();
            let called = on(backend.as_mut(), &pure, &columns, lanes);
            let called = called.unwrap_or_else(|failure| panic!("{name}: {failure}"));
            let (mut lit, mut far) = (0, 0);
            for lane in 0..lanes {
                let doubles = &truth.results[0].doubles;
                lit += usize::from(doubles[0][lane] > 1.0 / 255.0);
                for (single, double) in called.results[0].iter().zip(doubles).take(3) {
                    let apart = f64::from(float(single[lane])) - double[lane];
                    far += usize::from(apart.abs() > 0.1 / 255.0);
                }
            }
            assert!(lit > lanes / 10, "{lit} of {lanes} lanes are lit");
            assert_eq!(far, 0, "{name}");
        }
    });
}

/// What one call gives, by the backend of that name.
fn called(backend: &str, path: &str, text: &str, request: &Request) -> Vec<f32> {
    with_readers(|backends| {
        let backend =
            backends.iter_mut().find(|r| r.device().backend.name() == backend).expect("it is here");
        let source = Source::new(path, text);
        let report = call(&source, &Options::default(), request, Some(backend.as_mut()));
        let report = report.unwrap_or_else(|refusal| panic!("{path}: {:?}", refusal.found));
        let given = report.result.into_iter().chain(report.parameters.into_iter().map(|p| p.2));
        given.flat_map(|given| given.scalars).map(|scalar| float(scalar.value.bits)).collect()
    })
}

fn request(function: &str, arguments: serde_json::Value) -> Request {
    let arguments = arguments.as_array().expect("a list").clone();
    let limit = Duration::from_secs(20);
    Request { function: function.to_string(), arguments, limit, ..Request::default() }
}

#[test]
fn what_one_call_is_given_does_not_differ_between_neighbouring_pixels() {
    let text = "#version 450
layout(binding = 0) readonly buffer B { float s; };
float f(float a, float b) { return dFdx(a) + fwidth(b) + dFdy(s) + b; }
void main() {}
";
    let data = json!({"B": {"s": 5}}).as_object().expect("an object").clone();
    let request = Request { data, ..request("f", json!([3, 7])) };
    for backend in ["gl", "gpu"] {
        assert_eq!(called(backend, "slope.frag", text, &request), [7.0], "{backend}");
    }
}

#[test]
fn globals_that_begin_with_what_an_input_gives_are_computed_from_it() {
    let text = "#version 450
layout(location = 0) in vec3 v;
float later();
float before() { return v.z * 0.5; }
vec3 n = v * 2.0; vec3 k = n * 2.0;
vec3 p = v * 4.0, q = p * 2.0; float both[] = float[](q.x, v.y), last[1] = { v.z };
float calls = before(); float waits = later();
float later() { return v.x; }
struct All { vec3 n; vec3 k; vec3 p; vec3 q; float both[2]; float last[1]; float calls; float waits; };
All f() { return All(n, k, p, q, both, last, calls, waits); }
void main() {}
";
    let pure = pure("late.frag", text, "f");
    each(&pure, &ALL, 100, |name, columns, called| {
        for lane in 0..100 {
            let v = [0, 1, 2].map(|row| float(columns[row][lane]));
            let scaled = [2.0, 4.0, 4.0, 8.0].into_iter().flat_map(|by| v.map(|v| v * by));
            let rest = [v[0] * 8.0, v[1], v[2], v[2] * 0.5, v[0]];
            let wanted: Vec<f32> = scaled.chain(rest).collect();
            let back: Vec<f32> = called.results[0].iter().map(|all| float(all[lane])).collect();
            assert_eq!(back, wanted, "{name}, lane {lane}");
        }
    });
}

#[test]
#[ignore = "drivers compile for a minute: ./tests/run exec"]
fn arrays_that_are_written_come_back_within_seconds() {
    let text = "#version 450
void f(float x, out float a[400]) { for (int i = 0; i < 400; i++) a[i] = x + float(i); }
void main() {}
";
    for backend in ["gl", "gpu"] {
        let back = called(backend, "arrays.frag", text, &request("f", json!([3])));
        let wanted: Vec<f32> = (0..400).map(|i| 3.0 + i as f32).collect();
        assert_eq!(back, wanted, "{backend}");
    }
}

#[test]
fn derivatives_are_refused_where_every_pixel_would_write_a_buffer() {
    let text = "#version 450\nlayout(binding = 0) buffer B { int n; };\n\
                float f(float a) { n = 1; return dFdx(a); }\nvoid main() {}\n";
    with_readers(|backends| {
        for backend in
            backends.iter_mut().filter(|backend| backend.device().backend.name() != "cpu")
        {
            let source = Source::new("counts.frag", text);
            let data = json!({"B": {"n": 2}}).as_object().expect("an object").clone();
            let given = Request { data, ..request("f", json!([1])) };
            let report = call(&source, &Options::default(), &given, Some(backend.as_mut()));
            let found = report.expect_err("every pixel writes").found;
            golden().eq(found[0].message.clone(), str!["[..]: `f(float)` takes derivatives, so each sample runs on a quad of pixels, and each pixel would write its buffer or image; name the function that takes the derivatives"]);
        }
    });
}

#[test]
fn a_binding_next_to_the_last_leaves_room_for_the_words() {
    let text = |binding: u32| {
        format!(
            "#version 450\nlayout(binding = {binding}) uniform B {{ float x; }} b;\n\
             float f(float a) {{ return a + b.x; }}\nvoid main() {{}}\n"
        )
    };
    let data = json!({"B": {"x": 2}}).as_object().expect("an object").clone();
    let request = Request { data, ..request("f", json!([3])) };
    // wgpu has 1024 in a group at most.
    assert_eq!(called("gpu", "late.frag", &text(1000), &request), [5.0]);
    with_readers(|backends| {
        let gpu =
            backends.iter_mut().find(|r| r.device().backend.name() == "gpu").expect("it is here");
        let source = Source::new("last.frag", text(u32::MAX));
        let report = call(&source, &Options::default(), &request, Some(gpu.as_mut()));
        let found = report.expect_err("wgpu has no such binding").found;
        golden().eq(found[0].message.clone(), str!["gpu: wgpu rejects the bindings: Binding index 4294967295 is greater than the maximum number 1024"]);
    });
}

#[test]
fn a_group_is_as_large_as_any_of_its_sides_says() {
    let text = "#version 450\nlayout(local_size_y = 4) in;\n\
                float f(float x) { return x * 0.5; }\nvoid main() {}\n";
    each(&pure("side.comp", text, "f"), &ALL, 100, |name, columns, called| {
        for (back, given) in called.results[0][0].iter().zip(&columns[0]) {
            assert_eq!(float(*back), float(*given) * 0.5, "{name}");
        }
    });
}
