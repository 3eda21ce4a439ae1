//! Benches: rounds in turns, spreads, who is better, and what is written of it.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use snapbox::str;

use crate::support::command::golden;
use crate::support::schema;
use landfall::report::bench as print;
use landfall_accuracy::bench::clock::{Clock, Elapsed};
use landfall_accuracy::bench::rank::{Verdict, better, columns, dominated};
use landfall_accuracy::bench::{
    Bench, BenchRow, Errors, Failed, Machine, Part, Permitted, Results, Rounds, Runner, Samples,
    Size, Spread, Unit, Work, Workload, drawing, measure,
};

/// A workload that tells its own times: those of a script, one a call.
struct Scripted {
    name: char,
    calls: Rc<RefCell<Vec<(char, Part)>>>,
    times: Vec<u64>,
    parts: Vec<Part>,
    fails_at: Option<usize>,
    called: usize,
}

impl Workload for Scripted {
    fn has(&self, part: Part) -> bool {
        self.parts.contains(&part)
    }

    fn run(&mut self, part: Part) -> Result<Option<Elapsed>, String> {
        self.calls.borrow_mut().push((self.name, part));
        self.called += 1;
        if self.fails_at == Some(self.called) {
            return Err("lost its device".to_string());
        }
        let time = Duration::from_nanos(self.times[(self.called - 1) % self.times.len()]);
        Ok(Some(Elapsed { time, clock: Clock::Device }))
    }
}

fn scripted(name: char, calls: &Rc<RefCell<Vec<(char, Part)>>>, times: &[u64]) -> Scripted {
    let (calls, times) = (Rc::clone(calls), times.to_vec());
    Scripted { name, calls, times, parts: vec![Part::Whole], fails_at: None, called: 0 }
}

const ONCE: Rounds = Rounds { count: 4, least: Duration::ZERO };

#[test]
fn rounds_go_forwards_and_backwards_and_the_first_is_dropped() {
    let calls = Rc::default();
    let mut a = scripted('a', &calls, &[900, 800, 1, 2, 3, 4]);
    let mut b = scripted('b', &calls, &[700, 600, 5, 6, 7, 8]);
    let mut seen = Vec::new();
    let samples = measure(&mut [&mut a, &mut b], &ONCE, &|| false, &mut |round| seen.push(round));
    let order: String = calls.borrow().iter().map(|(name, _)| *name).collect();
    // Each is run twice to warm and to see how long it takes, then A B, B A, B A, A B.
    assert_eq!(order, "aabbabbabaab");
    assert_eq!(seen, [0, 1, 2, 3, 4]);
    let a = samples[0].as_ref().unwrap();
    assert_eq!(a.clock, Clock::Device);
    let nanoseconds: Vec<u64> = a.whole.iter().map(|s| (s * 1e9).round() as u64).collect();
    assert_eq!(nanoseconds, [1, 2, 3, 4]);
}

#[test]
fn each_begins_as_often_as_the_others() {
    let calls = Rc::default();
    let [mut a, mut b, mut c] = ['a', 'b', 'c'].map(|name| scripted(name, &calls, &[1]));
    let rounds = Rounds { count: 6, ..ONCE };
    measure(&mut [&mut a, &mut b, &mut c], &rounds, &|| false, &mut |_| {});
    let order: String = calls.borrow().iter().skip(6).map(|(name, _)| *name).collect();
    assert_eq!(order, "abccbabcaacbcabbac");
}

#[test]
fn short_work_is_repeated_until_it_has_taken_long_enough() {
    let calls = Rc::default();
    let mut a = scripted('a', &calls, &[100]);
    let rounds = Rounds { count: 2, least: Duration::from_nanos(950) };
    let samples = measure(&mut [&mut a], &rounds, &|| false, &mut |_| {});
    // Chosen by one run and again by ten; an eighth more goes before each time that counts.
    assert_eq!(calls.borrow().len(), 2 + 10 + 2 * (1 + 10));
    // What is given is for one run.
    assert!((samples[0].as_ref().unwrap().whole[1] - 100e-9).abs() < 1e-15);
}

