//! Which files of a directory are read, held against git's own answer for the same ignore files.

use std::collections::BTreeSet;
use std::os::unix::fs::symlink;
use std::process::Command;

use crate::cli_check::place::CLEAN;
use crate::support::command::Place;

const FOLDERS: [&str; 9] = ["", "", "a/", "b/", "a/b/", "a/a/", "b/a/b/", "ab/", "a/b c/"];

/// In ASCII: `?` is a character of a name, and git takes it for a byte.
const FILES: [&str; 9] = [
    "a.frag",
    "b.frag",
    "ab.frag",
    "a b.frag",
    "{a,b}.frag",
    "[a].frag",
    "!a.frag",
    "#a.frag",
    "a*.frag",
];

const SIGNS: [&str; 30] = [
    "a",
    "a",
    "b",
    "ab",
    ".frag",
    ".frag",
    "*",
    "*",
    "*",
    "**",
    "**/",
    "/**",
    "/**/",
    "/",
    "/",
    "?",
    "[ab]",
    "[!a]",
    "[^b]",
    "[]a]",
    "[[:alpha:]]",
    "[[:punct:][:space:]]",
    "\\*",
    "\\[",
    "{a,b}",
    "!",
    "#",
    " ",
    "\\ ",
    "[a",
];

/// An ignore file of a few random lines. `**` stands at the start of a component: git reads that of
/// `a**/b` as if it did, but not that of `a?**/b`.
fn ignore_file(random: &mut fastrand::Rng) -> String {
    let mut text = String::new();
    for _ in 0..random.usize(1..6) {
        text.push_str(random.choice(["", "", "", "!", "/", "\\!", "\\#"]).unwrap());
        for _ in 0..random.usize(1..5) {
            let sign = random.choice(SIGNS).unwrap();
            let is_start = text.is_empty() || text.ends_with(['/', '\n']);
            text.push_str(if sign.starts_with("**") && !is_start { "*" } else { sign });
        }
        text.push_str(random.choice(["", "", "/", " ", "\r"]).unwrap());
        text.push('\n');
    }
    text
}

fn git(place: &Place, arguments: &[&str]) -> Command {
    let mut git = Command::new("git");
    git.current_dir(&place.0).args(arguments);
    with_settings(git, place)
}

/// A command with the settings of git in a file of the folder, and those of no machine.
fn with_settings(mut command: Command, place: &Place) -> Command {
    let settings = place.0.join("settings");
    command.env("GIT_CONFIG_GLOBAL", settings).env("GIT_CONFIG_SYSTEM", "/dev/null");
    command.env("XDG_CONFIG_HOME", place.0.join("none"));
    command
}

/// The shaders below a directory that a command reads.
fn read(place: &Place, folder: &str) -> BTreeSet<String> {
    let command = place.command(&["layout", folder, "-f", "json"]);
    let ran = with_settings(command, place).output().expect("landfall runs");
    let found: serde_json::Value = match serde_json::from_slice(&ran.stdout) {
        Ok(found) => found,
        Err(_) => {
            let said = String::from_utf8_lossy(&ran.stderr);
            assert!(said.contains("contains no shader file"), "{said}");
            return BTreeSet::new();
        }
    };
    let shaders = found["shaders"].as_array().expect("a list").iter();
    shaders.map(|shader| shader["path"].as_str().expect("a path").to_string()).collect()
}

/// The files below a directory that git would add.
fn added(place: &Place, folder: &str) -> BTreeSet<String> {
    let list = ["ls-files", "--others", "--exclude-standard", "-z", "--", folder];
    let ran = git(place, &list).output().expect("git runs");
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let paths = ran.stdout.split(|byte| *byte == 0);
    let paths = paths.map(|path| String::from_utf8(path.to_vec()).expect("UTF-8"));
    paths.filter(|path| path.ends_with(".frag")).collect()
}

#[test]
fn ignored_files_are_those_that_git_ignores() {
    let mut random = fastrand::Rng::with_seed(31);
    let (mut kept, mut ignored) = (0, 0);
    for round in 0..60 {
        let place = Place::new("ignore-files");
        let mut all = BTreeSet::new();
        for _ in 0..24 {
            let (folder, file) = (random.choice(FOLDERS).unwrap(), random.choice(FILES).unwrap());
            place.write(&format!("{folder}{file}"), CLEAN);
            all.insert(format!("{folder}{file}"));
        }
        assert!(git(&place, &["init", "-q"]).status().unwrap().success());
        let user = format!("{}/user-ignores", place.0.display());
        place.write("settings", format!("[user]\n\tname = x\n[Core]\n\texcludesfile = {user}\n"));
        let mut texts = Vec::new();
        for file in
            [".gitignore", "a/.gitignore", "a/b/.gitignore", ".git/info/exclude", "user-ignores"]
        {
            if random.bool() {
                let text = ignore_file(&mut random);
                place.write(file, &text);
                texts.push((file, text));
            }
        }
        for folder in [".", "a", "a/b"] {
            // A directory that is named is searched, also where git ignores it.
            let is_ignored = || {
                let asked = git(&place, &["check-ignore", "-q", folder]).status();
                folder != "." && asked.unwrap().code() != Some(1)
            };
            if !place.has(folder) || is_ignored() {
                continue;
            }
            let (ours, theirs) = (read(&place, folder), added(&place, folder));
            assert_eq!(ours, theirs, "{folder} of round {round}: {all:#?} with {texts:#?}");
            if folder == "." {
                kept += ours.len();
                ignored += all.len() - ours.len();
            }
        }
    }
    assert!(kept > 300 && ignored > 300, "{kept} and {ignored}");
}

