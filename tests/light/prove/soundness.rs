//! No value that a device may give lies outside of its bounds.

use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_exec::interp::graph::{Arithmetic, Bounds, Graph, Range};
use landfall_exec::interp::{Precision, Settings};
use landfall_layout::Options;

use super::fragment;

/// A stream of random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    fn below(&mut self, end: u64) -> u64 {
        self.word() % end
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.word() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A random expression of `a`, `b` and `c`.
fn expression(random: &mut Random, depth: u32) -> String {
    if depth == 0 {
        return ["a", "b", "c", "0.5", "2.0", "-1.5", "3.25"][random.below(7) as usize].to_string();
    }
    let mut of = || expression(random, depth - 1);
    let (x, y, z) = (of(), of(), of());
    match random.below(25) {
        0..=3 => format!("({x} + {y})"),
        4..=6 => format!("({x} - {y})"),
        7..=10 => format!("({x} * {y})"),
        11 => format!("({x} / {y})"),
        12 => format!("sqrt({x})"),
        13 => format!("min({x}, {y})"),
        14 => format!("max({x}, {y})"),
        15 => format!("abs({x})"),
        16 => format!("sin({x})"),
        17 => format!("exp({x})"),
        18 => format!("clamp({x}, -1.0, 1.0)"),
        19 => format!("mix({x}, {y}, {z})"),
        20 => format!("({x} < {y} ? {z} : {x})"),
        21 => format!("dot(vec2({x}, {y}), vec2({y}, {z}))"),
        22 => format!("length(vec2({x}, {y}))"),
        23 => format!("smoothstep(-1.0, 2.0, {x})"),
        _ => format!("floor({x})"),
    }
}

/// Returns the number of samples whose values were compared with their bounds, and the first that
/// lies outside. `spoil` changes the bounds.
///
/// The permitted values of a sample take the operands of `smoothstep` as independent, and may then
/// be wider than the bounds: of those, the interpreter's own values are compared.
fn compare(
    pure: &PureFunction,
    graph: &Graph,
    part: &[Range],
    samples: &[Vec<f64>],
    own: bool,
    spoil: impl Fn(Range) -> Range,
) -> (usize, Option<String>) {
    let mut bounds = Bounds::default();
    graph.bounds(part, Arithmetic::Permitted, &mut bounds);
    let Range { low, high } = spoil(bounds.results(graph).next().expect("it has one result"));
    let columns: Vec<Vec<u64>> = (0..part.len())
        .map(|at| samples.iter().map(|s| u64::from((s[at] as f32).to_bits())).collect())
        .collect();
    let settings = Settings { precision: Precision::Permitted, ..Settings::default() };
    let called = pure.call(&columns, samples.len(), &settings).expect("it runs");
    let single = Settings { watch: true, ..Settings::default() };
    let watched = pure.call(&columns, samples.len(), &single).expect("it runs");
    let broken: Vec<usize> =
        watched.called.notes.undefined.iter().flat_map(|seen| seen.lanes.clone()).collect();
    let permitted = called.results[0].permitted.as_ref().expect("it was asked for");
    let mut compared = 0;
    for (lane, sample) in samples.iter().enumerate() {
        let [least, most] = permitted[0][lane];
        let value = f64::from(f32::from_bits(watched.results[0].words[0][lane] as u32));
        if called.called.unsure[lane] || broken.contains(&lane) || !value.is_finite() {
            continue;
        }
        compared += 1;
        // Without a bound, the interpreter's own value counts.
        let any = !(least.is_finite() && most.is_finite()) || own;
        let [least, most] = if any { [value; 2] } else { [least, most] };
        if !(low <= least && most <= high) {
            let text = format!("{sample:?}: [{least:?}, {most:?}] is not in [{low:?}, {high:?}]");
            return (compared, Some(text));
        }
    }
    (compared, None)
}

fn function(code: &str) -> PureFunction {
    let request = PureRequest { function: "f".to_string(), ..PureRequest::default() };
    PureFunction::new(&fragment(code), &Options::default(), &request)
        .unwrap_or_else(|refusal| panic!("{code}: {:?}", refusal.found))
}