#[test]
fn what_fails_is_named_and_the_others_go_on() {
    let calls = Rc::default();
    let mut a = Scripted { fails_at: Some(4), ..scripted('a', &calls, &[1]) };
    let mut b = scripted('b', &calls, &[1]);
    let samples = measure(&mut [&mut a, &mut b], &ONCE, &|| false, &mut |_| {});
    assert_eq!(samples[0], Err("lost its device".to_string()));
    assert_eq!(samples[1].as_ref().unwrap().whole.len(), 4);
    assert_eq!(calls.borrow().iter().filter(|(name, _)| *name == 'a').count(), 4);
}

#[test]
fn an_interrupted_bench_keeps_its_complete_rounds() {
    let calls = Rc::default();
    let [mut a, mut b] = ['a', 'b'].map(|name| scripted(name, &calls, &[1]));
    // Two runs each to warm, one complete round, and one run of the next.
    let stop = || calls.borrow().len() >= 7;
    let samples = measure(&mut [&mut a, &mut b], &ONCE, &stop, &mut |_| {});
    let rounds: Vec<usize> = samples.iter().map(|s| s.as_ref().unwrap().whole.len()).collect();
    assert_eq!((rounds, calls.borrow().len()), (vec![1, 1], 7));
    let samples = measure(&mut [&mut a, &mut b], &ONCE, &|| true, &mut |_| {});
    assert!(samples.iter().all(|s| s.as_ref().is_err_and(|why| why.starts_with("interrupted"))));
    assert_eq!(calls.borrow().len(), 7);
}

#[test]
fn lights_cost_the_slope_and_fragments_what_is_above_nothing() {
    let runner = runner("rust");
    let samples = Samples {
        clock: Clock::Processor,
        whole: vec![130e-6, 140e-6],
        unlit: Some(vec![30e-6, 20e-6]),
        trivial: Some(vec![10e-6, 10e-6]),
    };
    let size = Size { fragments: 1000, lights: 5 };
    let row =
        BenchRow::new("a", runner, &samples, size, Errors::default(), Work::default()).unwrap();
    // (130 - 30) us over 1000 fragments and 5 lights; (130 - 10) us over 1000 fragments.
    let near = |a: &[f64], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(near(row.light_rounds.as_deref().unwrap(), [20.0, 24.0]), "{row:?}");
    assert!(near(&row.fragment_rounds, [120.0, 130.0]), "{row:?}");
    assert!(row.subtracted);
    assert!((row.fragment.median - 125.0).abs() < 1e-9);
    let none = Samples { unlit: None, trivial: None, ..samples };
    let size = Size { lights: 0, ..size };
    let row = BenchRow::new("a", row.runner, &none, size, row.errors, row.work).unwrap();
    assert_eq!(row.light, None);
    assert!(!row.subtracted);
}

#[test]
fn quartiles_lie_between_numbers_in_proportion() {
    let spread = Spread::from_numbers(&[4.0, 1.0, 2.0, 3.0]).unwrap();
    // Type 7 of Hyndman and Fan, as R's `quantile(1:4)` has it.
    assert_eq!((spread.lower, spread.median, spread.upper, spread.min), (1.75, 2.5, 3.25, 1.0));
    assert_eq!(Spread::from_numbers(&[]), None);
}

fn runner(backend: &str) -> Runner {
    Runner { backend: backend.to_string(), device: "a device".to_string(), clock: Clock::Processor }
}

/// A row of so many rounds, or of the same times again until there are enough to be told apart.
fn row(variant: &str, backend: &str, times: &[f64], max_steps: f64) -> BenchRow {
    let times = times.repeat(12usize.div_ceil(times.len()));
    row_of(variant, backend, &times, max_steps)
}

fn row_of(variant: &str, backend: &str, times: &[f64], max_steps: f64) -> BenchRow {
    let samples = Samples {
        clock: Clock::Processor,
        whole: times.iter().map(|t| t * 1e-6).collect(),
        unlit: Some(vec![0.0; times.len()]),
        trivial: None,
    };
    let errors = Errors {
        max_steps: Some(max_steps),
        p999_steps: Some(max_steps / 2.0),
        channels: 3000,
        ..Errors::default()
    };
    let size = Size { fragments: 100, lights: 10 };
    BenchRow::new(variant, runner(backend), &samples, size, errors, Work::default()).unwrap()
}

