//! `landfall lsp`: the server of the Language Server Protocol.

use landfall_layout::Error;
use landfall_layout::file::reason;
use landfall_lsp::CommandTexts;
#[cfg(feature = "analysis")]
use landfall_lsp::{FunctionLights, FunctionQuery};

use crate::args::LspArgs;
use crate::check::page;
use crate::output::{CommandFailure, Outcome};

/// Answers an editor until it leaves; an end without `shutdown` is a failure, as the protocol wants.
pub fn run(_: &LspArgs) -> Result<Outcome, CommandFailure> {
    let texts = CommandTexts {
        page: |check, pass, findings, texts, at| {
            page::page("Landfall report", check, pass, findings, texts, at)
        },
        #[cfg(feature = "analysis")]
        lights: Some(lights),
        #[cfg(not(feature = "analysis"))]
        lights: None,
    };
    match landfall_lsp::serve(texts) {
        Ok(true) => Ok(Outcome::Clean),
        Ok(false) => Ok(Outcome::Findings),
        Err(cause) => {
            Err(Error::new("lsp", format!("cannot be started: {}", reason(&cause))).into())
        }
    }
}

/// What `landfall lights` says of one function.
#[cfg(feature = "analysis")]
fn lights(query: &FunctionQuery<'_>) -> FunctionLights {
    use landfall::report::lights as print;
    use landfall::report::lights::cost::{bounds, cost};
    use landfall_ir::analysis::roles::Form;
    use landfall_layout::format::Paint;

    let report = cost(query.source, query.options, query.shader);
    let inside: Vec<_> = report.accesses.iter().filter(|one| (query.holds)(one.span)).collect();
    let mut read = Vec::new();
    for (number, mut light) in report.lights.into_iter().enumerate() {
        light.bounds = bounds(number, inside.iter().copied());
        let is_read = !light.bounds.is_empty()
            || match light.form {
                Form::Structure => {
                    let is_named =
                        !light.structure.is_empty() && (query.reads)("", &light.structure);
                    is_named || (query.reads)(&light.block, &light.path)
                }
                Form::Block | Form::Members => {
                    light.members.iter().any(|part| (query.reads)(&light.block, &part.path))
                }
            };
        if is_read {
            read.push(light);
        }
    }
    let hazards = report.hazards.into_iter().filter(|hazard| (query.holds)(hazard.span));
    FunctionLights {
        text: match read.as_slice() {
            [] => String::new(),
            read => print::lights(read, Paint::Plain),
        },
        hazards: hazards.map(|hazard| hazard.finding).collect(),
        unfollowed: report.unfollowed.first().map(|why| why.message.clone()),
    }
}
