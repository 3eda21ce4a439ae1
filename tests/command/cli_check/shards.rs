//! A check in parts, and the parts put together again.

use std::fs;

use snapbox::data::Inline;
use snapbox::str;

use crate::cli_check::place::{CLEAN, idle};
use crate::support::command::{Place, Ran};

const FORMATS: [&str; 6] = ["human", "short", "json", "github", "sarif", "junit"];

/// Shaders with findings of every kind: idle comments, one in an include, drift, a lock without
/// shader, a copy that differs, one that does not lay out.
fn tree(name: &str) -> Place {
    let place = Place::new(&format!("check-{name}"));
    place.write("landfall.toml", "paths = [\"s\"]\n[levels]\nunused-allow = \"deny\"\n");
    for i in 0..20 {
        let text = CLEAN.replace("Light", &format!("Light{}", i % 7));
        place.write(&format!("s/{}/{i}.frag", i % 3), text);
    }
    fs::create_dir(place.0.join("layouts")).unwrap();
    assert_eq!(place.run(&["check", "--accept"]).code, 0);
    place.write("s/0/3.frag", CLEAN.replace("vec4 position", "mat4 position"));
    place.write("s/0/9.frag", idle()).write("s/1/4.frag", idle());
    fs::remove_file(place.0.join("s/2/5.frag")).unwrap();
    place.write("s/bad.frag", "#version 450\nuniform B { vec33 x; };\nvoid main() {}\n");
    let with = "#version 450\n#include \"b.inc\"\nvoid main() {}\n";
    place.write("s/x.frag", with).write("s/y.frag", with).write("s/z.frag", with);
    place.write("s/b.inc", "struct S { vec4 a; }; // landfall: allow(stale-comment)\n");
    place
}

/// Checks in so many parts; their reports by name.
fn parts(place: &Place, count: usize) -> Vec<String> {
    (1..=count)
        .map(|i| {
            let name = format!("r/{i}-of-{count}.json");
            let shard = format!("{i}/{count}");
            let ran = place.run(&["check", "--shard", &shard, "-f", &format!("json={name}")]);
            assert!(ran.out.is_empty(), "{}", ran.out);
            name
        })
        .collect()
}

fn merge(place: &Place, reports: &[String], more: &[&str]) -> Ran {
    let mut arguments = vec!["merge"];
    arguments.extend(reports.iter().map(String::as_str));
    arguments.extend(more);
    place.run(&arguments)
}

#[test]
fn merged_reports_are_those_of_a_whole_check_in_every_format() {
    let place = tree("shards");
    let mut whole = Vec::new();
    for format in FORMATS {
        let ran = place.run(&["check", "-f", format]);
        assert_eq!(ran.code, 2, "{}", ran.err);
        assert!(format == "human" || !ran.out.is_empty());
        whole.push(ran);
    }
    let codes = ["unused-allow", "layout-drift", "lock-orphan", "s/b.inc", "unknown-type"];
    codes.iter().for_each(|words| assert!(whole[1].out.contains(words), "{words}"));
    for count in 1..=5 {
        let mut reports = parts(&place, count);
        // The order of the reports does not matter.
        reports.rotate_left(count / 2);
        for (format, whole) in FORMATS.iter().zip(&whole) {
            let merged = merge(&place, &reports, &["-f", format]);
            assert_eq!(merged.out, whole.out, "{format} of {count}");
            assert_eq!((merged.code, &merged.err), (whole.code, &whole.err), "{format} of {count}");
        }
    }
}

