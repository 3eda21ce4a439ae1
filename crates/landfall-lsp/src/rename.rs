//! Renames a member in all files that declare or use it, where each use is known.
//!
//! Types of expressions are not known, so a name counts as a use of the member if nothing else of that
//! name could be meant; and all shaders must then have the layouts and the errors that they had before.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use gen_lsp_types::{PrepareRenameParams, RenameParams, TextEdit, WorkspaceEdit};
use landfall_layout::source::OpenFiles;
use landfall_layout::{Severity, ShaderLayout};
use lsp_server::{ErrorCode, ResponseError};

use crate::declarations::{Declaration, DeclarationKind, PlacedBytes, declarations};
use crate::laid_out::LaidOut;
use crate::project::CheckSetup;
use crate::server::{Server, error};
use crate::words::{Word, words};

/// Shaders that a rename reads.
const MOST_SHADERS: usize = 256;

impl Server {
    /// The range of the name to rename.
    pub fn prepare_rename(
        &mut self,
        params: &PrepareRenameParams,
    ) -> Result<gen_lsp_types::Range, ResponseError> {
        let at = &params.text_document_position_params;
        let declaration = self.member_at(at)?;
        let document = self.layouts_in(&at.text_document.uri);
        let range = document.and_then(|document| {
            let span = document.text.word(document.text.offset(at.position))?;
            Some(document.text.range(span))
        });
        range.ok_or_else(|| refused(format!("`{}` is not a name here", declaration.name)))
    }

    fn member_at(
        &mut self,
        at: &gen_lsp_types::TextDocumentPositionParams,
    ) -> Result<Declaration, ResponseError> {
        let mut found = self.declarations_at(at);
        match found.as_slice() {
            [] => Err(refused("there is no member of a block here")),
            [one] if one.kind != DeclarationKind::Member => {
                Err(refused(format!("`{}` is no member; only members are renamed", one.name)))
            }
            [_] => Ok(found.remove(0)),
            [one, other, ..] => Err(refused(format!(
                "`{}` may be a member of `{}` or of `{}`: rename it where it is declared",
                one.name, one.owner, other.owner
            ))),
        }
    }

    /// The edits that rename a member.
    pub fn rename(&mut self, params: &RenameParams) -> Result<WorkspaceEdit, ResponseError> {
        let at = &params.text_document_position_params;
        let declaration = self.member_at(at)?;
        let new = params.new_name.as_str();
        is_name(new)?;
        let path = crate::uris::path(&at.text_document.uri);
        let Some((index, setup, shown)) = path.and_then(|path| self.setup_of(&path)) else {
            return Err(refused("the document is of no project"));
        };
        if self.projects[index].memory.is_none() || self.projects[index].is_stale {
            return Err(refused("not all shaders are checked yet; try again in a moment"));
        }
        let shaders = self.shaders_declaring(index, &shown, &declaration);
        if shaders.len() > MOST_SHADERS {
            return Err(refused(format!("{} shaders have this member", shaders.len())));
        }
        let mut edits: BTreeMap<String, Vec<Range<u32>>> = BTreeMap::new();
        let mut laid_outs = Vec::new();
        for shader in &shaders {
            let Some(laid_out) = self.laid_out(index, shader) else {
                return Err(refused(format!("`{shader}` cannot be read")));
            };
            uses(&laid_out, &declaration, new, &mut edits)?;
            laid_outs.push(laid_out);
        }
        self.confirm(&setup, &laid_outs, &declaration, &edits, new)?;
        let files = edits.into_iter().filter_map(|(file, spans)| {
            let path = self.absolute(&file);
            let text = self.documents.text(&path)?;
            let edit = |span: Range<u32>| TextEdit { range: text.range(span), new_text: new.to_string() };
            Some((path, spans.into_iter().map(edit).collect()))
        });
        let files: Vec<(PathBuf, Vec<TextEdit>)> = files.collect();
        Ok(self.workspace_edit(files))
    }

    /// Checks the shaders as they would be: the same layouts under the new name, and no new error.
    fn confirm(
        &self,
        setup: &CheckSetup,
        shaders: &[Arc<LaidOut>],
        declaration: &Declaration,
        edits: &BTreeMap<String, Vec<Range<u32>>>,
        new: &str,
    ) -> Result<(), ResponseError> {
        let mut texts: Vec<(PathBuf, Arc<str>)> = Vec::new();
        for path in self.documents.paths().filter(|path| self.documents.is_live(path)) {
            let text = self.documents.get(path).map(|one| Arc::clone(one.text.text()));
            texts.extend(text.map(|text| (path.clone(), text)));
        }
        for (file, spans) in edits {
            let path = self.absolute(file);
            let Some(text) = self.documents.text(&path) else { continue };
            let mut renamed = text.text().trim_start_matches('\u{feff}').to_string();
            for span in spans.iter().rev() {
                renamed.replace_range(span.start as usize..span.end as usize, new);
            }
            texts.push((path, renamed.into()));
        }
        let before = self.open_files();
        let after = Arc::new(OpenFiles::new(self.current.clone(), texts));
        for laid_out in shaders {
            let path = self.absolute(&laid_out.shader.path);
            let errors = |open: &Arc<OpenFiles>| {
                let (found, _) = setup.check_one(&path, open, false);
                let found = found.map(|found| found.findings).unwrap_or_default();
                found.iter().filter(|one| one.severity == Severity::Error).count()
            };
            let options = {
                let mut options = setup.basis.options().with_interface(true);
                options.read.open_files = Some(Arc::clone(&after));
                options
            };
            let text = after.text(&path).map_or(&laid_out.source.text, |text| text).clone();
            let source = landfall_layout::Source { text, ..laid_out.source.clone() };
            let there = setup.basis.settings.layout(&source, &options);
            let is_same = bytes(&laid_out.shader, &declaration.name, new) == bytes(&there, "", "");
            if !is_same || errors(&after) > errors(&before) {
                return Err(refused(format!(
                    "`{}` would not be read the same in `{}` under the new name",
                    declaration.name, laid_out.shader.path
                )));
            }
        }
        Ok(())
    }
}

