//! Levels, comments that allow, and `rule`.

use snapbox::str;

use crate::cli_check::place::{CLEAN, idle};
use crate::support::command::Place;

#[test]
fn flags_hold_over_the_configuration_and_later_flags_over_earlier_ones() {
    let place = Place::new("check-levels");
    place.write("a.frag", idle()).write("landfall.toml", "[levels]\nunused-allow = \"deny\"\n");
    let code =
        |flags: &[&str]| place.run(&[&["check", "-W", "stale-comment"], flags].concat()).code;
    assert_eq!(code(&[]), 1);
    assert_eq!(code(&["-W", "unused-allow"]), 0);
    assert_eq!(code(&["-W", "unused-allow", "-D", "warnings"]), 1);
    assert_eq!(code(&["-D", "warnings", "-W", "unused-allow"]), 0);
    assert_eq!(code(&["-D", "all", "-A", "all"]), 0);
    assert_eq!(code(&["-A", "all", "-D", "unused-allow", "-W", "stale-comment"]), 1);
    place.write("landfall.toml", "[levels]\nall = \"deny\"\nunused-allow = \"allow\"\n");
    assert_eq!(code(&[]), 0, "a code holds over `all`");
    let ran = place.run(&["check", "-A", "unused-alow"]);
    ran.code(2).stdout_eq("").stderr_eq(str![[r#"
error[unknown-lint]: there is no lint `unused-alow`
  |
  = help: did you mean `unused-allow`?


"#]]);
}

/// A warning of the layout itself, at line 4.
const BACK: &str = "#version 450
layout(std140, binding = 0) uniform B {
    layout(offset = 16) vec4 a;
    layout(offset = 0) vec4 b;
};
void main() {}
";

#[test]
fn a_comment_allows_in_its_line_in_the_next_or_in_the_file() {
    let place = Place::new("check-allow");
    let found = |text: &str| place.write("a.frag", text).found(&["a.frag"]);
    assert_eq!(found(BACK), ["offset-goes-back a.frag:4"]);
    let line = "    layout(offset = 0) vec4 b;";
    let behind = BACK.replace(line, &format!("{line} // landfall: allow(offset-goes-back)"));
    assert_eq!(found(&behind), [""; 0]);
    let above = BACK.replace(line, &format!("    /* landfall: allow(offset-goes-back) */\n{line}"));
    assert_eq!(found(&above), [""; 0]);
    let file = format!("{BACK}// landfall: allow-file(offset-goes-back)\n");
    assert_eq!(found(&file), [""; 0]);
    let elsewhere = BACK.replace("void", "// landfall: allow(offset-goes-back)\nvoid");
    assert_eq!(found(&elsewhere).len(), 2, "it holds for no other line, and is idle");
    let wgsl = CLEAN.replace("450", "450 // landfall: allow(offset-goes-back");
    assert_eq!(found(&wgsl), ["unused-allow a.frag:1"], "a comment that is not closed");
}

#[test]
fn a_comment_without_effect_is_warned_of_unless_its_lint_is_off() {
    let place = Place::new("check-idle");
    place.write("a.frag", idle());
    let (code, found, _) = place.check(&["-W", "stale-comment"]);
    assert_eq!(code, 0);
    assert_eq!(found[0]["message"], "`allow(stale-comment)` suppresses nothing in line 4");
    assert_eq!(found[0]["place"]["column"], 36);
    assert_eq!(place.found(&["-A", "stale-comment"]), [""; 0], "nobody asked it");
    place.write(
        "a.frag",
        CLEAN.replace("450", "450 // landfall: allow(stale-coment, unused-allow)"),
    );
    let (_, found, _) = place.check(&[]);
    assert_eq!(found.len(), 0, "it may allow itself");
    place.write("a.frag", CLEAN.replace("450", "450 // landfall: allow(stale-coment)"));
    let (_, found, _) = place.check(&[]);
    assert_eq!(found[0]["help"], "did you mean `stale-comment`?");
}

#[test]
fn an_include_is_found_fault_with_once_and_its_comment_serves_all() {
    let place = Place::new("check-allow-include");
    let with = "#version 450\n#include \"b.inc\"\nvoid main() {}\n";
    place.write("a.frag", with).write("c.frag", with);
    let body = BACK.strip_prefix("#version 450\n").unwrap().replace("void main() {}\n", "");
    place.write("b.inc", &body);
    assert_eq!(place.found(&[]), ["offset-goes-back b.inc:3"]);
    place.write("b.inc", body.replace("vec4 b;", "vec4 b; // landfall: allow(offset-goes-back)"));
    assert_eq!(place.found(&[]), [""; 0]);
}

#[test]
fn rule_lists_and_explains() {
    let place = Place::new("check-rule");
    let list = place.run(&["rule"]);
    assert_eq!((list.code, list.err.as_str()), (0, ""));
    assert_eq!(list.out.lines().filter(|line| line.starts_with("unused-allow ")).count(), 1);
    let one = place.run(&["rule", "unused-allow"]);
    one.code(0).stderr_eq("").stdout_eq(str![[r#"
unused-allow  (warn by default)

what
  a `// landfall: allow(code)` comment that suppresses nothing, or names no lint

why
  The finding that it suppressed was fixed or has moved. Left in place, the
  comment hides the next finding of that lint there, and one with a misspelt
  code hides nothing at all. A warning, because the comment itself breaks
  nothing. Not reported for lints that the run does not include.

fix
  Remove the comment, or the code from its list; `--fix` does. A misspelt code
  is replaced by that of the nearest lint.

example
  #version 450
  // landfall: allow(stale-comment)
  layout(std140, binding = 0) uniform Light {
      vec4 color;
  };
  void main() {}

allow it for one line with `// landfall: allow(unused-allow)`, or set its level:
  landfall.toml  [levels]  unused-allow = "allow"
  command line   -A unused-allow

"#]]);
    let json: serde_json::Value =
        serde_json::from_str(&place.run(&["rule", "--format", "json"]).out).unwrap();
    let codes: Vec<&str> =
        json.as_array().unwrap().iter().map(|lint| lint["code"].as_str().unwrap()).collect();
    assert!(codes.contains(&"layout-drift") && codes.is_sorted(), "{codes:?}");
    let one = place.run(&["rule", "unused-allow", "-f", "json"]).out;
    assert_eq!(serde_json::from_str::<serde_json::Value>(&one).unwrap()["level"], "warn");
    let all = place.run(&["rule", "--all", "-f", "md"]).out;
    assert_eq!(all.matches("\n**Why.** ").count(), codes.len());
    let unknown = place.run(&["rule", "layout-drfit"]);
    unknown.code(2).stdout_eq("").stderr_eq(str![[r#"
error[unknown-lint]: there is no lint or hazard `layout-drfit`
  |
  = help: did you mean `layout-drift`?


"#]]);
}

#[test]
fn the_example_of_unused_allow_is_reported_and_without_its_comment_is_not() {
    let place = Place::new("check-twin");
    let json = place.run(&["rule", "unused-allow", "-f", "json"]).out;
    let lint: serde_json::Value = serde_json::from_str(&json).unwrap();
    let bad = lint["example"].as_str().unwrap();
    place.write("a.frag", bad);
    assert_eq!(place.found(&["-W", "stale-comment"]), ["unused-allow a.frag:2"]);
    let good: Vec<&str> = bad.lines().filter(|line| !line.contains("landfall:")).collect();
    place.write("a.frag", good.join("\n"));
    assert_eq!(place.found(&["-W", "stale-comment"]), [""; 0]);
}
