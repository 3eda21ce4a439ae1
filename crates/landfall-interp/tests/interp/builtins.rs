//! Float operators and functions against formulas of the specification, computed in `f32` where
//! one operation rounds once, and in `f64` where more are needed.

use super::support::{call, floats, program, words};

/// Numbers that show edges: signs, halves, large, small, subnormal, not finite.
pub const NUMBERS: [f32; 26] = [
    0.0,
    -0.0,
    0.5,
    -0.5,
    1.0,
    -1.0,
    1.5,
    -1.5,
    2.5,
    -2.5,
    3.0,
    0.1,
    -0.7,
    10.25,
    -33.75,
    1e-3,
    123456.79,
    8388609.0,
    -1e10,
    1e30,
    1e-30,
    1e-41,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

fn check1(expression: &str, reference: impl Fn(f32) -> f32) {
    let p = program(&format!("fn f(a: f32) -> f32 {{ return {expression}; }}"));
    let got = floats(&p, "f", &[&NUMBERS]);
    for (&a, got) in NUMBERS.iter().zip(got) {
        let expected = reference(a);
        assert!(same(got, expected), "{expression} of {a}: {got}, not {expected}");
    }
}

fn check2(expression: &str, reference: impl Fn(f32, f32) -> f32) {
    let p = program(&format!("fn f(a: f32, b: f32) -> f32 {{ return {expression}; }}"));
    let (a, b): (Vec<f32>, Vec<f32>) =
        NUMBERS.iter().flat_map(|&a| NUMBERS.iter().map(move |&b| (a, b))).unzip();
    for ((a, b), got) in a.iter().zip(&b).zip(floats(&p, "f", &[&a, &b])) {
        let expected = reference(*a, *b);
        assert!(same(got, expected), "{expression} of {a}, {b}: {got}, not {expected}");
    }
}

fn check3(expression: &str, reference: impl Fn(f32, f32, f32) -> f32) {
    let p = program(&format!("fn f(a: f32, b: f32, c: f32) -> f32 {{ return {expression}; }}"));
    let few = [0.0, -1.25, 0.3, 0.75, 1.0, 2.0, 1e20, f32::INFINITY];
    let mut lists = [Vec::new(), Vec::new(), Vec::new()];
    for a in few {
        for b in few {
            for c in few {
                lists[0].push(a);
                lists[1].push(b);
                lists[2].push(c);
            }
        }
    }
    let [a, b, c] = &lists;
    for (i, got) in floats(&p, "f", &[a, b, c]).into_iter().enumerate() {
        let expected = reference(a[i], b[i], c[i]);
        let given = [a[i], b[i], c[i]];
        assert!(same(got, expected), "{expression} of {given:?}: {got}, not {expected}");
    }
}

fn wide(f: impl Fn(f64) -> f64) -> impl Fn(f32) -> f32 {
    move |a| f(f64::from(a)) as f32
}

#[test]
fn operators_round_once() {
    check2("a + b", |a, b| a + b);
    check2("a - b", |a, b| a - b);
    check2("a * b", |a, b| a * b);
    check2("a / b", |a, b| a / b);
    // What is left by whole multiples, of the sign of the dividend: OpFRem.
    check2("a % b", |a, b| (f64::from(a) % f64::from(b)) as f32);
}

#[test]
fn functions_of_one_float() {
    check1("-a", |a| -a);
    check1("abs(a)", f32::abs);
    check1("floor(a)", f32::floor);
    check1("ceil(a)", f32::ceil);
    check1("trunc(a)", f32::trunc);
    check1("round(a)", f32::round_ties_even);
    check1("fract(a)", |a| a - a.floor());
    check1("saturate(a)", |a| {
        let above = if a < 0.0 { 0.0 } else { a };
        if 1.0 < above { 1.0 } else { above }
    });
    check1("sqrt(a)", f32::sqrt);
    check1("inverseSqrt(a)", wide(|a| 1.0 / a.sqrt()));
    check1("sign(a)", |a| {
        if a > 0.0 {
            1.0
        } else if a < 0.0 {
            -1.0
        } else {
            a
        }
    });
    check1("sin(a)", wide(f64::sin));
    check1("cos(a)", wide(f64::cos));
    check1("tan(a)", wide(f64::tan));
    check1("sinh(a)", wide(f64::sinh));
    check1("cosh(a)", wide(f64::cosh));
    check1("tanh(a)", wide(f64::tanh));
    check1("asin(a)", wide(f64::asin));
    check1("acos(a)", wide(f64::acos));
    check1("atan(a)", wide(f64::atan));
    check1("asinh(a)", wide(f64::asinh));
    check1("acosh(a)", wide(f64::acosh));
    check1("atanh(a)", wide(f64::atanh));
    check1("exp(a)", wide(f64::exp));
    check1("exp2(a)", wide(f64::exp2));
    check1("log(a)", wide(f64::ln));
    check1("log2(a)", wide(f64::log2));
    check1("degrees(a)", wide(|a| a * (180.0 / std::f64::consts::PI)));
    check1("radians(a)", wide(|a| a * (std::f64::consts::PI / 180.0)));
    check1("quantizeToF16(a)", |a| half::f16::from_f32(a).to_f32());
    check1("ldexp(a, 3)", |a| a * 8.0);
    check1("ldexp(a, -150)", wide(|a| a * 2f64.powi(-150)));
    check1("length(a)", f32::abs);
}

#[test]
fn functions_of_two_and_three_floats() {
    check2("min(a, b)", |a, b| if b < a { b } else { a });
    check2("max(a, b)", |a, b| if a < b { b } else { a });
    check2("step(a, b)", |edge, x| if edge <= x { 1.0 } else { 0.0 });
    check2("atan2(a, b)", |a, b| f64::from(a).atan2(f64::from(b)) as f32);
    check2(
        "pow(a, b)",
        |a, b| {
            if a < 0.0 { f32::NAN } else { f64::from(a).powf(f64::from(b)) as f32 }
        },
    );
    check2("distance(a, b)", |a, b| (a - b).abs());
    check2("select(a, b, a < b)", |a, b| if a < b { b } else { a });
    check3("fma(a, b, c)", |a, b, c| a.mul_add(b, c));
    check3("mix(a, b, c)", |a, b, c| a * (1.0 - c) + b * c);
    check3("clamp(a, b, c)", |x, low, high| {
        let above = if x < low { low } else { x };
        if high < above { high } else { above }
    });
    check3("smoothstep(a, b, c)", |low, high, x| {
        let t = (x - low) / (high - low);
        let t = if t < 0.0 { 0.0 } else { t };
        let t = if 1.0 < t { 1.0 } else { t };
        t * t * (3.0 - 2.0 * t)
    });
}

#[test]
fn comparisons_are_false_of_nan_except_unequal() {
    type Case = (&'static str, fn(f32, f32) -> bool);
    let cases: [Case; 6] = [
        ("a < b", |a, b| a < b),
        ("a <= b", |a, b| a <= b),
        ("a > b", |a, b| a > b),
        ("a >= b", |a, b| a >= b),
        ("a == b", |a, b| a == b),
        ("a != b", |a, b| a != b),
    ];
    for (expression, reference) in cases {
        check2(&format!("f32({expression})"), |a, b| f32::from(u8::from(reference(a, b))));
    }
}

#[test]
fn vectors_follow_their_formulas() {
    let p = program(
        "fn f(x: f32, y: f32, z: f32) -> array<f32, 21> {
            let v = vec3<f32>(x, y, z);
            let w = vec3<f32>(z, -x, y + 1.0);
            let n = normalize(v);
            let c = cross(v, w);
            let r = reflect(v, n);
            let t = refract(n, vec3<f32>(0.0, 1.0, 0.0), 0.75);
            let f = faceForward(v, w, n);
            let s = v.zyx * 2.0 + w.xxy;
            return array<f32, 21>(dot(v, w), length(v), distance(v, w), n.x, n.y, n.z, c.x, c.y,
                c.z, r.x, r.y, r.z, t.x, t.y, t.z, f.x, f.y, f.z, s.x, s.y, s.z);
        }",
    );
    let xs = [1.0f32, -2.5, 0.3, 1e-3];
    let ys = [0.5f32, 4.0, -0.1, 7.0];
    let zs = [-3.0f32, 0.25, 0.9, 2.0];
    let bits = |list: &[f32]| list.iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
    let called = call(&p, "f", &[&bits(&xs), &bits(&ys), &bits(&zs)]);
    for lane in 0..xs.len() {
        let v = [xs[lane], ys[lane], zs[lane]];
        let w = [v[2], -v[0], v[1] + 1.0];
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let sub = |a: [f32; 3], b: [f32; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let scale = |a: [f32; 3], k: f32| a.map(|x| k * x);
        let length = dot(v, v).sqrt();
        let n = v.map(|x| x / length);
        let cross =
            [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]];
        let reflected = sub(v, n.map(|x| 2.0 * dot(n, v) * x));
        let up = [0.0, 1.0, 0.0];
        let along = dot(up, n);
        let k = 1.0 - 0.75 * 0.75 * (1.0 - along * along);
        let refracted = if k < 0.0 {
            [0.0; 3]
        } else {
            sub(scale(n, 0.75), scale(up, 0.75 * along + k.sqrt()))
        };
        let facing = if dot(n, w) < 0.0 { v } else { v.map(|x| -x) };
        let swizzled = [v[2] * 2.0 + w[0], v[1] * 2.0 + w[0], v[0] * 2.0 + w[1]];
        let between = sub(v, w);
        let mut expected = vec![dot(v, w), length, dot(between, between).sqrt()];
        for part in [n, cross, reflected, refracted, facing, swizzled] {
            expected.extend(part);
        }
        let got: Vec<f32> =
            called.result.words.iter().map(|w| f32::from_bits(w[lane] as u32)).collect();
        assert_eq!(got, expected, "of {v:?}");
    }
}

#[test]
fn matrices_multiply_by_columns_and_have_inverses() {
    let p = program(
        "fn f(x: f32) -> array<f32, 28> {
            let m = mat3x3<f32>(2.0, x, 1.0, 0.0, 3.0, -1.0, 4.0, 1.0, x);
            let q = mat2x3<f32>(1.0, 2.0, 3.0, 4.0, 5.0, x);
            let a = m * q;
            let b = vec3<f32>(1.0, x, 2.0) * q;
            let c = q * vec2<f32>(x, 2.0);
            let t = transpose(q);
            let i = m * inverse3(m);
            let k = mat4x4<f32>(1.0, 2.0, 3.0, 4.0, 0.0, 1.0, x, 2.0, 2.0, 0.0, 1.0, 3.0, x, 1.0, 0.0, 1.0);
            return array<f32, 28>(a[0].x, a[0].y, a[0].z, a[1].x, a[1].y, a[1].z, b.x, b.y,
                c.x, c.y, c.z, t[0].x, t[0].y, t[1].x, t[1].y, t[2].x, t[2].y, determinant(m),
                i[0].x, i[0].y, i[0].z, i[1].x, i[1].y, i[1].z, i[2].x, i[2].y, i[2].z,
                determinant(k));
        }
        fn inverse3(m: mat3x3<f32>) -> mat3x3<f32> {
            let d = determinant(m);
            return transpose(mat3x3<f32>(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]))) * (1.0 / d);
        }",
    );
    let x = 0.5f32;
    let got: Vec<f32> = call(&p, "f", &[&[x.to_bits()]])
        .result
        .words
        .iter()
        .map(|w| f32::from_bits(w[0] as u32))
        .collect();
    // By hand, exact in f32.
    assert_eq!(got[..6], [2.0 + 12.0, 0.5 + 6.0 + 3.0, 1.0 - 2.0 + 1.5, 10.0, 17.5, -0.75]);
    assert_eq!(got[6..8], [1.0 + 1.0 + 6.0, 4.0 + 2.5 + 1.0]);
    assert_eq!(got[8..11], [8.5, 11.0, 2.5]);
    assert_eq!(got[11..17], [1.0, 4.0, 2.0, 5.0, 3.0, 0.5]);
    let determinant = 2.0 * (3.0 * x + 1.0) - x * 4.0 + (0.0 - 12.0) + x * 0.0;
    let by_rows = 2.0 * (3.0 * x + 1.0) - 0.0 * (x * x - 1.0) + 4.0 * (-x - 3.0);
    assert_eq!(got[17], by_rows, "{determinant}");
    for (i, value) in got[18..27].iter().enumerate() {
        let expected = if i % 4 == 0 { 1.0 } else { 0.0 };
        assert!((value - expected).abs() < 1e-5, "{i}: {value}");
    }
    let columns =
        [[1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.5, 2.0], [2.0, 0.0, 1.0, 3.0], [0.5, 1.0, 0.0, 1.0f64]];
    assert!((f64::from(got[27]) - eliminate(columns)).abs() < 1e-5);
}

