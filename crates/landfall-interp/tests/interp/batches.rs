//! What is computed once for all batches, and by fused instructions: the results and counts are those
//! of a watched run, which computes everything by itself, and of Rust.

use super::memory::{compute, left, resource, storage};
use super::support::{program, single};
use landfall_interp::backend::ResourceKind;
use landfall_interp::internals::once_and_fused;
use landfall_interp::{Call, Called, Precision, Settings};

const TEXT: &str = "
    struct U { a: f32, b: f32, c: f32, v: vec3<f32> }
    @group(0) @binding(0) var<uniform> u: U;
    @group(0) @binding(1) var<storage, read> s: array<f32, 2>;
    fn scale() -> f32 { return sqrt(u.a) * 3.0 + exp(u.b) / 7.0; }
    fn f(k: u32, x: f32) -> f32 {
        var sum = 0.0;
        if (k & 1u) == 1u { sum = scale() * x + s[1]; }
        if (k & 2u) == 2u { return sum - x * u.c; }
        for (var i = 0u; i < k; i++) {
            let along = normalize(u.v) * x + u.v;
            sum = sum * 0.5 + dot(along, u.v);
            if i == 5u { sum += pow(abs(s[0]), u.a) - sum * x; }
        }
        return sum * x - scale();
    }";

const U: [f32; 8] = [2.25, -0.75, 1.5, 0.0, 0.3, -1.25, 2.0, 0.0];
const S: [f32; 2] = [1.75, -3.5];

fn run(lanes: usize, precision: Precision, watch: bool) -> Called {
    let bytes = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let (k, x) =
        (0..lanes).map(inputs).map(|(k, x)| (u64::from(k), u64::from(x.to_bits()))).unzip();
    let resources = [
        resource(0, ResourceKind::Uniform(bytes(&U))),
        resource(1, ResourceKind::Storage { bytes: bytes(&S), writable: false }),
    ];
    let call =
        Call { function: "f", lanes, arguments: vec![vec![k], vec![x]], resources: &resources };
    let settings = Settings { threads: 1, precision, watch, ..Settings::default() };
    program(TEXT).call(&call, &settings).unwrap_or_else(|failure| panic!("{failure:?}"))
}

/// All lanes of the first batch return early, those of the second do not; of the others some.
fn inputs(lane: usize) -> (u32, f32) {
    let k = match lane / 64 {
        0 => 2,
        1 => 4,
        _ => lane % 11,
    };
    (k as u32, lane as f32 / 64.0 - 3.0)
}

#[test]
fn only_what_needs_no_argument_is_computed_once() {
    let [once, fused] = once_and_fused(&program(TEXT));
    for op in ["RealUnary(Sqrt)", "RealUnary(Exp)", "RealBinary(Pow)", "Normalize(3)"] {
        assert!(once.iter().any(|one| one == op), "{op} is not among {once:?}");
    }
    assert!(once.iter().any(|op| op.starts_with("Load(")));
    assert!(!fused.is_empty());
    let text = "fn f(x: f32) -> f32 { return exp(x) * sqrt(x) + x; }";
    assert_eq!(once_and_fused(&program(text)), [vec![], vec!["RealBinary(Mul)".to_string()]]);
}

#[test]
fn many_batches_give_what_watched_ones_do() {
    for precision in [Precision::Single, Precision::Double, Precision::Both, Precision::Permitted] {
        for lanes in [1, 64, 500] {
            let (quick, watched) = (run(lanes, precision, false), run(lanes, precision, true));
            assert_eq!(quick.result, watched.result, "{precision:?}, {lanes} lanes");
            assert_eq!(quick.unsure, watched.unsure);
            assert_eq!(quick.notes.counts, watched.notes.counts, "{precision:?}, {lanes} lanes");
        }
    }
}

#[test]
fn many_batches_give_what_rust_does() {
    let [a, b, c, _, v @ .., _] = U;
    let scale = a.sqrt() * 3.0 + f64::from(b).exp() as f32 / 7.0;
    let dot = |x: [f32; 3], y: [f32; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    let length = dot(v, v).sqrt();
    let results = run(500, Precision::Single, false).result;
    for lane in 0..500 {
        let (k, x) = inputs(lane);
        let mut sum = if k & 1 == 1 { scale * x + S[1] } else { 0.0 };
        if k & 2 == 2 {
            sum -= x * c;
        } else {
            for i in 0..k {
                sum = sum * 0.5 + dot(v.map(|v| v / length * x + v), v);
                if i == 5 {
                    sum += f64::from(S[0].abs()).powf(f64::from(a)) as f32 - sum * x;
                }
            }
            sum = sum * x - scale;
        }
        let got = f32::from_bits(results.words[0][lane] as u32);
        assert_eq!(got.to_bits(), sum.to_bits(), "lane {lane}: {got}, not {sum}");
    }
}

#[test]
fn a_buffer_that_is_written_is_read_again_by_each_batch() {
    let text = "
        @group(0) @binding(0) var<storage, read_write> counter: u32;
        @group(0) @binding(1) var<storage, read_write> seen: array<u32, 100>;
        @compute @workgroup_size(1) fn main(@builtin(workgroup_id) group: vec3<u32>) {
            seen[group.x] = counter * 2u;
            counter += 1u;
        }";
    let resources = vec![resource(0, storage(&[0])), resource(1, storage(&[0; 100]))];
    let answer = compute(text, [100, 1, 1], resources);
    assert_eq!(left(&answer, 1), (0..100).map(|group| 2 * group).collect::<Vec<u32>>());
}

#[test]
fn what_no_invocation_of_a_batch_reaches_is_computed_in_the_next() {
    let p = program(
        "@group(0) @binding(0) var<uniform> b: f32;
        fn hide(k: u32) -> f32 {
            for (var i = 0u; i < 9u; i++) { if i == k { discard; } }
            if k == 100u { return 1.0; }
            return 2.0;
        }
        fn f(k: u32) -> f32 { let hidden = hide(k); return exp(b) + hidden; }",
    );
    let uniform = resource(0, ResourceKind::Uniform(0.5f32.to_le_bytes().to_vec()));
    // The first batch is discarded.
    let k = (0..128).map(|lane| if lane < 64 { 3 } else { 100 }).collect();
    let call = Call { function: "f", lanes: 128, arguments: vec![vec![k]], resources: &[uniform] };
    let called = p.call(&call, &single()).expect("it runs");
    let expected = (0.5f64.exp() as f32 + 1.0).to_bits();
    assert_eq!(called.discarded, (0..128).map(|lane| lane < 64).collect::<Vec<bool>>());
    assert!(called.result.words[0][64..].iter().all(|word| *word == u64::from(expected)));
}
