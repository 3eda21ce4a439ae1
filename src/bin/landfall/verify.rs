//! `landfall verify`: every block read back by every reader, and which byte each read saw.

use landfall_exec::backend::BackendKind;
use landfall_layout::diagnostic::Code;
use std::path::Path;

use landfall::report::verify as print;
use landfall::report::verify::Counts;
use landfall_exec::backend::Device;
use landfall_exec::harness::bindings::Data;
use landfall_exec::harness::coverage::coverage;
use landfall_exec::harness::spirv;
use landfall_exec::harness::verify::report::{Attendance, Outcome as Seen, ShaderReport};
use landfall_exec::harness::verify::{
    ReadBy, Subject, VerifyOptions, hold_spirv, run_compiled, verify,
};
use landfall_layout::lock;
use landfall_layout::lock::Verified;
use landfall_layout::source::Files;
use landfall_layout::{BlockLayout, Diagnostic, Error, Severity};

use crate::args::{VerifyArgs, VerifyFormat};
use crate::config::{self, Config};
use crate::inputs::{Input, Inputs};
use crate::output::{Failure, FindingForm, FindingStyle, Outcome, Streams};
use crate::readers::{self, Readers};
use crate::{data, given, read};

pub fn run(args: &VerifyArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let Some(config) = config::load(&args.config, &args.files, streams)? else {
        return Ok(Outcome::CouldNot);
    };
    let options = VerifyOptions {
        layout: config.options(&args.read.text, &args.read.defines),
        given: args.layout.as_deref().map(given).transpose()?,
        stages: args.stages.clone(),
        naga: args.naga,
        block: args.block.clone(),
        limit: args.limit,
    };
    let mut readers = readers::open(&args.readers, args.adapter.as_deref());
    required(args, &readers)?;
    let form = match args.format {
        VerifyFormat::Human => FindingForm::Human,
        VerifyFormat::Json => FindingForm::Json,
    };
    let mut run = Run {
        args,
        config: &config,
        options,
        style: streams.style(form),
        streams,
        counts: Counts::default(),
        could_not: false,
        data: data::blocks(args.data.as_deref())?,
        spirv: args.spirv.as_deref().map(compiled).transpose()?,
    };
    match args.format {
        VerifyFormat::Human => {
            streams.product(&print::readers(&readers.attendance, streams.paint))?;
        }
        VerifyFormat::Json => streams.json(&print::json_opening(&readers.attendance))?,
    }
    for input in Inputs::new(args.files.clone()) {
        run.one(input, &mut readers)?;
    }
    run.finish()
}

/// The words of a SPIR-V file.
fn compiled(path: &Path) -> Result<Vec<u32>, Error> {
    let words = spirv::words(&read::bytes(path)?);
    words.map_err(|failure| Error::new(read::shown(path), failure.message))
}

fn of_failure(failure: landfall_exec::backend::Failure) -> Error {
    Error::new("--spirv", failure.message)
}

/// The blocks of a lock or of the output of `layout --format json`.
fn given(path: &Path) -> Result<Vec<BlockLayout>, Error> {
    let text = read::text(path)?;
    let locks = lock::read_all(&read::shown(path), &text)?;
    Ok(locks.into_iter().flat_map(|lock| lock.blocks).collect())
}

/// Those that `--require` names must be here, and somebody must.
fn required(args: &VerifyArgs, readers: &Readers) -> Result<(), Error> {
    for attendance in &readers.attendance {
        let Attendance::Missing { reader, failure } = attendance else { continue };
        if args.require.iter().any(|name| name.kind() == *reader) {
            let message = format!("is required and did not run: {}", failure.message);
            return Err(Error::new(reader.name(), message)
                .with_help("`landfall devices` lists what is here"));
        }
    }
    let named = |kind: BackendKind| {
        readers.attendance.iter().any(|attendance| match attendance {
            Attendance::Here(device) => device.reader == kind,
            Attendance::Missing { .. } => false,
        })
    };
    if let Some(name) = args.require.iter().find(|name| !named(name.kind())) {
        let message = "is required, but `--reader` leaves it out";
        return Err(Error::new(name.name(), message));
    }
    if readers.here.is_empty() {
        return Err(Error::new("verify", "has no reader to run")
            .with_help("`landfall devices` says why; `--reader cpu` needs nothing"));
    }
    Ok(())
}

struct Run<'a> {
    args: &'a VerifyArgs,
    config: &'a Config,
    options: VerifyOptions,
    style: FindingStyle,
    streams: &'a Streams,
    counts: Counts,
    could_not: bool,
    data: Data,
    /// The words of `--spirv`.
    spirv: Option<Vec<u32>>,
}

