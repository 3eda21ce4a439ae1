//! Matches the inputs of two functions that compute the same: by their paths, or by their order
//! where the names differ.
//!
//! Used by [`bench`](mod@crate::bench), whose variants are called with the same values,
//! and by [`stress`](mod@crate::stress), which compares findings with a robust form.

use super::input::{Inputs, inputs_of};
use landfall_exec::harness::call::pure::PureFunction;
use landfall_layout::shape::Scalar;

/// Returns the inputs of a function, including members of its blocks that only one of the others
/// reads.
pub(crate) fn shared(pure: &PureFunction, others: &[&PureFunction]) -> Inputs {
    let theirs: Vec<NamedScalar<'_>> =
        others.iter().flat_map(|other| scalars(other)).filter(|one| one.read).collect();
    let mut all = scalars(pure).into_iter();
    let sampled = pure.parameters.iter().map(|parameter| {
        let own: Vec<NamedScalar<'_>> = all.by_ref().take(parameter.scalars.len()).collect();
        parameter.read || own.iter().any(|one| theirs.iter().any(|other| other.matches(one)))
    });
    let sampled: Vec<bool> = sampled.collect();
    inputs_of(pure, &sampled)
}

/// Returns for each scalar of `other` the matching one of `pure`; `None` for unread scalars.
///
/// # Errors
/// An input that `other` reads and `pure` does not have.
pub(crate) fn matched(
    pure: &PureFunction,
    inputs: &Inputs,
    other: &PureFunction,
) -> Result<Vec<Option<usize>>, String> {
    let (own, others) = (scalars(pure), scalars(other));
    let mut sampled = vec![false; own.len()];
    inputs.iter().for_each(|input| sampled[input.range()].fill(true));
    let among = |at: &usize| sampled[*at];
    let by_path =
        others.iter().map(|one| own.iter().position(|own| own.matches(one)).filter(among));
    let by_path: Vec<Option<usize>> = by_path.collect();
    let in_turn = || (0..own.len()).map(|at| Some(at).filter(among)).collect();
    let read_in_turn = || {
        let mut read = (0..own.len()).filter(|&at| own[at].read);
        others.iter().map(|one| if one.read { read.next() } else { None }).collect()
    };
    let same = |a: Vec<Scalar>, b: Vec<Scalar>| a == b;
    let all = |each: &[NamedScalar<'_>]| each.iter().map(|one| one.kind).collect();
    let read =
        |each: &[NamedScalar<'_>]| each.iter().filter(|one| one.read).map(|one| one.kind).collect();
    // A variant may read fewer inputs.
    let fits = |order: &Vec<Option<usize>>| {
        order.iter().zip(&others).all(|(at, one)| at.is_some() || !one.read)
    };
    let by_order = same(all(&own), all(&others)).then(in_turn).filter(fits);
    let by_reading = || same(read(&own), read(&others)).then(read_in_turn);
    if let Some(order) = Some(by_path.clone()).filter(fits).or(by_order).or_else(by_reading) {
        return Ok(order);
    }
    let missing = by_path.iter().zip(&others).find(|(at, one)| at.is_none() && one.read);
    let missing =
        missing.map_or(String::new(), |(_, one)| format!("it reads `{}`, and ", one.path));
    let reads = pure.parameters.iter().filter(|parameter| parameter.read);
    let reads: Vec<String> = reads.map(|parameter| format!("`{}`", parameter.path)).collect();
    Err(format!(
        "{missing}`{}`, which it is compared with, reads {}",
        pure.shown,
        match reads.is_empty() {
            true => "nothing".to_string(),
            false => reads.join(", "),
        }
    ))
}

struct NamedScalar<'a> {
    path: &'a str,
    kind: Scalar,
    read: bool,
}

impl NamedScalar<'_> {
    /// Whether it has the same name and type.
    fn matches(&self, other: &NamedScalar<'_>) -> bool {
        self.path == other.path && self.kind == other.kind
    }
}

fn scalars(pure: &PureFunction) -> Vec<NamedScalar<'_>> {
    let each = pure.parameters.iter().flat_map(|parameter| {
        let kinds = parameter.scalars.iter().zip(parameter.ty.scalars());
        kinds.map(|(path, kind)| NamedScalar { path, kind, read: parameter.read })
    });
    each.collect()
}
