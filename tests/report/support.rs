//! Folders of shaders, runs of the command, and the scripts that read a page.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::browser::Browser;

/// A new folder, removed with the value.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Folder {
        let path =
            std::env::temp_dir().join(format!("landfall-report-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    pub fn file(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Runs landfall in a folder.
pub fn landfall(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_landfall"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .env_remove("GITHUB_ACTIONS")
        .output()
        .unwrap()
}

/// Runs landfall, which must exit with this code, and returns its standard output.
pub fn output(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let done = landfall(folder, arguments);
    let errors = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(code), "{arguments:?}: {errors}");
    String::from_utf8(done.stdout).unwrap()
}

pub fn json(folder: &Path, code: i32, arguments: &[&str]) -> Value {
    serde_json::from_str(&output(folder, code, arguments)).unwrap()
}

/// The repository, whose shaders the tests read.
pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Draws every map and fills every table, as printing does.
pub const DRAW_ALL: &str = "window.dispatchEvent(new Event('beforeprint'));";

/// The views of the blocks of a page, by a function of the page.
pub fn of_views(browser: &Browser, function: &str) -> Value {
    let script = format!(
        "return [...document.querySelectorAll('article.block')].map(({{ view }}) => ({function})(view));"
    );
    browser.run(&script, &[])
}