#[test]
fn every_shader_is_in_one_part_wherever_the_check_is_run_from() {
    let place = tree("shards-parts");
    let shaders = |reports: &[String]| -> Vec<Vec<String>> {
        let of = |name: &String| {
            let json: serde_json::Value = serde_json::from_str(&place.read(name)).unwrap();
            let checked = json["shard"]["checked"].as_array().unwrap();
            checked.iter().map(|c| c["path"].as_str().unwrap().to_string()).collect()
        };
        reports.iter().map(of).collect()
    };
    let three = shaders(&parts(&place, 3));
    let mut all: Vec<&String> = three.iter().flatten().collect();
    all.sort();
    let count = all.len();
    all.dedup();
    assert_eq!((all.len(), count), (23, 23));
    assert!(three.iter().all(|part| part.len() > 2), "{three:?}");
    // From a folder below, the same shaders are in the same parts.
    let mut below = place.command(&["check", "--shard", "2/3", "-f", "json=../r/below.json"]);
    below.current_dir(place.0.join("s")).output().unwrap();
    let second: Vec<String> = three[1].iter().map(|path| format!("../{path}")).collect();
    assert_eq!(shaders(&["r/below.json".to_string()]), [second]);
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    let place = tree("shards-refused");
    let (two, three) = (parts(&place, 2), parts(&place, 3));
    let refused = |reports: &[&str], said: Inline| {
        let reports: Vec<String> = reports.iter().map(|name| name.to_string()).collect();
        let ran = merge(&place, &reports, &["-f", "json=merged.json"]);
        ran.code(2).stdout_eq("").stderr_eq(said);
        assert!(!place.has("merged.json"), "{reports:?}");
    };
    refused(
        &[&three[0], &three[2]],
        str![[r#"
error[output]: `r/1-of-3.json` is incomplete without shard 2/3
  |
  = help: name the reports of all shards


"#]],
    );
    refused(
        &[&three[1]],
        str![[r#"
error[output]: `r/2-of-3.json` is incomplete without shards 1/3, 3/3
  |
  = help: name the reports of all shards


"#]],
    );
    refused(
        &[&three[0], &three[1], &three[1]],
        str![[r#"
error[output]: `r/2-of-3.json` is shard 2 of 3, as is `r/2-of-3.json`
  |
  = help: name the report of each shard once


"#]],
    );
    refused(
        &[&two[0], &three[1]],
        str![[r#"
error[output]: `r/2-of-3.json` is shard 2 of 3, but `r/1-of-2.json` is shard 1 of 2
  |
  = help: merge the shards of one check only


"#]],
    );
    place.run(&["check", "-f", "json=r/whole.json"]);
    refused(
        &[&two[0], "r/whole.json"],
        str![[r#"
error[output]: `r/whole.json` is the report of a whole check, not of a shard
  |
  = help: only reports of `landfall check --shard I/N` are merged


"#]],
    );
    place.run(&["check", "--shard", "2/2", "--define", "N=1", "-f", "json=r/other.json"]);
    refused(
        &[&two[0], "r/other.json"],
        str![[r#"
error[output]: `r/other.json` was checked with other settings than `r/1-of-2.json`
  |
  = help: give every shard the same configuration, flags and directory


"#]],
    );
    let newer = place.read(&two[1]).replace("\"version\":\"0.", "\"version\":\"7.");
    place.write("r/newer.json", newer);
    refused(
        &[&two[0], "r/newer.json"],
        str![[r#"
error[output]: `r/newer.json` was written by landfall 7.2.0, and this is 0.2.0
  |
  = help: check and merge with the same version of landfall


"#]],
    );
    let text = place.read(&two[1]);
    place.write("r/cut.json", &text[..text.len() / 2]);
    let cut = merge(&place, &[two[0].clone(), "r/cut.json".to_string()], &[]);
    cut.code(2).stderr_eq(str![[r#"
error[output]: `r/cut.json` is cut off: its JSON ends in the middle of line 5
  |
  = help: run `landfall check --format json` again


"#]]);
    place.write("s/0/0.frag", "#version 450\nvoid main() {}\n");
    refused(
        &[&two[0], &two[1]],
        str![[r#"
error[output]: `s/0/0.frag` has changed since it was checked
  |
  = help: merge in a checkout of the commit that the shards checked


"#]],
    );
    assert_eq!(merge(&place, &["gone.json".to_string()], &[]).code, 2);
}

#[test]
fn a_part_wants_a_report_that_can_be_merged() {
    let place = tree("shards-json");
    let ran = place.run(&["check", "--shard", "1/2"]);
    ran.code(2).stderr_eq(str![[r#"
error[output]: `--shard 1/2` writes no JSON report for `landfall merge`
  |
  = help: add `--format json=shard-1.json`


"#]]);
    for wrong in ["0/2", "3/2", "1", "a/b"] {
        assert_eq!(place.run(&["check", "--shard", wrong, "-f", "json"]).code, 2, "{wrong}");
    }
    assert_eq!(place.run(&["check", "--shard", "1/2", "-f", "json", "--fix"]).code, 2);
}

#[test]
fn parts_may_be_remembered_too() {
    let place = tree("shards-cache");
    let run = |name: &str| {
        let report = format!("json={name}");
        let arguments = ["check", "--shard", "1/2", "-f", &report, "--cache-dir", "cache"];
        place.run(&arguments);
        place.read(name)
    };
    assert_eq!(run("r/cold.json"), run("r/warm.json"));
}
