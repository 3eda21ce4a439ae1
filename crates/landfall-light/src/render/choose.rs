//! Measures ways to light a scene on a sample of its fragments, and picks one.
//!
//! The sample is whole squares of the picture, spread over it, so that tiles of them hold what tiles
//! of the picture do.

use glam::Vec3;

use super::{Draw, RenderError, Rendered, Renderer, Work};
use crate::bind::{FragmentLights, Kind};
use crate::culling::{self, Choice, Options, Plan, Timed};
use crate::shading_f32::Model;
use crate::splitmix64::SplitMix64;
use crate::{Fragment, Frame};
use landfall_exec::backend::Backend;

/// The side of a square of the sample: a multiple of the tiles tried.
const SIDE: u32 = 32;

/// The fewest fragments of a sample, and its part of a larger frame.
const FEWEST: usize = 2048;
const PART: usize = 32;

/// The rounds that count; one before them compiles.
const ROUNDS: usize = 3;

/// A way that takes so many times as long as skipping nothing is measured once only.
const SLOWER: f64 = 2.0;

/// A way to light the scene.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The parts of `--skip`.
    pub parts: String,
    /// The same, read.
    pub options: Options,
    /// The shader that executes it.
    pub renderer: Renderer,
    /// The plan for the sample, measured with the model.
    pub plan: Plan,
}

/// Runs work on a backend and returns its seconds.
pub type Timer<'t> = dyn FnMut(
        &mut dyn Backend,
        &mut dyn FnMut(&mut dyn Backend) -> Result<Rendered, RenderError>,
    ) -> Result<(Rendered, f64), RenderError>
    + 't;

/// Returns the parts of `--skip` to try for a permitted error in steps.
pub fn candidates(permitted: f64) -> Vec<String> {
    let exact = ["used", "used,tiles=8,always", "used,tiles=16,always", "used,tiles=32,always"];
    let mut all: Vec<String> = exact.into_iter().map(str::to_string).collect();
    all.push("used,clusters,always".to_string());
    if permitted > 0.0 {
        all.push(format!("used,tiles=16,budget={permitted},always"));
        all.push(format!("used,far={permitted},always"));
        all.push("used,interpolate=4,always".to_string());
    }
    all
}

/// Returns some fragments of a frame: all of those in some of its squares.
pub fn sample(frame: &Frame) -> Frame {
    let wanted = (frame.fragments.len() / PART).max(FEWEST);
    let across = frame.width.div_ceil(SIDE).max(1);
    let square = |fragment: &Fragment| {
        let (column, row) =
            (fragment.pixel % frame.width.max(1), fragment.pixel / frame.width.max(1));
        (row / SIDE * across + column / SIDE) as usize
    };
    let mut counts = vec![0usize; across as usize * frame.height.div_ceil(SIDE).max(1) as usize];
    frame.fragments.iter().for_each(|fragment| counts[square(fragment)] += 1);
    let mut order: Vec<(u64, usize)> =
        (0..counts.len()).map(|at| (SplitMix64(at as u64).next(), at)).collect();
    order.sort_unstable();
    let mut taken = vec![false; counts.len()];
    let mut total = 0;
    for (_, at) in order {
        if total >= wanted {
            break;
        }
        taken[at] = true;
        total += counts[at];
    }
    let chosen = frame.fragments.iter().filter(|fragment| taken[square(fragment)]);
    Frame { width: frame.width, height: frame.height, fragments: chosen.cloned().collect() }
}

