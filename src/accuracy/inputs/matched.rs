//! The inputs of one function as those of another that computes the same: by their paths, or by
//! their order where the names are others.
//!
//! Feeds [`bench`](mod@crate::accuracy::bench), whose variants are called with the same values.

use crate::run::call::pure::Pure;
use crate::shape::Scalar;

/// For each scalar of `other`, which of `pure`'s it is given.
///
/// # Errors
/// What `other` reads that `pure` does not, or the other way round.
pub(in crate::accuracy) fn matched(pure: &Pure, other: &Pure) -> Result<Vec<usize>, String> {
    let (own, others) = (scalars(pure), scalars(other));
    let find = |scalar: &(&String, Scalar)| own.iter().position(|known| known == scalar);
    let by_path: Vec<Option<usize>> = others.iter().map(find).collect();
    // A variant may need less: what it does not read does not matter to it.
    if let Some(all) = by_path.iter().copied().collect::<Option<Vec<usize>>>() {
        return Ok(all);
    }
    let kinds =
        |all: &[(&String, Scalar)]| -> Vec<Scalar> { all.iter().map(|(_, kind)| *kind).collect() };
    if kinds(&own) == kinds(&others) {
        return Ok((0..own.len()).collect());
    }
    let missing = by_path.iter().position(Option::is_none).map(|at| &others[at].0);
    let missing = missing.map_or_else(String::new, |path| format!("it reads `{path}`, and "));
    let reads: Vec<String> = pure.parameters.iter().map(|p| format!("`{}`", p.path)).collect();
    Err(format!(
        "{missing}`{}`, which it is compared with, reads {}",
        pure.shown,
        match reads.is_empty() {
            true => "nothing".to_string(),
            false => reads.join(", "),
        }
    ))
}

/// The path and the type of each scalar.
fn scalars(pure: &Pure) -> Vec<(&String, Scalar)> {
    let each = pure.parameters.iter();
    each.flat_map(|parameter| parameter.scalars.iter().zip(parameter.ty.scalars())).collect()
}
