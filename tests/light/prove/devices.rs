//! No value of the interpreter or of a driver lies outside of its bounds: random expressions, the
//! functions with known singular sets, and the functions of the repository's shaders.
//!
//! Needs drivers; a missing one fails.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use landfall_exec::backend::Backend;
use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_interp::graph::{Arithmetic, Bounds, Range};
use landfall_interp::{Precision, Settings};
use landfall_layout::shape::ScalarKind;
use landfall_layout::{Options, Source};
use serde_json::Value;

use super::expression::grow;
use super::soundness::{BRANCHES, Random};
use super::{fragment, functions, programs};
use crate::support::backends::with_readers;
use crate::support::sample::{everything, sample};

/// Lanes of a call; the notes of a run keep as many.
const LANES: usize = 64;

/// The most scalars of a function that drivers run: LLVM takes minutes for entry points whose blocks
/// of a hundred lights are inputs.
const MAX_ON_DRIVERS: usize = 256;

/// A function with the box of its inputs.
struct Function {
    name: String,
    pure: PureFunction,
    whole: Vec<Range>,
    /// By scalar: whether it is a float.
    floats: Vec<bool>,
    units: Vec<Vec<usize>>,
    /// Whether its shader calls `asin` or `acos`.
    is_arc: bool,
}

fn function(name: &str, source: &Source, called: &str, domain: &Value) -> Option<Function> {
    let request = PureRequest { function: called.to_string(), ..PureRequest::default() };
    let pure = PureFunction::new(source, &Options::default(), &request).ok()?;
    let (mut whole, mut floats, mut units) = (Vec::new(), Vec::new(), Vec::new());
    for parameter in &pure.parameters {
        let first = whole.len();
        let within = domain.get(&parameter.path);
        for scalar in parameter.ty.scalars() {
            let is_float = scalar.kind == ScalarKind::Float;
            if scalar.width != 4 && scalar.kind != ScalarKind::Bool {
                return None;
            }
            let (low, high) = match (within, scalar.kind) {
                (Some(Value::Array(ends)), _) => (ends[0].as_f64()?, ends[1].as_f64()?),
                (Some(Value::String(word)), _) if word == "color" => (0.0, 1.0),
                (Some(_), _) => (-1.0, 1.0),
                (None, ScalarKind::Float) => (-2.0, 2.0),
                (None, ScalarKind::Bool) => (0.0, 1.0),
                (None, _) => (0.0, 3.0),
            };
            let [low, high] = match is_float {
                true => [low as f32, high as f32].map(f64::from),
                false => [low, high],
            };
            whole.push(Range { low, high });
            floats.push(is_float);
        }
        if within.is_some_and(|within| within == "unit") {
            units.push((first..whole.len()).collect());
        }
    }
    let is_arc = ["asin(", "acos("].iter().any(|call| source.text.contains(call));
    Some(Function { name: name.to_string(), pure, whole, floats, units, is_arc })
}

impl Function {
    /// A part of the box, with the samples in it as columns of words.
    fn part(&self, random: &mut Random, share: f64) -> (Vec<Range>, Vec<Vec<u64>>) {
        let narrowed = |(range, is_float): (&Range, &bool)| {
            let width = (range.high - range.low) * share;
            let low = random.between(range.low, range.high - width);
            let high = (low + width).min(range.high);
            match is_float {
                true => [low as f32, high as f32].map(f64::from),
                false => [low.floor(), high.ceil()],
            }
        };
        let part: Vec<[f64; 2]> = self.whole.iter().zip(&self.floats).map(narrowed).collect();
        let mut part: Vec<Range> =
            part.into_iter().map(|[low, high]| Range { low, high: high.max(low) }).collect();
        // Parts of a sphere are mostly empty.
        for &at in self.units.iter().flatten() {
            part[at] = self.whole[at];
        }
        let mut samples: Vec<Vec<f64>> = Vec::new();
        for _ in 0..LANES {
            let inside = |(range, is_float): (&Range, &bool)| {
                let x = match random.below(6) {
                    0 => range.low,
                    1 => range.high,
                    _ => random.between(range.low, range.high),
                };
                let x = if *is_float { f64::from(x as f32) } else { x.round() };
                x.clamp(range.low, range.high)
            };
            let mut sample: Vec<f64> = part.iter().zip(&self.floats).map(inside).collect();
            for unit in &self.units {
                let length = unit.iter().map(|&at| sample[at] * sample[at]).sum::<f64>().sqrt();
                let scale = if length > 0.0 { 1.0 / length } else { 1.0 };
                unit.iter().for_each(|&at| sample[at] = f64::from((sample[at] * scale) as f32));
                if length == 0.0 {
                    sample[unit[0]] = 1.0;
                }
            }
            samples.push(sample);
        }
        let word = |at: usize, x: f64| match self.floats[at] {
            true => u64::from((x as f32).to_bits()),
            false => u64::from(x as i64 as u32),
        };
        let column = |at: usize| samples.iter().map(|sample| word(at, sample[at])).collect();
        let columns = (0..part.len()).map(column).collect();
        (part, columns)
    }

