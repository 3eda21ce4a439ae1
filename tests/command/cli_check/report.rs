//! Reports: to files and stdout, exit codes, the line in sum.

use std::io::{Read, Write};
use std::process::Stdio;

use snapbox::str;

use crate::cli_check::place::{CLEAN, idle};
use crate::support::command::{Place, Ran, golden};

#[test]
fn exit_codes_tell_clean_from_findings_from_could_not() {
    let place = Place::new("check-exit");
    let clean = place.write("a.frag", CLEAN).run(&["check", "-A", "all"]);
    clean.code(0).stderr_eq(str![[r#"
checked 1 shader: no findings

"#]]);
    place.write("b.frag", idle());
    let warned = place.run(&["check", "-A", "all", "-W", "unused-allow", "-W", "stale-comment"]);
    assert_eq!(warned.code, 0);
    warned.stderr_eq(str![[r#"
checked 2 shaders: 1 warning; 1 fixable with --fix

"#]]);
    let denied = place.run(&["check", "-A", "all", "-D", "unused-allow", "-W", "stale-comment"]);
    assert_eq!(denied.code, 1);
    place.write("c.frag", "#version 450\nuniform B {").write("d.frag", b"\xff\xfe");
    let (code, found, err) = place.check(&["-W", "stale-comment", "-D", "unused-allow"]);
    assert_eq!(code, 2, "{err}");
    assert!(found.iter().any(|f| f["code"] == "unused-allow"), "the others are checked");
    assert!(found.iter().any(|f| f["place"]["path"] == "d.frag"), "{found:?}");
    golden().eq(
        err,
        str![[r#"
checked 4 shaders: 3 errors; 1 fixable with --fix

"#]],
    );
    assert_eq!(place.run(&["check", "gone.frag"]).code, 2);
    let empty = place.write("empty/x.txt", "").run(&["check", "empty"]);
    empty.code(2).stdout_eq(str![[r#"
error[no-input]: `empty` contains no shader file
 --> empty
  |
  = help: shaders are recognised by their extension, such as .frag, .glsl or .wgsl; a file that is named itself is read with any extension

"#]]);
}

#[test]
fn reports_go_each_to_its_own_file_and_one_to_stdout() {
    let place = Place::new("check-formats");
    place.write("a.frag", idle());
    let mut arguments = vec!["check", "-W", "stale-comment", "-f", "short"];
    let formats = ["human=o/h.txt", "json=o/r.json", "github=g", "sarif=s.sarif", "junit=j.xml"];
    formats.iter().for_each(|format| arguments.extend(["-f", format]));
    let ran = place.run(&arguments);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.stdout_eq(str![[r#"
a.frag:4:36: warning[unused-allow] `allow(stale-comment)` suppresses nothing in line 4

"#]]);
    for file in ["o/h.txt", "o/r.json", "g", "s.sarif", "j.xml"] {
        assert!(place.read(file).contains("unused-allow"), "{file}");
    }
    let only = place.run(&["check", "-f", "json=o/r.json"]);
    assert_eq!(only.out, "");
    let twice = place.run(&["check", "-f", "json", "-f", "sarif"]);
    twice.code(2).stderr_eq(str![[r#"
error[cannot-run]: `<stdout>` cannot take two reports
  |
  = help: write all but one to a file: `--format sarif=check.sarif`


"#]]);
    let twice = place.run(&["check", "-f", "json=x", "-f", "sarif=x"]);
    twice.code(2).stderr_eq(str![[r#"
error[cannot-run]: `x` cannot take two reports


"#]]);
    assert!(!place.has("x"));
    for wrong in ["xml", "json=", "=x"] {
        assert_eq!(place.run(&["check", "-f", wrong]).code, 2, "{wrong}");
    }
    let blocked = place.run(&["check", "-f", "json=a.frag/x.json"]);
    blocked.code(2).stderr_eq(str![[r#"
error[cannot-write]: `a.frag` cannot be created as a directory: file exists


"#]]);
}

#[test]
fn a_step_summary_is_added_to_for_github_only() {
    let place = Place::new("check-summary");
    place.write("a.frag", idle()).write("summary.md", "before\n");
    let run = |format: &str| {
        let mut command = place.command(&["check", "-W", "stale-comment", "-f", format]);
        let ran = Ran::of(command.env("GITHUB_STEP_SUMMARY", "summary.md").output().unwrap());
        assert_eq!(ran.code, 0, "{}", ran.err);
        place.read("summary.md")
    };
    assert_eq!(run("short"), "before\n");
    let text = run("github");
    assert!(text.starts_with("before\n") && text.len() > "before\n".len(), "{text}");
}

#[test]
fn quiet_leaves_warnings_and_the_line_in_sum_out() {
    let place = Place::new("check-quiet");
    place.write("a.frag", idle());
    let warned = place.run(&["check", "-q", "-W", "stale-comment", "-f", "short"]);
    assert_eq!((warned.code, warned.out.as_str(), warned.err.as_str()), (0, "", ""));
    let denied =
        place.run(&["check", "-q", "-W", "stale-comment", "-D", "unused-allow", "-f", "short"]);
    denied.code(1).stdout_eq(str![[r#"
a.frag:4:36: error[unused-allow] `allow(stale-comment)` suppresses nothing in line 4

"#]]);
}

#[test]
fn statistics_count_the_findings_of_each_lint() {
    let place = Place::new("check-statistics");
    place.write("a.frag", idle()).write("b.frag", idle());
    let ran = place.run(&[
        "check",
        "-A",
        "all",
        "-W",
        "unused-allow",
        "-W",
        "stale-comment",
        "--statistics",
    ]);
    ran.stderr_eq(str![[r#"
     2  unused-allow
checked 2 shaders: 2 warnings; 2 fixable with --fix

"#]]);
}

#[test]
fn stdin_is_checked_under_the_name_it_is_given() {
    let place = Place::new("check-stdin");
    let arguments =
        ["check", "-", "--stdin-filename", "x/y.frag", "-W", "stale-comment", "-f", "short"];
    let mut command = place.command(&arguments);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(idle().as_bytes()).unwrap();
    let ran = Ran::of(child.wait_with_output().unwrap());
    ran.stdout_eq(str![[r#"
x/y.frag:4:36: warning[unused-allow] `allow(stale-comment)` suppresses nothing in line 4

"#]]);
}

#[test]
fn whoever_stops_reading_is_no_failure_and_files_are_written_all_the_same() {
    let place = Place::new("check-pipe");
    for i in 0..300 {
        place.write(&format!("s/{i}.frag"), idle());
    }
    let arguments = ["check", "-W", "stale-comment", "-f", "human", "-f", "json=r.json"];
    let mut command = place.command(&arguments);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdout = child.stdout.take().unwrap();
    let mut first = [0; 1];
    stdout.read_exact(&mut first).unwrap();
    drop(stdout);
    let ran = Ran::of(child.wait_with_output().unwrap());
    assert_eq!((ran.code, ran.err.contains("panic")), (0, false), "{}", ran.err);
    assert!(place.read("r.json").ends_with("}\n"));
}

#[test]
fn hostile_shaders_get_one_answer_each() {
    let place = Place::new("check-hostile");
    place.write("a.frag", "{".repeat(1 << 20)).write("b.wgsl", "/*".repeat(1 << 18));
    place.write("c.frag", format!("// landfall: allow({}", "(,".repeat(1 << 16)));
    place.write("d.frag", format!("#version 450\n// landfall: allow({})\n", ",".repeat(2000)));
    let (code, found, err) = place.check(&[]);
    assert_eq!(code, 2, "{err}");
    let paths: Vec<&str> = found.iter().map(|f| f["place"]["path"].as_str().unwrap()).collect();
    for path in ["a.frag", "b.wgsl", "c.frag", "d.frag"] {
        assert!(paths.contains(&path), "{path} in {paths:?}");
    }
}
