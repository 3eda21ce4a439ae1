//! The output streams: results on stdout, findings and progress on stderr.

use landfall_layout::diagnostic::Code;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use anstream::{AutoStream, ColorChoice};
use landfall_layout::error::ErrorKind;
use landfall_layout::format as emit;
use landfall_layout::format::Paint;
use landfall_layout::source::Files;
use landfall_layout::text::escape;
use landfall_layout::text::escape::Styles;
use landfall_layout::{Diagnostic, Error, Severity};
use terminal_size::terminal_size_of;

use crate::args::Color;
use crate::fit;
use crate::stdout;

/// The outcome of a command, which determines its exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Clean,
    /// Findings: an outdated generated file, suspicious bytes, changed layouts.
    Findings,
    CouldNot,
    /// Interrupted by Ctrl-C; partial results were printed.
    Interrupted,
}

/// The exit code of an interrupted command: 128 plus the number of SIGINT, as without a handler.
pub const INTERRUPTED: u8 = 130;

impl Outcome {
    pub fn code(self) -> u8 {
        match self {
            Outcome::Clean => 0,
            Outcome::Findings => 1,
            Outcome::CouldNot => 2,
            Outcome::Interrupted => INTERRUPTED,
        }
    }
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> ExitCode {
        ExitCode::from(outcome.code())
    }
}

/// Why a command has no result.
#[derive(Debug)]
pub enum CommandFailure {
    /// An error, told as text whatever the format is.
    Error(Error),
    /// Findings in the form of the command.
    Findings(String),
}