    /// Compares the values of every backend with their bounds over parts of the box; returns how
    /// many were compared, and those outside.
    fn compare(
        &self,
        random: &mut Random,
        backends: &mut [Box<dyn Backend>],
    ) -> (usize, Vec<String>) {
        let Some(graph) = self.pure.graph(&self.whole, &self.units) else { return (0, Vec::new()) };
        let kernels: Vec<_> =
            backends.iter().map(|backend| self.pure.on(backend.device())).collect();
        let (mut compared, mut outside) = (0, Vec::new());
        for share in [1.0, 0.1, 1e-4] {
            let (part, columns) = self.part(random, share);
            let mut bounds = Bounds::default();
            graph.bounds(&part, Arithmetic::Permitted, &mut bounds);
            let ranges: Vec<Range> = bounds.results(&graph).collect();
            let settings = Settings { precision: Precision::Permitted, ..Settings::default() };
            let Ok(permitted) = self.pure.call(&columns, LANES, &settings) else { continue };
            let settings = Settings { watch: true, ..Settings::default() };
            let Ok(single) = self.pure.call(&columns, LANES, &settings) else { continue };
            let broken = single.called.notes.undefined.iter().flat_map(|seen| &seen.lanes);
            let broken: Vec<usize> = broken.copied().collect();
            let fine = |lane: &usize| {
                !permitted.called.unsure[*lane]
                    && !single.called.discarded[*lane]
                    && !broken.contains(lane)
            };
            let lanes: Vec<usize> = (0..LANES).filter(fine).collect();
            let mut all: Vec<(&str, Vec<Vec<Vec<u64>>>)> = Vec::new();
            let own = single.results.iter().map(|result| result.words.clone()).collect();
            all.push(("interpreter", own));
            for (backend, kernel) in backends.iter_mut().zip(&kernels) {
                let name = backend.device().backend.name();
                // OpenGL runs no WGSL.
                let Ok(kernel) = kernel else { continue };
                if self.whole.len() > MAX_ON_DRIVERS {
                    continue;
                }
                // OpenGL specifies no accuracy of these; Mesa's are off by more than WGSL permits.
                if name == "gl" && self.is_arc {
                    continue;
                }
                let limit = Duration::from_secs(60);
                let called = kernel.call(backend.as_mut(), &columns, LANES, limit);
                let called = called.unwrap_or_else(|why| panic!("{}: {name}: {why}", self.name));
                all.push((name, called.results));
            }
            let mut flat = 0;
            for (nth, result) in self.pure.results.iter().enumerate() {
                for (at, scalar) in result.ty.scalars().iter().enumerate() {
                    let range = ranges[flat];
                    flat += 1;
                    if (scalar.kind, scalar.width) != (ScalarKind::Float, 4) {
                        continue;
                    }
                    let spans = permitted.results[nth].permitted.as_ref().expect("asked for");
                    for &lane in &lanes {
                        let [low, high] = spans[at][lane];
                        if !(low.is_finite() && high.is_finite()) {
                            continue;
                        }
                        for (name, results) in &all {
                            let value = f32::from_bits(results[nth][at][lane] as u32);
                            let value = f64::from(value);
                            compared += 1;
                            if !(range.low <= value && value <= range.high) {
                                let words: Vec<f32> = columns
                                    .iter()
                                    .map(|column| f32::from_bits(column[lane] as u32))
                                    .collect();
                                outside.push(format!(
                                    "{}: {name}: {words:?}: {value:?} is not in [{:?}, {:?}]",
                                    self.name, range.low, range.high
                                ));
                            }
                        }
                    }
                }
            }
        }
        (compared, outside)
    }
}

