//! Layouts that change under sets of macros.

use crate::support::command::golden;
use landfall_lint::Settings;
use snapbox::str;

use crate::lints_b::{found_with, said};

fn permutations(sets: &[&[(&str, &str)]]) -> Settings {
    let owned = |set: &&[(&str, &str)]| {
        set.iter().map(|(name, text)| (name.to_string(), text.to_string())).collect()
    };
    Settings { permutations: sets.iter().map(owned).collect(), ..Settings::default() }
}

fn text(members: &str) -> String {
    format!(
        "#version 330 core\nlayout(std140) uniform Light {{\n{members}\n}} light;\nvoid main() {{}}\n"
    )
}

#[test]
fn the_first_difference_is_named_with_the_permutation_and_both_numbers() {
    let settings = permutations(&[&[("SHADOWS", "1")]]);
    let bad = text("    vec3 color;\n#ifdef SHADOWS\n    mat4 shadow;\n#endif\n    float gain;");
    let found = found_with("define-changes-layout", "a.frag", &bad, &settings);
    assert_eq!(
        found.iter().map(said).collect::<Vec<_>>(),
        ["7:11 the layout of block `Light` changes under `SHADOWS`: `gain` is at 80 instead of 12"]
    );
    golden().eq(
        &found[0].notes[0],
        str!["without `SHADOWS` the block is 16 bytes; the listing is with it"],
    );
    golden().eq(
        found[0].listing.as_deref().expect("it lists the layout"),
        str![[r#"
/*            align(16) size(96)             */ layout(std140) uniform Light {
/* offset( 0) align(16) size(12)             */     vec3 color;
/* offset(12)           size( 4)             */     // -- hole
/* offset(16) align(16) size(64) columns(16) */     mat4 shadow;
/* offset(80) align( 4) size( 4)             */     float gain;
/* offset(84)           size(12)             */     // -- tail padding
/*                                           */ } light;
// 96 bytes: 80 used, 16 padding (16.7 %)
"#]],
    );
}

#[test]
fn macros_that_do_not_reach_a_layout_are_no_finding() {
    let settings = permutations(&[&[("SHADOWS", "1")], &[("UNHEARD_OF", "1")]]);
    let good = text("    vec3 color;\n    float gain;").replace(
        "void main() {}",
        "#ifdef SHADOWS\nuniform Map { float bias; };\n#endif\nvoid main() {}",
    );
    assert_eq!(found_with("define-changes-layout", "a.frag", &good, &settings), []);
}

#[test]
fn an_array_that_grows_is_found_where_it_stands() {
    let settings = permutations(&[&[("LIGHTS", "8")]]);
    let bad = "#version 330 core\n#define LIGHTS 4\nlayout(std140) uniform B { vec4 at[LIGHTS]; };\nvoid main() {}\n";
    let found = found_with("define-changes-layout", "a.frag", bad, &settings);
    assert_eq!(
        found.iter().map(said).collect::<Vec<_>>(),
        [
            "3:33 the layout of block `B` changes under `LIGHTS=8`: `at[]` has 8 elements instead of 4"
        ]
    );
    let same = permutations(&[&[("LIGHTS", "4")]]);
    assert_eq!(found_with("define-changes-layout", "a.frag", bad, &same), []);
}

#[test]
fn an_appended_member_is_a_change_too() {
    let settings = permutations(&[&[("FOG", "")]]);
    let bad = text("    vec4 color;\n#ifdef FOG\n    float fog;\n#endif");
    let found = found_with("define-changes-layout", "a.frag", &bad, &settings);
    assert_eq!(
        found.iter().map(said).collect::<Vec<_>>(),
        ["5:11 the layout of block `Light` changes under `FOG`: `fog` is added at 16"]
    );
}

#[test]
fn permutations_that_change_a_block_alike_share_a_finding() {
    let settings = permutations(&[&[("FOG", "1")], &[("FOG", "1"), ("DEBUG", "1")]]);
    let bad = text("    vec4 color;\n#ifdef FOG\n    float fog;\n#endif");
    let found = found_with("define-changes-layout", "a.frag", &bad, &settings);
    assert_eq!(found.len(), 1);
    assert!(found[0].notes.contains(&"under `FOG DEBUG=1` too".replace("=1", "")), "{found:#?}");
}

#[test]
fn a_permutation_that_breaks_the_shader_is_said() {
    let settings = permutations(&[&[("BROKEN", "1")]]);
    let bad = text("    vec4 color;\n#ifdef BROKEN\n    Missing what;\n#endif");
    let found = found_with("define-changes-layout", "a.frag", &bad, &settings);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].place().line, 5);
    golden().eq(
        &found[0].message,
        str!["under `BROKEN` the shader cannot be laid out: unknown type `Missing`"],
    );
}

#[test]
fn loose_uniforms_have_no_layout_to_change() {
    let settings = permutations(&[&[("FOG", "1")]]);
    let text = "#version 330 core\nuniform vec4 color;\n#ifdef FOG\nuniform float fog;\n#endif\nvoid main() {}\n";
    assert_eq!(found_with("define-changes-layout", "a.frag", text, &settings), []);
}

#[test]
fn variants_are_compared_with_each_other_where_the_text_without_macros_lacks_the_block() {
    let settings = permutations(&[&[("FOG", "1")], &[("FOG", "1"), ("RAIN", "1")]]);
    let members = "    vec4 color;\n#ifdef RAIN\n    mat4 drops;\n#endif\n    float gain;";
    let bad = text(members)
        .replace("layout(std140)", "#ifdef FOG\nlayout(std140)")
        .replace("} light;", "} light;\n#endif");
    let found = found_with("define-changes-layout", "a.frag", &bad, &settings);
    let message =
        "the layout of block `Light` changes under `FOG RAIN`: `gain` is at 80 instead of 16";
    assert_eq!(found.iter().map(said).collect::<Vec<_>>(), [format!("8:11 {message}")]);
    assert_eq!(
        found[0].notes[0],
        "under `FOG` the block is 32 bytes; the listing is with `FOG RAIN`"
    );
    let good = bad.replace("RAIN\n    mat4 drops;", "RAIN");
    assert_eq!(found_with("define-changes-layout", "a.frag", &good, &settings), []);
}

#[test]
fn an_array_of_structures_that_grows_is_marked_at_the_array() {
    let settings = permutations(&[&[("LIGHTS", "8")]]);
    let bad = text("    Lamp lamps[LIGHTS];").replace(
        "layout(std140)",
        "#ifndef LIGHTS\n#define LIGHTS 4\n#endif\nstruct Lamp { vec3 at; vec3 color; };\nlayout(std140)",
    );
    let found = found_with("define-changes-layout", "a.frag", &bad, &settings);
    let message =
        "the layout of block `Light` changes under `LIGHTS=8`: `lamps` has 8 elements instead of 4";
    assert_eq!(found.iter().map(said).collect::<Vec<_>>(), [format!("7:10 {message}")]);
}
