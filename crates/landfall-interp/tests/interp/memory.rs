//! Buffers at Landfall's offsets, workgroup and private variables, constant arrays.

use std::time::Duration;

use super::support::{module, program, single, words};
use landfall_interp::backend::{Backend, Grid, Job, JobOutput, Resource, ResourceKind, StageCode};
use landfall_interp::{Call, Cpu, Program, Settings};
use landfall_layout::source::Stage;

pub fn resource(binding: u32, kind: ResourceKind) -> Resource {
    Resource { name: String::new(), group: 0, binding, kind }
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|w| w.to_le_bytes()).collect()
}

pub fn compute(text: &str, groups: [u32; 3], resources: Vec<Resource>) -> JobOutput {
    let stages = vec![StageCode::of_module(Stage::Compute, "main", module(text))];
    let job = Job { stages, resources, grid: Grid::Groups(groups), limit: Duration::from_secs(60) };
    Cpu::new(single()).run(&job).unwrap_or_else(|failure| panic!("{failure:?}"))
}

pub fn storage(words: &[u32]) -> ResourceKind {
    ResourceKind::Storage { bytes: bytes(words), writable: true }
}

pub fn left(answer: &JobOutput, resource: usize) -> Vec<u32> {
    let bytes = answer.buffers[resource].as_ref().expect("it is writable");
    bytes.chunks(4).map(|w| u32::from_le_bytes(w.try_into().expect("four bytes"))).collect()
}

#[test]
fn a_uniform_block_is_read_at_its_offsets() {
    // Offsets by WGSL §14.4: a 0, v 16, m 32 (columns of 16), s 80 (stride 16), t 112.
    let p = program(
        "struct Inner { x: f32, y: vec2<f32> }
        struct U { a: f32, v: vec3<f32>, m: mat3x3<f32>, s: array<Inner, 2>, t: u32 }
        @group(0) @binding(0) var<uniform> u: U;
        fn f(i: u32) -> u32 {
            switch i {
                case 0u: { return u32(u.a); }
                case 1u: { return u32(u.v.z); }
                case 2u: { return u32(u.m[1][2]); }
                case 3u: { return u32(u.s[1].y.x); }
                case 4u: { return u.t; }
                case 5u: { let s = u.s; return u32(s[0].y.y); }
                case 6u: { let all = u; return u32(all.m[2].x); }
                default: { return u32(u.m[i % 3u][i % 2u]); }
            }
        }",
    );
    let numbers: Vec<u32> = (0..28).map(|i| (1000.0 + i as f32).to_bits()).collect();
    let mut data = bytes(&numbers);
    data.extend(77u32.to_le_bytes());
    data.extend([0; 12]);
    let resources = [resource(0, ResourceKind::Uniform(data))];
    let lanes: Vec<u64> = (0..12).collect();
    let call =
        Call { function: "f", lanes: 12, arguments: vec![vec![lanes]], resources: &resources };
    let called = p.call(&call, &Settings { watch: true, ..single() }).expect("it runs");
    let expected = [1000, 1006, 1014, 1026, 77, 1023, 1016, 1013, 1016, 1009, 1012, 1017];
    assert_eq!(called.result.words[0], expected);
    let read = &called.notes.read[0];
    let words_read: Vec<usize> =
        (0..read.len() / 4).filter(|i| read[4 * i..4 * i + 4].iter().all(|r| *r)).collect();
    assert_eq!(words_read, [0, 6, 9, 12, 13, 14, 16, 17, 23, 26, 28]);
    assert_eq!(read.iter().filter(|r| **r).count(), 4 * words_read.len());
}

#[test]
fn storage_is_written_by_each_invocation() {
    let answer = compute(
        "@group(0) @binding(0) var<storage, read_write> data: array<u32>;
        @compute @workgroup_size(8, 2, 1)
        fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32) {
            let at = id.x + id.y * 24u;
            if at < arrayLength(&data) { data[at] = data[at] * 100u + i; }
        }",
        [3, 2, 1],
        vec![resource(0, storage(&(0..90).collect::<Vec<u32>>()))],
    );
    let expected: Vec<u32> = (0..90).map(|at| at * 100 + at % 24 % 8 + at / 24 % 2 * 8).collect();
    assert_eq!(left(&answer, 0), expected);
}

#[test]
fn a_workgroup_of_one_batch_meets_at_barriers() {
    let answer = compute(
        "var<workgroup> shared_: array<u32, 64>;
        @group(0) @binding(0) var<storage, read_write> out: array<u32>;
        @compute @workgroup_size(64)
        fn main(@builtin(local_invocation_index) i: u32, @builtin(workgroup_id) g: vec3<u32>) {
            shared_[i] = i + g.x;
            workgroupBarrier();
            for (var step = 32u; step > 0u; step /= 2u) {
                if i < step { shared_[i] += shared_[i + step]; }
                workgroupBarrier();
            }
            if i == 0u { out[g.x] = shared_[0]; }
        }",
        [3, 1, 1],
        vec![resource(0, storage(&[0; 3]))],
    );
    assert_eq!(left(&answer, 0), [2016, 2016 + 64, 2016 + 128]);
}

