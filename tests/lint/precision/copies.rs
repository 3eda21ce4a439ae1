//! `block-mismatch`.

use super::{Fixture, Score};

fn light(members: &str, main: &str) -> String {
    format!(
        "#version 330 core\nlayout(std140) uniform Light {{\n{members}\n}} u_light;\nvoid main() {{ {main} }}\n"
    )
}

const GOOD: &str = "vec3 position;\nvec3 color;\nfloat intensity;\nmat4 view;";

/// Copies that drifted, with the line of the first member that differs.
const DRIFTED: &[(&str, u32)] = &[
    ("vec3 color;\nvec3 position;\nfloat intensity;\nmat4 view;", 3),
    ("vec3 position;\nvec4 color;\nfloat intensity;\nmat4 view;", 4),
    ("vec3 position;\nvec3 color;\nfloat intensity;\nfloat radius;\nmat4 view;", 6),
    ("vec3 position;\nvec3 color;\nmat4 view;\nfloat intensity;", 6),
];

#[test]
fn copies_of_one_block() {
    let good = light(GOOD, "");
    let mut fixtures = Vec::new();
    let pairs = [
        ("s/lit.vert", "s/lit.frag"),
        ("s/lit_vs.glsl", "s/lit_fs.glsl"),
        ("s/vert.glsl", "s/frag.glsl"),
        ("s/5.1.lit.vs", "s/5.1.lit.fs"),
    ];
    for (members, line) in DRIFTED {
        for (vert, frag) in pairs {
            let name = format!("{frag} {line}");
            let drifted = light(members, "");
            fixtures.push(Fixture::of(name, &[(vert, &good), (frag, &drifted)], &[(frag, *line)]));
        }
        // Files that nobody links with each other.
        let drifted = light(members, "");
        for other in ["s/sky.frag", "t/lit.frag", "s/lit2.frag", "s/lit_shadow.frag"] {
            fixtures.push(Fixture::of(other, &[("s/lit.vert", &good), (other, &drifted)], &[]));
        }
    }
    // The same bytes in another spelling.
    let same = light("vec3 position, color; float intensity; mat4 view;", "");
    fixtures.push(Fixture::of("spelling", &[("s/lit.vert", &good), ("s/lit.frag", &same)], &[]));
    Score::of("block-mismatch", &fixtures).at_least(1.0, 1.0);
}

/// A folder of samples, each with its own `Params`, `Light` or `Scene`, as collections have them:
/// blocks of one name share most members, and no two files are of one program.
#[test]
fn a_folder_of_310_unrelated_shaders_gives_no_finding() {
    let members = ["vec4 tint;", "mat4 view;", "vec3 eye;", "float time;", "vec2 size;", "int n;"];
    let names = ["Params", "Light", "Scene", "Camera"];
    let files: Vec<(String, String)> = (0..310)
        .map(|n| {
            let turned = (0..members.len()).map(|m| members[(m + n / 4) % members.len()]);
            let body: Vec<&str> = turned.take(5).collect();
            let name = names[n % names.len()];
            let text = light(&body.join("\n"), "").replace("Light", name);
            (format!("samples/{n:03}_sample.frag"), text)
        })
        .collect();
    let borrowed: Vec<(&str, &str)> =
        files.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
    let score = Score::of("block-mismatch", &[Fixture::of("310", &borrowed, &[])]);
    assert!(score.false_words.is_empty(), "{:#?}", score.false_words);
    // The same blocks as stages of one program are told.
    let stages = [("s/a.vert", borrowed[1].1), ("s/a.frag", borrowed[5].1)];
    Score::of("block-mismatch", &[Fixture::of("stages", &stages, &[("s/a.frag", 3)])])
        .at_least(1.0, 1.0);
}
