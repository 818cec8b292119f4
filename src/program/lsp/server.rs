use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, Write};
use std::path::{Path, PathBuf};

use lsp_server::{ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidChangeWatchedFiles, DidCloseTextDocument, DidOpenTextDocument, Initialized,
    Notification as _, PublishDiagnostics,
};
use lsp_types::request::{
    CodeActionRequest, Completion, DocumentSymbolRequest, Formatting, GotoDefinition, HoverRequest, Initialize,
    PrepareRenameRequest, References, Rename, Request as _, Shutdown,
};
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionOrCommand, CodeActionParams, CodeActionProviderCapability, CompletionOptions,
    CompletionParams, DidChangeTextDocumentParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams,
    DocumentFormattingParams, DocumentSymbolParams, DocumentSymbolResponse, GotoDefinitionParams, HoverParams,
    HoverProviderCapability, InitializeResult, Location, OneOf, Position, PrepareRenameResponse,
    PublishDiagnosticsParams, Range, ReferenceParams, RenameOptions, RenameParams, ServerCapabilities, ServerInfo,
    TextDocumentIdentifier, TextDocumentPositionParams, TextDocumentSyncCapability, TextDocumentSyncKind, TextEdit,
    Uri, WorkDoneProgressOptions, WorkspaceEdit,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::client::Client;
use super::cursor::{Place, cursor};
use super::documents::{Documents, path, position, range};
use super::references::{self, Places};
use super::visible::Visible;
use super::wire::{self, WireError};
use super::{complete, hover, navigate};
use base::contained::contained;
use base::diagnostic::{Diagnostic, Lines, Severity, Sources};
use compile::{Catalog, compile};
use lang::Loaded;

/// Maximum number of diagnostics of a file; an editor shows no more.
const MAX_SHOWN: usize = 500;

/// How a session ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The editor shut it down in order.
    Orderly,
    /// The editor closed the stream without a shutdown.
    Abrupt,
}

/// Serves one editor until it shuts the session down or its stream ends. A message that cannot be understood is answered with
/// an error and has no other effect.
///
/// The server looks up programs that scenarios name, if the catalogue has an opener, and never starts them. `shelf` is a folder to which the standard library is
/// written when the user opens one of its files.
///
/// # Errors
/// The stream failed, or its messages have lost their boundaries.
pub fn serve(
    catalog: Catalog,
    mut input: impl BufRead,
    output: impl Write,
    shelf: PathBuf,
) -> Result<Ending, WireError> {
    let mut server =
        Server { catalog, client: Client::default(), documents: Documents::new(shelf), shown: BTreeSet::new(), output };
    let mut stopping = false;
    loop {
        match wire::read(&mut input) {
            Ok(None) => return Ok(Ending::Abrupt),
            Ok(Some(Message::Request(request))) => {
                stopping |= request.method == Shutdown::METHOD;
                server.request(request)?;
            }
            Ok(Some(Message::Notification(note))) if note.method == "exit" => {
                return Ok(if stopping { Ending::Orderly } else { Ending::Abrupt });
            }
            Ok(Some(Message::Notification(note))) => server.notification(note)?,
            Ok(Some(Message::Response(_))) => {}
            Err(WireError::Body(reason)) => server.answer_without_id(&reason)?,
            Err(error) => return Err(error),
        }
    }
}

struct Server<W> {
    catalog: Catalog,
    client: Client,
    documents: Documents,
    /// Files that the editor shows diagnostics for.
    shown: BTreeSet<Uri>,
    output: W,
}

/// Why a request was refused.
struct Refusal(ErrorCode, String);

#[expect(
    clippy::mutable_key_type,
    reason = "only the parsed form of a name is filled in later; its order is its text's"
)]
impl<W: Write> Server<W> {
    fn send(&mut self, message: Message) -> Result<(), WireError> {
        message.write(&mut self.output)?;
        Ok(self.output.flush()?)
    }

    /// The protocol's answer to bytes that are not a message: an error without a number.
    fn answer_without_id(&mut self, reason: &str) -> Result<(), WireError> {
        let error = serde_json::json!({ "code": ErrorCode::ParseError as i32, "message": reason });
        let body = serde_json::json!({ "jsonrpc": "2.0", "id": null, "error": error }).to_string();
        write!(self.output, "Content-Length: {}\r\n\r\n{body}", body.len())?;
        Ok(self.output.flush()?)
    }