/// Measures skipping nothing and the candidates by turns, and picks. `work` is that of the sample,
/// `of` the number of fragments of the whole frame.
///
/// # Errors
/// More lights than slots, or a failure of the backend.
pub fn choose(
    whole: &Renderer,
    candidates: &[Candidate],
    backend: &mut dyn Backend,
    work: &Work<'_>,
    model: &Model,
    [permitted, of]: [f64; 2],
    time: &mut Timer<'_>,
) -> Result<Choice, RenderError> {
    let fragments = work.frame.fragments.len();
    let scale = of / fragments.max(1) as f64;
    let all = |backend: &mut dyn Backend| whole.render_all(backend, work);
    let by = |candidate: &Candidate, backend: &mut dyn Backend| {
        let Candidate { options, renderer, .. } = candidate;
        let mut plan = whole.plan_only(work, model, options);
        if renderer.reads_tile_lists() {
            plan.tiles = plan.tile_lists().ok();
        }
        renderer.render_plan(backend, work, &plan, &mut |_, _| {})
    };
    let mut timed = vec![Timed { error: Some(0.0), ..Timed::default() }];
    let (truth, warm) = time(backend, &mut |backend| all(backend))?;
    for candidate in candidates {
        let mut one = Timed {
            parts: candidate.parts.replace(",always", ""),
            error: candidate.plan.expected(),
            ..Timed::default()
        };
        if candidate.plan.evaluations() == candidate.plan.savings.before {
            one.note = "leaves out nothing".to_string();
        } else if !one.is_within(permitted) {
            one.note = "may err by more than permitted".to_string();
        } else {
            let (rendered, took) = time(backend, &mut |backend| by(candidate, backend))?;
            one.seen = whole.apart(work, &rendered, &truth);
            if !one.is_within(permitted) {
                one.note = "errs by more than permitted".to_string();
            } else if took > SLOWER * warm {
                one.seconds.push(took * scale);
                one.note = "measured once".to_string();
            }
        }
        timed.push(one);
    }
    // Nothing to compare with, if nothing else can be picked.
    let rounds = if timed[1..].iter().all(|one| !one.note.is_empty()) { 0 } else { ROUNDS };
    for _ in 0..rounds {
        let (_, took) = time(backend, &mut |backend| all(backend))?;
        timed[0].seconds.push(took * scale);
        for (timed, candidate) in timed[1..].iter_mut().zip(candidates) {
            if !timed.note.is_empty() {
                continue;
            }
            let (_, took) = time(backend, &mut |backend| by(candidate, backend))?;
            timed.seconds.push(took * scale);
        }
    }
    let (fragments, of) = (fragments as u64, of as u64);
    let mut choice = Choice { permitted, fragments, of, timed, picked: 0 };
    choice.pick();
    Ok(choice)
}

impl Renderer {
    /// Renders all fragments with all lights.
    fn render_all(
        &self,
        backend: &mut dyn Backend,
        work: &Work<'_>,
    ) -> Result<Rendered, RenderError> {
        let [directional, point, spot] = all_numbers(work);
        let lights =
            FragmentLights { ambient: true, directional: &directional, point: &point, spot: &spot };
        let fragments: Vec<u32> = (0..work.frame.fragments.len() as u32).collect();
        let draw = Draw { fragments: &fragments, lights, tiles: None };
        self.render(backend, work, &[draw], &mut |_, _| {})
    }

    /// Returns the largest difference of two pictures in steps. Where a slot without a light makes
    /// the second one no number, a plan mends that.
    fn apart(&self, work: &Work<'_>, a: &Rendered, b: &Rendered) -> f64 {
        let [directional, point, spot] = all_numbers(work);
        let lights =
            FragmentLights { ambient: true, directional: &directional, point: &point, spot: &spot };
        let mends = self.unused_slots(&lights) > 0;
        let color = |rendered: &Rendered, fragment: &Fragment| {
            let [r, g, b, _] = rendered.picture.pixels[fragment.pixel as usize];
            Vec3::new(r, g, b)
        };
        let pairs = work.frame.fragments.iter().map(|f| (color(a, f), color(b, f)));
        let (a, b): (Vec<Vec3>, Vec<Vec3>) =
            pairs.filter(|(_, all)| all.is_finite() || !mends).unzip();
        culling::compare(&a, &b).steps
    }
}

fn all_numbers(work: &Work<'_>) -> [Vec<u32>; 3] {
    let lights = &work.upload.lights;
    let counts = [lights.directional.len(), lights.point.len(), lights.spot.len()];
    Kind::ALL.map(|kind| (0..counts[kind as usize] as u32).collect())
}
