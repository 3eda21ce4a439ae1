//! What a shader's text permits: the evaluator's intervals against those that the tests of the
//! builtin functions have of their own, and drivers' results inside them.
//!
//! Needs drivers (Debian packages `mesa-vulkan-drivers`, `libvulkan1`, `libegl1` and
//! `libgl1-mesa-dri`); a missing one fails.

mod draw;
use crate::builtins::interval;
use crate::support::jobs;

use std::sync::Arc;

use interval::Interval;
use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{Backend, Grid, ResourceKind};
use landfall_interp::{Call, Called, Precision, Program, Settings};
use landfall_ir::Module;
use landfall_layout::{Options, Source, Stage};

fn module(name: &str, text: &str) -> Module {
    let module = Module::new(&Source::new(name, text), &Options::default());
    module.unwrap_or_else(|found| panic!("{found:?}\n{text}"))
}

/// `inputs` are components by invocation, all of one argument if `together`.
fn call(program: &Program, function: &str, inputs: &[Vec<f32>], together: bool) -> Called {
    let words = |list: &Vec<f32>| list.iter().map(|x| u64::from(x.to_bits())).collect();
    let all: Vec<Vec<u64>> = inputs.iter().map(words).collect();
    let arguments = if together { vec![all] } else { all.into_iter().map(|w| vec![w]).collect() };
    let settings = Settings { precision: Precision::Permitted, ..Settings::default() };
    let call = Call { function, lanes: inputs[0].len(), arguments, resources: &[] };
    program.call(&call, &settings).unwrap_or_else(|failure| panic!("{function}: {failure}"))
}

type Rule = fn(Interval, Interval) -> Interval;

const RULES: [(&str, Rule); 19] = [
    ("a + b", Interval::add),
    ("a - b", Interval::sub),
    ("a * b", Interval::mul),
    ("a / b", Interval::div),
    ("min(a, b)", Interval::min),
    ("max(a, b)", Interval::max),
    ("-a", |a, _| a.neg()),
    ("inverseSqrt(a)", |a, _| a.inverse_sqrt()),
    ("sqrt(a * a + 1.0)", |a, _| a.mul(a).add(Interval::of(1.0)).sqrt()),
    ("exp(a)", |a, _| a.exp()),
    ("exp2(a)", |a, _| a.exp2()),
    ("log(a)", |a, _| a.ln()),
    ("log2(a)", |a, _| a.log2()),
    ("atan2(a, b)", Interval::atan2),
    ("floor(a)", |a, _| a.whole(f64::floor)),
    ("a + b + a", |a, b| a.add(b).add(a)),
    ("dot(vec3<f32>(a, b, a), vec3<f32>(b, a, 3.0))", |a, b| {
        interval::dot(&[a, b, a], &[b, a, Interval::of(3.0)])
    }),
    ("dot(vec4<f32>(a, b, 1.0, b), vec4<f32>(b, b, a, a))", |a, b| {
        // Not one value with itself.
        let one = Interval::of(1.0);
        interval::dot(&[a, b, one, b], &[b, b, a, a])
    }),
    ("log2(a / b) * b", |a, b| a.div(b).log2().mul(b)),
];

#[test]
fn rules_are_those_of_another_hand() {
    let mut random = fastrand::Rng::with_seed(7);
    let mut number = || {
        let size = 2f32.powi(random.i32(-20..20)) * (1.0 + random.f32());
        match random.u32(0..12) {
            0 => 0.0,
            1 => 1.0,
            2 => f32::MIN_POSITIVE / 4.0,
            3 => 1e18,
            4..8 => -size,
            _ => size,
        }
    };
    let inputs: [Vec<f32>; 2] = [(); 2].map(|()| (0..1000).map(|_| number()).collect());
    for (text, rule) in RULES {
        let shader = format!("fn f(a: f32, b: f32) -> f32 {{ return {text}; }}");
        let program = Program::new(&module("rule.wgsl", &shader), &[]);
        let spans = call(&program, "f", &inputs, false).result.permitted.expect("it was asked for");
        let (mut bounded, mut farther) = (0, 0);
        for (i, [low, high]) in spans[0].iter().enumerate() {
            let (a, b) = (inputs[0][i], inputs[1][i]);
            let other = rule(Interval::of(a), Interval::of(b));
            let past = |x: f64| x.abs() > f64::from(f32::MAX);
            if other.is_any() || past(other.low) || past(other.high) {
                assert!(*low == f64::NEG_INFINITY && *high == f64::INFINITY, "{text} of {a}, {b}");
                continue;
            }
            bounded += 1;
            // What is never negative is not permitted to be.
            let floor = if text.starts_with("exp") { 0.0 } else { f64::NEG_INFINITY };
            for (ours, theirs, way) in
                [(*low, other.low.max(floor), -1.0), (*high, other.high, 1.0)]
            {
                // Their functions are series with errors of 1e-14; and where the sum of a large
                // and a small number is no `f64` either, they see no rounding.
                let past = (ours - theirs) * way / interval::ulp(theirs);
                let sum = text.contains(['+', '-']) || text.starts_with("dot");
                // Nor do they see that an ULP doubles at a power of two.
                let most = if text.starts_with("atan2") { 5000.0 } else { 50.0 };
                let close = past > -1e-3 && past < if sum { 1.01 + most } else { most };
                assert!(close, "{text} of {a}, {b}: [{low}, {high}], not {other:?}");
                farther += usize::from(past > 1e-3);
            }
        }
        assert!(farther < 400, "{text}: {farther} ends are farther out");
        assert!(bounded > 150, "{text}: {bounded} of 1000 have bounds");
    }
}

