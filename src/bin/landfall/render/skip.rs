//! `--skip`: the plan of a render, the shader that executes it, and whether it is applied.

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Duration;

use landfall_exec::backend::Backend;
use landfall_layout::Error;
use landfall_layout::file::FileWriter;
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_layout::source::kind_of_path;
use landfall_light::culling::{
    self, Claim, ConstantKind, Evaluations, LightSet, Measured, OptionEffect, Options, Plan,
    Savings, ShownLight, ShownLights, Times, Whole,
};
use landfall_light::listed;
use landfall_light::render::choose::Trial;
use landfall_light::render::{RenderError, Renderer, Work};
use landfall_light::scene::PointLight;
use landfall_light::shading_f32::Model;

use super::clock::timed;
use super::lighting::{BackendPicture, Lighting};
use super::request::RenderRequest;
use super::{PreparedScene, RenderStop};
use crate::args::RenderArgs;

/// The fewest lights that end, or are black, of which leaving some out pays for a plan.
const FEWEST: usize = 8;

/// Analysing a shader takes a few milliseconds: the least time without skipping that is worth them.
const SHORTEST: Duration = Duration::from_millis(200);

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
    // A known ending of another language is refused: the text would not be what the name says.
    match (language, named) {
        (Some(language), Some(named)) if language != named => {
            Err(Error::new(shown, "is named as a shader in another language than the scene's"))
        }
        _ => writer.allows(path),
    }
}

/// A plan, and the shader compiled for it.
pub struct Planned {
    plan: Plan,
    /// The shader that executes it.
    renderer: Renderer,
    /// Why it is not applied.
    refused: Option<String>,
    /// Whether it needs no measuring: its lights were shown to add zero, or it leaves out none.
    is_shown: bool,
    /// Whether it is to be applied even if it costs more than it saves.
    always: bool,
    /// The text to write, if asked for.
    emitted: Option<Arc<str>>,
    /// The time of the whole picture with all lights, by a sample.
    whole: Option<Whole>,
}

/// A picture made by a plan, or with all lights if that plan is not applied.
pub struct Skipped {
    pub lit: BackendPicture,
    pub plan: Plan,
    /// The text of the shader to write.
    pub emitted: Option<Arc<str>>,
    /// Whether a plan that was demanded changes the picture by more than it claims.
    pub unmet: bool,
    /// What is to be warned of.
    pub note: Option<String>,
}

struct Planning<'a> {
    request: &'a RenderRequest,
    made: &'a PreparedScene<'a>,
    whole: &'a Renderer,
    work: &'a Work<'a>,
    model: Model,
    options: Options,
    /// Whether the parts were named.
    by_name: bool,
    emits: bool,
}

/// Makes the plan asked for; `backend` is the one that lights the picture.
pub fn plan(
    args: &RenderArgs,
    request: &RenderRequest,
    made: &PreparedScene<'_>,
    backend: &mut dyn Backend,
) -> Result<Option<Planned>, RenderStop> {
    let (Some(parts), Some(whole)) = (&args.skip, &made.renderer) else { return Ok(None) };
    let by_name = !parts.is_empty();
    let options = if by_name { culling::parse(parts) } else { Ok(Options::exact()) };
    let options = options.map_err(|why| {
        Error::new("--skip", why).with_help("`landfall render --skip help` lists them")
    })?;
    let emits = args.emit_shader.is_some();
    let work = &made.work();
    let model = made.model.as_ref().map(|(model, _)| Model::new(model));
    let needs_model = by_name && options.leaves_out() || options.gates.is_some();
    // A model is needed only for bounds: what is shown of the code needs none.
    let model = match model {
        Some(Ok(model)) => model,
        _ if !needs_model => Model::default(),
        Some(Err(why)) => {
            return Err(Error::new("--skip", format!("cannot plan for this model: {why}")).into());
        }
        None => {
            let error = Error::new("--skip", "needs a lighting model to bound the lights");
            return Err(error.with_help("add `--model multi`, `array` or `view_space`").into());
        }
    };
    let planning = Planning { request, made, whole, work, model, options, by_name, emits };
    let planned = if by_name { planning.by_name(backend) } else { planning.exact(backend) };
    planned.map(Some)
}

