//! `landfall render`: renders a scene with a shader, and compares it with the f64 reference.

mod clock;
mod compare;
mod lighting;
pub mod request;
mod skip;

use landfall_layout::diagnostic::Code;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use landfall::report::render as print;
use landfall::report::render::RenderReport;
use landfall_interp::{Cpu, Settings};
use landfall_layout::file::FileWriter;
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Severity};
use landfall_light::bind::OverflowPolicy;
use landfall_light::culling::LightSet;
use landfall_light::picture::{Picture, Transfer, file};
use landfall_light::reference::Model;
use landfall_light::render::truth;
use landfall_light::render::truth::Truth;
use landfall_light::render::{Draw, RenderError, Renderer, Work};
use landfall_light::{Frame, Scene, Upload};

use crate::args::{RenderArgs, RenderFormat};
use crate::output::{CommandFailure, FindingForm, FindingStyle, Outcome, Streams};
use crate::{shader, without_effect, write};
use clock::timed;
use lighting::Lighting;
use request::{RenderArguments, RenderRequest};
use skip::Skipped;

pub fn run(args: &RenderArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let style = streams.style(FindingForm::json_if(args.format == RenderFormat::Json));
    if args.skip.as_deref() == Some("help") {
        streams.product(&skip::help())?;
        return Ok(Outcome::Clean);
    }
    let wanted = RenderArguments::new(args)?;
    let request = request::load(&wanted, streams, &style)?;
    // Recorded before anything fails, so that no option is warned of that the shader has.
    request.files_read().iter().for_each(without_effect::record);
    let record = |source| shader::record(source, &request.options, streams, style);
    let assumed = request.shader.as_ref().and_then(record);
    if args.print_bind {
        return print_bind(args, &request, streams, &style);
    }
    let report = picture(args, &request, streams).map_err(|stop| match stop {
        RenderStop::Error(error) => CommandFailure::Error(error),
        RenderStop::Render(error) => request.failure(&error, &style),
    })?;
    // A picture of the reference runs no shader, and assumes no target.
    let assumed_target = assumed.filter(|_| report.shader.is_some());
    print_report(args, &RenderReport { assumed_target, ..report }, streams)
}

fn print_bind(
    args: &RenderArgs,
    request: &RenderRequest,
    streams: &Streams,
    style: &FindingStyle,
) -> Result<Outcome, CommandFailure> {
    let renderer = request.renderer().map_err(|error| request.failure(&error, style))?;
    let renderer = renderer.ok_or_else(|| request.no_shader())?;
    match args.format {
        RenderFormat::Human => {
            streams.product(&landfall::report::bind::text(&renderer.map, streams.paint))?
        }
        RenderFormat::Json => {
            let map = landfall::report::bind::json(&renderer.map);
            let text = serde_json::to_string_pretty(&map).unwrap_or_default();
            streams.json(&format!("{text}\n"))?;
        }
    }
    Ok(Outcome::Clean)
}

/// The error that prevented the report.
enum RenderStop {
    Render(RenderError),
    Error(Error),
}

impl From<RenderError> for RenderStop {
    fn from(error: RenderError) -> RenderStop {
        RenderStop::Render(error)
    }
}

impl From<Error> for RenderStop {
    fn from(error: Error) -> RenderStop {
        RenderStop::Error(error)
    }
}

struct PreparedScene<'a> {
    scene: &'a Scene,
    /// The values and lights to upload.
    upload: Upload,
    frame: Frame,
    renderer: Option<Renderer>,
    model: Option<(Model, bool)>,
    limit: Duration,
}

