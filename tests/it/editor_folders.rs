//! The language server in a folder of scenarios: closed files, paths of imports, changes on disk; and files that are being written.

use std::io::{BufRead, Read};
use std::path::Path;

use compile::Catalog;
use program::lsp::{Ending, serve};
use serde_json::{Value, json};

use crate::language_server::{Session, at_places, labels, messages, result, shelf};

/// A session of an editor that has a folder open.
fn session(folder: &Path, capabilities: &Value) -> Session {
    let root = format!("file://{}", folder.display());
    Session::with(&json!({ "capabilities": capabilities, "rootUri": root }))
}

/// A folder with a declaration, a scenario below it that imports it, and copies of that in folders that are left out.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::Builder::new().prefix("scenarios").tempdir().unwrap();
    let here = folder.path();
    for below in ["deep/er", "target", ".hidden"] {
        std::fs::create_dir_all(here.join(below)).unwrap();
    }
    std::fs::create_dir(here.join("lib")).unwrap();
    std::fs::write(here.join("lib/part.scn"), PART).unwrap();
    let user = "edition 1\nimport \"../../lib/part.scn\"\ncampaign c { spawn: mine }\n";
    std::fs::write(here.join("deep/er/user.scn"), user).unwrap();
    for left_out in ["target/copy.scn", ".hidden/copy.scn"] {
        std::fs::write(here.join(left_out), user.replace("../../", "../")).unwrap();
    }
    std::fs::write(here.join("other.scn"), "edition 1\nspawn mine { distance: 9 m }\n").unwrap();
    folder
}

const PART: &str = "edition 1\n/// Near the car.\nspawn mine { distance: 7 m }\nparam far: length = 30 m\n";

#[test]
fn closed_scenarios_of_the_open_folder_that_import_a_file_take_its_new_names() {
    let folder = folder();
    let uri = |name: &str| format!("file://{}/{name}", folder.path().display());
    let part = uri("lib/part.scn");
    let mut session = session(folder.path(), &json!({}));
    session.open(&part, PART);
    let line = json!({ "line": 2, "character": 7 });
    let params =
        json!({ "textDocument": { "uri": part }, "position": line, "context": { "includeDeclaration": true } });
    let references = session.ask("textDocument/references", params);
    let params = json!({ "textDocument": { "uri": part }, "position": line, "newName": "yours" });
    let rename = session.ask("textDocument/rename", params);
    let answers = session.hold();
    assert_eq!(at_places(result(&answers, references)), ["user.scn:2:20", "part.scn:2:6"]);
    let changes = result(&answers, rename)["changes"].as_object().unwrap();
    let changed: Vec<&String> = changes.keys().collect();
    assert_eq!(changed, [&uri("deep/er/user.scn"), &part]);
    assert_eq!(changes[&uri("deep/er/user.scn")][0]["newText"], "yours");
}

#[test]
fn the_name_of_a_declaration_answers_as_its_uses_do() {
    let uri = "file:///nowhere/part.scn";
    let mut asking = Session::new();
    asking.open(uri, PART);
    let mut wanted = Vec::new();
    for (mark, text, place) in [("mine {", "Near the car.", 2), ("far:", "param far: length = 30 m", 3)] {
        let hover = asking.ask_at("textDocument/hover", uri, PART, mark);
        let definition = asking.ask_at("textDocument/definition", uri, PART, mark);
        let prepared = asking.ask_at("textDocument/prepareRename", uri, PART, mark);
        wanted.push((mark, text, place, hover, definition, prepared));
    }
    let nothing = asking.ask_at("textDocument/prepareRename", uri, PART, "7 m");
    let answers = asking.hold();
    for (mark, text, line, hover, definition, prepared) in wanted {
        let said = result(&answers, hover)["contents"]["value"].as_str().unwrap_or_default();
        assert!(said.contains(text), "{mark}: {said}");
        let start = json!({ "line": line, "character": 6 });
        assert_eq!(result(&answers, definition)["range"]["start"], start, "{mark}");
        let prepared = result(&answers, prepared);
        let name = mark.trim_end_matches([' ', '{', ':']);
        assert_eq!((&prepared["range"]["start"], &prepared["placeholder"]), (&start, &json!(name)));
    }
    assert_eq!(*result(&answers, nothing), Value::Null);

    // Names of the library cannot be given up, and only editors that ask beforehand are offered it.
    let text = "edition 1\nimport \"std/towns.scn\"\nmethod f = chance()\ncampaign c { search { towns: [harbour] } }\n";
    let capabilities = json!({ "textDocument": { "rename": { "prepareSupport": true } } });
    let mut asking = Session::with(&json!({ "capabilities": capabilities }));
    asking.open(uri, text);
    let refused = asking.ask_at("textDocument/prepareRename", uri, text, "harbour]");
    let answers = asking.hold();
    let of = |id: u64| answers.iter().find(|answer| answer["id"] == id && answer.get("method").is_none()).unwrap();
    assert!(of(refused)["error"]["message"].as_str().unwrap_or_default().contains("standard library"), "{answers:?}");
    assert_eq!(of(1)["result"]["capabilities"]["renameProvider"]["prepareProvider"], true);
}