impl<'a> Planning<'a> {
    /// Plans what is shown to be exact, if it pays.
    fn exact(mut self, backend: &mut dyn Backend) -> Result<Planned, RenderStop> {
        let lights = &self.work.upload.lights;
        let points = lights.point.iter().chain(lights.spot.iter().map(|spot| &spot.point));
        let ends = points.filter(|point| point.attenuation.range.is_some()).count();
        // The cheap checks come first; each next one costs more.
        if !self.emits && ends < FEWEST {
            return Ok(self.refused(format!("fewer than {FEWEST} lights have a range"), None));
        }
        let trial = self.trial();
        let whole = trial.whole(backend, &mut timed)?;
        if !self.emits && whole.time < SHORTEST {
            let why = "the picture takes less time than a plan is likely to save";
            return Ok(self.refused(why.to_string(), Some(whole)));
        }
        // Nothing is analysed that would leave out too little if all of it were shown.
        self.options.shown = Some(ShownLights::of_ranges(lights));
        if !self.emits && !trial.plan(&self.model, &self.options).leaves_out_enough() {
            let why = "it leaves out too little on a sample";
            return Ok(self.refused(why.to_string(), Some(whole)));
        }
        let shown = self.shown();
        let count = shown.as_ref().map_or(0, |shown| shown.count());
        if !self.emits && count < FEWEST {
            let why = format!(
                "the shader's code was shown to give exactly zero beyond their range for {count} \
                 of {ends} lights that have one"
            );
            return Ok(self.refused(why, Some(whole)));
        }
        self.options.shown = shown;
        self.planned(backend, &trial, Some(whole))
    }

    /// Plans the parts that were named, by what is shown of the shader if that leaves out what the
    /// model would by range, and otherwise by the bounds of the model.
    fn by_name(mut self, backend: &mut dyn Backend) -> Result<Planned, RenderStop> {
        if self.options.leaves_out() && self.options.budget.is_none() {
            let shown = self.shown();
            self.options.shown = shown.filter(|shown| self.is_shown_of_all(shown));
        }
        let trial = self.trial();
        // Only tiles cost tests; a plan to be applied whatever it costs is not timed either.
        let is_timed = self.options.tiles.is_some() && !self.options.always && !self.emits;
        let whole = if is_timed { Some(trial.whole(backend, &mut timed)?) } else { None };
        self.planned(backend, &trial, whole)
    }

    /// Returns the sample on which a plan is timed.
    fn trial(&self) -> Trial<'a> {
        Trial::new(self.whole, self.work, self.options.tiles.unwrap_or(1))
    }
}

impl Planning<'_> {
    /// Returns where the shader's code was shown to give zero.
    fn shown(&self) -> Option<ShownLights> {
        let shader = self.request.shader.as_ref()?;
        // A shader that reads lists gets all lights where a plan has none.
        if self.whole.reads_tile_lists() && self.options.tiles.is_none() {
            return None;
        }
        Some(self.whole.shown_lights(shader, &self.request.options, self.work))
    }

    /// Whether no light ends that was not shown to give zero beyond its range, and some does.
    fn is_shown_of_all(&self, shown: &ShownLights) -> bool {
        let lights = &self.work.upload.lights;
        let point = lights.point.iter().zip(&shown.0[1]);
        let spot = lights.spot.iter().map(|spot| &spot.point).zip(&shown.0[2]);
        let mut all = point.chain(spot);
        let ends = |(point, shown): (&PointLight, &ShownLight)| {
            point.attenuation.range.is_none() || *shown != ShownLight::Nowhere
        };
        shown.count() > 0 && all.all(ends)
    }

    /// Makes the plan, unless it costs more than it saves on a sample.
    fn planned(
        &self,
        backend: &mut dyn Backend,
        trial: &Trial<'_>,
        whole: Option<Whole>,
    ) -> Result<Planned, RenderStop> {
        let always = self.options.always || self.emits;
        // The plan is timed on a sample first, so that a useless one costs little.
        if let (Some(_), false) = (whole, always) {
            let by = (&self.model, &self.options);
            let (plan, lighting) = trial.planned(backend, by, &mut timed)?;
            let times = Times { lighting, whole, ..Times::default() };
            if let Some(why) = plan.drawback(None, &times, always) {
                return Ok(self.refused(format!("{why} on a sample"), whole));
            }
        }
        let plan = self.whole.plan(self.work, &self.model, &self.options);
        let is_idle = plan.evaluations() == plan.savings.before;
        let (plan, renderer, emitted) = self.executed(plan)?;
        let is_own = plan.savings.compiled.is_empty() && emitted.is_none();
        if is_idle && is_own && self.options.gates.is_none() && !always {
            return Ok(self.refused("it leaves out nothing".to_string(), whole));
        }
        let is_shown = is_own && (is_idle || self.options.shown.is_some());
        Ok(Planned { plan, renderer, refused: None, is_shown, always, emitted, whole })
    }

    /// Returns a plan with the shader that executes it: the one that reads lists if it is to be
    /// written, otherwise the scene's, compiled for the lights that are left if `used` was named.
    fn executed(&self, mut plan: Plan) -> Result<(Plan, Renderer, Option<Arc<str>>), RenderStop> {
        if self.emits {
            let (text, renderer) = self.listed()?;
            let lists = plan.tile_lists(self.work.frame.height);
            plan.tiles = Some(lists.map_err(|why| Error::new("--emit-shader", why))?);
            return Ok((plan, renderer, Some(text)));
        }
        let settings = match self.options.used && self.by_name {
            // Set only where `used` was named: nothing is shown of a shader compiled anew.
            true => self.request.settings(&plan.compiled),
            false => Vec::new(),
        };
        if settings.is_empty() {
            return Ok((plan, self.whole.clone(), None));
        }
        let smaller = self.request.renderer_with(|read| {
            for setting in &settings {
                let given = (setting.name.clone(), setting.text());
                match setting.place {
                    ConstantKind::Define => read.defines.push(given),
                    ConstantKind::Override => read.overrides.push(given),
                }
            }
        })?;
        let constants = settings.iter().map(|s| format!("{}={}", s.name, s.text()));
        plan.savings.compiled = constants.collect();
        Ok((plan, smaller.ok_or_else(|| self.request.no_shader())?, None))
    }

    fn listed(&self) -> Result<(Arc<str>, Renderer), RenderStop> {
        let Planning { request, whole, .. } = self;
        let shader = request.shader.as_ref().ok_or_else(|| request.no_shader())?;
        let wrong =
            |why: String| Error::new("--emit-shader", format!("cannot rewrite the shader: {why}"));
        let made = listed::listed(shader, &request.options.read, &whole.shader, &whole.map);
        let source = made.map_err(wrong)?.source;
        let text = Arc::clone(&source.text);
        let renderer = request.with_shader(source).renderer();
        let refused = |error: RenderError| wrong(format!("the result is not valid: {error}"));
        Ok((text, renderer.map_err(refused)?.ok_or_else(|| request.no_shader())?))
    }

    /// Returns the plan to skip nothing, since the parts are not worth planning.
    fn refused(&self, why: String, whole: Option<Whole>) -> Planned {
        let fragments = self.work.frame.fragments.len() as u64;
        let lights = LightSet::all(&self.made.upload.lights);
        let before = fragments * self.whole.evaluated(&lights);
        let option = match self.options.tiles {
            Some(size) => format!("tiles={size}"),
            None => "used".to_string(),
        };
        let step = OptionEffect {
            option,
            did: String::new(),
            evaluations: Some(Evaluations { before, after: before }),
            error: Claim::Unused,
            tests: 0,
        };
        // What is told of a refused plan: the work of all lights, and no saving.
        let savings = Savings { fragments, before, steps: vec![step], ..Savings::default() };
        let plan = Plan { savings, ..Plan::default() };
        let renderer = self.whole.clone();
        let refused = Some(why);
        Planned { plan, renderer, refused, is_shown: true, always: false, emitted: None, whole }
    }
}

