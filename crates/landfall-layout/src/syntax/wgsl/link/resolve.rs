//! What the names and paths in a module stand for.

use std::path::{Path, PathBuf};

use super::packages;
use super::{Linker, Meaning, not_found};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

impl Linker<'_> {
    /// Returns the module at a path, and where it was looked for.
    fn module_at(
        &mut self,
        from: usize,
        path: &[String],
        at: Span,
    ) -> Result<(Vec<PathBuf>, Option<usize>), Diagnostic> {
        let file = self.modules[from].file.clone();
        let (places, found) = self.module_file(&file, path);
        let Some(found) = found else { return Ok((places, None)) };
        let loaded = self.load(&found, at)?;
        Ok((places, Some(self.add_module(loaded, false)?)))
    }

    /// Returns the file of the module at a path, and where it was looked for.
    fn module_file(&mut self, from: &Path, path: &[String]) -> (Vec<PathBuf>, Option<PathBuf>) {
        let Some(first) = path.first() else { return (Vec::new(), None) };
        if first.contains(['/', '.']) {
            return if path.len() == 1 {
                self.packages.text(from, first)
            } else {
                (Vec::new(), None)
            };
        }
        if self.is_naga_oil {
            if let Some(named) = self.packages.named(from, &path.join("::")) {
                return (Vec::new(), Some(named));
            }
        }
        match first.as_str() {
            "package" => self.packages.module(&self.packages.own(from), &path[1..]),
            "super" => {
                let up = path.iter().take_while(|part| *part == "super").count();
                // The folder that a module's file stands in is its parent.
                let folder = packages::above(from).nth(up);
                self.packages.module(folder.as_slice(), &path[up..])
            }
            name => {
                let roots = self.packages.packages(from, name);
                let (mut places, mut found) = self.packages.module(&roots, &path[1..]);
                if found.is_none() {
                    // A folder of the own package, named from its root.
                    let own = self.packages.own(from);
                    let (more, at_root) = self.packages.module(&own, path);
                    places.extend(more);
                    found = at_root;
                }
                (places, found)
            }
        }
    }

    /// Returns what a path in a module stands for; `None` for a name of its own, or a predeclared one.
    pub(super) fn meaning(
        &mut self,
        module: usize,
        path: &[String],
        at: Span,
        before: &str,
    ) -> Result<Option<Meaning>, Diagnostic> {
        self.enter(at, |linker| linker.meaning_of(module, path, at, before))
    }

    fn meaning_of(
        &mut self,
        module: usize,
        path: &[String],
        at: Span,
        before: &str,
    ) -> Result<Option<Meaning>, Diagnostic> {
        let (first, rest) = (&path[0], &path[1..]);
        let import = self.modules[module].aliases.get(first).cloned();
        let path = match import {
            Some(import) => import.path.iter().chain(rest).cloned().collect::<Vec<_>>(),
            None if rest.is_empty() => {
                let own = self.modules[module].names.get(first);
                return Ok(own.map(|&index| Meaning::Declaration((module, index))));
            }
            None => path.to_vec(),
        };
        if let [package, name] = &path[..] {
            if package == "constants" {
                return Ok(self.value(name, at, before)?.map(Meaning::Value));
            }
        }
        let (name, of) = path.split_last().expect("a path has a name");
        let (places, found) = self.module_at(module, of, at)?;
        if let Some(found) = found {
            if let Some(&index) = self.modules[found].names.get(name) {
                return Ok(Some(Meaning::Declaration((found, index))));
            }
            // What the module itself imports.
            if self.modules[found].aliases.contains_key(name) {
                return self.meaning(found, std::slice::from_ref(name), at, before);
            }
            let message = format!("`{}` has no `{name}`", self.modules[found].file.display());
            let known = self.modules[found].names.keys().map(String::as_str);
            let error = Diagnostic::error(Code::UnknownName, at, message);
            return Err(match crate::text::edit_distance::nearest(name, known) {
                Some(near) => error.with_help(format!("did you mean `{near}`?")),
                None => error.with_note("a condition may leave it out: `-D FLAG` sets one"),
            });
        }
        let message = format!("the module `{}` is not found", of.join("::"));
        Err(not_found(message, &places, at)
            .with_help("name the folder of the package with `-I DIR`"))
    }
}
