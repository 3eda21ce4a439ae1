//! Measures ways to light a scene on a sample of its fragments, and picks one.
//!
//! The sample is whole squares of the picture, spread over it, so that tiles of them hold what tiles
//! of the picture do.

use glam::Vec3;

use super::{Draw, RenderError, Rendered, Renderer, Work};
use crate::bind::{FragmentLights, Kind};
use crate::culling::{self, Choice, Costs, Options, Plan, Savings, Timed};
use crate::shading_f32::Model;
use crate::splitmix64::SplitMix64;
use crate::{Fragment, Frame};
use landfall_exec::backend::{Backend, BackendKind};

/// The side of a square of the sample: a multiple of the tiles tried.
const SIDE: u32 = 32;

/// The fewest fragments of a sample, and its part of a larger frame.
const FEWEST: usize = 1024;
const PART: usize = 64;

/// The fragments that a shader is compiled with.
const WARM: usize = 32;

/// The rounds of what may be picked.
const ROUNDS: usize = 3;

/// A way that takes so many times as long as skipping nothing is measured once only.
const SLOWER: f64 = 1.05;

/// The least part of the time without skipping that a way is expected to take.
const LEAST: f64 = 0.3;

/// The part of the time without skipping that trials of other ways may take.
pub const SPENT: f64 = 0.1;

/// A way to light the scene.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The parts of `--skip`.
    pub parts: String,
    /// The same, read.
    pub options: Options,
    /// Whether the shader that executes it reads lists.
    pub lists: bool,
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

/// What bounds a choice.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The error permitted, in steps.
    pub permitted: f64,
    /// The fragments of the whole frame.
    pub fragments: usize,
    /// The part of the time without skipping that trials may take: [`SPENT`].
    pub spent: f64,
    /// The backend.
    pub backend: BackendKind,
}

impl Limits {
    /// Returns why a plan for the sample is not worth a trial.
    pub fn drawback(&self, plan: &Plan) -> Option<&'static str> {
        let Savings { before, fragments, .. } = plan.savings;
        let evaluations = before as f64 * self.fragments as f64 / fragments.max(1) as f64;
        let costs = Costs::for_backend(self.backend, false);
        if plan.evaluations() == before {
            Some("leaves out nothing")
        } else if plan.expected().is_none_or(|error| error > self.permitted) {
            Some("may err by more than permitted")
        } else if costs.evaluation * evaluations * self.spent < costs.trial {
            Some("not measured: a trial would take longer than it may save")
        } else {
            None
        }
    }
}

/// Trials of ways to light a scene.
#[derive(Clone, Copy, Debug)]
pub struct Trials<'t> {
    /// The shader with all lights.
    pub whole: &'t Renderer,
    /// The work of the sample.
    pub work: &'t Work<'t>,
    /// The model that plans are made for.
    pub model: &'t Model,
    /// What bounds the choice.
    pub limits: Limits,
}

