//! Rounding of floats that an OpenGL ES shader declares `mediump` or `lowp`, and of no others.

use half::f16;

use super::lighting::{fragments, module as six_lights, shade};
use super::support::{floats, single};
use landfall_interp::{Call, Floats, Precision, Program, Settings};
use landfall_ir::Module;
use landfall_layout::Options;
use landfall_layout::source::Source;

fn half(x: f32) -> f32 {
    f16::from_f32(x).to_f32()
}

fn module(text: &str) -> Module {
    let source = Source::new("test.frag", text);
    Module::new(&source, &Options::default()).unwrap_or_else(|found| panic!("{found:?}"))
}

fn program(text: &str) -> Program {
    Program::rounded(&module(text), &[], Floats::Mediump)
}

const SHADER: &str = "#version 300 es
precision mediump float;
struct Lamp { highp float far; lowp vec3 color; float near; };
const float third = 0.333333333;
highp float keep(highp float a) { return a * 3.0 + 0.1; }
highp float steps(float a) { return a * 3.0 + 0.1; }
highp float mixed(float a, highp float b) { return a * b; }
highp float literals() { return 0.1 + 0.2; }
highp float held(highp float a) { float b = a; highp float c = a; return b + c; }
highp float members(highp float a) {
    Lamp lamp = Lamp(a, vec3(a), a);
    return lamp.far + (lamp.color.y + lamp.near);
}
highp float inner(highp float a) { { precision highp float; float b = a; a = b * 3.0; } return a; }
highp float chosen(float a, highp float b) { return a > 0.0 ? a * a : b * b; }
float helper(highp float a) { return a; }
highp float called(highp float a) { return helper(a) * 1.0; }
highp float lengths(vec3 a) { return length(a); }
highp float whole(highp float a) { int i = int(a); return float(i); }
highp float fixed_third(float a) { return a * third; }
highp float raised(float a) { highp float b = a; b *= 3.0; a *= 3.0; return b - a; }
out vec4 color;
void main() { color = vec4(keep(0.5)); }
";

#[test]
fn operations_are_as_precise_as_their_most_precise_operand() {
    let p = program(SHADER);
    let (a, b) = (0.123_456_7_f32, 1.987_654_3_f32);
    let one = |name: &str| floats(&p, name, &[&[a]])[0];
    let two = |name: &str| floats(&p, name, &[&[a], &[b]])[0];
    assert_eq!(one("keep"), a * 3.0 + 0.1);
    // What is read is rounded too, and the literals beside it.
    assert_eq!(one("steps"), half(half(half(a) * 3.0) + half(0.1)));
    assert_eq!(two("mixed"), half(a) * b);
    assert_eq!(floats(&p, "literals", &[]), [0.1 + 0.2]);
    assert_eq!(one("held"), half(a) + a);
    assert_eq!(one("members"), a + half(half(a) + half(a)));
    assert_eq!(one("inner"), a * 3.0);
    // The condition's operands are rounded, the branch of a `highp` operand is not.
    assert_eq!(two("chosen"), half(half(a) * half(a)));
    assert_eq!(floats(&p, "chosen", &[&[-a], &[b]]), [b * b]);
    assert_eq!(one("called"), half(a));
    assert_eq!(floats(&p, "whole", &[&[4099.5]]), [4099.0]);
    assert_eq!(one("fixed_third"), half(half(a) * half(0.333_333_33)));
    assert_eq!(one("raised"), half(a) * 3.0 - half(half(a) * 3.0));
}

#[test]
fn steps_of_a_function_are_rounded_where_it_is() {
    let p = program(SHADER);
    let words = |x: f32| vec![u64::from(x.to_bits())];
    let arguments = vec![vec![words(300.0), words(1.0), words(2.0)]];
    let call = Call { function: "lengths", lanes: 1, arguments, resources: &[] };
    let run = |p: &Program, precision| {
        let settings = Settings { precision, ..single() };
        p.call(&call, &settings).expect("it runs").result.doubles[0][0]
    };
    // 300 squared is past the largest `f16`; the truth beside it is not rounded.
    assert_eq!(run(&p, Precision::Single), f64::INFINITY);
    assert_eq!(run(&p, Precision::Double), 90_005f64.sqrt());
    let written = Program::new(&module(SHADER), &[]);
    assert_eq!(run(&written, Precision::Single), f64::from(90_005f32.sqrt()));
}

/// Elsewhere the words say nothing (GLSL 4.60 §4.7).
#[test]
fn precisions_mean_nothing_outside_of_es() {
    let text = SHADER.replace("300 es", "450").replace("out vec4", "layout(location=0) out vec4");
    let p = program(&text);
    let a = 0.123_456_7_f32;
    assert_eq!(floats(&p, "steps", &[&[a]]), [a * 3.0 + 0.1]);
    let older = "#version 100
        uniform sampler2D image;
        varying highp vec2 at;
        mediump float f(mediump float a) { return a * 3.0; }
        void main() { gl_FragColor = texture2D(image, at) * f(0.1); }";
    let p = program(older);
    assert_eq!(floats(&p, "f", &[&[a]]), [half(half(a) * 3.0)]);
}

#[test]
fn calls_inside_calls_take_no_longer_than_they_are_deep() {
    let nested = format!("{}image{}", "texture(".repeat(150), ", at)".repeat(150));
    let text = format!(
        "#version 300 es
        uniform sampler2D image; in highp vec2 at;
        highp vec4 f() {{ return {nested}; }}
        void main() {{}}"
    );
    let found = Module::new(&Source::new("test.frag", text.as_str()), &Options::default());
    let left_out = found.expect("`main` runs").left_out().len();
    assert_eq!(left_out, 1, "what is sampled is no texture");
}

/// A study found 0.115 steps of 255 on average, 0.42 at the 99th of 100 and 0.73 at most for
/// attenuation and colours in `f16` with the geometry in `f32`, which is what this shader says.
#[test]
fn colours_in_mediump_are_off_by_less_than_a_step() {
    let fragments = fragments(4000);
    let run = |changes: &[(&str, &str)], precision, floats| {
        let settings = Settings { precision, ..single() };
        let module = six_lights("phong_300es.frag", changes);
        shade(&module, &fragments, &settings, floats).ports[0].1.doubles[0].clone()
    };
    let truth = run(&[], Precision::Double, Floats::Mediump);
    let steps = |changes: &[(&str, &str)], floats| {
        let got = run(changes, Precision::Single, floats);
        let off = |(a, b): (&f64, &f64)| 255.0 * (a - b).abs();
        let mut steps: Vec<f64> = truth.iter().zip(&got).map(off).collect();
        steps.sort_by(f64::total_cmp);
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        (mean, steps[steps.len() * 99 / 100], steps[steps.len() - 1])
    };
    let said = steps(&[], Floats::Mediump);
    println!("as the shader says: {said:.3?} on average, at the 99th of 100, at most");
    assert!(said.0 > 0.01 && said.0 < 0.115 && said.1 < 0.42 && said.2 < 0.73, "{said:?}");
    let written = steps(&[], Floats::AsWritten);
    assert!(written.2 < 2e-3, "{written:?}");
    // Nothing but `mediump` is `f16` throughout.
    let medium = steps(&[("highp", "mediump")], Floats::Mediump);
    let halves = steps(&[], Floats::Half);
    println!("all mediump: {medium:.3?}; all f16: {halves:.3?}");
    assert!(medium.2 > 2.0 && halves.2 > 2.0, "{medium:?} {halves:?}");
    assert!(medium.0 / halves.0 > 0.8 && medium.0 / halves.0 < 1.25, "{medium:?} {halves:?}");
}