#[test]
fn paths_of_imports_lead_to_folders_and_scenarios_beside_the_file() {
    let folder = folder();
    let uri = format!("file://{}/new.scn", folder.path().display());
    let mut wanted = Vec::new();
    let mut asking = session(folder.path(), &json!({}));
    for (typed, offered, other, start) in [
        ("edition 1\nimport \"", vec!["deep/", "lib/", "other.scn", "std/towns.scn"], "target/", 8),
        ("edition 1\nimport \"lib/", vec!["lib/part.scn"], "other.scn", 8),
        ("edition 1\nimport \"./deep/er/u", vec!["./deep/er/user.scn"], "deep/", 8),
        ("edition 1\nimport \"lib/../", vec!["lib/../other.scn"], "lib/../new.scn", 8),
        ("edition 1\nimport mine from \"nowhere/", vec!["std/towns.scn"], "lib/", 18),
    ] {
        asking.open(&uri, typed);
        let end = typed.lines().last().unwrap().len();
        let params = json!({ "textDocument": { "uri": uri }, "position": { "line": 1, "character": end } });
        wanted.push((typed, offered, other, (start, end), asking.ask("textDocument/completion", params)));
    }
    let answers = asking.hold();
    for (typed, offered, other, (start, end), id) in wanted {
        let labels = labels(&answers, id);
        for path in offered {
            assert!(labels.iter().any(|label| label == path), "{typed}: {path} of {labels:?}");
        }
        assert!(!labels.iter().any(|label| label == other), "{typed}: {labels:?}");
        let edit = &result(&answers, id)[0]["textEdit"]["range"];
        let columns = (&edit["start"]["character"], &edit["end"]["character"]);
        assert_eq!(columns, (&json!(start), &json!(end)), "{typed}");
    }
}

/// Writes a file when a reader comes to it, and has no bytes.
struct Writes<'a>(&'a Path, &'a str);

impl Read for Writes<'_> {
    fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
        std::fs::write(self.0, self.1).map(|()| 0)
    }
}

impl BufRead for Writes<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        std::fs::write(self.0, self.1)?;
        Ok(&[])
    }

    fn consume(&mut self, _: usize) {}
}

#[test]
fn a_change_on_disk_is_seen_in_the_open_files_that_import_it() {
    let folder = folder();
    let uri = format!("file://{}/new.scn", folder.path().display());
    let capabilities = json!({ "workspace": { "didChangeWatchedFiles": { "dynamicRegistration": true } } });
    let mut before = session(folder.path(), &capabilities);
    before.open(&uri, "edition 1\nimport mine from \"lib/part.scn\"\n");
    let mut after = Session { input: Vec::new(), next: 10 };
    let part = folder.path().join("lib/part.scn");
    let changes = json!({ "changes": [{ "uri": format!("file://{}", part.display()), "type": 2 }] });
    after.tell("workspace/didChangeWatchedFiles", changes);
    after.ask("shutdown", Value::Null);
    after.tell("exit", Value::Null);
    let edited = Writes(&part, "edition 1\nspawn yours { distance: 7 m }\n");
    let mut output = Vec::new();
    let input = before.input.chain(edited).chain(&after.input[..]);
    assert_eq!(serve(Catalog::builtin(), input, &mut output, shelf()).unwrap(), Ending::Orderly);
    let answers = messages(&output);
    let asked = answers.iter().find(|message| message["method"] == "client/registerCapability").unwrap();
    let registration = &asked["params"]["registrations"][0];
    assert_eq!(registration["method"], "workspace/didChangeWatchedFiles");
    let watched = registration["registerOptions"]["watchers"][0]["globPattern"].as_str().unwrap();
    assert!(watched.contains("scn"), "{watched}");
    let published: Vec<usize> = answers
        .iter()
        .filter(|message| message["method"] == "textDocument/publishDiagnostics" && message["params"]["uri"] == uri)
        .map(|message| message["params"]["diagnostics"].as_array().unwrap().len())
        .collect();
    assert_eq!(published, [0, 1], "the name that it imports is gone");
    let quiet = session(folder.path(), &json!({})).hold();
    assert!(quiet.iter().all(|message| message["method"] != "client/registerCapability"), "an editor that cannot");
}

#[test]
fn a_half_typed_kind_hides_no_other_declaration() {
    let text = "edition 1\nimport \"std/towns.scn\"\nmethod f = archive(rew\n/// Pays.\nreward pays { on touch => 1 }\n\
        method meet = intercept()\ncampaign c {\n  search { towns: [harbour]  methods: [meet] }\n}\n";
    let mut session = Session::new();
    let uri = "untitled:half";
    session.open(uri, text);
    let at = json!({ "line": 2, "character": "method f = archive(rew".len() });
    let completion = session.ask("textDocument/completion", json!({ "textDocument": { "uri": uri }, "position": at }));
    let hover = session.ask_at("textDocument/hover", uri, text, "harbour]");
    let definition = session.ask_at("textDocument/definition", uri, text, "meet]");
    let answers = session.hold();
    assert!(labels(&answers, completion).iter().any(|label| label == "reward"), "{answers:?}");
    let said = result(&answers, hover)["contents"]["value"].as_str().unwrap_or_default();
    assert!(said.contains("port"), "{said}");
    assert_eq!(result(&answers, definition)["range"]["start"], json!({ "line": 5, "character": 7 }));
}