/// Lanes of each expression.
const LANES: usize = 512;

#[test]
fn what_drivers_give_is_permitted() {
    let mut random = fastrand::Rng::with_seed(21);
    let expressions: Vec<String> = (0..150).map(|_| draw::expression(&mut random)).collect();
    let mut text = String::from(
        "#version 450\nlayout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Given { float given[]; };
layout(std430, binding = 1) buffer Got { float got[]; };\n",
    );
    for (i, expression) in expressions.iter().enumerate() {
        text += &format!("float e{i}(vec3 p) {{ return {expression}; }}\n");
    }
    let count = expressions.len();
    text += "void main() {\n  uint id = gl_GlobalInvocationID.x;\n";
    text += "  vec3 p = vec3(given[3u * id], given[3u * id + 1u], given[3u * id + 2u]);\n";
    for i in 0..count {
        text += &format!("  got[{count}u * id + {i}u] = e{i}(p);\n");
    }
    text += "}\n";
    let module = Arc::new(module("random.comp", &text));
    let program = Program::new(&module, &[]);
    let inputs: Vec<Vec<f32>> =
        (0..3).map(|_| (0..LANES).map(|_| random.f32() * 8.0 - 4.0).collect()).collect();
    let permitted: Vec<Called> =
        (0..count).map(|i| call(&program, &format!("e{i}"), &inputs, true)).collect();
    let given: Vec<u32> = (0..LANES)
        .flat_map(|lane| (0..3).map(move |i| (lane, i)))
        .map(|(lane, i)| inputs[i][lane].to_bits())
        .collect();
    let mut backends: Vec<Box<dyn Backend>> = vec![
        Box::new(Gl::open().unwrap_or_else(|failure| panic!("{failure}"))),
        Box::new(
            Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}")),
        ),
    ];
    for backend in &mut backends {
        let name = backend.device().backend.name();
        let mut stage = jobs::module(Stage::Compute, "main", &module);
        stage.text = Some(text.clone());
        let kind = ResourceKind::Storage { bytes: jobs::bytes(&given), writable: false };
        let resources = vec![jobs::bound("Given", 0, kind), jobs::output("Got", 1, LANES * count)];
        let job = jobs::job(vec![stage], resources, Grid::Groups([LANES as u32 / 64, 1, 1]));
        let answer = backend.run(&job).unwrap_or_else(|failure| panic!("{name}: {failure}"));
        let got = jobs::words(answer.buffers[1].as_ref().expect("the buffer is writable"));
        let (mut bounded, mut apart, mut outside) = (0, 0, Vec::new());
        for (i, called) in permitted.iter().enumerate() {
            let spans = &called.result.permitted.as_ref().expect("it was asked for")[0];
            for lane in 0..LANES {
                let [low, high] = spans[lane];
                if called.unsure[lane] || low == f64::NEG_INFINITY {
                    continue;
                }
                bounded += 1;
                let x = f32::from_bits(got[lane * count + i]);
                apart += usize::from(u64::from(x.to_bits()) != called.result.words[0][lane]);
                if !(low <= f64::from(x) && f64::from(x) <= high) {
                    let at: Vec<f32> = inputs.iter().map(|list| list[lane]).collect();
                    outside.push(format!("{} at {at:?}: {x}, not {low} to {high}", expressions[i]));
                }
            }
        }
        println!(
            "{name}: {bounded} bounded, {apart} unlike the evaluator's, {} outside",
            outside.len()
        );
        for line in outside.iter().take(10) {
            println!("  {line}");
        }
        assert!(bounded > count * LANES / 2 && apart > bounded / 20, "{bounded} {apart}");
        assert!(outside.is_empty(), "{name}: {} of {bounded}", outside.len());
    }
}