/// Lights the picture by a plan whose making took so long, or with all lights where it is not
/// applied; measures it at every fragment if it was not shown to be exact.
pub fn light(
    planned: Planned,
    planning: Duration,
    made: &PreparedScene<'_>,
    lighting: &mut Lighting<'_>,
) -> Result<Skipped, RenderStop> {
    let measured = |lit: &BackendPicture| {
        let fragments = made.frame.fragments.len() as u64;
        Some(Whole { time: lit.took, fragments, measured: true })
    };
    let all = LightSet::all(&made.upload.lights);
    let mut times = Times { planning, whole: planned.whole, ..Times::default() };
    let mut lit = match planned.refused {
        None => lighting.by_plan(made, &planned.renderer, &planned.plan)?,
        // A refused plan is lit with all lights, which is the picture without `--skip`.
        Some(_) => lighting.light_all(made)?,
    };
    times.lighting = lit.took;
    let Planned { mut plan, mut refused, mut emitted, is_shown, always, .. } = planned;
    let (mut unmet, mut note) = (false, None);
    if refused.is_some() {
        times.whole = measured(&lit);
    } else if !is_shown {
        // Not shown to be exact: the picture with all lights is made too, and compared.
        let whole = lighting.light_all(made)?;
        let checked =
            made.whole().apart(&made.work(), &lit.rendered.picture, &whole.rendered.picture);
        times.whole = measured(&whole);
        refused = plan.drawback(Some(&checked), &times, always);
        if refused.is_some() {
            if !plan.permits(&checked) {
                // A plan that the user insists on is a failure if it breaks its claim; otherwise
                // it is only noted.
                (unmet, emitted) = (always, None);
                note = Some(contradicted(&checked, made));
            }
            times = Times { planning: planning + lit.took, lighting: whole.took, ..times };
            plan.savings.checked = Some(checked);
            lit = whole;
        } else {
            // The second picture was made only to check the first.
            times.checking = whole.took;
            plan.confirm(checked);
        }
    }
    if let Some(why) = refused {
        plan = plan.refused(&why, all);
    }
    plan.savings.times = Some(times);
    Ok(Skipped { lit, plan, emitted, unmet, note })
}

/// The note that the error of a picture exceeds the bound of its plan.
fn contradicted(checked: &Measured, made: &PreparedScene<'_>) -> String {
    let computed = match made.model {
        Some((_, true)) => "the given model",
        Some((_, false)) | None => "the model inferred from its members",
    };
    format!(
        "skipping changes the picture by {:.2} steps of 1/255, more than the plan's bound: the \
         shader does not compute {computed}, and nothing is skipped; name its model with `--model`",
        checked.steps
    )
}