/// The names of all members with their bytes, one name replaced.
fn bytes(shader: &ShaderLayout, old: &str, new: &str) -> Vec<(String, Vec<PlacedBytes>)> {
    let all = declarations(shader).into_iter().map(|one| {
        let name = if one.name == old { new.to_string() } else { one.name };
        (name, one.uses.into_iter().map(|at| at.bytes).collect())
    });
    let mut all: Vec<(String, Vec<PlacedBytes>)> = all.collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// Adds the places of a member's name in all files of a shader.
fn uses(
    laid_out: &LaidOut,
    declaration: &Declaration,
    new: &str,
    edits: &mut BTreeMap<String, Vec<Range<u32>>>,
) -> Result<(), ResponseError> {
    let name = declaration.name.as_str();
    let shader = &laid_out.shader.path;
    if laid_out.shader.has_errors() {
        return Err(refused(format!("`{shader}` has errors, so that its uses are not known")));
    }
    let is_other = |one: &&Declaration| {
        one.name == name && (&one.file, &one.span) != (&declaration.file, &declaration.span)
    };
    if let Some(other) = laid_out.declarations.iter().find(is_other) {
        let of = if other.owner.is_empty() { "a block" } else { other.owner.as_str() };
        return Err(refused(format!("`{shader}` has another `{name}`, of {of}")));
    }
    if name.len() <= 4 && ["xyzw", "rgba", "stpq"].iter().any(|all| name.chars().all(|c| all.contains(c))) {
        return Err(refused(format!("`.{name}` may also be components of a vector")));
    }
    let is_global = laid_out.is_global(declaration);
    for file in laid_out.shader.files.written() {
        let bodies = structure_bodies(&file.text);
        for word in words(&file.text) {
            if word.text == new {
                return Err(refused(format!("`{}` has the name `{new}` already", file.path)));
            }
            if word.text != name {
                continue;
            }
            let is_declaration = *file.path == *declaration.file && word.span == declaration.span;
            let is_of_other =
                bodies.iter().any(|body| body.contains(&word.span.start)) && !word.is_behind_dot;
            if word.is_in_directive || is_of_other && !is_declaration {
                return Err(refused(elsewhere(&file.path, &file.text, &word)));
            }
            if is_declaration || word.is_behind_dot || is_global {
                let spans = edits.entry(file.path.clone()).or_default();
                if !spans.contains(&word.span) {
                    spans.push(word.span.clone());
                    spans.sort_by_key(|span| span.start);
                }
            }
        }
    }
    Ok(())
}

fn elsewhere(path: &str, text: &str, word: &Word<'_>) -> String {
    let line = text[..word.span.start as usize].matches('\n').count() + 1;
    format!("`{}` stands for something else at {path}:{line}", word.text)
}

/// The bodies of structures and interface blocks: of braces that no function has before them.
fn structure_bodies(text: &str) -> Vec<Range<u32>> {
    let mut bodies = Vec::new();
    let (mut depth, mut start, mut header) = (0_usize, 0, 0);
    for (at, c) in text.char_indices() {
        match c {
            '{' => {
                if depth == 0 {
                    start = at;
                }
                depth += 1;
            }
            '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    let before = words(&text[header..start]);
                    let is_function = text[header..start].trim_end().ends_with(')')
                        || before.iter().any(|word| word.text == "fn");
                    if !is_function {
                        bodies.push(start as u32..at as u32);
                    }
                    header = at + 1;
                }
            }
            ';' if depth == 0 => header = at + 1,
            _ => {}
        }
    }
    bodies
}

fn is_name(new: &str) -> Result<(), ResponseError> {
    let mut letters = new.chars();
    let starts = letters.next().is_some_and(|c| c == '_' || c.is_ascii_alphabetic());
    match starts && letters.all(|c| c == '_' || c.is_ascii_alphanumeric()) {
        true => Ok(()),
        false => Err(refused(format!("`{new}` is no name"))),
    }
}

fn refused(message: impl Into<String>) -> ResponseError {
    error(ErrorCode::RequestFailed, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_no_structures() {
        let text = "struct A { int a; };\nvoid f(int b) { if (b) { b; } }\nfn g() -> f32 { c; }\n\
                    uniform B { int d; } e;\n";
        let bodies = structure_bodies(text);
        let found: Vec<&str> =
            bodies.iter().map(|body| &text[body.start as usize..body.end as usize]).collect();
        assert_eq!(found, ["{ int a; ", "{ int d; "]);
    }
}
