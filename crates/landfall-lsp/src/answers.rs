//! Which code answers a message.

use std::path::PathBuf;
use std::sync::Arc;

use gen_lsp_types::{
    Contents, DidChangeTextDocumentParams, DidOpenTextDocumentParams, Hover, HoverParams,
    InlayHintParams, MarkupContent, MarkupKind, Range, TextDocumentPositionParams, Uri,
};
use lsp_server::{ErrorCode, Notification, Request, ResponseError};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::declarations::PlacedDeclaration;
use crate::hints;
use crate::hover::HoverContext;
use crate::laid_out::LaidOut;
use crate::positions::LineText;
use crate::projects::{is_configuration, is_shader};
use crate::server::{EditorServer, Phase, error};

/// Shaders that include an open file whose layouts are shown in it.
const MAX_SHADERS: usize = 8;

/// What a request is answered with; `None` if its answer comes later.
pub type RequestAnswer = Result<Option<Value>, ResponseError>;

impl EditorServer {
    pub fn answer(&mut self, request: Request) -> RequestAnswer {
        let Request { id, method, params } = request;
        match (self.phase, method.as_str()) {
            (Phase::Starting, "initialize") => return Ok(Some(self.initialize(&params))),
            (Phase::Starting, _) => {
                let message = "the server waits for `initialize`";
                return Err(error(ErrorCode::ServerNotInitialized, message));
            }
            (Phase::Running, "initialize") => {
                let message = "the server is initialized already";
                return Err(error(ErrorCode::InvalidRequest, message));
            }
            (Phase::Running, "shutdown") => {
                self.phase = Phase::ShutDown;
                return Ok(Some(Value::Null));
            }
            (Phase::ShutDown, _) => {
                return Err(error(ErrorCode::InvalidRequest, "the server has shut down"));
            }
            (Phase::Running, _) => {}
        }
        match method.as_str() {
            "textDocument/inlayHint" => done(self.inlay_hints(&read(params)?)),
            "textDocument/hover" => done(self.hover(&read(params)?)),
            "textDocument/definition" => done(self.definition(&read(params)?)),
            "textDocument/declaration" => done(self.declaration(&read(params)?)),
            "textDocument/implementation" => done(self.implementation(&read(params)?)),
            "textDocument/references" => done(self.references(&read(params)?)),
            "textDocument/prepareRename" => done(self.prepare_rename(&read(params)?)?),
            "textDocument/rename" => done(self.rename(&read(params)?)?),
            "textDocument/documentSymbol" => done(self.document_symbols(&read(params)?)),
            "workspace/symbol" => done(self.workspace_symbols(&read(params)?)),
            "textDocument/codeAction" => {
                self.check_edited();
                done(self.code_actions(&read(params)?))
            }
            "workspace/executeCommand" => self.execute(id, &read(params)?),
            _ => {
                let message = format!("landfall does not answer `{method}`");
                Err(error(ErrorCode::MethodNotFound, message))
            }
        }
    }

    /// Takes a notification.
    ///
    /// # Errors
    ///
    /// Its parameters are not those of the protocol.
    pub fn notified(&mut self, note: Notification) -> Result<(), String> {
        let Notification { method, params } = note;
        let read_uri =
            |params: &Value| params["textDocument"]["uri"].as_str().map(|s| Uri(s.into()));
        match method.as_str() {
            "initialized" => self.initialized(),
            "textDocument/didOpen" => {
                let params: DidOpenTextDocumentParams = parsed(&method, params)?;
                let item = params.text_document;
                if let Some(path) = self.documents.open(item.uri, item.version, item.text) {
                    self.find_project(&path);
                    // A pass that runs may have read what is saved.
                    let is_saved = self.documents.is_saved(&path);
                    self.touched(path, !is_saved);
                }
            }
            "textDocument/didChange" => {
                has_ranges(&params)?;
                let params: DidChangeTextDocumentParams = parsed(&method, params)?;
                let one = params.text_document;
                let uri = one.text_document_identifier.uri;
                if let Some(path) = self.documents.change(&uri, one.version, params.content_changes)
                {
                    self.touched(path, true);
                }
            }
            "textDocument/didSave" => {
                let uri = read_uri(&params).ok_or("didSave names no document")?;
                if let Some(path) = crate::uris::path(&uri) {
                    self.touched(path, true);
                }
            }
            "textDocument/didClose" => {
                let uri = read_uri(&params).ok_or("didClose names no document")?;
                if let Some(path) = self.documents.close(&uri) {
                    self.closed(path);
                }
            }
            "workspace/didChangeConfiguration" => match self.support.has_configuration {
                true => self.ask_settings(),
                false => self.change_settings(&params["settings"]),
            },
            "workspace/didChangeWorkspaceFolders" => self.change_folders(&params),
            "workspace/didChangeWatchedFiles" => self.files_changed(&params),
            "window/workDoneProgress/cancel" => self.cancel_progress(&params["token"]),
            // Of other servers, or of no consequence: `$/setTrace`.
            _ => {}
        }
        Ok(())
    }