impl From<Error> for CommandFailure {
    fn from(error: Error) -> CommandFailure {
        CommandFailure::Error(error)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FindingForm {
    Human,
    Json,
}

impl FindingForm {
    /// The form of the findings of a command, by whether its format is JSON.
    pub fn json_if(is_json: bool) -> FindingForm {
        if is_json { FindingForm::Json } else { FindingForm::Human }
    }
}

/// Formats findings; independent of streams, so usable from any thread.
#[derive(Clone, Copy, Debug)]
pub struct FindingStyle {
    form: FindingForm,
    paint: Paint,
    quiet: bool,
}

impl FindingStyle {
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Formats the findings of one shader; omits warnings when quiet.
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

    /// Formats a finding about no text.
    pub fn one(&self, found: Diagnostic) -> String {
        self.text(&[found], &Files::default())
    }

    /// The failure of a command that has no result because of these findings.
    pub fn failure(&self, found: &[Diagnostic], files: &Files) -> CommandFailure {
        CommandFailure::Findings(self.text(found, files))
    }

    /// The failure because of one finding about no text.
    pub fn refused(&self, found: Diagnostic) -> CommandFailure {
        CommandFailure::Findings(self.one(found))
    }

    /// The failure because of files and arguments that make up a request, in the form of the command.
    #[cfg(feature = "exec")]
    pub fn request(&self, failure: impl Into<CommandFailure>) -> CommandFailure {
        match failure.into() {
            CommandFailure::Error(error) => {
                let code = match error.kind {
                    ErrorKind::Unreadable => Code::UnreadableFile,
                    _ => Code::BadRequest,
                };
                self.refused(Diagnostic { code, ..error.into() })
            }
            told @ CommandFailure::Findings(_) => told,
        }
    }
}

/// Buffered stdout.
pub type Output = Mutex<BufWriter<Box<dyn Write + Send>>>;

/// A command that ends sooner shows no progress.
const FIRST_PROGRESS: Duration = Duration::from_millis(500);

const BETWEEN_PROGRESS: Duration = Duration::from_millis(100);

pub struct Streams {
    stdout: Arc<Output>,
    /// Colours of text on stdout.
    pub paint: Paint,
    /// Colours of findings on stderr.
    pub finding_paint: Paint,
    quiet: bool,
    /// Whether the reader of stdout closed it, as `head` does: the rest of the output is
    /// dropped, and the exit code is that of the whole.
    unread: AtomicBool,
    /// Whether the last line of stderr is a progress line, which other output must erase.
    progress: AtomicBool,
    /// When the next progress line may be shown.
    next_progress: Mutex<Instant>,
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
        // Stdout and stderr are decided separately: one may be a file and the other a terminal.
        let (to_stdout, to_stderr) =
            (AutoStream::choice(&stdout), AutoStream::choice(&io::stderr()));
        let stdout: Box<dyn Write + Send> = match paint(to_stdout) {
            // Plain text needs no filter.
            Paint::Plain => Box::new(stdout),
            Paint::Ansi => Box::new(AutoStream::new(stdout, to_stdout)),
        };
        Streams {
            stdout: Arc::new(Mutex::new(BufWriter::with_capacity(1 << 16, stdout))),
            paint: paint(to_stdout),
            finding_paint: paint(to_stderr),
            quiet,
            unread: AtomicBool::new(false),
            progress: AtomicBool::new(false),
            next_progress: Mutex::new(Instant::now() + FIRST_PROGRESS),
        }
    }

    pub fn for_thread(&self) -> Streams {
        Streams {
            stdout: Arc::clone(&self.stdout),
            unread: AtomicBool::new(false),
            // The thread takes over the progress line, and erases it before it writes.
            progress: AtomicBool::new(self.shows_progress()),
            next_progress: Mutex::new(*self.next_progress()),
            ..*self
        }
    }

    /// The buffer of stdout, shared with the watch over the process.
    pub fn output(&self) -> Arc<Output> {
        Arc::clone(&self.stdout)
    }

    fn buffer(&self) -> MutexGuard<'_, BufWriter<Box<dyn Write + Send>>> {
        self.stdout.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes text to stdout, with control characters escaped for terminals and logs.
    pub fn product(&self, text: &str) -> Result<(), Error> {
        let text = escape::output(text, self.paint.styles());
        self.exactly(&fit::to_terminal(&text, terminal_size_of(io::stdout())))
    }

    pub fn json(&self, text: &str) -> Result<(), Error> {
        self.exactly(&escape::json(text))
    }

    /// Writes code or a patch to stdout: unchanged for a program, escaped for a terminal and for
    /// the log of a GitHub step.
    pub fn source(&self, text: &str) -> Result<(), Error> {
        let is_log = || {
            let is_file = std::fs::metadata("/dev/stdout").is_ok_and(|found| found.is_file());
            std::env::var_os("GITHUB_ACTIONS").is_some() && !is_file
        };
        match io::stdout().is_terminal() || is_log() {
            true => self.product(text),
            false => self.exactly(text),
        }
    }

    /// Writes machine-readable text to stdout unchanged.
    pub fn exactly(&self, text: &str) -> Result<(), Error> {
        if text.is_empty() {
            return Ok(());
        }
        self.written(|| self.buffer().write_all(text.as_bytes()))
    }

    /// Streams output to stdout unchanged; names in it come from layouts and are escaped.
    pub fn product_of(
        &self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Error> {
        self.written(|| write(&mut *self.buffer()))
    }

    /// Writes to stdout, unless its reader is gone.
    fn written(&self, write: impl FnOnce() -> io::Result<()>) -> Result<(), Error> {
        open()?;
        if self.unread.load(Ordering::Relaxed) {
            return Ok(());
        }
        match write() {
            // The rest is dropped without an error: the reader has what it wanted.
            Err(cause) if cause.kind() == io::ErrorKind::BrokenPipe => {
                self.unread.store(true, Ordering::Relaxed);
                Ok(())
            }
            done => done.map_err(|cause| stdout_failure(&cause)),
        }
    }

    /// Checks that stdout can take binary data.
    ///
    /// # Errors
    ///
    /// Stdout is a terminal.
    pub fn takes_bytes(&self) -> Result<(), Error> {
        if !io::stdout().is_terminal() {
            return Ok(());
        }
        Err(Error::unwritten("<stdout>", "is a terminal, and the bytes of a block are not text")
            .with_help("write a file with `--out FILE`, or print a dump with `--hex`"))
    }

    /// Writes binary data to stdout, past the handling of colours.
    pub fn bytes(&self, bytes: &[u8]) -> Result<(), Error> {
        // What is in the buffer is older, and goes first.
        self.finish()?;
        self.written(|| {
            let mut stdout = io::stdout().lock();
            stdout.write_all(bytes).and_then(|()| stdout.flush())
        })
    }

    /// Whether the reader of stdout closed it.
    pub fn is_unread(&self) -> bool {
        self.unread.load(Ordering::Relaxed)
    }

    /// Clears the terminal, if stdout is one.
    pub fn clear(&self) {
        if io::stdout().is_terminal() {
            let _ = self.exactly("\x1b[2J\x1b[H").and_then(|()| self.finish());
        }
    }

    pub fn finish(&self) -> Result<(), Error> {
        self.wipe_progress();
        // What was to be printed to a closed stdout failed before.
        if stdout::was_closed() { Ok(()) } else { self.written(|| self.buffer().flush()) }
    }

    pub fn style(&self, form: FindingForm) -> FindingStyle {
        FindingStyle { form, paint: self.finding_paint, quiet: self.quiet }
    }

    /// Writes findings to stderr; failures are ignored.
    pub fn report(&self, text: &str) {
        if !text.is_empty() {
            self.wipe_progress();
            let text = fit::to_terminal(text, terminal_size_of(io::stderr()));
            let _ = anstream::stderr().write_all(text.as_bytes());
        }
    }

    /// Writes notes to stderr, unless quiet.
    pub fn notes(&self, text: &str) {
        if !self.quiet {
            self.report(&escape::output(text, Styles::Shown));
        }
    }

    /// Reports why a command has no result.
    pub fn failure(&self, failure: CommandFailure) {
        let error = match failure {
            CommandFailure::Findings(text) => return self.report(&text),
            CommandFailure::Error(error) => error,
        };
        let code = match error.kind {
            ErrorKind::Unreadable => Code::UnreadableFile,
            ErrorKind::Template => Code::OtherLanguage,
            ErrorKind::Unwritten => Code::CannotWrite,
            _ => Code::CannotRun,
        };
        self.finding(Diagnostic { code, ..error.into() });
    }

    /// Reports a finding as text.
    pub fn finding(&self, found: Diagnostic) {
        self.report(&self.style(FindingForm::Human).one(found));
    }

    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Whether notes go to a terminal.
    pub fn is_terminal(&self) -> bool {
        io::stderr().is_terminal()
    }

    /// Whether to show progress while stdout is redirected.
    pub fn shows_progress(&self) -> bool {
        // Otherwise the results on the same terminal are the progress.
        !self.quiet && io::stderr().is_terminal() && !io::stdout().is_terminal()
    }

    /// Whether to show progress before any result, which may go to the same terminal.
    #[cfg(feature = "exec")]
    pub fn shows_progress_first(&self) -> bool {
        !self.quiet && io::stderr().is_terminal()
    }

    /// Replaces the progress line, unless it is too early for another.
    pub fn progress(&self, text: &str) {
        let mut next = self.next_progress();
        // The caller does not count time, and calls this for every file.
        if Instant::now() < *next {
            return;
        }
        *next = Instant::now() + BETWEEN_PROGRESS;
        self.progress.store(true, Ordering::Relaxed);
        let _ = write!(io::stderr(), "\r{}\x1b[K", escape::name(text));
    }

    fn next_progress(&self) -> MutexGuard<'_, Instant> {
        self.next_progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wipe_progress(&self) {
        if self.progress.swap(false, Ordering::Relaxed) {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}

/// Fails if stdout was closed when the process began.
fn open() -> Result<(), Error> {
    if !stdout::was_closed() {
        return Ok(());
    }
    let error = Error::unwritten("<stdout>", "is closed: the output would be lost");
    Err(error.with_help("redirect it to a file, or to /dev/null to discard it"))
}

fn stdout_failure(cause: &io::Error) -> Error {
    let message = format!("cannot be written: {}", landfall_layout::file::reason(cause));
    Error::unwritten("<stdout>", message)
}
