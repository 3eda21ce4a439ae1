//! Help texts: groups, widths, examples that run, and the backend option.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use snapbox::str;

use crate::support::command::{self, Place, Ran, golden};
use crate::support::sample::sampled;

/// A new directory below the target directory with the repository's shaders, locks and settings.
fn checkout(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("help-{name}"));
    let _ = fs::remove_dir_all(&folder);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for tree in ["shaders", "layouts"] {
        copy(&root.join(tree), &folder.join(tree));
    }
    fs::copy(root.join(".landfall.toml"), folder.join(".landfall.toml")).expect("it is readable");
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("the target directory is writable");
    for entry in fs::read_dir(from).expect("the directory exists") {
        let (path, to) = (entry.expect("an entry").path(), to.to_path_buf());
        let to = to.join(path.file_name().expect("entries have names"));
        match path.is_dir() {
            true => copy(&path, &to),
            false => drop(fs::copy(&path, &to).expect("the file is readable")),
        }
    }
}

/// A help text, which must fit 80 columns.
fn help(arguments: &[&str]) -> String {
    let mut command = command::landfall(arguments);
    let ran = Ran::of(command.env("COLUMNS", "80").output().expect("the command of this package"));
    assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{arguments:?}");
    let text = ran.out;
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{arguments:?}: {line}");
    }
    text
}

/// The commands of the help, each with its group.
fn commands() -> Vec<(String, String)> {
    let (mut group, mut commands) = (String::new(), Vec::new());
    for line in help(&["--help"]).lines().skip_while(|line| !line.starts_with("Usage:")).skip(1) {
        if let Some(heading) = line.strip_suffix(':').filter(|line| !line.starts_with(' ')) {
            group = heading.to_string();
        } else if let Some(rest) = line.strip_prefix("  ").filter(|_| group != "Options") {
            let name = rest.split_whitespace().next().expect("a command");
            commands.push((name.to_string(), group.clone()));
        }
    }
    commands
}

/// An example line of a help text, with its documented exit code.
struct Example {
    line: String,
    code: i32,
}

fn examples(help: &str) -> Vec<Example> {
    let (_, text) = help.split_once("\nExamples:\n").expect("every --help has examples");
    let (mut examples, mut code): (Vec<Example>, i32) = (Vec::new(), 0);
    for line in text.lines() {
        if let Some(purpose) = line.strip_prefix("  # ") {
            code = i32::from(purpose.ends_with("(exit code 1)"));
            continue;
        }
        match examples.last_mut().filter(|example| example.line.ends_with('\\')) {
            Some(example) => {
                example.line.push('\n');
                example.line.push_str(line);
            }
            None => examples.push(Example { line: line.trim().to_string(), code }),
        }
    }
    examples
}

