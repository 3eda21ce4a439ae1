//! What plans say of shaders whose falloff is not what their names say, held against all lights in
//! `f64` at every fragment.

use landfall_interp::{Cpu, Precision, Settings};
use landfall_layout::{Options, Source};
use landfall_light::culling::{self, Plan, Times, parse};
use landfall_light::render::Renderer;
use landfall_light::render::truth::likely_model;
use landfall_light::shading_f32::Model;

use crate::made::{Made, renderer, scene};

/// A falloff of `d`, `r`, and `w`, the window that the names promise; `a` is the attenuation.
const FALLOFFS: [(&str, &str); 33] = [
    ("as promised", "a * w"),
    ("cut at the range", "d < r ? a : 0.0"),
    ("a hint only", "a"),
    ("a hint of an inverse square", "1.0 / (1.0 + d * d)"),
    ("an inverse square with a floor", "max(1.0 / (1.0 + d * d), 0.01)"),
    ("a window a tenth longer", "a * window(d, r * 1.1)"),
    ("a window half longer", "a * window(d, r * 1.5)"),
    ("a window of twice the range", "a * window(d, r * 2.0)"),
    ("a window of half the range", "a * window(d, r * 0.5)"),
    ("a linear fade past the range", "clamp(1.2 - d / r, 0.0, 1.0)"),
    ("a linear fade", "clamp(1.0 - d / r, 0.0, 1.0)"),
    ("an exponential", "exp(-d / r)"),
    ("a Gaussian", "exp(-d * d / (r * r))"),
    ("a constant after the window", "a * w + 0.05"),
    ("a small constant after the window", "a * w + 0.001"),
    ("a smooth step past the range", "smoothstep(r * 1.3, r * 0.2, d)"),
    ("a smooth step across the range", "1.0 - smoothstep(r * 0.9, r * 1.05, d)"),
    ("a soft range", "1.0 / (1.0 + d * d / (r * r))"),
    ("a squared range for a range", "a * window(d, r * r)"),
    ("a square forgotten", "a * pow(max(1.0 - d * d / r, 0.0), 2.0)"),
    ("ripples", "a * abs(sin(d / r * 3.14159265))"),
    ("negative past the range", "1.0 - d / r"),
    ("a floor of a fade", "clamp(1.0 - d / r, 0.01, 1.0)"),
    ("a floor of a window", "max(a * w, 0.001)"),
    ("a range and one more", "a * window(d, r + 1.0)"),
    ("a cosine past the range", "0.5 + 0.5 * cos(3.14159265 * min(d / (r * 1.15), 1.0))"),
    ("inverse square in a window", "w / max(d * d, 0.01)"),
    ("a window without its clamp", "a * (1.0 - d * d / (r * r)) * (1.0 - d * d / (r * r))"),
    ("a power of a negative", "a * pow(1.0 - d * d / (r * r), 2.0)"),
    ("a root of a negative", "d < r * 1.5 ? sqrt(abs(1.0 - d / r)) : 0.0"),
    ("a window of the intensity", "a * window(d, r * (0.5 + lights[i].intensity))"),
    ("two windows", "a * (0.9 * w + 0.1 * window(d, r * 3.0))"),
    ("a step late by a hair", "d < r * 1.02 ? a : 0.0"),
];

/// How a surface meets the light, as a factor.
const FACINGS: [(&str, &str); 3] = [
    ("", "max(dot(n, l), 0.0)"),
    (", wrapped", "max(0.5 * dot(n, l) + 0.5, 0.0)"),
    (", from both sides", "abs(dot(n, l))"),
];

fn text(falloff: &str, facing: &str) -> String {
    format!(
        "#version 450
layout(location = 0) in vec3 FragPos;
layout(location = 1) in vec3 Normal;
layout(location = 0) out vec4 FragColor;
struct PointLight {{
    vec3 position; float range; vec3 color; float intensity;
    float constant; float linear; float quadratic;
}};
layout(std430, binding = 0) readonly buffer PointLightBlock {{
    uint pointCount; PointLight lights[];
}};
layout(std140, binding = 1) uniform MaterialBlock {{ vec3 diffuse; }} material;
float window(float d, float r) {{
    float q = d / r;
    float s = max(1.0 - q * q * q * q, 0.0);
    return s * s;
}}
void main() {{
    vec3 n = normalize(Normal);
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < pointCount; i++) {{
        vec3 p = lights[i].position - FragPos;
        float d = length(p);
        vec3 l = p / d;
        float r = lights[i].range;
        float a = 1.0 / (lights[i].constant + d * (lights[i].linear + d * lights[i].quadratic));
        float w = window(d, r);
        sum += lights[i].color * lights[i].intensity * material.diffuse * {facing} * ({falloff});
    }}
    FragColor = vec4(sum, 1.0);
}}
"
    )
}

