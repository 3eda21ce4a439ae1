//! Maps of the error over two inputs, with the others fixed as in a scene.
//!
//! Reads a [`Report`]; draws with [`plot`](crate::plot).

use super::Request;
use super::case::Case;
use super::deadline::Deadline;
use super::domain::{Domain, ValueRange};
use super::input::{Inputs, Sample};
use super::matched;
use super::measure::{Outcome, floats, outcome};
use super::messages::figure;
use super::plan::{Plan, columns, settings};
use super::random::Random;
use super::report::Report;
use super::role::InputRole;
use super::sampler::Sampler;
use super::scene::{Geometry, SceneSetting};
use crate::plot::{Axis, Cell, HeatMap, MapMark, heat_map};
use landfall_exec::harness::call::Refusal;
use landfall_exec::harness::call::pure::PureFunction;
use landfall_layout::diagnostic::Code;
use landfall_layout::source::Source;
use landfall_layout::text::edit_distance::suggestion;
use landfall_layout::{Diagnostic, Options};

/// The axes and the resolution of a map.
#[derive(Clone, Debug)]
pub struct MapRequest {
    /// The path of the horizontal scalar.
    pub x: String,
    /// The path of the vertical scalar.
    pub y: String,
    /// The cells in a row.
    pub columns: usize,
    pub rows: usize,
}

impl Default for MapRequest {
    fn default() -> MapRequest {
        MapRequest { x: String::new(), y: String::new(), columns: 96, rows: 72 }
    }
}

/// Returns the error of a function over two of its inputs, as SVG.
///
/// # Errors
/// Those of [`stress`](super::stress()); a path that is not a float scalar of the function.
pub fn error_map(
    source: &Source,
    options: &Options,
    request: &Request,
    report: &Report,
    map: &MapRequest,
) -> Result<String, Box<Refusal>> {
    let pure = PureFunction::new(source, options, &request.pure)?;
    let against = request.against.as_ref();
    let against =
        against.map(|(source, other)| PureFunction::new(source, options, other)).transpose()?;
    let all = matched::shared(&pure, &against.iter().collect::<Vec<_>>());
    let refused = |found| Box::new(Refusal { found: vec![found], files: pure.files.clone() });
    let domain =
        crate::inputs::domain(source, &pure, &all, request.domain.as_ref()).map_err(&refused)?;
    let paths: Vec<&String> = pure.parameters.iter().flat_map(|p| &p.scalars).collect();
    let scalar = |path: &str, about: &str| -> Result<usize, Box<Refusal>> {
        let found = paths.iter().position(|known| *known == path);
        // Only floats have an error to show along them.
        let found = found.filter(|at| all.iter().any(|i| i.range().contains(at) && i.is_float()));
        found.ok_or_else(|| {
            refused(Diagnostic::about(
                Code::UnknownInput,
                format!("the function has no float input `{path}`"),
                suggestion(path, paths.iter().map(|p| p.as_str())),
                about,
            ))
        })
    };
    let (x, y) = (scalar(&map.x, "--map-x")?, scalar(&map.y, "--map-y")?);
    if x == y {
        let message = format!("`{}` cannot be both axes of a map", map.x);
        return Err(refused(Diagnostic::about(Code::BadRequest, message, None, "--map-y")));
    }
    let plan = Plan {
        samples: 0,
        until: Deadline::default(),
        threads: 1,
        steps: request.steps,
        ulp: f64::INFINITY,
        least_steps: 0.0,
        budget: request.budget,
    };
    let base = base(&all, &domain, request.seed);
    let axis = |at: usize, path: &str| axis(&all, &domain, &base, at, path);
    let (across, up) = (axis(x, &map.x), axis(y, &map.y));
    let floats = floats(&pure);
    let mut cells = Vec::with_capacity(map.columns * map.rows);
    // A row is one call.
    for row in 0..map.rows {
        let samples: Vec<Sample> = (0..map.columns)
            .map(|column| {
                let mut sample = base.clone();
                let part = |i: usize, of: usize| (i as f64 + 0.5) / of as f64;
                let put = |axis: &Axis, at: f64| u64::from((axis.number(at) as f32).to_bits());
                sample[x] = put(&across, part(column, map.columns));
                sample[y] = put(&up, part(row, map.rows));
                sample
            })
            .collect();
        let called = pure.call(&columns(&samples), samples.len(), &settings(&plan, true));
        // A row that does not end stays empty.
        let Ok(called) = called else {
            cells.resize(cells.len() + map.columns, Cell::Empty);
            continue;
        };
        let undefined = |lane: usize| {
            called.called.notes.undefined.iter().any(|seen| seen.lanes.contains(&lane))
        };
        for lane in 0..samples.len() {
            cells.push(match outcome(&called, &floats, lane) {
                Outcome::Discarded => Cell::Empty,
                Outcome::NotANumber | Outcome::Infinite => Cell::NonFinite,
                Outcome::Finite(..) if undefined(lane) => Cell::Undefined,
                Outcome::Finite(off, _) => Cell::Error(off.steps),
            });
        }
    }
    let errors = cells.iter().filter_map(|cell| match cell {
        Cell::Error(steps) if *steps > 0.0 => Some(*steps),
        Cell::Error(_) | Cell::NonFinite | Cell::Undefined | Cell::Empty => None,
    });
    // The colours reach the worst error of the whole run, so that maps can be compared.
    let worst = report.worst.iter().map(|worst| worst.off.steps).filter(|steps| *steps > 0.0);
    let error = Axis::around("error, steps of 1/255", errors.chain(worst));
    let title = format!("{} in {}", report.function, report.path);
    let columns = map.columns;
    let marks = marks(report, [x, y]);
    Ok(heat_map(&HeatMap { title, x: across, y: up, error, columns, cells, marks }))
}