    /// Notes that a document has changed.
    fn touched(&mut self, path: PathBuf, is_new_text: bool) {
        if is_configuration(&path) {
            self.reload_projects();
            return;
        }
        if let Some(&index) = self.project_of.get(&path) {
            if is_new_text {
                self.postpone_pass(index);
            }
            self.edited.insert(path);
        } else if path.extension().is_some_and(|end| end == "rs") {
            // Mirrors are compared by the next pass.
            (0..self.projects.len()).for_each(|index| self.postpone_pass(index));
        }
    }

    /// Notes that a file counts again as it is on disk.
    fn closed(&mut self, path: PathBuf) {
        self.edited.remove(&path);
        if is_configuration(&path) {
            self.reload_projects();
            return;
        }
        let Some((index, setup, shown)) = self.setup_of(&path) else { return };
        self.project_of.remove(&path);
        let gone = self.projects[index].since.remove(&shown);
        if setup.paths.is_empty() {
            // No folder holds it: nothing more is told of it.
            let places = gone.iter().flat_map(|found| &found.findings);
            let places: Vec<String> = places.map(|one| one.place().path.clone()).collect();
            let files = places.iter().map(|place| self.absolute(place)).collect();
            self.publish(&files);
        } else {
            self.postpone_pass(index);
        }
    }

    fn files_changed(&mut self, params: &Value) {
        let changes = params["changes"].as_array().into_iter().flatten();
        let uris = changes.filter_map(|change| change["uri"].as_str());
        let paths: Vec<PathBuf> =
            uris.filter_map(|uri| crate::uris::path(&Uri(uri.to_string()))).collect();
        if paths.iter().any(|path| is_configuration(path)) {
            self.reload_projects();
            return;
        }
        // What is open counts as it is edited.
        if paths.iter().any(|path| self.documents.get(path).is_none()) {
            let open: Vec<PathBuf> = self.project_of.keys().cloned().collect();
            self.edited.extend(open);
            self.documents.generation += 1;
            (0..self.projects.len()).for_each(|index| self.postpone_pass(index));
        }
    }

    /// The layout of a shader by the path that findings have.
    pub fn laid_out(&mut self, index: usize, shown: &str) -> Option<Arc<LaidOut>> {
        let setup = self.projects[index].setup.clone()?;
        let (documents, current) = (&self.documents, &self.current);
        let open = || Arc::new(documents.texts(current));
        self.layouts.get(documents.generation, &setup, shown, open)
    }

    /// The layouts that show in an open document: its own, and those of shaders that include it.
    pub fn layouts_in(&mut self, uri: &Uri) -> Option<DocumentLayouts> {
        let path = crate::uris::path(uri)?;
        if !is_shader(&path) || !self.documents.is_live(&path) {
            return None;
        }
        let (index, _, shown) = self.setup_of(&path)?;
        let including = self.projects[index].shaders_with(&shown);
        let mut shaders = vec![shown.clone()];
        shaders.extend(including.into_iter().take(MAX_SHADERS).map(str::to_string));
        let layouts = shaders.iter().filter_map(|shader| self.laid_out(index, shader)).collect();
        let text = self.documents.get(&path)?.text.clone();
        Some(DocumentLayouts { index, shown, text, layouts })
    }

