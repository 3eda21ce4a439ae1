//! `landfall verify`: runs probes that report the byte each member is read from.

use landfall_check::files;
use landfall_exec::backend::BackendKind;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::OnceLock;

use landfall::report::verify as print;
use landfall::report::verify::Counts;
use landfall_exec::backend::Device;
use landfall_exec::harness::bindings::Data;
use landfall_exec::harness::coverage::coverage;
use landfall_exec::harness::spirv;
use landfall_exec::harness::verify::report::{BackendStatus, Outcome as ReadOutcome, ShaderReport};
use landfall_exec::harness::verify::{
    ReadBy, Subject, VerifyOptions, compare_spirv, run_compiled, verify,
};
use landfall_layout::diagnostic::Code;
use landfall_layout::format::Paint;
use landfall_layout::format::phrases::counted;
use landfall_layout::lock;
use landfall_layout::lock::Verified;
use landfall_layout::source::{Files, Source};
use landfall_layout::{BlockLayout, Diagnostic, Error, Options, Severity};

use crate::args::{VerifierName, VerifyArgs, VerifyFormat};
use crate::backends::{self, Backends};
use crate::config;
use crate::output::{CommandFailure, FindingForm, FindingStyle, Outcome, Streams};
use crate::{data, read, templates, watch, without_effect};
use landfall_check::config::Config;
use landfall_check::inputs::{Input, Inputs};
use landfall_check::templates::Templates;
use landfall_ir::threads;

pub fn run(args: &VerifyArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let config = config::load(&args.config, &args.files, streams)?;
    let options = VerifyOptions {
        layout: config.options(&args.read.flags()),
        given: args.layout.as_deref().map(given_layout).transpose()?,
        stages: args.stages.clone(),
        naga: args.naga,
        block: args.block.clone(),
        limit: args.limit,
    };
    let form = FindingForm::json_if(args.format == VerifyFormat::Json);
    let job = VerifyJob {
        args,
        options,
        style: streams.style(form),
        templates: Templates::default(),
        paint: streams.paint,
        data: data::blocks(args.data.as_deref())?,
        spirv: args.spirv.as_deref().map(compiled).transpose()?,
    };
    let statuses = OnceLock::new();
    let mut run = Run {
        args,
        config: &config,
        style: job.style,
        layout: job.options.layout.clone(),
        streams,
        statuses: &statuses,
        counts: Counts::default(),
        idle: args.require.clone(),
        could_not: false,
    };
    // One browser serves all of a command.
    let browser = VerifierName::Web;
    let has_browser = args.backends.contains(&browser) || args.require.contains(&browser);
    let jobs = if has_browser { Some(NonZeroUsize::MIN) } else { args.jobs };
    let open = || backends::open(&args.backends, &args.require, args.adapter.as_deref());
    let own = || {
        // Dropped at the end of this closure: other threads do not wait for a thread that failed.
        let _known = KnownAtEnd(&statuses);
        let backends = open();
        required(args, &backends)?;
        statuses.get_or_init(|| Some(backends.statuses.clone()));
        match args.format {
            VerifyFormat::Human => {
                streams.product(&print::backends(&backends.statuses, streams.paint))?;
            }
            VerifyFormat::Json => streams.json(&print::json_opening(&backends.statuses))?,
        }
        Ok(backends)
    };
    // Another thread has its own processes of the same drivers.
    let other = || {
        let backends = open();
        let is_alike = statuses.wait().as_deref().is_some_and(|found| backends.are_on(found));
        is_alike.then_some(backends)
    };
    threads::ordered_with(
        Inputs::new(args.files.clone(), watch::stop())
            .filter(|input| config.takes(input, &args.files)),
        jobs,
        (own, other),
        |backends, input| job.one(input, backends),
        |done| run.take(done?),
    )?;
    Ok(run.finish(&job.templates)?)
}

