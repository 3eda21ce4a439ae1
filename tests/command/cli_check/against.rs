//! `--against`: layouts of a git revision in the place of locks.

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::{Place, Ran};

/// A repository whose branch `main` has a shader with an include, and no lock.
fn repository(name: &str) -> Place {
    let place = Place::new(name);
    place.write("shaders/a.frag", CLEAN);
    place.write("lib/light.glsl", "struct Light { vec4 position; float range; };\n");
    let including = "#version 450\n#extension GL_GOOGLE_include_directive : require\n#include \"light.glsl\"\nlayout(std140, binding = 0) uniform Lights { Light lights[4]; } all;\nvoid main() {}\n";
    place.write("shaders/b.frag", including);
    place.write(
        "landfall.toml",
        "include = [\"lib\"]\n[levels]\nall = \"allow\"\nlayout-drift = \"deny\"\n",
    );
    place.commit();
    place
}

fn check(place: &Place, more: &[&str]) -> Ran {
    place.run(&[&["check", "-f", "short", "--against", "main"], more].concat())
}

#[test]
fn a_change_is_judged_by_the_revision_without_any_lock() {
    let place = repository("check-against");
    let same = check(&place, &[]);
    assert_eq!(same.code(0).out, "");
    // A new shader and a removed one change no layout that somebody fills.
    place.write("shaders/new.frag", CLEAN);
    place.write("shaders/a.frag", CLEAN.replace("vec4 position;", "vec4 n, position;"));
    let ran = check(&place, &[]);
    let expected = "shaders/a.frag:2:37: error[layout-drift] `Light` differs from `main`: `position` moved from 0 to 16; buffers filled for the old layout are misread\n";
    assert_eq!(ran.code(1).out, expected);
    assert!(!place.has("layouts"), "nothing is written");
    // The includes of the revision are read, not those of today.
    place.write("shaders/a.frag", CLEAN);
    place.write("lib/light.glsl", "struct Light { vec4 position; vec4 color; float range; };\n");
    let ran = check(&place, &[]);
    ran.code(1).stdout_eq(str![[r#"
shaders/b.frag:4:37: error[layout-drift] `Lights` differs from `main`: `lights` changed its array stride from 32 to 48; buffers filled for the old layout are misread

"#]]);
    let mut below = place.command(&["check", "-f", "short", "--against", "main"]);
    let below = Ran::of(below.current_dir(place.0.join("shaders")).output().unwrap());
    below.code(1).stdout_eq(str![[r#"
../shaders/b.frag:4:37: error[layout-drift] `Lights` differs from `main`: `lights` changed its array stride from 32 to 48; buffers filled for the old layout are misread

"#]]);
    // After the commit, the branch is what it is compared with.
    place.commit();
    assert_eq!(check(&place, &[]).code(0).out, "");
    let before = place.run(&["check", "-f", "short", "--against", "HEAD~1"]);
    before.code(1).stdout_eq(str![[r#"
shaders/b.frag:4:37: error[layout-drift] `Lights` differs from `HEAD~1`: `lights` changed its array stride from 32 to 48; buffers filled for the old layout are misread

"#]]);
}

#[test]
fn the_message_has_both_places_and_no_word_of_a_lock() {
    let place = repository("check-against-human");
    place.write("shaders/a.frag", CLEAN.replace("vec4 color;", "vec3 color;"));
    let ran = place.run(&["check", "--against", "main"]);
    let words = ["its lock", "locked", "`landfall lock`"];
    assert!(words.iter().all(|word| !ran.code(1).out.contains(word)), "{}", ran.out);
    ran.stdout_eq(str![[r#"
error[layout-drift]: `Light` differs from `main`: `color` changed from `vec4` to `vec3`; buffers filled for the old layout are misread
 --> shaders/a.frag:2:37
  |
2 | layout(std140, binding = 0) uniform Light {
  |                                     ^^^^^ differs from `main`
  |
  = note: declaration in `main`: main:shaders/a.frag:2:37
  = note: the layout
             32  uniform Light light std140 binding 0      32  uniform Light light std140 binding 0
           0 16    vec4 position                         0 16    vec4 position
          16 16    vec4 color                         | 16 12    vec3 color
                                                      > 28  4    -- tail padding
  = help: undo it, or change what uploads the block

"#]]);
    // A comment allows it.
    let allowed = CLEAN
        .replace("vec4 color;", "vec3 color;")
        .replace("layout(std140", "// landfall: allow(layout-drift)\nlayout(std140");
    place.write("shaders/a.frag", allowed);
    check(&place, &[]).code(0);
}

#[test]
fn the_cache_and_a_baseline_take_it_too() {
    let place = repository("check-against-cache");
    place.write("shaders/a.frag", CLEAN.replace("vec4 position;", "vec4 n, position;"));
    let cached = ["--cache-dir", "cache"];
    let (first, second) = (check(&place, &cached), check(&place, &cached));
    assert_eq!((first.code, &first.out), (second.code, &second.out));
    second.stderr_eq(str![[r#"
checked 3 shaders: 1 error
laid out 0 of 3 shaders, the rest is unchanged

"#]]);
    place.run(&["check", "--cache-dir", "cache", "--against", "HEAD"]).code(1);
    check(&place, &["--baseline", "b.json", "--write-baseline"]).code(0);
    check(&place, &["--baseline", "b.json"]).code(0);
}

#[test]
fn a_revision_that_cannot_be_read_is_an_error() {
    let place = repository("check-against-faults");
    for rev in ["gone", "-x", ""] {
        let ran = place.run(&["check", &format!("--against={rev}")]);
        assert_eq!((ran.code(2).out.as_str(), ran.err.is_empty()), ("", false), "{rev}");
    }
    let other = Place::new("check-against-nothing");
    other.commit();
    // Before its first shader, a project has no layout to compare with.
    other.write("a.frag", CLEAN);
    other.run(&["check", "--against", "main"]).code(0);
    other.run(&["check", "--against", "main", "--accept"]).code(2);
}
