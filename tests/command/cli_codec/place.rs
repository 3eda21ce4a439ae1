//! A folder for a test, landfall run in it, and what it answered.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

pub const LIGHTS: &str = "#version 330 core
struct PointLight { vec3 pos; vec3 color; float intensity, constant, linear, quadratic; };
layout(std140) uniform PointLightBlock {
    PointLight data[128];
    int actually_used_count;
} u_lights;
";

/// A folder of its own for one test, and landfall run in it.
pub struct Place(pub PathBuf);

pub struct Ran {
    pub code: i32,
    pub bytes: Vec<u8>,
    pub err: String,
}

impl Place {
    pub fn new(name: &str) -> Place {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-codec-{name}"));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        let place = Place(path);
        place.write("a.frag", LIGHTS);
        place
    }

    pub fn write(&self, path: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.0.join(path), bytes).unwrap();
    }

    pub fn read(&self, path: &str) -> Vec<u8> {
        fs::read(self.0.join(path)).unwrap()
    }

    /// What lies in the folder, by name.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = landfall(arguments);
        command.current_dir(&self.0);
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        Ran::of(self.command(arguments).stdin(Stdio::null()).output().unwrap())
    }

    pub fn run_with(&self, arguments: &[&str], stdin: impl AsRef<[u8]>) -> Ran {
        with_stdin(self.command(arguments), stdin.as_ref())
    }
}

pub fn landfall(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
    command.args(arguments).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
    command
}

pub fn with_stdin(mut command: Command, bytes: &[u8]) -> Ran {
    let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = piped.spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let bytes = bytes.to_vec();
    let writer = std::thread::spawn(move || match stdin.write_all(&bytes) {
        // What is refused before it is read.
        Err(cause) if cause.kind() == ErrorKind::BrokenPipe => {}
        done => done.unwrap(),
    });
    let ran = Ran::of(child.wait_with_output().unwrap());
    writer.join().unwrap();
    ran
}

impl Ran {
    pub fn of(output: Output) -> Ran {
        Ran {
            code: output.status.code().expect("not killed"),
            bytes: output.stdout,
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    pub fn out(&self) -> &str {
        std::str::from_utf8(&self.bytes).unwrap()
    }

    /// It failed in that way, with no product.
    #[track_caller]
    pub fn refuses(&self, code: &str, words: &str) {
        assert_eq!((self.code, self.bytes.len()), (2, 0), "{}", self.err);
        assert!(self.err.starts_with(&format!("error[{code}]: ")), "{}", self.err);
        assert!(self.err.contains(words), "{words}\n{}", self.err);
        assert_eq!(self.err.matches("error[").count(), 1, "{}", self.err);
    }
}
