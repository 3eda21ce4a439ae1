//! `landfall bench --fn`: what its errors are of. Held against the same functions in Rust on uniform
//! numbers of another generator.

use landfall_accuracy::bench::{Bench, BenchRow, SampleSet};
use serde_json::json;

use crate::support::command::Place;

/// A function of some numbers in `f32`, and in `f64` by its most accurate form.
struct Function {
    parameters: &'static [Parameter],
    code: &'static str,
    single: fn(&[f32]) -> f32,
    exact: fn(&[f64]) -> f64,
}

/// The name and the range of a parameter.
type Parameter = (&'static str, f64, f64);

const F0_C: &[Parameter] = &[("f0", 0.0, 1.0), ("c", 0.0, 1.0)];
const C_A: &[Parameter] = &[("c", 0.0, 1.0), ("a", 0.0, 1.0)];
const DISTANCE: &[Parameter] = &[("d", 0.0, 100.0), ("linear", 0.0, 1.0), ("quadratic", 0.0, 2.0)];
const PAIR: &[Parameter] = &[("intensity", 1.0, 3.0), ("radius", 1.0, 3.0)];

fn ggx(v: &[f64]) -> f64 {
    let (c, a) = (v[0], v[1]);
    let f = (1.0 - c) * (1.0 + c) + c * c * a * a;
    a * a / (f64::from(std::f32::consts::PI) * f * f)
}

fn fresnel(v: &[f64]) -> f64 {
    v[0] + (1.0 - v[0]) * (1.0 - v[1]).powi(5)
}

fn falloff(v: &[f64]) -> f64 {
    1.0 / (1.0 + v[0] * (v[1] + v[2] * v[0]))
}

fn smooth(v: &[f64]) -> f64 {
    v[0] * v[0] * (3.0 - 2.0 * v[0])
}

fn smith(v: &[f64]) -> f64 {
    v[0] / (v[0] + v[1] * (1.0 - v[0]))
}

const FUNCTIONS: [Function; 15] = [
    Function {
        parameters: F0_C,
        code: "float m = 1.0 - c; float m2 = m * m; return f0 + (1.0 - f0) * (m2 * m2 * m);",
        single: |v| {
            let m = 1.0 - v[1];
            let m2 = m * m;
            v[0] + (1.0 - v[0]) * (m2 * m2 * m)
        },
        exact: fresnel,
    },
    Function {
        parameters: F0_C,
        code: "float m = 1.0 - c; return f0 + m * m * m * m * m - f0 * (m * m * m * m * m);",
        single: |v| {
            let m = 1.0 - v[1];
            v[0] + m * m * m * m * m - v[0] * (m * m * m * m * m)
        },
        exact: fresnel,
    },
    Function {
        parameters: &[("c", 3.0, 7.0)],
        code: "return c * c * c;",
        single: |v| v[0] * v[0] * v[0],
        exact: |v| v[0] * v[0] * v[0],
    },
    Function {
        parameters: C_A,
        code: "float a2 = a * a; float f = (c * a2 - c) * c + 1.0; return a2 / (3.1415927 * f * f);",
        single: |v| {
            let a2 = v[1] * v[1];
            let f = (v[0] * a2 - v[0]) * v[0] + 1.0;
            a2 / (std::f32::consts::PI * f * f)
        },
        exact: ggx,
    },
    Function {
        parameters: C_A,
        code: "float f = (1.0 - c) * (1.0 + c) + c * c * a * a; return a * a / (3.1415927 * f * f);",
        single: |v| {
            let f = (1.0 - v[0]) * (1.0 + v[0]) + v[0] * v[0] * v[1] * v[1];
            v[1] * v[1] / (std::f32::consts::PI * f * f)
        },
        exact: ggx,
    },
    Function {
        parameters: DISTANCE,
        code: "return 1.0 / (1.0 + linear * d + quadratic * (d * d));",
        single: |v| 1.0 / (1.0 + v[1] * v[0] + v[2] * (v[0] * v[0])),
        exact: falloff,
    },
    Function {
        parameters: DISTANCE,
        code: "return 1.0 / (1.0 + d * (linear + quadratic * d));",
        single: |v| 1.0 / (1.0 + v[0] * (v[1] + v[2] * v[0])),
        exact: falloff,
    },
    Function {
        parameters: &[("cutOff", 0.0, 1.0)],
        code: "return cutOff * cutOff * (3.0 - 2.0 * cutOff);",
        single: |v| v[0] * v[0] * (3.0 - 2.0 * v[0]),
        exact: smooth,
    },
    Function {
        parameters: &[("cutOff", 0.0, 1.0)],
        code: "return 3.0 * cutOff * cutOff - 2.0 * cutOff * cutOff * cutOff;",
        single: |v| 3.0 * v[0] * v[0] - 2.0 * v[0] * v[0] * v[0],
        exact: smooth,
    },
    Function {
        parameters: &[("ndotl", 0.0, 1.0), ("k", 0.05, 1.0)],
        code: "return ndotl / (ndotl * (1.0 - k) + k);",
        single: |v| v[0] / (v[0] * (1.0 - v[1]) + v[1]),
        exact: smith,
    },
    Function {
        parameters: &[("ndotl", 0.0, 1.0), ("k", 0.05, 1.0)],
        code: "return ndotl / (ndotl + k * (1.0 - ndotl));",
        single: |v| v[0] / (v[0] + v[1] * (1.0 - v[0])),
        exact: smith,
    },
    Function {
        parameters: &[("shininess", 1.0, 1000.0)],
        code: "return sqrt(shininess + 1.0) - sqrt(shininess);",
        single: |v| (v[0] + 1.0).sqrt() - v[0].sqrt(),
        exact: |v| 1.0 / ((v[0] + 1.0).sqrt() + v[0].sqrt()),
    },
    Function {
        parameters: &[("shininess", 1.0, 1000.0)],
        code: "return 1.0 / (sqrt(shininess + 1.0) + sqrt(shininess));",
        single: |v| 1.0 / ((v[0] + 1.0).sqrt() + v[0].sqrt()),
        exact: |v| 1.0 / ((v[0] + 1.0).sqrt() + v[0].sqrt()),
    },
    Function {
        parameters: PAIR,
        code: "return intensity * intensity + radius * radius + 0.1;",
        single: |v| v[0] * v[0] + v[1] * v[1] + 0.1,
        exact: |v| v[0] * v[0] + v[1] * v[1] + f64::from(0.1f32),
    },
    Function {
        parameters: PAIR,
        code: "return sqrt(intensity * radius) / (intensity + radius);",
        single: |v| (v[0] * v[1]).sqrt() / (v[0] + v[1]),
        exact: |v| (v[0] * v[1]).sqrt() / (v[0] + v[1]),
    },
];

/// The samples of each side.
const SAMPLES: usize = 1 << 17;

/// Numbers from 0 to 1 (Knuth's 64-bit linear congruential generator; its upper 53 bits).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The median, the 99.9 % quantile and the maximum of the error in units of the last place.
fn measured(function: &Function) -> [f64; 3] {
    let mut numbers = Numbers(7);
    let mut errors: Vec<f64> = Vec::with_capacity(SAMPLES);
    for _ in 0..SAMPLES {
        let of = |&(_, low, high): &Parameter, x: f64| (low + (high - low) * x) as f32;
        let singles: Vec<f32> =
            function.parameters.iter().map(|one| of(one, numbers.next())).collect();
        let doubles: Vec<f64> = singles.iter().map(|x| f64::from(*x)).collect();
        let exact = (function.exact)(&doubles);
        let place = 2f64.powi(exact.abs().log2().floor() as i32 - 23);
        errors.push((f64::from((function.single)(&singles)) - exact).abs() / place);
    }
    errors.sort_by(f64::total_cmp);
    [errors[SAMPLES / 2], errors[SAMPLES * 999 / 1000], errors[SAMPLES - 1]]
}

/// The bench of a function whose parameters have some names.
fn bench(function: &Function, names: &[String], place: &Place) -> Bench {
    let mut code = function.code.to_string();
    let words = |code: &str, from: &str, to: &str| -> String {
        // Whole words: the text with each run of letters and digits compared.
        let mut text = String::new();
        let mut word = String::new();
        for c in code.chars().chain(['\n']) {
            if c.is_alphanumeric() || c == '_' {
                word.push(c);
                continue;
            }
            text += if word == from { to } else { &word };
            word.clear();
            text.push(c);
        }
        text
    };
    for ((name, ..), other) in function.parameters.iter().zip(names) {
        code = words(&code, name, other);
    }
    let parameters: Vec<String> = names.iter().map(|name| format!("float {name}")).collect();
    let text = format!(
        "#version 450\nfloat f({}) {{ {code} }}\nvoid main() {{}}\n",
        parameters.join(", ")
    );
    place.write("f.frag", &text);
    let ranges = names.iter().zip(function.parameters);
    let ranges = ranges.map(|(name, (_, low, high))| (name.clone(), json!([low, high])));
    let domain = serde_json::Value::Object(ranges.collect()).to_string();
    let samples = SAMPLES.to_string();
    let ran = place.run(&[
        "bench",
        "f.frag",
        "--fn",
        "f",
        "--domain",
        &domain,
        "--samples",
        &samples,
        "--backend",
        "cpu",
        "--rounds",
        "3",
        "--format",
        "json",
    ]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    serde_json::from_value(ran.json()).expect("a bench")
}

fn only(bench: &Bench) -> &BenchRow {
    assert_eq!(bench.rows.len(), 1, "{:?}", bench.failed);
    &bench.rows[0]
}

/// 30 pairs of functions and domains: 15 functions, each with names of its field and without.
#[test]
fn errors_are_those_of_uniform_numbers_whatever_the_parameters_are_called() {
    let place = Place::new("bench-inputs-uniform");
    for function in &FUNCTIONS {
        let wanted @ [median, most_of, max] = measured(function);
        let plain: Vec<String> =
            function.parameters.iter().map(|(name, ..)| (*name).to_string()).collect();
        let neutral: Vec<String> = (0..plain.len()).map(|i| format!("zq{i}")).collect();
        for names in [plain, neutral] {
            let found = bench(function, &names, &place);
            let errors = only(&found).errors;
            let (own_median, own_most, own_max) =
                (errors.median_ulp.unwrap(), errors.p999_ulp.unwrap(), errors.max_ulp.unwrap());
            let about = format!("{} with {names:?}: {errors:?}, not {wanted:?}", function.code);
            assert!((own_median - median).abs() <= 0.05 * median.max(0.1), "{about}");
            assert!((own_most - most_of).abs() <= 0.2 * most_of, "{about}");
            assert!(own_max >= max / 2.0, "{about}");
            assert_eq!(found.inputs.as_ref().map(|inputs| inputs.drawn), Some(SAMPLES as u64));
        }
    }
}

#[test]
fn a_bench_states_its_distributions_and_lists_ends_apart() {
    let place = Place::new("bench-inputs-ends");
    // At its lower end the function is NaN, near it exact.
    let text = "#version 450
float f(float c, vec3 n, float free) { return sqrt(c) + 0.0 * (n.x / c) + 0.0 * free; }
void main() {}
";
    place.write("f.frag", text);
    place.write("d.json", r#"{"edges": [0, 1, 4], "counts": [0, 2]}"#);
    let run = |domain: &str| -> Bench {
        let ran = place.run(&[
            "bench",
            "f.frag",
            "--fn",
            "f",
            "--domain",
            domain,
            "--samples",
            "1600",
            "--backend",
            "cpu",
            "--rounds",
            "3",
            "--format",
            "json",
        ]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        serde_json::from_value(ran.json()).expect("a bench")
    };
    let found = run(r#"{"c": [0, 4], "n": "unit", "n.z": [0, 1]}"#);
    let inputs = found.inputs.as_ref().expect("it has inputs");
    assert_eq!((inputs.drawn, inputs.ends), (1600, 100));
    let texts: Vec<(&str, &str)> =
        inputs.distributions.iter().map(|i| (i.path.as_str(), i.distribution.as_str())).collect();
    let wanted = [
        ("c", "uniform in 0..4"),
        ("n", "unit, uniform over directions, z uniform in 0..1"),
        ("free", "as in scenes"),
    ];
    assert_eq!(texts, wanted);
    let row = only(&found);
    let ends = row.ends.expect("ranges are stated");
    assert_eq!((row.errors.non_finite, row.errors.undefined), (0, 0));
    assert!(ends.undefined > 5, "{ends:?}");
    assert_eq!(ends.channels + ends.undefined + ends.non_finite, 100, "{ends:?}");
    assert!(row.worst.iter().any(|worst| worst.of == SampleSet::Drawn
        && worst.inputs["c"].as_f64().is_some_and(|c| c > 0.0 && c < 4.0)
        && worst.inputs["n"].as_array().is_some_and(|n| n.len() == 3)));
    let of = |domain: &str| {
        let found = run(domain);
        found.inputs.expect("it has inputs").distributions[0].distribution.clone()
    };
    assert_eq!(of(r#"{"c": {"histogram": "d.json"}}"#), "histogram in 0..4");
    assert_eq!(of(r#"{"c": {"log": [0.01, 4]}}"#), "log in 0.01..4");
    assert_eq!(of(r#"{"c": [0.1, 0.1]}"#), "fixed at 0.1");
    let normal = of(r#"{"c": {"normal": [2, 0.5], "in": [1, 4]}}"#);
    assert_eq!(normal, "normal (mean 2, deviation 0.5) in 1..4");
    // Of values in 0..1 and 1..4 as 3 to 1, a quarter is above 1: within four standard deviations.
    place.write("d.json", r#"{"edges": [0, 1, 4], "counts": [3, 1]}"#);
    place.write("f.frag", text.replace("sqrt(c)", "sqrt(1.0 - c)"));
    let quarter = only(&run(r#"{"c": {"histogram": "d.json"}}"#)).errors.undefined;
    assert!((330..=470).contains(&quarter), "{quarter} of 1600");
    // What is not stated has no ends.
    assert_eq!(only(&run("{}")).ends, None);
}

#[test]
fn a_robust_form_is_not_judged_by_the_form_that_it_replaces() {
    let place = Place::new("bench-inputs-truth");
    // Near a = 0 and c = 1, the textbook form has no digit left, in f64 neither.
    let text = "#version 450
float textbook(float c, float a) {
    float a2 = a * a; float f = (c * a2 - c) * c + 1.0; return a2 / (3.1415927 * f * f);
}
float factored(float c, float a) {
    float f = (1.0 - c) * (1.0 + c) + c * c * a * a; return a * a / (3.1415927 * f * f);
}
float other(float c, float a) { return a; }
void main() {}
";
    place.write("f.frag", text);
    let of = |more: &[&str]| -> Bench {
        let own = [
            "bench",
            "f.frag",
            "--fn",
            "textbook",
            "--variant",
            "factored=#factored",
            "--variant",
            "other=#other",
            "--domain",
            r#"{"c": {"log": [0.5, 1]}, "a": {"log": [1e-6, 1e-2]}}"#,
            "--samples",
            "65536",
            "--backend",
            "cpu",
            "--rounds",
            "3",
            "--format",
            "json",
        ];
        let ran = place.run(&[&own[..], more].concat());
        assert_eq!(ran.code, 0, "{}", ran.err);
        serde_json::from_value(ran.json()).expect("a bench")
    };
    let ends = |bench: &Bench| bench.rows[1].ends.and_then(|ends| ends.max_ulp).expect("ulp");
    let found = of(&[]);
    assert_eq!(found.truth, "the f64 of factored, the most accurate form");
    // Four roundings of half a unit before the square, of which each counts twice, and two after.
    assert!(ends(&found) < 12.0, "{:?}", found.rows[1].ends);
    // By the other form it looks as if it were wrong.
    let named = of(&["--truth", "as it is"]);
    assert_eq!(named.truth, "the function's own f64");
    assert!(ends(&named) > 100.0, "{:?}", named.rows[1].ends);
}

#[test]
fn distributions_that_do_not_fit_are_refused_by_path() {
    let place = Place::new("bench-inputs-refused");
    place.write("f.frag", "#version 450\nfloat f(float x, vec3 n) { return x * n.x; }\n");
    for (domain, said) in [
        (r#"{"x": {"log": [0, 1]}}"#, "`x`: a range with 0 in it has no logarithmic distribution"),
        (r#"{"x": {"normal": [0, 0]}}"#, "`x`: 0 is not a standard deviation"),
        (
            r#"{"x": {"normal": [0, 1], "in": [5, 6]}}"#,
            "`x`: the range is more than 3 standard deviations from the mean",
        ),
        (r#"{"x": {"square": [0, 1]}}"#, "`x`: unknown distribution \"square\""),
        (r#"{"x": {"log": [1, 2], "in": [1, 2]}}"#, "`x`: \"in\" has no meaning beside \"log\""),
        (r#"{"x": {}}"#, "`x`: not one distribution"),
        (r#"{"x": {"histogram": {"edges": [0, 0], "counts": [1]}}}"#, "`x`: a histogram is"),
        (r#"{"x": {"histogram": "none.json"}}"#, "`none.json` cannot be read"),
        (r#"{"n.w": [0, 1]}"#, "the function has no input `n.w`"),
        (r#"{"n.x": "unit"}"#, "`n.x` is not a vector and cannot be `unit`"),
        (r#"{"n.x": [2, 3], "n": "unit"}"#, "only 0 of"),
    ] {
        let ran = place.run(&["bench", "f.frag", "--fn", "f", "--domain", domain]);
        assert_eq!(ran.code, 2, "{domain}: {}", ran.out);
        assert!(ran.err.contains(said), "{domain}: {}", ran.err);
    }
}

#[test]
fn stress_and_prove_have_the_same_domains() {
    let place = Place::new("bench-inputs-stress");
    let text = "#version 450
float f(vec3 n) { return 1.0 / n.z; }
float g(int i, int n) { return float(i % n); }
void main() {}
";
    place.write("f.frag", text);
    let unit = r#"{"n": "unit", "n.z": [0.25, 1]}"#;
    let own = ["stress", "f.frag", "--fn", "f", "--format", "json", "--samples", "20000"];
    let ran = place.run(&[&own[..], &["--domain", unit]].concat());
    let report = ran.code(0).json();
    assert_eq!(report["inputs"][0]["domain"], "unit, z in 0.25..1");
    let family = |name: &str| {
        let all = report["families"].as_array().expect("families");
        all.iter().find(|one| one["family"] == name).expect("it is listed").clone()
    };
    let drawn = family("drawn");
    assert!(drawn["samples"].as_u64().is_some_and(|samples| samples > 1000), "{drawn}");
    // Nothing is stated, and 1 / 0 is found.
    let free = place.run(&own);
    assert_eq!(free.code, 1);
    place.run(&["prove", "f.frag", "--fn", "f", "--domain", unit]).code(0);
    place.run(&["prove", "f.frag", "--fn", "f", "--domain", r#"{"n": "unit"}"#]).code(1);
    // A remainder by 0 is not in the domain, nor is one found by making inputs simpler.
    let whole = r#"{"i": [-8, 8], "n": [1, 16]}"#;
    let ran = place.run(&["stress", "f.frag", "--fn", "g", "--domain", whole, "--samples", "5000"]);
    assert!(!ran.out.contains("division"), "{}", ran.out);
}