/// Sixteen random expressions, as the components of a matrix.
fn sixteen(random: &mut Random, depth: u32) -> Function {
    let texts: Vec<String> = (0..16).map(|_| grow(random, depth).text()).collect();
    let code = format!(
        "mat4 f(float a, float b, float c) {{\n    return mat4(\n{});\n}}",
        texts.join(",\n")
    );
    let domain = serde_json::json!({"a": [-16, 16], "b": [-16, 16], "c": [-16, 16]});
    function(&code, &fragment(&code), "f", &domain).expect("it is a function")
}

/// The functions with known singular sets, their twins, the programs of FPBench and others.
fn written() -> Vec<Function> {
    let mut all = Vec::new();
    for known in functions::all() {
        let domain = serde_json::from_str(known.domain).expect("the test's domain is JSON");
        for code in [known.code, known.twin] {
            all.extend(function(known.name, &fragment(code), "f", &domain));
        }
    }
    for program in programs::PROGRAMS {
        let range = |&(name, low, high): &(&str, f64, f64)| (name.to_string(), [low, high].into());
        let domain: serde_json::Map<String, Value> = program.domain.iter().map(range).collect();
        all.extend(function(program.name, &fragment(program.code), "f", &domain.into()));
    }
    let domain = serde_json::json!({"a": [-16, 16], "b": [-16, 16], "c": [-16, 16]});
    all.extend(BRANCHES.iter().filter_map(|code| function(code, &fragment(code), "f", &domain)));
    all
}

/// The functions of the repository's shaders.
fn of_shaders() -> Vec<Function> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["shaders/seed", "shaders/casters", "shaders/many_lights", "shaders/six_lights"];
    let folders = folders.iter().chain(&["shaders/view_space", "tests/hazards"]);
    let mut all = Vec::new();
    for folder in folders {
        let read = std::fs::read_dir(root.join(folder)).expect("the folder exists");
        let mut files: Vec<_> = read.map(|entry| entry.expect("it is read").path()).collect();
        files.sort();
        for file in files {
            let Ok(source) = Source::read(&file) else { continue };
            let heads = source.text.lines().filter(|line| line.starts_with(char::is_alphabetic));
            for line in heads {
                let Some((before, _)) = line.split_once('(') else { continue };
                let Some(name) = before.split_whitespace().last() else { continue };
                let shown = format!("{} of {}", name, file.display());
                all.extend(function(&shown, &source, name, &Value::Null));
            }
        }
    }
    all
}

/// Compares functions on backends; none of their values may lie outside.
fn none_is_outside(functions: &[Function], seed: u64, backends: &mut [Box<dyn Backend>]) -> usize {
    let mut random = Random(seed);
    let (mut compared, mut outside) = (0, Vec::new());
    for function in functions {
        let (count, more) = function.compare(&mut random, backends);
        compared += count;
        outside.extend(more);
    }
    println!("{} functions, {compared} values compared", functions.len());
    assert!(outside.is_empty(), "{} outside, first\n{}", outside.len(), outside[0]);
    compared
}

#[test]
fn no_value_of_two_thousand_expressions_and_two_hundred_functions_lies_outside() {
    let mut random = Random(11);
    let expressions: Vec<Function> = (0..if everything() { 125 } else { 12 })
        .map(|nth| sixteen(&mut random, 2 + nth % 3))
        .collect();
    let mut functions = written();
    functions.extend(of_shaders());
    let tried: BTreeSet<u64> = sample(0..functions.len() as u64, 10).collect();
    let mut number = 0..;
    functions.retain(|_| number.next().is_some_and(|number| tried.contains(&number)));
    let on_drivers = functions.iter().filter(|known| known.whole.len() <= MAX_ON_DRIVERS).count();
    println!("{} functions, {on_drivers} of them on drivers", functions.len());
    let share = if everything() { 1 } else { 20 };
    assert!(on_drivers >= 200 / share, "{on_drivers} functions on drivers");
    with_readers(|backends| {
        let compared = none_is_outside(&expressions, 12, backends);
        assert!(compared > 300_000 / share, "{compared} values were compared");
        let compared = none_is_outside(&functions, 13, backends);
        assert!(compared > 50_000 / share, "{compared} values were compared");
    });
}
