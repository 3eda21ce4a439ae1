//! Ends the process from outside its work: on Ctrl-C, and past the budget of time and memory.
//!
//! A thread polls the interrupt flag, the clock and the memory of the process. Commands that
//! process many files stop after the current one; others are ended where they are. Either way
//! unfinished files are removed and finished output is printed.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use landfall_check::stop::StopFlag;
use landfall_layout::diagnostic::Code;
use landfall_layout::file::{remove_directory, remove_partial};
use landfall_layout::{Diagnostic, Error};
use signal_hook::consts::SIGINT;
use signal_hook::{flag, low_level};

use crate::args::{BudgetArgs, Command};
use crate::output::{FindingForm, FindingStyle, INTERRUPTED, Outcome, Output, Streams};

/// Time between two polls.
const INTERVAL: Duration = Duration::from_millis(20);

/// Polls between two readings of the memory.
const MEMORY_EVERY: u32 = 3;

/// Time that a command has to end on its own after Ctrl-C.
const PATIENCE: Duration = Duration::from_millis(300);

/// Processor time that `stress` and `prove` have to report what they found after Ctrl-C.
#[cfg(feature = "exec")]
const REPORT_PATIENCE: Duration = Duration::from_millis(400);

/// Time that `check` has to end on its own after Ctrl-C, before its findings so far are printed.
const CHECK_PATIENCE: Duration = Duration::from_millis(150);

/// Time that the report of a command in the middle of its work may take.
const PARTIAL_REPORT: Duration = Duration::from_millis(200);

/// Time that the output collected so far has to reach its reader.
const FLUSH: Duration = Duration::from_millis(100);

/// Budget of time without `--max-time`; `stress` has twice its `--time` if that is longer.
const TIME: Duration = Duration::from_secs(3600);

/// Set by the first Ctrl-C; the second ends the process at once.
static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// The exit code of an interrupted command that watches files: that of its last check.
static LAST: Mutex<Option<Outcome>> = Mutex::new(None);

/// Directories to remove when the process is ended.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The process groups of the programs that run.
static GROUPS: Mutex<Vec<u32>> = Mutex::new(Vec::new());

/// Prints what a command has found so far.
type PartialReport = Box<dyn FnOnce() + Send>;

/// The report to print if the process is ended in the middle of its work.
static PARTIAL: Mutex<Option<PartialReport>> = Mutex::new(None);

/// Locked once and for all by the thread that ends the process.
static END: Mutex<()> = Mutex::new(());

/// Waits forever if another thread is ending the process; from then on only this one does.
pub fn hold_end() {
    std::mem::forget(END.lock());
}

fn partial() -> MutexGuard<'static, Option<PartialReport>> {
    PARTIAL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sets the report to print if the process is ended before [`end_of_work`].
pub fn on_end(report: impl FnOnce() + Send + 'static) {
    *partial() = Some(Box::new(report));
}

/// Reverts [`on_end`]; does not return if the report is being printed, as the process then ends.
pub fn end_of_work() {
    // The report is gone: the other thread prints it, and ends the process when it has.
    while partial().take().is_none() {
        thread::park();
    }
}

/// Sets the outcome of the command if it is interrupted from now on.
pub fn end_with(outcome: Outcome) {
    *LAST.lock().unwrap_or_else(PoisonError::into_inner) = Some(outcome);
}

/// The outcome of an interrupted command, as set by [`end_with`].
pub fn last_outcome() -> Option<Outcome> {
    *LAST.lock().unwrap_or_else(PoisonError::into_inner)
}

pub fn flag() -> Arc<AtomicBool> {
    Arc::clone(STOP.get_or_init(Arc::default))
}

/// The interrupt flag, as the engine of `check` takes it.
pub fn stop() -> StopFlag {
    StopFlag(flag())
}

pub fn is_stopped() -> bool {
    STOP.get().is_some_and(|stop| stop.load(Ordering::Relaxed))
}

/// Removes a directory if the process is ended before [`forget`].
pub fn remember(directory: &Path) {
    temporary().push(directory.to_path_buf());
}

