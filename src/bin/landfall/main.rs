//! The `landfall` command: parses the arguments, runs one command, returns an exit code.
//!
//! Exit codes: 0: no findings; 1: findings; 2: failure, such as wrong usage, a file that cannot be
//! read or written, an error in a shader, or an exceeded budget; 130: interrupted after printing
//! the results so far.
//! Results go to stdout, findings to stderr.

mod args;
#[cfg(feature = "exec")]
mod backends;
#[cfg(feature = "exec")]
mod bench;
#[cfg(feature = "exec")]
mod browser;
mod check;
mod child;
#[cfg(feature = "completions")]
mod completions;
mod config;
#[cfg(feature = "exec")]
mod data;
mod decode;
#[cfg(feature = "exec")]
mod devices;
mod diff;
mod emit;
mod encode;
mod explain;
mod fit;
mod git;
mod init;
mod layout;
#[cfg(feature = "analysis")]
mod lights;
mod lock;
#[cfg(feature = "lsp")]
mod lsp;
#[cfg(not(all(
    feature = "exec",
    feature = "completions",
    feature = "lsp",
    feature = "port",
    feature = "serve"
)))]
mod missing;
mod output;
mod overview;
#[cfg(feature = "port")]
mod port;
#[cfg(feature = "exec")]
mod prove;
mod read;
#[cfg(feature = "exec")]
mod render;
mod report;
mod rule;
#[cfg(feature = "exec")]
mod run;
mod schema;
#[cfg(feature = "serve")]
mod serve;
#[cfg(any(feature = "gl", feature = "gpu"))]
mod serve_backend;
mod shader;
mod stdout;
#[cfg(feature = "exec")]
mod stress;
mod templates;
#[cfg(feature = "exec")]
mod verify;
mod watch;
mod without_effect;
mod write;

use std::panic::resume_unwind;
use std::process::ExitCode;

use landfall_ir::stack::{StackError, on_a_large_stack};

use args::{Args, Command};
use output::{CommandFailure, Streams};

/// In place of musl's, whose one lock makes threads wait for one another.
#[cfg(target_env = "musl")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

// Lowering follows the nesting of code by recursion, so commands that lower run on a large stack.
fn main() -> ExitCode {
    if std::env::args_os().len() == 1 {
        // Lints may follow code that nests deeply.
        let printed = on_a_large_stack(overview::run).unwrap_or_else(|_| overview::run());
        if let Some(outcome) = printed {
            return outcome.into();
        }
    }
    let args = args::parse();
    if !args.command.lowers() {
        return run(&args);
    }
    match on_a_large_stack(|| run(&args)) {
        Ok(code) => code,
        // Each shader is then lowered on a thread of its own, which may find memory.
        Err(StackError::Memory) => run(&args),
        Err(StackError::Panic(panic)) => resume_unwind(panic),
    }
}

fn run(args: &Args) -> ExitCode {
    let streams = Streams::new(args.global.color, args.global.quiet);
    // Before anything is read: the limits of time and memory include the reading.
    watch::begin(&args.command, &args.global.budget, &streams);
    without_effect::begin(&args.command, &streams);
    let done = match &args.command {
        Command::Layout(args) => layout::run(args, &streams),
        Command::Explain(args) => explain::run(args, &streams),
        Command::Report(args) => report::run(args, &streams),
        #[cfg(feature = "serve")]
        Command::Serve(args) => serve::run(args, &streams),
        #[cfg(feature = "lsp")]
        Command::Lsp(args) => lsp::run(args),
        Command::Emit(args) => emit::run(args, &streams),
        #[cfg(feature = "port")]
        Command::Port(args) => port::run(args, &streams),
        Command::Encode(args) => encode::run(args, &streams),
        Command::Decode(args) => decode::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Verify(args) => verify::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Run(args) => run::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Stress(args) => stress::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Prove(args) => prove::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Render(args) => render::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Bench(args) => bench::run(args, &streams),
        #[cfg(feature = "analysis")]
        Command::Lights(args) => lights::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Devices(args) => devices::run(args, &streams),
        Command::Lock(args) => lock::run(args, &streams),
        Command::Diff(args) => diff::run(args, &streams),
        Command::Check(args) => check::run(args, &streams),
        Command::Init(args) => init::run(args, &streams),
        Command::Rule(args) => rule::run(args, &streams),
        Command::Schema(args) => schema::run(args, &streams),
        #[cfg(feature = "completions")]
        Command::Completions(args) => completions::run(args, &streams),
        #[cfg(feature = "completions")]
        Command::Man(args) => completions::man(args),
        #[cfg(any(feature = "gl", feature = "gpu"))]
        Command::Reader(args) => serve_backend::run(args),
        #[cfg(not(all(
            feature = "exec",
            feature = "completions",
            feature = "lsp",
            feature = "port",
            feature = "serve"
        )))]
        command => missing::run(command),
    };
    let done = done.or_else(|failure| match failure {
        // They are as much a result as those of a command that has one.
        CommandFailure::Findings(text) => {
            streams.report(&text);
            Ok(output::Outcome::CouldNot)
        }
        CommandFailure::Error(error) => Err(error),
    });
    // What was printed before an error is not lost. Output that could not be written fails the
    // command, even if its work was done.
    let finished = streams.finish();
    let done = done.and_then(|outcome| finished.map(|()| outcome));
    // From here no interrupt ends the process, so that its outcome is printed once.
    watch::hold_end();
    match done {
        // A command that watches files ends with the outcome of its last check.
        Ok(outcome) if watch::is_stopped() && watch::last_outcome().is_some() => {
            watch::last_outcome().unwrap_or(outcome).into()
        }
        // Its inputs after the interrupt were not read.
        Ok(_) if watch::is_stopped() => {
            streams.notes("interrupted: these are the results so far\n");
            output::Outcome::Interrupted.into()
        }
        Ok(outcome) => {
            // Only of a run that was finished is it known which options had no effect.
            without_effect::finish(&streams);
            outcome.into()
        }
        Err(error) => {
            streams.failure(error.into());
            output::Outcome::CouldNot.into()
        }
    }
}
