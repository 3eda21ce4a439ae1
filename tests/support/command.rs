//! The command `landfall` as a process, in a folder of its own test, and golden texts.
//!
//! A golden text is written as `str![]` and filled in by `SNAPSHOTS=overwrite`. It may hold
//! snapbox's wildcards and the placeholders of [`golden`], which stand for what differs from one
//! machine to the next.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;

use snapbox::assert::DEFAULT_ACTION_ENV;
use snapbox::{Assert, IntoData, Redactions};

/// A folder of its own for one test, below the target directory.
pub struct Place(pub PathBuf);

/// What a process answered.
pub struct Ran {
    pub code: i32,
    /// Standard output; where it is not UTF-8, with replacement characters.
    pub out: String,
    /// Standard output as it is.
    pub bytes: Vec<u8>,
    pub err: String,
}

impl Place {
    /// An empty folder but for a configuration, so that none further up is found.
    pub fn new(name: &str) -> Place {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("the target directory can be written");
        let place = Place(path);
        place.write("landfall.toml", "");
        place
    }

    /// The path of a file of this folder, which need not exist.
    pub fn path(&self, file: &str) -> String {
        self.0.join(file).display().to_string()
    }

    pub fn write(&self, file: &str, text: impl AsRef<[u8]>) -> &Place {
        let path = self.0.join(file);
        fs::create_dir_all(path.parent().expect("a file is in a folder")).expect("it is made");
        fs::write(&path, text).unwrap_or_else(|e| panic!("{file}: {e}"));
        self
    }

    pub fn read(&self, file: &str) -> String {
        String::from_utf8(self.bytes(file)).expect("the file is UTF-8")
    }

    pub fn bytes(&self, file: &str) -> Vec<u8> {
        fs::read(self.0.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
    }

    pub fn has(&self, file: &str) -> bool {
        self.0.join(file).exists()
    }

    /// The command with this folder as its current directory.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = landfall(arguments);
        // The folder is below the repository of these tests, but a checkout of its own.
        command.current_dir(&self.0).env("CI_PROJECT_DIR", &self.0);
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        Ran::of(self.command(arguments).output().expect("the command of this package"))
    }

    /// Runs git in this folder, without settings of whoever runs the tests.
    fn git(&self, arguments: &[&str]) {
        let settings = ["user.name=A", "user.email=a@example.org", "init.defaultBranch=main"];
        let mut git = Command::new("git");
        git.args(settings.iter().flat_map(|setting| ["-c", setting]));
        git.args(arguments).current_dir(&self.0).env("GIT_CONFIG_GLOBAL", "/dev/null");
        let output = git.output().expect("git is installed");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    /// Commits all files to the repository of this folder, which the first commit makes.
    pub fn commit(&self) {
        self.git(&["init", "-q"]);
        self.git(&["add", "."]);
        self.git(&["commit", "-q", "-m", "all"]);
    }

    pub fn run_with_stdin(&self, arguments: &[&str], stdin: impl AsRef<[u8]>) -> Ran {
        with_stdin(self.command(arguments), stdin.as_ref())
    }
}

/// The command with an empty standard input and nothing in its environment that changes output.
pub fn landfall(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.args(arguments).stdin(Stdio::null()).env("TERM", "xterm");
    for name in [
        "NO_COLOR",
        "CLICOLOR_FORCE",
        "COLUMNS",
        "GITHUB_ACTIONS",
        "GITHUB_STEP_SUMMARY",
        "GITHUB_WORKSPACE",
        "CI_PROJECT_DIR",
        "WORKSPACE",
    ] {
        command.env_remove(name);
    }
    command
}

/// Runs the command in the root of the repository.
pub fn run(arguments: &[&str]) -> Ran {
    Ran::of(landfall(arguments).output().expect("the command of this package"))
}

/// Runs a command that reads this from its standard input, or refuses to.
pub fn with_stdin(mut command: Command, bytes: &[u8]) -> Ran {
    let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = piped.spawn().expect("the command of this package");
    let mut stdin = child.stdin.take().expect("it is piped");
    let bytes = bytes.to_vec();
    let writer = std::thread::spawn(move || match stdin.write_all(&bytes) {
        // What is refused before it is read.
        Err(cause) if cause.kind() == ErrorKind::BrokenPipe => {}
        done => done.expect("it is read"),
    });
    let ran = Ran::of(child.wait_with_output().expect("it ends"));
    writer.join().expect("all is written");
    ran
}

impl Ran {
    pub fn of(output: Output) -> Ran {
        Ran {
            code: output.status.code().expect("not killed"),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            bytes: output.stdout,
            err: String::from_utf8(output.stderr).expect("standard error is UTF-8"),
        }
    }

    /// Asserts the exit code.
    #[track_caller]
    pub fn code(&self, code: i32) -> &Ran {
        assert_eq!(self.code, code, "{}\n{}", self.out, self.err);
        self
    }

    /// Asserts that standard output is a golden text.
    #[track_caller]
    pub fn stdout_eq(&self, expected: impl IntoData) -> &Ran {
        golden().eq(&self.out, expected);
        self
    }

    /// Asserts that standard error is a golden text.
    #[track_caller]
    pub fn stderr_eq(&self, expected: impl IntoData) -> &Ran {
        golden().eq(&self.err, expected);
        self
    }

    /// Standard output as JSON.
    #[track_caller]
    pub fn json(&self) -> serde_json::Value {
        let parsed = serde_json::from_slice(&self.bytes);
        parsed.unwrap_or_else(|e| panic!("{e}\n{}\n{}", self.out, self.err))
    }
}

/// Comparison with golden texts, in which these stand for what differs between machines and runs:
///
/// | placeholder | stands for |
/// |---|---|
/// | `[TMP]` | the directory of the folders of tests |
/// | `[ROOT]` | the root of the repository |
/// | `[VERSION]` | the version of landfall |
/// | `[TIME]` | a time that was measured |
/// | `[HASH]` | the name of a cache |
/// | `[DRIVER]` | name and version of a driver and its device |
/// | `[BROWSER]` | name and version of a browser and its device |
pub fn golden() -> &'static Assert {
    static GOLDEN: LazyLock<Assert> = LazyLock::new(|| {
        let mut redactions = Redactions::new();
        let pattern = |text: &str| regex::Regex::new(text).expect("the pattern is right");
        let mut stands = |placeholder, pattern: regex::Regex| {
            redactions.insert(placeholder, pattern).expect("the placeholder is right");
        };
        let version = env!("CARGO_PKG_VERSION").replace('.', r"\.");
        stands("[VERSION]", pattern(&format!(r"landfall (?<redacted>{version})\b")));
        stands("[TIME]", pattern(r"time +(?<redacted>\d+\.\d+ s)"));
        stands("[HASH]", pattern(r"check-(?<redacted>[0-9a-f]{16})\.json"));
        let browser = r"ANGLE \([^\n]*\)|google swiftshader|Chrome [0-9.]+";
        stands("[BROWSER]", pattern(browser));
        stands("[DRIVER]", pattern(r"(llvmpipe|Mesa) [^·\n]*[^·\s]"));
        redactions.insert("[TMP]", env!("CARGO_TARGET_TMPDIR")).expect("the placeholder is right");
        redactions.insert("[ROOT]", env!("CARGO_MANIFEST_DIR")).expect("the placeholder is right");
        // Backslashes are part of names and of escaped text.
        Assert::new().action_env(DEFAULT_ACTION_ENV).normalize_paths(false).redact_with(redactions)
    });
    &GOLDEN
}
