//! One hostile name, in a path, an include, comments, a lock and a scene, through every command
//! and format: nothing of it acts on a terminal, in a log of GitHub's, in Markdown, HTML, SVG or
//! generated code.

use std::fs;

use snapbox::str;

use crate::support::c::{BOTH, compile};
use crate::support::command::{Place, Ran};
use crate::support::rustc;
use crate::writers::scene;

/// A workflow command, a bidi mark, Markdown's and HTML's signs, an escape sequence, a C1 control,
/// ends of lines and a second command. No `/`: it is one name.
const NAME: &str =
    "::error file=x::\u{202e}`a|<b>\u{1b}[2J\u{9b}\n##[error]p\n::warning::w \u{2066}.frag";

const INCLUDE: &str = "::inc\u{202e}\u{1b}[31m.glsl";

const LIGHT: &str = "// ::error::c \u{202e} x
struct Light { vec4 color; /* \u{202e}
::error::member
 ##[group]x \u{1b}[2J */ };
";

fn shader() -> String {
    format!(
        "#version 450
// ::error::first \u{202e}
/*
::error::block \u{202e} \u{1b}[2J \u{9b}
*/
#include \"{INCLUDE}\"
layout(std140, binding = 0) uniform B {{ Light l; // \u{202e} hi ::error::
   float a; // 0..3 offset 99
   float b; }};
layout(location = 0) out vec4 c;
/*
::error::in code */
float f(float x) {{ return x / (a - a) + pow(x, -1.0); }}
void main() {{ c = l.color * f(1.0); }}
"
    )
}

fn project(name: &str) -> Place {
    let place = Place::new(&format!("hostile-{name}"));
    place.write(NAME, shader()).write(INCLUDE, LIGHT);
    place.write(&format!("d/{NAME}"), shader()).write(&format!("d/{INCLUDE}"), LIGHT);
    place
}

fn run(place: &Place, arguments: &[&str]) -> Ran {
    Ran::of(place.command(arguments).env("GITHUB_ACTIONS", "true").output().unwrap())
}

/// A text without styles of ours (SGR).
fn unstyled(text: &str) -> String {
    let mut result = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("\u{1b}[") {
        let inside = &rest[at + 2..];
        let end = inside.find(|c: char| !c.is_ascii_digit() && c != ';').unwrap_or(0);
        match inside[end..].starts_with('m') {
            true => {
                result.push_str(&rest[..at]);
                rest = &inside[end + 1..];
            }
            false => {
                result.push_str(&rest[..at + 2]);
                rest = inside;
            }
        }
    }
    result + rest
}

/// What a text must not hold, whatever reads it.
fn holds_back(text: &str, what: &str) {
    let text = unstyled(text);
    shows_all(&text, what);
    // `::: ` is the mark of another place in an excerpt: no command has the name `:`.
    let command = |line: &&str| {
        let line = line.trim_start();
        line.starts_with("::") && !line.starts_with("::: ") || line.contains("##[")
    };
    if let Some(line) = text.lines().find(command) {
        panic!("{what}: {line:?} is a command to GitHub");
    }
}

/// What no file must hold, for terminals show them, too.
fn shows_all(text: &str, what: &str) {
    let acts = |c: char| {
        c.is_control() && c != '\n' && c != '\t'
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}')
            || matches!(c, '\u{2028}' | '\u{2029}' | '\u{2066}'..='\u{2069}')
    };
    if let Some(line) = text.lines().find(|line| line.contains(acts)) {
        panic!("{what}: {line:?} acts on a terminal");
    }
}

fn checked(place: &Place, arguments: &[&str]) -> Ran {
    let ran = run(place, arguments);
    holds_back(&ran.out, &format!("{arguments:?} on stdout"));
    holds_back(&ran.err, &format!("{arguments:?} on stderr"));
    ran
}

