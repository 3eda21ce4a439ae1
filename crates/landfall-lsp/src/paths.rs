//! One spelling of each path: an include is found as `shaders/../lights.glsl`, and open as `lights.glsl`.

use std::path::Path;

use landfall_check::walk::{joined, slashes};

/// A path without `.` and without the folders that `..` leaves again.
pub fn plain(path: &str) -> String {
    slashes(&joined(Path::new(""), Path::new(path)))
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
