//! `landfall run` from outside: what it prints, and what it says about arguments that do not fit.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// One function of each kind of parameter; `gain` is loose, `scale` is initialised by the shader.
const SHADER: &str = "#version 330
uniform float gain;
uniform sampler2D tex;
in vec3 v_normal;
out vec4 colour;
float scale = 2.5;
struct Light { vec3 color; float power; };
float third(float x) { return x / 3.0; }
float third(int x) { return float(x) / 3.0; }
void split(vec3 v, out float len, inout vec3 dir) { len = length(v); dir = dir * gain * scale; }
vec3 direction(vec3 v) {
    return normalize(v);
}
vec3 lit(Light light, mat2 turn) { return light.color * light.power + turn[1].x * v_normal; }
vec4 look(vec2 uv) { return texture(tex, uv); }
vec3 with(sampler2D t) { return texture(t, vec2(0)).rgb; }
void main() {
    float l; vec3 d = v_normal; split(v_normal, l, d);
    vec3 sum = d + direction(d) + lit(Light(d, l), mat2(1)) + with(tex) + third(1.0) + third(1);
    colour = vec4(sum, 1) + look(vec2(0));
}
";

fn shader(name: &str, text: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_run");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn run(path: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.arg("run").arg(path).args(arguments).env("NO_COLOR", "1");
    command.output().expect("the binary was built for this test")
}

