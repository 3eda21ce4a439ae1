//! `landfall lsp`: the server of the Language Server Protocol.

use landfall_layout::Error;
use landfall_layout::file::reason;

use crate::args::LspArgs;
use crate::output::{Failure, Outcome};

/// Answers an editor until it leaves; an end without `shutdown` is a failure, as the protocol wants.
pub fn run(_: &LspArgs) -> Result<Outcome, Failure> {
    match landfall_lsp::serve() {
        Ok(true) => Ok(Outcome::Clean),
        Ok(false) => Ok(Outcome::Findings),
        Err(cause) => Err(Error::new("lsp", format!("cannot be started: {}", reason(&cause)))),
    }
}
