//! The report of a run: undefined operations, divergence of f32 and f64, costs, endless loops.

use super::support::{program, run, single, watched};
use landfall_interp::backend::FailureKind;
use landfall_interp::{Precision, Settings, UndefinedKind as U};

#[test]
fn undefined_operations_are_noted_with_their_place() {
    let cases: [(&str, f32, f32, U); 20] = [
        ("a / b", 1.0, 0.0, U::DivisionByZero),
        ("a * b", 0.0, f32::INFINITY, U::ZeroTimesInfinity),
        ("sqrt(a)", -1.0, 0.0, U::RootOfNegative),
        ("inverseSqrt(a)", 0.0, 0.0, U::RootOfNegative),
        ("log2(a)", 0.0, 0.0, U::LogOfNonPositive),
        ("pow(a, b)", -2.0, 2.0, U::PowOfNegative),
        ("pow(a, b)", 0.0, 0.0, U::PowOfZero),
        ("acos(a)", 1.5, 0.0, U::ArcOutOfRange),
        ("asin(a)", -1.5, 0.0, U::ArcOutOfRange),
        ("atan2(a, b)", 0.0, 0.0, U::AtanOfZeros),
        ("normalize(vec3<f32>(a, b, a)).x", 0.0, 0.0, U::NormalizeOfZero),
        ("smoothstep(a, b, 0.5)", 1.0, 1.0, U::SmoothStepEdges),
        ("f32(i32(a))", 3e9, 0.0, U::ConversionOutOfRange),
        ("f32(1 / i32(a))", 0.0, 0.0, U::IntegerDivisionByZero),
        ("array<f32, 3>(a, b, a)[u32(b)]", 1.0, 3.0, U::IndexOutOfBounds),
        ("a * b", 1e30, 1e30, U::BornInfinite),
        ("max(b, sqrt(a))", -1.0, 0.0, U::NanCompared),
        ("min(sqrt(a), b)", -1.0, 0.0, U::NanCompared),
        ("clamp(sqrt(a), 0.0, b)", -1.0, 1.0, U::NanCompared),
        ("step(sqrt(a), b)", -1.0, 0.0, U::NanCompared),
    ];
    for (expression, a, b, kind) in cases {
        let p = program(&format!(
            "fn f(a: f32, b: f32) -> f32 {{\n    let fine = 1.0;\n    return {expression};\n}}"
        ));
        // Three invocations; those beside the one at fault are in order.
        let arguments: [&[f32]; 2] = [&[0.5, a, 0.25], &[1.0, b, 2.0]];
        let notes = run(&p, "f", &arguments, &watched()).expect("it runs").notes;
        let noted = notes.undefined.iter().find(|u| u.kind == kind);
        let noted = noted.unwrap_or_else(|| panic!("{expression}: {:?}", notes.undefined));
        assert_eq!(noted.place.function, "f");
        assert!(noted.place.shown.starts_with("test.wgsl:3:"), "{:?}", noted.place);
        let ours = noted.count == 1 || expression.contains("i32(a)");
        assert!(ours, "{expression}: {noted:?}");
        if !expression.contains("i32(a)") {
            let notes = run(&p, "f", &[&[0.5], &[1.0]], &watched()).expect("it runs").notes;
            assert!(notes.undefined.iter().all(|u| u.kind != kind), "{expression}");
        }
    }
}

#[test]
fn lengths_whose_squares_leave_the_range_are_noted() {
    let p = program("fn f(a: f32) -> f32 { return normalize(vec3f(a, 0.0, 0.0)).x; }");
    let g = program("fn f(a: f32) -> f32 { return length(vec2f(0.0, a)); }");
    // 2^64 squared is 2^128, past f32; 2^-64 squared is 2^-128, below the smallest normal 2^-126.
    let cases = [
        (2f32.powi(64), Some(U::SquaresTooLarge)),
        (2f32.powi(63), None),
        (2f32.powi(-63), None),
        (2f32.powi(-64), Some(U::SquaresTooSmall)),
    ];
    for (program, (a, kind)) in [&p, &g].into_iter().flat_map(|p| cases.map(|case| (p, case))) {
        let seen = |precision| {
            let settings = Settings { precision, ..watched() };
            let notes = run(program, "f", &[&[a]], &settings).expect("it runs").notes;
            notes.undefined.iter().map(|u| u.kind).find(|kind| *kind != U::BornInfinite)
        };
        assert_eq!((seen(Precision::Single), seen(Precision::Both)), (kind, kind), "{a:e}");
        assert_eq!(seen(Precision::Double), None, "{a:e}");
    }
}

