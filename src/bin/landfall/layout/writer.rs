//! Writes the layouts of a run in order: one document on stdout, or one file per shader in `--out`.

use landfall_check::files;
use landfall_layout::diagnostic::Code;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use landfall_layout::format as emit;
use landfall_layout::format::phrases::counted;
use landfall_layout::format::{EmitOptions, Format};
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Severity};

use super::Done;
use crate::args::LayoutArgs;
use crate::{templates, watch, write};
use landfall_check::missing_includes::MissingIncludes;
use landfall_check::templates::Templates;
use landfall_layout::file::FileWriter;

use crate::output::{FindingStyle, Outcome, Streams};

/// Number of names listed if `--block` finds nothing.
const NAMES: usize = 8;

pub struct Writer<'a> {
    args: &'a LayoutArgs,
    emit: &'a EmitOptions,
    style: FindingStyle,
    streams: &'a Streams,
    /// Numbers of shaders read and written.
    shaders: usize,
    written: usize,
    /// Files written below `--out`, each with its shader.
    targets: HashMap<PathBuf, PathBuf>,
    /// The path of the last shader, for the message if it is the only one and has no blocks.
    last: PathBuf,
    others: Vec<String>,
    missing: MissingIncludes,
    /// The error that a shader does not declare the structure of `--struct`.
    absent: Option<Diagnostic>,
    outcome: Outcome,
    shows_progress: bool,
    writer: FileWriter,
}

impl<'a> Writer<'a> {
    pub fn new(
        args: &'a LayoutArgs,
        emit: &'a EmitOptions,
        style: FindingStyle,
        streams: &'a Streams,
    ) -> Writer<'a> {
        Writer {
            args,
            emit,
            style,
            streams,
            shaders: 0,
            written: 0,
            targets: HashMap::new(),
            last: PathBuf::new(),
            others: Vec::new(),
            missing: MissingIncludes::default(),
            absent: None,
            outcome: Outcome::Clean,
            shows_progress: streams.shows_progress(),
            writer: writer(args),
        }
    }

    pub fn take(&mut self, done: &Done) -> Result<(), Error> {
        if done.is_template {
            return Ok(());
        }
        self.shaders += 1;
        if done.failed {
            self.outcome = Outcome::CouldNot;
        }
        let shader = done.path.display().to_string();
        for (text, found) in &done.missing {
            if self.missing.is_new(&shader, found) {
                self.streams.report(text);
            }
        }
        self.streams.report(&done.findings);
        // Some names are enough for the message.
        let room = NAMES.saturating_sub(self.others.len());
        for name in done.others.iter().take(room) {
            if !self.others.contains(name) {
                self.others.push(name.clone());
            }
        }
        if self.absent.is_none() {
            self.absent.clone_from(&done.absent);
        }
        match (&done.product, &self.args.out) {
            (Some(text), None) => self.print(text)?,
            (Some(text), Some(out)) => self.write(text, out, done)?,
            (None, _) => {}
        }
        self.last.clone_from(&done.path);
        if self.shows_progress {
            self.streams.progress(&format!("{} laid out", counted(self.shaders, "shader")));
        }
        Ok(())
    }

    fn print(&mut self, text: &str) -> Result<(), Error> {
        // JSON of several shaders is one array, opened by the first.
        match self.written {
            0 => self.streams.exactly(&emit::opening(self.emit))?,
            _ => self.streams.exactly(emit::between(self.emit))?,
        }
        self.written += 1;
        match self.emit.format {
            Format::Json => self.streams.json(text),
            // Already escaped.
            _ => self.streams.exactly(text),
        }
    }

    fn write(&mut self, text: &str, out: &Path, done: &Done) -> Result<(), Error> {
        let path = &done.path;
        let mut target = out.join(&done.relative).into_os_string();
        target.push(".");
        target.push(self.emit.format.extension());
        let target = PathBuf::from(target);
        // `a/x.frag` and `b/x.frag` given as files have the same path below `--out`.
        if let Some(other) = self.targets.get(&target) {
            let message = format!(
                "would be written twice: for `{}` and `{}`",
                other.display(),
                path.display()
            );
            return Err(Error::unwritten(target.display().to_string(), message)
                .with_help("write the layouts of each directory to a directory of its own"));
        }
        write::protect(&mut self.writer, &done.files);
        self.own(&target, &done.files)?;
        self.writer.write(&target, text)?;
        self.targets.insert(target, path.to_path_buf());
        self.written += 1;
        Ok(())
    }

    /// Fails if the target exists and was not written by `layout --out`.
    fn own(&self, target: &Path, files: &Files) -> Result<(), Error> {
        // A document names its shader, by which output of earlier runs is known.
        let name = files.get(0).and_then(|file| Path::new(&file.path).file_name());
        let name = name.map(|name| name.to_string_lossy()).unwrap_or_default();
        let own = |text: &[u8]| {
            let text = String::from_utf8_lossy(text);
            text.is_empty() || emit::is_document(&text, self.emit.format, &name)
        };
        match files::file(target) {
            Some(text) if !self.args.force && !own(&text) => {
                let message = "already exists and was not written by `landfall layout`";
                Err(Error::unwritten(target.display().to_string(), message)
                    .with_help("name another directory, or overwrite it with `--force`"))
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Ends the document and reports missing blocks.
    pub fn finish(mut self, templates: &Templates) -> Result<Outcome, Error> {
        if self.args.out.is_none() {
            if self.written == 0 {
                self.streams.product(&emit::opening(self.emit))?;
            }
            self.streams.product(emit::closing(self.emit, self.written))?;
        }
        self.streams.notes(&self.missing.notes());
        if templates::report(templates, self.shaders == 0, self.style, self.streams) {
            self.outcome = Outcome::CouldNot;
        }
        // Silence would leave open whether nothing was found or nothing was asked.
        let known = self.written > 0 || self.outcome == Outcome::CouldNot;
        if known || watch::is_stopped() {
            return Ok(self.outcome);
        }
        let (found, outcome) = match (&self.absent, &self.args.block) {
            (Some(absent), _) => (absent.clone(), Outcome::CouldNot),
            (None, Some(name)) => (self.no_such_block(name), Outcome::CouldNot),
            (None, None) => (self.no_blocks(), Outcome::Clean),
        };
        self.streams.report(&self.style.one(found));
        Ok(outcome)
    }

    fn no_such_block(&self, name: &str) -> Diagnostic {
        let message = format!("no block named `{name}` {}", self.among());
        let help =
            (!self.others.is_empty()).then(|| format!("available: `{}`", self.others.join("`, `")));
        Diagnostic {
            help,
            ..Diagnostic::without_place(Code::UnknownBlock, Severity::Error, message)
        }
    }

    fn no_blocks(&self) -> Diagnostic {
        let message = format!("no blocks and no loose uniforms {}", self.among());
        Diagnostic::without_place(Code::NoBlocks, Severity::Warning, message)
    }

    fn among(&self) -> String {
        match self.shaders {
            1 => format!("in `{}`", self.last.display()),
            n => format!("in {}", counted(n, "shader")),
        }
    }
}

/// A writer for `--out` that does not overwrite inputs.
fn writer(args: &LayoutArgs) -> FileWriter {
    match &args.out {
        Some(out) => write::protecting(args.files.iter().map(PathBuf::as_path), []).inside(out),
        None => FileWriter::default(),
    }
}