/// A determinant by elimination.
fn eliminate(mut m: [[f64; 4]; 4]) -> f64 {
    let mut product = 1.0;
    for i in 0..4 {
        let pivot = (i..4).max_by(|&a, &b| m[a][i].abs().total_cmp(&m[b][i].abs())).unwrap_or(i);
        if pivot != i {
            m.swap(pivot, i);
            product = -product;
        }
        product *= m[i][i];
        for row in i + 1..4 {
            let k = m[row][i] / m[i][i];
            let above = m[i];
            for (cell, above) in m[row].iter_mut().zip(above).skip(i) {
                *cell -= k * above;
            }
        }
    }
    product
}

#[test]
fn glsl_has_an_inverse() {
    let text = "#version 450\nvoid main() {}\nfloat f(float x) {
        mat4 m = mat4(1.0, 2.0, 3.0, 4.0, 0.0, 1.0, x, 2.0, 2.0, 0.0, 1.0, 3.0, x, 1.0, 0.0, 1.0);
        mat4 i = m * inverse(m) - mat4(1.0);
        mat2 n = mat2(1.0, x, 2.0, 4.0);
        mat2 j = n * inverse(n) - mat2(1.0);
        float worst = 0.0;
        for (int c = 0; c < 4; c++)
            for (int r = 0; r < 4; r++) worst = max(worst, abs(i[c][r]));
        return worst + abs(j[0][0]) + abs(j[0][1]) + abs(j[1][0]) + abs(j[1][1]);
    }";
    let source = landfall_layout::source::Source::new("test.frag", text);
    let module = landfall_ir::Module::new(&source, &landfall_layout::Options::default())
        .unwrap_or_else(|found| panic!("{found:?}"));
    let p = landfall_interp::Program::new(&module, &[]);
    let got = floats(&p, "f", &[&[0.5, 0.25, -3.0]]);
    assert!(got.iter().all(|&x| x < 1e-5), "{got:?}");
}

