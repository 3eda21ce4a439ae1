//! Which project a document is of, and the checks of documents as they are edited.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use landfall_check::config;
use landfall_layout::source::kind_of_path;

use crate::project::{CheckSetup, Project};
use crate::server::EditorServer;

impl EditorServer {
    /// Opens the projects of the client's folders.
    pub fn open_folders(&mut self) {
        for folder in self.folders.clone() {
            self.project_at(&folder.join("shader"), true);
        }
    }

    /// Reads all configurations again.
    pub fn reload_projects(&mut self) {
        let open = self.open_files();
        let flags = self.settings.flags().unwrap_or_default();
        for index in 0..self.projects.len() {
            self.postpone_pass(index);
            let base = self.projects[index].base.clone();
            let near = base.join("shader");
            let folder = self.folder_of(&near);
            let read = CheckSetup::read(&near, folder.as_deref(), &flags, &open);
            self.projects[index].configure(read);
        }
        // A configuration that is new or gone divides the documents otherwise.
        self.project_of.clear();
        self.open_folders();
        let documents: Vec<PathBuf> = self.documents.paths().cloned().collect();
        for path in documents {
            self.find_project(&path);
            self.edited.insert(path);
        }
        self.drop_unused_projects();
        self.layouts = Default::default();
        self.publish_all();
        self.due = Some(Instant::now());
    }

    /// Empties projects that no folder and no document is of; their numbers stay.
    fn drop_unused_projects(&mut self) {
        let mut used: HashSet<usize> = self.project_of.values().copied().collect();
        for folder in self.folders.clone() {
            used.extend(self.project_at(&folder.join("shader"), true));
        }
        for (index, project) in self.projects.iter_mut().enumerate() {
            if !used.contains(&index) {
                let base = project.base.clone();
                let generation = project.generation + 1;
                *project = Project { is_stale: false, generation, ..Project::new(base) };
            }
        }
    }

    /// The innermost folder of the client that holds a file.
    fn folder_of(&self, path: &Path) -> Option<PathBuf> {
        let holds = self.folders.iter().filter(|folder| path.starts_with(folder));
        holds.max_by_key(|folder| folder.components().count()).cloned()
    }

    /// The project of a file, opened if it is new.
    fn project_at(&mut self, path: &Path, is_folder: bool) -> Option<usize> {
        let folder = self.folder_of(path);
        let open = self.open_files();
        let flags = self.settings.flags().unwrap_or_default();
        let read = CheckSetup::read(path, folder.as_deref(), &flags, &open);
        let configured = read.as_ref().ok().and_then(|setup| {
            let file = setup.config.file.as_ref()?;
            Some(config::absolute(&self.current, file.parent()?))
        });
        let beside = || path.parent().map(Path::to_path_buf);
        let base = match &read {
            Ok(_) => configured.or(folder).or_else(beside)?,
            // A broken configuration is that of its own folder.
            Err(faults) => {
                let file = self.absolute(&faults.first()?.place().path);
                file.parent()?.to_path_buf()
            }
        };
        if let Some(known) = self.projects.iter().position(|project| project.base == base) {
            let project = &mut self.projects[known];
            if project.setup.is_none() {
                project.configure(read);
            }
            return Some(known);
        }
        let mut project = Project::new(base);
        project.configure(read);
        project.is_stale = is_folder || project.setup.as_ref().is_some_and(|s| !s.paths.is_empty());
        self.projects.push(project);
        Some(self.projects.len() - 1)
    }

    /// Finds the project of an open document.
    pub fn find_project(&mut self, path: &Path) {
        if !is_shader(path) {
            return;
        }
        if let Some(index) = self.project_at(path, false) {
            self.project_of.insert(path.to_path_buf(), index);
            if self.projects[index].is_stale {
                self.due.get_or_insert_with(Instant::now);
            }
        }
    }

    /// The configuration and the path by which a document is checked.
    pub fn setup_of(&self, path: &Path) -> Option<(usize, std::sync::Arc<CheckSetup>, String)> {
        let index = *self.project_of.get(path)?;
        let setup = self.projects[index].setup.clone()?;
        let shown = setup.shown(path);
        Some((index, setup, shown))
    }

    /// Checks the documents that have changed, and the open ones that include them.
    pub fn check_edited(&mut self) {
        let edited: Vec<PathBuf> = self.edited.drain().collect();
        if edited.is_empty() {
            return;
        }
        let mut to_check: HashSet<PathBuf> = HashSet::new();
        for path in edited.iter().filter(|path| self.documents.is_live(path)) {
            let Some((index, _, shown)) = self.setup_of(path) else { continue };
            let including = self.projects[index].shaders_with(&shown);
            let including = including.into_iter().map(|shader| self.absolute(shader));
            to_check.extend(including.filter(|shader| self.documents.get(shader).is_some()));
            to_check.insert(path.clone());
        }
        let open = self.open_files();
        let mut touched: HashSet<PathBuf> = HashSet::new();
        for path in to_check {
            let Some((index, setup, shown)) = self.setup_of(&path) else { continue };
            if setup.config.excludes(&path) {
                continue;
            }
            let (found, _) = setup.check_one(&path, &open, false);
            let Some(found) = found else { continue };
            let project = &mut self.projects[index];
            let old = project.shader(&shown).map(|old| old.findings.clone()).unwrap_or_default();
            let places: Vec<String> =
                old.iter().chain(&found.findings).map(|one| one.place().path.clone()).collect();
            project.since.insert(shown, found);
            touched.extend(places.iter().map(|place| self.absolute(place)));
        }
        self.publish(&touched);
    }
}

/// Whether a document is a shader that is checked.
pub fn is_shader(path: &Path) -> bool {
    kind_of_path(path).is_some()
}

/// Whether a file is a configuration.
pub fn is_configuration(path: &Path) -> bool {
    path.file_name().is_some_and(|name| config::NAMES.iter().any(|known| name == *known))
}
