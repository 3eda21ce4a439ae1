//! `landfall stress` from outside: what it exits with, that its findings repeat, and that it
//! stops when it is told to.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use snapbox::str;

use crate::support::command::{self, Ran, golden};

/// A function that is exact, one that breaks at zero, and one that is inaccurate near 1.
const SHADER: &str = "#version 450
layout(location = 0) out vec4 color;
float halved(float x) { return x * 0.5; }
vec3 direction(vec3 v) {
    return normalize(v);
}
float nearly(float x) { return 1000.0 * (x * x - 1.0); }
void main() { color = vec4(direction(vec3(1)), halved(nearly(1.0))); }
";

fn shader(name: &str) -> PathBuf {
    written(name, SHADER)
}

fn written(name: &str, text: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_stress");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// What a shell makes of a command line that was printed.
fn repeated(line: &str) -> Ran {
    let binary = Path::new(env!("CARGO_BIN_EXE_landfall")).parent().unwrap();
    let paths = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap());
    Ran::of(Command::new("sh").args(["-c", line]).env("PATH", paths).output().unwrap())
}

fn stress(path: &Path, arguments: &[&str]) -> Ran {
    let path = path.to_str().expect("it is text");
    command::run(&[&["stress", path], arguments].concat())
}

#[test]
fn it_exits_with_1_past_a_limit_and_on_what_is_not_finite() {
    let path = shader("exits.frag");
    let few = ["--samples", "4000", "--time", "3"];
    for (function, more, code) in [
        ("halved", &["--max-ulp", "0", "--domain", r#"{"x": [1, 2]}"#][..], 0),
        ("direction", &[], 1),
        ("nearly", &["--domain", r#"{"x": [0.9, 1.1]}"#], 0),
        ("nearly", &["--max-step", "0.001", "--domain", r#"{"x": [0.9, 1.1]}"#], 1),
        ("halve", &[], 2),
        ("halved", &["--domain", r#"{"y": [0, 1]}"#], 2),
        ("halved", &["--domain", r#"{"x": [1, 0]}"#], 2),
    ] {
        let output = stress(&path, &[&["--fn", function][..], &few, more].concat());
        let said = &output.err;
        assert_eq!(output.code, code, "{function} {more:?}: {said}");
        assert_eq!(output.out.is_empty(), code == 2, "{function} {more:?}");
        assert_eq!(said.contains("error"), code == 2, "{function} {more:?}: {said}");
    }
    let output = stress(&path, &["--fn", "halve"]);
    output.code(2).stderr_eq(str![[r#"
error[unknown-function]: the shader has no function `halve`
 --> [TMP]/cli_stress/exits.frag
  |
  = help: did you mean `halved`?


"#]]);
}

#[test]
fn a_limit_of_nothing_finds_nothing_in_what_is_exact() {
    let path = shader("exact.frag");
    let exact = ["--fn", "halved", "--samples", "4000", "--domain", r#"{"x": [1, 2]}"#];
    for limit in ["--max-ulp", "--max-step"] {
        let output = stress(&path, &[&exact[..], &[limit, "0", "--format", "json"]].concat());
        let report = output.json();
        assert_eq!(report["findings"], serde_json::json!([]), "{limit}");
        assert_eq!(output.code, 0, "{limit}");
    }
}

#[test]
fn options_that_mean_nothing_are_refused() {
    let path = shader("options.frag");
    for (options, expected) in [
        (
            &["--max-ulp", "nan"][..],
            str![[r#"
error: invalid value 'nan' for '--max-ulp <ULP>': a limit is a finite number of at least 0

For more information, try '--help'.

"#]],
        ),
        (
            &["--max-ulp", "inf"],
            str![[r#"
error: invalid value 'inf' for '--max-ulp <ULP>': a limit is a finite number of at least 0

For more information, try '--help'.

"#]],
        ),
        (
            &["--max-step=-5"],
            str![[r#"
error: invalid value '-5' for '--max-step <STEPS>': a limit is a finite number of at least 0

For more information, try '--help'.

"#]],
        ),
        (
            &["--samples", "0"],
            str![[r#"
error: invalid value '0' for '--samples <N>': number would be zero for non-zero type

For more information, try '--help'.

"#]],
        ),
        (
            &["--jobs", "100000"],
            str![[r#"
error: invalid value '100000' for '--jobs <N>': 100000 is not in 1..=256

For more information, try '--help'.

"#]],
        ),
        (
            &["--map-x", "x"],
            str![[r#"
error: the following required arguments were not provided:
  --map-y <PATH>
  --map <FILE>

Usage: landfall stress --fn <NAME> --map-x <PATH> --map-y <PATH> --map <FILE> <FILE>

For more information, try '--help'.

"#]],
        ),
        (
            &["--map", "x.png", "--map-x", "x", "--map-y", "x"],
            str![[r#"
error: invalid value 'x.png' for '--map <FILE>': a map is an .svg or .html file

For more information, try '--help'.

"#]],
        ),
    ] {
        let output = stress(&path, &[&["--fn", "halved"][..], options].concat());
        output.code(2).stdout_eq("").stderr_eq(expected);
    }
}

#[test]
fn whole_numbers_stay_within_their_range_and_their_type() {
    let text = "#version 450
float f(int a, uint b) { return 1.0 / float(a) + 1.0 / float(b); }
void main() {}
";
    let path = written("whole.frag", text);
    let run = |domain: &str| stress(&path, &["--fn", "f", "--format", "json", "--domain", domain]);
    // Of all that is tried none divides by zero.
    let output = run(r#"{"a": [-3.5, -0.5], "b": [0.5, 4e10]}"#);
    let report = output.json();
    assert_eq!(report["findings"], serde_json::json!([]));
    let domains: Vec<&str> =
        report["inputs"].as_array().unwrap().iter().filter_map(|i| i["domain"].as_str()).collect();
    assert_eq!(domains, ["-3..-1", "1..4294967295"]);
    for (domain, expected) in [
        (
            r#"{"a": [0.5, 0.6]}"#,
            str![[r#"
{"severity":"error","code":"bad-domain","message":"`a`: no `int` is from 0.5 to 0.6","path":"--domain","line":null,"column":null,"end_line":null,"end_column":null,"labels":[],"notes":[],"help":"widen it"}

"#]],
        ),
        (
            r#"{"b": [-5, -1]}"#,
            str![[r#"
{"severity":"error","code":"bad-domain","message":"`b`: no `uint` is from -5 to -1","path":"--domain","line":null,"column":null,"end_line":null,"end_column":null,"labels":[],"notes":[],"help":"widen it"}

"#]],
        ),
    ] {
        run(domain).code(2).stderr_eq(expected);
    }
}

#[test]
fn wide_numbers_stay_within_their_range() {
    let text = "#version 450
uniform double wide; // in 0.5..0.75
float f(float a) { return a / float(wide); }
float g(uint n) { return 1.0 / float(n); }
void main() {}
";
    let path = written("wide.frag", text);
    let run = |arguments: &[&str]| {
        let output =
            stress(&path, &[arguments, &["--samples", "3000", "--format", "json"]].concat());
        output.json()
    };
    let report = run(&["--fn", "f", "--domain", r#"{"a": [1, 2]}"#]);
    // Nothing divides by zero, and nothing comes to more than 4.
    assert_eq!(report["findings"], serde_json::json!([]));
    assert_eq!(report["total"]["infinite"], 0);
    // The one number there is is no f32.
    let report = run(&["--fn", "g", "--domain", r#"{"n": [4294967295, 4294967295]}"#]);
    assert_eq!(
        (&report["total"]["samples"], &report["all_inputs"]),
        (&Value::from(1), &Value::from(1))
    );
}

#[test]
fn a_robust_form_is_given_what_blocks_hold() {
    let text = "#version 450
layout(std140, binding = 0) uniform B { float k; } b;
float f(float x) { return b.k / x; }
float r(float x) { return max(x, 1e-3) / b.k; }
void main() {}
";
    let path = written("held.frag", text);
    let form = format!("{}#r", path.display());
    let given = ["--fn", "f", "--data", r#"{"B": {"k": 2}}"#, "--against", &form];
    let output = stress(&path, &[&given[..], &["--samples", "2000", "--format", "json"]].concat());
    let report = output.json();
    let found = report["findings"].as_array().unwrap();
    let zero = found.iter().find(|found| found["code"] == "division-by-zero");
    // Divided by 2, and not by 0.
    assert_eq!(zero.expect("x is 0 once")["against"]["outcome"], "finite");
}

#[test]
fn what_is_found_in_f16_is_repeated_in_f16() {
    let path = shader("half.frag");
    // 300 squared is past 65504.
    let few = ["--fn", "nearly", "--half", "--samples", "2000", "--format", "json", "--domain"];
    let output = stress(&path, &[&few[..], &[r#"{"x": [300, 400]}"#]].concat());
    let report = output.json();
    let found = report["findings"].as_array().unwrap();
    let found = found.iter().find(|found| found["outcome"] == "infinite");
    let line = found.expect("it overflows")["case"]["command"].as_str().unwrap();
    assert!(line.contains(" --half"), "{line}");
    let again = repeated(line);
    again.stdout_eq(str![[r#"
nearly(float)  [TMP]/cli_stress/half.frag
  cpu  interpreter · landfall [VERSION]
          f32  f64 [..] ulp
  result  inf  [..]  differs
  result is infinite, by infinity from finite operands
    at [TMP]/cli_stress/half.frag:7:42
    comes from x = 300
  every operation is rounded to f16
  results of operations that f16 rounds: 1

"#]]);
}

#[test]
fn what_no_text_says_is_found_where_the_function_is_named() {
    let text = "#version 450\nfloat given(float x) { return x; }\nvoid main() {}\n";
    let path = written("given.frag", text);
    // What is given is rounded before the function begins.
    let few = ["--fn", "given", "--half", "--samples", "2000", "--format", "json"];
    let report = stress(&path, &few).json();
    let found = report["findings"].as_array().unwrap();
    assert!(!found.is_empty());
    for found in found {
        assert_eq!(
            (&found["line"], &found["column"]),
            (&Value::from(2), &Value::from(7)),
            "{found:#}"
        );
    }
}

#[test]
fn what_is_found_is_repeated_by_the_command_beside_it() {
    let path = shader("repeats.frag");
    let few = ["--fn", "direction", "--samples", "4000", "--time", "3", "--format", "json"];
    let output = stress(&path, &few);
    let report = output.json();
    let found = report["findings"].as_array().unwrap();
    let zero = found.iter().find(|found| found["code"] == "zero-vector");
    let zero = zero.unwrap_or_else(|| panic!("{found:#?}"));
    assert_eq!(zero["line"], 5, "the line of `normalize`");
    let line = zero["case"]["command"].as_str().unwrap();
    let again = repeated(line);
    again
        .stdout_eq(str![[r#"
direction(vec3)  [TMP]/cli_stress/repeats.frag
  cpu  interpreter · landfall [VERSION]
            f32  f64  ulp
  result.x  nan  nan  0.00
  result.y  nan  nan  0.00
  result.z  nan  nan  0.00
  result is NaN, by normalised zero vector
    at [TMP]/cli_stress/repeats.frag:5:12
    comes from v = (0, 0, 0)

"#]])
        .stderr_eq(str![[r#"
warning[undefined-operation]: normalised zero vector: 0.0, 0.0, 0.0
 --> [TMP]/cli_stress/repeats.frag:5:12
  |
5 |     return normalize(v);
  |            ^^^^^^^^^^^^ in `direction`
  |
  = note: comes from v = (0, 0, 0)


"#]]);
}

/// A function that is there under a macro alone, and reads a texture and an included file. The
/// text and what is included are `.txt` and `.inc`, so that no name says what they are.
const ASKED: &str = "#version 450
#ifdef X
#include \"scale.inc\"
layout(binding = 0) uniform sampler2D a;
layout(binding = 1) uniform Block { float k; } block;
float f(vec2 at) { return texture(a, at).y * SCALE * at.x / 3.0 + block.k * float(X); }
#endif
void main() {}
";

#[test]
fn a_command_has_the_macros_textures_folders_and_stage_the_function_was_read_with() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_stress");
    let included = folder.join("an include folder");
    std::fs::create_dir_all(&included).unwrap();
    std::fs::write(included.join("scale.inc"), "#define SCALE 0.7\n").unwrap();
    let path = folder.join("asked.txt");
    std::fs::write(&path, ASKED).unwrap();
    let asked = ["-D", "X=3", "-I", included.to_str().unwrap(), "--stage", "fragment"];
    let textured = ["--fn", "f", "--texture", "a=[0.25, 0.3, 1, 1e-7]", "--data"];
    let few = [r#"{"Block": {"k": 0.125}}"#, "--samples", "2000", "--format", "json"];
    let domain = ["--domain", r#"{"at": [0.5, 2]}"#];
    let output = stress(&path, &[&asked[..], &textured, &few, &domain].concat());
    let report = output.json();
    let case = &report["worst"][0]["case"];
    let line = case["command"].as_str().expect("some sample is rounded");
    let line = format!("{line} --format json");
    let again = repeated(&line);
    let again = again.json();
    let scalar = &again["result"]["scalars"][0];
    assert_eq!(scalar["value"], case["results"][0]["f32"], "{line}: {again}");
    assert_eq!(scalar["double"], case["results"][0]["f64"], "{line}: {again}");
    // White instead of 0.3 would be three times as much: x is at least a half.
    assert!(
        scalar["value"].as_f64().is_some_and(|y| y < 0.375 + 0.7 * 0.31 * 2.0 / 3.0),
        "{again}"
    );
}

#[test]
fn a_time_no_clock_reaches_is_refused_in_words() {
    let path = shader("late.frag");
    let mut said = String::new();
    for time in ["1e19", "1e300", "inf", "NaN", "0"] {
        let output = stress(&path, &["--fn", "halved", "--samples", "10", "--time", time]);
        said += output.code(2).err.lines().next().unwrap_or_default();
        said.push('\n');
    }
    golden().eq(
        said,
        str![[r#"
error: invalid value '1e19' for '--time <SECONDS>': a limit is above 0 and up to 1000000000 s
error: invalid value '1e300' for '--time <SECONDS>': a limit is above 0 and up to 1000000000 s
error: invalid value 'inf' for '--time <SECONDS>': a limit is above 0 and up to 1000000000 s
error: invalid value 'NaN' for '--time <SECONDS>': a limit is above 0 and up to 1000000000 s
error: invalid value '0' for '--time <SECONDS>': a limit is above 0 and up to 1000000000 s

"#]],
    );
}

#[test]
fn a_robust_form_reads_what_the_function_reads_or_is_refused() {
    let text = "#version 450
layout(binding = 0) uniform Block { float k; float m; } u;
float f(float x) { return normalize(vec2(x * u.k)).x; }
float g(float x) { return normalize(vec2(x * u.k)).x * (u.m / u.m); }
float h(float x, float more) { return x * u.k + more; }
void main() {}
";
    let path = written("against.frag", text);
    let few = ["--fn", "f", "--samples", "3000", "--format", "json", "--domain"];
    let domain = r#"{"m": [1, 2]}"#.replace("\"m\"", "\"u.m\"");
    let against = |name: &str| {
        let form = format!("{}#{name}", path.display());
        stress(&path, &[&few[..], &[&domain, "--against", &form]].concat())
    };
    let output = against("g");
    let report = output.json();
    // Of a zero vector both give NaN; of what is too large, both give the same.
    let found = report["findings"].as_array().unwrap();
    assert!(!found.is_empty());
    for found in found {
        assert_eq!(found["against"]["outcome"], found["outcome"], "{found:#}");
        let m = found["case"]["inputs"]["u.m"].as_f64();
        assert!(m.is_some_and(|m| (1.0..=2.0).contains(&m)), "{found:#}");
    }
    against("h").code(2).stderr_eq(str![[r#"
{"severity":"error","code":"cannot-compare","message":"`h(float, float)` cannot be compared: it reads `more`, and `f(float)`, which it is compared with, reads `x`, `u.k`","path":"--against","line":null,"column":null,"end_line":null,"end_column":null,"labels":[],"notes":[],"help":null}

"#]]);
}

#[test]
fn an_error_map_is_a_drawing_of_the_two_inputs() {
    let path = shader("map.frag");
    let map = path.with_extension("svg");
    let arguments = ["--map", map.to_str().unwrap(), "--map-x", "v.x", "--map-y", "v.y"];
    let few = ["--fn", "direction", "--samples", "2000", "--time", "3"];
    stress(&path, &[&few[..], &arguments].concat()).code(1);
    let drawing = std::fs::read_to_string(&map).unwrap();
    let document = roxmltree::Document::parse(&drawing).expect("SVG is XML");
    let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
    for axis in ["v.x", "v.y"] {
        assert!(texts.iter().any(|text| text.contains(axis)), "{axis} in {texts:?}");
    }
    let twice = ["--map", map.to_str().unwrap(), "--map-x", "v.x", "--map-y", "v.x"];
    let output = stress(&path, &[&few[..], &twice].concat());
    assert_eq!(output.code, 2);
    assert_eq!(std::fs::read_to_string(&map).unwrap(), drawing, "it is left as it was");
}

/// Where signals can be looked at.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_ends_it_with_what_it_has() {
    use std::io::Read as _;
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let path = shader("interrupt.frag");
    let mut child = command::landfall(&["stress"])
        .arg(&path)
        .args(["--fn", "direction", "--time", "3000", "--samples", "1000000000000"])
        .args(["--format", "json"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let began = Instant::now();
    let status = format!("/proc/{}/status", child.id());
    let listens = || {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        let caught = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
        caught.is_some_and(|mask| mask & 0b10 != 0)
    };
    while !listens() {
        assert!(began.elapsed() < Duration::from_secs(60), "it does not listen to SIGINT");
        std::thread::sleep(Duration::from_millis(20));
    }
    // Samples are computed, however busy the machine is: in hundredths of a second.
    let used = || {
        let text =
            std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap_or_default();
        let fields: Vec<&str> = text.rsplit(") ").next().unwrap_or_default().split(' ').collect();
        [11, 12]
            .map(|at| fields.get(at).and_then(|f| f.parse::<u64>().ok()))
            .into_iter()
            .flatten()
            .sum::<u64>()
    };
    while used() < 150 {
        assert!(began.elapsed() < Duration::from_secs(100), "it computes nothing");
        std::thread::sleep(Duration::from_millis(20));
    }
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // Not the 3000 seconds, nor half as long again for what was found.
    assert!(began.elapsed() < Duration::from_secs(120), "{:?}", began.elapsed());
    let report: Value = serde_json::from_str(&text).expect("the whole report is there");
    assert_eq!(report["stopped"], true);
    assert!(report["total"]["samples"].as_u64().unwrap() > 0);
    let found = report["findings"].as_array().unwrap();
    assert!(found.iter().any(|found| found["code"] == "zero-vector"), "{text}");
}
