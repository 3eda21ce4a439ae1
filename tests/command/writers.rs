//! What the command writes and what it must not write over: inputs, files of others, what is
//! behind links; and that a file is the old one or the new one whatever happens meanwhile.

pub mod campaign;
#[cfg(target_os = "linux")]
mod disk;

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};

use snapbox::str;

use crate::cli_check::place::{CLEAN, idle};
use crate::support::command::{Place, Ran, golden};

const LEGACY: &str = "#version 120
uniform vec3 tint;
void main() { gl_FragColor = vec4(tint, 1.0); }
";

const WITH: &str = "#version 450
#include \"light.inc\"
layout(std140, binding = 0) uniform B { Light light; } b;
layout(location = 0) out vec4 color;
float bend(float x) { return x * b.light.color.x; }
void main() { color = b.light.color; }
";

/// A project whose files are inputs of one command or another.
fn project(name: &str) -> Place {
    let place = Place::new(&format!("writers-{name}"));
    place.write("s/a.frag", WITH).write("s/light.inc", "struct Light { vec4 color; };\n");
    place.write("s/old.frag", LEGACY).write("v.json", "{}").write("d.svg", "{\"x\": [0, 1]}");
    place
}

/// A scene without a shader.
pub fn scene() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/scenes/six_lights.json");
    let mut scene: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    scene.as_object_mut().unwrap().retain(|key, _| key != "shader" && key != "$schema");
    scene.to_string()
}

/// Every file below a folder with its bytes, links as where they lead.
pub fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let shown = path.display().to_string();
        if path.is_symlink() {
            let leads = fs::read_link(&path).unwrap();
            found.push((shown, leads.display().to_string().into_bytes()));
        } else if path.is_dir() {
            found.extend(files(&path));
        } else if path.is_file() {
            found.push((shown, fs::read(&path).unwrap()));
        }
    }
    found.sort();
    found
}

#[test]
fn no_output_is_written_over_an_input() {
    let place = project("inputs");
    assert_eq!(place.run(&["lock", "s"]).code, 0);
    let shard = ["check", "s", "--shard", "1/1", "-f", "json=r.json"];
    assert_eq!(place.run(&shard).code, 0);
    let run = ["--samples", "50", "--time", "1"];
    let map = ["--map-x", "x", "--map-y", "b.light.color.x"];
    let cases: [(&str, Vec<&str>); 16] = [
        ("s/a.frag", vec!["emit", "s/a.frag", "--lang", "rust", "-o"]),
        ("s/light.inc", vec!["emit", "s/a.frag", "--lang", "c", "-o"]),
        ("s/a.frag", vec!["encode", "s/a.frag", "v.json", "-o"]),
        ("v.json", vec!["encode", "s/a.frag", "v.json", "-o"]),
        ("v.json", vec!["encode", "s/a.frag", "v.json", "--hex", "-o"]),
        ("s/light.inc", vec!["encode", "s/a.frag", "v.json", "-o"]),
        ("s/old.frag", vec!["port", "s/old.frag", "-o"]),
        ("s/a.frag", vec!["port", "s/old.frag", "--partner", "s/a.frag", "-o"]),
        ("s/a.frag", vec!["check", "s", "-f", "json="]),
        ("s/light.inc", vec!["check", "s", "-f", "sarif="]),
        ("landfall.toml", vec!["check", "s", "-f", "human="]),
        ("layouts/s/a.frag.json", vec!["check", "s", "-f", "junit="]),
        ("r.json", vec!["merge", "r.json", "-f", "json="]),
        ("s/a.frag", vec!["merge", "r.json", "-f", "github="]),
        (
            "d.svg",
            [
                &["stress", "s/a.frag", "--fn", "bend", "--domain", "d.svg"],
                &run[..],
                &map,
                &["--map"],
            ]
            .concat(),
        ),
        (
            "d.svg",
            vec![
                "bench",
                "s/a.frag",
                "--fn",
                "bend",
                "--domain",
                "d.svg",
                "--backend",
                "cpu",
                "--rounds",
                "3",
                "--samples",
                "16",
                "--plot",
            ],
        ),
    ];
    // What each command said, with its target as `FILE`.
    let mut said = BTreeSet::new();
    for (target, command) in cases {
        let kind = Path::new(target).extension().unwrap().to_str().unwrap();
        let (link, hard) = (format!("link.{kind}"), format!("hard.{kind}"));
        symlink(target, place.0.join(&link)).unwrap();
        fs::hard_link(place.0.join(target), place.0.join(&hard)).unwrap();
        let before = files(&place.0);
        let behind = format!("/proc/self/cwd/{target}");
        for target in [target, &link, &hard, &behind] {
            let mut all = command.clone();
            let joined = format!("{}{target}", all.last().unwrap());
            match all.last().unwrap().ends_with('=') {
                true => *all.last_mut().unwrap() = &joined,
                false => all.push(target),
            }
            let ran = place.run(&all);
            assert_eq!(ran.code, 2, "{all:?}: {}\n{}", ran.out, ran.err);
            said.insert(ran.err.replace(&format!("`{target}`"), "`FILE`"));
            assert!(files(&place.0) == before, "{all:?} changed a file");
        }
        fs::remove_file(place.0.join(link)).unwrap();
        fs::remove_file(place.0.join(hard)).unwrap();
    }
    golden().eq(
        said.into_iter().collect::<String>(),
        str![[r#"
error[output]: `FILE` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]],
    );
}

