//! `--skip`: the plan of a render, and the shader compiled for no more than its lights.

use std::fmt::Write as _;

use landfall_layout::Error;
use landfall_light::compiled::Model;
use landfall_light::reference;
use landfall_light::render::{Renderer, Work};
use landfall_light::skip;
use landfall_light::skip::{Costs, Measured, Place, Plan};

use super::asked::Asked;
use super::{Made, Stop};
use crate::args::{ReaderName, RenderArgs};

/// A plan, and the shader made for it.
pub struct Planned {
    pub plan: Plan,
    pub renderer: Renderer,
}

/// What `--skip help` prints.
pub fn help() -> String {
    let width = skip::PARTS.iter().map(|(part, _)| part.len()).max().unwrap_or(0);
    let mut text = String::from("parts of --skip, with commas between them:\n");
    for (part, does) in skip::PARTS {
        let _ = writeln!(text, "  {part:width$}  {does}");
    }
    text
}

/// What is said where a picture is farther from that of all lights than its plan says.
pub fn broken(checked: &Measured, model: Option<&(reference::Model, bool)>) -> String {
    let computed = match model {
        Some((_, true)) => "the model that was said",
        Some((_, false)) | None => "the model guessed from its members",
    };
    format!(
        "what was skipped changes the picture by {:.2} of 255 steps, more than the plan says: the \
         shader does not compute {computed}; say the right one with `--model`",
        checked.steps
    )
}

pub fn plan(args: &RenderArgs, asked: &Asked, made: &Made<'_>) -> Result<Option<Planned>, Stop> {
    let (Some(parts), Some(whole)) = (&args.skip, &made.renderer) else { return Ok(None) };
    let mut options = skip::parse(parts).map_err(|why| {
        Error::new("--skip", why).with_help("`landfall render SCENE.json --skip help` lists them")
    })?;
    options.costs = match args.reader {
        ReaderName::Cpu => Costs::EVALUATOR,
        ReaderName::Gl | ReaderName::Gpu => Costs::DRIVER,
    };
    if whole.asks_for_tiles() {
        options.costs = options.costs.by_lists();
    }
    let (model, _) = made.model.as_ref().ok_or_else(|| {
        Error::new("--skip", "needs a lighting model to bound lights by")
            .with_help("say `--model multi`, `array` or `view_space`")
    })?;
    let model = Model::of(model)
        .map_err(|why| Error::new("--skip", format!("cannot plan for this model: {why}")))?;
    let Made { upload, frame, scene, limit, .. } = made;
    let work = Work { upload, frame, background: scene.background, limit: *limit };
    let mut plan = whole.plan(&work, &model, &options);
    let mut renderer = whole.clone();
    if options.used {
        let settings = asked.settings(&plan.compiled);
        if !settings.is_empty() {
            let said: Vec<String> =
                settings.iter().map(|s| format!("{}={}", s.name, s.text())).collect();
            let smaller = asked.renderer_with(|read| {
                for setting in &settings {
                    let given = (setting.name.clone(), setting.text());
                    match setting.place {
                        Place::Define => read.defines.push(given),
                        Place::Override => read.overrides.push(given),
                    }
                }
            })?;
            if let Some(smaller) = smaller {
                renderer = smaller;
                plan.savings.compiled = said;
            }
        }
    }
    Ok(Some(Planned { plan, renderer }))
}