#[test]
fn better_is_not_worse_in_any_column_and_better_in_one() {
    let slow = row("slow", "cpu", &[4.0, 4.1, 4.2, 4.0], 0.5);
    let fast = row("fast", "cpu", &[2.0, 2.1, 2.2, 2.0], 0.5);
    let rough = row("rough", "cpu", &[1.0, 1.1, 1.2, 1.0], 0.6);
    assert!(better(&fast, &slow) && !better(&slow, &fast));
    assert!(!better(&rough, &fast) && !better(&fast, &rough), "one is faster, one more exact");
    assert!(!better(&fast, &fast), "no variant is better than itself");
    // Each other column alone undoes it.
    let worse: [fn(&mut BenchRow); 16] = [
        |row| row.errors.p999_steps = row.errors.p999_steps.map(|steps| 1.01 * steps),
        |row| row.errors.max_ulp = Some(9.0),
        |row| row.errors.p999_ulp = Some(5.0),
        |row| row.permitted = Some(Permitted { max_steps: Some(2.5), ..PERMITTED }),
        |row| row.permitted = Some(Permitted { max_steps: None, ..PERMITTED }),
        |row| row.permitted = Some(Permitted { p999_steps: Some(1.5), ..PERMITTED }),
        |row| row.permitted = Some(Permitted { unsure: 5, ..PERMITTED }),
        |row| row.errors.flips = Some(40),
        |row| row.errors.differing = Some(1),
        |row| row.errors.non_finite = 1,
        |row| row.ends = Some(Errors { max_steps: Some(3.5), ..ENDS }),
        |row| row.ends = Some(Errors { max_ulp: Some(9.5), ..ENDS }),
        |row| row.ends = Some(Errors { non_finite: 3, ..ENDS }),
        |row| row.work.slots = Some(9.0),
        |row| row.work.evaluations = Some(7.0),
        |row| row.work.bytes = Some(41),
    ];
    for (i, make) in worse.into_iter().enumerate() {
        let (mut slow, mut fast) = (slow.clone(), fast.clone());
        slow.work =
            Work { evaluations: Some(6.0), slots: Some(8.0), bytes: Some(40), ..Work::default() };
        slow.errors = Errors {
            max_ulp: Some(8.0),
            p999_ulp: Some(4.0),
            flips: Some(0),
            differing: Some(0),
            ..slow.errors
        };
        (slow.permitted, slow.ends) = (Some(PERMITTED), Some(ENDS));
        (fast.work, fast.errors, fast.permitted) = (slow.work, slow.errors, slow.permitted);
        fast.ends = slow.ends;
        assert!(better(&fast, &slow));
        make(&mut fast);
        assert!(!better(&fast, &slow), "column {i}");
    }
}

#[test]
fn differences_within_the_spread_are_none() {
    let a = row("a", "cpu", &[2.0, 2.1, 2.2, 2.0], 0.5);
    let b = row("b", "cpu", &[2.1, 2.0, 2.3, 1.9], 0.5);
    // Faster in two rounds, slower in two.
    assert!(!better(&a, &b) && !better(&b, &a));
    // One of three more flips could be by chance, one of three hundred more could not.
    let flips = |flips| {
        let mut row = a.clone();
        row.errors.flips = Some(flips);
        row
    };
    assert!(!better(&flips(2), &flips(3)));
    assert!(better(&flips(300), &flips(400)));
    // 30 lights and 28 are not apart where each may be off by 1, and are where they are counted.
    let lights = |n: f64, error: f64| {
        let mut row = a.clone();
        row.work = Work { evaluations: Some(n), evaluations_error: Some(error), ..row.work };
        row
    };
    assert!(!better(&lights(28.0, 1.0), &lights(30.0, 1.0)));
    assert!(better(&lights(27.0, 1.0), &lights(30.0, 1.0)));
    assert!(better(&lights(28.0, 0.0), &lights(30.0, 0.0)));
}

#[test]
fn a_variant_of_another_runner_is_never_better() {
    let here = row("a", "cpu", &[4.0, 4.0, 4.0, 4.0], 0.5);
    let there = row("a", "gpu", &[1.0, 1.0, 1.0, 1.0], 0.1);
    assert!(!better(&there, &here));
    let rows = [here, there, row("b", "gpu", &[2.0, 2.0, 2.0, 2.0], 0.2)];
    assert_eq!(dominated(&rows), [vec![], vec![], vec![1]]);
}

