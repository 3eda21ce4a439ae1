//! Code actions: the fixes of findings, comments that allow them, and commands about a block.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gen_lsp_types::{
    CodeAction, CodeActionKind, CodeActionParams, Command, DocumentChange, Edit as LspEdit,
    OptionalVersionedTextDocumentIdentifier, TextDocumentEdit, TextDocumentIdentifier, TextEdit,
    Uri, WorkspaceEdit,
};
use landfall_layout::finding::{Edit, Finding};
use landfall_layout::source::kind_of_path;
use landfall_lint::fix::apply;
use landfall_lint::{add_allow, lint};
use serde_json::json;

use crate::answers::DocumentLayouts;
use crate::declarations::{DeclarationKind, PlacedDeclaration};
use crate::insert_padding::padding_members;
use crate::positions::LineText;
use crate::server::EditorServer;
use crate::words::function_at;

impl EditorServer {
    pub fn code_actions(&mut self, params: &CodeActionParams) -> Vec<CodeAction> {
        let uri = &params.text_document.uri;
        let Some(path) = crate::uris::path(uri) else { return Vec::new() };
        let Some(text) = self.documents.text(&path) else { return Vec::new() };
        let only = params.context.only.as_deref();
        let (start, end) = (text.offset(params.range.start), text.offset(params.range.end));
        let mut actions = Vec::new();
        if is_wanted(only, &CodeActionKind::QuickFix) {
            for finding in self.findings_in(&path) {
                let place = finding.place();
                if place.start <= end && start <= place.end.max(place.start) {
                    actions.extend(self.actions_of(&finding, &path, uri));
                }
            }
        }
        // Asked for by name, as on saving.
        if only.is_some() && is_wanted(only, &CodeActionKind::SourceFixAll) {
            actions.extend(self.fix_all(&path));
        }
        if is_wanted(only, &CodeActionKind::Refactor) {
            actions.extend(self.block_actions(params));
            actions.extend(function_actions(uri, &text, start));
        }
        actions
    }

    /// The findings in a file, each once.
    pub fn findings_in(&self, path: &Path) -> Vec<Finding> {
        let all = self.projects.iter().flat_map(|project| project.findings());
        let mut found: Vec<Finding> = Vec::new();
        for one in all.filter(|one| self.absolute(&one.place().path) == path) {
            if !found.contains(one) {
                found.push(one.clone());
            }
        }
        found
    }

    fn actions_of(&self, finding: &Finding, path: &Path, uri: &Uri) -> Vec<CodeAction> {
        let mut actions = Vec::new();
        let code = &finding.code;
        if !finding.fix.is_empty() {
            let title = finding.help.as_deref().unwrap_or(&finding.message);
            let edit = self.edit_of(&finding.fix);
            actions.push(CodeAction { is_preferred: Some(true), ..edited(title, edit) });
        }
        if code == "layout-drift" || code == "lock-missing" {
            let title = match code.as_str() {
                "lock-missing" => "Lock this layout",
                _ => "Accept the new layout: write the lock",
            };
            actions.push(with_command(title, "landfall.acceptLayout", vec![json!(uri)]));
        }
        if code == "stale-assertions" {
            actions.extend(self.rewrite_action(finding));
        }
        if lint(code).is_some() {
            actions.extend(self.allow_actions(finding, path));
        }
        let title = format!("What `{code}` means");
        actions.push(with_command(&title, "landfall.rule", vec![json!(code)]));
        actions
    }

    /// Comments that allow a finding, in its line and in its file.
    fn allow_actions(&self, finding: &Finding, path: &Path) -> Vec<CodeAction> {
        let Some((language, _)) = kind_of_path(path) else { return Vec::new() };
        let Some(text) = self.documents.text(path) else { return Vec::new() };
        let plain = text.plain();
        let code = finding.code.as_str();
        let (place, codes) = (finding.place(), BTreeSet::from([code]));
        let lines = BTreeMap::from([(place.line, codes.clone())]);
        let above = add_allow::above_lines(&place.path, plain, language, &lines);
        let in_file = add_allow::in_file(&place.path, plain, &codes);
        let mut actions = Vec::new();
        if !above.is_empty() {
            actions.push(edited(&format!("Allow `{code}` in this line"), self.edit_of(&above)));
        }
        actions.push(edited(&format!("Allow `{code}` in this file"), self.edit_of(&[in_file])));
        actions
    }

    /// All fixes in a file that do not touch one another.
    fn fix_all(&self, path: &Path) -> Option<CodeAction> {
        let findings = self.findings_in(path);
        let in_file =
            |one: &&Finding| one.fix.iter().all(|edit| self.absolute(&edit.at.path) == path);
        let fixable: Vec<Finding> =
            findings.iter().filter(|one| !one.fix.is_empty()).filter(in_file).cloned().collect();
        let text = self.documents.text(path)?;
        let plain: Arc<str> = text.plain().into();
        let fixed = apply(&fixable, &|_| Some(Arc::clone(&plain)));
        let new = &fixed.first()?.new;
        let whole = TextEdit { range: text.range(0..plain.len() as u32), new_text: new.clone() };
        let edit = self.workspace_edit(vec![(path.to_path_buf(), vec![whole])]);
        let action = edited("Fix all findings of landfall that have a fix", edit);
        Some(CodeAction { kind: Some(CodeActionKind::SourceFixAll), ..action })
    }