#[test]
fn settings_links_and_own_files_are_read_as_git_reads_them() {
    let place = Place::new("ignore-files-settings");
    for file in ["a.frag", "b.frag", "# c.frag", "in/7.frag", "in/_.frag"] {
        place.write(file, CLEAN);
    }
    assert!(git(&place, &["init", "-q"]).status().unwrap().success());
    place.write("user", "a.frag\n").write(".git/refs/own.frag", CLEAN);
    let mut found = Vec::new();
    let mut compare = |about: &str| {
        let (ours, theirs) = (read(&place, "."), added(&place, "."));
        assert_eq!(ours, theirs, "{about}");
        found.push(ours.len());
    };
    place.write("settings", "[core]\nexcludesFile = /dev/null\n");
    compare("no file of the user");
    let user = place.path("user");
    place.write(
        "settings",
        format!("[user]\nname = J\u{fc}rgen\n[core] ; own\nexcludesfile=\"{user}\" # x\n"),
    );
    compare("a comment behind the value");
    place.write(
        "settings",
        [&b"[user]\nname = \xfc\n[core]excludesfile="[..], user.as_bytes()].concat(),
    );
    compare("bytes that are not UTF-8");
    place.write("settings", "");
    let set = ["config", "core.excludesFile", "user"];
    assert!(git(&place, &set).status().unwrap().success());
    compare("the configuration of the repository");
    place.write(".gitignore", "*\n!*/\n!*.frag\n");
    compare("a rule that names every folder");
    place.write(".gitignore", "[[:blank:]-_].frag\n[!!]{a}.frag\n");
    compare("a class within brackets before a `-`");
    place.write(".gitignore", b"\xfc.frag\n\xef\xbb\xbfb.frag\n#\n\\# c.frag\n");
    compare("a line that is not UTF-8");
    std::fs::remove_file(place.0.join(".gitignore")).unwrap();
    symlink("user", place.0.join(".gitignore")).unwrap();
    place.write("settings", "[core]\nexcludesFile =\n");
    assert!(git(&place, &["config", "--unset", "core.excludesFile"]).status().unwrap().success());
    compare("a link");
    assert_eq!(found, [5, 4, 4, 4, 5, 3, 3, 5]);
}

#[test]
fn rules_of_git_count_in_a_repository_from_its_root_on() {
    let place = Place::new("ignore-files-outside");
    place.write("a.frag", CLEAN).write(".gitignore", "*.frag\n").write("in/b.frag", CLEAN);
    let found = |folder: &str| read(&place, folder).into_iter().collect::<Vec<_>>();
    // The folder of this test is in a repository already: that of the tests.
    std::fs::create_dir(place.0.join(".git")).unwrap();
    assert_eq!(found("."), [""; 0]);
    std::fs::create_dir(place.0.join("in/.git")).unwrap();
    assert_eq!(found("."), ["in/b.frag"], "a repository in a repository");
    place.write("in/.ignore", "b.frag\n").write("in/.gitignore", "!b.frag\n");
    assert_eq!(found("in"), [""; 0], "`.ignore` precedes `.gitignore`");
    place.write("in/.ignore", "");
    assert_eq!(found("in"), ["in/b.frag"]);
    place.write(".ignore", "b.frag\n");
    assert_eq!(found("in"), [""; 0], "`.ignore` counts beyond the repository");
}

#[test]
fn a_linked_worktree_has_the_rules_of_its_repository() {
    let place = Place::new("ignore-files-worktree");
    place.write("main/a.frag", CLEAN).write("main/b.frag", CLEAN).write("main/landfall.toml", "");
    let run = |folder: &str, arguments: &[&str]| {
        let mut git = git(&place, &["-C", folder, "-c", "user.name=x", "-c", "user.email=x"]);
        let ran = git.args(arguments).output().expect("git runs");
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    };
    run("main", &["init", "-q"]);
    run("main", &["add", "."]);
    run("main", &["commit", "-q", "-m", "shaders"]);
    run("main", &["worktree", "add", "-q", "../linked"]);
    place.write("main/.git/info/exclude", "b.frag\n");
    let found: Vec<String> = read(&place, "linked").into_iter().collect();
    assert_eq!(found, ["linked/a.frag"]);
}
