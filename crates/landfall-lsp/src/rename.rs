//! Renames a member in all files that declare or use it, where each use is known: those whose owner can be
//! followed, or that nothing else of that name could be. All shaders must then have the layouts and the
//! errors that they had before.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use gen_lsp_types::{PrepareRenameParams, RenameParams, TextEdit, WorkspaceEdit};
use landfall_layout::finding::Place;
use landfall_layout::source::{File, OpenFiles};
use landfall_layout::{Severity, ShaderLayout};
use lsp_server::{ErrorCode, ResponseError};

use crate::declarations::{DeclarationKind, PlacedBytes, PlacedDeclaration, declarations};
use crate::laid_out::LaidOut;
use crate::owners::OwnerResolver;
use crate::paths::plain;
use crate::project::CheckSetup;
use crate::server::{EditorServer, error};
use crate::words::{TextWord, words};

/// Shaders that a rename reads.
const MAX_SHADERS: usize = 256;

impl EditorServer {
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
    ) -> Result<PlacedDeclaration, ResponseError> {
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
        let laid_outs = self.concerned(index, &shown, &declaration)?;
        let mut edits: BTreeMap<String, Vec<Range<u32>>> = BTreeMap::new();
        for laid_out in &laid_outs {
            uses(laid_out, &declaration, new, &mut edits)?;
        }
        self.confirm(&setup, &laid_outs, &declaration, &edits, new)?;
        let files = edits.into_iter().filter_map(|(file, spans)| {
            let path = self.absolute(&file);
            let text = self.documents.text(&path)?;
            let edit =
                |span: Range<u32>| TextEdit { range: text.range(span), new_text: new.to_string() };
            Some((path, spans.into_iter().map(edit).collect()))
        });
        let files: Vec<(PathBuf, Vec<TextEdit>)> = files.collect();
        Ok(self.workspace_edit(files))
    }

    /// The shaders that have the declaration, and those that declare the same block for themselves, as
    /// the stages of one program do.
    fn concerned(
        &mut self,
        index: usize,
        shown: &str,
        declaration: &PlacedDeclaration,
    ) -> Result<Vec<Arc<LaidOut>>, ResponseError> {
        let declaring = self.shaders_declaring(index, shown, declaration);
        let blocks = &self.projects[index].found.blocks;
        let has_block =
            |all: &[(String, Place)]| all.iter().any(|(name, _)| declaration.blocks.contains(name));
        let alike =
            blocks.iter().filter(|(shader, all)| !declaring.contains(shader) && has_block(all));
        let mut alike: Vec<String> = alike.map(|(shader, _)| shader.clone()).collect();
        alike.sort_unstable();
        if declaring.len() + alike.len() > MAX_SHADERS {
            let count = declaring.len() + alike.len();
            return Err(refused(format!("{count} shaders have this member or one of its name")));
        }
        let mut found = Vec::new();
        let mut own_shapes = Vec::new();
        for (number, shader) in declaring.iter().chain(&alike).enumerate() {
            let Some(laid_out) = self.laid_out(index, shader) else {
                return Err(refused(format!("`{shader}` cannot be read")));
            };
            // Blocks of one name that differ are others.
            let shape = owner_shape(&laid_out.shader, &declaration.owner);
            let is_declaring = number < declaring.len();
            if is_declaring || own_shapes.contains(&shape) {
                found.push(laid_out);
            }
            if is_declaring {
                own_shapes.push(shape);
            }
        }
        Ok(found)
    }

    /// Checks the shaders as they would be: the same layouts under the new name, and no new error.
    fn confirm(
        &self,
        setup: &CheckSetup,
        shaders: &[Arc<LaidOut>],
        declaration: &PlacedDeclaration,
        edits: &BTreeMap<String, Vec<Range<u32>>>,
        new: &str,
    ) -> Result<(), ResponseError> {
        let mut texts: Vec<(PathBuf, Arc<str>)> = Vec::new();
        for path in self.documents.paths().filter(|path| self.documents.is_live(path)) {
            let text = self.documents.get(path).map(|one| one.text.shared());
            texts.extend(text.map(|text| (path.clone(), text)));
        }
        for (file, spans) in edits {
            let path = self.absolute(file);
            let Some(text) = self.documents.text(&path) else { continue };
            let mut renamed = text.plain().to_string();
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
            let options = setup.options(&after).with_interface(true);
            let text = after.text(&path).map_or(&laid_out.source.text, |text| text).clone();
            let source = landfall_layout::Source { text, ..laid_out.source.clone() };
            let there = setup.basis.settings.layout(&source, &options);
            let is_alike = bytes(&laid_out.shader, Some((declaration, new))) == bytes(&there, None);
            if !is_alike || errors(&after) > errors(&before) {
                return Err(refused(format!(
                    "`{}` would not be read the same in `{}` under the new name",
                    declaration.name, laid_out.shader.path
                )));
            }
        }
        Ok(())
    }
}

