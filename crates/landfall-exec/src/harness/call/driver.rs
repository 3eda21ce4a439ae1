//! Runs a call on a driver: the function in the form of [`kernel`](super::kernel), over one lane.
//!
//! The interpreter needs no such form.

use super::Request;
use super::find::{Target, spelled_signature};
use super::kernel;
use super::kernel::KernelResult;
use super::pure::{CallPurpose, Origin, PureFunction, PureRequest};
use crate::backend::{Backend, Failure};
use landfall_interp::Floats;
use landfall_layout::Options;
use landfall_layout::source::Source;

/// The words that a driver returned.
#[derive(Clone, Debug, Default)]
pub(super) struct DriverWords {
    pub result: Vec<u64>,
    /// By parameter; empty for those that are not returned.
    pub parameters: Vec<Vec<u64>>,
    /// By written global variable.
    pub written: Vec<Vec<u64>>,
}

pub(super) fn run(
    source: &Source,
    options: &Options,
    request: &Request,
    found: &Target<'_>,
    backend: &mut dyn Backend,
) -> Result<DriverWords, Failure> {
    let wanted = PureRequest {
        function: spelled_signature(found.info),
        data: request.data.clone(),
        textures: request.textures.clone(),
        // A driver computes as the shader is written.
        floats: Floats::AsWritten,
    };
    let pure = PureFunction::prepare(source, options, &wanted, CallPurpose::Call)
        .map_err(|refusal| kernel::refused(refusal.found.first()))?;
    let mut columns: Vec<Vec<u64>> = Vec::new();
    for parameter in &pure.parameters {
        let zeros = || vec![vec![0]; parameter.scalars.len()];
        columns.extend(match &parameter.origin {
            Origin::Argument(at) => found.arguments.get(*at).cloned().unwrap_or_else(zeros),
            Origin::Input => request
                .input(&parameter.path, &parameter.ty, source.language)
                .map_err(|found| Failure::refused(found.message, ""))?
                .unwrap_or_else(zeros),
            // Blocks with given values stay buffers.
            Origin::Block(..) => zeros(),
        });
    }
    let driven = pure.on(backend.device())?;
    let KernelResult { results, .. } = driven.call(backend, &columns, 1, request.limit)?;
    let mut answered = DriverWords {
        result: Vec::new(),
        parameters: vec![Vec::new(); found.signature.parameters.len()],
        written: Vec::new(),
    };
    for (result, words) in pure.results.iter().zip(results) {
        let words = words.into_iter().map(|lanes| lanes[0]).collect();
        // `at` counts the caller's parameters: the inputs of the stage, then the arguments, then
        // the written variables.
        match result.at.map(|at| at.checked_sub(pure.inputs.len())) {
            None => answered.result = words,
            Some(at) => match at.and_then(|at| answered.parameters.get_mut(at)) {
                Some(own) => *own = words,
                None => answered.written.push(words),
            },
        }
    }
    Ok(answered)
}
