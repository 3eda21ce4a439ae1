//! A folder of its own for one test, and landfall run in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// A shader that no lint finds fault with.
pub const CLEAN: &str = "#version 450
layout(std140, binding = 0) uniform Light {
    vec4 position;
    vec4 color;
} light;
layout(location = 0) out vec4 color;
void main() {
    color = light.position + light.color;
}
";

/// The same with a comment that allows what is not there.
pub fn idle() -> String {
    CLEAN.replace("    vec4 color;", "    vec4 color; // landfall: allow(stale-comment)")
}

pub struct Place(pub PathBuf);

pub struct Ran {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Place {
    /// With an empty configuration, so that none further up is found.
    pub fn new(name: &str) -> Place {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("check-{name}"));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        let place = Place(path);
        place.write("landfall.toml", "");
        place
    }

    pub fn write(&self, path: &str, text: impl AsRef<[u8]>) -> &Place {
        let path = self.0.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
        self
    }

    pub fn read(&self, path: &str) -> String {
        String::from_utf8(fs::read(self.0.join(path)).unwrap()).unwrap()
    }

    pub fn has(&self, path: &str) -> bool {
        self.0.join(path).exists()
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_landfall"));
        command.args(arguments).current_dir(&self.0).stdin(Stdio::null());
        // Otherwise a key is made in the home folder of whoever runs the tests.
        command.env("LANDFALL_CACHE_KEY", "the key of these tests");
        command.env_remove("GITHUB_STEP_SUMMARY").env_remove("CLICOLOR_FORCE");
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        Ran::of(self.command(arguments).output().unwrap())
    }

    /// `check` with only the lints of these tests, its findings as JSON.
    pub fn check(&self, arguments: &[&str]) -> (i32, Vec<Value>, String) {
        let mut all =
            vec!["check", "-A", "all", "-W", "unused-allow", "-W", "stale-comment", "-f", "json"];
        all.extend(arguments);
        let ran = self.run(&all);
        let report: Value = serde_json::from_str(&ran.out)
            .unwrap_or_else(|e| panic!("{e}\n{}\n{}", ran.out, ran.err));
        (ran.code, report["findings"].as_array().unwrap().clone(), ran.err)
    }

    /// Codes with paths and lines of what is found.
    pub fn found(&self, arguments: &[&str]) -> Vec<String> {
        self.check(arguments).1.iter().map(told).collect()
    }
}

/// `unused-allow a.frag:4`.
pub fn told(finding: &Value) -> String {
    let place = &finding["place"];
    let text = |value: &Value| value.as_str().unwrap().to_string();
    format!("{} {}:{}", text(&finding["code"]), text(&place["path"]), place["line"])
}

impl Ran {
    pub fn of(output: Output) -> Ran {
        Ran {
            code: output.status.code().expect("not killed"),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }
}
