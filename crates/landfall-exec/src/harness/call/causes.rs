//! What made results of a call NaN, infinite or undefined, from a second run of the call that
//! records every operation.
//!
//! Used by [`call`](super::call()).

use super::report::{ResultCause, ReturnedValue, UndefinedOperation};
use crate::harness::origins::{Cause, Names, number};
use landfall_interp::{
    Call, Called, Number, Numbers, Operand, Operation, Settings, Source, Trace, ValueType,
};
use landfall_layout::shape::{Scalar, ScalarKind};

/// A result of the interpreter that is NaN or infinite.
struct NonFiniteScalar {
    /// The caller's parameter; `None` for the return value.
    slot: Option<usize>,
    scalar: usize,
    is_nan: bool,
    cause: Cause,
}

/// What a call left undefined, NaN or infinite, with the values that led there.
#[derive(Default)]
pub(super) struct Causes {
    pub undefined: Vec<UndefinedOperation>,
    /// What rounding to f16 changed, as notes.
    pub rounded: Vec<String>,
    non_finite: Vec<NonFiniteScalar>,
}

/// Returns the causes in a call that was run with the same settings but for the trace; `rounds` if
/// it rounds to f16.
pub(super) fn causes(
    names: &Names<'_>,
    result: Option<&ValueType>,
    called: &Called,
    rounds: bool,
    (call, settings): (&Call<'_>, &Settings),
) -> Causes {
    let mut odd: Vec<(Option<usize>, usize, f32)> = Vec::new();
    let mut find = |slot, ty: &ValueType, numbers: &Numbers| {
        let scalars = ty.scalars().into_iter().zip(&numbers.words).enumerate();
        let floats = scalars.filter(|(_, (scalar, _))| is_single(*scalar));
        let numbers = floats.map(|(nth, (_, lanes))| (slot, nth, f32::from_bits(lanes[0] as u32)));
        odd.extend(numbers.filter(|(_, _, x)| !x.is_finite()));
    };
    if let Some(ty) = result {
        find(None, ty, &called.result);
    }
    for (slot, (numbers, (_, ty))) in called.returned.iter().zip(&names.parameters).enumerate() {
        if let Some(numbers) = numbers {
            find(Some(slot), ty, numbers);
        }
    }
    let undefined = &called.notes.undefined;
    let mut trace = None;
    // The trace needs memory for every operation, so it is made only for a call that has something
    // to explain.
    if rounds || !odd.is_empty() || !undefined.is_empty() {
        let settings = Settings { trace: true, ..settings.clone() };
        // Where it does not end in time again, the operations are still known.
        let traced = names.program.call(call, &settings).ok();
        trace = traced.and_then(|traced| traced.notes.trace);
    }
    let trace: &Trace = &trace.unwrap_or_default();
    let source = |slot: Option<usize>, scalar: usize| {
        let sources = match slot {
            None => Some(&trace.results),
            Some(slot) => trace.returned.get(slot),
        };
        sources.and_then(|sources| sources.get(scalar)).copied().unwrap_or(Source::Unknown)
    };
    let non_finite = odd.into_iter().map(|(slot, scalar, x)| {
        let number = Number { single: x, double: f64::from(x) };
        let cause = names.cause(trace, Operand { number, source: source(slot, scalar) });
        NonFiniteScalar { slot, scalar, is_nan: x.is_nan(), cause }
    });
    let undefined = undefined.iter().map(|seen| UndefinedOperation {
        from: names.led_to(trace, seen.kind, &seen.place).unwrap_or_default(),
        seen: seen.clone(),
    });
    Causes {
        rounded: if rounds { rounded(names, trace) } else { Vec::new() },
        undefined: undefined.collect(),
        non_finite: non_finite.collect(),
    }
}

/// Returns which values that were read, and how many results of operations, rounding to f16 changed.
fn rounded(names: &Names<'_>, trace: &Trace) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    let mut results = 0;
    // Rounding is an instruction of its own, after the operation or the read.
    for step in trace.steps.iter().filter(|step| step.operation == Operation::Convert) {
        let ([from], [to]) = (&step.operands[..], &step.results[..]) else { continue };
        let is_changed = to.single != from.number.single;
        if let Source::Step { .. } = from.source {
            results += usize::from(is_changed);
            continue;
        }
        for read in names.values(&[*from]).iter().filter(|_| is_changed) {
            let note = match to.single.is_finite() {
                true => format!("f16 rounds the input {read} to {}", number(to.single.into())),
                false => format!("f16 cannot hold the input {read}: its largest number is 65504"),
            };
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    if results > 0 {
        notes.push(format!("results of operations that f16 rounds: {results}"));
    }
    notes
}

fn is_single(scalar: Scalar) -> bool {
    scalar.kind == ScalarKind::Float && scalar.width < 8
}

impl Causes {
    /// Adds the causes in a returned value, by the caller's parameter.
    pub fn push(
        &self,
        name: &str,
        slot: Option<usize>,
        given: &ReturnedValue,
        to: &mut Vec<ResultCause>,
    ) {
        let own: Vec<&NonFiniteScalar> =
            self.non_finite.iter().filter(|scalar| scalar.slot == slot).collect();
        let first = to.len();
        for NonFiniteScalar { scalar, is_nan, cause, .. } in own {
            let path = given.scalars.get(*scalar).map_or("", |scalar| scalar.path.as_str());
            let path = format!("{name}{path}");
            // Results with the same cause are listed together.
            let same = |known: &&mut ResultCause| known.is_nan == *is_nan && known.cause == *cause;
            match to[first..].iter_mut().find(same) {
                Some(known) => known.results.push(path),
                None => {
                    let (results, cause) = (vec![path], cause.clone());
                    to.push(ResultCause { results, is_nan: *is_nan, cause });
                }
            }
        }
        for cause in &mut to[first..] {
            // Every scalar has this cause: the value is named as a whole.
            if cause.results.len() == given.scalars.len() {
                cause.results = vec![name.to_string()];
            }
        }
    }
}
