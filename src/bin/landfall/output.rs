//! Where text goes: products to stdout, findings and progress to stderr, files whole or not at all.

use landfall_layout::diagnostic::Code;
use std::cell::RefCell;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::process::ExitCode;

use anstream::{AutoStream, ColorChoice};
#[cfg(feature = "exec")]
use landfall_layout::error::ErrorKind;
use landfall_layout::format as emit;
use landfall_layout::format::Paint;
use landfall_layout::source::Files;
use landfall_layout::text::escape;
use landfall_layout::text::escape::Styles;
use landfall_layout::{Diagnostic, Error, Severity};

use crate::args::Color;
use crate::stdout;

/// What a command came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Clean,
    /// Something to look at: a generated file that is stale, bytes that look wrong.
    Findings,
    CouldNot,
    /// Somebody said stop; what there was by then is printed.
    Interrupted,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> ExitCode {
        match outcome {
            Outcome::Clean => ExitCode::SUCCESS,
            Outcome::Findings => ExitCode::from(1),
            Outcome::CouldNot => ExitCode::from(2),
            // 128 and the number of SIGINT, as of a command that does not listen.
            Outcome::Interrupted => ExitCode::from(130),
        }
    }
}

/// Why a command stopped half-way.
#[derive(Debug)]
pub enum Failure {
    /// Nobody reads stdout any more.
    BrokenPipe,
    Error(Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        Failure::Error(error)
    }
}

#[cfg(feature = "exec")]
/// Why what was asked for cannot be done, as a finding: a file that cannot be read, or arguments
/// that are wrong.
pub fn asked_wrongly(error: Error) -> Diagnostic {
    let code = match error.kind {
        ErrorKind::Unreadable => Code::UnreadableFile,
        ErrorKind::Other => Code::BadRequest,
    };
    Diagnostic { code, ..error.into() }
}

/// How findings are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FindingForm {
    Human,
    Json,
}

/// How findings are turned into text; knows no stream, so any thread may use it.
#[derive(Clone, Copy, Debug)]
pub struct FindingStyle {
    form: FindingForm,
    paint: Paint,
    quiet: bool,
}

impl FindingStyle {
    /// The findings of one shader as text, warnings left out when quiet.
    pub fn text(&self, found: &[Diagnostic], files: &Files) -> String {
        let kept: Vec<Diagnostic>;
        let found = if self.quiet {
            kept = found.iter().filter(|d| d.severity == Severity::Error).cloned().collect();
            &kept
        } else {
            found
        };
        match self.form {
            FindingForm::Human => emit::diagnostics::human(found, files, self.paint),
            FindingForm::Json => emit::diagnostics::json(found, files),
        }
    }
}

/// The two streams of the process.
pub struct Streams {
    stdout: RefCell<BufWriter<Box<dyn Write>>>,
    /// Whether products for the eye carry colours.
    pub paint: Paint,
    /// Whether findings do.
    finding_paint: Paint,
    quiet: bool,
    /// Whether stderr's last line is progress, to be wiped before anything else is written.
    progress: RefCell<bool>,
}

impl Streams {
    pub fn new(color: Color, quiet: bool) -> Streams {
        let choice = match color {
            Color::Auto => ColorChoice::Auto,
            Color::Always => ColorChoice::Always,
            Color::Never => ColorChoice::Never,
        };
        choice.write_global();
        let paint = |choice: ColorChoice| match choice {
            ColorChoice::Never => Paint::Plain,
            ColorChoice::Auto | ColorChoice::Always | ColorChoice::AlwaysAnsi => Paint::Ansi,
        };
        let stdout = io::stdout();
        let (to_stdout, to_stderr) =
            (AutoStream::choice(&stdout), AutoStream::choice(&io::stderr()));
        let stdout: Box<dyn Write> = match paint(to_stdout) {
            // Plain text needs no filter.
            Paint::Plain => Box::new(stdout),
            Paint::Ansi => Box::new(AutoStream::new(stdout, to_stdout)),
        };
        Streams {
            stdout: RefCell::new(BufWriter::with_capacity(1 << 16, stdout)),
            paint: paint(to_stdout),
            finding_paint: paint(to_stderr),
            quiet,
            progress: RefCell::new(false),
        }
    }

    /// Writes a product for people to stdout: nothing in it acts on a terminal or a log.
    pub fn product(&self, text: &str) -> Result<(), Failure> {
        self.exactly(&escape::output(text, self.paint.styles()))
    }

