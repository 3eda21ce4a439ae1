//! The start and end of the server's life, and the settings of its user.

use std::path::PathBuf;
use std::time::Instant;

use gen_lsp_types::Uri;
use lsp_server::Response;
use serde_json::{Value, json};

use crate::client::{ClientSupport, MessageLevel};
use crate::commands::COMMANDS;
use crate::server::{EditorServer, Phase};
use crate::settings::EditorSettings;
use crate::uris;

/// What a client is to watch: shaders and their imports, Rust mirrors, configurations and locks.
const WATCHED: &str = "**/*.{wgsl,wesl,glsl,vert,frag,comp,geom,tesc,tese,mesh,task,rgen,rint,rahit,\
                       rchit,rmiss,rcall,vs,fs,vsh,fsh,glslinc,glslh,rs,json,toml}";

impl EditorServer {
    /// Takes what the client can do, and tells what the server can.
    pub fn initialize(&mut self, params: &Value) -> Value {
        self.support = ClientSupport::from_capabilities(&params["capabilities"]);
        self.documents.encoding = self.support.encoding;
        let options = &params["initializationOptions"];
        self.take_settings(options);
        let folders = params["workspaceFolders"].as_array().into_iter().flatten();
        let mut folders: Vec<PathBuf> = folders.filter_map(folder).collect();
        if folders.is_empty() {
            let root = params["rootUri"].as_str();
            folders.extend(root.and_then(|uri| uris::path(&Uri(uri.to_string()))));
        }
        // Findings name files from the first folder, as those of a command that is run there.
        if let Some(first) = folders.first() {
            if std::env::set_current_dir(first).is_ok() {
                self.current.clone_from(first);
            }
        }
        self.folders = folders;
        self.phase = Phase::Running;
        json!({
            "serverInfo": { "name": "landfall", "version": env!("CARGO_PKG_VERSION") },
            "capabilities": {
                "positionEncoding": self.support.encoding.kind(),
                "textDocumentSync": { "openClose": true, "change": 2, "save": {} },
                "inlayHintProvider": true,
                "hoverProvider": true,
                "definitionProvider": true,
                "declarationProvider": true,
                "implementationProvider": true,
                "referencesProvider": true,
                "renameProvider": { "prepareProvider": true },
                "documentSymbolProvider": true,
                "workspaceSymbolProvider": true,
                "codeActionProvider": {
                    "codeActionKinds": ["quickfix", "source.fixAll", "refactor"],
                },
                "executeCommandProvider": { "commands": COMMANDS },
                "workspace": {
                    "workspaceFolders": { "supported": true, "changeNotifications": true },
                },
            },
        })
    }

    /// Begins the work that needs no document.
    pub fn initialized(&mut self) {
        let files = json!({
            "id": "files",
            "method": "workspace/didChangeWatchedFiles",
            "registerOptions": { "watchers": [{ "globPattern": WATCHED }] },
        });
        let settings = json!({
            "id": "settings",
            "method": "workspace/didChangeConfiguration",
            "registerOptions": { "section": "landfall" },
        });
        let support = &self.support;
        for (is_supported, registration) in
            [(support.watches_files, files), (support.registers_configuration, settings)]
        {
            if is_supported {
                let all = json!({ "registrations": [registration] });
                self.client.request("client/registerCapability", all);
            }
        }
        self.ask_settings();
        self.open_folders();
        self.due = Some(Instant::now());
    }

    pub fn ask_settings(&mut self) {
        if self.support.has_configuration {
            let items = json!({ "items": [{ "section": "landfall" }] });
            self.asked_settings = Some(self.client.request("workspace/configuration", items));
        }
    }

    /// Takes the client's answer.
    pub fn response(&mut self, response: Response) {
        if self.asked_settings.as_ref() == Some(&response.id) {
            self.asked_settings = None;
            if let Ok(value) = response.response_result {
                self.change_settings(value.get(0).unwrap_or(&Value::Null));
            }
        }
    }

    /// Takes new settings, and checks again if they change findings.
    pub fn change_settings(&mut self, value: &Value) {
        let old = self.settings.clone();
        self.take_settings(value);
        let is_of_check =
            |one: &EditorSettings| (one.targets.clone(), one.defines.clone(), one.features.clone());
        if is_of_check(&old) != is_of_check(&self.settings) {
            self.reload_projects();
        } else if old.rule_pages != self.settings.rule_pages {
            self.publish_all();
        }
        if old.inlay_hints != self.settings.inlay_hints && self.support.refreshes_hints {
            self.client.request("workspace/inlayHint/refresh", Value::Null);
        }
    }

    fn take_settings(&mut self, value: &Value) {
        let read =
            EditorSettings::read(value).and_then(|settings| settings.flags().map(|_| settings));
        match read {
            Ok(settings) => self.settings = settings,
            Err(cause) => self.client.show(MessageLevel::Error, &cause),
        }
    }

    pub fn change_folders(&mut self, params: &Value) {
        let gone: Vec<PathBuf> = params["event"]["removed"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(folder)
            .collect();
        self.folders.retain(|one| !gone.contains(one));
        let new = params["event"]["added"].as_array().into_iter().flatten().filter_map(folder);
        self.folders.extend(new);
        self.reload_projects();
    }
}

fn folder(value: &Value) -> Option<PathBuf> {
    uris::path(&Uri(value["uri"].as_str()?.to_string()))
}
