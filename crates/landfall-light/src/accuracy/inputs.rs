//! The inputs of a function by role, their domain, and the sampler of both.
//!
//! Derived from a [`PureFunction`]; [`stress`](super::stress) searches them for failures,
//! [`bench`](mod@super::bench) takes ordinary ones.

pub(super) mod comments;
pub mod distribution;
pub mod domain;
pub(super) mod input;
pub(super) mod matched;
pub(super) mod random;
pub mod role;
pub(super) mod sampler;
pub(super) mod scene;

use landfall_layout::diagnostic::Code;
use serde_json::Value;

pub(super) use input::Inputs;
pub use input::{Input, Sample};

use domain::{Domain, Refused};
use landfall_exec::harness::call::pure::PureFunction;
use landfall_layout::Diagnostic;
use landfall_layout::source::Source;

/// Returns the domain of a function's inputs: from comments of its shader, then from JSON.
pub(super) fn domain(
    source: &Source,
    pure: &PureFunction,
    inputs: &[Input],
    json: Option<&Value>,
) -> Result<Domain, Diagnostic> {
    let mut domain = Domain::any(inputs);
    let name = pure.shown.split('(').next().unwrap_or_default().to_string();
    for file in pure.files.iter() {
        comments::add(&mut domain, &file.text, &name, inputs)
            .map_err(|refused| bad(refused, &source.path))?;
    }
    if let Some(json) = json {
        domain.add_json(json, inputs).map_err(|refused| bad(refused, "--domain"))?;
    }
    Ok(domain)
}

fn bad(refused: Refused, about: &str) -> Diagnostic {
    Diagnostic::about(Code::BadDomain, refused.message, refused.help, about)
}

/// Transposes samples to columns, one for each scalar.
pub(super) fn columns(samples: &[Sample]) -> Vec<Vec<u64>> {
    let scalars = samples.first().map_or(0, Vec::len);
    (0..scalars).map(|at| samples.iter().map(|sample| sample[at]).collect()).collect()
}
