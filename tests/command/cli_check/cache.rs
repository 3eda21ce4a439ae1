//! What is remembered from one check to the next, and what is not.

use std::fs;
use std::time::SystemTime;

use snapbox::str;

use crate::cli_check::place::{CLEAN, idle};
use crate::support::command::Place;

const WITH: &str = "#version 450
#include \"light.inc\"
layout(std140, binding = 0) uniform B { Light light; } b;
layout(location = 0) out vec4 color;
void main() { color = b.light.color; }
";

/// Three shaders of which two include one file.
fn tree(name: &str) -> Place {
    let place = Place::new(&format!("check-{name}"));
    place.write("landfall.toml", "include = [\"lib\"]\n");
    place.write("s/a.frag", WITH).write("s/b.frag", WITH).write("s/c.frag", idle());
    place.write("lib/light.inc", "struct Light { vec4 color; };\n");
    place
}

/// How many shaders were laid out, and the report.
fn laid_out(place: &Place, arguments: &[&str]) -> (usize, String) {
    let mut all = vec!["check", "s", "--cache-dir", "cache", "-W", "stale-comment", "-f", "json"];
    all.extend(arguments);
    let ran = place.run(&all);
    let line = ran.err.lines().find_map(|line| line.strip_prefix("laid out "));
    let count =
        line.and_then(|line| line.split(' ').next()).unwrap_or_else(|| panic!("{}", ran.err));
    (count.parse().unwrap(), ran.out)
}

#[test]
fn only_what_changed_is_laid_out_again() {
    let place = tree("cache");
    let (first, report) = laid_out(&place, &[]);
    assert_eq!(first, 3);
    assert_eq!(laid_out(&place, &[]), (0, report.clone()), "and the report is the same");
    let touched = fs::File::options().append(true).open(place.0.join("s/a.frag")).unwrap();
    touched.set_modified(SystemTime::UNIX_EPOCH).unwrap();
    assert_eq!(laid_out(&place, &[]), (0, report.clone()), "a touch changes nothing");
    place.write("lib/light.inc", "struct Light { vec3 color; };\n");
    assert_eq!(laid_out(&place, &["-A", "unused-allow"]).0, 3, "other levels, other cache");
    assert_eq!(laid_out(&place, &[]).0, 2, "an include concerns those that include it");
    place.write("s/c.frag", CLEAN);
    let (count, after) = laid_out(&place, &[]);
    assert_eq!(count, 1);
    assert!(report.contains("unused-allow") && !after.contains("unused-allow"));
    place.write("s/d.frag", CLEAN);
    assert_eq!(laid_out(&place, &[]).0, 1);
    fs::remove_file(place.0.join("s/d.frag")).unwrap();
    assert_eq!(laid_out(&place, &[]), (0, after));
}

#[test]
fn what_is_read_with_other_macros_or_folders_is_laid_out_again() {
    let place = tree("cache-settings");
    place.write("more/light.inc", "struct Light { vec4 color; float more; };\n");
    assert_eq!(laid_out(&place, &[]).0, 3);
    for flags in [
        &["--define", "N=1"][..],
        &["--define", "N=2"],
        &["-I", "more"],
        &["--rules", "scalar"],
        &["--gather"],
        &["--target", "gl33"],
    ] {
        assert_eq!(laid_out(&place, flags).0, 3, "{flags:?}");
        assert_eq!(laid_out(&place, flags).0, 0, "{flags:?}");
    }
    assert_eq!(laid_out(&place, &[]).0, 0, "what others remember does not replace it");
}

#[test]
fn a_file_that_would_be_included_instead_counts_as_a_change() {
    let place = tree("cache-shadow");
    assert_eq!(laid_out(&place, &[]).0, 3);
    place.write("s/light.inc", "struct Light { vec4 color; float more; };\n");
    assert_eq!(laid_out(&place, &[]).0, 2);
    fs::remove_file(place.0.join("s/light.inc")).unwrap();
    assert_eq!(laid_out(&place, &[]).0, 2);
}