impl Run<'_> {
    fn one(&mut self, input: Result<Input, Error>, readers: &mut Readers) -> Result<(), Failure> {
        let read = |input: Input| Ok((read::source(&input.path, &self.args.read)?, input));
        let (source, input) = match input.and_then(read) {
            Ok(read) => read,
            Err(error) => {
                self.refuse(&[error.into()], &Files::default());
                return Ok(());
            }
        };
        if self.streams.shows_progress() {
            self.streams.progress(&format!("verifying {}", source.path));
        }
        let subject = match Subject::new(&source, &self.options) {
            Ok(subject) => subject,
            Err((shader, found)) => {
                self.refuse(&found, &shader.files);
                return Ok(());
            }
        };
        given::saw(&subject.layout().files);
        let mut report = verify(&subject, &self.options, &mut readers.here);
        if let Some(words) = &self.spirv {
            hold_spirv(&subject, &self.options, words, &mut report).map_err(of_failure)?;
            let gpu =
                readers.here.iter_mut().find(|reader| reader.device().reader == BackendKind::Gpu);
            report.compiled =
                gpu.map(|gpu| run_compiled(&subject, &self.options, words, gpu.as_mut()));
        }
        if self.args.coverage {
            let limit = self.options.limit;
            match coverage(&source, &self.options.layout, &self.data, limit) {
                Ok(found) => report.cover(found),
                Err(found) => self.refuse(&found, &subject.layout().files),
            }
        }
        let text = match self.args.format {
            VerifyFormat::Human => format!("\n{}", print::shader(&report, self.streams.paint)),
            VerifyFormat::Json => {
                let comma = if self.counts.shaders > 0 { ",\n" } else { "" };
                format!("{comma}{}", print::json_shader(&report))
            }
        };
        self.counts.add(&report);
        match self.args.format {
            VerifyFormat::Human => self.streams.product(&text)?,
            VerifyFormat::Json => self.streams.json(&text)?,
        }
        if self.args.record {
            self.record(&subject, &input, &report, &readers.attendance)?;
        }
        Ok(())
    }

    fn refuse(&mut self, found: &[Diagnostic], files: &Files) {
        self.could_not = true;
        self.streams.report(&self.style.text(found, files));
    }

    /// Notes in a shader's lock who confirmed all of its blocks.
    fn record(
        &self,
        subject: &Subject,
        input: &Input,
        report: &ShaderReport,
        attendance: &[Attendance],
    ) -> Result<(), Failure> {
        let locks = self.config.locks(self.args.locks.as_deref());
        let path = self.config.lock_of(&locks, &read::named(&input.path, &self.args.read))?;
        let text = read::text(&path).map_err(|error| {
            error.with_help("`landfall lock` writes it; then `verify --record` can add to it")
        })?;
        let mut lock = lock::read(&path.display().to_string(), &text)?;
        let confirmed = |device: &Device| {
            let mut seen = report.blocks.iter().map(|block| {
                block.readers.iter().any(|reader| {
                    reader.reader == ReadBy::Backend(device.reader)
                        && reader.outcome == Seen::Confirmed
                })
            });
            !report.blocks.is_empty() && seen.all(|seen| seen)
        };
        for attendance in attendance {
            let Attendance::Here(device) = attendance else { continue };
            if device.reader == BackendKind::Cpu || !confirmed(device) {
                continue;
            }
            let verified = Verified {
                reader: device.reader.to_string(),
                adapter: device.adapter.clone(),
                driver: format!("{} {}", device.driver, device.version).trim().to_string(),
                version: env!("CARGO_PKG_VERSION").to_string(),
            };
            lock.verified.retain(|other| {
                (&other.reader, &other.adapter) != (&verified.reader, &verified.adapter)
            });
            lock.verified.push(verified);
        }
        // A lock of another layout keeps nobody's word.
        let renewed = lock::renew(subject.layout(), Some(&lock));
        if renewed != text {
            let named = self.args.locks.is_some();
            self.config.writer(&locks, named).write(&path, renewed.as_bytes())?;
        }
        Ok(())
    }

    /// Nothing was read back, so that nothing is proved.
    fn nothing(self) -> Result<Outcome, Failure> {
        let shaders = match self.counts.shaders {
            1 => "1 shader".to_string(),
            n => format!("{n} shaders"),
        };
        let (message, code) = match &self.args.block {
            Some(name) => (format!("no block named `{name}` in {shaders}"), Code::UnknownBlock),
            None => (format!("no blocks to verify in {shaders}"), Code::NoBlocks),
        };
        let severity = if self.args.block.is_some() { Severity::Error } else { Severity::Warning };
        let found = Diagnostic { severity, ..Diagnostic::about(code, message, None, "") };
        let found = Diagnostic { path: None, ..found };
        self.streams.report(&self.style.text(&[found], &Files::default()));
        Ok(if self.args.block.is_some() { Outcome::CouldNot } else { Outcome::Clean })
    }

    fn finish(self) -> Result<Outcome, Failure> {
        if self.args.format == VerifyFormat::Json {
            self.streams.json(print::json_closing(self.counts.shaders))?;
        }
        if self.counts.blocks == 0 && self.counts.failed == 0 && !self.could_not {
            return self.nothing();
        }
        if self.counts.shaders > 0 {
            self.streams.notes(&print::summary(&self.counts));
        }
        Ok(if self.could_not || self.counts.failed > 0 {
            Outcome::CouldNot
        } else if self.counts.elsewhere > 0 {
            Outcome::Findings
        } else {
            Outcome::Clean
        })
    }
}
