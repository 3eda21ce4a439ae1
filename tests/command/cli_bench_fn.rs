//! `landfall bench --fn`: functions of any kind on every backend, held against a truth.

use std::process::Command;

use landfall_accuracy::bench::{Bench, BenchRow};
use snapbox::data::Inline;
use snapbox::str;

use crate::cli_bench::steps;
use crate::schema::{holds, validator};
use crate::support::command::{self, Place, Ran, golden};

/// Shaders of a test, each of one file.
struct Folder(Place);

impl Folder {
    fn new(name: &str) -> Folder {
        Folder(Place::new(&format!("bench-fn-{name}")))
    }

    /// A shader of some functions; `shade` is called by its `main`, if there is one.
    fn file(&self, name: &str, functions: &str) -> String {
        let main = if functions.contains("void shade()") { "shade();" } else { "" };
        let text = format!("#version 450\n{functions}\nvoid main() {{ {main} }}\n");
        self.0.write(name, text);
        self.0.path(name)
    }
}

const SMALL: [&str; 6] = ["--rounds", "3", "--samples", "2000", "--format", "json"];

fn bench(arguments: &[&str]) -> Bench {
    let output = command::run(&[&["bench"], arguments, &SMALL].concat());
    assert_eq!(output.code, 0, "{}", output.err);
    serde_json::from_value(holds(&validator("bench"), &output.out, "bench")).expect("a bench")
}

fn row<'b>(bench: &'b Bench, variant: &str, backend: &str) -> &'b BenchRow {
    let mut rows = bench.rows.iter();
    let found = rows.find(|row| row.variant == variant && row.runner.backend == backend);
    found.unwrap_or_else(|| panic!("{variant} on {backend}: {:?}", bench.failed))
}

const READERS: [&str; 3] = ["cpu", "gl", "gpu"];

#[test]
fn variants_are_held_against_the_first_functions_f64() {
    let folder = Folder::new("variants");
    // x * x - 1 loses what (x - 1) * (x + 1) keeps, next to 1.
    let functions = "float f(float x) { return x * x - 1.0; }
float product(float x) { return (x - 1.0) * (x + 1.0); }";
    let file = folder.file("plain.frag", functions);
    let wrong =
        format!("wrong={}", folder.file("wrong.frag", "float f(float x) { return x * x; }"));
    let arguments = [
        &file,
        "--fn",
        "f",
        "--variant",
        "product=#product",
        "--variant",
        &wrong,
        "--backend",
        "cpu",
    ];
    let found = bench(&arguments);
    let of = |variant: &str| row(&found, variant, "cpu").errors;
    let most = |variant: &str| steps(row(&found, variant, "cpu"));
    // A rounding of the square and one of the difference: 2^-23 of the result or of 1.
    assert!(most("as it is") > 0.0 && most("as it is") < 255.0 * 2f64.powi(-22));
    // Three roundings, each half a unit of its place, which may be half the result's.
    assert!(of("product").max_ulp.is_some_and(|ulp| ulp > 0.0 && ulp < 6.0), "{found:?}");
    assert!(of("as it is").max_ulp > of("product").max_ulp);
    assert!((most("wrong") - 255.0).abs() < 1.0, "it is wrong by 1: {found:?}");
    assert_eq!(row(&found, "as it is", "cpu").work.operations, Some(2.0));
    // Two thousand calls of one float.
    assert_eq!(row(&found, "as it is", "cpu").work.bytes, Some(8000));
    // Where the wrong one is the truth, it is the others that are wrong.
    let turned = bench(&[&arguments[..], &["--truth", "wrong"]].concat());
    assert!(steps(row(&turned, "wrong", "cpu")) < 1e-3, "{turned:?}");
    assert!(steps(row(&turned, "as it is", "cpu")) > 200.0);
    golden().eq(&turned.truth, str!["the f64 of wrong"]);
}