    fn inlay_hints(&mut self, params: &InlayHintParams) -> Option<Vec<gen_lsp_types::InlayHint>> {
        let document = self.layouts_in(&params.text_document.uri)?;
        let text = &document.text;
        let (start, end) = (text.offset(params.range.start), text.offset(params.range.end));
        let declarations = document.declarations();
        let declarations: Vec<&PlacedDeclaration> = declarations.iter().collect();
        Some(hints::hints(
            &declarations,
            text,
            start..end.max(start + 1),
            self.settings.inlay_hints,
        ))
    }

    fn hover(&mut self, params: &HoverParams) -> Option<Hover> {
        let TextDocumentPositionParams { text_document, position } =
            &params.text_document_position_params;
        let document = self.layouts_in(&text_document.uri)?;
        let offset = document.text.offset(*position);
        let setup = self.projects[document.index].setup.clone()?;
        let options = setup.options(&self.open_files());
        for laid_out in &document.layouts {
            let locked = setup.locked(&laid_out.shader.path);
            let context = HoverContext {
                laid_out,
                options: &setup.basis.settings.own_options(&laid_out.source, &options),
                mirrors: &self.projects[document.index].found.mirrors,
                locked: locked.as_ref(),
                program_fields: &|declaration| self.program_fields(&setup, declaration),
                shown: &|path| setup.shown(path),
                link: &|path, line| self.link(path, line),
            };
            let found = match laid_out.name_at(&document.shown, &document.text, offset) {
                Some(name) => Some((
                    context.of_name(&name.declarations),
                    Some(document.text.range(name.span)),
                )),
                None => {
                    let include = laid_out.include_at(&document.shown, offset);
                    let import = || laid_out.import_at(&document.text, offset);
                    let file = include.or_else(|| Some(import()?.display().to_string()));
                    file.map(|file| (context.of_include(&file), None))
                }
            };
            if let Some((value, range)) = found {
                let contents = Contents::from(MarkupContent { kind: MarkupKind::Markdown, value });
                return Some(Hover { contents, range });
            }
        }
        self.function_hover(&document, offset)
    }
}

/// An open document, with the layouts of the shaders that it is a file of.
pub struct DocumentLayouts {
    /// Of its project.
    pub index: usize,
    /// Its path as findings have it.
    pub shown: String,
    pub text: Arc<LineText>,
    pub layouts: Vec<Arc<LaidOut>>,
}

impl DocumentLayouts {
    /// The declarations in the document, each with the uses of all shaders.
    pub fn declarations(&self) -> Vec<PlacedDeclaration> {
        let mut found: Vec<PlacedDeclaration> = Vec::new();
        for laid_out in &self.layouts {
            for one in laid_out.in_file(&self.shown) {
                match found.iter_mut().find(|known| known.span == one.span) {
                    Some(known) => known.uses.extend(one.uses.iter().cloned()),
                    None => found.push(one.clone()),
                }
            }
        }
        found
    }
}

/// Checks that each change of a part says which: what cannot be read is not one of the whole text.
fn has_ranges(params: &Value) -> Result<(), String> {
    let changes = params["contentChanges"].as_array().into_iter().flatten();
    for range in changes.filter_map(|change| change.get("range")) {
        Range::deserialize(range).map_err(|cause| format!("a change has no range: {cause}"))?;
    }
    Ok(())
}

fn done<T: serde::Serialize>(value: T) -> RequestAnswer {
    let value = serde_json::to_value(value);
    value.map(Some).map_err(|cause| error(ErrorCode::InternalError, cause.to_string()))
}

fn read<T: DeserializeOwned>(params: Value) -> Result<T, ResponseError> {
    serde_json::from_value(params)
        .map_err(|cause| error(ErrorCode::InvalidParams, format!("wrong parameters: {cause}")))
}

fn parsed<T: DeserializeOwned>(method: &str, params: Value) -> Result<T, String> {
    serde_json::from_value(params).map_err(|cause| format!("{method}: wrong parameters: {cause}"))
}
