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
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub(super) use input::Inputs;
pub use input::{Input, Sample};

use domain::{Domain, DomainError};
use landfall_exec::harness::call::pure::PureFunction;
use landfall_layout::Diagnostic;
use landfall_layout::source::Source;

/// An input of a function and its distribution.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DistributedInput {
    /// The path: `light.position`.
    pub path: String,
    /// Its distribution, in words: `uniform in 0..1`.
    pub distribution: String,
}

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
    // After the comments, so that JSON replaces what they state.
    if let Some(json) = json {
        domain.add_json(json, inputs).map_err(|refused| bad(refused, "--domain"))?;
    }
    Ok(domain)
}

/// Returns the distribution of each input, in words.
pub(super) fn distributions(inputs: &[Input], domain: &Domain) -> Vec<DistributedInput> {
    let of = |(at, input): (usize, &Input)| DistributedInput {
        path: input.path.clone(),
        distribution: domain
            .distribution_text(at, input)
            .unwrap_or_else(|| "as in scenes".to_string()),
    };
    inputs.iter().enumerate().map(of).collect()
}

fn bad(refused: DomainError, about: &str) -> Diagnostic {
    Diagnostic::about(Code::BadDomain, refused.message, refused.help, about)
}

/// Returns a sample and two others for each of its floats: those with the next `f32` above and
/// below, or the sample itself where that is not finite.
pub(super) fn neighbours(sample: &Sample, inputs: &Inputs) -> Vec<Sample> {
    let moved = |at: usize| {
        [1, u32::MAX].map(|by| {
            let mut moved = sample.clone();
            let bits = (sample[at] as u32).wrapping_add(by);
            if f32::from_bits(bits).is_finite() {
                moved[at] = u64::from(bits);
            }
            moved
        })
    };
    std::iter::once(sample.clone()).chain(inputs.float_scalars().flat_map(moved)).collect()
}

/// Transposes samples to columns, one for each scalar.
pub(super) fn columns(samples: &[Sample]) -> Vec<Vec<u64>> {
    let scalars = samples.first().map_or(0, Vec::len);
    (0..scalars).map(|at| samples.iter().map(|sample| sample[at]).collect()).collect()
}