fn picture(
    args: &RenderArgs,
    request: &RenderRequest,
    streams: &Streams,
) -> Result<RenderReport, RenderStop> {
    let named = args.bind.iter().chain(&args.compare).map(Path::new).chain(args.scene.as_deref());
    let writer = write::protecting(named, &request.files_read());
    if let Some(out) = &args.out {
        // Fail before computing anything.
        let shown = out.display().to_string();
        file::PictureFormat::from_path(&shown)
            .map_err(|error| Error::new(&shown, error.to_string()))?;
        writer.allows(out)?;
        compare::refuse_foreign(out, &args.compare)?;
    }
    skip::allows_shader(&writer, args, request)?;
    let scene = &request.scene;
    let (frame, renderer) = frame_and_renderer(args, request)?;
    let mut upload = Upload::new(scene);
    if let Some(renderer) = &renderer {
        let excess = if args.leave_out { OverflowPolicy::LeaveOut } else { OverflowPolicy::Refuse };
        // Lights beyond the shader's room are an error, or with `--leave-out` are dropped.
        let kept = renderer.lights(&upload, excess).map_err(RenderError::from)?;
        upload.lights.truncate(kept.counts());
    }
    let likely = || renderer.as_ref().map(|renderer| (truth::likely_model(&renderer.map), false));
    let model = request.model.map(|model| (model, true)).or_else(likely);
    let limit = args.limit;
    let model = match (model, &request.shader) {
        (None, Some(_)) => own_model(request, &upload, &frame, limit)?,
        (model, _) => model,
    };
    let made = PreparedScene { scene, upload, frame, renderer, model, limit };
    let mut report = made.report(request);
    let mut emitted = None;
    let picture = if args.reference {
        let begun = Instant::now();
        let truth = made.truth()?;
        report.time = begun.elapsed();
        report.shader = None;
        report.model = made.model;
        truth.picture
    } else {
        let mut lighting = Lighting::open(args.backend, args, &made, streams)?;
        let (planned, planning) =
            timed(lighting.backend(), &mut |backend| skip::plan(args, request, &made, backend))?;
        let lit = match planned {
            Some(planned) => {
                let skipped = skip::light(planned, planning, &made, &mut lighting)?;
                let Skipped { lit, plan, emitted: text, unmet, note } = skipped;
                (emitted, report.unmet, report.plan) = (text, unmet, Some(plan));
                report.notes.extend(note);
                lit
            }
            None => lighting.light_all(&made)?,
        };
        report.device = Some(lighting.backend().device().clone());
        report.tally = lit.tally;
        report.time = lit.elapsed;
        report.discarded = lit.rendered.discarded;
        report.evaluations = Some(lit.rendered.evaluations);
        report.uploaded = lit.rendered.uploaded;
        lit.rendered.picture
    };
    let transfer = transfer(args);
    for what in &args.compare {
        let done = compare::compare(&made, what, &picture, args, streams)?;
        for (path, difference) in done.pictures {
            // For viewing, independent of the picture's transfer function.
            save(&writer, Path::new(&path), &difference, Transfer::Srgb)?;
            report.written.push(path);
        }
        report.model = done.model.or(report.model);
        report.compared.push(done.compared);
    }
    if let (Some(path), Some(text)) = (&args.emit_shader, &emitted) {
        writer.write(path, text.as_bytes())?;
        report.written.push(path.display().to_string());
    }
    report.non_finite = picture.non_finite();
    if report.non_finite > 0 && !args.reference {
        report.causes = made.whole().non_finite(&made.work(), &picture)?;
    }
    if let Some(tally) = &report.tally {
        report.undefined = made.whole().undefined(&made.work(), &tally.undefined)?;
    }
    thread::scope(|scope| -> Result<(), Error> {
        // Freeing it takes about as long as saving the picture.
        let _ = thread::Builder::new().spawn_scoped(scope, || drop(made.frame));
        if let Some(out) = &args.out {
            save(&writer, out, &picture, transfer)?;
            report.written.insert(0, out.display().to_string());
        }
        Ok(())
    })?;
    Ok(report)
}

/// Rasterises the scene and compiles its shader meanwhile, if it is needed.
fn frame_and_renderer(
    args: &RenderArgs,
    request: &RenderRequest,
) -> Result<(Frame, Option<Renderer>), RenderStop> {
    let is_needed = !args.reference || compare::needs_shader(&args.compare);
    Frame::beside(&request.scene, &request.frame, || match is_needed {
        true => Ok(Some(request.renderer()?.ok_or_else(|| request.no_shader())?)),
        false => Ok(None),
    })
}

/// The model of the scene's shader, as a comparison with the reference takes it: the one nearest to
/// the shader's picture.
fn own_model(
    request: &RenderRequest,
    upload: &Upload,
    frame: &Frame,
    limit: Duration,
) -> Result<Option<(Model, bool)>, RenderStop> {
    let Some(renderer) = request.renderer()? else { return Ok(None) };
    let lights = renderer.lights(upload, OverflowPolicy::LeaveOut).map_err(RenderError::from)?;
    let fragments = truth::sampled(frame);
    let draws = [Draw { fragments: &fragments, lights: &lights, tiles: None }];
    let work = Work { upload, frame, background: request.scene.background, limit };
    let mut cpu = renderer.cpu(Settings::default());
    let rendered = renderer.render(&mut cpu, &work, &draws, &mut |_: &mut Cpu, _| {})?;
    let likely = truth::likely_model(&renderer.map);
    Ok(Some((truth::nearest(&likely, upload, frame, &rendered.picture), false)))
}

