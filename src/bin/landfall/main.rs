//! The command line: arguments in, one command run, an exit code out.
//!
//! 0 is clean, 1 is findings, 2 is "could not": wrong usage, a file that cannot be read or
//! written, an error in a shader; 130 is a command that was interrupted and printed what it had.
//! Products go to stdout, findings to stderr.

mod args;
#[cfg(feature = "exec")]
mod bench;
mod check;
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
mod given;
mod inputs;
#[cfg(feature = "exec")]
mod interrupt;
mod layout;
mod lights;
mod lock;
mod merge;
#[cfg(not(feature = "exec"))]
mod missing;
mod output;
mod port;
mod read;
#[cfg(any(feature = "gl", feature = "gpu"))]
mod reader;
#[cfg(feature = "exec")]
mod readers;
#[cfg(feature = "exec")]
mod render;
mod rule;
#[cfg(feature = "exec")]
mod run;
mod schema;
mod shader;
mod stdout;
#[cfg(feature = "exec")]
mod stress;
#[cfg(feature = "exec")]
mod verify;
mod work;
mod write;

use std::process::ExitCode;

use args::{Args, Command};
use clap::Parser;
use output::{Failure, Streams};

fn main() -> ExitCode {
    let args = Args::parse();
    let streams = Streams::new(args.color, args.quiet);
    given::begin(&args.command, &streams);
    let done = match &args.command {
        Command::Layout(args) => layout::run(args, &streams),
        Command::Explain(args) => explain::run(args, &streams),
        Command::Emit(args) => emit::run(args, &streams),
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
        Command::Render(args) => render::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Bench(args) => bench::run(args, &streams),
        #[cfg(not(feature = "exec"))]
        Command::Verify(_)
        | Command::Run(_)
        | Command::Stress(_)
        | Command::Render(_)
        | Command::Bench(_)
        | Command::Devices(_) => missing::run(&args.command),
        Command::Lights(args) => lights::run(args, &streams),
        #[cfg(feature = "exec")]
        Command::Devices(args) => devices::run(args, &streams),
        Command::Lock(args) => lock::run(args, &streams),
        Command::Diff(args) => diff::run(args, &streams),
        Command::Check(args) => check::run(args, &streams),
        Command::Merge(args) => merge::run(args, &streams),
        Command::Rule(args) => rule::run(args, &streams),
        Command::Schema(args) => schema::run(args, &streams),
        #[cfg(any(feature = "gl", feature = "gpu"))]
        Command::Reader(args) => reader::run(args),
    };
    match done.and_then(|outcome| streams.finish().map(|()| outcome)) {
        Ok(outcome) => {
            given::finish(&streams);
            outcome.into()
        }
        // Whoever read the output has seen enough.
        Err(Failure::BrokenPipe) => ExitCode::SUCCESS,
        Err(Failure::Error(error)) => {
            streams.failure(error);
            output::Outcome::CouldNot.into()
        }
    }
}
