//! The order of run times in `landfall bench --fn`, held against the same functions compiled by
//! `rustc -O`.

use std::process::Command;

use landfall_accuracy::bench::Bench;

use crate::support::command::Place;
use crate::support::rustc;

/// Two forms of a function of numbers from 0.1 to 0.9, in what GLSL and Rust spell alike.
const PAIRS: [[&str; 2]; 12] = [
    ["x * x * x * x * x", "pow(x, 5.5)"],
    ["y + (1.0 - y) * pow(1.0 - x, 5.5)", "(1.0 - x) * (1.0 - x) * (1.0 - y) + y"],
    ["sqrt(x)", "exp(0.5 * log(x))"],
    ["exp(-x)", "1.0 / (1.0 + x * (1.0 + 0.5 * x))"],
    ["sin(x)", "x - x * x * x * (0.16666667 - x * x * 0.008333333)"],
    ["acos(x)", "sqrt(1.0 - x) * (1.5707288 + x * (x * 0.074261 - 0.2121144))"],
    ["log(1.0 + x)", "x * (1.0 - x * (0.5 - x * 0.33333333))"],
    ["1.0 / (1.0 + x * (y + z * x))", "1.0 / pow(1.0 + x, 1.5 + y)"],
    ["x / z + y / z + x * y / z", "(x + y + x * y) * z"],
    ["sin(x) * cos(y) + cos(x) * sin(y)", "sin(x + y)"],
    ["tan(x)", "x / (1.0 - x * x * 0.4)"],
    ["exp(x) * exp(y) * exp(z)", "exp(x + y + z)"],
];

/// Times that differ by more than this must be in one order.
const APART: f64 = 1.3;

/// What the functions are called by in Rust, and what times them: the least of several rounds over
/// numbers that the compiler does not know, in nanoseconds a call.
const PROGRAM: &str = "
use std::hint::black_box;
use std::time::Instant;
fn pow(x: f32, y: f32) -> f32 { x.powf(y) }
fn sqrt(x: f32) -> f32 { x.sqrt() }
fn exp(x: f32) -> f32 { x.exp() }
fn log(x: f32) -> f32 { x.ln() }
fn sin(x: f32) -> f32 { x.sin() }
fn cos(x: f32) -> f32 { x.cos() }
fn tan(x: f32) -> f32 { x.tan() }
fn acos(x: f32) -> f32 { x.acos() }
fn timed(f: impl Fn(f32, f32, f32) -> f32, numbers: &[[f32; 3]]) -> f64 {
    let mut results = vec![0.0f32; numbers.len()];
    let mut least = f64::INFINITY;
    for _ in 0..60 {
        let start = Instant::now();
        for (result, [x, y, z]) in results.iter_mut().zip(black_box(numbers)) {
            *result = f(*x, *y, *z);
        }
        black_box(&results);
        least = least.min(start.elapsed().as_nanos() as f64);
    }
    least / numbers.len() as f64
}
";

/// Returns the times of all pairs in a program that `rustc -O` compiles.
fn compiled() -> Vec<[f64; 2]> {
    let lines = PAIRS.iter().flatten().map(|code| {
        let used =
            |name: &str| if code.contains(name) { name.to_string() } else { format!("_{name}") };
        let [x, y, z] = ["x", "y", "z"].map(used);
        format!("    println!(\"{{}}\", timed(|{x}, {y}, {z}| {code}, &numbers));\n")
    });
    let numbers = "(0..1 << 14).map(|n| [n, n * 7, n * 13].map(|k| \
                   0.1 + 0.8 * ((k * 2654435761usize) % 65536) as f32 / 65536.0)).collect()";
    let main = format!(
        "fn main() {{\n    let numbers: Vec<[f32; 3]> = {numbers};\n{}}}\n",
        lines.collect::<String>()
    );
    let folder = rustc::scratch("bench-order");
    let (root, program) = (folder.join("order.rs"), folder.join("order"));
    std::fs::write(&root, format!("#![allow(dead_code, unused_parens)]{PROGRAM}{main}"))
        .expect("scratch can be written to");
    let mut command = Command::new("rustc");
    command.env_remove("RUSTC_BOOTSTRAP").arg(&root).args(["-O", "--edition", "2024", "-o"]);
    let built = command.arg(&program).output().expect("rustc compiled this test");
    assert!(built.status.success(), "{}", rustc::shown(&built.stderr));
    let ran = Command::new(&program).output().expect("the program was just built");
    let times = String::from_utf8(ran.stdout).expect("numbers");
    let times: Vec<f64> = times.lines().map(|line| line.parse().expect("a number")).collect();
    times.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Returns the times of a pair on the interpreter.
fn interpreted(place: &Place, pair: [&str; 2]) -> [f64; 2] {
    let function = |name: &str, code: &str| {
        format!("float {name}(float x, float y, float z) {{ return {code}; }}\n")
    };
    let [a, b] = pair;
    let text = format!("#version 450\n{}{}void main() {{}}\n", function("f", a), function("g", b));
    place.write("pair.frag", text);
    let domain = r#"{"x": [0.1, 0.9], "y": [0.1, 0.9], "z": [0.1, 0.9]}"#;
    let bench = ["bench", "pair.frag", "--fn", "f", "--variant", "g=#g"];
    let more = ["--domain", domain, "--backend", "cpu", "--samples", "10000", "--format", "json"];
    let ran = place.run(&[&bench[..], &more].concat());
    assert_eq!(ran.code, 0, "{}", ran.err);
    let bench: Bench = serde_json::from_value(ran.json()).expect("a bench");
    let times: Vec<f64> = bench.rows.iter().map(|row| row.fragment.median).collect();
    times.try_into().expect("two variants")
}

/// Pairs whose times are nearer to each other than that in Rust may be in either order.
#[test]
#[ignore = "measures times, which other work disturbs: ./tests/run command"]
fn run_times_are_in_the_order_of_compiled_code() {
    let place = Place::new("bench-order");
    let mut wrong = Vec::new();
    let mut apart = 0;
    for (pair, [a, b]) in PAIRS.into_iter().zip(compiled()) {
        let [own_a, own_b] = interpreted(&place, pair);
        let line = format!("{pair:?}: rustc {a:.2} and {b:.2} ns, bench {own_a:.1} and {own_b:.1}");
        println!("{line}");
        if a.max(b) > APART * a.min(b) {
            apart += 1;
            if (a < b) != (own_a < own_b) {
                wrong.push(line);
            }
        }
    }
    assert!(apart >= 8, "only {apart} pairs differ by more than {APART}");
    assert!(wrong.is_empty(), "{wrong:#?}");
}
