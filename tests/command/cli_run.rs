//! `landfall run` from outside: what it prints, and what it says about arguments that do not fit.

use snapbox::str;

use crate::schema::{holds, validator};
use crate::support::command::{Place, Ran, golden};

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

/// A folder with a shader of that name.
fn shader(name: &str, text: &str) -> Place {
    let place = Place::new(&format!("run-{name}"));
    place.write(name, text);
    place
}

fn run(place: &Place, arguments: &[&str]) -> Ran {
    let name = place.0.file_name().and_then(|name| name.to_str()).expect("it is text");
    let file = name.strip_prefix("run-").expect("folders are named after their shader");
    place.run(&[&["run", file], arguments].concat())
}

fn ran(place: &Place, arguments: &[&str]) -> String {
    let ran = run(place, arguments);
    ran.code(0);
    ran.out
}

fn refused(place: &Place, arguments: &[&str]) -> Ran {
    let ran = run(place, arguments);
    ran.code(2).stdout_eq("");
    ran
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
    let place = shader("third.frag", SHADER);
    let text = ran(&place, &["--fn", "third(float)", "--args", "[1]"]);
    // 1/3 in f32 is a third of a unit off, in f64 the shortest digits that read back.
    assert_eq!(row(&text, "result"), ["0.33333334", "0.3333333333333333", "0.33"]);
}

#[test]
fn every_reader_gives_back_out_and_inout_parameters() {
    let place = shader("split.frag", SHADER);
    for backend in ["cpu", "gl", "gpu"] {
        let data = r#"{"DefaultBlock": {"gain": 2}}"#;
        let arguments = ["--fn", "split", "--args", "[[3, 4, 0], [1, 2, -3]]", "--data", data];
        let text = ran(&place, &[&arguments[..], &["--backend", backend]].concat());
        // 3-4-5; and each component times gain 2 times scale 2.5.
        assert_eq!(row(&text, "len")[..2], ["5.0", "5.0"], "{backend}");
        for (name, value) in [("dir.x", "5.0"), ("dir.y", "10.0"), ("dir.z", "-15.0")] {
            assert_eq!(row(&text, name), [value, value, "0.00"], "{backend}");
        }
    }
}

/// The last line of a report: its note, if it has one.
fn last(text: &str) -> &str {
    text.lines().last().unwrap_or_default()
}

#[test]
fn textures_are_white_unless_given_and_inputs_zero_unless_given() {
    let place = shader("assumed.frag", SHADER);
    for backend in ["cpu", "gl", "gpu"] {
        let call = ["--fn", "look", "--args", "[[0, 0]]", "--backend", backend];
        let text = ran(&place, &call);
        assert_eq!(row(&text, "result.y")[0], "1.0", "{backend}");
        golden().eq(last(&text), str!["  `tex` is white by default: set a colour with --texture"]);
        let text = ran(&place, &[&call[..], &["--texture", "tex=[1, 0.5, 0.25, 1]"]].concat());
        assert_eq!(row(&text, "result.y")[0], "0.5", "{backend}");
        assert!(!text.contains("white"), "{text}");
    }
    let light = r#"[{"color": [1, 2, 3], "power": 2}, [[0, 0], [1, 0]]]"#;
    for backend in ["cpu", "gl", "gpu"] {
        let text = ran(&place, &["--fn", "lit", "--args", light, "--backend", backend]);
        assert_eq!(row(&text, "result.z")[0], "6.0", "{backend}");
        golden().eq(last(&text), str!["  `v_normal` defaults to zero: set it with --input"]);
    }
    for backend in ["cpu", "gl", "gpu"] {
        let input = ["--input", "v_normal=[0, 0, 0.5]", "--backend", backend];
        let text = ran(&place, &[&["--fn", "lit", "--args", light][..], &input].concat());
        assert_eq!(row(&text, "result.z")[0], "6.5", "{backend}");
        assert!(!text.contains("v_normal"), "{text}");
    }
}