/// The largest difference of a plan from all lights over every fragment, in steps.
fn brute(made: &Made, renderer: &Renderer, plan: &Plan) -> f64 {
    let mut cpu = Cpu::new(Settings { precision: Precision::Double, ..Settings::default() });
    let all = made.whole(renderer, &mut cpu);
    let by_plan = made.by_plan(renderer, &mut cpu, plan);
    let pairs = all.picture.pixels.iter().flatten().zip(by_plan.picture.pixels.iter().flatten());
    let apart = |(a, b): (&f32, &f32)| match (f64::from(*a) - f64::from(*b)).abs() {
        _ if a.is_nan() && b.is_nan() => 0.0,
        apart if apart.is_nan() => f64::INFINITY,
        apart => apart * 255.0,
    };
    pairs.map(apart).fold(0.0, f64::max)
}

#[test]
fn nothing_is_called_exact_that_all_lights_in_f64_contradict() {
    let mut scene = scene("lights_1024_windowed.json", [64, 36]);
    scene.lights.point.truncate(60);
    let made = Made::of(scene);
    let (mut applied, mut refused, mut shown_of, mut wrong) = (0, 0, 0, Vec::new());
    for (nth, (name, falloff)) in FALLOFFS.iter().enumerate() {
        let facings = if nth == 0 { &FACINGS[..] } else { &FACINGS[..1] };
        for (turned, facing) in facings {
            let source = Source::new("falloff.frag", text(falloff, facing));
            let renderer = renderer(&source);
            let model = Model::new(&likely_model(&renderer.map)).expect("a model with bounds");
            assert!(model.windowed, "{name}: the names promise a window");
            let work = made.work();
            let shown = renderer.shown_lights(&source, &Options::default(), &work);
            if shown.count() > 0 {
                shown_of += 1;
                let exact = culling::Options { tiles: Some(4), ..culling::Options::exact() };
                let exact = culling::Options { shown: Some(shown), ..exact };
                let plan = renderer.plan(&work, &model, &exact);
                assert!(plan.evaluations() < plan.savings.before, "{name}");
                let brute = brute(&made, &renderer, &plan);
                if brute > 1e-6 {
                    wrong.push(format!("{name}{turned}: {brute:.4} steps, called exact"));
                }
            }
            // By the bounds of the model that the names promise, measured at every fragment.
            for parts in ["tiles=4", "tiles=4,budget=0.5"] {
                let plan = renderer.plan(&work, &model, &parse(parts).expect("good"));
                let mut cpu = Cpu::default();
                let all = made.whole(&renderer, &mut cpu);
                let found = made.by_plan(&renderer, &mut cpu, &plan);
                let checked = renderer.apart(&work, &found.picture, &all.picture);
                let holds = plan.drawback(Some(&checked), &Times::default(), true).is_none();
                let brute = brute(&made, &renderer, &plan);
                let row = format!("{name}{turned}, {parts}: {brute:.4} steps");
                *(if holds { &mut applied } else { &mut refused }) += 1;
                // Apart from what `f32` rounds.
                let most = plan.permitted() + 0.01;
                if holds != (brute <= most) && (brute - most).abs() > 1e-3 {
                    wrong.push(format!("{row}, applied: {holds}"));
                }
                // "Up to" is no less than what is there, the rounding of `f32` aside.
                if checked.steps < brute * (1.0 - 1e-6) - 1e-3 {
                    wrong.push(format!("{row}, but measured {:.4}", checked.steps));
                }
            }
        }
    }
    println!("{applied} applied, {refused} not, {shown_of} shown to be exact");
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(applied >= 10 && refused >= 30, "{applied} {refused}");
    assert!(shown_of >= 4, "{shown_of}");
}
