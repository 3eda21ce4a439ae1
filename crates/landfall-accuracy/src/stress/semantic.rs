//! Rules about how the result changes with an input, which no single sample shows.
//!
//! A light below the horizon has no highlight; the length of a normal has no effect; a cut-off
//! given as an angle lights too much. Used by the report beside [`find`](super::find).

use std::time::{Duration, Instant};

use super::blame::Graph;
use super::classify::{Examined, HazardCandidate, Performed, examine};
use super::domain::ValueRange;
use super::find::UnreportedFinding;
use super::input::{Input, Inputs, Sample, float};
use super::measure::{Outcome, SampleError, floats};
use super::plan::SampleSearch;
use super::random::Random;
use super::role::InputRole;
use super::scene;
use super::scene::{Geometry, SceneSetting};
use landfall_interp::{Operation, Source, TracedOperation};
use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::hazard::threshold::CHANGE;

/// The scenes each rule is tested on.
const SCENES: usize = 48;

/// The time that the rules may always take.
const LEAST: Duration = Duration::from_secs(1);

/// Returns the samples that break a rule.
pub(super) fn findings(search: SampleSearch<'_>, seed: u64) -> Vec<UnreportedFinding> {
    let check = SemanticCheck { search, end: search.plan.until.end_with(LEAST) };
    let mut random = Random::new(seed, 1 << 40);
    let mut all = Vec::new();
    all.extend(check.behind(&mut random));
    all.extend(check.normals(&mut random));
    all.extend(check.cones(&mut random));
    all
}

struct SemanticCheck<'a> {
    search: SampleSearch<'a>,
    /// The time at which the rules are given up.
    end: Instant,
}