fn transfer(args: &RenderArgs) -> Transfer {
    match args.transfer {
        crate::args::TransferName::Linear => Transfer::Linear,
        crate::args::TransferName::Srgb => Transfer::Srgb,
    }
}

fn save(
    writer: &FileWriter,
    path: &Path,
    picture: &Picture,
    transfer: Transfer,
) -> Result<(), Error> {
    let shown = path.display().to_string();
    let bytes = file::PictureFormat::from_path(&shown)
        .and_then(|format| file::write(picture, format, transfer));
    let bytes = bytes.map_err(|error| Error::new(&shown, error.to_string()))?;
    writer.write(path, bytes).map(|_| ())
}

impl PreparedScene<'_> {
    /// Renders the reference; without a given model, with the one nearest to `picture`.
    fn truth_near(&self, picture: &Picture) -> Result<(Truth, (Model, bool)), Error> {
        let (mut model, is_given) = self.model()?;
        if !is_given {
            model = truth::nearest(&model, &self.upload, &self.frame, picture);
        }
        let truth = truth::truth(&model, &self.upload, &self.frame, self.scene.background);
        Ok((truth, (model, is_given)))
    }

    fn truth(&self) -> Result<Truth, Error> {
        let (model, _) = self.model()?;
        Ok(truth::truth(&model, &self.upload, &self.frame, self.scene.background))
    }

    fn model(&self) -> Result<(Model, bool), Error> {
        self.model.ok_or_else(|| {
            let what = "needs a lighting model, but neither the scene nor the shader gives one";
            Error::new("--reference", what)
                .with_help("add `--model multi`, `array`, `view_space` or `casters`")
        })
    }

    fn report(&self, request: &RenderRequest) -> RenderReport {
        let lit = LightSet::all(&self.upload.lights);
        let mut notes = self.renderer.as_ref().map_or(Vec::new(), |r| r.notes(&self.upload));
        if self.frame.fragments.is_empty() {
            notes.push("no pixel shows an object: the picture is the background".to_string());
        }
        if let Some(renderer) = &self.renderer {
            let unknown = renderer.map.unknown();
            notes.extend(
                unknown
                    .iter()
                    .map(|name| format!("`{name}` is zero: the scene has no value for it")),
            );
        }
        RenderReport {
            scene: self.scene.name.clone(),
            shader: request.shader.as_ref().map(|shader| shader.path.clone()),
            size: [self.frame.width, self.frame.height],
            fragments: self.frame.fragments.len() as u64,
            lights: lit.counts(),
            idle: self.renderer.as_ref().map_or(0, |renderer| renderer.unused_slots(&lit)),
            map: self.renderer.as_ref().map(|renderer| renderer.map.clone()),
            notes,
            ..RenderReport::default()
        }
    }

    fn work(&self) -> Work<'_> {
        let PreparedScene { upload, frame, limit, scene, .. } = self;
        Work { upload, frame, background: scene.background, limit: *limit }
    }

    /// The shader with all lights.
    fn whole(&self) -> &Renderer {
        self.renderer.as_ref().expect("backends render shaders only")
    }
}

fn print_report(
    args: &RenderArgs,
    report: &RenderReport,
    streams: &Streams,
) -> Result<Outcome, CommandFailure> {
    match args.format {
        RenderFormat::Human => {
            streams.product(&print::text(report, args.details, streams.paint))?;
            if let (true, Some(plan)) = (args.details, &report.plan) {
                streams.product(&landfall::report::plan::text(plan, streams.paint))?;
            }
            streams.finish()?;
            let warning = |note| Diagnostic::without_place(Code::Bind, Severity::Warning, note);
            let notes: Vec<Diagnostic> = report.notes.iter().map(warning).collect();
            let style = streams.style(FindingForm::Human);
            streams.report(&style.text(&notes, &Files::default()));
        }
        RenderFormat::Json => streams.json(&print::json(report))?,
    }
    // A picture that differs by more than `--max-step`, or that has NaN or infinities, is a
    // finding.
    let far = |most: u8| report.compared.iter().any(|with| with.comparison.codes.max > most);
    let found = report.non_finite > 0 || report.unmet || args.max_step.is_some_and(far);
    Ok(if found { Outcome::Findings } else { Outcome::Clean })
}