#[test]
fn no_command_prints_what_acts_on_a_terminal_or_in_a_log() {
    let place = project("all");
    assert!(checked(&place, &["layout", NAME]).out.contains("uniform B"));
    for format in ["table", "listing", "json", "csv", "md"] {
        let ran = checked(&place, &["layout", ".", "-f", format]);
        assert!(ran.out.contains("color"), "{format}: {}", ran.err);
        checked(&place, &["layout", ".", "-f", format, "--color", "always"]);
    }
    for format in ["human", "json"] {
        checked(&place, &["explain", NAME, "l.color", "-f", format]);
        checked(&place, &["verify", ".", "--backend", "cpu", "-f", format]);
        checked(&place, &["lights", ".", "-f", format]);
        checked(&place, &["run", NAME, "--fn", "f", "--args", "[1]", "-f", format]);
        checked(&place, &["stress", NAME, "--fn", "f", "--samples", "50", "-f", format]);
    }
    checked(&place, &["verify", ".", "--backend", "cpu", "--color", "always"]);
    checked(&place, &["report", "."]);
    for format in ["human", "short", "json", "sarif", "junit", "html"] {
        let ran = checked(&place, &["check", "-W", "all", "-f", format]);
        assert!(ran.out.contains("stale-comment"), "{format}: {}", ran.out);
        checked(&place, &["check", "-W", "all", "-f", format, "--color", "always"]);
    }
    checked(&place, &["check", "-W", "all", "--diff"]);
    for lang in ["rust", "c"] {
        assert_eq!(checked(&place, &["emit", NAME, "--lang", lang]).code, 0);
    }
    checked(&place, &["port", NAME]);
    place.write("v.json", "{\"a\": \"\u{1b}[2J\u{202e}\"}");
    checked(&place, &["encode", NAME, "v.json"]);
    place.write("v.bin", vec![1; 32]);
    for format in ["table", "json"] {
        checked(&place, &["decode", NAME, "v.bin", "-f", format]);
    }
    // Values that the parser of arguments refuses.
    for (option, command) in [("-f", "layout"), ("--rules", "layout"), ("--samples", "stress")] {
        let ran = checked(&place, &[command, NAME, option, NAME]);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{option}");
        assert!(ran.err.starts_with("error: invalid value "), "{option}: {}", ran.err);
    }
    checked(&place, &[NAME]);
    // Names that are not there, in every message of a file that cannot be read or written.
    let gone = format!("gone{NAME}");
    for command in [
        &["layout", &gone][..],
        &["check", &gone],
        &["lock", &gone],
        &["emit", NAME, "--lang", "c", "-o", &format!("v.bin/{NAME}")],
        &["layout", NAME, "-b", NAME],
        &["explain", NAME, NAME],
        &["check", "-A", NAME],
        &["check", "--config", &gone],
        &["render", &gone, "--reference"],
        &["run", NAME, "--fn", NAME],
    ] {
        assert_eq!(checked(&place, command).code, 2, "{command:?}");
    }
}

#[test]
fn annotations_are_the_only_commands_of_a_check_for_github() {
    let place = project("github");
    let ran = run(&place, &["check", "-W", "all", "-f", "github"]);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert!(!lines.is_empty());
    for line in lines {
        let ours = ["::error file=", "::warning file=", "::notice "];
        assert!(ours.iter().any(|start| line.starts_with(start)), "{line:?}");
        // The path's own colons are escaped: one command a line, ours.
        let properties = line[2..].split("::").next().unwrap();
        assert!(
            properties.contains("file=%3A%3Aerror") || properties.contains("file=d/%3A%3Aerror")
        );
    }
}