/// The status of every requested backend, as the calling thread found it; `None` if the command
/// ends with an error before.
type Statuses = OnceLock<Option<Vec<BackendStatus>>>;

/// Sets the statuses on drop, if an error came first: other threads wait for them.
struct KnownAtEnd<'a>(&'a Statuses);

impl Drop for KnownAtEnd<'_> {
    fn drop(&mut self) {
        self.0.get_or_init(|| None);
    }
}

/// Reads the words of a SPIR-V file.
fn compiled(path: &Path) -> Result<Vec<u32>, Error> {
    let words = spirv::words(&files::bytes(path)?);
    words.map_err(|failure| Error::new(files::display_path(path), failure.message))
}

fn of_failure(failure: landfall_exec::backend::Failure) -> Error {
    Error::new("--spirv", failure.message)
}

/// Reads the blocks of a lock or of output of `layout --format json`.
fn given_layout(path: &Path) -> Result<Vec<BlockLayout>, Error> {
    let text = files::text(path)?;
    let locks = lock::read_all(&files::display_path(path), &text)?;
    Ok(locks.into_iter().flat_map(|lock| lock.blocks).collect())
}

/// Fails if a backend of `--require` is missing, or if none is available. One API of a browser is
/// enough.
fn required(args: &VerifyArgs, backends: &Backends) -> Result<(), Error> {
    let statuses = || backends.statuses.iter();
    let missing = |name: VerifierName| {
        statuses().find_map(|status| match status {
            BackendStatus::Missing { backend, failure } if name.kinds().contains(backend) => {
                Some(failure)
            }
            BackendStatus::Missing { .. } | BackendStatus::Here(_) => None,
        })
    };
    let is_here = |name: VerifierName| {
        statuses().any(|status| match status {
            BackendStatus::Here(device) => name.kinds().contains(&device.backend),
            BackendStatus::Missing { .. } => false,
        })
    };
    if let Some(name) = args.require.iter().find(|name| !is_here(**name)) {
        return Err(match missing(*name) {
            Some(failure) => {
                let message = format!("is required but did not run: {}", failure.message);
                Error::new(name.name(), message)
                    .with_help("`landfall devices` lists the available backends")
            }
            None => Error::new(name.name(), "is required, but `--backend` excludes it"),
        });
    }
    if !backends.here.is_empty() {
        return Ok(());
    }
    if let ([VerifierName::Web], Some(failure)) = (&args.backends[..], missing(VerifierName::Web)) {
        let message = format!("did not run: {}", failure.message);
        return Err(Error::new("web", message)
            .with_help("install Chromium; `--backend cpu` needs no browser"));
    }
    Err(Error::new("verify", "finds no backend to run the shader on")
        .with_help("`landfall devices` shows why; `--backend cpu` needs no driver"))
}

struct VerifyJob<'a> {
    args: &'a VerifyArgs,
    options: VerifyOptions,
    style: FindingStyle,
    templates: Templates,
    paint: Paint,
    data: Data,
    /// The words of `--spirv`.
    spirv: Option<Vec<u32>>,
}

#[derive(Default)]
struct VerifiedInput {
    /// The shader, the path it was named by, and what was read; `None` if it cannot be laid out.
    report: Option<(Source, Input, ShaderReport)>,
    text: String,
    /// Findings that prevent it, or a part of it.
    findings: String,
    could_not: bool,
}

impl threads::Weighed for VerifiedInput {
    fn bytes(&self) -> usize {
        /// About a read with its names, in the report.
        const READ: usize = 160;
        let blocks = self.report.iter().flat_map(|(_, _, report)| &report.blocks);
        let reads = blocks.flat_map(|block| &block.backends).map(|backend| backend.reads.len());
        self.text.len() + self.findings.len() + READ * reads.sum::<usize>()
    }
}

