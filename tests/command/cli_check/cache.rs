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

/// Waits until the files of a tree are old enough to have stamps, and has them recorded.
#[cfg(unix)]
fn settle(place: &Place) {
    std::thread::sleep(std::time::Duration::from_millis(2100));
    assert_eq!(laid_out(place, &[]).0, 0);
}

/// Whether the cache has stamps of a file: its size, device and inode, in this order.
#[cfg(unix)]
fn is_stamped(place: &Place, file: &str) -> bool {
    use std::os::unix::fs::MetadataExt;
    let found = fs::metadata(place.0.join(file)).unwrap();
    let start = format!("[{},{},{},", found.size(), found.dev(), found.ino());
    let entries = fs::read_dir(place.0.join("cache")).unwrap().map(|entry| entry.unwrap().path());
    entries.map(|path| fs::read_to_string(path).unwrap()).any(|text| text.contains(&start))
}

#[cfg(unix)]
#[test]
fn files_that_were_just_written_have_no_stamps() {
    let place = tree("cache-racy");
    assert_eq!(laid_out(&place, &[]).0, 3);
    // Written within the granularity of the clock: a second write might leave the times as they are.
    assert!(!is_stamped(&place, "s/c.frag") && !is_stamped(&place, "lib/light.inc"));
    settle(&place);
    for file in ["s/a.frag", "s/c.frag", "lib/light.inc"] {
        assert!(is_stamped(&place, file), "{file}");
    }
    place.write("s/c.frag", CLEAN);
    assert_eq!(laid_out(&place, &[]).0, 1);
    assert!(!is_stamped(&place, "s/c.frag") && is_stamped(&place, "s/a.frag"));
}

#[cfg(unix)]
#[test]
fn a_change_that_keeps_size_and_modification_time_is_found() {
    let place = tree("cache-same-time");
    let found = idle();
    let silent = found.replace("landfall: allow", "landfalls allow");
    place.write("s/c.frag", silent);
    let (_, clean) = laid_out(&place, &[]);
    assert!(!clean.contains("unused-allow"), "{clean}");
    settle(&place);
    let overwrite = |file: &str, text: &str| {
        let path = place.0.join(file);
        let before = fs::metadata(&path).unwrap();
        place.write(file, text);
        let opened = fs::File::options().append(true).open(&path).unwrap();
        opened.set_modified(before.modified().unwrap()).unwrap();
        let after = fs::metadata(&path).unwrap();
        assert_eq!(before.len(), after.len());
        assert_eq!(before.modified().unwrap(), after.modified().unwrap());
    };
    overwrite("s/c.frag", &found);
    let (count, report) = laid_out(&place, &[]);
    assert_eq!(count, 1);
    assert!(report.contains("unused-allow"), "{report}");
    settle(&place);
    overwrite("lib/light.inc", "struct Light { vec3 color; };\n");
    assert_eq!(laid_out(&place, &[]).0, 2);
}

#[cfg(unix)]
#[test]
fn a_file_that_is_replaced_by_another_of_its_times_is_read() {
    let place = tree("cache-renamed");
    // As `cp -p` and archives do: the size and the time of modification are those of the first.
    let other = place.read("s/c.frag").replace("450", "460");
    place.write("other.frag", other);
    laid_out(&place, &[]);
    settle(&place);
    let time = fs::metadata(place.0.join("s/c.frag")).unwrap().modified().unwrap();
    let opened = fs::File::options().append(true).open(place.0.join("other.frag")).unwrap();
    opened.set_modified(time).unwrap();
    fs::rename(place.0.join("other.frag"), place.0.join("s/c.frag")).unwrap();
    assert_eq!(laid_out(&place, &[]).0, 1);
}

#[cfg(unix)]
#[test]
fn locks_that_change_come_or_go_are_seen_beside_shaders_that_were_not_touched() {
    let place = tree("cache-locks");
    place.run(&["lock", "s", "-q"]).code(0);
    let (_, clean) = laid_out(&place, &[]);
    settle(&place);
    let lock = "layouts/s/a.frag.json";
    let was = place.read(lock);
    place.write(lock, was.replacen("16", "32", 1));
    let (_, changed) = laid_out(&place, &[]);
    assert_ne!(changed, clean);
    fs::remove_file(place.0.join(lock)).unwrap();
    let (_, missing) = laid_out(&place, &[]);
    assert!(missing.contains("lock-missing"), "{missing}");
    // The result without a lock has stamps, too.
    settle_without(&place, &missing);
    place.write(lock, was);
    assert_eq!(laid_out(&place, &[]).1, clean);
}

#[cfg(unix)]
fn settle_without(place: &Place, report: &str) {
    std::thread::sleep(std::time::Duration::from_millis(2100));
    for _ in 0..2 {
        assert_eq!(laid_out(place, &[]), (0, report.to_string()));
    }
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
    // From here on, the cache has the stamps of its files.
    std::thread::sleep(std::time::Duration::from_millis(2100));
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

"#]]);
    place.run(&["check", "s"]).stderr_eq(str![[r#"
checked 3 shaders: 1 warning; 1 fixable with --fix
laid out 0 of 3 shaders, the rest is unchanged

"#]]);
}
