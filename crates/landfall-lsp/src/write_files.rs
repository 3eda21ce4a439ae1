//! Code actions that write files: a mirror in Rust, an entry of `[[assert]]`, and the file of one. Nothing
//! is written over but a file of `[[assert]]`, which `landfall emit` writes.

use std::path::Path;

use gen_lsp_types::{
    CodeAction, CreateFile, DocumentChange, Position, Range, TextEdit, Uri, WorkspaceEdit,
};
use landfall_check::stop::StopFlag;
use landfall_codegen::CodeOptions;
use landfall_codegen::languages::{C, RUST};
use landfall_layout::Severity;
use landfall_layout::finding::Finding;
use landfall_layout::text::glob;

use crate::actions::{edited, refactor};
use crate::answers::DocumentLayouts;
use crate::declarations::{DeclarationKind, PlacedDeclaration};
use crate::project::CheckSetup;
use crate::server::EditorServer;

impl EditorServer {
    /// Writes what a block or structure lacks: a mirror, and an assertion.
    pub fn write_actions(
        &self,
        declaration: &PlacedDeclaration,
        document: &DocumentLayouts,
    ) -> Vec<CodeAction> {
        let Some(setup) = &self.projects[document.index].setup else { return Vec::new() };
        let mirror = match declaration.kind {
            DeclarationKind::Block => self.mirror_action(setup, declaration, document),
            _ => None,
        };
        let assertion = self.assertion_action(setup, declaration, &document.shown);
        mirror.into_iter().chain(assertion).collect()
    }

    /// Writes the mirror of a block that has none, beside its shader or where `[[rust-mirror]]` has it.
    fn mirror_action(
        &self,
        setup: &CheckSetup,
        declaration: &PlacedDeclaration,
        document: &DocumentLayouts,
    ) -> Option<CodeAction> {
        let (name, shown) = (&declaration.name, &document.shown);
        let mirrors = &self.projects[document.index].found.mirrors;
        if !self.support.creates_files || mirrors.iter().any(|mirror| mirror.is_of(shown, name)) {
            return None;
        }
        let all = &setup.basis.settings.rust_mirrors;
        let configured =
            all.iter().find(|one| one.block == *name && glob::matches(&one.shader, shown));
        let path = match configured {
            Some(mirror) => self.absolute(&mirror.file),
            None => self.absolute(shown).with_file_name(format!("{}.rs", snake_case(name))),
        };
        if self.is_there(&path) {
            return None;
        }
        let use_of_block = declaration.uses.first()?;
        let laid_out = document.layouts.iter().find(|one| {
            one.shader.blocks.get(use_of_block.block).is_some_and(|block| *block.name == **name)
        })?;
        let block = laid_out.shader.blocks.get(use_of_block.block)?;
        let mut options = CodeOptions::default();
        options.rust.project_renames.clone_from(&setup.config.rename);
        options.rust.project_types.clone_from(&setup.config.types);
        options.rust.derives.clone_from(&setup.config.derives);
        if let Some(mirror) = configured {
            options.rust.rename.push((name.clone(), mirror.structure.clone()));
        }
        // With the files, by which the text says where it is from.
        let mut shader = laid_out.shader.of_block(block);
        shader.path.clone_from(&laid_out.shader.path);
        shader.files = laid_out.shader.files.clone();
        let output = RUST.generate(&[&shader], &options);
        if output.diagnostics.iter().any(|found| found.severity == Severity::Error) {
            return None;
        }
        let text = match configured {
            Some(_) => output.text,
            None => with_comment(&output.text, name)?,
        };
        let file = setup.shown(&path);
        let title = format!("Write the mirror of `{name}` in Rust: `{file}`");
        Some(refactor(edited(&title, self.created(&path, text))))
    }