/// Times of one round of the same work: half as much again where the machine is busy, and
/// unlike by some percent, now and then by much more.
fn noisy(random: &mut fastrand::Rng, load: f64) -> f64 {
    let some = (0..4).map(|_| random.f64() - 0.5).sum::<f64>();
    let rare = if random.u32(..10) == 0 { 0.3 * random.f64() } else { 0.0 };
    10.0 * load * (1.0 + 0.05 * some + rare)
}

/// How many of a thousand benches of two call either of them faster; the second takes so much
/// more.
fn told_apart(rounds: usize, more: f64) -> (usize, usize) {
    let mut random = fastrand::Rng::with_seed(7);
    let (mut first, mut second) = (0, 0);
    for _ in 0..1000 {
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..rounds {
            let load = 1.0 + 0.5 * random.f64();
            times[0].push(noisy(&mut random, load));
            times[1].push(noisy(&mut random, load) * (1.0 + more));
        }
        let [a, b] = times.map(|times| row_of("a", "cpu", &times, 0.5));
        first += usize::from(better(&a, &b));
        second += usize::from(better(&b, &a));
    }
    (first, second)
}

#[test]
fn the_same_work_is_not_faster_than_itself() {
    // At most as often as the level that is stated, one in a hundred.
    for rounds in [3, 4, 8, 15, 16, 41] {
        let (first, second) = told_apart(rounds, 0.0);
        assert!(first + second <= 10, "{rounds} rounds: {first} and {second}");
    }
    // What lies in other places of memory takes some percent more or less, in every round.
    for more in [0.02, -0.02] {
        let (first, second) = told_apart(41, more);
        assert!(first + second <= 10, "{more}: {first} and {second}");
    }
    let still: [&[f64]; 2] = [&[10.0; 15], &[10.3; 15]];
    let [a, b] = still.map(|times| row_of("a", "cpu", times, 0.5));
    assert!(!better(&a, &b) && !better(&b, &a));
}

#[test]
fn what_takes_longer_is_told_apart_in_eight_rounds_and_in_no_fewer() {
    assert_eq!(told_apart(7, 1.0), (0, 0));
    for (rounds, more) in [(8, 1.0), (15, 0.5)] {
        let (first, second) = told_apart(rounds, more);
        assert!(first > 900 && second == 0, "{rounds} rounds: {first} and {second}");
    }
}

/// Where most of the time is subtracted, some percent of all of it are much of what is left.
#[test]
fn a_part_of_what_is_subtracted_is_no_difference() {
    let net = |nanoseconds: f64, clock: Clock| {
        let samples = Samples {
            clock,
            whole: vec![(28.0 + nanoseconds) * 1e-7; 15],
            unlit: None,
            trivial: Some(vec![28.0e-7; 15]),
        };
        let (errors, size) = (Errors::default(), Size { fragments: 100, lights: 0 });
        BenchRow::new("a", runner("cpu"), &samples, size, errors, Work::default()).unwrap()
    };
    let [two, three, five] = [2.0, 3.0, 5.0].map(|n| net(n, Clock::Processor));
    assert!((two.fragment_gross - 30.0).abs() < 1e-9 && (two.fragment.median - 2.0).abs() < 1e-9);
    assert!(!better(&two, &three) && better(&two, &five));
    // Timestamps of a device are of its work alone.
    let [two, three] = [2.0, 3.0].map(|n| net(n, Clock::Device));
    assert!(better(&two, &three));
}

#[test]
fn who_gives_no_number_is_better_than_nobody() {
    let nothing = |times: &[f64]| {
        let mut row = row("nothing", "cpu", times, 0.5);
        row.errors = Errors { non_finite: 1000, ..Errors::default() };
        row
    };
    let slow = row("slow", "cpu", &[4.0], 2.0);
    let fast = nothing(&[1.0]);
    assert!(better(&slow, &fast) && !better(&fast, &slow));
    assert!(better(&fast, &nothing(&[2.0])), "of two of the kind, times tell");
    let mut elsewhere = slow.clone();
    elsewhere.runner = runner("gpu");
    assert!(!better(&elsewhere, &fast));
}