impl VerifyJob<'_> {
    fn one(
        &self,
        input: Result<Input, Error>,
        backends: &mut Backends,
    ) -> Result<VerifiedInput, Error> {
        let refused = |found: &[Diagnostic], files: &Files| {
            let findings = self.style.text(found, files);
            Ok(VerifiedInput { findings, could_not: true, ..VerifiedInput::default() })
        };
        let read = |input: Input| {
            let source = templates::shader_text(&self.templates, &input, &self.args.read)?;
            Ok(source.map(|source| (source, input)))
        };
        let (source, input) = match input.and_then(read) {
            Ok(Some(read)) => read,
            Ok(None) => return Ok(VerifiedInput::default()),
            Err(error) => return refused(&[error.into()], &Files::default()),
        };
        // A shader that cannot be laid out is reported, and the others go on.
        let subject = match Subject::new(&source, &self.options) {
            Ok(subject) => subject,
            Err((shader, found)) => return refused(&found, &shader.files),
        };
        // The names given are looked for in the shader as it was laid out.
        without_effect::record_of(subject.layout());
        let mut report = verify(&subject, &self.options, &mut backends.here);
        if let Some(words) = &self.spirv {
            compare_spirv(&subject, &self.options, words, &mut report).map_err(of_failure)?;
            // Of the backends, only `gpu` takes a user's SPIR-V.
            let gpu = backends
                .here
                .iter_mut()
                .find(|backend| backend.device().backend == BackendKind::Gpu);
            report.compiled =
                gpu.map(|gpu| run_compiled(&subject, &self.options, words, gpu.as_mut()));
        }
        let mut done = VerifiedInput::default();
        if self.args.coverage {
            let limit = self.options.limit;
            match coverage(&source, &self.options.layout, &self.data, limit) {
                Ok(found) => report.cover(found),
                Err(found) => done = refused(&found, &subject.layout().files)?,
            }
        }
        let text = match self.args.format {
            VerifyFormat::Human => format!("\n{}", print::shader(&report, self.paint)),
            VerifyFormat::Json => print::json_shader(&report),
        };
        Ok(VerifiedInput { report: Some((source, input, report)), text, ..done })
    }
}

struct Run<'a> {
    args: &'a VerifyArgs,
    config: &'a Config,
    style: FindingStyle,
    layout: Options,
    streams: &'a Streams,
    statuses: &'a Statuses,
    counts: Counts,
    /// The required backends that have read nothing so far.
    idle: Vec<VerifierName>,
    could_not: bool,
}