    /// Appends an entry of `[[assert]]` about a block or structure that has none to the configuration.
    fn assertion_action(
        &self,
        setup: &CheckSetup,
        declaration: &PlacedDeclaration,
        shown: &str,
    ) -> Option<CodeAction> {
        let name = &declaration.name;
        let mut all = setup.config.assertions.iter();
        let is_held = all.any(|file| {
            file.takes(shown) && file.options.assertions.structures.iter().any(|(_, of)| of == name)
        });
        let config = self.absolute(&setup.config.file.as_ref()?.to_string_lossy());
        let text = self.documents.text(&config)?;
        let shader = setup.config.root.below(&self.absolute(shown))?;
        let out = Path::new(&shader).with_file_name(format!("{}_assert.hpp", snake_case(name)));
        let shown_out = setup.config.root.path(&out.to_string_lossy());
        let is_there = self.is_there(&self.absolute(&shown_out.to_string_lossy()));
        if is_held || is_there || !declaration.kind.has_members() {
            return None;
        }
        let out = landfall_check::walk::slashes(&out);
        let quoted = |text: &str| serde_json::to_string(text).unwrap_or_default();
        let (out, shader) = (quoted(&out), quoted(&shader));
        let before =
            if text.plain().is_empty() || text.plain().ends_with('\n') { "" } else { "\n" };
        let entry = format!(
            "{before}\n# Holds a structure of the program to `{name}`. Set the names: in `structures` the \
             program's is the first,\n# `fields` has those that differ. `landfall emit` writes the file.\n\
             [[assert]]\nout = {out}\nlang = \"{}\"\nshaders = [{shader}]\n\
             structures = {{ \"{name}\" = \"{name}\" }}\n\
             # fields = {{ \"{name}.member\" = \"field\" }}\n\
             # include-header = [\"the header that declares it\"]\n",
            C.name
        );
        let range = Range { start: text.end(), end: text.end() };
        let edit = TextEdit { range, new_text: entry };
        let title = format!("Hold a structure of the program to `{name}`: `[[assert]]`");
        Some(refactor(edited(&title, self.workspace_edit(vec![(config, vec![edit])]))))
    }

    /// Writes a file of `[[assert]]` that is not the one of the shaders.
    pub fn rewrite_action(&self, finding: &Finding) -> Option<CodeAction> {
        let setups = self.projects.iter().filter_map(|project| project.setup.as_ref());
        let mut rows =
            setups.flat_map(|setup| setup.config.assertions.iter().map(move |file| (setup, file)));
        let (setup, file) = rows.find(|(_, file)| {
            file.place == *finding.place() && file.out.display().to_string() == finding.about
        })?;
        let made = file.text(&setup.basis, &StopFlag::default()).ok()?;
        let path = self.absolute(&file.out.to_string_lossy());
        // As `landfall emit`, not over a shader or the configuration.
        let mut inputs = made.files.iter().chain(&setup.config.file);
        if inputs.any(|input| self.absolute(&input.to_string_lossy()) == path) {
            return None;
        }
        let edit = match self.documents.text(&path) {
            Some(old) => {
                let range = Range { start: Position { line: 0, character: 0 }, end: old.end() };
                let edit = TextEdit { range, new_text: made.text };
                self.workspace_edit(vec![(path, vec![edit])])
            }
            None if path.exists() || !self.support.creates_files => return None,
            None => self.created(&path, made.text),
        };
        Some(CodeAction {
            is_preferred: Some(true),
            ..edited(&format!("Write `{}`", finding.about), edit)
        })
    }

    fn is_there(&self, path: &Path) -> bool {
        path.symlink_metadata().is_ok() || self.documents.get(path).is_some()
    }

    /// An edit that creates a file.
    fn created(&self, path: &Path, text: String) -> WorkspaceEdit {
        let uri: Uri = crate::uris::uri(path);
        let create = CreateFile { uri, options: None, annotation_id: None };
        let edit = TextEdit { range: Range::default(), new_text: text };
        let all = vec![DocumentChange::CreateFile(create), self.document_edit(path, vec![edit])];
        WorkspaceEdit { document_changes: Some(all), ..WorkspaceEdit::default() }
    }
}

/// Generated Rust whose structure of that name a comment names as a mirror, so that it is compared.
fn with_comment(text: &str, name: &str) -> Option<String> {
    let structure = text.find(&format!("pub struct {name} {{"))?;
    // Its attributes, and the text about it.
    let start = text[..structure].rfind("\n\n").map_or(0, |end| end + 2);
    Some(format!("{}// landfall: mirror({name})\n{}", &text[..start], &text[start..]))
}

/// `PointLightBlock` as `point_light_block`.
fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    let mut was_lower = false;
    for c in name.chars() {
        if c.is_uppercase() && was_lower {
            snake.push('_');
        }
        was_lower = !c.is_uppercase() && c != '_';
        snake.extend(c.to_lowercase());
    }
    snake
}
