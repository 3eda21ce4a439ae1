//! Paths in reports for other programs, relative to the root of the repository.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::finding::{Finding, Place};

use landfall_check::config::{absolute, current, relative_path, repository};
use landfall_check::walk::slashes;

/// Environment variables in which CI systems name the directory of the checkout: GitHub, GitLab,
/// Azure, Bitbucket, Buildkite, Woodpecker, Travis, AppVeyor and Jenkins.
const VARIABLES: [&str; 9] = [
    "GITHUB_WORKSPACE",
    "CI_PROJECT_DIR",
    "BUILD_SOURCESDIRECTORY",
    "BITBUCKET_CLONE_DIR",
    "BUILDKITE_BUILD_CHECKOUT_PATH",
    "CI_WORKSPACE",
    "TRAVIS_BUILD_DIR",
    "APPVEYOR_BUILD_FOLDER",
    "WORKSPACE",
];

/// The directory that paths are made relative to, and the one that they are relative to.
pub struct ReportRoot {
    root: PathBuf,
    current: PathBuf,
}

impl ReportRoot {
    /// The root above the current directory; `None` if there is none, or if it is that directory.
    pub fn find() -> Option<ReportRoot> {
        let current = fs::canonicalize(current().ok()?).ok()?;
        // The variable must name a directory that contains this one; a leftover of another job
        // does not.
        let checkout = VARIABLES.iter().find_map(|name| {
            let folder = std::env::var_os(name).map(PathBuf::from)?;
            let folder = fs::canonicalize(folder.is_absolute().then_some(folder)?).ok()?;
            current.starts_with(&folder).then_some(folder)
        });
        let root = checkout.or_else(|| repository(&current).map(Path::to_path_buf))?;
        (root != current).then_some(ReportRoot { root, current })
    }

    /// The findings with their paths from the root; not those of `given` texts, which are no files.
    pub fn findings(&self, found: &[Finding], given: &HashMap<String, String>) -> Vec<Finding> {
        let mut found = found.to_vec();
        for finding in &mut found {
            let labels = finding.labels.iter_mut().map(|label| &mut label.at);
            let places = labels.chain(finding.fix.iter_mut().map(|edit| &mut edit.at));
            places.filter(|at| !given.contains_key(&at.path)).for_each(|at| self.rebase(at));
        }
        found
    }

    fn rebase(&self, at: &mut Place) {
        if !at.path.is_empty() {
            at.path =
                slashes(&relative_path(&self.root, &absolute(&self.current, Path::new(&at.path))));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_start_at_the_root_of_the_repository() {
        let base = ReportRoot { root: "/p".into(), current: "/p/engine".into() };
        let rebased = |path: &str| {
            let mut place = Place::file(path);
            base.rebase(&mut place);
            place.path
        };
        assert_eq!(rebased("a.frag"), "engine/a.frag");
        assert_eq!(rebased("../shaders/a.frag"), "shaders/a.frag");
        assert_eq!(rebased("/p/b.frag"), "b.frag");
        assert_eq!(rebased("/elsewhere/c.frag"), "../elsewhere/c.frag");
        assert_eq!(rebased(""), "");
    }
}
