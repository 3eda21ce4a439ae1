//! The directory that the paths of a project are relative to.

use std::path::{Component, Path, PathBuf};

use landfall_layout::Error;
use landfall_layout::file::{FileWriter, reason};
use landfall_layout::text::glob;

use crate::walk::slashes;

/// The root directory, as messages show it and as an absolute path.
#[derive(Clone, Debug, Default)]
pub struct Root {
    /// The path from the current directory; empty for that directory.
    pub shown: PathBuf,
    real: PathBuf,
    current: PathBuf,
}

impl Root {
    /// Creates the root with this displayed path.
    pub fn new(shown: &Path) -> Result<Root, Error> {
        let current = current()?;
        Ok(Root { shown: clean(shown), real: absolute(&current, shown), current })
    }

    /// Converts a path of the configuration to the form of messages.
    pub fn path(&self, named: &str) -> PathBuf {
        let joined = clean(&self.shown.join(named));
        if joined.as_os_str().is_empty() { PathBuf::from(".") } else { joined }
    }

    /// Converts a glob of the configuration to match paths in the form of messages.
    pub fn glob(&self, named: &str) -> String {
        let named = named.strip_prefix("./").unwrap_or(named);
        if named.is_empty() || self.shown.as_os_str().is_empty() {
            return named.to_string();
        }
        if Path::new(named).is_absolute() {
            return named.to_string();
        }
        // What the directory's name contains is no pattern.
        format!("{}/{named}", glob::escape(&slashes(&self.shown)))
    }

    /// The path of a file relative to the root; `None` outside it.
    pub fn below(&self, path: &Path) -> Option<String> {
        // Most paths do not depend on the current directory.
        if self.shown.as_os_str().is_empty()
            && path.components().all(|c| matches!(c, Component::Normal(_)))
        {
            return Some(slashes(path));
        }
        let real = absolute(&self.current, path);
        real.strip_prefix(&self.real).ok().map(slashes)
    }

    /// A writer for a directory. It follows no link out of the project, or out of the directory if
    /// that is outside the project.
    pub fn writer(&self, folder: &Path) -> FileWriter {
        let tree = if self.below(folder).is_some() { self.path("") } else { folder.to_path_buf() };
        crate::files::writer().inside(&tree)
    }

    /// The path of a file in messages, independent of its spelling on the command line.
    pub fn show(&self, path: &Path) -> String {
        match self.below(path) {
            Some(below) => slashes(&self.shown.join(below)),
            None => slashes(&clean(path)),
        }
    }
}

pub fn current() -> Result<PathBuf, Error> {
    let failed = |cause| Error::new(".", format!("cannot be found: {}", reason(&cause)));
    std::env::current_dir().map_err(failed)
}

/// The root of the git repository that contains a directory; of a submodule, that of the whole.
pub fn repository(folder: &Path) -> Option<&Path> {
    folder.ancestors().find(|folder| {
        let git = folder.join(".git");
        git.is_dir() || git.is_file() && !is_submodule(&git)
    })
}

/// Whether the `.git` file of a work tree names the directory of a submodule.
fn is_submodule(git: &Path) -> bool {
    let text = crate::files::file(git).unwrap_or_default();
    String::from_utf8_lossy(&text).contains("/modules/")
}

/// An absolute path without `.` and `..`.
pub fn absolute(current: &Path, path: &Path) -> PathBuf {
    // Links are not followed: the path need not exist, and is shown as it was named.
    let mut real = PathBuf::new();
    for part in current.join(path).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                real.pop();
            }
            Component::Prefix(_) | Component::RootDir | Component::Normal(_) => real.push(part),
        }
    }
    real
}

/// The way from one directory to another, both from the root of the file system.
pub fn relative_path(from: &Path, to: &Path) -> PathBuf {
    let common = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    // On Windows, another drive.
    if common == 0 {
        return to.to_path_buf();
    }
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    up.chain(to.components().skip(common)).collect()
}

fn clean(path: &Path) -> PathBuf {
    path.components().filter(|part| *part != Component::CurDir).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root(shown: &str, real: &str) -> Root {
        Root { shown: shown.into(), real: real.into(), current: "/p/sub".into() }
    }

    #[test]
    fn a_file_is_shown_alike_however_it_is_spelled() {
        let above = root("..", "/p");
        for spelled in ["a.frag", "./a.frag", "../sub/a.frag", "/p/sub/a.frag"] {
            assert_eq!(above.below(Path::new(spelled)).as_deref(), Some("sub/a.frag"), "{spelled}");
            assert_eq!(above.show(Path::new(spelled)), "../sub/a.frag", "{spelled}");
        }
        let here = root("", "/p/sub");
        assert_eq!(here.show(Path::new("./x/../a.frag")), "a.frag");
        assert_eq!(here.below(Path::new("../b.frag")), None);
        assert_eq!(here.show(Path::new("../b.frag")), "../b.frag");
    }

    #[test]
    fn the_way_goes_up_and_down() {
        let way = |from, to| relative_path(Path::new(from), Path::new(to)).display().to_string();
        assert_eq!(way("/p/sub/x", "/p"), "../..");
        assert_eq!(way("/p", "/p/sub"), "sub");
        assert_eq!(way("/p/a", "/p/b/c"), "../b/c");
        assert_eq!(way("/p", "/p"), "");
    }
}