/// Where most of the time is that of an empty kernel, 5 % of the whole are more than a net time
/// differs by; the quartiles that are printed still tell that it is no better.
#[test]
fn a_variant_whose_quartiles_lie_above_is_not_better() {
    let unlit = |row: BenchRow| BenchRow {
        fragment_gross: 600.0,
        light: None,
        light_rounds: None,
        light_gross: None,
        ..row
    };
    let [fast, slow] = [1.42, 2.33].map(|time| {
        let rounds: Vec<f64> = (0..15).map(|nth| time + 0.01 * f64::from(nth)).collect();
        let error = if time < 2.0 { 0.5 } else { 0.1 };
        unlit(row("f", "cpu", &rounds, error))
    });
    assert_eq!(columns(&slow, &fast)[1], Verdict::Same, "the placement of code may explain it");
    assert!(slow.errors.max_steps < fast.errors.max_steps);
    assert!(!better(&slow, &fast) && !better(&fast, &slow));
    // Within the quartiles, the more accurate one is better.
    let near: Vec<f64> = (0..15).map(|nth| 1.45 + 0.01 * f64::from(nth)).collect();
    let near = unlit(row("f", "cpu", &near, 0.1));
    assert!(better(&near, &fast));
}

#[test]
fn a_busy_machine_ranks_as_an_idle_one() {
    // Times of variants that take 10, 12 and 20; then the same rounds of a machine that another
    // program slows by up to three times, a little differently for each of a round.
    let idle: [&[f64]; 3] = [&[10.0; 9], &[12.0; 9], &[20.0; 9]];
    let mut random = fastrand::Rng::with_seed(1);
    let load = [1.0, 2.6, 1.2, 3.0, 1.1, 2.2, 1.4, 2.9, 1.7];
    let busy: Vec<Vec<f64>> = idle
        .iter()
        .map(|times| {
            times.iter().zip(&load).map(|(t, load)| t * load * (1.0 + 0.1 * random.f64())).collect()
        })
        .collect();
    let rank = |times: &[&[f64]]| {
        let names = ["a", "b", "c"];
        let rows: Vec<BenchRow> =
            times.iter().zip(names).map(|(times, name)| row(name, "cpu", times, 0.5)).collect();
        dominated(&rows)
    };
    let busy: Vec<&[f64]> = busy.iter().map(Vec::as_slice).collect();
    assert_eq!(rank(&idle), [vec![], vec![0], vec![0, 1]]);
    assert_eq!(rank(&busy), rank(&idle));
    // The quartiles of the busy one overlap: it is the rounds that tell.
    let [a, b] = [0, 1].map(|i| Spread::from_numbers(busy[i]).unwrap());
    assert!(a.upper > b.lower);
}

#[test]
fn errors_are_those_of_defined_fragments_and_numbers() {
    let truth: Vec<Option<[f64; 3]>> =
        vec![Some([0.5, 0.25, 0.0]), None, Some([0.5; 3]), Some([0.25; 3])];
    let colors =
        [[0.5, 0.25 + 2.0 / 255.0, 0.0], [9.0; 3], [f32::NAN, 0.0, 0.0], [0.25, 0.25, 0.25]];
    let errors = Errors::new(&colors, &truth);
    assert_eq!((errors.undefined, errors.non_finite, errors.channels), (1, 1, 6));
    assert!(errors.max_steps.is_some_and(|most| (most - 2.0).abs() < 1e-5));
    assert_eq!(errors.flips, Some(1));
    // sRGB is steeper than 1 there: 0.25 is 137.4, 0.25 + 2/255 is 139.3.
    assert_eq!(errors.max_code, Some(2));
    // Of nothing that can be compared there is no error, which is not one of 0.
    assert_eq!(Errors::new(&[], &[]), Errors::default());
    let nothing = Errors::new(&[[f32::NAN; 3]; 2], &[Some([0.5; 3]); 2]);
    assert_eq!((nothing.max_steps, nothing.p999_steps, nothing.flips), (None, None, None));
    assert!(nothing.is_no_number() && !errors.is_no_number() && !Errors::default().is_no_number());
}