#[test]
fn locks_and_differences_show_names_as_names() {
    let place = project("lock");
    assert_eq!(checked(&place, &["lock"]).code, 0);
    let lock = format!("layouts/{NAME}.json");
    place.write(NAME, shader().replace("float a;", "vec3 a;"));
    checked(&place, &["lock", "--check"]);
    for format in ["human", "json", "md"] {
        let ran = checked(&place, &["diff", &lock, NAME, "-f", format]);
        assert_eq!(ran.code, 1, "{format}: {}", ran.err);
        assert!(ran.out.contains("breaking"), "{format}");
        checked(&place, &["diff", &lock, NAME, "-f", format, "--color", "always"]);
    }
    // A lock that somebody wrote has names that no shader has.
    let text =
        place.read(&lock).replace("\"name\": \"B\"", "\"name\": \"B\\n::error::\\u202e\\u001b\"");
    place.write(&lock, text);
    let ran = checked(&place, &["diff", &lock, NAME]);
    ran.code(2).stderr_eq(str![[r#"
error[cannot-run]: `layouts/::error file=x::�`a|<b>␛[2J�
                   #﹟[error]p
                   ./::warning::w �.frag.json` has a control character in `name`, at line 6
  |
  = help: locks are not edited by hand: write it again with `landfall lock`


"#]]);
    checked(&place, &["check"]);
}

#[test]
fn markdown_has_no_sign_of_the_name() {
    let place = project("markdown");
    place.write("a.json", place_lock(&place));
    for arguments in [&["layout", NAME, "-f", "md"][..], &["diff", "a.json", NAME, "-f", "md"]] {
        let ran = checked(&place, arguments);
        assert!(ran.out.contains('#'), "{arguments:?}: {}", ran.err);
        for sign in ["<b>", "`a|", "a|"] {
            assert!(!ran.out.contains(sign), "{arguments:?} has {sign}: {}", ran.out);
        }
    }
    let summary = place.0.join("summary.md");
    let mut command = place.command(&["check", "-W", "all", "-f", "github"]);
    command.env("GITHUB_STEP_SUMMARY", &summary).output().unwrap();
    let text = fs::read_to_string(summary).unwrap();
    assert!(!text.contains("<b>") && !text.contains('\u{202e}') && text.contains("stale-comment"));
}

/// The lock of the same shader before a member changed.
fn place_lock(place: &Place) -> String {
    let other = Place::new("hostile-other");
    other.write("a.frag", shader().replace("float a;", "vec4 a;"));
    other.write(INCLUDE, place.read(INCLUDE));
    assert_eq!(other.run(&["lock"]).code, 0);
    other.read("layouts/a.frag.json")
}

#[test]
fn generated_code_of_a_hostile_name_compiles() {
    let place = project("code");
    assert_eq!(run(&place, &["emit", ".", "--lang", "rust", "-o", "mirrors.rs"]).code, 0);
    let crates = rustc::crates(rustc::Math::Simd);
    let file = place.0.join("mirrors.rs");
    let out = rustc::check("rustc", crates, &file, "2021", rustc::Target::Library);
    assert!(out.status.success(), "{}", rustc::shown(&out.stderr));
    shows_all(&place.read("mirrors.rs"), "mirrors.rs");
    assert_eq!(run(&place, &["emit", ".", "--lang", "c", "-o", "lights.h"]).code, 0);
    place.write("main.c", "#include \"lights.h\"\nint main(void) { return 0; }\n");
    for compiler in BOTH {
        if let Err(log) = compile(compiler, &place.0, "main.c") {
            panic!("{compiler:?}: {log}");
        }
    }
    shows_all(&place.read("lights.h"), "lights.h");
}

#[test]
fn drawings_and_pages_of_a_hostile_name_are_sound() {
    let place = project("svg");
    let stress = ["stress", NAME, "--fn", "f", "--samples", "50", "--map-x", "x", "--map-y", "a"];
    for file in ["map.svg", "map.html"] {
        let ran = checked(&place, &[&stress[..], &["--map", file]].concat());
        assert!(place.has(file), "{}", ran.err);
        let text = place.read(file);
        assert!(!text.contains("<b>"), "{file}");
        shows_all(&text, file);
        if file.ends_with("svg") {
            roxmltree::Document::parse(&text).expect("XML");
        }
    }
    let bench =
        ["bench", NAME, "--fn", "f", "--backend", "cpu", "--rounds", "3", "--samples", "16"];
    let variant = "\u{202e}<b>\n::error::x\u{1b}[2J=#f".to_string();
    let ran = checked(&place, &[&bench[..], &["--plot", "p.svg", "--variant", &variant]].concat());
    assert!(place.has("p.svg"), "{}", ran.err);
    roxmltree::Document::parse(&place.read("p.svg")).expect("XML");
    shows_all(&place.read("p.svg"), "p.svg");
}

#[test]
fn strings_of_a_scene_are_shown_as_text() {
    let place = project("scene");
    let hostile = "\"name\":\"::error::x\\n::error::\\u202e\\u001b[2J\\u009b##[error]\"";
    let scene = scene().replace("\"name\":\"six lights\"", hostile);
    assert!(scene.contains(hostile));
    place.write(NAME, scene);
    let render = ["render", NAME, "--reference", "--model", "multi", "--size", "8x8"];
    for more in [&[][..], &["-f", "json"], &["--color", "always"], &["-o", "p.png"]] {
        let ran = checked(&place, &[&render[..], more].concat());
        assert_eq!(ran.code, 0, "{}", ran.err);
    }
    checked(&place, &["render", NAME, "--reference", "--model", NAME]);
}

#[test]
fn a_patch_to_a_file_is_exact() {
    let place = project("patch");
    let text = "/*\n::odd */ // landfall: allow(stale-comment)\nvoid main";
    place.write("d/x.frag", shader().replace("void main", text));
    let out = fs::File::create(place.0.join("patch")).unwrap();
    let mut command = place.command(&["check", "d/x.frag", "--diff", "-W", "all"]);
    command.env("GITHUB_ACTIONS", "true").stdout(out).status().unwrap();
    let patch = place.read("patch");
    assert!(patch.contains("::odd") && !patch.contains("./::odd"), "{patch}");
}

/// A shader of OpenGL without blocks that clash, for commands that write or run shaders.
const PLAIN: &str = "#version 330
struct Light { vec4 position; vec4 color; };
layout(std140) uniform B { Light l; float a; };
uniform vec3 tint;
in vec3 v_normal;
in vec3 v_position;
out vec4 c;
float f(float x) { return x / (a - a); }
mat3 inverse(mat3 m) { return m; }
void main() {
    vec3 to = normalize(l.position.xyz - v_position);
    c = vec4(l.color.rgb * tint * max(dot(to, v_normal), 0.0), 1.0);
}
";

#[test]
fn what_runs_and_ports_a_shader_shows_its_name_as_text() {
    let place = Place::new("hostile-runs");
    let shader = format!("s/{NAME}");
    place.write(&shader, PLAIN);
    let scene = scene().replace("\"name\":\"six lights\"", "\"name\":\"::error::\\u202e\"");
    place.write("scene.json", scene);
    let own = ["--shader", &shader, "--size", "8x8", "--leave-out"];
    for format in ["human", "json"] {
        for more in [&[][..], &["--print-bind"], &["--details", "--skip", "tiles=4"]] {
            let render = [&["render", "scene.json", "-f", format][..], &own, more].concat();
            assert!(checked(&place, &render).code < 2, "{more:?}");
        }
        checked(&place, &["prove", &shader, "--fn", "f", "-f", format, "--time", "1"]);
    }
    let bench = ["bench", &shader, "--fn", "f", "--rounds", "3", "--samples", "9"];
    let variant = format!("{}=#f", NAME.replace('=', ""));
    for format in ["human", "json", "csv"] {
        let more = ["--backend", "cpu", "--variant", &variant, "-f", format];
        assert_eq!(checked(&place, &[&bench[..], &more].concat()).code, 0, "{format}");
    }
    for more in [
        &["--to", "vulkan"][..],
        &["--to", "naga"],
        &["--to", "wgsl"],
        &["--partner", &shader],
        &["--location", &format!("{NAME}=1")],
        &["--block", NAME],
    ] {
        checked(&place, &[&["port", &shader, "-o", "ported"][..], more].concat());
    }
    for command in [&["init", "s", "--print"][..], &["init", &shader], &["init", NAME]] {
        checked(&place, command);
    }
}

#[test]
fn policies_baselines_and_reports_show_names_as_text() {
    let place = Place::new("hostile-guard");
    let shader = format!("s/{NAME}");
    place.write(&shader, PLAIN);
    checked(&place, &["lock", "s"]);
    place.write(&shader, PLAIN.replace("float a;", "vec3 a;"));
    let kept = checked(&place, &["lock", "s", "--policy", "names"]);
    assert!(kept.code == 1 && kept.err.contains("that policy `names` forbids"), "{}", kept.err);
    place.write(&shader, PLAIN.replace("float a;", "mat4 a;"));
    for format in ["human", "json", "md", "html"] {
        for (old, new) in [("layouts", "s"), ("layouts", shader.as_str())] {
            checked(&place, &["diff", old, new, "-f", format, "--policy", "names"]);
        }
    }
    for format in ["human", "short", "json", "sarif", "junit"] {
        let ran = checked(&place, &["check", "s", "-W", "all", "-f", format]);
        assert!(ran.out.contains("layout-drift"), "{format}: {}", ran.err);
    }
    let baseline = ["check", "s", "-W", "all", "--baseline", "base.json"];
    checked(&place, &[&baseline[..], &["--write-baseline"]].concat());
    // An entry that nothing is like any more is named.
    place.write(&shader, PLAIN);
    checked(&place, &baseline);
    checked(&place, &["check", "s", "--against", NAME]);
    checked(&place, &["check", "s", "--cache-dir", NAME]);
}

/// Each key of the configuration with a hostile value, in the commands that read it.
#[test]
fn values_of_the_configuration_are_shown_as_text() {
    let place = Place::new("hostile-configuration");
    place.write("s/a.frag", PLAIN);
    let value = serde_json::to_string(NAME).expect("a string");
    for key in [
        "paths = [%]",
        "exclude = [%]",
        "locks = %",
        "baseline = %",
        "include = [%]",
        "define = [%]",
        "override = [%]",
        "rules = %",
        "targets = [%]",
        "policy = %",
        "permutations = [[%]]",
        "% = 1",
        "[levels]\n% = \"deny\"",
        "[levels]\nwarnings = %",
        "[rename]\nLight = %",
        "[rename]\n% = \"X\"",
        "[[path-levels]]\nfile = %\nlevels = { warnings = \"allow\" }",
        "[[path-policy]]\nfile = %\npolicy = \"bytes\"",
        "[[mirror-group]]\nname = %\ncopies = [{ block = \"B\" }, { block = \"C\" }]",
        "[[mirror-group]]\nname = \"x\"\ncopies = [{ block = % }, { block = \"B\" }]",
        "[[table]]\nblock = %\nsize = 3",
        "[[table]]\nblock = \"B\"\nsize = %",
        "[[table]]\nblock = \"B\"\noffsets = { % = 3 }",
        "[[rust-mirror]]\nfile = %\nstructure = \"P\"\nblock = \"B\"",
        "[[prove]]\nfile = \"s/*\"\nfunction = %",
        "[[prove]]\nfile = \"s/*\"\nfunction = \"f\"\ndomain = { % = [0, 1] }",
        "garbage %",
    ] {
        place.write("landfall.toml", key.replace('%', &value));
        checked(&place, &["check", "s"]);
        checked(&place, &["emit", "s", "--lang", "rust"]);
        checked(&place, &["lock", "--check"]);
    }
}