    fn request(&mut self, request: Request) -> Result<(), WireError> {
        let id = request.id.clone();
        if request.method == Initialize::METHOD {
            self.client = Client::read(&request.params);
            let editor = request.params["processId"].as_i64().and_then(|id| id.try_into().ok());
            editor.into_iter().for_each(process::end_with);
        }
        // A bug answers one request with an error and does not end the server.
        let answer = contained(|| self.answer(request));
        let answer = answer.unwrap_or_else(|_| Err(Refusal(ErrorCode::InternalError, "a bug in falsify".into())));
        let response = match answer {
            Ok(result) => Response::new_ok(id, result),
            Err(Refusal(code, message)) => Response::new_err(id, code as i32, message),
        };
        self.send(response.into())
    }

    fn answer(&self, request: Request) -> Result<serde_json::Value, Refusal> {
        let Request { method, params, .. } = request;
        match method.as_str() {
            Initialize::METHOD => json(&capabilities(&self.client)),
            Shutdown::METHOD => Ok(serde_json::Value::Null),
            HoverRequest::METHOD => {
                let params: HoverParams = read(params)?;
                let at = params.text_document_position_params;
                json(&self.at(&at, |text, byte, loaded, sources| {
                    let here = cursor(text, byte, &self.catalog);
                    hover::hover(&here, byte, &self.catalog, Visible { loaded, sources })
                }))
            }
            Completion::METHOD => {
                let params: CompletionParams = read(params)?;
                let at = params.text_document_position;
                let file = path(&at.text_document.uri);
                json(&self.at(&at, |text, byte, loaded, sources| {
                    let here = cursor(text, byte, &self.catalog);
                    if let Place::Imported(import) = here.place {
                        let (loaded, sources) = self.imported(&at.text_document.uri, import)?;
                        let visible = Visible { loaded: &loaded, sources: &sources };
                        return Some(complete::complete(&here, &self.catalog, visible, &file));
                    }
                    let mut items = complete::complete(&here, &self.catalog, Visible { loaded, sources }, &file);
                    if let Place::Import(typed) = here.place {
                        // A path is no word for editors, so each item says what it replaces.
                        let lines = Lines::new(text);
                        let range = Range { start: position(&lines, byte - typed.len()), end: position(&lines, byte) };
                        items.iter_mut().for_each(|item| {
                            let edit = TextEdit { range, new_text: item.label.clone() };
                            item.text_edit = Some(edit.into());
                        });
                    }
                    Some(items)
                }))
            }
            GotoDefinition::METHOD => {
                let params: GotoDefinitionParams = read(params)?;
                let at = params.text_document_position_params;
                let found: Option<Location> = self.at(&at, |text, byte, loaded, sources| {
                    let here = cursor(text, byte, &self.catalog);
                    navigate::definition(&here, byte, loaded, sources, &self.documents)
                });
                json(&found)
            }
            References::METHOD => {
                let params: ReferenceParams = read(params)?;
                let found = self.places_of(&params.text_document_position);
                json(&found.map(|found| self.locations(&found, params.context.include_declaration)))
            }
            Rename::METHOD => {
                let RenameParams { text_document_position, new_name, .. } = read(params)?;
                json(&self.rename(&text_document_position, &new_name)?)
            }
            PrepareRenameRequest::METHOD => {
                let at: TextDocumentPositionParams = read(params)?;
                json(&self.prepare_rename(&at)?)
            }
            DocumentSymbolRequest::METHOD => {
                let params: DocumentSymbolParams = read(params)?;
                json(&self.at(&start_of(params.text_document), |text, _, loaded, _| {
                    let root = loaded.files.iter().find(|file| loaded.roots.contains(&file.source))?;
                    Some(DocumentSymbolResponse::Nested(navigate::symbols(root, text)))
                }))
            }
            CodeActionRequest::METHOD => {
                let params: CodeActionParams = read(params)?;
                json(&self.repairs(&params.text_document.uri, params.range))
            }
            Formatting::METHOD => {
                let params: DocumentFormattingParams = read(params)?;
                json(&self.layout(&params.text_document.uri))
            }
            _ => Err(Refusal(ErrorCode::MethodNotFound, format!("`{method}` is not served"))),
        }
    }