#[test]
fn one_correctly_rounded_operation_is_half_a_unit_off_on_every_reader() {
    let folder = Folder::new("rounding");
    let file = folder.file("sum.frag", "float f(float x) { return x + 1.0; }");
    let found = bench(&[&file, "--fn", "f"]);
    for backend in READERS {
        let row = row(&found, "as it is", backend);
        let ulp = row.errors.max_ulp.unwrap();
        // Of two thousand sums some are nearly in the middle of two numbers.
        assert!(ulp > 0.45 && ulp <= 0.5, "{backend}: {ulp}");
        // Rounded either way, as devices may: a unit, and no more.
        let permitted = row.permitted.unwrap();
        assert_eq!(permitted.samples, 2000);
        let most = permitted.max_steps.unwrap();
        assert!(most >= steps(row) && most < 3.0 * steps(row), "{row:?}");
        assert!(row.subtracted);
    }
}

#[test]
fn structures_blocks_inputs_matrices_and_whole_numbers_are_called_with() {
    let folder = Folder::new("kinds");
    let file = folder.file(
        "kinds.frag",
        "struct Light { vec3 position; bool on; ivec2 cell; };
layout(location = 0) in vec3 FragPos;
layout(binding = 0) uniform Block { mat3 turn; uint mask; } block;
float f(Light light, int n, out int k) {
    k = n + light.cell.y + int(block.mask);
    vec3 way = block.turn * (light.position - FragPos);
    return light.on ? way.x : way.y;
}
layout(location = 0) out vec4 color;
void shade() { int k; color = vec4(f(Light(FragPos, true, ivec2(0)), 0, k)); }",
    );
    let found = bench(&[&file, "--fn", "f"]);
    assert!(found.failed.is_empty(), "{:?}", found.failed);
    for backend in READERS {
        let row = row(&found, "as it is", backend);
        assert_eq!(row.errors.differing, Some(0), "{backend}");
        // Some roundings of numbers up to some hundred.
        assert!(steps(row) > 0.0 && steps(row) < 0.01, "{:?}", row.errors);
        // 20 words of 4 bytes: 3, 1 and 2 of the light, n, 3 of the input, 9 and 1 of the block.
        assert_eq!(row.work.bytes, Some(2000 * 4 * 20));
    }
}

