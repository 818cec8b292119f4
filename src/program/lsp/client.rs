//! What the editor says of itself when it starts the server.

use std::path::PathBuf;

use lsp_server::{Message, Request};
use lsp_types::notification::{DidChangeWatchedFiles, Notification as _};
use lsp_types::request::{RegisterCapability, Request as _};
use lsp_types::{
    DidChangeWatchedFilesRegistrationOptions, FileSystemWatcher, GlobPattern, InitializeParams, Registration,
    RegistrationParams,
};

use super::documents::path;

/// Files on disk that change what is said about a scenario: imports, maps, networks.
const WATCHED: &str = "**/*.{scn,xodr,onnx,safetensors}";

/// What the editor can, and where it works.
#[derive(Debug, Clone, Default)]
pub struct Client {
    /// The folders that it has open.
    pub folders: Vec<PathBuf>,
    /// Whether it asks before a new name is typed.
    pub prepares_names: bool,
    /// Whether it can be asked to report changes of files on disk.
    pub watches: bool,
}

impl Client {
    /// Reads the parameters of `initialize`; what is missing or has another form counts as absent.
    pub fn read(params: &serde_json::Value) -> Self {
        let Ok(params) = serde_json::from_value::<InitializeParams>(params.clone()) else { return Self::default() };
        #[expect(deprecated, reason = "editors that know no workspace folders name their root")]
        let root = params.root_uri;
        let named = params.workspace_folders.unwrap_or_default().into_iter().map(|folder| folder.uri);
        let mut folders: Vec<PathBuf> = named.map(|uri| path(&uri)).collect();
        if folders.is_empty() {
            folders.extend(root.map(|uri| path(&uri)));
        }
        folders.retain(|folder| folder.is_absolute());
        let names = params.capabilities.text_document.and_then(|of| of.rename).and_then(|of| of.prepare_support);
        let watches = params.capabilities.workspace.and_then(|of| of.did_change_watched_files);
        Self {
            folders,
            prepares_names: names.unwrap_or(false),
            watches: watches.and_then(|of| of.dynamic_registration).unwrap_or(false),
        }
    }

    /// The request to report changes of files on disk; `None` for an editor that cannot.
    pub fn watch(&self) -> Option<Message> {
        let watchers = vec![FileSystemWatcher { glob_pattern: GlobPattern::String(WATCHED.into()), kind: None }];
        let options = DidChangeWatchedFilesRegistrationOptions { watchers };
        let registration = Registration {
            id: "files".into(),
            method: DidChangeWatchedFiles::METHOD.into(),
            register_options: serde_json::to_value(options).ok(),
        };
        let params = RegistrationParams { registrations: vec![registration] };
        let id = String::from("falsify-files").into();
        self.watches.then(|| Request::new(id, RegisterCapability::METHOD.into(), params).into())
    }
}
