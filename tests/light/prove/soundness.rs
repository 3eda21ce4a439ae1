//! No value that a device may give lies outside of its bounds. The whole set takes minutes:
//!
//!     cargo test --features full --test light prove::soundness -- --ignored --nocapture

use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_interp::graph::{Arithmetic, Bounds, Graph, Range};
use landfall_interp::{Precision, Settings};
use landfall_layout::Options;

use super::device::Device;
use super::expression::{Tree, grow};
use super::fragment;

/// A stream of random numbers (splitmix64).
pub struct Random(pub u64);

impl Random {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    pub fn below(&mut self, end: u64) -> u64 {
        self.word() % end
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.word() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Functions with branches, loops, arrays and vectors.
pub const BRANCHES: [&str; 5] = [
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

/// Returns the number of samples whose values were compared with their bounds, and the first that
/// lies outside.
fn compare(
    pure: &PureFunction,
    graph: &Graph,
    part: &[Range],
    samples: &[Vec<f64>],
) -> (usize, Option<String>) {
    let mut bounds = Bounds::default();
    graph.bounds(part, Arithmetic::Permitted, &mut bounds);
    let Range { low, high } = bounds.results(graph).next().expect("it has one result");
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
        let any = !(least.is_finite() && most.is_finite());
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

/// A value of a device outside of the bounds of an expression over a part, among those compared.
fn outside_on_devices(
    tree: &Tree,
    bounds: Range,
    samples: &[Vec<f64>],
    random: &mut Random,
) -> (usize, Option<String>) {
    let mut compared = 0;
    for sample in samples {
        let inputs = [sample[0], sample[1], sample[2]].map(|x| x as f32);
        for _ in 0..3 {
            let Some(value) = Device::new(inputs, random).value(tree) else { continue };
            compared += 1;
            let value = f64::from(value);
            if !(bounds.low <= value && value <= bounds.high) {
                let text = format!("{inputs:?}: {value:?} is not in {bounds:?}");
                return (compared, Some(text));
            }
        }
    }
    (compared, None)
}

#[test]
fn no_value_of_a_random_device_lies_outside_of_the_bounds_of_an_expression() {
    compare_expressions(0..250);
}

#[test]
#[ignore = "takes minutes"]
fn no_value_of_a_random_device_lies_outside_of_the_bounds_of_two_thousand_expressions() {
    compare_expressions(0..2000);
}

/// Compares the values of devices with the bounds of random expressions over parts of their box.
fn compare_expressions(numbers: std::ops::Range<u32>) {
    let mut random = Random(1);
    let (mut compared, mut caught) = (0, 0);
    let expressions = numbers.len();
    for nth in numbers {
        let tree = grow(&mut random, 2 + nth % 3);
        let text = tree.text();
        let code = format!("float f(float a, float b, float c) {{\n    return {text};\n}}");
        let pure = function(&code);
        let all = vec![Range { low: -16.0, high: 16.0 }; 3];
        let graph = pure.graph(&all, &[]).expect("it is small");
        for part in boxes(&mut random, 3) {
            let samples = samples(&mut random, &part);
            let mut bounds = Bounds::default();
            graph.bounds(&part, Arithmetic::Permitted, &mut bounds);
            let range = bounds.results(&graph).next().expect("it has one result");
            let (count, outside) = outside_on_devices(&tree, range, &samples, &mut random);
            assert_eq!(outside, None, "{text} over {part:?}");
            compared += count;
            // Bounds that are one unit narrower are caught.
            let low = f64::from((range.low as f32).next_up());
            let narrower = Range { low, ..range };
            let narrower = outside_on_devices(&tree, narrower, &samples, &mut random);
            caught += usize::from(narrower.1.is_some());
        }
    }
    println!("{compared} values compared, {caught} narrower bounds caught");
    assert!(compared > 50 * expressions, "{compared} values were compared");
    assert!(caught > expressions / 10, "narrower bounds were caught {caught} times");
}

#[test]
fn no_permitted_value_of_a_function_with_branches_lies_outside_of_its_bounds() {
    let mut random = Random(2);
    let mut compared = 0;
    for code in BRANCHES {
        let pure = function(code);
        let all = vec![Range { low: -16.0, high: 16.0 }; 3];
        let graph = pure.graph(&all, &[]).expect("it is small");
        for _ in 0..60 {
            for part in boxes(&mut random, 3) {
                let samples = samples(&mut random, &part);
                let (count, outside) = compare(&pure, &graph, &part, &samples);
                assert_eq!(outside, None, "{code} over {part:?}");
                compared += count;
            }
        }
    }
    assert!(compared > 5_000, "{compared} samples were compared");
}
