//! A call by a driver: the function in the form [`driven`](super::driven) gives it, over one lane.
//!
//! The evaluator needs none of it.

use super::Request;
use super::arguments::words;
use super::driven;
use super::driven::DrivenCalled;
use super::find::{Found, shown};
use super::pure::{Asks, Origin, Pure, PureRequest};
use crate::backend::{Failure, Reader};
use crate::interp::Floats;
use landfall_layout::source::Source;
use landfall_layout::{Diagnostic, Options};

/// The words that came back.
#[derive(Clone, Debug, Default)]
pub(super) struct Answered {
    pub result: Vec<u64>,
    /// By parameter; of one that is not returned, nothing.
    pub parameters: Vec<Vec<u64>>,
}

/// Has a driver call the function.
pub(super) fn run(
    source: &Source,
    options: &Options,
    request: &Request,
    found: &Found<'_>,
    reader: &mut dyn Reader,
) -> Result<Answered, Failure> {
    let wanted = PureRequest {
        function: shown(found.info),
        data: request.data.clone(),
        textures: request.textures.clone(),
        floats: Floats::AsWritten,
    };
    let pure = Pure::asked(source, options, &wanted, Asks::Call)
        .map_err(|refusal| driven::refused(refusal.found.first()))?;
    let mut columns: Vec<Vec<u64>> = Vec::new();
    for parameter in &pure.parameters {
        let zeros = || vec![vec![0]; parameter.scalars.len()];
        columns.extend(match &parameter.origin {
            Origin::Argument(at) => found.arguments.get(*at).cloned().unwrap_or_else(zeros),
            Origin::Input => input(source, request, &parameter.path, &parameter.ty)
                .map_err(|found| Failure::refused(found.message, ""))?
                .unwrap_or_else(zeros),
            // What is given stays a buffer.
            Origin::Block(..) => zeros(),
        });
    }
    let driven = pure.on(reader.device())?;
    let DrivenCalled { results, .. } = driven.call(reader, &columns, 1, request.limit)?;
    let mut answered = Answered {
        result: Vec::new(),
        parameters: vec![Vec::new(); found.signature.parameters.len()],
    };
    for (result, words) in pure.results.iter().zip(results) {
        let words = words.into_iter().map(|lanes| lanes[0]).collect();
        match result.at.map(|at| at.checked_sub(pure.inputs.len())) {
            None => answered.result = words,
            Some(at) => {
                let own = at.and_then(|at| answered.parameters.get_mut(at));
                own.into_iter().for_each(|own| own.clone_from(&words));
            }
        }
    }
    Ok(answered)
}

/// The words of an input, where it is given.
fn input(
    source: &Source,
    request: &Request,
    name: &str,
    ty: &crate::interp::ValueType,
) -> Result<Option<Vec<Vec<u64>>>, Box<Diagnostic>> {
    let Some((_, value)) = request.inputs.iter().find(|(given, _)| given == name) else {
        return Ok(None);
    };
    let mut flat = Vec::new();
    words(ty, value, name, source.language, &mut flat)
        .map_err(|m| Box::new(Diagnostic::about(m.code, m.message, m.help, "--input")))?;
    Ok(Some(flat.into_iter().map(|word| vec![word]).collect()))
}
