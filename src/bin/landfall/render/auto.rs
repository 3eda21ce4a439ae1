//! `--skip auto`: measures ways to light a scene on the backend of the render, and picks one.

use landfall_exec::backend::Backend;
use landfall_layout::Error;
use landfall_light::accuracy::bench::clock::{Start, Stopwatch};
use landfall_light::culling::{self, Division, LightSet, Options, Plan, Savings};
use landfall_light::render::choose::{self, Candidate};
use landfall_light::render::{RenderError, Rendered, Work};
use landfall_light::shading_f32::Model;

use super::applied::{Listed, Planned, applied};
use super::request::RenderRequest;
use super::{PreparedScene, Stop};
use crate::args::RenderArgs;
use crate::backends;

/// Picks the plan. Tiles are in lists where the shader can read them; to write that shader,
/// everything is.
pub fn picked(
    args: &RenderArgs,
    request: &RenderRequest,
    made: &PreparedScene<'_>,
    model: &Model,
    given: &Options,
    permitted: f64,
    listed: Option<Listed>,
) -> Result<Planned, Stop> {
    let whole = made.renderer.as_ref().ok_or_else(|| request.no_shader())?;
    let sample = choose::sample(&made.frame);
    let work = made.work();
    let few = Work { frame: &sample, ..work };
    let emits = args.emit_shader.is_some();
    let lists = |options: &Options| {
        listed.as_ref().filter(|_| emits || matches!(options.division, Division::Tiles { .. }))
    };
    let mut candidates = Vec::new();
    for parts in choose::candidates(permitted) {
        let options = culling::parse(&parts).map_err(|why| Error::new("--skip", why))?;
        let options = Options { slots: given.slots, costs: given.costs, ..options };
        let plan = whole.plan(&few, model, &options);
        if emits && plan.tile_lists().is_err() {
            continue;
        }
        let (plan, renderer) = applied(request, whole, &few, model, &options, lists(&options))?;
        candidates.push(Candidate { parts, options, renderer, plan });
    }
    let name = args.backend;
    let mut backend = backends::open_one(name, args.adapter.as_deref()).map_err(|failure| {
        Error::new(name.name(), format!("cannot measure: {}", failure.message))
            .with_help("`landfall devices` lists the backends; cpu needs no driver")
    })?;
    let of = made.frame.fragments.len() as f64;
    let limits = [permitted, of];
    let choice =
        choose::choose(whole, &candidates, backend.as_mut(), &few, model, limits, &mut timed)?;
    let picked = choice.picked.checked_sub(1).map(|at| &candidates[at]);
    let (mut plan, renderer) = match picked {
        Some(picked) => {
            applied(request, whole, &work, model, &picked.options, lists(&picked.options))?
        }
        None => {
            let [directional, point, spot] = made.numbers();
            let all = LightSet { ambient: true, directional, point, spot };
            let mut plan = Plan::all_lights(made.frame.fragments.len(), all);
            let evaluations = plan.evaluations();
            let fragments = made.frame.fragments.len() as u64;
            let (before, after) = (evaluations, evaluations);
            plan.savings = Savings { fragments, before, after, ..Savings::default() };
            match &listed {
                Some(listed) if emits => {
                    plan.tiles = plan.tile_lists().ok();
                    (plan, listed.renderer.clone())
                }
                _ => (plan, whole.clone()),
            }
        }
    };
    let idle = picked.is_none() && !emits;
    plan.savings.choice = Some(choice);
    let emitted = listed.filter(|_| emits).map(|listed| listed.text);
    Ok(Planned { plan, renderer, demanded: false, idle, emitted })
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