/// The names of all members with their owners and bytes, one name replaced.
fn bytes(
    shader: &ShaderLayout,
    renamed: Option<(&PlacedDeclaration, &str)>,
) -> Vec<(String, String, Vec<PlacedBytes>)> {
    let all = declarations(shader).into_iter().map(|one| {
        let name = match renamed {
            Some((old, new)) if is_same(&one, old) => new.to_string(),
            _ => one.name,
        };
        (one.owner, name, one.uses.into_iter().map(|at| at.bytes).collect())
    });
    let mut all: Vec<(String, String, Vec<PlacedBytes>)> = all.collect();
    all.sort_by(|a, b| (&a.0, &a.1).cmp(&(&b.0, &b.1)));
    all
}

/// The members of a block or structure: names, types, and offsets under the rules of each use.
fn owner_shape(shader: &ShaderLayout, owner: &str) -> BTreeSet<(String, String, u64)> {
    let all = declarations(shader).into_iter().filter(|one| one.owner == owner);
    let each = all.flat_map(|one| {
        one.uses.into_iter().map(move |at| (one.name.clone(), at.ty, at.bytes.offset))
    });
    each.collect()
}

/// Whether two declarations are of one member: of one name, of blocks or structures of one name.
fn is_same(one: &PlacedDeclaration, other: &PlacedDeclaration) -> bool {
    one.kind == DeclarationKind::Member && one.name == other.name && one.owner == other.owner
}

/// Adds the places of a member's name in all files of a shader.
fn uses(
    laid_out: &LaidOut,
    declaration: &PlacedDeclaration,
    new: &str,
    edits: &mut BTreeMap<String, Vec<Range<u32>>>,
) -> Result<(), ResponseError> {
    let name = declaration.name.as_str();
    if laid_out.shader.has_errors() {
        let shader = &laid_out.shader.path;
        return Err(refused(format!("`{shader}` has errors, so that its uses are not known")));
    }
    for file in laid_out.shader.files.written() {
        let path = plain(&file.path);
        let resolver = OwnerResolver::new(laid_out, &file.text);
        let bodies = structure_bodies(&file.text);
        for word in resolver.words() {
            if word.text == new {
                return Err(refused(format!("`{path}` has the name `{new}` already")));
            }
            let is_named = word.text == name;
            if !is_named || !is_use(laid_out, declaration, file, &resolver, &bodies, word)? {
                continue;
            }
            let spans = edits.entry(path.clone()).or_default();
            if !spans.contains(&word.span) {
                spans.push(word.span.clone());
                spans.sort_by_key(|span| span.start);
            }
        }
    }
    Ok(())
}

/// Whether a word of the member's name is the member, in a file with these bodies of structures.
fn is_use(
    laid_out: &LaidOut,
    declaration: &PlacedDeclaration,
    file: &File,
    resolver: &OwnerResolver<'_>,
    bodies: &[Range<u32>],
    word: &TextWord<'_>,
) -> Result<bool, ResponseError> {
    let name = word.text;
    let path = plain(&file.path);
    let is_unknown = || {
        let line = file.text[..word.span.start as usize].matches('\n').count() + 1;
        refused(format!("it is not known what `{name}` means at {path}:{line}"))
    };
    // Of branches that are not taken, nothing is known.
    if word.is_in_directive || word.is_conditional {
        return Err(is_unknown());
    }
    let declared = laid_out.in_file(&path).find(|one| one.span == word.span);
    if let Some(declared) = declared {
        return Ok(is_same(declared, declaration));
    }
    let is_in_body =
        |word: &TextWord<'_>| bodies.iter().any(|body| body.contains(&word.span.start));
    if word.is_behind_dot {
        if let Some(owner) = resolver.owner(word) {
            return Ok(owner == declaration.owner);
        }
        let is_other = |one: &PlacedDeclaration| one.name == name && !is_same(one, declaration);
        let same = resolver.words().iter().filter(|one| one.text == name && !one.is_behind_dot);
        let is_ours = |one: &TextWord<'_>| {
            laid_out
                .in_file(&file.path)
                .any(|own| own.span == one.span && is_same(own, declaration))
        };
        let is_ambiguous = laid_out.declarations.iter().any(is_other)
            || same.into_iter().any(|one| is_in_body(one) && !is_ours(one))
            || is_swizzle(name);
        return if is_ambiguous { Err(is_unknown()) } else { Ok(true) };
    }
    // A parameter or variable, a member of a structure that no block has, or this member without a dot.
    let mut all = laid_out.declarations.iter();
    let is_global = all.any(|one| is_same(one, declaration) && one.is_global());
    Ok(is_global && !is_in_body(word) && !resolver.is_local(word))
}

/// Whether a name may be components of a vector.
fn is_swizzle(name: &str) -> bool {
    let sets = ["xyzw", "rgba", "stpq"];
    name.len() <= 4 && sets.iter().any(|set| name.chars().all(|c| set.contains(c)))
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
    // GLSL 4.60 §3.7 reserves these.
    let is_reserved = new.starts_with("gl_") || new.contains("__");
    match starts && letters.all(|c| c == '_' || c.is_ascii_alphanumeric()) {
        true if is_reserved => Err(refused(format!("`{new}` is a reserved name"))),
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
