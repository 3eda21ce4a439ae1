//! `--skip`: the plan of a render, and the shader compiled for the lights it keeps.

use std::fmt::Write as _;

use landfall_layout::Error;
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_light::culling;
use landfall_light::culling::{ConstantKind, Measured, Plan};
use landfall_light::reference;
use landfall_light::render::{Renderer, Work};
use landfall_light::shading_f32::Model;

use super::request::RenderRequest;
use super::{PreparedScene, Stop};
use crate::args::RenderArgs;

/// A plan, and the shader compiled for it.
pub struct Planned {
    pub plan: Plan,
    pub renderer: Renderer,
    /// Whether it is to be applied in any case.
    pub demanded: bool,
}

/// The text of `--skip help`.
pub fn help() -> String {
    let width = culling::PARTS.iter().map(|(part, _)| part.len()).max().unwrap_or(0);
    let mut text = String::from("parts of --skip, separated by commas:\n");
    for (part, does) in culling::PARTS {
        for (nth, line) in wrapped(does, WIDTH - width - 4).iter().enumerate() {
            let part = if nth == 0 { part } else { "" };
            let _ = writeln!(text, "  {part:width$}  {line}");
        }
    }
    text
}

/// The note that the error of a picture exceeds the bound of its plan.
pub fn broken(
    checked: &Measured,
    model: Option<&(reference::Model, bool)>,
    applied: bool,
) -> String {
    let computed = match model {
        Some((_, true)) => "the given model",
        Some((_, false)) | None => "the model inferred from its members",
    };
    let instead = if applied { "" } else { ", and nothing is skipped" };
    format!(
        "skipping changes the picture by {:.2} steps of 1/255, more than the plan's bound: the \
         shader does not compute {computed}{instead}; name its model with `--model`",
        checked.steps
    )
}

pub fn plan(
    args: &RenderArgs,
    request: &RenderRequest,
    made: &PreparedScene<'_>,
) -> Result<Option<Planned>, Stop> {
    let (Some(parts), Some(whole)) = (&args.skip, &made.renderer) else { return Ok(None) };
    let mut options = culling::parse(parts).map_err(|why| {
        Error::new("--skip", why).with_help("`landfall render SCENE.json --skip help` lists them")
    })?;
    options.costs = whole.costs(args.backend.kind());
    let (model, _) = made.model.as_ref().ok_or_else(|| {
        Error::new("--skip", "needs a lighting model to bound the lights")
            .with_help("add `--model multi`, `array` or `view_space`")
    })?;
    let model = Model::of(model)
        .map_err(|why| Error::new("--skip", format!("cannot plan for this model: {why}")))?;
    let PreparedScene { upload, frame, scene, limit, .. } = made;
    let work = Work { upload, frame, background: scene.background, limit: *limit };
    let mut plan = whole.plan(&work, &model, &options);
    let mut renderer = whole.clone();
    if options.used {
        let settings = request.settings(&plan.compiled);
        if !settings.is_empty() {
            let constants: Vec<String> =
                settings.iter().map(|s| format!("{}={}", s.name, s.text())).collect();
            let smaller = request.renderer_with(|read| {
                for setting in &settings {
                    let given = (setting.name.clone(), setting.text());
                    match setting.place {
                        ConstantKind::Define => read.defines.push(given),
                        ConstantKind::Override => read.overrides.push(given),
                    }
                }
            })?;
            if let Some(smaller) = smaller {
                renderer = smaller;
                plan.savings.compiled = constants;
            }
        }
    }
    let demanded = options.choose == culling::Choose::Always;
    Ok(Some(Planned { plan, renderer, demanded }))
}
