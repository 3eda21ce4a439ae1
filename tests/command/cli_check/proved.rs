//! `[[prove]]`: demands on functions that a check proves.

use snapbox::str;

use crate::cli_check::place::CLEAN;
use crate::support::command::Place;

const SHADER: &str = "#version 450
layout(location = 0) in float distance_;
layout(location = 0) out vec4 color;
float plain(float d) {
    return d / d;
}
float guarded(float d) {
    return d / max(d, 0.01);
}
void main() { color = vec4(plain(distance_) + guarded(distance_)); }
";

/// `[[prove]]` with more keys.
fn row(function: &str, more: &str) -> String {
    format!("[[prove]]\nfile = \"s/*.frag\"\nfunction = \"{function}\"\n{more}\n")
}

fn tree(name: &str, config: &str) -> Place {
    let place = Place::new(&format!("check-proved-{name}"));
    place.write("s/a.frag", SHADER).write("s/b.vert", CLEAN);
    place.write(
        "landfall.toml",
        format!("paths = [\"s\"]\n[levels]\nall = \"allow\"\nnot-proved = \"deny\"\n{config}"),
    );
    place
}

const RANGE: &str = "domain = { d = [0, 100] }";

#[test]
fn an_input_that_breaks_a_demand_is_a_finding_at_the_operation() {
    let place = tree("broken", &row("plain", &format!("no-nan = true\n{RANGE}")));
    place.run(&["check"]).code(1).stdout_eq(str![[r#"
error[not-proved]: `plain(float)` is NaN with all inputs zero
 --> s/a.frag:5:12
  |
5 |     return d / d;
  |            ^^^^^
  |
 ::: landfall.toml:5:1
  |
5 | [[prove]]
  | --------- demanded here
  |
  = note: undefined results: 1 found, 0 proved absent, 0 open, in 1 operation
  = help: `landfall prove s/a.frag --fn 'plain' --no-nan --domain '{"d":[0.0,100.0]}'` lists them

"#]]);
}

#[test]
fn what_is_proved_is_no_finding() {
    let place = tree("shown", &row("guarded", &format!("no-nan = true\nno-inf = true\n{RANGE}")));
    assert_eq!(place.run(&["check"]).code, 0);
    let place = tree("shown-any", &row("guarded", RANGE));
    assert_eq!(place.run(&["check"]).code, 0);
}

#[test]
fn standard_input_is_held_to_a_demand_by_its_own_text() {
    let place = tree("stdin", &row("plain", &format!("no-nan = true\n{RANGE}")));
    let mended = SHADER.replace("d / d", "d");
    let check = ["check", "-", "--stdin-filename", "s/a.frag"];
    place.run_with_stdin(&check, &mended).code(0);
    place.write("s/a.frag", &mended).run_with_stdin(&check, SHADER).code(1);
}

#[test]
fn an_error_past_the_limit_is_a_finding_at_the_configuration() {
    let limit =
        |most: &str| row("guarded", &format!("max-ulp = {most}\ndomain = {{ d = [1, 100] }}"));
    // A division in f32 is off by up to 2.5 ULP on Vulkan, and GLSL states no other limit.
    let place = tree("limit", &limit("0.25"));
    assert_eq!(place.run(&["check"]).code, 1);
    let place = tree("limit-met", &limit("100"));
    assert_eq!(place.run(&["check"]).code, 0);
}

#[test]
fn a_row_without_a_shader_or_with_a_function_that_cannot_be_called_is_a_finding() {
    let place = tree("gone", &row("plain", RANGE).replace("s/*.frag", "t/*.frag"));
    place.run(&["check"]).code(1).stdout_eq(str![[r#"
error[not-proved]: no shader matches `t/*.frag`
 --> landfall.toml:5:1
  |
5 | [[prove]]
  | ^^^^^^^^^
  |
  = help: `file` is relative to the configuration, and may have `*` and `**`

"#]]);
    // Of a part of the tree, the rest may have the shader.
    assert_eq!(place.run(&["check", "s/a.frag"]).code, 0);
    let place = tree("no-function", &row("no_such", ""));
    place.run(&["check"]).code(1).stdout_eq(str![[r#"
error[not-proved]: `no_such` of `s/a.frag` cannot be proved: the shader has no function `no_such`
 --> landfall.toml:5:1
  |
5 | [[prove]]
  | ^^^^^^^^^
  |
  = help: its functions are `plain(float)`, `guarded(float)`

"#]]);
}

#[test]
fn levels_and_comments_allow_it() {
    let place = tree("allowed", &row("plain", RANGE));
    assert_eq!(place.run(&["check"]).code, 1);
    assert_eq!(place.run(&["check", "-W", "not-proved"]).code, 0);
    assert_eq!(place.run(&["check", "-A", "not-proved"]).err, "checked 2 shaders: no findings\n");
    let comment = "    return d / d; // landfall: allow(not-proved)";
    place.write("s/a.frag", SHADER.replace("    return d / d;", comment));
    assert_eq!(place.run(&["check"]).code, 0);
}

#[test]
fn keys_of_another_form_are_errors() {
    let refused = |more: &str| {
        let place = tree("refused", &row("plain", more));
        let ran = place.run(&["check"]);
        assert_eq!((ran.code, &*ran.out), (2, ""), "{more}");
        ran.err.lines().next().unwrap_or_default().to_string()
    };
    assert_eq!(
        refused("no-nan = 1"),
        "error[wrong-type]: `no-nan` is an integer, not true or false"
    );
    let negative = "error[wrong-value]: `max-ulp` is -1, not a finite number of at least 0";
    assert_eq!(refused("max-ulp = -1"), negative);
    let nan = "error[wrong-value]: `max-step` is NaN, not a finite number of at least 0";
    assert_eq!(refused("max-step = nan"), nan);
    let array = "error[wrong-type]: `domain` is an array, not a table";
    assert_eq!(refused("domain = [0, 100]"), array);
    let date = "error[wrong-value]: `domain` holds a date or a number that is not finite";
    assert_eq!(refused("domain = { d = 1979-05-27 }"), date);
    let unknown = "error[unknown-key]: `[[prove]]` has no key `no_nan`";
    assert_eq!(refused("no_nan = true"), unknown);
}
