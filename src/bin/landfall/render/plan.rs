//! `--skip`: the plan of a render, and the shader compiled for the lights it keeps.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use landfall_layout::Error;
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_layout::source::kind_of_path;
use landfall_light::culling;
use landfall_light::culling::{ConstantKind, Measured, Plan};
use landfall_light::listed;
use landfall_light::reference;
use landfall_light::render::{RenderError, Renderer, Work};
use landfall_light::shading_f32::Model;

use super::request::RenderRequest;
use super::{PreparedScene, Stop, auto};
use crate::args::RenderArgs;

/// A plan, and the shader compiled for it.
pub struct Planned {
    pub plan: Plan,
    pub renderer: Renderer,
    /// Whether it is to be applied in any case.
    pub demanded: bool,
    /// Whether nothing is to be skipped, since nothing pays.
    pub idle: bool,
    /// The text to write, if asked for.
    pub emitted: Option<Arc<str>>,
}

/// The shader that reads lists.
pub struct Listed {
    pub text: Arc<str>,
    pub renderer: Renderer,
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

/// Refuses a file for the shader that is the picture's, or of another language.
pub fn refuse_path(path: &Path, args: &RenderArgs, request: &RenderRequest) -> Result<(), Error> {
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
        _ => Ok(()),
    }
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
    let (model, _) = made.model.as_ref().ok_or_else(|| {
        Error::new("--skip", "needs a lighting model to bound the lights")
            .with_help("add `--model multi`, `array` or `view_space`")
    })?;
    let model = Model::of(model)
        .map_err(|why| Error::new("--skip", format!("cannot plan for this model: {why}")))?;
    let listed = match (args.emit_shader.is_some(), options.auto) {
        (false, None) => None,
        (true, _) => Some(listed(request, whole)?),
        (false, Some(_)) => listed(request, whole).ok(),
    };
    if let Some(permitted) = options.auto {
        let planned = auto::picked(args, request, made, &model, &options, permitted, listed)?;
        return Ok(Some(planned));
    }
    let drawn = listed.as_ref().map_or(whole, |listed| &listed.renderer);
    options.costs = drawn.costs(args.backend.kind());
    let (plan, renderer) =
        applied(request, whole, &made.work(), &model, &options, listed.as_ref())?;
    let demanded = options.choose == culling::Choose::Always;
    let emitted = listed.map(|listed| listed.text);
    Ok(Some(Planned { plan, renderer, demanded, idle: false, emitted }))
}

/// Rewrites the shader to read lists.
fn listed(request: &RenderRequest, whole: &Renderer) -> Result<Listed, Stop> {
    let shader = request.shader.as_ref().ok_or_else(|| request.no_shader())?;
    let wrong =
        |why: String| Error::new("--emit-shader", format!("cannot rewrite the shader: {why}"));
    let made = listed::listed(shader, &request.options.read, &whole.shader, &whole.map);
    let source = made.map_err(wrong)?.source;
    let text = Arc::clone(&source.text);
    let renderer = request.with_shader(source).renderer();
    let refused = |error: RenderError| wrong(format!("the result is not valid: {error}"));
    let renderer = renderer.map_err(refused)?.ok_or_else(|| request.no_shader())?;
    Ok(Listed { text, renderer })
}

/// Makes a plan, and the shader that executes it: the one that reads lists if given, otherwise the
/// scene's, compiled for the lights that are left.
pub fn applied(
    request: &RenderRequest,
    whole: &Renderer,
    work: &Work<'_>,
    model: &Model,
    options: &culling::Options,
    listed: Option<&Listed>,
) -> Result<(Plan, Renderer), Stop> {
    let mut plan = whole.plan(work, model, options);
    if let Some(listed) = listed {
        let lists = plan.tile_lists();
        plan.tiles = Some(lists.map_err(|why| Error::new("--emit-shader", why))?);
        return Ok((plan, listed.renderer.clone()));
    }
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
    Ok((plan, renderer))
}