#[test]
fn inputs_are_in_the_domain_of_comments_and_options() {
    let folder = Folder::new("domain");
    // From 2 to 4, the two are apart by 1 of 2 at most.
    let functions = |comment: &str| {
        format!(
            "float f(float x) {{ {comment}\n    return x;\n}}
float above(float x) {{\n    return max(x, 3.0);\n}}"
        )
    };
    let plain = folder.file("plain.frag", &functions(""));
    let said = folder.file("said.frag", &functions("// x in 2..4"));
    let most = |file: &str, more: &[&str]| {
        let own = [file, "--fn", "f", "--variant", "above=#above", "--backend", "cpu"];
        steps(row(&bench(&[&own[..], more].concat()), "above", "cpu"))
    };
    assert!((125.0..=127.5).contains(&most(&said, &[])));
    assert!((125.0..=127.5).contains(&most(&plain, &["--domain", r#"{"x": [2, 4]}"#])));
    assert!(most(&plain, &[]) > 127.5);
}

#[test]
fn a_seed_gives_the_same_errors_again() {
    let file = "shaders/six_lights/phong_450.frag";
    let errors = |seed: &str| {
        let found = bench(&[file, "--fn", "CalcSpotLight", "--backend", "cpu", "--seed", seed]);
        assert!(found.subject.contains(&format!("seed {seed}")), "{}", found.subject);
        found.rows[0].errors
    };
    assert_eq!(errors("7"), errors("7"));
    assert_ne!(errors("7"), errors("8"));
}

#[test]
fn half_precision_is_the_evaluators_alone() {
    let folder = Folder::new("half");
    let file = folder.file("square.frag", "float f(float x) { return x * x; }");
    let domain = r#"{"x": [1, 2]}"#;
    let found = bench(&[
        &file,
        "--fn",
        "f",
        "--variant",
        "half=:half",
        "--domain",
        domain,
        "--backend",
        "cpu,gl",
    ]);
    // f16 has 11 digits and f32 24: half a unit of the one is 2^12 of the other. The argument
    // is rounded too, which the square doubles.
    let ulp = row(&found, "half", "cpu").errors.max_ulp.unwrap();
    assert!(ulp > 2048.0 && ulp <= 4.0 * 4096.0, "{ulp}");
    assert_eq!(row(&found, "half", "cpu").permitted, None);
    assert_eq!(found.failed.len(), 1, "{:?}", found.failed);
    assert_eq!(
        (found.failed[0].variant.as_str(), found.failed[0].backend.as_str()),
        ("half", "gl")
    );
}

#[test]
fn a_member_that_is_not_read_needs_no_value() {
    let folder = Folder::new("unread");
    let body = "float f(float x) { return x * u.k; }";
    let small = format!("layout(binding = 0) uniform Block {{ float k; }} u;\n{body}");
    let large = "layout(binding = 0) uniform Block { float k; float extra; ivec2 more; } u;\n";
    let small = folder.file("small.frag", &small);
    let large = format!("b={}", folder.file("large.frag", &format!("{large}{body}")));
    // By order, where the names are others: what is read, and nothing between.
    let renamed = "layout(binding = 0) uniform Other { float pad; float gain; } o;
float f(float y) { return y * o.gain; }";
    let renamed = format!("c={}", folder.file("renamed.frag", renamed));
    let arguments = [&small, "--fn", "f", "--variant", &large, "--variant", &renamed];
    let found = bench(&[&arguments[..], &["--backend", "cpu,gl"]].concat());
    assert!(found.failed.is_empty(), "{:?}", found.failed);
    for backend in ["cpu", "gl"] {
        let of = |variant: &str| row(&found, variant, backend).errors;
        assert!(of("as it is").max_ulp.is_some_and(|ulp| ulp > 0.4 && ulp <= 0.5), "{backend}");
        assert_eq!((of("b"), of("c")), (of("as it is"), of("as it is")), "{backend}");
    }
}

#[test]
fn a_member_that_only_a_variant_reads_has_values_too() {
    let folder = Folder::new("more");
    let functions = "layout(binding = 0) uniform Block { float k; float m; } u;
float f(float x) { return x * u.k; }
float g(float x) { return x * u.k * u.m / u.m; }";
    let file = folder.file("more.frag", functions);
    let arguments = [&file, "--fn", "f", "--variant", "g=#g", "--backend", "cpu"];
    let found = bench(&[&arguments[..], &["--domain", r#"{"u.m": [1, 2]}"#]].concat());
    let g = row(&found, "g", "cpu").errors;
    // Three roundings, the first two up to a whole unit of the last's place.
    assert_eq!(g.non_finite, 0, "{g:?}");
    assert!(g.max_ulp.is_some_and(|ulp| ulp > 0.5 && ulp <= 2.5), "{g:?}");
    // What no value is there for is refused in words.
    let alone = folder.file("alone.frag", "float f(float x) { return x; }");
    let form = format!("more={file}");
    let output =
        command::run(&["bench", &alone, "--fn", "f", "--variant", &form, "--backend", "cpu"]);
    output.code(2).stderr_eq(str![[r#"
error[bad-request]: `--variant more` does not fit: it reads `u.k`, and `f(float)`, which it is compared with, reads `x`


"#]]);
}

#[test]
fn what_cannot_be_called_is_refused_by_name() {
    let folder = Folder::new("refused");
    let functions = "layout(binding = 0) buffer Out { float kept; };
float writes(float x) { kept = x; return x; }
void nothing(float x) {}
vec4 sampled(sampler2D image, vec2 at) { return texture(image, at); }
float f(float x) { return x; }
float two(float x, int n) { return x + float(n); }
vec2 pair(float x) { return vec2(x); }";
    folder.file("all.frag", functions);
    let refused = |arguments: &[&str], said: Inline| {
        let ran =
            folder.0.run(&[&["bench", "all.frag"], arguments, &["--backend", "cpu"]].concat());
        ran.code(2).stdout_eq("").stderr_eq(said);
    };
    refused(
        &["--fn", "writes"],
        str![[r#"
error[cannot-call]: `writes(float)` cannot be sampled: it writes the buffer `Out`
 --> all.frag
  |
  = help: name a function that returns the value instead


"#]],
    );
    refused(
        &["--fn", "nothing"],
        str![[r#"
error[cannot-call]: `nothing(float)` cannot be sampled: it returns nothing
 --> all.frag
  |
  = help: name a function that returns something, has an `out` parameter or writes a global


"#]],
    );
    refused(
        &["--fn", "sampled"],
        str![[r#"
error[cannot-call]: `sampled(sampler2D, vec2)` cannot be sampled: `image` is a `sampler2D`, but arguments can only be numbers, vectors, matrices, and arrays or structures of them
 --> all.frag
  |
  = help: name the function that calls it


"#]],
    );
    refused(
        &["--fn", "ff"],
        str![[r#"
error[unknown-function]: the shader has no function `ff`
 --> all.frag
  |
  = help: did you mean `f`?


"#]],
    );
    refused(
        &["--fn", "f", "--variant", "more=#two"],
        str![[r#"
error[bad-request]: `--variant more` does not fit: it reads `n`, and `f(float)`, which it is compared with, reads `x`


"#]],
    );
    refused(
        &["--fn", "f", "--variant", "more=#pair"],
        str![[r#"
error[bad-request]: `--variant more` does not fit: `pair(float)` returns 2 floats, but the reference function 1 float


"#]],
    );
    refused(
        &["--fn", "f", "--variant", "more=#fff"],
        str![[r#"
error[unknown-function]: the shader has no function `fff`
 --> all.frag
  |
  = help: its functions are `writes(float)`, `nothing(float)`, `sampled(sampler2D, vec2)`, `f(float)`, `two(float, int)`, `pair(float)`


"#]],
    );
    refused(
        &["--fn", "f", "--domain", r#"{"y": "unit"}"#],
        str![[r#"
error[bad-domain]: the function has no input `y`
 --> --domain
  |
  = help: its inputs are `x`


"#]],
    );
    refused(
        &["--fn", "f", "--domain", r#"{"x": [2, 1]}"#],
        str![[r#"
error[bad-domain]: `x`: the range from 2 to 1 is inverted
 --> --domain
  |
  = help: write `[1, 2]`


"#]],
    );
    refused(
        &["--fn", "f", "--truth", "other"],
        str![[r#"
error[bad-request]: `--truth other` is not a variant
  |
  = help: the variants are `as it is`


"#]],
    );
    refused(
        &["--fn", "f", "--samples", "0"],
        str![[r#"
error: invalid value '0' for '--samples <N>': a run has 1 to 4194304 calls

For more information, try '--help'.

"#]],
    );
    refused(
        &["--fn", "f", "--variant", "a=#f", "--variant", "a=#two"],
        str![[r#"
error[bad-request]: `--variant a=#two` repeats the name of `--variant a=#f`
  |
  = help: give each a distinct name


"#]],
    );
    refused(
        &["--fn", "f", "--variant", "as it is=#f"],
        str![[r#"
error[bad-request]: `--variant as it is=#f` is the name of the original function
  |
  = help: choose another name


"#]],
    );
    refused(
        &["--fn", "f", "--variant", "a=gone.frag"],
        str![[r#"
error[unreadable-file]: `gone.frag` cannot be read: no such file or directory


"#]],
    );
}

#[test]
fn a_driver_that_refuses_says_what_its_compiler_said() {
    let folder = Folder::new("log");
    // The evaluator runs what it is asked for; OpenGL compiles the whole shader.
    let functions = "float rec(float x) { return x < 1.0 ? x : rec(x - 1.0); }
float f(float x) { return x; }";
    let file = folder.file("rec.frag", functions);
    let output = command::run(&["bench", &file, "--fn", "f", "--backend", "gl", "--rounds", "3"]);
    let said = output.out.replace("\n  ", " ");
    let line = said.lines().find(|line| line.starts_with("as it is on gl: "));
    assert!(line.is_some_and(|line| line.contains("static recursion")), "{said}\n{}", output.err);
}

#[test]
fn a_shader_on_stdin_is_read_once_for_all_its_variants() {
    let text = "#version 450\nfloat f(float x) { return x; }
float g(float x) { return x + 1.0; }\nvoid main() {}\n";
    let function = ["bench", "-", "--stage", "fragment", "--fn", "f", "--variant", "b=#g"];
    let command = command::landfall(&[&function[..], &["--backend", "cpu"], &SMALL].concat());
    let output = command::with_stdin(command, text.as_bytes());
    assert_eq!(output.code, 0, "{}", output.err);
    let found: Bench = serde_json::from_slice(&output.bytes).expect("a bench");
    assert_eq!(found.rows.len(), 2);
}

/// A driver that dies takes its variant with it, and neither the others nor the bench.
#[cfg(target_os = "linux")]
#[test]
fn a_driver_that_dies_fails_its_variant_and_the_others_go_on() {
    use std::process::Stdio;
    use std::time::Duration;

    let folder = Folder::new("death");
    // More steps than the evaluator takes. Mesa's llvmpipe leaves a loop after 65,535, which is
    // half a minute for all calls.
    let functions = "float f(float x) { return x + 1.0; }
float endless(float x) {
    for (int i = 0; i < 2000000000; i++) {
        x = sin(x) + 0.5;
    }
    return x;
}";
    let file = folder.file("slow.frag", functions);
    let mut command = command::landfall(&[]);
    command.args(["bench", &file, "--fn", "f", "--variant", "endless=#endless", "--variant"]);
    command.args(["again=#f", "--backend", "cpu,gl", "--rounds", "3", "--samples", "131072"]);
    let command = command.args(["--format", "json"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = command.spawn().unwrap();
    let parent = running.id();
    // The driver's process, once it has worked so long that it is at the endless one.
    let worked = |process: &str| -> Option<u64> {
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
        let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        let ticks = |at: usize| fields.get(at)?.parse::<u64>().ok();
        (fields.get(1)? == &parent.to_string()).then_some(ticks(11)? + ticks(12)?)
    };
    let stuck = loop {
        let all = std::fs::read_dir("/proc").unwrap().flatten();
        let names = all.filter_map(|entry| entry.file_name().into_string().ok());
        // In hundredths of a second.
        let mut stuck = names.filter(|name| worked(name).is_some_and(|ticks| ticks > 250));
        match stuck.next() {
            Some(process) => break process,
            None => std::thread::sleep(Duration::from_millis(20)),
        }
        if running.try_wait().unwrap().is_some() {
            let output = Ran::of(running.wait_with_output().unwrap());
            panic!("nobody killed it: {}", output.err);
        }
    };
    assert!(Command::new("kill").args(["-ABRT", &stuck]).status().unwrap().success());
    let output = Ran::of(running.wait_with_output().unwrap());
    assert_eq!(output.code, 0, "{}", output.err);
    let found: Bench = serde_json::from_slice(&output.bytes).unwrap();
    for backend in ["cpu", "gl"] {
        assert!(row(&found, "again", backend).errors.max_ulp.is_some_and(|ulp| ulp <= 0.5));
    }
    let failed = |backend: &str| {
        let found = found.failed.iter().find(|failed| failed.backend == backend);
        found.map(|failed| (failed.variant.as_str(), failed.reason.as_str()))
    };
    let Some(("endless", why)) = failed("gl") else { panic!("{found:?}") };
    golden().eq(why, str!["the driver process was ended by signal 6 (SIGABRT)"]);
    assert!(matches!(failed("cpu"), Some(("endless", _))), "{found:?}");
}