#[test]
fn errors_of_calls_are_in_units_of_the_last_place_too() {
    let of = |floats: &[f64]| Results { floats: floats.to_vec(), ..Results::default() };
    let whole = |n: u64| Results { wholes: vec![n], ..of(&[1.0]) };
    // 1 + 2^-23 is the next f32 above 1; 3/1000 of 1000 is 0.765 steps of a full scale of 1000.
    let next = f64::from(1.0f32.next_up());
    let errors = |all: &[(Results, Option<Results>)]| {
        Errors::of_calls(all.iter().map(|(ours, truth)| (ours.clone(), truth.as_ref())))
    };
    let (found, worst) = errors(&[
        (of(&[next, 0.0]), Some(of(&[1.0, 0.0]))),
        (of(&[1003.0]), Some(of(&[1000.0]))),
        (of(&[f64::NAN]), Some(of(&[1.0]))),
        (Results { missing: true, ..of(&[0.0]) }, Some(of(&[0.0]))),
        (of(&[5.0]), None),
    ]);
    // Of three floats that of 1003 is the furthest off, and that of `next` in the middle.
    assert_eq!((worst, found.median_ulp), ([Some(1); 2], Some(1.0)));
    assert_eq!((found.channels, found.non_finite, found.undefined), (3, 2, 1));
    assert!(found.max_steps.is_some_and(|most| (most - 0.765).abs() < 1e-9), "{found:?}");
    // A unit of the last place of 1000 is 2^-14.
    assert_eq!(found.max_ulp, Some(3.0 * 16384.0));
    assert_eq!((found.flips, found.differing), (None, None));
    let (one, _) = errors(&[(of(&[next]), Some(of(&[1.0])))]);
    assert_eq!((one.max_ulp, one.p999_ulp), (Some(1.0), Some(1.0)));
    let wholes = [(whole(1), Some(whole(2))), (whole(3), Some(whole(3)))];
    assert_eq!(errors(&wholes).0.differing, Some(1));
}

const ENDS: Errors = Errors {
    max_steps: Some(3.0),
    p999_steps: None,
    median_steps: None,
    max_ulp: Some(9.0),
    p999_ulp: None,
    median_ulp: None,
    channels: 50,
    flips: None,
    max_code: None,
    differing: None,
    non_finite: 2,
    undefined: 0,
};

const PERMITTED: Permitted =
    Permitted { max_steps: Some(2.0), p999_steps: Some(1.0), unsure: 0, samples: 100 };

fn bench() -> Bench {
    let mut rows = vec![
        row("seed, \"as is\"", "rust", &[4.0, 4.1, 4.2, 4.0], 1.03e-3),
        row("robust", "rust", &[2.0, 2.1, 2.2, 1.0 / 3.0], 9.0e-4),
        row("zeros", "gpu", &[30.0, 31.0, 32.0, 30.0], 0.0),
    ];
    rows[1].work = Work {
        evaluations: Some(5.38),
        evaluations_error: Some(0.02),
        slots: Some(6.0),
        powers: Some(1.29),
        operations: Some(540.25),
        bytes: Some(6148),
    };
    rows[1].errors = Errors { flips: Some(7), max_code: Some(1), ..rows[1].errors };
    rows[1].permitted = Some(PERMITTED);
    rows[2].permitted = Some(Permitted { max_steps: None, unsure: 3, ..PERMITTED });
    rows[2].errors = Errors { max_ulp: Some(3.5), differing: Some(2), ..rows[2].errors };
    rows[2].errors.non_finite = 100;
    rows[2].light = None;
    rows[2].light_rounds = None;
    Bench {
        subject: "six lights".to_string(),
        truth: "the reference in f64".to_string(),
        unit: Unit::Fragment,
        fragments: 243_037,
        lights: 6,
        inputs: None,
        machine: Machine {
            processor: Some("AMD EPYC".to_string()),
            threads: 2,
            system: "linux x86_64".to_string(),
            load: Some([0.5, 14.21]),
            optimised: false,
        },
        rows,
        failed: vec![Failed {
            variant: "robust".to_string(),
            backend: "gl".to_string(),
            reason: "no driver".to_string(),
        }],
    }
    .ranked()
}