#[test]
fn a_shader_that_failed_is_looked_at_again() {
    let place = tree("cache-failed");
    let include = place.read("lib/light.inc");
    fs::remove_file(place.0.join("lib/light.inc")).unwrap();
    assert_eq!(laid_out(&place, &[]).0, 3);
    place.write("lib/light.inc", include);
    let (count, report) = laid_out(&place, &[]);
    assert_eq!(count, 2);
    assert!(!report.contains("missing-include"), "{report}");
}

#[test]
fn a_cache_that_is_broken_is_as_good_as_none() {
    let place = tree("cache-broken");
    let (_, report) = laid_out(&place, &[]);
    let folder = place.0.join("cache");
    let file = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let is_json = |path: &std::path::PathBuf| path.extension().is_some_and(|e| e == "json");
    let file = file.filter(is_json).last().unwrap();
    let sound = fs::read(&file).unwrap();
    let mut flipped = sound.clone();
    flipped[sound.len() / 2] ^= 1;
    for foreign in [&b"{}"[..], b"\xff\xfe", b"0\n{}\n"] {
        fs::write(&file, foreign).unwrap();
        assert_eq!(laid_out(&place, &[]), (3, report.clone()));
        assert_eq!(laid_out(&place, &[]), (3, report.clone()));
        assert_eq!(fs::read(&file).unwrap(), foreign, "it is not landfall's");
    }
    for broken in [&sound[..sound.len() / 2], &flipped, b""] {
        fs::write(&file, broken).unwrap();
        assert_eq!(laid_out(&place, &[]), (3, report.clone()));
        assert_eq!(laid_out(&place, &[]), (0, report.clone()), "and it is mended");
    }
    assert_eq!(fs::read(&file).unwrap(), sound, "the same is remembered in the same bytes");
    assert!(place.read("cache/.gitignore").ends_with("*\n"));
}

#[test]
fn a_cache_that_cannot_be_written_is_no_error() {
    let place = tree("cache-file");
    place.write("cache", "in the way");
    let ran = place.run(&["check", "s", "--cache-dir", "cache"]);
    ran.code(0).stderr_eq(str![[r#"
the cache is not used: `cache` cannot be created as a directory: file exists
checked 3 shaders: 1 warning; 1 fixable with --fix
laid out 3 of 3 shaders, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
    assert_eq!(place.read("cache"), "in the way");
}

#[test]
fn runs_at_the_same_time_do_not_disturb_one_another() {
    let place = tree("cache-race");
    for i in 0..50 {
        place.write(&format!("s/{i}.frag"), CLEAN);
    }
    let arguments = ["check", "s", "--cache-dir", "cache", "-W", "stale-comment", "-f", "json"];
    let start = || place.command(&arguments).stdout(std::process::Stdio::piped()).spawn().unwrap();
    let runs: Vec<_> = (0..4).map(|_| start()).collect();
    let reports: Vec<Vec<u8>> =
        runs.into_iter().map(|run| run.wait_with_output().unwrap().stdout).collect();
    assert!(reports.iter().all(|report| *report == reports[0]));
    assert_eq!(laid_out(&place, &[]).0, 0);
    let left = fs::read_dir(place.0.join("cache")).unwrap().count();
    assert_eq!(left, 2, "the cache and its .gitignore, nothing half-written");
}

#[test]
fn the_configuration_may_name_the_folder_and_a_flag_refuse_it() {
    let place = tree("cache-config");
    place.write("landfall.toml", "include = [\"lib\"]\ncache-dir = \"remembered\"\n");
    assert_eq!(place.run(&["check", "s", "--no-cache"]).code, 0);
    assert!(!place.has("remembered"));
    place.run(&["check", "s"]);
    assert!(place.has("remembered/.gitignore") && place.has("landfall.toml"));
    place.run(&["check", "s/a.frag"]).stderr_eq(str![[r#"
checked 1 shader: no findings
laid out 0 of 1 shader, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
    place.run(&["check", "s"]).stderr_eq(str![[r#"
checked 3 shaders: 1 warning; 1 fixable with --fix
laid out 0 of 3 shaders, the rest is unchanged
no layouts are locked: `landfall lock` records them, so that check can tell when one changes

"#]]);
}
