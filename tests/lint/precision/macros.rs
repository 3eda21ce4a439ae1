//! `define-changes-layout` and `webgl2-size`.

use landfall_lint::Settings;
use landfall_lint::settings::Target;
use snapbox::str;

use super::{Fixture, Score};
use crate::support::command::golden;

fn block(members: &str) -> String {
    format!(
        "#version 330 core\nlayout(std140) uniform Light {{\n{members}\n}};\nvoid main() {{}}\n"
    )
}

#[test]
fn members_that_macros_move() {
    let settings = || Settings {
        permutations: vec![
            vec![("SHADOWS".into(), "1".into())],
            vec![("LIGHTS".into(), "8".into())],
        ],
        ..Settings::default()
    };
    // With the line of the member that differs.
    let bad = [
        ("vec3 color;\n#ifdef SHADOWS\nmat4 shadow;\n#endif\nfloat power;", 7),
        ("vec3 color;\nfloat power;\n#ifdef SHADOWS\nmat4 shadow;\n#endif", 6),
        ("#ifdef SHADOWS\nmat4 m;\n#else\nvec4 m;\n#endif\nfloat power;", 6),
        ("vec3 color;\n#ifndef SHADOWS\nfloat bias;\n#endif\nfloat power;", 5),
        ("#ifndef LIGHTS\n#define LIGHTS 4\n#endif\nvec4 color[LIGHTS];", 6),
    ];
    let good = [
        "vec3 color;\nmat4 shadow;\nfloat power;",
        "vec3 color; // SHADOWS\nfloat power;",
        "#ifdef SHADOWS\nvec4 color;\n#else\nvec4 color;\n#endif",
        "vec3 color;\n#ifdef FOG\nvec4 fog;\n#endif\nfloat power;",
    ];
    let fixtures: Vec<Fixture> = bad
        .iter()
        .map(|(members, line)| {
            Fixture::of(*members, &[("a.frag", &block(members))], &[("a.frag", *line)])
        })
        .chain(
            good.iter().map(|members| Fixture::of(*members, &[("a.frag", &block(members))], &[])),
        )
        .map(|fixture| fixture.with(settings()))
        .collect();
    Score::of("define-changes-layout", &fixtures).at_least(1.0, 1.0);
    // The member that only the permutation has is named beside the one that it moves.
    let found = fixtures[0].found("define-changes-layout");
    let related = found[0].related();
    let named = related.iter().map(|label| format!("line {}: {}\n", label.at.line, label.text));
    golden().eq(
        named.collect::<String>(),
        str![[r#"
line 5: `shadow` is there only with `SHADOWS`
line 2: the block

"#]],
    );
}

#[test]
fn sizes_that_webgl_refuses_are_said_once_a_file() {
    let settings = || Settings { targets: vec![Target::WebGl2], ..Settings::default() };
    let blocks = |texts: &[&str]| {
        let blocks: String = texts
            .iter()
            .enumerate()
            .map(|(n, members)| format!("layout(std140) uniform B{n} {{ {members} }} b{n};\n"))
            .collect();
        format!("#version 300 es\nprecision highp float;\n{blocks}void main() {{}}\n")
    };
    let short = ["vec4 a; float b;", "vec3 a;", "vec4 a; vec2 b;"];
    let whole = ["vec4 a;", "vec3 a; float b;", "mat4 m;"];
    let mut fixtures = vec![
        Fixture::of("three", &[("a.frag", &blocks(&short))], &[("a.frag", 3)]),
        Fixture::of("whole", &[("a.frag", &blocks(&whole))], &[]),
        Fixture::of("second", &[("a.frag", &blocks(&[whole[0], short[0]]))], &[("a.frag", 4)]),
    ];
    for members in short {
        fixtures.push(Fixture::of(members, &[("a.frag", &blocks(&[members]))], &[("a.frag", 3)]));
    }
    let fixtures: Vec<Fixture> = fixtures.into_iter().map(|f| f.with(settings())).collect();
    Score::of("webgl2-size", &fixtures).at_least(1.0, 1.0);
    // The other two are named with the first.
    assert_eq!(fixtures[0].found("webgl2-size")[0].related().len(), 2);
}
