//! The evaluator's `f64` against 86 digits, on random expressions.
//!
//! How far it may be off is no guess: each expression's bound is carried through its own
//! operations (`number`), so that an expression that makes much of a rounding may be off by
//! more, and one that does not may not.

mod number;
mod tree;

use std::collections::BTreeMap;

use astro_float_num::RoundingMode;
use landfall_interp::{Call, Precision, Program, Settings};
use landfall_ir::Module;
use landfall_layout::{Options, Source};
use number::{Digits, Number, approximate, big};
use tree::{Tree, grow};

use crate::support::sample::{self, everything};

const EXPRESSIONS: usize = 10_000;
const SEED: u64 = 1980;

struct Drawn {
    tree: Tree,
    inputs: [f32; 3],
    truth: Number,
}

/// An expression whose value can be bounded, and where.
fn draw(random: &mut fastrand::Rng, digits: &mut Digits) -> Drawn {
    loop {
        let tree = grow(random, 4);
        if !matches!(tree, Tree::Call(..)) {
            continue;
        }
        let inputs = [0; 3].map(|_| {
            let size = 2f32.powi(random.i32(-8..5)) * (1.0 + random.f32());
            if random.bool() { size } else { -size }
        });
        if let Some(truth) = tree.value(digits, inputs) {
            return Drawn { tree, inputs, truth };
        }
    }
}

fn evaluate(drawn: &[Drawn]) -> Vec<f64> {
    let mut text = String::new();
    for (i, drawn) in drawn.iter().enumerate() {
        let value = drawn.tree.text();
        text += &format!("fn expression{i}(x: f32, y: f32, z: f32) -> f32 {{ return {value}; }}\n");
    }
    let module = Module::new(&Source::new("random.wgsl", text.as_str()), &Options::default());
    let program = Program::new(&module.unwrap_or_else(|found| panic!("{found:?}")), &[]);
    let settings = Settings { precision: Precision::Double, threads: 1, ..Settings::default() };
    let one = |(i, drawn): (usize, &Drawn)| {
        let function = format!("expression{i}");
        let arguments = drawn.inputs.iter().map(|x| vec![vec![u64::from(x.to_bits())]]).collect();
        let call = Call { function: &function, lanes: 1, arguments, resources: &[] };
        program.call(&call, &settings).expect("it runs").result.doubles[0][0]
    };
    drawn.iter().enumerate().map(one).collect()
}

#[test]
fn ten_thousand_random_expressions_are_within_their_bounds_of_86_digits() {
    let count = if everything() { EXPRESSIONS } else { EXPRESSIONS / 10 };
    let seed = if everything() { SEED } else { SEED + sample::seed() };
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut digits = Digits::new();
    let mut used: BTreeMap<&str, usize> = tree::names().map(|name| (name, 0)).collect();
    let (mut shares, mut bounds, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..count / 20 {
        let drawn: Vec<Drawn> = (0..20).map(|_| draw(&mut random, &mut digits)).collect();
        for (got, drawn) in evaluate(&drawn).into_iter().zip(&drawn) {
            let Drawn { tree, inputs, truth } = drawn;
            let mut calls = Vec::new();
            tree.calls(&mut calls);
            calls.iter().for_each(|name| *used.entry(name).or_default() += 1);
            let off = distance(truth, got);
            let within = off <= truth.off;
            if !within {
                let line = format!(
                    "{} at {inputs:?}: {got}, off by {off:.2e}, not {:.2e}",
                    tree.text(),
                    truth.off
                );
                wrong.push((calls.len(), line));
            }
            if truth.off > 0.0 {
                shares.push(off / truth.off);
                bounds.push(truth.off / truth.near().abs().max(truth.off));
            }
        }
    }
    wrong.sort();
    for (_, line) in wrong.iter().take(20) {
        println!("{line}");
    }
    bounds.sort_by(f64::total_cmp);
    let worst = shares.iter().copied().fold(0.0, f64::max);
    let (median, p90) = (bounds[bounds.len() / 2], bounds[bounds.len() * 9 / 10]);
    println!(
        "{} rounded; at most {worst:.2} of the bound; bounds are {median:.1e} in the middle, {p90:.1e} at the 90th of 100",
        bounds.len()
    );
    println!("least used: {:?}", used.iter().min_by_key(|(_, n)| **n));
    assert_eq!(wrong.len(), 0, "of {count}");
    // Bounds that allowed anything would show nothing.
    assert!(median < 1e-14 && p90 < 1e-12, "{median} {p90}");
    assert!(worst > 0.3, "no expression comes near its bound: {worst}");
    assert!(used.values().all(|n| *n * 100 > count), "{used:?}");
}

/// Where functions bend most: beside 1, beside 0, beside their poles and roots.
#[test]
fn functions_keep_their_digits_beside_their_singular_points() {
    let mut digits = Digits::new();
    let mut beside = Vec::new();
    for exponent in 1..24 {
        let gap = 2f32.powi(-exponent);
        beside.extend([gap, -gap, 1.0 - gap, gap - 1.0, 1.0 + gap, gap * 1.37e-6, gap * -1.9e-3]);
    }
    let quarter = std::f32::consts::FRAC_PI_2;
    beside.extend([quarter, quarter.next_up(), -2.0 * quarter, 2.0 * quarter, 64.0, 1e6]);
    let mut drawn = Vec::new();
    let all: Vec<&str> = tree::names().filter(|name| number::smooth(name).is_some()).collect();
    for name in &all {
        let tree = Tree::Call(name, vec![Tree::Input(0)]);
        for &x in &beside {
            let inputs = [x, 0.0, 0.0];
            if let Some(truth) = tree.value(&mut digits, inputs) {
                drawn.push(Drawn { tree: tree.clone(), inputs, truth });
            }
        }
    }
    assert!(drawn.len() > all.len() * 60, "{} of {} are defined", drawn.len(), all.len());
    let mut wrong = 0;
    for drawn in drawn.chunks(64) {
        for (got, Drawn { tree, inputs, truth }) in evaluate(drawn).into_iter().zip(drawn) {
            let off = distance(truth, got);
            let within = off <= truth.off;
            if !within {
                wrong += 1;
                println!("{} at {}: {got}, off by {off:.1e}", tree.text(), inputs[0]);
            }
        }
    }
    assert_eq!(wrong, 0);
}

fn distance(truth: &Number, got: f64) -> f64 {
    approximate(&truth.value.sub(&big(got), 288, RoundingMode::ToEven)).abs()
}