#[test]
fn the_help_groups_commands_by_purpose_and_fits_80_columns() {
    let commands = commands();
    let mut groups: Vec<&str> = commands.iter().map(|(_, group)| group.as_str()).collect();
    groups.dedup();
    assert_eq!(groups, ["Lay out", "Generate", "Guard", "Prove", "Light", "Measure"]);
    assert_eq!(commands.len(), 23, "{commands:?}");
    let long = help(&["--help"]);
    assert_eq!(long, help(&["help"]));
    assert_eq!(long, help(&["-h"]));
    golden().eq(
        &long,
        str![[r#"
Computes byte layouts of GLSL and WGSL blocks, generates mirrors, and checks
them on drivers

Usage: landfall [OPTIONS] <COMMAND>

Lay out:
  layout   Print the byte layout of every block
  explain  Explain the offset of a member, or find the member at a byte
  report   Draw memory maps of all blocks, with the findings, as one HTML file
  serve    Serve the playground: layouts, maps and findings as you type
  lsp      Serve an editor: offsets, findings and fixes where you type

Generate:
  emit     Generate mirrors of blocks in Rust, C and other languages
  port     Rewrite legacy GLSL as Vulkan GLSL, naga's GLSL or WGSL
  encode   Convert JSON values to the bytes of a block
  decode   Convert the bytes of a block to a table or JSON, and flag bad values
  schema   Print the JSON Schema of an output format, landfall.toml or scenes

Guard:
  init     Write a commented landfall.toml for the shaders of a directory
  lock     Record the layout of every shader in a lock file
  check    Check shaders for lint findings and layout changes
  diff     Compare two layouts and classify each change
  rule     List the lints and hazards, or explain one of them

Prove:
  verify   Run shaders to prove that every member is read at its offset
  prove    Prove that a function has no undefined results, NaN or infinities
  run      Call a function of a shader in f32 and f64
  devices  List the backends and adapters of this machine, with their limits

Light:
  lights   List light structures, their cost and numerical hazards
  render   Render a JSON scene of lights with a shader

Measure:
  stress   Search for inputs at which a function is inaccurate
  bench    Measure the run time and error of shader variants

Options:
      --color <WHEN>        When to colour the output [default: auto] [possible
                            values: auto, always, never]
  -q, --quiet               Print errors only: no warnings, notes or progress
      --max-time <SECONDS>  End with exit code 2 after this time, in seconds
                            [default: 3600; for `stress` at least twice its
                            --time]
      --max-memory <MIB>    End with exit code 2 if this process and those it
                            starts need more memory, in MiB (Linux; measured
                            every 60 ms) [default: 8192]
  -h, --help                Print help
  -V, --version             Print version

`landfall COMMAND --help` prints options and examples of a command.

"#]],
    );
    assert!(!long.contains('\u{1b}'), "no colours outside a terminal");
}

/// The examples of one command run in order in one directory, as a reader would type them.
#[test]
fn every_example_of_every_help_exits_as_documented() {
    let program = Path::new(env!("CARGO_BIN_EXE_landfall"));
    let folder = program.parent().expect("a program is in a directory");
    let mut path = vec![folder.to_path_buf()];
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let path = std::env::join_paths(path).expect("PATH takes the directory");
    for (command, _) in sampled(&commands(), 3) {
        let text = help(&[command, "--help"]);
        let examples = examples(&text);
        let own = format!("landfall {command} ");
        let is_own = |example: &Example| format!("{} ", example.line).contains(&own);
        assert!(examples.iter().any(is_own), "{command}: {text}");
        let place = checkout(command);
        for Example { line, code } in examples {
            let mut shell = Command::new("sh");
            // It runs until Ctrl-C, which comes once: the second one ends a command at once.
            let line = match command.as_str() {
                "serve" => format!("timeout --foreground --preserve-status --signal INT 2 {line}"),
                // Its messages end without `shutdown`, which the protocol wants to be a failure.
                "lsp" => format!("! {line}"),
                _ => line,
            };
            shell.args(["-c", &line]).env("PATH", &path).current_dir(&place);
            let output = shell.output().expect("a shell runs");
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(code), "{line}\n{said}");
        }
        fs::remove_dir_all(&place).expect("the test's own directory");
    }
}

#[test]
fn the_short_help_of_every_command_fits_80_columns_without_examples() {
    for (command, _) in commands() {
        let text = help(&[&command, "-h"]);
        assert!(text.contains("Usage: landfall ") && !text.contains("Examples:"), "{text}");
    }
}

#[test]
fn five_commands_take_backend() {
    let place = checkout("backend");
    let unit = ["shaders/include/lights.glsl", "--fn", "unit"];
    let scene = ["shaders/scenes/six_lights.json", "--size", "16x9"];
    let commands: [(&str, &[&str], &[&str]); 5] = [
        ("verify", &["shaders/ideas/vec3_then_float.frag"], &[]),
        ("run", &unit, &["--args", "[[0, 3, 4]]"]),
        ("stress", &unit, &["--samples", "100"]),
        ("render", &scene, &[]),
        ("bench", &scene, &["--rounds", "3"]),
    ];
    for (command, subject, more) in commands {
        let ran =
            Place(place.clone()).run(&[&[command], subject, more, &["--backend", "cpu"]].concat());
        assert_eq!(ran.code, 0, "{command}: {}", ran.err);
        let text = help(&[command, "--help"]);
        assert!(text.contains("--backend <BACKEND>") && !text.contains("reader"), "{text}");
    }
}