#[test]
fn json_comes_back_as_it_was() {
    let bench = bench();
    let text = print::json(&bench);
    let read: Bench = serde_json::from_str(&text).unwrap();
    assert_eq!(read, bench);
    let validator = schema::validator(print::BENCH_SCHEMA);
    let value = schema::holds(&validator, &text, "a bench");
    assert_eq!(value["rows"][0]["dominated_by"], serde_json::json!(["robust"]));
    let mut odd = value.clone();
    odd["rows"][0]["errors"]["flips"] = serde_json::json!(-1);
    assert!(!validator.is_valid(&odd));
    let mut odd = value.clone();
    odd["rows"][0]["errors"]["max_steps"] = serde_json::Value::Null;
    assert!(validator.is_valid(&odd));
    let mut odd = value.clone();
    odd["rows"][1]["permitted"]["samples"] = serde_json::Value::Null;
    assert!(!validator.is_valid(&odd));
}

#[test]
fn csv_has_every_number_in_full() {
    let bench = bench();
    let text = print::csv(&bench);
    let lines: Vec<Vec<String>> = text.lines().map(cells).collect();
    let header = &lines[0];
    let at = |line: &[String], name: &str| {
        let column = header.iter().position(|cell| cell == name);
        line[column.unwrap_or_else(|| panic!("no column {name}"))].clone()
    };
    assert_eq!(lines.len(), 1 + bench.rows.len());
    for (line, row) in lines[1..].iter().zip(&bench.rows) {
        assert_eq!(line.len(), header.len());
        assert_eq!(at(line, "variant"), row.variant);
        assert_eq!(at(line, "backend"), row.runner.backend);
        let number = |name| at(line, name).parse::<f64>().ok();
        assert_eq!(number("ns_per_fragment"), Some(row.fragment.median));
        assert_eq!(number("ns_per_light_min"), row.light.map(|spread| spread.min));
        assert_eq!(number("err_max_steps"), row.errors.max_steps);
        assert_eq!(number("evaluations"), row.work.evaluations);
        assert_eq!(number("slots"), row.work.slots);
        assert_eq!(number("err_max_ulp"), row.errors.max_ulp);
        // What may be anything is more than any number.
        let permitted = row.permitted.map(|p| p.max_steps.unwrap_or(f64::INFINITY));
        assert_eq!(number("permitted_max_steps"), permitted);
        assert_eq!(number("differing"), row.errors.differing.map(|n| n as f64));
        assert_eq!(number("bytes"), row.work.bytes.map(|n| n as f64));
        assert_eq!(number("non_finite"), Some(row.errors.non_finite as f64));
        assert_eq!(at(line, "dominated_by"), row.dominated_by.join(" "));
    }
}

/// The cells of a line of RFC 4180.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let (mut quoted, mut rest) = (false, line.chars().peekable());
    while let Some(c) = rest.next() {
        let cell = cells.last_mut().unwrap();
        match (c, quoted) {
            ('"', true) if rest.peek() == Some(&'"') => {
                rest.next();
                cell.push('"');
            }
            ('"', _) => quoted = !quoted,
            (',', false) => cells.push(String::new()),
            (c, _) => cell.push(c),
        }
    }
    cells
}