/// Reverts [`remember`].
pub fn forget(directory: &Path) {
    temporary().retain(|other| other != directory);
}

/// Starts a program that has a process group of its own, which ends if this process is ended before
/// [`end_group`].
pub fn start(command: &mut process::Command) -> io::Result<process::Child> {
    // Locked from before the start: once the groups are ended, none is added.
    let mut groups = groups();
    let child = command.spawn()?;
    groups.push(child.id());
    Ok(child)
}

/// Ends what runs of a program and what it started; the process itself is not waited for yet, so
/// that its number is not another's.
pub fn end_group(process: u32) {
    let mut groups = groups();
    if let Some(at) = groups.iter().position(|group| *group == process) {
        kill_group(groups.swap_remove(at));
    }
}

fn groups() -> MutexGuard<'static, Vec<u32>> {
    GROUPS.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(unix)]
fn kill_group(process: u32) {
    use rustix::process::{Pid, Signal, kill_process_group};

    if let Some(pid) = i32::try_from(process).ok().and_then(Pid::from_raw) {
        // It may have ended already.
        let _ = kill_process_group(pid, Signal::KILL);
    }
}

#[cfg(not(unix))]
fn kill_group(_: u32) {}

fn temporary() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether a command is watched: not the servers of a driver and of an editor, which end with their
/// clients.
fn watches(command: &Command) -> bool {
    match command {
        #[cfg(any(feature = "gl", feature = "gpu"))]
        Command::Reader(_) => false,
        Command::Lsp(_) => false,
        _ => true,
    }
}

pub fn begin(command: &Command, budget: &BudgetArgs, streams: &Streams) {
    if !watches(command) {
        return;
    }
    let stop = flag();
    // In this order: the second handler checks the flag that the first sets. Without signals,
    // Ctrl-C ends the process.
    if flag::register_conditional_default(SIGINT, Arc::clone(&stop)).is_ok() {
        let _ = flag::register(SIGINT, Arc::clone(&stop));
    }
    // `check --watch` and `serve` run until they are interrupted.
    let usual = match command {
        Command::Check(args) if args.watch => Duration::MAX,
        Command::Serve(_) => Duration::MAX,
        _ => TIME,
    };
    let (own_time, wait): (Duration, fn()) = match command {
        #[cfg(feature = "exec")]
        Command::Stress(args) => (args.time.saturating_mul(2), wait_for_report),
        #[cfg(feature = "exec")]
        Command::Prove(args) => (args.time.saturating_mul(2), wait_for_report),
        Command::Check(_) | Command::Report(_) => {
            (Duration::ZERO, || thread::sleep(CHECK_PATIENCE))
        }
        _ => (Duration::ZERO, || thread::sleep(PATIENCE)),
    };
    // `--max-time` overrides both.
    let mut time = budget.max_time.unwrap_or(usual.max(own_time));
    if let (Command::Serve(_), Some(end)) = (command, budget.max_time) {
        // A server that has run for its time has done its work: it ends as by Ctrl-C.
        let stop = Arc::clone(&stop);
        let wait = move || {
            thread::sleep(end);
            stop.store(true, Ordering::SeqCst);
        };
        if thread::Builder::new().name("end".to_string()).spawn(wait).is_ok() {
            time = Duration::MAX;
        }
    }
    let watch = Watch {
        stop,
        wait,
        time,
        memory: budget.max_memory.saturating_mul(1 << 20),
        style: streams.style(FindingForm::Human),
        output: streams.output(),
    };
    // Without a thread the process runs unwatched; Ctrl-C pressed twice still ends it.
    let _ = thread::Builder::new().name("watch".to_string()).spawn(move || watch.run());
}

/// On a busy machine, what was found takes longer to write.
#[cfg(feature = "exec")]
fn wait_for_report() {
    let since = landfall_exec::processor::Stopwatch::start();
    while since.elapsed() < REPORT_PATIENCE {
        thread::sleep(INTERVAL);
    }
}

