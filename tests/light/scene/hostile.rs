//! Whatever a text holds, reading it gives a scene or says what is wrong, and never panics.

use landfall_light::scene::Reading;
use landfall_light::{Frame, FrameOptions, Upload};
use snapbox::str;

use crate::scene::{RIGHT, folder, names, read_alone};
use crate::support::command::golden;

/// A scene, which must be drawable then, or at least one error.
fn sound(reading: &Reading) {
    match &reading.scene {
        None => assert!(!reading.diagnostics.is_empty()),
        Some(scene) => {
            let mut scene = scene.clone();
            scene.size = [16, 9];
            let upload = Upload::new(&scene);
            for lamp in &upload.lights.point {
                assert!(lamp.position.is_finite() && lamp.emission.diffuse.is_finite());
                assert!(lamp.emission.diffuse.min_element() >= 0.0);
            }
            for fragment in Frame::new(&scene, &FrameOptions::default()).fragments {
                let numbers = fragment.position.iter().chain(&fragment.normal).chain(&fragment.uv);
                assert!(numbers.into_iter().all(|number| number.is_finite()), "{fragment:?}");
            }
        }
    }
    for found in &reading.diagnostics {
        assert!(found.message.len() < 500, "{}", found.message);
        for label in &found.labels {
            assert!(label.at.start <= label.at.end);
            reading.files.locate(label.at);
        }
    }
}

/// What is put in the place of another value.
const VALUES: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1e-320",
    "1e-38",
    "1e38",
    "-1e18",
    "1e400",
    "NaN",
    "\"nan\"",
    "null",
    "true",
    "[]",
    "{}",
    "[0,0,0]",
    "[1e18,-1e18,1e18]",
    "\"\"",
    "\"cube\"",
    "4294967296",
    "0.1e",
    "[[[[",
    "\\u0000",
    "\"\\ud800\"",
    "//",
];

#[test]
fn a_mutated_scene_never_panics() {
    let mut random = fastrand::Rng::with_seed(6);
    let mut texts = vec![RIGHT.to_string()];
    for name in names() {
        let path = folder().join(name).with_extension("json");
        texts.push(std::fs::read_to_string(path).expect("it is there"));
    }
    let (mut right, mut wrong) = (0, 0);
    for _ in 0..3000 {
        let mut text = texts[random.usize(..texts.len())].clone();
        // 1,024 lamps are many to look at so often.
        text = text.replace("1024", "24");
        for _ in 0..random.usize(1..4) {
            mutate(&mut text, &mut random);
        }
        let reading = read_alone(&text);
        sound(&reading);
        if reading.scene.is_some() { right += 1 } else { wrong += 1 }
    }
    assert!(right > 100 && wrong > 1000, "{right} {wrong}");
}

fn mutate(text: &mut String, random: &mut fastrand::Rng) {
    let floor = |text: &str, mut at: usize| {
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let at = floor(text, random.usize(..text.len().max(1)).min(text.len()));
    match random.u8(..6) {
        0 => text.truncate(at),
        1 => {
            let end = floor(text, (at + random.usize(..20)).min(text.len())).max(at);
            text.replace_range(at..end, "");
        }
        2 => text
            .insert(at, *random.choice(b"{}[],:\"-0eE.\\\n\0 ").expect("there are some") as char),
        3 => {
            let end = floor(text, (at + random.usize(..60)).min(text.len())).max(at);
            let part = text[at..end].to_string();
            text.insert_str(at, &part);
        }
        _ => {
            // A number, most of the time the whole of it.
            let is_part = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
            let Some(start) = text[at..].find(|c: char| c.is_ascii_digit()) else { return };
            let start = at + start;
            let len = text[start..].find(|c| !is_part(c)).unwrap_or(text.len() - start);
            let value = random.choice(VALUES).expect("there are some");
            text.replace_range(start..start + len, value);
        }
    }
}

#[test]
fn what_is_no_scene_at_all_is_one_clear_error() {
    let deep = "[".repeat(1 << 20);
    let braces = "{".repeat(10 << 20);
    let objects = "{\"camera\":".repeat(100_000);
    let list = format!("[{}1]", "1,".repeat(1 << 20));
    for (text, code) in [
        ("", "json-syntax"),
        ("   \n", "json-syntax"),
        ("null", "wrong-value"),
        ("\0\u{1}\u{fffd}junk", "json-syntax"),
        ("#version 330\nvoid main() {}", "json-syntax"),
        ("{\"size\": [8, 8], }", "json-syntax"),
        ("{'size': 1}", "json-syntax"),
        (&deep, "json-syntax"),
        (&braces, "json-syntax"),
        (&objects, "json-syntax"),
        (&list, "wrong-value"),
    ] {
        let reading = read_alone(text);
        sound(&reading);
        let codes: Vec<&str> = reading.diagnostics.iter().map(|found| found.code.name()).collect();
        assert_eq!(codes, [code], "{}", &text[..text.len().min(20)]);
    }
    let message = &read_alone(&deep).diagnostics[0].message;
    golden().eq(message, str!["the scene is nested too deeply"]);
}

#[test]
fn a_flood_of_errors_is_cut_off() {
    let keys: String = (0..20_000).map(|i| format!("\"key{i}\": 1, ")).collect();
    let reading = read_alone(&format!("{{{keys} \"size\": [1, 1]}}"));
    assert!(reading.scene.is_none());
    assert_eq!(reading.diagnostics.len(), 1000);
}

#[test]
fn a_bare_value_that_nests_too_deep_is_refused() {
    let deep = format!("\"model\": {{\"a\": {}1{}}},", "[".repeat(200), "]".repeat(200));
    let reading = read_alone(&RIGHT.replace("\"model\": \"phong\",", &deep));
    assert!(reading.scene.is_none());
    assert_eq!(reading.diagnostics.len(), 1);
    golden().eq(&reading.diagnostics[0].message, str!["`model` is nested too deeply"]);
}