/// Boxes within a range, down to points.
fn boxes(random: &mut Random, scalars: usize) -> Vec<Vec<Range>> {
    let widths = [8.0, 1.0, 0.01, 0.0];
    let of = |width: f64, random: &mut Random| {
        let low = f64::from(random.between(-4.0, 4.0) as f32);
        Range { low, high: f64::from((low + width) as f32) }
    };
    widths.iter().map(|&width| (0..scalars).map(|_| of(width, random)).collect()).collect()
}

fn samples(random: &mut Random, part: &[Range]) -> Vec<Vec<f64>> {
    let inside = |range: &Range, random: &mut Random| match random.below(6) {
        0 => range.low,
        1 => range.high,
        _ => f64::from(random.between(range.low, range.high) as f32).clamp(range.low, range.high),
    };
    (0..24).map(|_| part.iter().map(|range| inside(range, random)).collect()).collect()
}

#[test]
fn no_permitted_value_of_a_random_expression_lies_outside_of_its_bounds() {
    let mut random = Random(1);
    let (mut compared, mut caught) = (0, 0);
    for nth in 0..300 {
        let depth = 2 + nth % 3;
        let text = expression(&mut random, depth);
        let code = format!("float f(float a, float b, float c) {{\n    return {text};\n}}");
        let pure = function(&code);
        let all = vec![Range { low: -16.0, high: 16.0 }; 3];
        let graph = pure.graph(&all, &[]).expect("it is small");
        for part in boxes(&mut random, 3) {
            let samples = samples(&mut random, &part);
            let own = text.contains("smoothstep");
            let (count, outside) = compare(&pure, &graph, &part, &samples, own, |range| range);
            assert_eq!(outside, None, "{text} over {part:?}");
            compared += count;
            // An engine that rounds the lower bound up is caught.
            let reversed = |range: Range| Range {
                low: f64::from((range.low as f32).next_up()),
                high: range.high,
            };
            caught +=
                usize::from(compare(&pure, &graph, &part, &samples, own, reversed).1.is_some());
        }
    }
    assert!(compared > 10_000, "{compared} samples were compared");
    assert!(caught > 100, "a reversed rounding was caught {caught} times");
}

#[test]
fn no_permitted_value_of_a_function_with_branches_lies_outside_of_its_bounds() {
    let codes = [
        "float f(float a, float b, float c) {
    float k = a * a - b;
    if (k < 0.0) return c;
    return a - sqrt(k);
}",
        "float f(float a, float b, float c) {
    float sum = 0.0;
    for (int i = 0; i < 5; i++) {
        if (sum > 3.0) break;
        if (a < b) { sum += abs(c); continue; }
        sum += a - b;
    }
    return sum;
}",
        "float f(float a, float b, float c) {
    vec3 v = normalize(vec3(a, b, c) + vec3(0.0, 0.0, 8.5));
    return dot(v, v) + v.z;
}",
        "float f(float a, float b, float c) {
    float w[3] = float[3](a, b, c);
    int i = int(clamp(a + 1.0, 0.0, 2.0));
    w[i] = 2.0;
    return w[0] + w[1] * w[2];
}",
        "float f(float a, float b, float c) {
    switch (int(floor(a))) {
        case 0: return b;
        case 1: b += c;
        case 2: return b - 1.0;
        default: return c * c;
    }
}",
    ];
    let mut random = Random(2);
    let mut compared = 0;
    for code in codes {
        let pure = function(code);
        let all = vec![Range { low: -16.0, high: 16.0 }; 3];
        let graph = pure.graph(&all, &[]).expect("it is small");
        for _ in 0..60 {
            for part in boxes(&mut random, 3) {
                let samples = samples(&mut random, &part);
                let (count, outside) =
                    compare(&pure, &graph, &part, &samples, false, |range| range);
                assert_eq!(outside, None, "{code} over {part:?}");
                compared += count;
            }
        }
    }
    assert!(compared > 5_000, "{compared} samples were compared");
}
