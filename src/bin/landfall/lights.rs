//! `landfall lights`: lists light structures, their cost and the numerical hazards of their code.

use landfall::report::lights as print;
use landfall::report::lights::cost::{Report, cost};
use landfall_layout::format::phrases::counted;
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, ShaderLayout, layout};

use crate::args::{LightsArgs, LightsFormat};
use crate::output::{CommandFailure, FindingForm, FindingStyle, Outcome, Streams};
use crate::{read, templates, watch, without_effect};
use landfall_check::caught::caught;
use landfall_check::inputs::Inputs;
use landfall_check::templates::Templates;

pub fn run(args: &LightsArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let style = streams.style(FindingForm::json_if(args.format == LightsFormat::Json));
    let mut tally = LightsTally::default();
    if args.format == LightsFormat::Json {
        streams.json(&print::opening())?;
    }
    let templates = Templates::default();
    for input in Inputs::new(args.files.clone(), watch::stop()) {
        let read = input.and_then(|input| {
            let source = templates::shader_text(&templates, &input, &args.read)?;
            Ok(source.map(|source| (input.path, source)))
        });
        let (path, source) = match read {
            Ok(Some(read)) => read,
            Ok(None) => continue,
            Err(error) => {
                tally.failed(&[error.into()], &Files::default(), streams, style);
                continue;
            }
        };
        let options = read::options(&args.read);
        let work = || {
            let shader = layout(&source, &options);
            without_effect::record_of(&shader);
            // Analysis needs a layout.
            let report = (!shader.has_errors()).then(|| cost(&source, &options, &shader));
            (shader, report)
        };
        let (shader, report) = match caught(&path.display().to_string(), work) {
            Ok(done) => done,
            Err(found) => {
                tally.failed(&[found], &Files::default(), streams, style);
                continue;
            }
        };
        let Some(mut report) = report else {
            tally.failed(&shader.diagnostics, &shader.files, streams, style);
            continue;
        };
        // Judged before the hazards below `--least` are left out.
        let denied = args.deny.map(|sure| sure.certainty());
        tally.denied |= denied.is_some_and(|d| report.hazards.iter().any(|h| h.certainty >= d));
        report.hazards.retain(|hazard| hazard.certainty >= args.least.certainty());
        if args.format == LightsFormat::Human && streams.is_quiet() {
            // The hazards that fail the run are errors, the others warnings.
            report.hazards.retain(|hazard| denied.is_some_and(|d| hazard.certainty >= d));
        }
        tally.take(&shader, &report, args, streams)?;
    }
    match args.format {
        LightsFormat::Json => streams.json(print::closing(tally.printed))?,
        LightsFormat::Human => tally.end(streams)?,
    }
    let is_all = tally.shaders == 0 && !tally.failed;
    tally.failed |= templates::report(&templates, is_all, style, streams);
    Ok(tally.outcome())
}

#[derive(Default)]
struct LightsTally {
    shaders: usize,
    printed: usize,
    /// A shader without lights, held back: the text is printed only if no second shader comes.
    dark: Option<String>,
    failed: bool,
    denied: bool,
}

impl LightsTally {
    fn failed(
        &mut self,
        found: &[Diagnostic],
        files: &Files,
        streams: &Streams,
        style: FindingStyle,
    ) {
        self.failed = true;
        streams.report(&style.text(found, files));
    }

    fn take(
        &mut self,
        shader: &ShaderLayout,
        report: &Report,
        args: &LightsArgs,
        streams: &Streams,
    ) -> Result<(), Error> {
        self.shaders += 1;
        match args.format {
            LightsFormat::Json => {
                // The separator comes before each object after the first; the brackets are printed
                // by the caller.
                if self.printed > 0 {
                    streams.product(",\n")?;
                }
                streams.json(&print::json(shader, report))?;
            }
            LightsFormat::Human => {
                let text = print::human(shader, report, streams.paint);
                // Among several files, those without lights are only counted.
                if report.lights.is_empty() && report.hazards.is_empty() {
                    self.dark = Some(text);
                    return Ok(());
                }
                if self.printed > 0 {
                    streams.product("\n")?;
                }
                streams.product(&text)?;
            }
        }
        self.printed += 1;
        Ok(())
    }

    // A single shader without lights is printed in full; among several, a count tells that they
    // were read.
    fn end(&mut self, streams: &Streams) -> Result<(), Error> {
        match (&self.dark, self.shaders) {
            (Some(text), 1) => streams.product(text),
            (_, 0 | 1) => Ok(()),
            (_, shaders) => {
                streams.finish()?;
                streams.notes(&format!(
                    "{} of {} have lights\n",
                    self.printed,
                    counted(shaders, "shader")
                ));
                Ok(())
            }
        }
    }

    fn outcome(&self) -> Outcome {
        match (self.failed, self.denied) {
            (true, _) => Outcome::CouldNot,
            (false, true) => Outcome::Findings,
            (false, false) => Outcome::Clean,
        }
    }
}