impl Trials<'_> {
    /// Returns the choice to skip nothing if no candidate is worth a trial.
    pub fn settled(&self, candidates: &[Candidate]) -> Option<Choice> {
        let choice = self.unmeasured(candidates);
        choice.timed[1..].iter().all(|one| !one.note.is_empty()).then_some(choice)
    }

    fn unmeasured(&self, candidates: &[Candidate]) -> Choice {
        let mut timed = vec![Timed { error: Some(0.0), ..Timed::default() }];
        timed.extend(candidates.iter().map(|candidate| Timed {
            parts: candidate.parts.replace(",always", ""),
            error: candidate.plan.expected(),
            note: self.limits.drawback(&candidate.plan).unwrap_or_default().to_string(),
            ..Timed::default()
        }));
        let Limits { permitted, fragments: of, .. } = self.limits;
        let fragments = self.work.frame.fragments.len() as u64;
        Choice { permitted, fragments, of: of as u64, timed, picked: 0 }
    }

    /// Measures skipping nothing and the candidates, and picks. `shader` gives the shader that
    /// executes a candidate.
    ///
    /// Candidates are measured once, the one of the least expected cost first, until one is slower
    /// than another or no time is left; then the fastest and skipping nothing by turns.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the backend.
    pub fn choose<E: From<RenderError>>(
        &self,
        candidates: &[Candidate],
        backend: &mut dyn Backend,
        shader: &mut dyn FnMut(&Candidate) -> Result<Renderer, E>,
        time: &mut Timer<'_>,
    ) -> Result<Choice, E> {
        let Trials { whole, work, model, limits } = *self;
        let mut choice = self.unmeasured(candidates);
        let scale = limits.fragments as f64 / work.frame.fragments.len().max(1) as f64;
        let warm = Frame {
            fragments: work.frame.fragments.iter().take(WARM).cloned().collect(),
            ..*work.frame
        };
        let warm = Work { frame: &warm, ..*work };
        let (_, compiling) = time(backend, &mut |backend| whole.render_all(backend, &warm))?;
        let (truth, without) = time(backend, &mut |backend| whole.render_all(backend, work))?;
        choice.timed[0].seconds.push(without * scale);
        let mut left = limits.spent * without * scale;
        // By the costs expected of its plan.
        let expected = |at: usize| {
            let Candidate { lists, plan, .. } = &candidates[at - 1];
            let costs = Costs::for_backend(limits.backend, *lists);
            let all = costs.evaluation * plan.savings.before as f64;
            without * (costs.total(plan, 0, 0) / all.max(1.0)).clamp(LEAST, 1.0)
        };
        let mut order: Vec<(usize, f64)> = (1..choice.timed.len())
            .filter(|at| choice.timed[*at].note.is_empty())
            .map(|at| (at, expected(at)))
            .collect();
        order.sort_by(|(_, a), (_, b)| a.total_cmp(b));
        let mut fastest: Option<(usize, f64, Renderer)> = None;
        let mut is_settled = false;
        for (at, expected) in order {
            // To be picked, it is measured once more beside skipping nothing.
            let needed = if fastest.is_none() { without + 2.0 * expected } else { expected };
            let one = &mut choice.timed[at];
            if is_settled || left < needed + compiling {
                let why =
                    if is_settled { "expected to be slower" } else { "no time left for trials" };
                one.note = format!("not measured: {why}");
                continue;
            }
            let candidate = &candidates[at - 1];
            let renderer = shader(candidate)?;
            let by = |backend: &mut dyn Backend, work: &Work<'_>| {
                candidate.render(whole, &renderer, backend, work, model)
            };
            let (_, compiling) = time(backend, &mut |backend| by(backend, &warm))?;
            let (rendered, took) = time(backend, &mut |backend| by(backend, work))?;
            left -= compiling + took;
            one.seen = whole.apart(work, &rendered, &truth);
            if !one.is_within(limits.permitted) {
                one.note = "errs by more than permitted".to_string();
                continue;
            }
            one.seconds.push(took * scale);
            let least = fastest.as_ref().map(|(_, least, _)| *least);
            if took * SLOWER > without || least.is_some_and(|least| took > least * SLOWER) {
                one.note = "measured once".to_string();
                is_settled = least.is_some();
            } else if least.is_none_or(|least| took < least) {
                fastest = Some((at, took, renderer));
            }
        }
        if let Some((fastest, took, renderer)) = fastest {
            let candidate = &candidates[fastest - 1];
            for round in 1..ROUNDS {
                if round > 1 && left < took + without {
                    break;
                }
                let (_, took) = time(backend, &mut |backend| {
                    candidate.render(whole, &renderer, backend, work, model)
                })?;
                let (_, without) = time(backend, &mut |backend| whole.render_all(backend, work))?;
                left -= took + without;
                choice.timed[fastest].seconds.push(took * scale);
                choice.timed[0].seconds.push(without * scale);
            }
            for one in &mut choice.timed[1..] {
                if one.seconds.len() == 1 && one.note.is_empty() {
                    one.note = "measured once".to_string();
                }
            }
        }
        choice.pick();
        Ok(choice)
    }
}

impl Candidate {
    /// Plans and renders as an engine does it for each picture.
    fn render(
        &self,
        whole: &Renderer,
        renderer: &Renderer,
        backend: &mut dyn Backend,
        work: &Work<'_>,
        model: &Model,
    ) -> Result<Rendered, RenderError> {
        let mut plan = whole.plan_only(work, model, &self.options);
        if renderer.reads_tile_lists() {
            plan.tiles = plan.tile_lists().ok();
        }
        renderer.render_plan(backend, work, &plan, &mut |_, _| {})
    }
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
        let fragments = work.frame.numbers();
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