#[test]
fn an_undefined_operation_is_named_with_its_place() {
    let place = shader("zero.frag", SHADER);
    // The line of `normalize`.
    run(&place, &["--fn", "direction", "--args", "[[0, 0, 0]]"])
        .code(0)
        .stdout_eq(str![[r#"
direction(vec3)  zero.frag
  cpu  interpreter · landfall [VERSION]
            f32  f64  ulp
  result.x  nan  nan  0.00
  result.y  nan  nan  0.00
  result.z  nan  nan  0.00
  result is NaN, by normalised zero vector
    at zero.frag:12:12
    comes from v = (0, 0, 0)

"#]])
        .stderr_eq(str![[r#"
warning[undefined-operation]: normalised zero vector: 0.0, 0.0, 0.0
  --> zero.frag:12:12
   |
12 |     return normalize(v);
   |            ^^^^^^^^^^^^ in `direction`
   |
   = note: comes from v = (0, 0, 0)


"#]]);
}

#[test]
fn what_does_not_fit_is_said_with_its_place_in_the_json() {
    let place = shader("misfits.frag", SHADER);
    for (function, arguments, said) in [
        (
            "direktion",
            "[]",
            str![[r#"
error[unknown-function]: the shader has no function `direktion`
 --> misfits.frag
  |
  = help: did you mean `direction`?


"#]],
        ),
        (
            "direction",
            "[]",
            str![[r#"
error[wrong-count]: `direction(vec3)` takes 1 argument, but none was given
 --> --args
  |
  = help: it is declared as `direction(vec3 v)`


"#]],
        ),
        (
            "direction",
            "[[1, 2]]",
            str![[r#"
error[wrong-value]: `args[0]` is a `vec3`: expected an array of 3 numbers, found an array of 2 values
 --> --args


"#]],
        ),
        (
            "direction",
            "[[1, 2, 1e99]]",
            str![[r#"
error[value-out-of-range]: `args[0][2]`: 1e+99 does not fit `float`
 --> --args


"#]],
        ),
        (
            "direction",
            "[[1, 2",
            str![[r#"
error[bad-request]: `--args` is not JSON: line 1, column 7: the text ends before the value is complete


"#]],
        ),
        (
            "lit",
            r#"[{"color": [1, 2, "x"], "power": 1}, 0]"#,
            str![[r#"
error[wrong-value]: `args[0].color[2]` is a `float`: expected a number, "inf", "-inf", "nan" or "nan:0x…" (a NaN by its bits), found "x"
 --> --args


"#]],
        ),
        (
            "lit",
            r#"[{"color": [1, 2, 3], "powr": 1}, 0]"#,
            str![[r#"
error[missing-member]: `args[0].power` is not given
 --> --args
  |
  = help: add a value of type `float`


"#]],
        ),
        (
            "third",
            "[1]",
            str![[r#"
error[ambiguous-function]: 2 overloads of `third` accept these arguments
 --> misfits.frag
  |
  = help: select one by its parameter types: `third(float)`, `third(int)`


"#]],
        ),
        (
            "third(bool)",
            "[1]",
            str![[r#"
error[unknown-function]: no function `third` has these parameters
 --> misfits.frag
  |
  = help: there is `third(float)`, `third(int)`


"#]],
        ),
        (
            "with",
            "[1]",
            str![[r#"
error[cannot-call]: `with(sampler2D)` cannot be called: `t` is a `sampler2D`, but arguments can only be numbers, vectors, matrices, and arrays or structures of them
 --> misfits.frag
  |
  = help: call the function that calls it


"#]],
        ),
    ] {
        refused(&place, &["--fn", function, "--args", arguments]).stderr_eq(said);
    }
    let data = r#"{"DefaultBlok": {}}"#;
    refused(&place, &["--fn", "third(int)", "--args", "[1]", "--data", data]).stderr_eq(str![[
        r#"
error[unknown-block]: no block named `DefaultBlok`
 --> --data
  |
  = help: did you mean `DefaultBlock`?


"#
    ]]);
}

#[test]
fn a_loop_without_an_end_is_stopped() {
    // Iterations take so long that their limit is not reached before that of time.
    let slow = "x += sin(x);".repeat(100);
    let text = &format!(
        "#version 450\nfloat spin(float x) {{ for (;;) {{ {slow} x += 2.0; if (x < 0.0) break; }} \
         return x; }}\nvoid main() {{ spin(1.0); }}\n"
    );
    let place = shader("spin.frag", text);
    refused(&place, &["--fn", "spin", "--args", "[1]", "--limit", "2"]).stderr_eq(str![[r#"
error[cannot-run]: cpu: the code was still running at the time limit: in `spin`, spin.frag:2:23


"#]]);
}

#[test]
fn json_holds_to_its_schema() {
    let validator = validator("run");
    let place = shader("json.frag", SHADER);
    for arguments in [
        &["--fn", "direction", "--args", "[[0, 0, 0]]"][..],
        &["--fn", "split", "--args", r#"[["nan", "inf", 0], [1, 2, 3]]"#],
        &["--fn", "third(int)", "--args", "[1]", "--backend", "gl"],
    ] {
        let text = ran(&place, &[arguments, &["--format", "json"]].concat());
        holds(&validator, &text, "run");
        assert!(text.ends_with('\n'));
    }
}

#[test]
fn wgsl_pointers_come_back() {
    let text = "struct B { n: u32, gain: f32 }\n@group(0) @binding(0) var<uniform> b: B;\n\
                fn twice(k: vec2<f32>, to: ptr<function, vec2<f32>>) -> u32 {\n\
                *to = k * 2.0 * b.gain; return b.n; }\n\
                @compute @workgroup_size(1) fn main() { var v: vec2<f32>; _ = twice(v, &v); }\n";
    let place = shader("twice.wgsl", text);
    let data = r#"{"B": {"n": 7, "gain": 0.5}}"#;
    for backend in ["cpu", "gpu"] {
        let text = ran(
            &place,
            &["--fn", "twice", "--args", "[[3, 4], [0, 0]]", "--data", data, "--backend", backend],
        );
        assert_eq!((row(&text, "result")[0], row(&text, "to.y")[0]), ("7", "4.0"), "{backend}");
    }
    refused(&place, &["--fn", "twice", "--args", "[[3, 4], [0, 0]]", "--backend", "gl"]).stderr_eq(
        str![[r#"
error[cannot-run]: gl: OpenGL does not accept WGSL


"#]],
    );
}

#[test]
fn a_call_by_itself_has_no_neighbours_to_differ_from() {
    let text = "#version 330
in vec2 uv;
out vec4 colour;
float slope(float a, float b) { return dFdx(a) + dFdy(b) + fwidth(uv.x) + 5.0; }
void main() { colour = vec4(slope(uv.x, uv.y)); }
";
    let place = shader("slope.frag", text);
    for backend in ["cpu", "gl", "gpu"] {
        let call = ["--fn", "slope", "--args", "[3, 7]", "--input", "uv=[3, 7]"];
        let text = ran(&place, &[&call[..], &["--backend", backend]].concat());
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
    let place = shader("left_out.frag", text);
    for (function, said) in [
        (
            "again",
            str![[r#"
error[cannot-call]: `again` cannot run: `again` calls itself, at left_out.frag:3


"#]],
        ),
        (
            "through",
            str![[r#"
error[cannot-call]: `through` cannot run: `again` calls itself, at left_out.frag:3


"#]],
        ),
        (
            "loose",
            str![[r#"
error[cannot-call]: `loose` cannot run: there is no variable `undeclared`, at left_out.frag:5


"#]],
        ),
    ] {
        let ran = refused(&place, &["--fn", function, "--args", "[3]"]);
        // What no compiler takes is said of the whole text, before.
        let (warning, rest) = ran.err.split_at(ran.err.find("error").expect("it is refused"));
        assert!(warning.starts_with("warning[invalid-shader]: `undeclared` is not declared\n"));
        golden().eq(rest, said);
    }
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
    let place = shader("two_textures.frag", text);
    let call = ["--fn", "both", "--texture", "a=[0, 0, 0, 1]"];
    run(&place, &[&call[..], &["--args", "[[0, 0]]"]].concat())
        .code(0)
        .stdout_eq(str![[r#"
both(vec2)  two_textures.frag
  cpu  interpreter · landfall [VERSION]
            f32  f64  ulp
  result.x  1.0  1.0  0.00
  result.y  1.0  1.0  0.00
  result.z  1.0  1.0  0.00
  result.w  2.0  2.0  0.00
  `ab` is white by default: set a colour with --texture

"#]])
        .stderr_eq(str![]);
    let stress = ["stress", "two_textures.frag", "--samples", "256"];
    let ran = place.run(&[&stress[..], &call].concat());
    let note = ran.out.lines().find(|line| line.contains("`ab`")).unwrap_or(&ran.err);
    golden().eq(note, str![""]);
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
    let place = shader("half.frag", text);
    // 2^-12 is a quarter of a unit in the last place of an f16 at 1: the sum is 1.
    let few = ["--fn", "few", "--args", "[0.000244140625]"];
    for (rounding, sum) in
        [(None, "1.0002441"), (Some("--half"), "1.0"), (Some("--mediump"), "1.0")]
    {
        let call: Vec<&str> = few.into_iter().chain(rounding).collect();
        assert_eq!(row(&ran(&place, &call), "result")[0], sum, "{rounding:?}");
    }
    // Above 65,504 an f16 is infinite; `grown` is highp.
    let grown = ["--fn", "grown", "--args", "[5000]"];
    for (rounding, product) in
        [(None, "80000.0"), (Some("--half"), "inf"), (Some("--mediump"), "80000.0")]
    {
        let call: Vec<&str> = grown.into_iter().chain(rounding).collect();
        assert_eq!(row(&ran(&place, &call), "result")[0], product, "{rounding:?}");
    }
    refused(&place, &[&grown[..], &["--half", "--backend", "gl"]].concat()).stderr_eq(str![[r#"
error[bad-request]: `--backend gl` cannot round to f16: drivers run the source as written
  |
  = help: remove --half and --mediump, or use `--backend cpu`


"#]]);
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
    let place = shader("stage.frag", text);
    for backend in ["cpu", "gl", "gpu"] {
        let call = ["--fn", "f", "--args", "[2]", "--backend", backend];
        let given = ["--input", "Stage.uv=[3, 7]", "--input", "Bare.bare=0.5"];
        let text = ran(&place, &[&call[..], &given].concat());
        // 2 * 3 + 0 + 100 / 2.
        assert_eq!(row(&text, "result")[0], "56.0", "{backend}");
        golden().eq(last(&text), str!["  `Stage.w` defaults to zero: set it with --input"]);
    }
    let stress = ["stress", "stage.frag", "--fn", "f", "--samples", "64", "--format", "json"];
    let report = place.run(&stress).json();
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
        let place = shader(name, text);
        for backend in ["cpu", "gl", "gpu"] {
            for (function, expected) in [("plain", "8.0"), ("listed", "14.0")] {
                let call = ["--fn", function, "--args", "[2]", "--input", "v=[4, 5, 6]"];
                let text = ran(&place, &[&call[..], &["--backend", backend]].concat());
                assert_eq!(row(&text, "result")[0], expected, "{name} {function} {backend}");
            }
        }
    }
    let place = shader("alone.frag", &without);
    refused(&place, &["--fn", "plain", "--args", "[2]", "--input", "w=[4, 5, 6]"]).stderr_eq(str![
        [r#"
error[unknown-input]: the shader has no input `w`
 --> --input
  |
  = help: it reads `v`


"#]
    ]);
}

#[test]
fn values_of_push_constants_are_refused_by_opengl_and_read_by_the_others() {
    let text = "#version 450
layout(push_constant) uniform P { float pc; } q;
layout(location = 0) out vec4 colour;
float a(float x) { return q.pc * x + 1.0; }
void main() { colour = vec4(a(1.0)); }
";
    let place = shader("pushed.frag", text);
    let call = ["--fn", "a", "--args", "[3]", "--data", r#"{"P": {"pc": 2}}"#, "--backend"];
    for backend in ["cpu", "gpu"] {
        let text = ran(&place, &[&call[..], &[backend]].concat());
        assert_eq!(row(&text, "result")[0], "7.0", "{backend}");
    }
    refused(&place, &[&call[..], &["gl"]].concat()).stderr_eq(str![[r#"
error[cannot-run]: gl: OpenGL has no push constants to hold the values of `P`


"#]]);
}

/// Of a function that returns nothing, the variables it writes are the result.
#[test]
fn the_outputs_of_main_are_printed_on_every_backend() {
    let place = Place::new("run-main");
    place.write(
        "a.vert",
        "#version 450\nlayout(std140, binding = 0) uniform Camera { mat4 view; float near; };\n\
         layout(location = 0) in vec3 p;\nlayout(location = 0) out vec3 twice;\n\
         void main() { twice = 2.0 * p; gl_Position = view * vec4(p, near); }\n",
    );
    let camera = r#"{"Camera": {"view": [[2,0,0,0],[0,3,0,0],[0,0,1,0],[1,0,0,1]], "near": 1}}"#;
    for backend in ["cpu", "gl", "gpu"] {
        let run = ["run", "a.vert", "--fn", "main", "--data", camera, "--input", "p=[1, 2, 3]"];
        let more = ["--backend", backend, "--format", "json"];
        let report = place.run(&[&run[..], &more].concat()).json();
        let value = |name: &str| {
            let all = report["parameters"].as_array().unwrap();
            all.iter().find(|output| output["name"] == name).unwrap()["value"].clone()
        };
        assert_eq!(value("twice"), serde_json::json!([2.0, 4.0, 6.0]), "{backend}");
        assert_eq!(value("gl_Position"), serde_json::json!([3.0, 6.0, 3.0, 1.0]), "{backend}");
    }
}

/// An entry point of WGSL takes the inputs of its stage as arguments.
#[test]
fn an_entry_point_of_wgsl_is_called_on_the_interpreter_and_the_gpu() {
    let place = Place::new("run-entry-point");
    place.write(
        "a.wgsl",
        "struct In { @location(0) p: vec3f, @builtin(vertex_index) n: u32 }\n\
         struct Out { @builtin(position) at: vec4f, @location(0) twice: vec3f }\n\
         struct Eye { near: f32 }\n@group(0) @binding(0) var<uniform> e: Eye;\n\
         @vertex fn lit(v: In) -> Out { return Out(vec4f(v.p, e.near + f32(v.n)), 2.0 * v.p); }\n",
    );
    for backend in ["cpu", "gpu"] {
        let run = ["run", "a.wgsl", "--fn", "lit", "--args", r#"[{"p": [1, 2, 3], "n": 4}]"#];
        let more = ["--data", r#"{"e": {"near": 0.5}}"#, "--backend", backend, "-f", "json"];
        let report = place.run(&[&run[..], &more].concat()).json();
        let expected = serde_json::json!({"at": [1.0, 2.0, 3.0, 4.5], "twice": [2.0, 4.0, 6.0]});
        assert_eq!(report["result"]["value"], expected, "{backend}");
    }
    let refused = place.run(&["run", "a.wgsl", "--fn", "lid"]);
    golden().eq(
        &refused.err,
        str![[r#"
error[unknown-function]: the shader has no function `lid`
 --> a.wgsl
  |
  = help: did you mean `lit`?


"#]],
    );
}