#[test]
fn atomics_take_turns() {
    let answer = compute(
        "struct S { sum: atomic<u32>, most: atomic<i32>, order: array<u32, 20> }
        @group(0) @binding(0) var<storage, read_write> s: S;
        @compute @workgroup_size(20)
        fn main(@builtin(local_invocation_index) i: u32) {
            s.order[i] = atomicAdd(&s.sum, i);
            atomicMax(&s.most, 7 - i32(i));
        }",
        [1, 1, 1],
        vec![resource(0, storage(&[0; 22]))],
    );
    let left = left(&answer, 0);
    assert_eq!(left[..2], [190, 7]);
    let before: Vec<u32> = (0..20u32).map(|i| (0..i).sum()).collect();
    assert_eq!(left[2..], before);
}

#[test]
fn constants_overrides_and_private_variables_start_as_written() {
    let text = "const table = array<u32, 4>(10u, 20u, 30u, 40u);
        const offset = table[1] + 5u;
        override scale = 3u;
        override twice = scale * 2u;
        var<private> count: u32 = offset;
        fn bump() -> u32 { count += scale; return count; }
        fn f(i: u32) -> u32 {
            var local = table;
            local[i % 4u] += 1u;
            let copy = local;
            return bump() + bump() * 1000u + table[i % 4u] * 1000000u + copy[(i + 1u) % 4u] + twice;
        }";
    let lanes: Vec<u32> = (0..70).collect();
    let expected = |scale: u32| -> Vec<u32> {
        lanes
            .iter()
            .map(|i| {
                let table = [10, 20, 30, 40];
                let at = *i as usize;
                25 + scale
                    + (25 + 2 * scale) * 1000
                    + table[at % 4] * 1_000_000
                    + table[(at + 1) % 4]
                    + scale * 2
            })
            .collect()
    };
    assert_eq!(words(&program(text), "f", &[&lanes]), expected(3));
    let given = Program::new(&module(text), &[("scale".into(), 5.0)]);
    assert_eq!(words(&given, "f", &[&lanes]), expected(5));
}

/// A place that was sampled before is not sampled again, unless that was in a branch or elsewhere; it
/// counts whenever the text samples it.
#[test]
fn samples_of_one_place_are_equal_wherever_they_are_taken() {
    let p = program(
        "@group(0) @binding(0) var t: texture_2d<f32>;
        @group(0) @binding(1) var s: sampler;
        fn at(u: f32) -> f32 { return textureSampleLevel(t, s, vec2<f32>(u, 0.5), 0.0).x; }
        fn f(a: f32, u: f32) -> f32 {
            var sum = 0.0;
            if a > 0.5 { sum = 100.0 * at(u); }
            sum += at(u);
            for (var i = 0; i < 3; i++) {
                sum += 10.0 * at(u);
                if a > 1.5 { break; }
                sum += at(u + f32(i) / 4.0);
            }
            return sum + 1000.0 * at(u);
        }",
    );
    let texels: Vec<[f32; 4]> = (1..5u8).map(|i| [f32::from(i), 0.0, 0.0, 1.0]).collect();
    let resources = [
        resource(0, ResourceKind::Texture { width: 4, height: 1, texels }),
        resource(1, ResourceKind::Sampler),
    ];
    // No lane enters the branch, some do, all do.
    for [first, second] in [[0u8, 0], [0, 1], [1, 2]] {
        let inputs: Vec<[u8; 2]> =
            (0..70).map(|i| [if i % 3 == 0 { first } else { second }, i % 4]).collect();
        let column = |k: usize, scale: f32, add: f32| -> Vec<Vec<u64>> {
            let bits = |input: &[u8; 2]| (f32::from(input[k]) * scale + add).to_bits();
            vec![inputs.iter().map(|input| u64::from(bits(input))).collect()]
        };
        let arguments = vec![column(0, 1.0, 0.0), column(1, 0.25, 0.125)];
        let call = Call { function: "f", lanes: 70, arguments, resources: &resources };
        let called = p.call(&call, &single()).expect("it runs");
        let mut samples = 0;
        for (lane, [a, at]) in inputs.iter().enumerate() {
            let texel = f32::from(at + 1);
            let mut expected = 1001.0 * texel + if *a > 0 { 100.0 * texel } else { 0.0 };
            samples += 2 + u64::from(*a > 0);
            for i in 0..3 {
                expected += 10.0 * texel;
                samples += 1;
                if *a > 1 {
                    break;
                }
                expected += f32::from((at + i) % 4 + 1);
                samples += 1;
            }
            let found = f32::from_bits(called.result.words[0][lane] as u32);
            assert_eq!(found, expected, "{a}, {at}");
        }
        assert_eq!(called.notes.counts.textures, samples);
    }
}
