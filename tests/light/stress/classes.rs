//! Functions with a fault and their mended twins: the class comes from the operation that breaks, and
//! advice that is given mends it and changes nothing else. What is expected is the specification's.

use landfall_accuracy::stress::{Report, Request, StressFinding};
use landfall_interp::UndefinedKind;
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::Source;
use landfall_layout::finding::Level;

use super::{all, domain, line, request, run, shader};

/// A function of a file: its name, the domain, the code of its fault and the text where that is.
struct Row {
    path: String,
    name: String,
    domain: String,
    code: String,
    at: String,
}

fn rows() -> Vec<Row> {
    let files = ["geometry", "colour", "integer", "packing", "sampling"];
    let paths = files.map(|file| format!("tests/light/stress/functions/{file}.frag"));
    let read = |path: &String| -> Vec<Row> {
        let text = shader(path).text;
        let row = |line: &str| {
            let parts: Vec<&str> = line.strip_prefix("// ")?.split(" | ").collect();
            let [name, domain, code, at] = parts[..] else { return None };
            let [name, domain, code, at] = [name, domain, code, at].map(str::to_string);
            domain.starts_with('{').then(|| Row { path: path.clone(), name, domain, code, at })
        };
        text.lines().filter_map(row).collect()
    };
    paths.iter().flat_map(read).collect()
}

fn stressed(source: &Source, function: &str, json: &str) -> Report {
    let request = Request { samples: 16_000, domain: domain(json), ..request(function) };
    run(source, &request)
}

/// The findings that a person is shown.
fn shown(report: &Report) -> impl Iterator<Item = &StressFinding> {
    report.findings.iter().filter(|found| found.plausible || found.level == Level::Deny)
}

/// The shader with the advice of a finding.
fn mended(source: &Source, found: &StressFinding) -> Option<Source> {
    let advice = found.advice.as_ref()?;
    let span = advice.span;
    let (before, after) = (&source.text[..span.start as usize], &source.text[span.end as usize..]);
    let text = format!("{before}({}){after}", advice.code);
    Some(Source { text: text.into(), ..source.clone() })
}

#[test]
fn functions_have_the_class_of_the_operation_that_breaks_and_their_twins_have_none() {
    let rows = rows();
    assert!(rows.len() >= 50, "{}", rows.len());
    let (mut missed, mut loud, mut wrong, mut given) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for row in &rows {
        let source = shader(&row.path);
        let report = stressed(&source, &format!("{}_bad", row.name), &row.domain);
        let is_it = |found: &&StressFinding| {
            found.hazard.code() == row.code && line(&report, found).contains(&row.at)
        };
        let Some(found) = shown(&report).find(is_it) else {
            missed.push(format!("{} {}:\n{}", row.name, row.code, all(&report)));
            continue;
        };
        if let Some(mended) = mended(&source, found) {
            given += 1;
            // The fault is gone, and what was right is: the advice has no class of its own.
            let after = stressed(&mended, &format!("{}_bad", row.name), &row.domain);
            if let Some(still) = shown(&after).find(is_it) {
                wrong.push(format!("{}: {:?}\n{}", row.name, still.advice, all(&after)));
            }
        }
        let twin = stressed(&source, &format!("{}_ok", row.name), &row.domain);
        if shown(&twin).next().is_some() {
            loud.push(format!("{}:\n{}", row.name, all(&twin)));
        }
    }
    println!(
        "{} of {} functions found with their class, {} of {} twins silent, {} of {given} advices right",
        rows.len() - missed.len(),
        rows.len(),
        rows.len() - missed.len() - loud.len(),
        rows.len() - missed.len(),
        given - wrong.len()
    );
    let all = [missed, loud, wrong];
    assert!(all.iter().all(Vec::is_empty), "{}", all.concat().join("\n"));
}

/// The first finding of a function of a text.
fn first(name: &str, text: &str, json: &str) -> (StressFinding, String) {
    let report = stressed(&Source::new(name, text), "f", json);
    let found = shown(&report)
        .next()
        .unwrap_or_else(|| panic!("nothing found in {text}:\n{}", all(&report)));
    let lint = report.lint(found);
    (found.clone(), format!("{}\n{}", found.message(), lint.notes.join("\n")))
}

fn fragment(code: &str) -> String {
    format!("#version 450\n{code}\nvoid main() {{}}\n")
}

