//! One spelling of each path: an include is found as `shaders/../lights.glsl`, and open as `lights.glsl`.

use std::path::{Component, Path, PathBuf};

use landfall_check::walk::slashes;

/// A path without `.` and without the folders that `..` leaves again.
pub fn plain(path: &str) -> String {
    let mut plain = PathBuf::new();
    for part in Path::new(path).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(plain.components().next_back(), Some(Component::Normal(_))) =>
            {
                plain.pop();
            }
            _ => plain.push(part),
        }
    }
    slashes(&plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_folders_that_are_named_are_left() {
        for (path, expected) in [
            ("a/../b.glsl", "b.glsl"),
            ("./a/./b.glsl", "a/b.glsl"),
            ("../a/../../b.glsl", "../../b.glsl"),
            ("/a/b/../c", "/a/c"),
        ] {
            assert_eq!(plain(path), expected, "{path}");
        }
    }
}
