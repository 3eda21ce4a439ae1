//! What the names and paths in a module stand for.

use std::path::{Path, PathBuf};

use super::{Linker, ROOT, Referent, Sought, not_found};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;
use crate::source::file_cache::FoundFile;
use crate::syntax::above;
use crate::text::edit_distance::suggestion;

impl Linker<'_> {
    /// Returns the module at a path, and where it was looked for or which files state the path.
    // By module and path, since `super` and `package` depend on where they stand.
    fn module_at(&mut self, from: usize, path: &[String], at: Span) -> Result<Sought, Diagnostic> {
        let key = (from, path.to_vec());
        if let Some(known) = self.by_path.get(&key) {
            return Ok(known.clone());
        }
        let file = self.modules[from].file.clone();
        let (places, found) = self.module_file(&file, path);
        let module = match found {
            Some(found) => {
                let loaded = self.load(&found, at)?;
                Some(self.add_module(loaded)?)
            }
            None => None,
        };
        let sought: Sought = (places.into(), module);
        self.by_path.insert(key, sought.clone());
        Ok(sought)
    }

    /// Returns the file of the module at a path, and where it was looked for; of a module of naga_oil
    /// the files that state the path.
    fn module_file(&mut self, from: &Path, path: &[String]) -> FoundFile {
        let way = if self.is_naga_oil { "module of naga_oil" } else { "module" };
        let options = self.options;
        options.found(way, from, &path.join("::"), || self.sought_module_file(from, path))
    }

    fn sought_module_file(&mut self, from: &Path, path: &[String]) -> FoundFile {
        if self.is_naga_oil && !path.first().is_some_and(|first| first.contains(['/', '.'])) {
            let named = self.packages.named(from, &path.join("::"));
            if let Some(first) = named.first().cloned() {
                return (named, Some(first));
            }
        }
        let (places, found) = self.file_by_folders(from, path);
        (if found.is_none() { places } else { Vec::new() }, found)
    }

    // `package` :: …   from the root of the own package
    // `super` :: …     from the file's own folder, one further up for each `super` after the first
    // name :: …        from a package of that name, or a folder of the own one
    // "file"           beside the importing file
    fn file_by_folders(&self, from: &Path, path: &[String]) -> FoundFile {
        let Some(first) = path.first() else { return (Vec::new(), None) };
        if first.contains(['/', '.']) {
            return if path.len() == 1 {
                self.packages.text(from, first)
            } else {
                (Vec::new(), None)
            };
        }
        match first.as_str() {
            "package" => self.packages.module(&self.packages.own(from), &path[1..]),
            "super" => {
                let up = path.iter().take_while(|part| *part == "super").count();
                // The folder that a module's file stands in is its parent.
                let folder = above(from).nth(up);
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

    /// Adds what the shader imports publicly: its entry points, variables and overrides are its own.
    pub(super) fn export(&mut self) {
        let public = self.modules[ROOT].aliases.values().filter(|import| import.is_public);
        let mut public: Vec<(String, Span)> =
            public.map(|import| (import.alias.clone(), import.at)).collect();
        public.sort_unstable_by_key(|(_, at)| at.start);
        for (alias, at) in public {
            match self.referent(ROOT, std::slice::from_ref(&alias), at, "") {
                Ok(Some(Referent::Declaration(target))) => {
                    self.used_name(target);
                    self.exported.insert(target, alias);
                }
                Ok(Some(Referent::Value(_)) | None) => {}
                Err(error) => self.fail(error),
            }
        }
    }

    /// Returns the module that declares a name, of all that state the path of a module of naga_oil:
    /// a program may have one instead of another.
    fn declaring(
        &mut self,
        found: usize,
        stating: &[PathBuf],
        path: &[String],
        name: &str,
        at: Span,
    ) -> Result<usize, Diagnostic> {
        if stating.len() < 2 {
            return Ok(found);
        }
        let mut declaring = Vec::new();
        for file in stating {
            let loaded = self.load(file, at)?;
            let module = self.add_module(loaded)?;
            if self.modules[module].outline.names.contains_key(name) {
                declaring.push(module);
            }
        }
        if let [first, second, ..] = declaring[..] {
            let [read, other] =
                [first, second].map(|at| self.modules[at].file.display().to_string());
            let path = path.join("::");
            let message = format!("`{path}` is the path of two modules that declare `{name}`");
            let warning = Diagnostic::warning(Code::DuplicateName, at, message);
            let note = format!("`{read}` is read, `{other}` is not");
            self.warnings.add(warning.with_note(note));
        }
        Ok(declaring.first().copied().unwrap_or(found))
    }

    /// Returns what a path in a module stands for; `None` for a name that no module declares.
    // 1. An import's alias is replaced by its path. 2. A single name is a declaration of the module
    // itself, or none. 3. All but the last name of a path lead to a module, the last to a
    // declaration in it, or to one that it imports in turn. `enter` bounds the chain of such
    // imports, which may be cyclic.
    pub(super) fn referent(
        &mut self,
        module: usize,
        path: &[String],
        at: Span,
        before: &str,
    ) -> Result<Option<Referent>, Diagnostic> {
        let (first, rest) = (&path[0], &path[1..]);
        // What an import names is missing there, and not at each use.
        let import = self.modules[module].aliases.get(first);
        let named_at = import.map_or(at, |import| import.at);
        let path = match import {
            Some(import) => import.path.iter().chain(rest).cloned().collect::<Vec<_>>(),
            None if rest.is_empty() => {
                let own = self.modules[module].outline.names.get(first.as_str());
                return Ok(own.map(|&index| Referent::Declaration((module, index))));
            }
            None => path.to_vec(),
        };
        if let [package, name] = &path[..] {
            if package == "constants" {
                return Ok(self.value(name, at, before)?.map(Referent::Value));
            }
        }
        let (name, of) = path.split_last().expect("a path has a name");
        let (places, found) = self.module_at(module, of, named_at)?;
        let Some(found) = found else {
            let message = format!("the module `{}` is not found", of.join("::"));
            let help = "name the folder of the package with `-I DIR`";
            return Err(not_found(message, &places, named_at).with_help(help));
        };
        let found = self.declaring(found, &places, of, name, named_at)?;
        let there = &self.modules[found];
        if let Some(&index) = there.outline.names.get(name.as_str()) {
            return Ok(Some(Referent::Declaration((found, index))));
        }
        // What the module itself imports.
        if there.aliases.contains_key(name) {
            let name = std::slice::from_ref(name);
            return self.enter(at, |linker| linker.referent(found, name, at, before));
        }
        let message = format!("`{}` has no `{name}`", there.file.display());
        let place = if rest.is_empty() { named_at } else { at };
        let error = Diagnostic::error(Code::UnknownName, place, message);
        Err(match suggestion(name, there.outline.names.keys().copied()) {
            Some(help) => error.with_help(help),
            None => error.with_note("a condition may leave it out: `-D FLAG` sets one"),
        })
    }
}