struct Watch {
    stop: Arc<AtomicBool>,
    /// Waits until the command had its time to end on its own.
    wait: fn(),
    time: Duration,
    /// In bytes.
    memory: u64,
    style: FindingStyle,
    output: Arc<Output>,
}

impl Watch {
    fn run(&self) {
        let began = Instant::now();
        for look in 1u32.. {
            thread::sleep(INTERVAL);
            if self.stop.load(Ordering::Relaxed) {
                if let Some(outcome) = last_outcome() {
                    hold_end();
                    self.end(outcome.code());
                }
                (self.wait)();
                hold_end();
                let note = match report_partially() {
                    true => "interrupted: these are the results so far, without the last file\n",
                    false => "interrupted: results that were not printed yet are lost\n",
                };
                if !self.style.is_quiet() {
                    let _ = anstream::stderr().write_all(note.as_bytes());
                }
                self.end(INTERRUPTED);
            }
            if began.elapsed() > self.time {
                let seconds = self.time.as_secs_f64();
                let message = format!("took longer than the limit of {seconds} s");
                self.refuse(message, "raise the limit with `--max-time SECONDS`");
            }
            // Reading `/proc` takes longer than the other looks.
            if look.is_multiple_of(MEMORY_EVERY) && memory() > self.memory {
                let message = format!("needs more than the limit of {} MiB", self.memory >> 20);
                self.refuse(message, "raise the limit with `--max-memory MIB`, or use fewer files");
            }
        }
    }

    /// Ends the process because it exceeds its budget.
    fn refuse(&self, message: String, help: &str) {
        let error = Error::new("landfall", message).with_help(help);
        self.fail(Diagnostic { code: Code::TooLarge, ..error.into() });
    }

    fn fail(&self, found: Diagnostic) {
        hold_end();
        report_partially();
        let text = self.style.one(found);
        let mut stderr = anstream::stderr().lock();
        let _ = stderr.write_all(text.as_bytes());
        // Stays locked: no other thread writes anything after the error.
        std::mem::forget(stderr);
        self.end(Outcome::CouldNot.code());
    }

    /// Ends the process: prints the output so far, and removes unfinished files.
    fn end(&self, code: u8) {
        let output = Arc::clone(&self.output);
        let (done, flushed) = mpsc::channel();
        // A reader that does not read would block the flush.
        let flush = move || {
            if let Ok(mut output) = output.try_lock() {
                let _ = output.flush();
                // Nothing is written after the end.
                std::mem::forget(output);
            }
            let _ = done.send(());
        };
        if thread::Builder::new().spawn(flush).is_ok() {
            let _ = flushed.recv_timeout(FLUSH);
        }
        let mut groups = groups();
        groups.drain(..).for_each(kill_group);
        // Stays locked: a thread whose program was ended here waits where it drops the program, so
        // that it reports no error about it.
        std::mem::forget(groups);
        remove_partial();
        for directory in temporary().iter() {
            remove_directory(directory);
        }
        low_level::exit(i32::from(code));
    }
}

/// Prints the report of [`on_end`]; `false` if there is none.
fn report_partially() -> bool {
    let Some(report) = partial().take() else { return false };
    let (done, reported) = mpsc::channel();
    let run = move || {
        report();
        let _ = done.send(());
    };
    let started = thread::Builder::new().spawn(run).is_ok();
    started && reported.recv_timeout(PARTIAL_REPORT).is_ok()
}

/// The memory of this process and of those it started, in bytes; 0 if the system does not report
/// it.
fn memory() -> u64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let children = tasks
        .filter_map(|task| std::fs::read_to_string(task.path().join("children")).ok())
        .flat_map(|all| all.split_whitespace().map(memory_of).collect::<Vec<_>>());
    memory_of("self").saturating_add(children.fold(0, u64::saturating_add))
}

/// The memory of a process in bytes (`VmRSS`).
fn memory_of(process: &str) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kib.unwrap_or(0).saturating_mul(1024)
}