    fn notification(&mut self, note: Notification) -> Result<(), WireError> {
        let Notification { method, params } = note;
        match method.as_str() {
            DidOpenTextDocument::METHOD => {
                let Ok(params) = serde_json::from_value::<DidOpenTextDocumentParams>(params) else { return Ok(()) };
                self.documents.set(params.text_document.uri, params.text_document.text);
            }
            DidChangeTextDocument::METHOD => {
                let Ok(params) = serde_json::from_value::<DidChangeTextDocumentParams>(params) else { return Ok(()) };
                // The server asked for whole texts.
                let Some(change) = params.content_changes.into_iter().next_back() else { return Ok(()) };
                self.documents.set(params.text_document.uri, change.text);
            }
            DidCloseTextDocument::METHOD => {
                let Ok(params) = serde_json::from_value::<DidCloseTextDocumentParams>(params) else { return Ok(()) };
                self.documents.close(&params.text_document.uri);
            }
            // An import, a map or a network may have changed, so all open files are checked again.
            DidChangeWatchedFiles::METHOD => {}
            Initialized::METHOD => return self.client.watch().map_or(Ok(()), |request| self.send(request)),
            _ => return Ok(()),
        }
        self.publish()
    }

    /// Loads a document with its imports and answers a query about a place in it; `None` if the document is not open.
    fn at<T>(
        &self,
        at: &TextDocumentPositionParams,
        ask: impl Fn(&str, usize, &Loaded, &Sources) -> Option<T>,
    ) -> Option<T> {
        let text = self.documents.text(&at.text_document.uri)?;
        let byte = Lines::new(text).byte(at.position.line, at.position.character);
        let root = path(&at.text_document.uri);
        let mut sources = Sources::default();
        let mut loaded = lang::load(std::slice::from_ref(&root), &self.documents, &mut sources).ok()?;
        let is_root = |file: &&lang::ast::File| loaded.roots.contains(&file.source);
        if loaded.files.iter().find(is_root).is_some_and(|file| file.edition.is_none()) {
            // A bracket that is still open hides the whole file; the text before its statement is used instead.
            let above = above(text, byte);
            let read = |path: &Path| if path == root { Ok(above.to_string()) } else { self.documents.read(path) };
            sources = Sources::default();
            loaded = lang::load(std::slice::from_ref(&root), &read, &mut sources).ok()?;
        }
        ask(text, byte, &loaded, &sources)
    }

    /// All places of the name at a place.
    fn places_of(&self, at: &TextDocumentPositionParams) -> Option<Places> {
        self.at(at, |text, byte, loaded, sources| {
            let here = cursor(text, byte, &self.catalog);
            let folders = &self.client.folders;
            references::places_of(&here, byte, loaded, sources, &self.documents, folders, &self.catalog)
        })
    }

    /// The places of a name as an editor shows them, perhaps with that of its declaration.
    fn locations(&self, found: &Places, with_declaration: bool) -> Vec<Location> {
        let (home, start) = &found.declared;
        let mut all = Vec::new();
        for (path, (text, spans)) in &found.files {
            let (lines, Some(uri)) = (Lines::new(text), self.documents.uri_to_show(path)) else { continue };
            let shown = spans.iter().filter(|span| with_declaration || (path, span.start) != (home, *start));
            all.extend(shown.map(|span| Location { uri: uri.clone(), range: range(&lines, *span) }));
        }
        all
    }

    /// The word at a place that can get a new name; `None` without a name.
    fn prepare_rename(&self, at: &TextDocumentPositionParams) -> Result<Option<PrepareRenameResponse>, Refusal> {
        let Some(found) = self.places_of(at) else { return Ok(None) };
        found.check_old_name().map_err(|reason| Refusal(ErrorCode::RequestFailed, reason))?;
        let Some((text, spans)) = found.files.get(&path(&at.text_document.uri)) else { return Ok(None) };
        let lines = Lines::new(text);
        let byte = lines.byte(at.position.line, at.position.character);
        let here = spans.iter().find(|span| (span.start..=span.end).contains(&byte));
        Ok(here.map(|span| PrepareRenameResponse::RangeWithPlaceholder {
            range: range(&lines, *span),
            placeholder: found.name.clone(),
        }))
    }

