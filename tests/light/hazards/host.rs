//! Scenes that the host refuses, each at its place, and their twins that it takes; members that
//! are given twice or never.

use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::harness::call::{Request, call};
use landfall_layout::buffer::{EncodeError, Missing, encode, read_json};
use landfall_layout::{Options, Severity, Source, layout};
use serde_json::{Value, json};
use snapbox::str;

use super::scenes::{reading, refused_by, written};
use super::{list, rows, text};
use crate::support::command::golden;

/// Rows of which the host refuses a scene.
const REFUSED: [&str; 11] = [
    "camera-at-fragment",
    "attenuation-unset",
    "overflow",
    "swapped-cut-offs",
    "cone-out-of-range",
    "zero-width-cone",
    "pow-of-negative",
    "count-past-array",
    "zero-direction",
    "negative-attenuation",
    "lone-constant",
];

/// What is wrong with how a scene was refused, if anything.
fn misfit(case: &Value) -> Option<String> {
    let scene = written(case, &case["scene"]);
    let reading = reading(&scene);
    let expect = &case["expect"];
    if let (Some(shader), Some(scene)) = (case["run"][0].as_str(), &reading.scene) {
        // Which slots there are, only a shader says.
        let Some(error) = refused_by(case, shader, scene) else {
            return Some(format!("{shader} takes it"));
        };
        let [found] = list(expect, "found") else { return Some("one is found".to_string()) };
        let at = error.at().unwrap_or_default();
        let has_place = reading.place(&at).is_some() && error.help().is_some();
        let fits = found[0] == error.code().name() && found[1] == at && has_place;
        return (!fits).then(|| format!("{} at `{at}`: {error}", error.code()));
    }
    let errors = reading.diagnostics.iter().filter(|found| found.severity == Severity::Error);
    let found: Vec<(&str, usize, &String)> = errors
        .map(|found| (found.code.name(), found.labels[0].at.start as usize, &found.message))
        .collect();
    // A key that stands twice has a place and no path of its own: it is counted.
    let place = |at: &Value| match (at.as_str(), at.as_array().map(Vec::as_slice)) {
        (Some(path), _) => reading.place(path).map(|span| span.start as usize),
        (None, Some([Value::String(key), nth])) => {
            let nth = nth.as_u64().expect("which of them") as usize;
            scene.match_indices(key.as_str()).nth(nth).map(|(at, _)| at)
        }
        (None, _) => None,
    };
    let wanted = list(expect, "found");
    let same = wanted.len() == found.len()
        && wanted.iter().zip(&found).all(|(wanted, (code, at, message))| {
            let named =
                wanted[1].as_str().is_none_or(|path| message.contains(&format!("`{path}`")));
            wanted[0] == *code && place(&wanted[1]) == Some(*at) && named
        });
    match (same, &reading.scene) {
        (true, None) => None,
        (true, Some(_)) => Some("there is a scene all the same".to_string()),
        (false, _) => Some(format!("{found:?} is found in {scene}")),
    }
}

#[test]
fn the_host_refuses_each_scene_at_its_place() {
    let (mut ids, mut wrong) = (Vec::new(), Vec::new());
    for row in rows() {
        let cases = row["scenes"].as_array().into_iter().flatten();
        for case in cases.filter(|case| text(&case["expect"], "class") == "refused") {
            ids.push(text(&row, "id").to_string());
            if let Some(why) = misfit(case) {
                wrong.push(format!("{} ({}): {why}", text(&row, "id"), text(case, "why")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for id in REFUSED {
        assert!(ids.iter().any(|known| known == id), "{id} refuses nothing");
    }
}

#[test]
fn the_host_takes_the_twin_of_each_scene_it_refuses() {
    for row in rows() {
        let (id, cases) = (text(&row, "id"), row["scenes"].as_array().into_iter().flatten());
        let of = |class: &'static str| {
            cases.clone().filter(move |case| text(&case["expect"], "class") == class)
        };
        assert_eq!(of("refused").count() > 0, of("taken").count() > 0, "{id} has no twins");
        for case in of("taken") {
            let reading = reading(&written(case, &case["scene"]));
            let codes: Vec<&str> =
                reading.diagnostics.iter().map(|found| found.code.name()).collect();
            let warned: Vec<&str> =
                case["warned"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
            assert_eq!(codes, warned, "{id}: {:?}", reading.diagnostics);
            let scene = reading.scene.unwrap_or_else(|| panic!("{id}: {:?}", reading.diagnostics));
            if let Some(shader) = case["run"][0].as_str() {
                let refused = refused_by(case, shader, &scene);
                assert!(refused.is_none(), "{id}: {refused:?}");
            }
        }
    }
}

/// `constant` three times and `linear`, `quadratic` never, as JSON for a block.
#[test]
fn a_member_given_twice_or_never_is_named() {
    let text = "layout(std140) uniform Spot { float constant; float linear; float quadratic; };";
    let shader = layout(&Source::new("spot.glsl", text), &Options::default());
    let block = &shader.blocks[0];
    let made =
        |json: &str| read_json(json).and_then(|values| encode(block, &values, Missing::Error));
    let said = |json: &str| match made(json) {
        Ok(bytes) => panic!("{json} is taken: {bytes:?}"),
        Err(error) => error,
    };
    let thrice = said(r#"{"constant": 1, "constant": 0.09, "constant": 0.032}"#);
    assert!(matches!(thrice, EncodeError::Syntax { line: 1, .. }), "{thrice}");
    golden().eq(thrice.to_string(), str!["line 1, column 17: `constant` is given twice"]);
    let never = said(r#"{"constant": 0.032}"#);
    assert!(matches!(&never, EncodeError::Missing { path } if path == "linear"), "{never}");
    made(r#"{"constant": 1, "linear": 0.09, "quadratic": 0.032}"#).expect("each is given once");
}

/// `mediump-position` where it cannot run: wgpu's own OpenGL has no 16-bit floats.
#[test]
fn an_adapter_without_16_bit_floats_refuses_them_by_name() {
    let choice = AdapterChoice { adapter: Some("(gl)".to_string()) };
    let mut gpu = Gpu::open(&choice).expect("Mesa's OpenGL, as wgpu takes it");
    let source = Source::read("tests/hazards/half.wgsl").expect("the shader is there");
    let request = Request {
        function: "attenuation_half".to_string(),
        arguments: vec![json!(20)],
        ..Request::default()
    };
    let refusal = call(&source, &Options::default(), &request, Some(&mut gpu))
        .expect_err("there are no 16-bit floats");
    let said = &refusal.found[0].message;
    golden()
        .eq(said, str!["gpu: the shader uses 16-bit floats, which this adapter does not support"]);
}