/// GLSL 4.60 8.1: `acos` is undefined where |x| > 1. No host rejects that as "too large".
#[test]
fn an_inverse_cosine_out_of_its_range_is_undefined_and_clamped() {
    let text = fragment("float f(float x) { return acos(x); }");
    let (found, said) = first("f.frag", &text, r#"{"x": [-1.5, 1.5]}"#);
    assert_eq!(found.kind, Some(UndefinedKind::ArcOutOfRange));
    let advice = found.advice.expect("a clamp is tried");
    assert_eq!(advice.code, "acos(clamp(x, -1.0, 1.0))");
    assert!(!said.contains("host") && !said.contains("range of its float type"), "{said}");
}

/// For unit vectors, 2 atan(|a - b| / |a + b|) is their angle, which the rounded cosine has not where
/// it is small; for others, it is another number than the inverse cosine.
#[test]
fn the_angle_of_unit_vectors_is_advised_without_the_cosine() {
    let text = fragment("float f(vec3 a, vec3 b) { return acos(dot(a, b)); }");
    let source = Source::new("f.frag", &*text);
    let (found, _) = first("f.frag", &text, r#"{"a": "unit", "b": "unit"}"#);
    let advice = found.advice.as_ref().expect("the angle is tried");
    assert_eq!(advice.code, "2.0 * atan(length(a - b), length(a + b))");
    assert!(advice.text().contains("others change as by a rounding"), "{}", advice.text());
    let mended = mended(&source, &found).expect("it has advice");
    let after = stressed(&mended, "f", r#"{"a": "unit", "b": "unit"}"#);
    assert!(shown(&after).next().is_none(), "{}", all(&after));
    assert!(after.max_steps() < 0.01, "{} steps", after.max_steps());
    let (found, _) = first("f.frag", &text, r#"{"a": [-1, 1], "b": [-1, 1]}"#);
    assert_eq!(found.advice.expect("a clamp is tried").code, "acos(clamp(dot(a, b), -1.0, 1.0))");
}

/// WGSL 8.7: the remainder has the sign of the dividend, so that an index from it is negative.
#[test]
fn an_index_from_a_negative_remainder_is_made_positive() {
    let text = "fn f(i: i32) -> f32 {
    var w = array<f32, 8>(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[i % 8];
}
";
    let (found, _) = first("f.wgsl", text, r#"{"i": [-16, 16]}"#);
    assert_eq!(found.hazard, Hazard::NegativeRemainder);
    assert_eq!(found.advice.expect("it is tried").code, "w[((i % 8) + 8) % 8]");
}

/// A miss is not made a hit: the root of -3 is no root of a rounding error.
#[test]
fn a_discriminant_that_is_clearly_negative_is_not_clamped() {
    let text = fragment(
        "float f(float b, float c) {
    return -b - sqrt(b * b - c);
}",
    );
    let (found, said) = first("f.frag", &text, r#"{"b": [0, 1], "c": [2, 4]}"#);
    assert_eq!(found.kind, Some(UndefinedKind::RootOfNegative));
    assert_eq!(found.advice, None, "{said}");
    assert!(said.contains("test it before"), "{said}");
}

/// By hand: `f - d (f - n)` is `f (1 - d) + n d`, whose terms have one sign.
#[test]
fn a_linear_depth_is_advised_by_weights_that_add_up_to_one() {
    let text = fragment(
        "float f(float d, float n, float far) {
    return n * far / (far - d * (far - n));
}",
    );
    let json = r#"{"d": [0, 1], "n": [0.01, 0.01], "far": [10000, 10000]}"#;
    let (found, said) = first("f.frag", &text, json);
    assert_eq!(found.hazard, Hazard::Cancellation, "{said}");
    let advice = found.advice.as_ref().expect("a form is tried");
    assert_eq!(advice.code, "far * (1.0 - d) + n * d");
    assert!(!said.contains("ill-conditioned"), "{said}");
}

/// Letters are no roles: `c` is a cosine here, `d` a depth.
#[test]
fn letters_are_not_taken_for_lights() {
    let ggx = "float f(float c, float a) {
    float a2 = a * a;
    float d = (c * a2 - c) * c + 1.0;
    return a2 / (d * d);
}";
    let square = "float f(vec3 d, float power) { return power / dot(d, d); }";
    let cases =
        [(ggx, r#"{"c": [0, 1], "a": [0, 1]}"#), (square, r#"{"d": [-1, 1], "power": [0, 9]}"#)];
    for (code, json) in cases {
        let report = stressed(&Source::new("f.frag", fragment(code)), "f", json);
        let codes: Vec<&str> = shown(&report).map(|found| found.hazard.code()).collect();
        assert!(codes.contains(&"division-by-zero"), "{codes:?}");
        for found in shown(&report) {
            let words = found.message() + found.remedy().unwrap_or_default();
            for light in ["light", "attenuation", "normalis"] {
                assert!(!words.contains(light), "{words}");
            }
        }
    }
}

/// An octahedral component near 0 is units of the last place off, but no step.
#[test]
fn units_of_the_last_place_near_zero_are_no_finding() {
    let code = "vec3 f(vec3 n) {
    vec2 p = n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 1.0e-6);
    vec2 s = vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    vec2 e = n.z >= 0.0 ? p : (1.0 - abs(p.yx)) * s;
    vec3 m = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float t = max(-m.z, 0.0);
    m.x += m.x >= 0.0 ? -t : t;
    m.y += m.y >= 0.0 ? -t : t;
    return m * inversesqrt(dot(m, m));
}";
    let report = stressed(&Source::new("f.frag", fragment(code)), "f", r#"{"n": "unit"}"#);
    assert!(shown(&report).next().is_none(), "{}", all(&report));
}

/// Where 16 bits cannot hold the input, no formula is unstable.
#[test]
fn the_rounding_of_an_input_to_half_precision_is_told_from_that_of_an_operation() {
    let code =
        "float f(vec3 a, vec3 b) { vec3 d = (a - b) * 0.0078125; return 128.0 * sqrt(dot(d, d)); }";
    let mut request = Request { samples: 16_000, ..request("f") };
    request.domain = domain(r#"{"a": [-1000, 1000], "b": [-1000, 1000]}"#);
    request.pure.floats = landfall_interp::Floats::Half;
    let report = run(&Source::new("f.frag", fragment(code)), &request);
    let of_input: Vec<&StressFinding> =
        shown(&report).filter(|found| found.message().contains("rounds an input")).collect();
    assert!(!of_input.is_empty(), "{}", all(&report));
    for found in of_input {
        let notes = found.notes().join("\n");
        assert!(!notes.contains("unstable"), "{notes}");
    }
}

/// Found inputs are in the domain: there `k - 4` is 0 at 4 alone, and no divisor is 0.
#[test]
fn simplified_inputs_stay_in_the_domain() {
    let code = "float f(float x, int k) { return log2(x) / float(k - 4); }";
    let (found, _) = first("f.frag", &fragment(code), r#"{"x": [0.5, 2], "k": [2, 9]}"#);
    let flat: Vec<f64> = found.case.flat.iter().flat_map(|(_, values)| values.clone()).collect();
    assert!(matches!(flat[..], [x, 4.0] if (0.5..=2.0).contains(&x)), "{flat:?}");
    let rem = fragment("int f(int i, int n) { return i % n; }");
    let report = stressed(&Source::new("f.frag", rem), "f", r#"{"i": [0, 9], "n": [1, 16]}"#);
    assert!(report.findings.is_empty(), "{}", all(&report));
}

/// The fractional part of -1e-14 is 1 in f32, and 8 no index of 8 elements.
#[test]
fn rounding_that_takes_an_index_past_its_array_is_found() {
    let code = "float f(float x) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[int(mod(x, 1.0) * 8.0)];
}";
    let (found, said) = first("f.frag", &fragment(code), "{}");
    assert_eq!((found.hazard, found.level), (Hazard::IndexOutOfBounds, Level::Deny), "{said}");
    let code = found.advice.expect("a bound is tried").code;
    assert!(code.starts_with("w[min(") || code.starts_with("w[clamp("), "{code}");
}

/// In f32 `b * b` is off by 0.03 where it is 1e6, and the ray misses a sphere of radius 1 that it hits.
#[test]
fn a_branch_that_rounding_flips_is_searched_for() {
    let code = "float f(vec3 o, vec3 d, float r) {
    float b = dot(o, d);
    float h = b * b - dot(o, o) + r * r;
    if (h < 0.0) { return -1.0; }
    return -b - sqrt(h);
}";
    let json = r#"{"o": [-1000, 1000], "d": "unit", "r": [0.5, 2]}"#;
    for seed in 1..4 {
        let request =
            Request { samples: 8_000, seed, time: None, domain: domain(json), ..request("f") };
        let report = run(&Source::new("f.frag", fragment(code)), &request);
        let found = report.findings.iter().find(|f| f.hazard == Hazard::BranchDivergence);
        let found = found.unwrap_or_else(|| panic!("seed {seed}:\n{}", all(&report)));
        let edge = found.edge.expect("samples were run around it");
        assert!(edge.flipped > 0 && edge.flipped < edge.near, "{edge:?}");
        assert!(found.notes().join("\n").contains("take the wrong one"));
        let advice = found.advice.as_ref().unwrap_or_else(|| panic!("{}", all(&report)));
        assert_eq!(advice.code, "r * r - dot(o - d * b, o - d * b)");
        assert!(advice.text().contains("rounding decides in "), "{}", advice.text());
    }
    // With the form, no branch is flipped often; where `d` is no unit vector, it is another function.
    let mended = code.replace("b * b - dot(o, o) + r * r", "r * r - dot(o - d * b, o - d * b)");
    let asked =
        |json: &str| Request { samples: 8_000, time: None, domain: domain(json), ..request("f") };
    let report = run(&Source::new("f.frag", fragment(&mended)), &asked(json));
    assert!(
        report.findings.iter().all(|f| f.hazard != Hazard::BranchDivergence),
        "{}",
        all(&report)
    );
    let free = asked(r#"{"o": [-1000, 1000], "d": [-2, 2], "r": [0.5, 2]}"#);
    let report = run(&Source::new("f.frag", fragment(code)), &free);
    assert!(report.findings.iter().all(|f| f.advice.is_none()), "{}", all(&report));
}