    /// Gives the name at a place a new one in all files that see it.
    fn rename(&self, at: &TextDocumentPositionParams, new: &str) -> Result<WorkspaceEdit, Refusal> {
        let refused = |reason: String| Refusal(ErrorCode::RequestFailed, reason);
        let found = self.places_of(at).ok_or_else(|| refused("here is no name that a file declares".into()))?;
        found.check_new_name(new, &self.documents, &self.catalog).map_err(refused)?;
        let edits =
            self.locations(&found, true).into_iter().fold(BTreeMap::new(), |mut all, Location { uri, range }| {
                all.entry(uri).or_insert_with(Vec::new).push(TextEdit { range, new_text: new.to_owned() });
                all
            });
        Ok(WorkspaceEdit { changes: Some(edits.into_iter().collect()), ..WorkspaceEdit::default() })
    }

    /// The names that an imported file offers; the import statement itself may not be readable yet.
    fn imported(&self, uri: &Uri, import: &str) -> Option<(Loaded, Sources)> {
        let root = path(uri);
        let statement = format!("edition 1\nimport \"{import}\"\n");
        let read = |path: &Path| if path == root { Ok(statement.clone()) } else { self.documents.read(path) };
        let mut sources = Sources::default();
        let loaded = lang::load(std::slice::from_ref(&root), &read, &mut sources).ok()?;
        Some((loaded, sources))
    }

    fn layout(&self, uri: &Uri) -> Option<Vec<TextEdit>> {
        let text = self.documents.text(uri)?;
        let source = Sources::default().add("", text);
        let laid_out = lang::format(source, text).ok()?;
        let lines = Lines::new(text);
        let whole = Range { start: Position { line: 0, character: 0 }, end: position(&lines, text.len()) };
        Some(if laid_out == text { Vec::new() } else { vec![TextEdit { range: whole, new_text: laid_out }] })
    }

    /// The fixes of the mistakes in a part of a document.
    fn repairs(&self, uri: &Uri, part: Range) -> Vec<CodeActionOrCommand> {
        let mut sources = Sources::default();
        let root = path(uri);
        let compiled = compile(std::slice::from_ref(&root), &self.catalog, &self.documents, &mut sources);
        let (Ok(compiled), Some((id, source))) = (compiled, sources.iter().next()) else { return Vec::new() };
        let lines = Lines::new(&source.text);
        let mut repairs = Vec::new();
        for each in compiled.diagnostics.iter().filter(|each| each.primary.span.source == id) {
            let range = range(&lines, each.primary.span);
            if range.end < part.start || range.start > part.end {
                continue;
            }
            // A fix in another file is not for this document.
            let fixes = each.fixes.iter().filter(|fix| fix.span.source == id);
            repairs.extend(fixes.map(|fix| {
                let edit = TextEdit { range: self::range(&lines, fix.span), new_text: fix.text.clone() };
                let changes = Some([(uri.clone(), vec![edit])].into());
                CodeActionOrCommand::CodeAction(CodeAction {
                    title: fix.offer(),
                    kind: Some(CodeActionKind::QUICKFIX),
                    diagnostics: Some(vec![shown(each, &lines)]),
                    edit: Some(WorkspaceEdit { changes, ..WorkspaceEdit::default() }),
                    // If there are several fixes, the user must choose.
                    is_preferred: Some(each.fixes.len() == 1),
                    ..CodeAction::default()
                })
            }));
        }
        repairs
    }