#[test]
fn glsl_variables_nobody_set_are_noted_where_they_are_read() {
    let text = "#version 450
        float set(float x) { float sum; sum = 0.0; sum += x; return sum; }
        float open(float x) { float sum; sum += x; return sum; }
        vec3 partly(float x) { vec3 v; if (x > 1.0) { v = vec3(x); } return v * 2.0; }
        float indexed(float x) { vec3 v; for (int i = 0; i < 3; i++) { v[i] = x; } return v.z + v.x; }
        float stored(float x) { float a; vec3 v; for (int i = 0; i < 3; i++) { v[i] = a; } return v.z + x; }
        float copied(float x) { float a; float b = a; return max(b, x); }
        void main() {}";
    let source = landfall_layout::Source::new("sums.frag", text);
    let module =
        landfall_ir::Module::new(&source, &landfall_layout::Options::default()).expect("it runs");
    let p = landfall_interp::Program::new(&module, &[]);
    let cases =
        [("set", 0), ("open", 2), ("partly", 3), ("indexed", 0), ("stored", 2), ("copied", 2)];
    for (name, expected) in cases {
        let notes = run(&p, name, &[&[0.5, 2.0]], &watched()).expect("it runs").notes;
        let read = notes.undefined.iter().filter(|u| u.kind == U::Uninitialised);
        assert_eq!(read.map(|u| u.count).sum::<u64>(), expected, "{name}: {:?}", notes.undefined);
    }
    // WGSL has zeros there.
    let p = program("fn f(x: f32) -> f32 { var sum: f32; sum += x; return sum; }");
    assert_eq!(run(&p, "f", &[&[1.0]], &watched()).expect("it runs").notes.undefined, []);
}

#[test]
fn a_branch_not_taken_is_not_undefined() {
    let p = program("fn f(a: f32) -> f32 { if a > 0.0 { return sqrt(a); } return 0.0; }");
    let called = run(&p, "f", &[&[4.0, -4.0, 9.0]], &watched()).expect("it runs");
    assert_eq!(called.notes.undefined, []);
    assert_eq!(called.result.doubles[0], [2.0, 0.0, 3.0]);
}

#[test]
fn both_precisions_part_where_digits_cancel() {
    let p = program(
        "fn f(a: f32) -> f32 {
            let big = a + 1.0;
            let small = big - a;
            return small * 2.0;
        }",
    );
    let settings = Settings { precision: Precision::Both, tolerance: Some(1e-3), ..watched() };
    let called = run(&p, "f", &[&[1.0, 1e9]], &settings).expect("it runs");
    assert_eq!(called.result.doubles[0], [2.0, 2.0]);
    assert_eq!(called.result.words[0][1], 0);
    let [parted] = &called.notes.divergences[..] else {
        panic!("{:?}", called.notes.divergences);
    };
    assert_eq!((parted.lane, parted.single, parted.double), (1, 0.0, 1.0));
    assert!(parted.place.shown.starts_with("test.wgsl:3:"), "{:?}", parted.place);
}

#[test]
fn double_precision_has_the_digits_of_f64() {
    let p = program("fn f(a: f32) -> f32 { return sin(a) / 3.0; }");
    let settings = Settings { precision: Precision::Double, ..single() };
    let called = run(&p, "f", &[&[0.7]], &settings).expect("it runs");
    assert_eq!(called.result.doubles[0], [f64::from(0.7f32).sin() / 3.0]);
}

