//! Findings from beside the shaders: mirrors in Rust files, and what `verify` saw.

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::Place;

const MIRROR: &str = "// landfall: mirror(Light)
#[repr(C)]
struct Light {
    position: [f32; 3],
    color: [f32; 4],
}
";

/// By hand: three floats where the shader has four. `color` is at 12 and is read at 16 for that reason
/// alone, so that one edit mends both.
const SAID: [&str; 1] = ["rust-mirror src/light.rs:4"];

fn tree(name: &str) -> Place {
    let place = Place::new(&format!("check-{name}"));
    place.write("shaders/a.frag", CLEAN).write("src/light.rs", MIRROR);
    place.write("src/other.rs", "fn nothing() {}\n");
    place
}

fn found(place: &Place, more: &[&str]) -> Vec<String> {
    let levels = ["-D", "rust-mirror", "-W", "rust-mirror-unknown"];
    place.found(&[&levels[..], more].concat())
}

#[test]
fn mirrors_named_by_comments_are_found_below_the_configuration() {
    let place = tree("rust");
    assert_eq!(found(&place, &[]), SAID);
    place.write("landfall.toml", "paths = [\"shaders\"]\n");
    assert_eq!(found(&place, &[]), SAID, "wherever shaders are searched");
    assert_eq!(found(&place, &["shaders"]), [""; 0], "a part of the tree is no place for it");
    assert_eq!(found(&place, &["."]), SAID);
    place.write("landfall.toml", "exclude = [\"src\"]\n");
    assert_eq!(found(&place, &[]), [""; 0]);
    place.write("landfall.toml", "").write(".ignore", "/src\n");
    assert_eq!(found(&place, &[]), [""; 0]);
}

#[test]
fn mirrors_named_by_the_configuration_need_no_comment() {
    let place = tree("rust-config");
    place.write("src/light.rs", MIRROR.replace("// landfall: mirror(Light)", ""));
    assert_eq!(found(&place, &[]), [""; 0]);
    let said =
        "[[rust-mirror]]\nfile = \"src/light.rs\"\nstructure = \"Light\"\nblock = \"Light\"\n";
    place.write("landfall.toml", said);
    assert_eq!(found(&place, &["shaders"]), SAID);
    place.write("landfall.toml", said.replace("light.rs", "gone.rs"));
    let ran = place.run(&["check"]);
    ran.code(2).stderr_eq(str![[r#"
error[bad-rust]: `src/gone.rs` cannot be read: no such file or directory
  |
  = help: `[[rust-mirror]]` names it, landfall.toml:1


"#]]);
}

#[test]
fn a_rust_file_that_is_no_rust_ends_the_check_with_its_place() {
    let place = tree("rust-broken");
    place.write("src/light.rs", MIRROR.replace("[f32; 3],", "[f32; 3,"));
    let ran = place.run(&["check", "-D", "rust-mirror"]);
    ran.code(2).stderr_eq(str![[r#"
error[bad-rust]: `src/light.rs` cannot be read: it is not valid Rust at line 6, column 1: cannot parse string into token stream
  |
  = help: correct it, or leave it out of the mirrors that are checked


"#]]);
    assert_eq!(place.run(&["check", "-A", "all"]).code, 0, "nobody asks about it");
}

#[test]
fn a_changed_rust_file_is_seen_by_caches() {
    let place = tree("rust-cache");
    let cached = ["--cache-dir", "cache"];
    assert_eq!(found(&place, &cached), SAID);
    assert_eq!(found(&place, &cached), SAID);
    place.write("src/light.rs", MIRROR.replace("[f32; 3]", "[f32; 4]"));
    assert_eq!(found(&place, &cached), [""; 0]);
}

#[test]
fn what_verify_saw_is_reported_at_the_member_and_obeys_levels_and_comments() {
    let place = Place::new("check-verified");
    place.write("a.frag", CLEAN);
    let report = r#"{"schema_version":1,"tool":{"name":"landfall","version":"0.1.0"},"backends":[],
        "shaders":[{"path":"./a.frag","language":"glsl","blocks":[{"name":"Light",
        "instance":"light","rules":"std140","size":32,"leaves":2,"backends":[{"backend":"gpu",
        "stage":"fragment","form":"naga","outcome":"disagrees","reads":[{"path":"color.y",
        "leaf":"color","way":"constant","expected_byte":20,"byte_read":24}],"causes":[]}],
        "unprobed":[]}]}]}"#;
    place.write("seen.json", report);
    let ran = place.run(&["check", "--verified", "seen.json", "-f", "short"]);
    assert_eq!(ran.code, 1);
    ran.stdout_eq(str![[r#"
a.frag:4:10: error[driver-disagrees] `gpu` reads `color.y` of block `Light` from byte 24 instead of 20

"#]]);
    let quiet = ["check", "--verified", "seen.json", "-A", "driver-disagrees"];
    assert_eq!(place.run(&quiet).code, 0);
    let allowed = "    // landfall: allow(driver-disagrees)\n    vec4 color;";
    place.write("a.frag", CLEAN.replace("    vec4 color;", allowed));
    assert_eq!(place.run(&["check", "--verified", "seen.json"]).code, 0);
    assert_eq!(place.run(&["check"]).code, 0, "without a report the comment is not idle");
    place.write("seen.json", &report[..100]);
    let ran = place.run(&["check", "--verified", "seen.json"]);
    ran.code(2).stderr_eq(str![[r#"
error[cannot-run]: `seen.json` is no report of `landfall verify`: EOF while parsing an object at line 2 column 20
  |
  = help: write it again with `landfall verify --format json`


"#]]);
}