    /// Commands about the block or structure whose name is selected.
    fn block_actions(&mut self, params: &CodeActionParams) -> Vec<CodeAction> {
        let uri = &params.text_document.uri;
        let Some(document) = self.layouts_in(uri) else { return Vec::new() };
        let offset = document.text.offset(params.range.start);
        let declarations = document.declarations();
        let is_here = |span: &std::ops::Range<u32>| (span.start..=span.end).contains(&offset);
        let Some(one) = declarations.iter().find(|one| is_here(&one.span)) else {
            return Vec::new();
        };
        if one.kind == DeclarationKind::Member {
            return self.padding_action(one, &document).into_iter().collect();
        }
        let writes = self.write_actions(one, &document);
        if one.kind != DeclarationKind::Block {
            return writes;
        }
        let name = &one.name;
        let of_block = |title: &str, command: &str, more: Option<&str>| {
            let arguments =
                [json!(uri), json!(name)].into_iter().chain(more.map(|more| json!(more)));
            refactor(with_command(title, command, arguments.collect()))
        };
        let commands = [
            of_block("Show its memory map", "landfall.memoryMap", None),
            of_block("Show the mirrors of this shader in Rust", "landfall.emit", Some("rust")),
            of_block("Show the mirrors of this shader in C", "landfall.emit", Some("c")),
            of_block("Show its format for RenderDoc", "landfall.emit", Some("renderdoc")),
            of_block(
                "Run the shader: is each byte read where it is written?",
                "landfall.verify",
                None,
            ),
        ];
        commands.into_iter().chain(writes).collect()
    }

    /// Declares the padding behind a member.
    fn padding_action(
        &self,
        member: &PlacedDeclaration,
        document: &DocumentLayouts,
    ) -> Option<CodeAction> {
        let plain = document.text.plain();
        let language = document.layouts.first()?.shader.language;
        let (at, new_text) = padding_members(member, plain, language)?;
        let path = self.absolute(&document.shown);
        let edit = TextEdit { range: document.text.range(at), new_text };
        let bytes = member.uses.first()?.bytes.after;
        let title = format!("Declare the {bytes} bytes of padding behind `{}`", member.name);
        Some(refactor(edited(&title, self.workspace_edit(vec![(path, vec![edit])]))))
    }

    /// The edits of a finding for the client.
    fn edit_of(&self, edits: &[Edit]) -> WorkspaceEdit {
        let mut files: BTreeMap<PathBuf, Vec<TextEdit>> = BTreeMap::new();
        for edit in edits {
            let path = self.absolute(&edit.at.path);
            let Some(text) = self.documents.text(&path) else { continue };
            let range = text.range(edit.at.start..edit.at.end);
            files.entry(path).or_default().push(TextEdit { range, new_text: edit.new.clone() });
        }
        self.workspace_edit(files.into_iter().collect())
    }

    /// Edits by file; with the versions of open documents, if the client takes them.
    pub fn workspace_edit(&self, files: Vec<(PathBuf, Vec<TextEdit>)>) -> WorkspaceEdit {
        if !self.support.document_changes {
            let changes = files.into_iter().map(|(path, edits)| (self.documents.uri(&path), edits));
            let changes: HashMap<Uri, Vec<TextEdit>> = changes.collect();
            return WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() };
        }
        let changes = files.into_iter().map(|(path, edits)| self.document_edit(&path, edits));
        WorkspaceEdit { document_changes: Some(changes.collect()), ..WorkspaceEdit::default() }
    }

    pub fn document_edit(&self, path: &Path, edits: Vec<TextEdit>) -> DocumentChange {
        let version = self.documents.get(path).map(|document| document.version);
        let uri = self.documents.uri(path);
        DocumentChange::TextDocumentEdit(TextDocumentEdit {
            text_document: OptionalVersionedTextDocumentIdentifier {
                version,
                text_document_identifier: TextDocumentIdentifier { uri },
            },
            edits: edits.into_iter().map(LspEdit::TextEdit).collect(),
        })
    }
}

/// Commands about the function whose name is selected.
fn function_actions(uri: &Uri, text: &LineText, offset: u32) -> Vec<CodeAction> {
    let plain = text.plain();
    let Some((name, _)) = function_at(plain, offset) else { return Vec::new() };
    let stress = format!("Search for inputs at which `{name}` is inaccurate");
    let lights = "Show what the lights of this shader cost, and the hazards of its functions";
    vec![
        refactor(with_command(&stress, "landfall.stress", vec![json!(uri), json!(name)])),
        refactor(with_command(lights, "landfall.lights", vec![json!(uri)])),
    ]
}

/// Whether actions of a kind are asked for: by its name, or by one of those above it.
fn is_wanted(only: Option<&[CodeActionKind]>, kind: &CodeActionKind) -> bool {
    let name = kind.to_string();
    only.is_none_or(|kinds| {
        kinds.iter().map(CodeActionKind::to_string).any(|above| {
            let rest = name.strip_prefix(&above);
            above.is_empty() || rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        })
    })
}

pub fn refactor(action: CodeAction) -> CodeAction {
    CodeAction { kind: Some(CodeActionKind::Refactor), ..action }
}

pub fn edited(title: &str, edit: WorkspaceEdit) -> CodeAction {
    CodeAction { edit: Some(edit), ..action(title) }
}

fn with_command(title: &str, command: &str, arguments: Vec<serde_json::Value>) -> CodeAction {
    let command = Command {
        title: title.to_string(),
        tooltip: None,
        command: command.to_string(),
        arguments: Some(arguments),
    };
    CodeAction { command: Some(command), ..action(title) }
}

fn action(title: &str) -> CodeAction {
    CodeAction {
        title: title.to_string(),
        kind: Some(CodeActionKind::QuickFix),
        ..CodeAction::default()
    }
}