#[test]
fn the_table_marks_who_is_not_beaten_and_names_who_beats() {
    let bench = bench();
    let text = print::text(&bench, true, landfall_layout::format::Paint::Plain);
    let line = |name: &str| {
        let found = text.lines().find(|line| line.get(3..).is_some_and(|l| l.starts_with(name)));
        found.unwrap_or_else(|| panic!("no {name} in\n{text}"))
    };
    assert!(line("robust").starts_with("*"), "{text}");
    // The columns of a variant take several lines, the last of which names who beats it.
    let seed: Vec<&str> = text.lines().filter(|line| line.contains("   seed")).collect();
    assert!(seed.iter().all(|line| line.starts_with(' ')), "{text}");
    assert!(seed.last().is_some_and(|line| line.ends_with("robust")), "{text}");
    golden().eq(
        &text,
        str![[r#"
six lights  243,037 fragments, 6 lights
rust: `robust` wins: 0.506 (quartiles 0.396 to 0.515) of the time of `seed,
  "as is"`; off by at most 9.0e-4 steps, where `seed, "as is"` is by 1.0e-3
errors against the reference in f64
...

rust  a device; processor time
   variant                   ns/light          ns/fragment  max step
   seed, "as is"  4.05 (4.00 to 4.12)  40.5 (40.0 to 41.2)    1.0e-3
*  robust         2.05 (1.58 to 2.12)  20.5 (15.8 to 21.2)    9.0e-4
   variant        99.9 % step  permitted  permitted 99.9 %  unsure    flips
   seed, "as is"       5.2e-4
*  robust              4.5e-4       2.00              1.00     0 %  0.233 %
   variant        non-finite  undefined  lights  slots  powers  operations
   seed, "as is"           0          0
*  robust                  0          0    5.38   6.00    1.29         540
   variant        bytes  dominated by
   seed, "as is"         robust
*  robust         6,148

gpu  a device; processor time
   variant       ns/fragment  max ulp  max step  99.9 % step  permitted
*  zeros    305 (300 to 312)     3.50         0            0        any
   variant  permitted 99.9 %  unsure  differing  non-finite  undefined
*  zeros                1.00  3.00 %          2         100          0

* no other variant is better than it in one column and worse in none
permitted: the error in steps that WGSL and Vulkan allow a device; unsure:
samples in which a device may take another branch
dominated by: a variant that is better in a column, worse in none, and whose
quartiles of time do not lie above

robust on gl: no driver

"#]],
    );
    // The conditions, with the rounds, are those of what ran.
    let conditions = |text: &str| {
        let lines = text.lines().skip_while(|line| !line.starts_with("linux"));
        let lines = lines.take_while(|line| !line.is_empty());
        lines.map(|line| format!("{line}\n")).collect::<String>()
    };
    golden().eq(
        conditions(&text),
        str![[r#"
linux x86_64, 2 threads, AMD EPYC; load 0.5 before, 14.21 after; 12 interleaved
rounds; medians and quartiles; built without optimisation: times of Rust
variants are not representative

"#]],
    );
    // Where nothing ran, there are no rounds; where nothing is a number, no error and no mark.
    let mut odd = bench.clone();
    odd.rows.truncate(1);
    odd.rows[0].errors = Errors { non_finite: 9, ..Errors::default() };
    let odd_text = print::text(&odd.clone().ranked(), true, landfall_layout::format::Paint::Plain);
    let nothing: Vec<&str> = odd_text.lines().filter(|line| line.contains("   seed")).collect();
    assert!(nothing.iter().all(|line| !line.starts_with('*')), "{odd_text}");
    let words = nothing.iter().flat_map(|line| line.split_whitespace());
    assert!(words.filter(|word| *word == "-").count() >= 1, "{odd_text}");
    let csv = print::csv(&odd);
    let read: Vec<Vec<String>> = csv.lines().map(cells).collect();
    let at = read[0].iter().position(|name| name == "err_max_steps").unwrap();
    assert_eq!((read[1][at].as_str(), read[1][at + 1].as_str()), ("", ""));
    odd.rows.clear();
    let nothing_ran = print::text(&odd, true, landfall_layout::format::Paint::Plain);
    golden().eq(
        conditions(&nothing_ran),
        str![[r#"
linux x86_64, 2 threads, AMD EPYC; load 0.5 before, 14.21 after; built without
optimisation: times of Rust variants are not representative

"#]],
    );
    let drawn = drawing(&bench);
    assert!(drawn.marks[0].dominated && !drawn.marks[1].dominated);
    // What gave no number has no error to be drawn at.
    assert!(!drawn.marks[2].error.is_finite());
}

#[cfg(unix)]
#[test]
fn the_processor_clock_counts_threads_that_ended() {
    use landfall_accuracy::bench::clock::Start;
    let work = || {
        let start = std::time::Instant::now();
        while start.elapsed() < Duration::from_millis(30) {
            std::hint::black_box(0);
        }
    };
    let start = Start::now();
    std::thread::spawn(work).join().unwrap();
    let Elapsed { time: busy, clock } = start.elapsed();
    let start = Start::now();
    std::thread::sleep(Duration::from_millis(30));
    let Elapsed { time: idle, .. } = start.elapsed();
    assert_eq!(clock, Clock::Processor);
    // Others may have had the processor for most of those 30 ms, and other tests run beside.
    assert!(busy > Duration::from_millis(1), "{busy:?} {idle:?}");
}