#[test]
fn costs_are_counted_by_active_invocations() {
    let p = program(
        "fn work(a: f32) -> f32 { return a * a + 1.0; }
        fn f(a: f32) -> f32 {
            var sum = 0.0;
            if a > 2.0 { sum = work(a) + sin(a); }
            return sum;
        }",
    );
    let numbers: Vec<f32> = (0..100u8).map(f32::from).collect();
    let counts = run(&p, "f", &[&numbers], &single()).expect("it runs").notes.counts;
    // A comparison each; of 97, a product, a sum, a sum.
    assert_eq!((counts.arithmetic, counts.transcendental), (100 + 3 * 97, 97));
    assert_eq!((counts.calls_of("work"), counts.calls_of("f")), (97, 100));
}

#[test]
fn a_loop_without_an_end_is_named() {
    let p = program(
        "fn f(a: f32) -> f32 {
            var x = a;
            loop {
                if x < 0.0 { break; }
                x += 1.0;
            }
            return x;
        }",
    );
    let settings = Settings { budget: 1000, ..single() };
    let failure = run(&p, "f", &[&[-1.0, 1.0]], &settings).expect_err("it does not end");
    assert_eq!(failure.kind, FailureKind::TimedOut);
    assert!(failure.message.contains("in `f`, test.wgsl:3:13"), "{}", failure.message);
}

#[test]
fn calls_that_double_are_refused_at_their_limit() {
    let functions: String = (1..=11)
        .map(|n| {
            let before = n - 1;
            format!("fn f{n}(a: f32) -> f32 {{ return f{before}(a) + f{before}(a); }}\n")
        })
        .collect();
    let p = program(&format!("fn f0(a: f32) -> f32 {{ return a; }}\n{functions}"));
    let call = |function, budget| run(&p, function, &[&[1.0]], &Settings { budget, ..single() });
    // f9 makes 2 + 4 + … + 512 = 1022 calls, f10 1024 more.
    assert!(call("f9", 1).is_ok() && call("f10", 2).is_ok());
    let failure = call("f10", 1).expect_err("it makes more than 1024 calls");
    assert_eq!(failure.kind, FailureKind::Refused);
    assert!(
        failure.message.contains("more function calls than the interpreter"),
        "{}",
        failure.message
    );
}

#[test]
fn what_is_not_known_is_refused_by_name_where_it_is_run() {
    let p = program(
        "@group(0) @binding(0) var t: texture_cube<f32>;
        @group(0) @binding(1) var s: sampler;
        fn cube(v: f32) -> f32 { return textureSampleLevel(t, s, vec3<f32>(v), 0.0).x; }
        fn plain(v: f32) -> f32 { return v; }",
    );
    let call = |function| run(&p, function, &[&[1.0]], &single());
    let failure = call("cube").expect_err("cube maps are not known");
    assert_eq!(failure.kind, FailureKind::Refused);
    assert!(failure.message.contains("texture_2d<f32>"), "{}", failure.message);
    assert!(call("plain").is_ok());
}

#[test]
fn what_is_too_large_is_refused_without_being_built() {
    let mut text =
        String::from("struct S0 { a: array<vec4<f32>, 65536>, b: array<vec4<f32>, 65536> }\n");
    for i in 1..7 {
        text.push_str(&format!("struct S{i} {{ a: S{}, b: S{} }}\n", i - 1, i - 1));
    }
    let way = ".a".repeat(6);
    text.push_str("var<private> p: S6;\n");
    text.push_str(&format!("fn f(a: f32) -> f32 {{ return p{way}.b[0].x + a; }}\n"));
    text.push_str("fn g(a: f32) -> f32 { var l: array<f32, 4000000>; ");
    text.push_str("l[u32(a)] = a; return l[0]; }");
    let p = program(&text);
    for function in ["f", "g"] {
        let failure = run(&p, function, &[&[1.0]], &single()).expect_err("it is too large");
        assert_eq!(failure.kind, FailureKind::Refused);
        assert!(failure.message.contains("scalars"), "{}", failure.message);
    }
}
