//! `--skip`: the plan of a render, and the shader compiled for the lights it keeps.

use std::fmt::Write as _;

use landfall_layout::Error;
use landfall_layout::file::FileWriter;
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_layout::source::kind_of_path;
use landfall_light::culling;
use landfall_light::culling::Measured;
use landfall_light::reference;
use landfall_light::shading_f32::Model;

use super::applied::{Planned, applied, listed};
use super::auto::Opened;
use super::request::RenderRequest;
use super::{PreparedScene, Stop, auto};
use crate::args::RenderArgs;

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

/// Refuses a file for the shader that is an input, the picture's, or of another language.
pub fn allows_shader(
    writer: &FileWriter,
    args: &RenderArgs,
    request: &RenderRequest,
) -> Result<(), Error> {
    let Some(path) = args.emit_shader.as_deref() else { return Ok(()) };
    let shown = path.display().to_string();
    if args.out.as_deref() == Some(path) {
        return Err(Error::new(shown, "is the file of the picture too"));
    }
    let language = request.shader.as_ref().map(|shader| shader.language);
    let named = kind_of_path(path).map(|(language, _)| language);
    match (language, named) {
        (Some(language), Some(named)) if language != named => {
            Err(Error::new(shown, "is named as a shader in another language than the scene's"))
        }
        _ => writer.allows(path),
    }
}

/// Makes the plan asked for, and returns the backend that chose it.
pub fn plan(
    args: &RenderArgs,
    request: &RenderRequest,
    made: &PreparedScene<'_>,
) -> Result<(Option<Planned>, Opened), Stop> {
    let (Some(parts), Some(whole)) = (&args.skip, &made.renderer) else {
        return Ok((None, None));
    };
    let mut options = culling::parse(parts).map_err(|why| {
        Error::new("--skip", why).with_help("`landfall render SCENE.json --skip help` lists them")
    })?;
    let (model, _) = made.model.as_ref().ok_or_else(|| {
        Error::new("--skip", "needs a lighting model to bound the lights")
            .with_help("add `--model multi`, `array` or `view_space`")
    })?;
    let model = Model::of(model)
        .map_err(|why| Error::new("--skip", format!("cannot plan for this model: {why}")))?;
    let listed = args.emit_shader.as_ref().map(|_| listed(request, whole)).transpose()?;
    if let Some(permitted) = options.auto {
        let (planned, backend) =
            auto::picked(args, request, made, &model, &options, permitted, listed)?;
        return Ok((Some(planned), backend));
    }
    let drawn = listed.as_ref().map_or(whole, |listed| &listed.renderer);
    options.costs = drawn.costs(args.backend.kind());
    let (plan, renderer) =
        applied(request, whole, &made.work(), &model, &options, listed.as_ref())?;
    let demanded = options.choose == culling::Choose::Always;
    let emitted = listed.map(|listed| listed.text);
    Ok((Some(Planned { plan, renderer, demanded, idle: false, emitted }), None))
}