    /// Checks all open documents and publishes the diagnostics of them and of their imports.
    fn publish(&mut self) -> Result<(), WireError> {
        let mut by_file: BTreeMap<Uri, Vec<lsp_types::Diagnostic>> = BTreeMap::new();
        for root in self.documents.paths() {
            let mut sources = Sources::default();
            let roots = [root.clone()];
            let checked = contained(|| compile(&roots, &self.catalog, &self.documents, &mut sources));
            let Ok(Ok(compiled)) = checked else { continue };
            by_file.extend(
                self.documents.uri(&root).map(|uri| (uri, Vec::new())).filter(|(uri, _)| !by_file.contains_key(uri)),
            );
            let lines: Vec<Lines> = sources.iter().map(|(_, source)| Lines::new(&source.text)).collect();
            for (index, (id, source)) in sources.iter().enumerate() {
                let Some(uri) = self.documents.uri(&source.path) else { continue };
                let here = by_file.entry(uri).or_default();
                let about = compiled.diagnostics.iter().filter(|each| each.primary.span.source == id);
                for each in about.take(MAX_SHOWN) {
                    let each = shown(each, &lines[index]);
                    if !here.contains(&each) {
                        here.push(each);
                    }
                }
            }
        }
        // Diagnostics that no longer apply are withdrawn.
        for gone in self.shown.iter().filter(|uri| !by_file.contains_key(uri)).cloned().collect::<Vec<_>>() {
            by_file.insert(gone, Vec::new());
        }
        self.shown.clear();
        for (uri, diagnostics) in by_file {
            if !diagnostics.is_empty() {
                self.shown.insert(uri.clone());
            }
            let params = PublishDiagnosticsParams { uri, diagnostics, version: None };
            let params = serde_json::to_value(params).expect("texts and numbers can be written as JSON");
            self.send(Notification { method: PublishDiagnostics::METHOD.into(), params }.into())?;
        }
        Ok(())
    }
}

/// The text before the statement of a byte: up to the last line that starts with a letter.
fn above(text: &str, byte: usize) -> &str {
    let letter = |at: usize| text[at..].starts_with(|first: char| first.is_ascii_alphabetic());
    let mut starts = text[..byte].match_indices('\n').map(|(at, _)| at + 1);
    &text[..starts.rfind(|at| letter(*at)).unwrap_or(0)]
}

/// A diagnostic as an editor shows it.
fn shown(each: &Diagnostic, lines: &Lines) -> lsp_types::Diagnostic {
    let mut message = each.message.clone();
    let fix = each.offer();
    for part in std::iter::once(&each.primary.text).chain(&each.help).chain(&fix).filter(|part| !part.is_empty()) {
        message.push('\n');
        message.push_str(part);
    }
    lsp_types::Diagnostic {
        range: range(lines, each.primary.span),
        severity: Some(match each.severity {
            Severity::Error => lsp_types::DiagnosticSeverity::ERROR,
            Severity::Warning => lsp_types::DiagnosticSeverity::WARNING,
        }),
        code: Some(lsp_types::NumberOrString::String(each.code.into())),
        source: Some("falsify".into()),
        message,
        ..lsp_types::Diagnostic::default()
    }
}

/// The first place of a document.
fn start_of(text_document: TextDocumentIdentifier) -> TextDocumentPositionParams {
    TextDocumentPositionParams { text_document, position: Position { line: 0, character: 0 } }
}

fn capabilities(client: &Client) -> InitializeResult {
    let rename =
        RenameOptions { prepare_provider: Some(true), work_done_progress_options: WorkDoneProgressOptions::default() };
    let triggers = [":", "=", "(", "[", ",", " ", "\"", "/"].map(String::from).to_vec();
    InitializeResult {
        capabilities: ServerCapabilities {
            text_document_sync: Some(TextDocumentSyncCapability::Kind(TextDocumentSyncKind::FULL)),
            hover_provider: Some(HoverProviderCapability::Simple(true)),
            completion_provider: Some(CompletionOptions {
                trigger_characters: Some(triggers),
                ..CompletionOptions::default()
            }),
            definition_provider: Some(OneOf::Left(true)),
            document_symbol_provider: Some(OneOf::Left(true)),
            references_provider: Some(OneOf::Left(true)),
            rename_provider: Some(if client.prepares_names { OneOf::Right(rename) } else { OneOf::Left(true) }),
            document_formatting_provider: Some(OneOf::Left(true)),
            code_action_provider: Some(CodeActionProviderCapability::Simple(true)),
            ..ServerCapabilities::default()
        },
        server_info: Some(ServerInfo { name: "falsify".into(), version: Some(env!("CARGO_PKG_VERSION").into()) }),
    }
}

fn read<T: DeserializeOwned>(params: serde_json::Value) -> Result<T, Refusal> {
    serde_json::from_value(params).map_err(|error| Refusal(ErrorCode::InvalidParams, error.to_string()))
}

fn json(value: &impl Serialize) -> Result<serde_json::Value, Refusal> {
    serde_json::to_value(value).map_err(|error| Refusal(ErrorCode::InternalError, error.to_string()))
}
