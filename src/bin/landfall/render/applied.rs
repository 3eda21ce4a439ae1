//! A plan with the shader that executes it: the scene's, compiled for fewer lights or rewritten to
//! read lists.

use std::sync::Arc;

use landfall_layout::Error;
use landfall_light::culling::{self, ConstantKind, Plan};
use landfall_light::listed;
use landfall_light::render::{RenderError, Renderer, Work};
use landfall_light::shading_f32::Model;

use super::Stop;
use super::request::RenderRequest;

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

/// Rewrites the shader to read lists.
pub fn listed(request: &RenderRequest, whole: &Renderer) -> Result<Listed, Stop> {
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

/// Makes a plan, and the shader that executes it.
pub fn applied(
    request: &RenderRequest,
    whole: &Renderer,
    work: &Work<'_>,
    model: &Model,
    options: &culling::Options,
    listed: Option<&Listed>,
) -> Result<(Plan, Renderer), Stop> {
    executed(request, whole, whole.plan(work, model, options), options.used, listed)
}

/// Returns a plan with the shader that executes it: the one that reads lists if given, otherwise the
/// scene's, compiled for the lights that are left if only the used ones are lit.
pub fn executed(
    request: &RenderRequest,
    whole: &Renderer,
    mut plan: Plan,
    used: bool,
    listed: Option<&Listed>,
) -> Result<(Plan, Renderer), Stop> {
    if let Some(listed) = listed {
        let lists = plan.tile_lists();
        plan.tiles = Some(lists.map_err(|why| Error::new("--emit-shader", why))?);
        return Ok((plan, listed.renderer.clone()));
    }
    let mut renderer = whole.clone();
    if used {
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
