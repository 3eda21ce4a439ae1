//! `--skip auto`: measures ways to light a scene on the backend of the render, and picks one.

use std::cell::OnceCell;

use landfall_exec::backend::Backend;
use landfall_layout::Error;
use landfall_light::accuracy::bench::clock::{Start, Stopwatch};
use landfall_light::culling::{self, Division, LightSet, Options, Plan, Savings};
use landfall_light::render::choose::{self, Candidate, Limits, Trials};
use landfall_light::render::{RenderError, Rendered, Renderer, Work};
use landfall_light::shading_f32::Model;

use super::applied::{self, Listed, Planned, applied, executed};
use super::request::RenderRequest;
use super::{PreparedScene, Stop};
use crate::args::RenderArgs;
use crate::backends;

/// The backend that measured, which has compiled what it renders with.
pub type Opened = Option<Box<dyn Backend>>;

/// Picks the plan. Tiles are in lists where a driver's shader can read them; to write that shader,
/// everything is.
pub fn picked(
    args: &RenderArgs,
    request: &RenderRequest,
    made: &PreparedScene<'_>,
    model: &Model,
    given: &Options,
    permitted: f64,
    given_lists: Option<Listed>,
) -> Result<(Planned, Opened), Stop> {
    let whole = made.renderer.as_ref().ok_or_else(|| request.no_shader())?;
    let sample = choose::sample(&made.frame);
    let work = made.work();
    let few = Work { frame: &sample, ..work };
    let emits = args.emit_shader.is_some();
    // The interpreter renders the frame on all cores, and a sample on fewer.
    let cores = match args.backend.kind().is_driver() {
        true => 1,
        false => std::thread::available_parallelism().map_or(1, usize::from),
    };
    let limits = Limits {
        permitted,
        fragments: made.frame.fragments.len(),
        spent: choose::SPENT / cores as f64,
        backend: args.backend.kind(),
    };
    // The interpreter draws a tile faster than it follows lists that differ from fragment to fragment.
    let lists = |options: &Options| {
        let has_tiles = matches!(options.division, Division::Tiles { .. });
        emits || has_tiles && args.backend.kind().is_driver()
    };
    let rewritten = OnceCell::new();
    let listed = |options: &Options| match &given_lists {
        Some(listed) => Some(listed),
        None if lists(options) => {
            rewritten.get_or_init(|| applied::listed(request, whole).ok()).as_ref()
        }
        None => None,
    };
    let mut candidates = Vec::new();
    for parts in choose::candidates(permitted) {
        let options = culling::parse(&parts).map_err(|why| Error::new("--skip", why))?;
        let options = Options { slots: given.slots, costs: given.costs, ..options };
        let plan = whole.plan(&few, model, &options);
        if emits && plan.tile_lists().is_err() {
            continue;
        }
        candidates.push(Candidate { parts, lists: lists(&options), options, plan });
    }
    let trials = Trials { whole, work: &few, model, limits };
    let settled = trials.settled(&candidates);
    let (choice, backend) = match settled {
        Some(choice) => (choice, None),
        None => {
            let name = args.backend;
            let opened = backends::open_one(name, args.adapter.as_deref());
            let mut backend = opened.map_err(|failure| {
                Error::new(name.name(), format!("cannot measure: {}", failure.message))
                    .with_help("`landfall devices` lists the backends; cpu needs no driver")
            })?;
            let on = backend.as_mut();
            let mut shader = |candidate: &Candidate| -> Result<Renderer, Stop> {
                let Candidate { options, plan, .. } = candidate;
                let listed = listed(options);
                Ok(executed(request, whole, plan.clone(), options.used, listed)?.1)
            };
            let choice = trials.choose(&candidates, on, &mut shader, &mut timed)?;
            (choice, Some(backend))
        }
    };
    let picked = choice.picked.checked_sub(1).map(|at| &candidates[at]);
    let (mut plan, renderer) = match picked {
        Some(picked) => {
            applied(request, whole, &work, model, &picked.options, listed(&picked.options))?
        }
        None => {
            let [directional, point, spot] = made.numbers();
            let all = LightSet { ambient: true, directional, point, spot };
            let mut plan = Plan::all_lights(made.frame.fragments.len(), all);
            let evaluations = plan.evaluations();
            let fragments = made.frame.fragments.len() as u64;
            let (before, after) = (evaluations, evaluations);
            plan.savings = Savings { fragments, before, after, ..Savings::default() };
            match &given_lists {
                Some(listed) => {
                    plan.tiles = plan.tile_lists().ok();
                    (plan, listed.renderer.clone())
                }
                _ => (plan, whole.clone()),
            }
        }
    };
    let idle = picked.is_none() && !emits;
    plan.savings.choice = Some(choice);
    let emitted = given_lists.map(|listed| listed.text);
    Ok((Planned { plan, renderer, demanded: false, idle, emitted }, backend))
}

/// Runs work on a backend, and returns its seconds: those of the processor, planning included, and of
/// the jobs on a driver.
fn timed(
    backend: &mut dyn Backend,
    work: &mut dyn FnMut(&mut dyn Backend) -> Result<Rendered, RenderError>,
) -> Result<(Rendered, f64), RenderError> {
    let mut watch = Stopwatch::new(backend);
    let start = Start::now();
    let rendered = work(&mut watch)?;
    let own = start.elapsed().time;
    let jobs = watch.elapsed().map_or(0.0, |jobs| jobs.time.as_secs_f64());
    Ok((rendered, own.as_secs_f64() + jobs))
}
