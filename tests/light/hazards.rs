//! The hazards of lighting code, each with inputs that trigger it and what every backend must make
//! of them.
//!
//! `CODE.json` has the rows. `cases` are functions of `shaders/` and of small shaders beside the
//! rows, in the form tutorials print and in the form that holds; `scenes` are whole pictures,
//! lit by both forms, and scenes that the host refuses, with a twin that it takes. Expected
//! values are computed from the formulas, in double precision, not by what is tested. Classes:
//! - `undefined`: the evaluator notes those operations, whatever a driver prints;
//! - `finite`: nothing undefined, and each number within `within` of `value`; `beyond` says
//!   how far the evaluator's `f32` must be off at least, so that the hazard is one; `drivers`
//!   is what drivers get instead of `within`. Of pictures they are steps from the reference;
//! - `refused`: the scene's backend, or the binding, says those codes at those places;
//! - `taken`: the host takes it, `warned` of no more than that.
//!
//! `besides` names operations of another row that the shader has as well.
//!
//! Rows without a picture, and why: `ambient-per-light` is of the model, which sums as the shader
//! does; `kahan-without-precise` needs sums of a range that no picture shows; `mediump-position` is
//! of `f16`, in which no shader of ours lights (desktop OpenGL ignores `mediump`, so its driver has
//! no say; an adapter without 16-bit floats has to refuse). Those of `host::REFUSED` are scenes
//! that the host refuses, so no picture of them can be asked for: their `cases` say what the
//! formulas would make of them. What the host can see of `lone-constant` is a key given twice, and
//! a `constant` that stands alone, at which it warns.

mod calls;
mod host;
use crate::support::backends;
mod scenes;
mod thresholds;

use std::fs;
use std::path::Path;

use landfall_ir::analysis::hazard::Hazard;
use serde_json::Value;

/// Rows without an entry in the catalogue.
const OWN: [&str; 2] = ["grazing-angle", "type-by-w"];

/// Rows of no scene, for reasons given above.
const PICTURELESS: [&str; 3] = ["ambient-per-light", "kahan-without-precise", "mediump-position"];

/// Rows whose numbers are what the formula says: `grazing-angle` is harmless, `ambient-per-light`
/// is of the model, and in `type-by-w` another branch is taken, as its first case shows.
const EXACT: [&str; 3] = ["grazing-angle", "ambient-per-light", "type-by-w"];

fn rows() -> Vec<Value> {
    let folder = Path::new("tests/hazards");
    let entries = fs::read_dir(folder).expect("the rows are beside this file");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
    paths.sort();
    let read = |path: &_| fs::read_to_string(path).expect("a readable row");
    paths.iter().map(|path| serde_json::from_str(&read(path)).expect("a row is JSON")).collect()
}

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value[key].as_str().unwrap_or_else(|| panic!("`{key}` of {value}"))
}

fn list<'v>(value: &'v Value, key: &str) -> &'v [Value] {
    value[key].as_array().unwrap_or_else(|| panic!("`{key}` of {value}"))
}

#[test]
fn every_hazard_has_a_row_that_breaks_and_one_that_holds() {
    let rows = rows();
    let ids: Vec<&str> = rows.iter().map(|row| text(row, "id")).collect();
    // A fragment at the edge of a cone is computed as well as any other.
    let lighting = Hazard::ALL.into_iter().filter(|h| !h.is_arithmetic() && *h != Hazard::ConeEdge);
    let wanted: Vec<&str> = lighting.map(Hazard::code).chain(OWN).collect();
    for id in &wanted {
        assert!(ids.contains(id), "{id} has no row");
    }
    assert_eq!(ids.len(), wanted.len());
    for row in &rows {
        let (id, cases) = (text(row, "id"), list(row, "cases"));
        let scenes = row["scenes"].as_array().map_or(&[][..], |scenes| scenes);
        assert_eq!(scenes.is_empty(), PICTURELESS.contains(&id), "{id}");
        let class = |case: &Value| text(&case["expect"], "class").to_string();
        let breaks = |case: &Value| match class(case).as_str() {
            "undefined" | "refused" => true,
            _ => case["expect"]["beyond"].is_number(),
        };
        let any = cases.iter().chain(scenes).any(breaks);
        assert_eq!(any, !EXACT.contains(&id), "whether anything of {id} breaks");
        assert!(cases.iter().any(|case| class(case) == "finite"), "nothing of {id} holds");
    }
}