impl SemanticCheck<'_> {
    fn inputs(&self) -> &Inputs {
        self.search.inputs()
    }

    fn of(&self, is: impl Fn(&Input) -> bool) -> Vec<usize> {
        (0..self.inputs().len()).filter(|&at| is(&self.inputs()[at])).collect()
    }

    fn scene(&self, geometry: Geometry, random: &mut Random) -> Option<Sample> {
        let setting =
            SceneSetting { geometry, cone: random.below(3), shine: random.below(4), exact: true };
        self.search.generator.sampler.scene(setting, random)
    }

    fn examine(&self, sample: &Sample) -> Option<Examined> {
        if self.search.plan.until.is_stopped() || Instant::now() > self.end {
            return None;
        }
        examine(self.search, sample).ok()
    }

    /// Returns the `f64` results; `None` if one is not finite.
    fn values(&self, examined: &Examined) -> Option<Vec<f64>> {
        let values: Vec<f64> = floats(self.search.pure)
            .iter()
            .map(|&(nth, at)| examined.called.results[nth].doubles[at][0])
            .collect();
        values.iter().all(|x| x.is_finite()).then_some(values)
    }

    fn graph<'g>(&'g self, examined: &'g Examined) -> Graph<'g> {
        Graph { pure: self.search.pure, trace: &examined.trace, inputs: self.inputs() }
    }

    fn raw(
        &self,
        hazard: Hazard,
        graph: &Graph<'_>,
        step: &TracedOperation,
        sample: &Sample,
        about: Vec<usize>,
        change: f64,
    ) -> UnreportedFinding {
        let operation = Performed {
            operation: step.operation,
            operands: step.operands.iter().map(|o| o.number).collect(),
            result: step.results.first().copied().unwrap_or_default(),
            sources: step.operands.iter().map(|o| o.source).collect(),
            scale: 0.0,
        };
        let place = graph.pure.place_of(step);
        let candidate = HazardCandidate {
            hazard,
            place,
            operation: Some(operation),
            about,
            members: Vec::new(),
            kind: None,
            what: None,
        };
        let off = SampleError { ulp: 0.0, relative: 0.0, steps: 255.0 * change };
        UnreportedFinding {
            candidate,
            outcome: Outcome::Finite(off, false),
            sample: sample.clone(),
            severity: 255.0 * change,
            seen: 1,
            plausible: self.search.is_plausible(sample),
        }
    }

    /// Tests that a light below the horizon has no highlight.
    fn behind(&self, random: &mut Random) -> Option<UnreportedFinding> {
        // In scenes with the light behind the surface: a dot product below zero that something
        // cuts off at zero is the facing term; a power that depends on the same vectors is a
        // highlight. If changing an input of the highlight alone changes the result, it shows from
        // behind.
        for _ in 0..SCENES {
            let Some(sample) = self.scene(Geometry::Behind, random) else { continue };
            let Some(examined) = self.examine(&sample) else { continue };
            let Some(values) = self.values(&examined) else { continue };
            let graph = self.graph(&examined);
            for (away, step) in examined.trace.steps.iter().enumerate() {
                let below = step.operation == Operation::Dot
                    && step.results[0].double < -1.0e-3
                    && cut_at_zero(&examined, away);
                if !below {
                    continue;
                }
                let facing = graph.inputs_of(step.operands.iter().map(|o| o.source));
                if !facing.iter().any(|&at| self.inputs()[at].role == InputRole::Normal) {
                    continue;
                }
                if let Some(raw) = self.highlight(&graph, &facing, &sample, &values, random) {
                    return Some(raw);
                }
            }
        }
        None
    }

    /// Returns a highlight of the same light that affects the result.
    fn highlight(
        &self,
        graph: &Graph<'_>,
        facing: &[usize],
        sample: &Sample,
        values: &[f64],
        random: &mut Random,
    ) -> Option<UnreportedFinding> {
        for step in &graph.trace.steps {
            let shines = step.operation == Operation::Pow && step.results[0].double > 1.0e-2;
            if !shines {
                continue;
            }
            let behind = graph.inputs_of(step.operands.iter().map(|o| o.source));
            if !facing.iter().all(|at| behind.contains(at)) {
                continue;
            }
            // The inputs of the highlight that the facing term does not depend on.
            for &only in behind.iter().filter(|at| !facing.contains(at)) {
                let mut other = sample.clone();
                let input = &self.inputs()[only];
                for at in input.range() {
                    let x = float(sample, at);
                    // A scalar, such as an exponent, is made larger; a vector, such as the eye's
                    // position, goes to the other side.
                    let moved = match input.len {
                        1 => x * 4.0 + 1.0,
                        _ => -x + random.between(-0.5, 0.5) as f32,
                    };
                    other[at] = u64::from(moved.to_bits());
                }
                let Some(examined) = self.examine(&other) else { continue };
                let Some(others) = self.values(&examined) else { continue };
                let change = difference(values, &others);
                if change > CHANGE.value {
                    let hazard = Hazard::HighlightFromBehind;
                    return Some(self.raw(hazard, graph, step, sample, vec![only], change));
                }
            }
        }
        None
    }

    /// Tests that the length of a normal has no effect.
    fn normals(&self, random: &mut Random) -> Option<UnreportedFinding> {
        let domain = &self.search.domain().within;
        // A domain of unit vectors promises the length.
        let free = |at: &usize| matches!(domain[*at], ValueRange::Any | ValueRange::Range(..));
        let normals = self.of(|i| i.role == InputRole::Normal && i.is_vector());
        let normals: Vec<usize> = normals.into_iter().filter(free).collect();
        let mut worst: Option<UnreportedFinding> = None;
        for &normal in &normals {
            for scene in 0..SCENES {
                let geometry = if scene % 2 == 0 { Geometry::Mirror } else { Geometry::Ordinary };
                let Some(sample) = self.scene(geometry, random) else { continue };
                let mut scaled = sample.clone();
                // 10 % longer, as after interpolation of scaled normals, and 20 % shorter.
                let factor = if scene % 4 < 2 { 1.1f32 } else { 0.8 };
                for at in self.inputs()[normal].range() {
                    scaled[at] = u64::from((float(&sample, at) * factor).to_bits());
                }
                let pair = self.examine(&sample).zip(self.examine(&scaled));
                let Some((one, other)) = pair else { continue };
                let Some((a, b)) = self.values(&one).zip(self.values(&other)) else { continue };
                let change = difference(&a, &b);
                // The worst of all scenes is reported.
                let known = worst.as_ref().map_or(CHANGE.value, |raw| raw.severity / 255.0);
                if change > known {
                    let graph = self.graph(&other);
                    let step = self.first_of(&one, &other, normal);
                    worst = step.map(|step| {
                        let hazard = Hazard::UnnormalisedNormal;
                        self.raw(hazard, &graph, step, &scaled, vec![normal], change)
                    });
                }
            }
        }
        worst
    }

    /// Follows the largest change between two runs back to the operation that reads the input.
    fn first_of<'e>(
        &'e self,
        one: &Examined,
        other: &'e Examined,
        input: usize,
    ) -> Option<&'e TracedOperation> {
        if one.trace.steps.len() != other.trace.steps.len() {
            // The runs took different branches: the first operation that reads the input.
            let graph = self.graph(other);
            return other
                .trace
                .steps
                .iter()
                .find(|step| step.operands.iter().any(|o| graph.input(o.source) == Some(input)));
        }
        // Both runs have the same operations in the same order, so their numbers can be compared
        // step by step.
        let graph = self.graph(other);
        let sources = self.search.pure.sources(&other.trace);
        let number = |examined: &Examined, source: Source| match source {
            Source::Step { step, part } => {
                examined.trace.steps[step as usize].results.get(part as usize).map(|n| n.double)
            }
            _ => None,
        };
        let change = |source: Source| match (number(one, source), number(other, source)) {
            (Some(a), Some(b)) => (a - b).abs() / a.abs().max(b.abs()).max(1.0e-12),
            _ => 0.0,
        };
        // Backwards along the operand that changed most, to the operation that reads the normal.
        let mut at = sources.iter().copied().max_by(|a, b| change(*a).total_cmp(&change(*b)))?;
        for _ in 0..other.trace.steps.len() {
            let (step, _) = graph.step(at)?;
            if step.operands.iter().any(|o| graph.input(o.source) == Some(input)) {
                return Some(step);
            }
            at = step
                .operands
                .iter()
                .map(|o| o.source)
                .max_by(|a, b| change(*a).total_cmp(&change(*b)))?;
        }
        None
    }

    /// Tests that a cut-off in degrees and its cosine light the same points.
    fn cones(&self, random: &mut Random) -> Option<UnreportedFinding> {
        let domain = &self.search.domain().within;
        let wide = |at: &usize| domain[*at].bounds().1 >= 17.5;
        let cones = self.of(|i| i.role.is_cone() && i.is_number());
        let cones: Vec<usize> = cones.into_iter().filter(wide).collect();
        let mut owners: Vec<&str> =
            cones.iter().map(|&at| self.inputs()[at].owner.as_str()).collect();
        owners.dedup();
        for owner in owners.into_iter().take(4) {
            let own: Vec<usize> =
                cones.iter().copied().filter(|&at| self.inputs()[at].owner == owner).collect();
            for _ in 0..SCENES {
                if let Some(raw) = self.cone(&own, random) {
                    return Some(raw);
                }
            }
        }
        None
    }

    fn cone(&self, cones: &[usize], random: &mut Random) -> Option<UnreportedFinding> {
        // The point on the axis is lit, and with the axis turned round it is not. With cut-offs in
        // degrees it should be the same; a function that expects cosines lights the wrong one of
        // them.
        let setting = SceneSetting { geometry: Geometry::OnAxis, cone: 0, shine: 0, exact: true };
        let lit = scene::sample(self.inputs(), setting, random);
        let owner = &self.inputs()[cones[0]].owner;
        let mut away = lit.clone();
        let related = |path: &str| path == owner || owner.starts_with(&format!("{path}."));
        let beams: Vec<usize> =
            self.of(|i| i.role == InputRole::Axis && (related(&i.owner) || i.owner.is_empty()));
        for at in beams.iter().flat_map(|&beam| self.inputs()[beam].range()) {
            away[at] ^= 1 << 31;
        }
        let value = |sample: &Sample| self.values(&self.examine(sample)?);
        let (on, off) = (value(&lit)?, value(&away)?);
        let shines = difference(&on, &off);
        // A scene in which the cone makes no difference tells nothing.
        if shines < 1.0e-2 {
            return None;
        }
        let degrees = |sample: &Sample| {
            let mut changed = sample.clone();
            for &cone in cones {
                let outer = self.inputs()[cone].role == InputRole::OuterCosine;
                let angle = if outer { 17.5f32 } else { 12.5 };
                changed[self.inputs()[cone].first] = u64::from(angle.to_bits());
            }
            changed
        };
        for (sample, wanted, other) in [(&away, &off, &on), (&lit, &on, &off)] {
            let changed = degrees(sample);
            let mut fitted = changed.clone();
            if !self.search.domain().fit(&mut fitted, self.inputs(), random) || fitted != changed {
                continue;
            }
            let examined = self.examine(&changed)?;
            let got = self.values(&examined)?;
            let change = difference(wanted, &got);
            // Nearer to what is wanted than to the other: no finding.
            if change < 0.5 * difference(wanted, other) {
                continue;
            }
            let graph = self.graph(&examined);
            // A comparison of a cut-off with a value computed from the directions.
            let meets = |step: &&TracedOperation| {
                let reads = |o: &landfall_interp::Operand| {
                    graph.input(o.source).is_some_and(|at| cones.contains(&at))
                };
                let trigonometric = step.operation == Operation::Trigonometric;
                !trigonometric
                    && step.operands.iter().any(&reads)
                    && step.operands.iter().any(|o| matches!(o.source, Source::Step { .. }))
            };
            let step = examined.trace.steps.iter().find(meets)?;
            let hazard = Hazard::ConeOutOfRange;
            return Some(self.raw(hazard, &graph, step, &changed, cones.to_vec(), change));
        }
        None
    }
}

/// Whether the result of a step is cut off at zero: by `max`, `clamp` or a branch.
fn cut_at_zero(examined: &Examined, number: usize) -> bool {
    examined.trace.steps.iter().any(|step| {
        let cuts = matches!(step.operation, Operation::Max | Operation::Clamp | Operation::Compare(_));
        let reads = |o: &landfall_interp::Operand| {
            matches!(o.source, Source::Step { step, .. } if step as usize == number)
        };
        cuts && step.operands.iter().any(reads)
    })
}

/// Returns the largest difference of two results as a share of full scale.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let scale = a.iter().map(|x| x.abs()).fold(1.0, f64::max);
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) / scale
}