    /// Writes a product in JSON to stdout.
    pub fn json(&self, text: &str) -> Result<(), Failure> {
        self.exactly(&escape::json(text))
    }

    /// Writes code or a patch to stdout: as it is for the program that reads it, but safe to look
    /// at on a terminal and in the log of a step on GitHub.
    pub fn source(&self, text: &str) -> Result<(), Failure> {
        let is_log = || {
            let is_file = std::fs::metadata("/dev/stdout").is_ok_and(|found| found.is_file());
            std::env::var_os("GITHUB_ACTIONS").is_some() && !is_file
        };
        match io::stdout().is_terminal() || is_log() {
            true => self.product(text),
            false => self.exactly(text),
        }
    }

    /// Writes a product to stdout that a program reads, byte for byte: code, or the commands of a
    /// log.
    pub fn exactly(&self, text: &str) -> Result<(), Failure> {
        if text.is_empty() {
            return Ok(());
        }
        open()?;
        self.stdout.borrow_mut().write_all(text.as_bytes()).map_err(|cause| stdout_failure(&cause))
    }

    /// Writes a product to stdout piece by piece; names in it are those of a layout.
    pub fn product_of(
        &self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        open()?;
        write(&mut *self.stdout.borrow_mut()).map_err(|cause| stdout_failure(&cause))
    }

    /// Whether stdout is a place for bytes that are no text.
    pub fn takes_bytes(&self) -> Result<(), Error> {
        if !io::stdout().is_terminal() {
            return Ok(());
        }
        Err(Error::new("<stdout>", "is a terminal, and the bytes of a block are not text")
            .with_help("`--out FILE` writes a file, `--hex` a dump to read"))
    }

    /// Writes a product that is no text to stdout, past whatever handles colours.
    pub fn bytes(&self, bytes: &[u8]) -> Result<(), Failure> {
        open()?;
        self.finish()?;
        let mut stdout = io::stdout().lock();
        let written = stdout.write_all(bytes).and_then(|()| stdout.flush());
        written.map_err(|cause| stdout_failure(&cause))
    }

    /// Sees to it that all of the product has gone out.
    pub fn finish(&self) -> Result<(), Failure> {
        self.wipe_progress();
        self.stdout.borrow_mut().flush().map_err(|cause| stdout_failure(&cause))
    }

    /// How findings are turned into text.
    pub fn style(&self, form: FindingForm) -> FindingStyle {
        FindingStyle { form, paint: self.finding_paint, quiet: self.quiet }
    }

    /// Writes findings to stderr. Nobody can be told when that fails.
    pub fn report(&self, text: &str) {
        if !text.is_empty() {
            self.wipe_progress();
            let _ = anstream::stderr().write_all(text.as_bytes());
        }
    }

    /// Writes what else there is to know to stderr, unless quiet.
    pub fn notes(&self, text: &str) {
        if !self.quiet {
            self.report(&escape::output(text, Styles::Shown));
        }
    }

    /// Writes why the whole run stopped.
    pub fn failure(&self, error: Error) {
        let found = Diagnostic { code: Code::Output, ..error.into() };
        self.report(&self.style(FindingForm::Human).text(&[found], &Files::default()));
    }

    /// Whether only errors are wanted.
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Whether anybody would see progress.
    pub fn shows_progress(&self) -> bool {
        !self.quiet && io::stderr().is_terminal() && !io::stdout().is_terminal()
    }

    #[cfg(feature = "exec")]
    /// Whether anybody would see progress before the product, which may go to the same terminal.
    pub fn shows_progress_first(&self) -> bool {
        !self.quiet && io::stderr().is_terminal()
    }

    /// Writes a line of progress over the last one.
    pub fn progress(&self, text: &str) {
        *self.progress.borrow_mut() = true;
        let _ = write!(io::stderr(), "\r{}\x1b[K", escape::name(text));
    }

    fn wipe_progress(&self) {
        if self.progress.replace(false) {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}

/// Whether there is a stdout for a product to go to.
fn open() -> Result<(), Failure> {
    if !stdout::was_closed() {
        return Ok(());
    }
    let error = Error::new("<stdout>", "is closed, so that the output would be lost");
    Err(error.with_help("send it to a file, or to /dev/null where nobody wants it").into())
}

fn stdout_failure(cause: &io::Error) -> Failure {
    if cause.kind() == io::ErrorKind::BrokenPipe {
        return Failure::BrokenPipe;
    }
    Failure::Error(Error::new(
        "<stdout>",
        format!("cannot be written: {}", landfall_layout::file::reason(cause)),
    ))
}
