//! `landfall reader`: the process that has a driver, for another `landfall` or a program
//! that uses the library. Not for people.

use landfall_exec::backend::subprocess::{Behind, serve};
use landfall_layout::Error;

use crate::args::{ReaderArgs, ReaderDriver};
use crate::output::{Failure, Outcome};

pub fn run(args: &ReaderArgs) -> Result<Outcome, Failure> {
    let behind = match args.driver {
        ReaderDriver::Gl => Behind::Gl,
        ReaderDriver::Gpu => Behind::Gpu(args.adapter.clone()),
    };
    // Whoever asked is gone, and a driver may be stuck: there is nobody to tell.
    let alone = || std::process::exit(0);
    serve(&behind, alone).map_err(|cause| Error::new("<stdin>", cause.to_string()))?;
    Ok(Outcome::Clean)
}