/// Returns the worst sample of the run and the first with a result that is not finite, as the two
/// inputs of a map have them.
fn marks(report: &Report, [x, y]: [usize; 2]) -> Vec<MapMark> {
    let place = |case: &Case| [x, y].map(|at| f64::from(super::input::float(&case.words, at)));
    let worst = report.worst.iter().max_by(|a, b| a.off.steps.total_cmp(&b.off.steps));
    let worst = worst.filter(|worst| worst.off.steps > 0.0).map(|worst| MapMark {
        at: place(&worst.sample),
        text: format!("{} steps", figure(worst.off.steps)),
    });
    let odd = report.findings.iter().find_map(|found| {
        let text = match found.outcome {
            Outcome::NotANumber => "NaN",
            Outcome::Infinite => "infinite",
            Outcome::Discarded | Outcome::Finite(..) => return None,
        };
        Some(MapMark { at: place(&found.case), text: text.to_string() })
    });
    worst.into_iter().chain(odd).collect()
}

/// Returns the axis of a scalar: its range in the domain, or a usual one for its role.
fn axis(inputs: &Inputs, domain: &Domain, base: &Sample, at: usize, path: &str) -> Axis {
    let nth = inputs.iter().position(|i| i.range().contains(&at)).unwrap_or(0);
    let now = f64::from(super::input::float(base, at));
    let (within, (low, high)) = (domain.within[nth], domain.bounds(nth, at));
    if matches!(within, ValueRange::Range(..)) || (low, high) != within.bounds() {
        // Several orders of magnitude, all positive: logarithmic.
        let wide = low > 0.0 && high > 100.0 * low;
        return if wide { Axis::log(path, low, high) } else { Axis::linear(path, low, high) };
    }
    match (within, inputs[nth].role) {
        (ValueRange::Any, role) if role.is_position() => Axis::linear(path, now - 2.0, now + 2.0),
        (ValueRange::Any, InputRole::Shininess) => Axis::log(path, 1.0, 65536.0),
        (ValueRange::Any, InputRole::Constant | InputRole::Linear | InputRole::Quadratic) => {
            Axis::linear(path, 0.0, 1.0)
        }
        (
            ValueRange::Any,
            InputRole::InnerCosine | InputRole::OuterCosine | InputRole::ConeCosine,
        ) => Axis::linear(path, 0.9, 1.0),
        (ValueRange::Any, InputRole::Distance) => Axis::log(path, 1.0e-6, 1.0e6),
        (ValueRange::Position, _) => Axis::linear(path, now - 2.0, now + 2.0),
        (ValueRange::Any | ValueRange::Unit | ValueRange::Cosine, _) => {
            Axis::linear(path, -1.0, 1.0)
        }
        (ValueRange::Color | ValueRange::Range(..), _) => Axis::linear(path, 0.0, 1.0),
    }
}

/// Returns a scene in the domain.
fn base(inputs: &Inputs, domain: &Domain, seed: u64) -> Sample {
    let mut random = Random::new(seed, 1 << 41);
    let setting = SceneSetting { geometry: Geometry::InRamp, cone: 0, shine: 0, exact: true };
    let sampler = Sampler::new(inputs, domain);
    // A few tries, as the domain may reject scenes; then all zeros.
    let found = (0..64).find_map(|_| sampler.scene(setting, &mut random));
    found.unwrap_or_else(|| vec![0; inputs.scalars])
}
