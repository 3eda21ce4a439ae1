//! `landfall report`: the layouts and findings of shaders as one HTML page.
//!
//! The findings are those of `check`, whose page this is.

use crate::args::ReportArgs;
use crate::check;
use crate::output::{CommandFailure, Outcome, Streams};

// The page is one of the formats of `check`.
pub fn run(args: &ReportArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    Ok(match check::run(&args.check(), streams)? {
        // They are in the report.
        Outcome::Findings => Outcome::Clean,
        outcome => outcome,
    })
}