#[test]
fn parts_of_numbers() {
    let p = program(
        "fn whole(a: f32) -> f32 { return modf(a).whole; }
        fn fract_(a: f32) -> f32 { return modf(a).fract; }
        fn fraction(a: f32) -> f32 { return frexp(a).fract; }
        fn exponent(a: f32) -> i32 { return frexp(a).exp; }
        fn nan(a: f32) -> u32 { return bitcast<u32>(a); }",
    );
    let numbers: Vec<f32> = NUMBERS.iter().copied().filter(|x| x.is_finite()).collect();
    let whole = floats(&p, "whole", &[&numbers]);
    let fract = floats(&p, "fract_", &[&numbers]);
    let fraction = floats(&p, "fraction", &[&numbers]);
    let bits: Vec<u32> = numbers.iter().map(|x| x.to_bits()).collect();
    let exponent = words(&p, "exponent", &[&bits]);
    for (i, &x) in numbers.iter().enumerate() {
        assert_eq!((whole[i], fract[i]), (x.trunc(), x - x.trunc()), "{x}");
        let back = f64::from(fraction[i]) * 2f64.powi(exponent[i] as i32);
        assert_eq!(back, f64::from(x), "{x}");
        assert!(x == 0.0 || (0.5..1.0).contains(&fraction[i].abs()), "{x}: {}", fraction[i]);
    }
    assert_eq!(words(&p, "nan", &[&bits]), bits);
}

#[test]
fn halves_are_rounded_at_each_operation() {
    let p = program(
        "enable f16;
        fn f(a: f32, b: f32) -> f32 {
            let x = f16(a);
            let y = f16(b);
            return f32(x * y + x);
        }",
    );
    let a = [1.001f32, 3.3415, 60000.0, 1e-6];
    let b = [0.3333f32, -7.7, 2.0, 0.5];
    let half = |x: f32| half::f16::from_f32(x).to_f32();
    let expected: Vec<f32> =
        a.iter().zip(b).map(|(&a, b)| half(half(half(a) * half(b)) + half(a))).collect();
    assert_eq!(floats(&p, "f", &[&a, &b]), expected);
}