fn ran(path: &Path, arguments: &[&str]) -> String {
    let output = run(path, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

fn refused(path: &Path, arguments: &[&str]) -> String {
    let output = run(path, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// The row of a name: what stands in its columns.
fn row<'t>(text: &'t str, name: &str) -> Vec<&'t str> {
    let rows = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let mut found = rows.filter(|columns| columns.first() == Some(&name));
    let row = found.next().unwrap_or_else(|| panic!("no {name} in\n{text}"));
    row[1..].to_vec()
}

#[test]
fn a_third_is_printed_in_both_precisions_with_its_error() {
    let path = shader("third.frag", SHADER);
    let text = ran(&path, &["--fn", "third(float)", "--args", "[1]"]);
    // 1/3 in f32 is a third of a unit off, in f64 the shortest digits that read back.
    assert_eq!(row(&text, "result"), ["0.33333334", "0.3333333333333333", "0.33"]);
}

#[test]
fn every_reader_gives_back_out_and_inout_parameters() {
    let path = shader("split.frag", SHADER);
    for backend in ["cpu", "gl", "gpu"] {
        let data = r#"{"DefaultBlock": {"gain": 2}}"#;
        let arguments = ["--fn", "split", "--args", "[[3, 4, 0], [1, 2, -3]]", "--data", data];
        let text = ran(&path, &[&arguments[..], &["--backend", backend]].concat());
        // 3-4-5; and each component times gain 2 times scale 2.5.
        assert_eq!(row(&text, "len")[..2], ["5.0", "5.0"], "{backend}");
        for (name, value) in [("dir.x", "5.0"), ("dir.y", "10.0"), ("dir.z", "-15.0")] {
            assert_eq!(row(&text, name), [value, value, "0.00"], "{backend}");
        }
    }
}

#[test]
fn textures_are_white_unless_given_and_inputs_zero_unless_given() {
    let path = shader("assumed.frag", SHADER);
    for backend in ["cpu", "gl", "gpu"] {
        let call = ["--fn", "look", "--args", "[[0, 0]]", "--backend", backend];
        let text = ran(&path, &call);
        assert_eq!(row(&text, "result.y")[0], "1.0", "{backend}");
        assert!(text.contains("`tex` is white"), "{text}");
        let text = ran(&path, &[&call[..], &["--texture", "tex=[1, 0.5, 0.25, 1]"]].concat());
        assert_eq!(row(&text, "result.y")[0], "0.5", "{backend}");
        assert!(!text.contains("white"), "{text}");
    }
    let light = r#"[{"color": [1, 2, 3], "power": 2}, [[0, 0], [1, 0]]]"#;
    for backend in ["cpu", "gl", "gpu"] {
        let text = ran(&path, &["--fn", "lit", "--args", light, "--backend", backend]);
        assert_eq!(row(&text, "result.z")[0], "6.0", "{backend}");
        assert!(text.contains("`v_normal` defaults to zero"), "{text}");
    }
    for backend in ["cpu", "gl", "gpu"] {
        let input = ["--input", "v_normal=[0, 0, 0.5]", "--backend", backend];
        let text = ran(&path, &[&["--fn", "lit", "--args", light][..], &input].concat());
        assert_eq!(row(&text, "result.z")[0], "6.5", "{backend}");
        assert!(!text.contains("v_normal"), "{text}");
    }
}

#[test]
fn an_undefined_operation_is_named_with_its_place() {
    let path = shader("zero.frag", SHADER);
    let output = run(&path, &["--fn", "direction", "--args", "[[0, 0, 0]]"]);
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("normalised zero vector"), "{said}");
    let line = SHADER.lines().position(|line| line.contains("normalize")).unwrap() + 1;
    assert!(said.contains(&format!("zero.frag:{line}:12")), "{said}");
    assert!(said.contains("return normalize(v);"), "{said}");
}

#[test]
fn what_does_not_fit_is_said_with_its_place_in_the_json() {
    let path = shader("misfits.frag", SHADER);
    for (function, arguments, words) in [
        ("direktion", "[]", "did you mean `direction`?"),
        ("direction", "[]", "`direction(vec3)` takes 1 argument, but none was given"),
        ("direction", "[[1, 2]]", "`args[0]` is a `vec3`: expected an array of 3 numbers"),
        ("direction", "[[1, 2, 1e99]]", "`args[0][2]`: 1e+99 does not fit `float`"),
        ("direction", "[[1, 2", "`--args` is not JSON"),
        ("lit", r#"[{"color": [1, 2, "x"], "power": 1}, 0]"#, "`args[0].color[2]` is a `float`"),
        ("lit", r#"[{"color": [1, 2, 3], "powr": 1}, 0]"#, "`args[0].power` is not given"),
        ("third", "[1]", "2 functions `third` take these arguments"),
        ("third(bool)", "[1]", "no function `third` has these parameters"),
        ("with", "[1]", "`t` is a `sampler2D`"),
    ] {
        let said = refused(&path, &["--fn", function, "--args", arguments]);
        assert!(said.contains(words), "{function} {arguments}: {said}");
    }
    let data = r#"{"DefaultBlok": {}}"#;
    let said = refused(&path, &["--fn", "third(int)", "--args", "[1]", "--data", data]);
    assert!(said.contains("did you mean `DefaultBlock`?"), "{said}");
}

#[test]
fn a_loop_without_an_end_is_stopped() {
    let text = "#version 450\nfloat spin(float x) { for (;;) { x += 1.0; if (x < 0.0) break; } \
                return x; }\nvoid main() { spin(1.0); }\n";
    let path = shader("spin.frag", text);
    let said = refused(&path, &["--fn", "spin", "--args", "[1]", "--limit", "2"]);
    assert!(said.contains("loop"), "{said}");
}

#[test]
fn json_holds_to_its_schema() {
    let schema = Command::new(env!("CARGO_BIN_EXE_landfall")).args(["schema", "run"]).output();
    let schema: Value = serde_json::from_slice(&schema.unwrap().stdout).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let path = shader("json.frag", SHADER);
    for arguments in [
        &["--fn", "direction", "--args", "[[0, 0, 0]]"][..],
        &["--fn", "split", "--args", r#"[["nan", "inf", 0], [1, 2, 3]]"#],
        &["--fn", "third(int)", "--args", "[1]", "--backend", "gl"],
    ] {
        let text = ran(&path, &[arguments, &["--format", "json"]].concat());
        let value: Value = serde_json::from_str(&text).unwrap();
        let errors: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{}\n{text}", errors.join("\n"));
        assert!(text.ends_with('\n'));
    }
}

#[test]
fn wgsl_pointers_come_back() {
    let text = "struct B { n: u32, gain: f32 }\n@group(0) @binding(0) var<uniform> b: B;\n\
                fn twice(k: vec2<f32>, to: ptr<function, vec2<f32>>) -> u32 {\n\
                *to = k * 2.0 * b.gain; return b.n; }\n\
                @compute @workgroup_size(1) fn main() { var v: vec2<f32>; _ = twice(v, &v); }\n";
    let path = shader("twice.wgsl", text);
    let data = r#"{"B": {"n": 7, "gain": 0.5}}"#;
    for backend in ["cpu", "gpu"] {
        let text = ran(
            &path,
            &["--fn", "twice", "--args", "[[3, 4], [0, 0]]", "--data", data, "--backend", backend],
        );
        assert_eq!((row(&text, "result")[0], row(&text, "to.y")[0]), ("7", "4.0"), "{backend}");
    }
    let said = refused(&path, &["--fn", "twice", "--args", "[[3, 4], [0, 0]]", "--backend", "gl"]);
    assert!(said.contains("OpenGL does not accept WGSL"), "{said}");
}

#[test]
fn a_call_by_itself_has_no_neighbours_to_differ_from() {
    let text = "#version 330
in vec2 uv;
out vec4 colour;
float slope(float a, float b) { return dFdx(a) + dFdy(b) + fwidth(uv.x) + 5.0; }
void main() { colour = vec4(slope(uv.x, uv.y)); }
";
    let path = shader("slope.frag", text);
    for backend in ["cpu", "gl", "gpu"] {
        let call = ["--fn", "slope", "--args", "[3, 7]", "--input", "uv=[3, 7]"];
        let text = ran(&path, &[&call[..], &["--backend", backend]].concat());
        assert_eq!(row(&text, "result")[0], "5.0", "{backend}");
    }
}

#[test]
fn a_function_that_does_not_run_is_named_with_its_reason_and_line() {
    let text = "#version 330
out vec4 colour;
float again(float x) { return x < 1.0 ? x : again(x - 1.0); }
float through(float x) { return 2.0 * again(x); }
float loose(float x) { return x * undeclared; }
void main() { colour = vec4(1.0); }
";
    let path = shader("left_out.frag", text);
    for (function, words) in [
        ("again", "`again` cannot run: `again` calls itself"),
        ("through", "`through` cannot run: `again` calls itself"),
        ("loose", "`loose` cannot run: "),
    ] {
        let said = refused(&path, &["--fn", function, "--args", "[3]"]);
        assert!(said.contains("error[cannot-call]") && said.contains(words), "{said}");
        assert!(said.contains("left_out.frag:"), "{said}");
    }
    let said = refused(&path, &["--fn", "loose", "--args", "[3]"]);
    assert!(said.contains("`undeclared`") && said.contains("left_out.frag:5"), "{said}");
}

#[test]
fn a_texture_is_given_its_own_colour_and_not_that_of_a_longer_name() {
    let text = "#version 330
uniform sampler2D a;
uniform sampler2D ab;
out vec4 colour;
vec4 both(vec2 uv) { return texture(a, uv) + texture(ab, uv); }
void main() { colour = both(vec2(0)); }
";
    let path = shader("two_textures.frag", text);
    for command in ["run", "stress"] {
        let mut landfall = Command::new(env!("CARGO_BIN_EXE_landfall"));
        landfall.arg(command).arg(&path).args(["--fn", "both", "--texture", "a=[0, 0, 0, 1]"]);
        match command {
            "run" => landfall.args(["--args", "[[0, 0]]"]),
            _ => landfall.args(["--samples", "256"]),
        };
        let output = landfall.env("NO_COLOR", "1").output().unwrap();
        let said =
            String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("`ab` is white"), "{command}: {said}");
    }
}

#[test]
fn half_rounds_each_operation_and_a_driver_refuses_to() {
    let text = "#version 300 es
precision highp float;
out vec4 colour;
mediump float few(mediump float x) { return x + 1.0; }
float grown(float x) { return x * 16.0; }
void main() { colour = vec4(few(1.0), grown(1.0), 0, 1); }
";
    let path = shader("half.frag", text);
    // 2^-12 is a quarter of a unit in the last place of an f16 at 1: the sum is 1.
    let few = ["--fn", "few", "--args", "[0.000244140625]"];
    for (rounding, sum) in
        [(None, "1.0002441"), (Some("--half"), "1.0"), (Some("--mediump"), "1.0")]
    {
        let call: Vec<&str> = few.into_iter().chain(rounding).collect();
        assert_eq!(row(&ran(&path, &call), "result")[0], sum, "{rounding:?}");
    }
    // Above 65,504 an f16 is infinite; `grown` is highp.
    let grown = ["--fn", "grown", "--args", "[5000]"];
    for (rounding, product) in
        [(None, "80000.0"), (Some("--half"), "inf"), (Some("--mediump"), "80000.0")]
    {
        let call: Vec<&str> = grown.into_iter().chain(rounding).collect();
        assert_eq!(row(&ran(&path, &call), "result")[0], product, "{rounding:?}");
    }
    let said = refused(&path, &[&grown[..], &["--half", "--backend", "gl"]].concat());
    assert!(said.contains("`--backend gl` cannot round to f16"), "{said}");
}

#[test]
fn members_of_a_block_of_inputs_have_values_on_every_reader() {
    let text = "#version 330
in Stage { vec2 uv; float w; } stage;
in Bare { float bare; };
out vec4 colour;
float f(float a) { return a * stage.uv.x + stage.w + 100.0 * bare; }
void main() { colour = vec4(f(1.0)); }
";
    let path = shader("stage.frag", text);
    for backend in ["cpu", "gl", "gpu"] {
        let call = ["--fn", "f", "--args", "[2]", "--backend", backend];
        let given = ["--input", "Stage.uv=[3, 7]", "--input", "Bare.bare=0.5"];
        let text = ran(&path, &[&call[..], &given].concat());
        // 2 * 3 + 0 + 100 / 2.
        assert_eq!(row(&text, "result")[0], "56.0", "{backend}");
        assert!(text.contains("`Stage.w` defaults to zero"), "{backend}: {text}");
    }
    let mut landfall = Command::new(env!("CARGO_BIN_EXE_landfall"));
    landfall.arg("stress").arg(&path).args(["--fn", "f", "--samples", "64", "--format", "json"]);
    let report: Value = serde_json::from_slice(&landfall.output().unwrap().stdout).unwrap();
    let inputs = report["inputs"].as_array().unwrap().iter().filter_map(|i| i["path"].as_str());
    assert_eq!(inputs.collect::<Vec<_>>(), ["Stage.uv", "Stage.w", "Bare.bare", "a"]);
}

#[test]
fn an_input_that_main_leaves_alone_has_a_value_too() {
    let text = "#version 330
in vec3 v;
in vec2 other;
out vec4 colour;
float late[][] = float[][](float[](v.x, 1.0, 5.0), float[](2.0, v.y, 6.0));
float plain(float x) { return x * v.x; }
float listed(float x) { return late[0][0] + late[1][1] * x; }
void main() { colour = vec4(1.0); }
";
    let without = text
        .replace("float late[][]", "//")
        .replace("return late[0][0] + late[1][1]", "return v.x + v.y");
    for (name, text) in [("alone.frag", without.as_str()), ("late.frag", text)] {
        let path = shader(name, text);
        for backend in ["cpu", "gl", "gpu"] {
            for (function, expected) in [("plain", "8.0"), ("listed", "14.0")] {
                let call = ["--fn", function, "--args", "[2]", "--input", "v=[4, 5, 6]"];
                let text = ran(&path, &[&call[..], &["--backend", backend]].concat());
                assert_eq!(row(&text, "result")[0], expected, "{name} {function} {backend}");
            }
        }
    }
    let path = shader("alone.frag", &without);
    let said = refused(&path, &["--fn", "plain", "--args", "[2]", "--input", "w=[4, 5, 6]"]);
    assert!(said.contains("it reads `v`"), "{said}");
}

#[test]
fn values_of_push_constants_are_refused_by_opengl_and_read_by_the_others() {
    let text = "#version 450
layout(push_constant) uniform P { float pc; } q;
layout(location = 0) out vec4 colour;
float a(float x) { return q.pc * x + 1.0; }
void main() { colour = vec4(a(1.0)); }
";
    let path = shader("pushed.frag", text);
    let call = ["--fn", "a", "--args", "[3]", "--data", r#"{"P": {"pc": 2}}"#, "--backend"];
    for backend in ["cpu", "gpu"] {
        let text = ran(&path, &[&call[..], &[backend]].concat());
        assert_eq!(row(&text, "result")[0], "7.0", "{backend}");
    }
    let said = refused(&path, &[&call[..], &["gl"]].concat());
    assert!(said.contains("no push constants to hold the values of `P`"), "{said}");
}