#[test]
fn a_picture_is_not_written_over_the_one_it_is_compared_with_nor_over_the_scene() {
    let place = project("picture");
    place.write("scene.pfm", scene());
    let render = ["render", "scene.pfm", "--reference", "--model", "multi", "--size", "8x8", "-o"];
    let ran = place.run(&[&render[..], &["a.png"]].concat());
    assert_eq!(ran.code, 0, "{}", ran.err);
    let before = files(&place.0);
    let over = [&render[..], &["scene.pfm"]].concat();
    place.run(&over).code(2).stderr_eq(str![[r#"
error[output]: `scene.pfm` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]]);
    let compared = [&render[..], &["a.png", "--compare", "a.png"]].concat();
    place.run(&compared).code(2).stderr_eq(str![[r#"
error[output]: `a.png` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]]);
    let unchanged = |path: &str| {
        let at = place.0.join(path).display().to_string();
        before.iter().find(|(name, _)| *name == at).unwrap().1 == fs::read(at).unwrap()
    };
    assert!(unchanged("scene.pfm") && unchanged("a.png"));
}

#[test]
fn two_reports_of_one_file_by_two_names_are_refused() {
    let place = Place::new("writers-twice");
    place.write("a.frag", CLEAN).write("r.json", "");
    symlink("r.json", place.0.join("link.json")).unwrap();
    let command = ["check", "a.frag", "-f", "json=r.json", "-f", "sarif=link.json"];
    place.run(&command).code(2).stderr_eq(str![[r#"
error[output]: `link.json` is an input of this command, and would be overwritten
  |
  = help: name another file for the output


"#]]);
    assert!(place.read("r.json").contains("\"findings\""));
}

#[test]
fn locks_are_neither_written_over_files_of_others_nor_are_those_removed() {
    let place = Place::new("writers-locks");
    place.write("a.frag", CLEAN).write("assets/a.frag.json", "{\"mine\": 1}");
    place.write("assets/gone.frag.json", "{\"mine\": [\"schema_version\", 2]}");
    place.write("assets/bytes.frag.json", [0xff, 0, 1]);
    let before = files(&place.0.join("assets"));
    let command = ["lock", "--locks", "assets", "--prune"];
    place.run(&command).code(2).stderr_eq(str![[r#"
error[unreadable-file]: `assets/a.frag.json` has the name of a lock but is not a landfall lock
  |
  = help: move it away, keep locks elsewhere with `--locks DIR`, or overwrite it with `--force`

0 locks written, 0 unchanged

"#]]);
    assert!(files(&place.0.join("assets")) == before);
    // A lock that was cut off, or that git could not merge, is one.
    assert_eq!(place.run(&["lock", "--locks", "assets", "--force"]).code, 0);
    let lock = place.read("assets/a.frag.json");
    let conflict = format!("<<<<<<< HEAD\n{lock}=======\n{lock}>>>>>>> other\n");
    for broken in [&lock[..lock.len() / 2], &conflict, ""] {
        place.write("assets/a.frag.json", broken);
        assert_eq!(place.run(&["lock", "--locks", "assets"]).code, 0);
        assert_eq!(place.read("assets/a.frag.json"), lock);
    }
    place.write("assets/left.frag.json", &lock);
    assert_eq!(place.run(&["lock", "--locks", "assets", "--prune"]).code, 0);
    assert!(!place.has("assets/left.frag.json"), "a lock without a shader is removed");
    assert!(place.has("assets/gone.frag.json") && place.has("assets/bytes.frag.json"));
    let orphans = ["check", "-A", "all", "-W", "lock-orphan", "--locks", "assets", "-f", "short"];
    assert_eq!(place.run(&orphans).out, "", "nor is a file of others an orphan");
}

#[test]
fn layouts_are_written_only_over_layouts() {
    let place = Place::new("writers-layouts");
    place.write("a.frag", CLEAN);
    for format in ["table", "listing", "json", "csv", "md"] {
        let command = ["layout", "a.frag", "-f", format, "--out", "o"];
        let extension = if matches!(format, "table" | "listing") { "txt" } else { format };
        let target = format!("o/a.frag.{extension}");
        place.write(&target, "mine, all of it\n");
        let said = place.run(&command).code(2).err.replace(&target, "FILE");
        golden().eq(
            said,
            str![[r#"
error[output]: `FILE` already exists and was not written by `landfall layout`
  |
  = help: name another directory, or overwrite it with `--force`


"#]],
        );
        assert_eq!(place.read(&target), "mine, all of it\n");
        assert_eq!(place.run(&[&command[..], &["--force"]].concat()).code, 0);
        let written = place.read(&target);
        place.write("a.frag", format!("{CLEAN}// another\n"));
        assert_eq!(place.run(&command).code, 0, "{format}: one of ours is written anew");
        assert_eq!(place.read(&target), written);
    }
}

#[test]
fn a_folder_with_a_cache_keeps_the_files_of_others() {
    let place = Place::new("writers-cache");
    place.write("a.frag", CLEAN);
    for i in 0..40 {
        place.write(&format!("check-{i}.json"), "mine");
    }
    for i in 0..24 {
        // Other settings, another cache: there are more than are kept.
        let define = format!("N={i}");
        let ran = place.run(&["check", "a.frag", "--cache-dir", ".", "--define", &define]);
        assert_eq!(ran.code, 0, "{}", ran.err);
    }
    for i in 0..40 {
        assert_eq!(place.read(&format!("check-{i}.json")), "mine");
    }
    let count = fs::read_dir(&place.0).unwrap().count();
    assert_eq!(count, 40 + 16 + 2, "the oldest of our own are gone");
}

#[test]
fn a_cache_of_somebody_elses_or_one_that_was_changed_says_nothing() {
    let place = Place::new("writers-forged");
    place.write("a.frag", CLEAN.replace("    vec4 color;\n}", "    vec4 color; // offset 99\n}"));
    let check = ["check", "a.frag", "-W", "stale-comment", "--cache-dir", "c", "-f", "short"];
    let with =
        |key: &str| Ran::of(place.command(&check).env("LANDFALL_CACHE_KEY", key).output().unwrap());
    let honest = with("the key of whoever checks");
    honest
        .stdout_eq(str![[r#"
a.frag:4:27: warning[stale-comment] comment puts `color` at offset 99, but it is at 16

"#]])
        .stderr_eq(str![[r#"
checked 1 shader: 1 warning; 1 fixable with --fix
laid out 1 of 1 shader, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
    with("the key of whoever checks").stderr_eq(str![[r#"
checked 1 shader: 1 warning; 1 fixable with --fix
laid out 0 of 1 shader, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
    let other = with("the key of somebody else");
    other.stderr_eq(str![[r#"
checked 1 shader: 1 warning; 1 fixable with --fix
laid out 1 of 1 shader, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
    assert_eq!(other.out, honest.out);
    // Now the cache is theirs; to us it is worth nothing.
    with("the key of whoever checks").stderr_eq(str![[r#"
checked 1 shader: 1 warning; 1 fixable with --fix
laid out 1 of 1 shader, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
    let name = fs::read_dir(place.0.join("c")).unwrap().map(|entry| entry.unwrap().path());
    let file = name.filter(|path| path.extension().is_some_and(|e| e == "json")).last().unwrap();
    let text = fs::read_to_string(&file).unwrap();
    let start = text.find("\"findings\":[{").expect("the cache remembers the finding");
    let end = text.find(",\"blocks\"").expect("the blocks come next");
    let silenced = format!("{}\"findings\":[]{}", &text[..start], &text[end..]);
    fs::write(&file, silenced).unwrap();
    let after = with("the key of whoever checks");
    after.code(honest.code).stderr_eq(str![[r#"
checked 1 shader: 1 warning; 1 fixable with --fix
laid out 1 of 1 shader, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
    assert_eq!(after.out, honest.out);
}

#[test]
fn nothing_is_written_through_a_link_out_of_the_tree() {
    let outside = Place::new("writers-outside");
    outside.write("kept", "kept");
    outside.write("far.frag", idle());
    let away = outside.0.display().to_string();
    let before = files(&outside.0);
    let fresh = |name: &str| {
        let place = Place::new(&format!("writers-links-{name}"));
        place.write("a.frag", CLEAN);
        place
    };
    let cases: [(&str, &str, &str, &[&str]); 8] = [
        ("locks", &away, "layouts", &["lock"]),
        ("lock", "../../writers-outside/new.json", "layouts/a.frag.json", &["lock"]),
        ("accept", &away, "layouts", &["check", "--accept", "--locks", "layouts/../layouts/x"]),
        (
            "out",
            "../../writers-outside/new.txt",
            "o/a.frag.txt",
            &["layout", "a.frag", "--out", "o"],
        ),
        ("deep", &away, "o/s", &["layout", ".", "--out", "o"]),
        (
            "emit",
            "../writers-outside/new.rs",
            "m.rs",
            &["emit", "a.frag", "--lang", "rust", "-o", "m.rs"],
        ),
        (
            "encode",
            &format!("{away}/kept"),
            "v.bin",
            &["encode", "a.frag", "v.json", "-o", "v.bin"],
        ),
        (
            "fix",
            &format!("{away}/far.frag"),
            "l.frag",
            &["check", "--fix", "-W", "unused-allow", "-W", "stale-comment"],
        ),
    ];
    let mut said = String::new();
    for (name, leads, link, command) in cases {
        let place = fresh(name);
        place.write("s/b.frag", CLEAN).write("v.json", "{}");
        let link = place.0.join(link);
        fs::create_dir_all(link.parent().unwrap()).unwrap();
        symlink(leads, link).unwrap();
        let ran = place.run(command);
        assert!(files(&outside.0) == before, "{name}: {command:?} wrote outside\n{}", ran.err);
        if name != "accept" {
            ran.code(2);
            said += &format!("{name}: {}{}", ran.err, ran.out);
        }
    }
    golden().eq(said, str![[r#"
locks: error[output]: `layouts/a.frag.json` leads through a symbolic link to `[TMP]/writers-outside/a.frag.json`, out of `[TMP]/writers-links-locks`
  |
  = help: remove the link, or name its target

error[output]: `layouts/s/b.frag.json` leads through a symbolic link to `[TMP]/writers-outside/s/b.frag.json`, out of `[TMP]/writers-links-locks`
  |
  = help: remove the link, or name its target

0 locks written, 0 unchanged
lock: error[output]: `layouts/a.frag.json` leads through a symbolic link to `[TMP]/writers-outside/new.json`, out of `[TMP]/writers-links-lock`
  |
  = help: remove the link, or name its target

1 lock written, 0 unchanged
out: error[output]: `o/a.frag.txt` leads through a symbolic link to `[TMP]/writers-outside/new.txt`, out of `[TMP]/writers-links-out/o`
  |
  = help: remove the link, or name its target

deep: error[output]: `o/s/b.frag.txt` leads through a symbolic link to `[TMP]/writers-outside/b.frag.txt`, out of `[TMP]/writers-links-deep/o`
  |
  = help: remove the link, or name its target

emit: error[output]: `m.rs` leads through a symbolic link to `[TMP]/writers-outside/new.rs`, out of `[TMP]/writers-links-emit`
  |
  = help: remove the link, or name its target

encode: error[output]: `v.bin` leads through a symbolic link to `[TMP]/writers-outside/kept`, out of `[TMP]/writers-links-encode`
  |
  = help: remove the link, or name its target

fix: checked 3 shaders: 1 error, 1 warning; 1 fixable with --fix
fixed 0 edits in 0 files
no layouts are locked: `landfall lock` records them, so that check can tell when one changes
error[output]: `l.frag` leads through a symbolic link to `[TMP]/writers-outside/far.frag`, out of `[TMP]/writers-links-fix`
 --> l.frag
  |
  = help: remove the link, or name its target

warning[unused-allow]: `allow(stale-comment)` suppresses nothing in line 4
 --> l.frag:4:36
  |
4 |     vec4 color; // landfall: allow(stale-comment)
  |                                    ^^^^^^^^^^^^^ no such finding
  |
  = help: remove it

3 shaders: 1 error, 1 warning

"#]]);
    // A cache is no more than a help: it is left out.
    let place = fresh("cache");
    symlink(&away, place.0.join("c")).unwrap();
    place.write("landfall.toml", "cache-dir = \"c\"\n");
    let ran = place.run(&["check"]);
    ran.code(0).stderr_eq(str![[r#"
the cache is not used: `c/check-[HASH].json` leads through a symbolic link to `[TMP]/writers-outside/check-[HASH].json`, out of `[TMP]/writers-links-cache`
help: remove the link, or name its target
checked 1 shader: no findings
laid out 1 of 1 shader, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
    assert!(files(&outside.0) == before);
}

#[test]
fn a_read_only_file_stays() {
    let place = project("readonly");
    place.write("m.rs", "mine");
    let mut permissions = fs::metadata(place.0.join("m.rs")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(place.0.join("m.rs"), permissions).unwrap();
    let command = ["emit", "s/a.frag", "--lang", "rust", "-o", "m.rs"];
    place.run(&command).code(2).stderr_eq(str![[r#"
error[output]: `m.rs` cannot be written: it is read-only
  |
  = help: make it writable, or name another file


"#]]);
    assert_eq!(place.read("m.rs"), "mine");
}

#[test]
fn what_a_killed_process_left_is_removed_and_nothing_else() {
    let place = Place::new("writers-partial");
    place.write("a.frag", CLEAN);
    let mut gone = Command::new("true").stdin(Stdio::null()).spawn().unwrap();
    gone.wait().unwrap();
    let left = format!("layouts/.landfall-{}-0badcafe-3.partial", gone.id());
    let alive = format!("layouts/.landfall-{}-0badcafe-3.partial", std::process::id());
    let others = ["layouts/.landfall-notes.partial", "layouts/a.frag.json.partial"];
    for path in [&left, &alive].into_iter().map(String::as_str).chain(others) {
        place.write(path, "half of");
    }
    assert_eq!(place.run(&["lock"]).code, 0);
    assert!(!place.has(&left) && place.has(&alive));
    assert!(others.iter().all(|other| place.has(other)));
}

#[test]
#[cfg(target_os = "linux")]
fn a_closed_stdout_is_an_error_where_a_product_would_be_lost() {
    let place = project("closed");
    let closed = |arguments: &str| {
        let script = format!("exec {} {arguments} >&-", env!("CARGO_BIN_EXE_landfall"));
        let mut command = Command::new("sh");
        command.args(["-c", &script]).current_dir(&place.0).stdin(Stdio::null());
        Ran::of(command.output().unwrap())
    };
    for command in [
        "layout s/a.frag",
        "layout s/a.frag -f json",
        "explain s/a.frag b.light.color",
        "emit s/a.frag --lang c",
        "port s/old.frag",
        "encode s/a.frag v.json",
        "encode s/a.frag v.json --hex",
        "verify s/a.frag --backend cpu",
        "lights s/a.frag",
        "check s",
        "check s -f sarif",
        "rule",
        "schema lock",
        "devices -f json",
    ] {
        let ran = closed(command);
        ran.code(2).stderr_eq(str![[r#"
error[output]: `<stdout>` is closed: the output would be lost
  |
  = help: redirect it to a file, or to /dev/null to discard it


"#]]);
    }
    for command in ["--help", "--version", "check --help"] {
        let ran = closed(command);
        ran.code(2).stderr_eq("error: standard output cannot be written: it is closed\n");
    }
    for command in ["lock s", "emit s/a.frag --lang c -o h.h", "check s -f json=r.json -f short=r"]
    {
        let ran = closed(command);
        assert_eq!(ran.code, 0, "{command} prints no product: {}", ran.err);
    }
    let null = place.command(&["layout", "s/a.frag"]).stdout(Stdio::null()).output().unwrap();
    assert_eq!(null.status.code(), Some(0), "/dev/null is where somebody sent it");
}