impl Run<'_> {
    fn take(&mut self, done: VerifiedInput) -> Result<(), Error> {
        self.could_not |= done.could_not;
        self.streams.report(&done.findings);
        let Some((source, input, report)) = done.report else { return Ok(()) };
        let is_first = self.counts.shaders == 0;
        self.counts.add(&report);
        let backends_of = report.blocks.iter().flat_map(|block| &block.backends);
        for backend in backends_of.filter(|backend| !backend.reads.is_empty()) {
            let read_by = |kind: &BackendKind| ReadBy::Backend(*kind) == backend.backend;
            self.idle.retain(|idle| !idle.kinds().iter().any(read_by));
        }
        match self.args.format {
            VerifyFormat::Human => self.streams.product(&done.text)?,
            VerifyFormat::Json => {
                // The opening of the array was printed before the first result.
                let comma = if is_first { "" } else { ",\n" };
                self.streams.json(&format!("{comma}{}", done.text))?;
            }
        }
        if self.streams.shows_progress() {
            self.streams.progress(&format!("verified {}", source.path));
        }
        if self.args.record {
            self.record(&source, &input, &report)?;
        }
        Ok(())
    }

    /// Records in the shader's lock the backends that confirmed all of its blocks.
    fn record(&self, source: &Source, input: &Input, report: &ShaderReport) -> Result<(), Error> {
        let locks = self.config.locks(self.args.locks.as_deref());
        let path =
            self.config.lock_of(&locks, &read::message_path(&input.path, &self.args.read))?;
        let text = files::text(&path).map_err(|error| {
            error.with_help("write it with `landfall lock` before `verify --record`")
        })?;
        let mut lock = lock::read(&path.display().to_string(), &text)?;
        let confirmed = |device: &Device| {
            let mut confirmations = report.blocks.iter().map(|block| {
                block.backends.iter().any(|backend| {
                    backend.backend == ReadBy::Backend(device.backend)
                        && backend.outcome == ReadOutcome::Confirmed
                })
            });
            !report.blocks.is_empty() && confirmations.all(|confirmed| confirmed)
        };
        for status in self.statuses.get().into_iter().flatten().flatten() {
            let BackendStatus::Here(device) = status else { continue };
            // The interpreter is part of landfall, so it confirms nothing about other
            // implementations.
            if device.backend == BackendKind::Cpu || !confirmed(device) {
                continue;
            }
            let verified = Verified {
                backend: device.backend.to_string(),
                adapter: device.adapter.clone(),
                driver: format!("{} {}", device.driver, device.version).trim().to_string(),
                version: env!("CARGO_PKG_VERSION").to_string(),
            };
            // A newer record of the same backend and adapter replaces the older.
            lock.verified.retain(|other| {
                (&other.backend, &other.adapter) != (&verified.backend, &verified.adapter)
            });
            lock.verified.push(verified);
        }
        // Renewing drops the records of another layout. Locks hold the layout without what probes
        // need, such as a block of loose uniforms.
        let shader = self.config.settings.layout(source, &self.layout);
        let renewed = lock::renew(&shader, Some(&lock));
        if renewed != text {
            let named = self.args.locks.is_some();
            self.config.writer(&locks, named).write(&path, renewed.as_bytes())?;
        }
        Ok(())
    }

    fn nothing(self) -> Outcome {
        let shaders = counted(self.counts.shaders, "shader");
        let (code, severity, message, outcome) = match &self.args.block {
            Some(name) => {
                let message = format!("no block named `{name}` in {shaders}");
                (Code::UnknownBlock, Severity::Error, message, Outcome::CouldNot)
            }
            None => {
                let message = format!("no blocks to verify in {shaders}");
                (Code::NoBlocks, Severity::Warning, message, Outcome::Clean)
            }
        };
        self.streams.report(&self.style.one(Diagnostic::without_place(code, severity, message)));
        outcome
    }

    /// Returns the error that no backend, or not each required one, read anything.
    fn unread(&self) -> Option<Error> {
        // That error has been reported.
        if self.could_not || self.counts.failed > 0 {
            return None;
        }
        let (name, message) = match self.idle.first() {
            _ if self.counts.reads == 0 => ("verify", "read no member of any block"),
            Some(backend) => {
                (backend.name(), "is required, but its probes read no member of any block")
            }
            None => return None,
        };
        let help = "the report names the reason by block; `--backend cpu` reads GLSL and WGSL";
        Some(Error::new(name, message).with_help(help))
    }

    fn finish(mut self, templates: &Templates) -> Result<Outcome, Error> {
        if self.args.format == VerifyFormat::Json {
            self.streams.json(print::json_closing(self.counts.shaders))?;
        }
        let is_all = self.counts.shaders == 0 && !self.could_not;
        self.could_not |= templates::report(templates, is_all, self.style, self.streams);
        if watch::is_stopped() {
            return Ok(Outcome::Interrupted);
        }
        // Nothing was read, and nothing failed: there were no blocks to verify.
        if self.counts.blocks == 0 && self.counts.failed == 0 && !self.could_not {
            return Ok(self.nothing());
        }
        if self.counts.shaders > 0 {
            self.streams.notes(&print::summary(&self.counts));
        }
        if let Some(error) = self.unread() {
            let found = Diagnostic { code: Code::CannotRun, path: None, ..error.into() };
            self.streams.report(&self.style.one(found));
            return Ok(Outcome::CouldNot);
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
