//! Complete sessions of the language server, message by message.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::Arc;

use compile::Catalog;
use process::ProcessOpener;
use program::lsp::{Ending, WireError, serve};
use serde_json::{Value, json};

use crate::program::command;

/// The folder for the copy of the standard library that an editor opens.
pub fn shelf() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("shelf")
}

/// A session whose messages are all collected first and sent afterwards.
pub struct Session {
    pub input: Vec<u8>,
    pub next: u64,
}

impl Session {
    pub fn new() -> Self {
        Self::with(&json!({ "capabilities": {} }))
    }

    /// One of an editor that says this of itself.
    pub fn with(editor: &Value) -> Self {
        let mut session = Self { input: Vec::new(), next: 0 };
        session.ask("initialize", editor.clone());
        session.tell("initialized", json!({}));
        session
    }

    fn raw(&mut self, body: &str) {
        self.input.extend(format!("Content-Length: {}\r\n\r\n{body}", body.len()).bytes());
    }

    /// Adds a request and returns its number.
    pub fn ask(&mut self, method: &str, params: Value) -> u64 {
        self.next += 1;
        self.raw(&json!({ "jsonrpc": "2.0", "id": self.next, "method": method, "params": params }).to_string());
        self.next
    }

    pub fn tell(&mut self, method: &str, params: Value) {
        self.raw(&json!({ "jsonrpc": "2.0", "method": method, "params": params }).to_string());
    }

    pub fn open(&mut self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "falsify", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    /// Sends a request about the position of a mark in a text.
    pub fn ask_at(&mut self, method: &str, uri: &str, text: &str, mark: &str) -> u64 {
        let at = text.find(mark).unwrap_or_else(|| panic!("{mark}"));
        let (line, column) = base::diagnostic::Lines::new(text).utf16(at);
        let position = json!({ "line": line, "character": column });
        self.ask(method, json!({ "textDocument": { "uri": uri }, "position": position }))
    }

    /// Ends the session and returns all answers.
    pub fn hold(mut self) -> Vec<Value> {
        self.ask("shutdown", Value::Null);
        self.tell("exit", Value::Null);
        let mut output = Vec::new();
        let catalog = Catalog::builtin().with_opener(Arc::new(ProcessOpener::default()));
        assert_eq!(serve(catalog, &self.input[..], &mut output, shelf()).unwrap(), Ending::Orderly);
        messages(&output)
    }
}

pub fn messages(mut output: &[u8]) -> Vec<Value> {
    let mut all = Vec::new();
    while !output.is_empty() {
        let end = output.windows(4).position(|window| window == b"\r\n\r\n").unwrap();
        let header = std::str::from_utf8(&output[..end]).unwrap();
        let length: usize = header.rsplit(' ').next().unwrap().parse().unwrap();
        all.push(serde_json::from_slice(&output[end + 4..end + 4 + length]).unwrap());
        output = &output[end + 4 + length..];
    }
    all
}

pub fn result(messages: &[Value], id: u64) -> &Value {
    let found = messages.iter().find(|message| message["id"] == id && message.get("method").is_none());
    &found.unwrap_or_else(|| panic!("no answer to {id}"))["result"]
}

pub fn labels(messages: &[Value], id: u64) -> Vec<String> {
    let items = result(messages, id).as_array().unwrap();
    items.iter().map(|item| item["label"].as_str().unwrap().to_string()).collect()
}

/// The last diagnostics that were published for a file.
fn diagnostics<'a>(messages: &'a [Value], uri: &str) -> &'a Vec<Value> {
    let about =
        |message: &&Value| message["method"] == "textDocument/publishDiagnostics" && message["params"]["uri"] == uri;
    messages.iter().rev().find(about).unwrap()["params"]["diagnostics"].as_array().unwrap()
}

const FILE: &str = "file:///nowhere/a%20b.scn";

#[test]
fn mistakes_are_shown_as_they_are_typed_and_taken_back() {
    let mut session = Session::new();
    session.open(FILE, "edition 1\n/* 🚗🚗 */ rewrd a {}\n");
    let seen = session.input.clone();
    let change = json!({ "textDocument": { "uri": FILE, "version": 2 }, "contentChanges": [{ "text": "edition 1\nreward a {}\n" }] });
    session.tell("textDocument/didChange", change);
    let first = Session { input: seen, next: 1 }.hold();
    let said = diagnostics(&first, FILE);
    assert_eq!(said.len(), 1);
    assert_eq!(said[0]["code"], "unknown-form");
    assert_eq!(
        said[0]["range"],
        json!({ "start": { "line": 1, "character": 11 }, "end": { "line": 1, "character": 16 } })
    );
    assert!(said[0]["message"].as_str().unwrap().contains("did you mean `reward`?"));
    assert_eq!(diagnostics(&session.hold(), FILE).len(), 0);
}

#[test]
fn an_address_that_is_not_encoded_is_understood() {
    let mut session = Session::new();
    session.open("file:///nowhere/ü ä.scn", "edition 1\rrewrd a {}\r");
    let said = session.hold();
    let said = diagnostics(&said, "file:///nowhere/%C3%BC%20%C3%A4.scn");
    // A carriage return alone ends a line.
    assert_eq!(said[0]["range"]["start"], json!({ "line": 1, "character": 0 }));
}

#[test]
fn an_unsaved_import_goes_before_the_file_and_gets_its_own_mistakes() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("part.scn"), "edition 1\nreward on_disk { on touch => 1 }\n").unwrap();
    let uri = |name: &str| format!("file://{}/{name}", folder.path().display());
    let mut session = Session::new();
    session.open(&uri("whole.scn"), "edition 1\nimport \"part.scn\"\n");
    session.open(&uri("part.scn"), "edition 1\nreward typed { on touch => v_c }\n");
    let close = json!({ "textDocument": { "uri": uri("part.scn") } });
    let before = Session { input: session.input.clone(), next: 1 }.hold();
    assert_eq!(diagnostics(&before, &uri("part.scn"))[0]["code"], "wrong-unit");
    assert_eq!(diagnostics(&before, &uri("part.scn")).len(), 1, "once, though two files lead to it");
    assert_eq!(diagnostics(&before, &uri("whole.scn")).len(), 0);
    session.tell("textDocument/didClose", close);
    assert_eq!(diagnostics(&session.hold(), &uri("part.scn")).len(), 0, "the file on disk is right");
}

const SCENARIO: &str = "edition 1
import \"std/paper.scn\"
import \"std/drivers.scn\"
import \"std/towns.scn\"
/// Brakes late.
driver hurried = idm(time_headway: 0.8 s, limit_share: 1)
body small { shape: child }
reward fast { on touch(front) => max(1, v_c in m/s) }
campaign mine {
  vehicle: model3
  body: small
  spawn: ahead
  episode: thirty_seconds
  training: ppo_paper
  train { towns: [harbour]  drivers: [hurried]  rewards: [fast] }
}
";

#[test]
fn words_are_explained_where_they_stand() {
    let mut session = Session::new();
    session.open(FILE, SCENARIO);
    let mut wanted = Vec::new();
    for (mark, part) in [
        ("reward fast", "What the pedestrian is paid for"),
        ("idm(", "Intelligent Driver Model"),
        ("time_headway", "time [s, ms], above 0 s; default `1.5 s`"),
        ("s, limit", "time"),
        ("child", "one of"),
        ("touch(", "touch"),
        ("v_c", "speed"),
        ("m/s)", "`m/s` (unit): speed"),
        ("front)", "`front` within the front sector"),
        ("vehicle:", "name of a vehicle; required"),
        ("train {", "Trains one pedestrian"),
        ("towns:", "Towns to train in"),
        ("harbour]", "A port"),
        ("hurried]", "Brakes late."),
    ] {
        wanted.push((mark, part, session.ask_at("textDocument/hover", FILE, SCENARIO, mark)));
    }
    let comment = session.ask_at("textDocument/hover", FILE, SCENARIO, "Brakes late");
    let answers = session.hold();
    for (mark, part, id) in wanted {
        let text = result(&answers, id)["contents"]["value"].as_str().unwrap_or_default();
        assert!(text.contains(part), "{mark}: {text}");
    }
    assert_eq!(*result(&answers, comment), Value::Null);
}

#[test]
fn what_could_stand_at_the_cursor_is_offered() {
    let mut session = Session::new();
    let mut wanted = Vec::new();
    for (index, (before, some, not)) in [
        ("edition 1\n", "campaign", "time_headway"),
        ("edition 1\nimport \"", "std/towns.scn", "campaign"),
        ("edition 1\ndriver p = ", "behavior_agent", "campaign"),
        ("edition 1\ndriver p = idm(", "time_headway", "campaign"),
        ("edition 1\ndriver p = idm(margin: 1 m, ", "time_headway", "m"),
        ("edition 1\ndriver p = behavior_agent(profile: ", "cautious", "time_headway"),
        ("edition 1\nspawn s { bearing: -60 ", "deg", "bearing"),
        ("edition 1\nspawn s {\n  bearing: -60 deg .. 60 deg\n  ", "distance", "deg"),
        ("edition 1\nreward r { on ", "touch", "distance"),
        ("edition 1\nreward r { on touch(", "front", "touch"),
        ("edition 1\nreward r { on touch => ", "v_c", "touch"),
        ("edition 1\nreward r { on touch => max(1, ", "v_c", "touch"),
        ("edition 1\nreward r { on step => distance in ", "m", "distance"),
        ("edition 1\nepisode e { traffic_lights: ", "true", "ticks"),
        ("edition 1\nimport \"std/drivers.scn\"\ncampaign c {\n  vehicle: ", "plain_car", "vehicle"),
        ("edition 1\nimport \"std/towns.scn\"\ncampaign c {\n  train { towns: [harbour, ", "village", "towns"),
        ("edition 1\ncampaign c {\n  training: x\n  train {\n    ", "rewards", "evaluate"),
        ("edition 1\ncampaign c {\n  train { towns: [a] }\n  ", "evaluate", "towns"),
        ("edition 1\ntown t = opendrive(file: \"x\") {\n  ", "building", "file_name"),
    ]
    .into_iter()
    .enumerate()
    {
        let uri = format!("untitled:{index}");
        session.open(&uri, before);
        let (line, column) = base::diagnostic::Lines::new(before).utf16(before.len());
        let position = json!({ "line": line, "character": column });
        let params = json!({ "textDocument": { "uri": uri }, "position": position });
        wanted.push((before, some, not, session.ask("textDocument/completion", params)));
    }
    let answers = session.hold();
    for (before, some, not, id) in wanted {
        let labels = labels(&answers, id);
        assert!(labels.iter().any(|label| label == some), "{before:?} lacks {some}: {labels:?}");
        assert!(!labels.iter().any(|label| label == not), "{before:?} has {not}: {labels:?}");
    }
}

#[test]
fn a_fitting_unit_comes_first() {
    let mut session = Session::new();
    let mut wanted = Vec::new();
    for (index, (line, units)) in [
        ("spawn s { bearing: -60 ", ["deg", "rad"]),
        ("reward r { on touch => v_c in ", ["m/s", "km/h"]),
        ("reward r { on step => distance in ", ["m", "km"]),
        ("param fast: speed = 3 ", ["m/s", "km/h"]),
    ]
    .into_iter()
    .enumerate()
    {
        let uri = format!("untitled:{index}");
        session.open(&uri, &format!("edition 1\n{line}"));
        let position = json!({ "line": 1, "character": line.len() });
        let params = json!({ "textDocument": { "uri": uri }, "position": position });
        wanted.push((line, units, session.ask("textDocument/completion", params)));
    }
    let answers = session.hold();
    for (line, units, id) in wanted {
        assert_eq!(labels(&answers, id)[..2], units, "{line}");
    }
}

#[test]
fn names_and_imports_lead_to_their_declarations() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("part.scn"), "edition 1\n\nvehicle mine = generic()\n").unwrap();
    let uri = |name: &str| format!("file://{}/{name}", folder.path().display());
    let text =
        SCENARIO.replace("vehicle: model3", "vehicle: mine").replace("edition 1\n", "edition 1\nimport \"part.scn\"\n");
    let mut session = Session::new();
    session.open(&uri("whole.scn"), &text);
    let import = session.ask_at("textDocument/definition", &uri("whole.scn"), &text, "part.scn");
    let other = session.ask_at("textDocument/definition", &uri("whole.scn"), &text, "mine\n");
    let same = session.ask_at("textDocument/definition", &uri("whole.scn"), &text, "hurried]");
    let symbols = session.ask("textDocument/documentSymbol", json!({ "textDocument": { "uri": uri("whole.scn") } }));
    let answers = session.hold();
    assert_eq!(result(&answers, import)["uri"], uri("part.scn"));
    assert_eq!(result(&answers, other)["uri"], uri("part.scn"));
    assert_eq!(result(&answers, other)["range"]["start"], json!({ "line": 2, "character": 8 }));
    assert_eq!(result(&answers, same)["uri"], uri("whole.scn"));
    assert_eq!(result(&answers, same)["range"]["start"]["line"], 6);
    let names: Vec<&str> =
        result(&answers, symbols).as_array().unwrap().iter().map(|each| each["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["hurried", "small", "fast", "mine"]);
}

#[test]
fn what_the_library_declares_can_be_read() {
    let mut session = Session::new();
    session.open(FILE, SCENARIO);
    let town = session.ask_at("textDocument/definition", FILE, SCENARIO, "harbour]");
    let import = session.ask_at("textDocument/definition", FILE, SCENARIO, "std/paper.scn");
    let answers = session.hold();
    for (id, name) in [(town, "towns.scn"), (import, "paper.scn")] {
        let uri = result(&answers, id)["uri"].as_str().unwrap();
        let file = shelf().join(name);
        assert_eq!(uri, format!("file://{}", file.display()));
        let text = std::fs::read_to_string(file).unwrap();
        let start = &result(&answers, id)["range"]["start"];
        let line = text.lines().nth(start["line"].as_u64().unwrap() as usize).unwrap();
        assert!(id == import || line.starts_with("town harbour"), "{line}");
        // The text there can be opened, and its positions accept requests in turn.
        let mut inside = Session::new();
        inside.open(uri, &text);
        assert_eq!(diagnostics(&inside.hold(), uri), &Vec::<Value>::new());
    }
}

#[test]
fn repairs_are_offered_where_the_mistake_is() {
    let text = "edition 1\nspwan s { bearing: -60 .. 60 deg }\ndriver p = idm(magrin: 1 m)\n";
    let mut session = Session::new();
    session.open(FILE, text);
    let line = |number: u32, to: u32| json!({ "start": { "line": number, "character": 0 }, "end": { "line": number, "character": to } });
    let mut ask = |range: Value| {
        let params = json!({ "textDocument": { "uri": FILE }, "range": range, "context": { "diagnostics": [] } });
        session.ask("textDocument/codeAction", params)
    };
    let (none, word, key) = (ask(line(0, 3)), ask(line(1, 3)), ask(line(2, 40)));
    let answers = session.hold();
    let texts = |id: u64| -> Vec<String> {
        let actions = result(&answers, id).as_array().unwrap();
        let text = |action: &Value| action["edit"]["changes"][FILE][0]["newText"].as_str().unwrap().to_string();
        actions.iter().map(text).collect()
    };
    assert_eq!(texts(none), Vec::<String>::new());
    assert_eq!(texts(word), ["spawn"]);
    assert_eq!(texts(key), ["margin"]);
    let action = &result(&answers, word)[0];
    assert_eq!((&action["kind"], &action["isPreferred"]), (&json!("quickfix"), &json!(true)));
    assert_eq!(action["diagnostics"][0]["code"], "unknown-form");
    assert_eq!(
        action["edit"]["changes"][FILE][0]["range"],
        json!({ "start": { "line": 1, "character": 0 }, "end": { "line": 1, "character": 5 } })
    );
}

#[test]
fn a_missing_import_is_added_where_imports_stand() {
    let text = "edition 1\nimport \"std/paper.scn\"\ncampaign c { vehicle: model3 }\n";
    let mut session = Session::new();
    session.open(FILE, text);
    let range = json!({ "start": { "line": 2, "character": 24 }, "end": { "line": 2, "character": 25 } });
    let params = json!({ "textDocument": { "uri": FILE }, "range": range, "context": { "diagnostics": [] } });
    let asked = session.ask("textDocument/codeAction", params);
    let answers = session.hold();
    let [action] = result(&answers, asked).as_array().unwrap().as_slice() else { panic!("one repair") };
    let edit = &action["edit"]["changes"][FILE][0];
    let place = json!({ "line": 1, "character": 22 });
    assert_eq!(edit["newText"], "\nimport model3 from \"std/drivers.scn\"");
    assert_eq!(edit["range"], json!({ "start": place, "end": place }));
}

#[test]
fn a_program_as_driver_is_no_mistake_and_is_not_started() {
    let mut session = Session::new();
    let mark = tempfile::tempdir().unwrap();
    let file = mark.path().join("started");
    let text = format!("edition 1\ndriver p = external(command: \"touch {}\")\n", file.display());
    session.open(FILE, &text);
    assert_eq!(diagnostics(&session.hold(), FILE), &Vec::<Value>::new());
    assert!(!file.exists());
}

#[test]
fn a_file_is_laid_out_unless_it_cannot_be_read() {
    let mut session = Session::new();
    session.open(FILE, "edition 1 reward r{on touch=>1}");
    session.open("untitled:bad", "edition 1 reward r{on touch=>}");
    let ask = |session: &mut Session, uri: &str| {
        let options = json!({ "tabSize": 2, "insertSpaces": true });
        session.ask("textDocument/formatting", json!({ "textDocument": { "uri": uri }, "options": options }))
    };
    let (good, bad) = (ask(&mut session, FILE), ask(&mut session, "untitled:bad"));
    let answers = session.hold();
    assert_eq!(result(&answers, good)[0]["newText"], "edition 1\nreward r { on touch => 1 }\n");
    assert_eq!(*result(&answers, bad), Value::Null);
}

#[test]
fn malformed_messages_and_unknown_requests_do_no_harm() {
    let mut session = Session::new();
    session.raw("{ this is no JSON");
    session.raw("[1, 2]");
    let unknown = session.ask("textDocument/dance", json!({}));
    let wrong = session.ask("textDocument/hover", json!({ "textDocument": 7 }));
    session.tell("textDocument/didOpen", json!({ "textDocument": 7 }));
    session.tell("$/something", json!(null));
    session.open(FILE, SCENARIO);
    let beyond = session.ask(
        "textDocument/hover",
        json!({ "textDocument": { "uri": FILE }, "position": { "line": 9999, "character": 9999 } }),
    );
    let answers = session.hold();
    let error = |id: u64| answers.iter().find(|message| message["id"] == id).unwrap()["error"]["code"].clone();
    assert_eq!((error(unknown), error(wrong)), (json!(-32601), json!(-32602)));
    assert_eq!(answers.iter().filter(|message| message["error"]["code"] == -32700).count(), 2);
    assert_eq!(*result(&answers, beyond), Value::Null);
    assert_eq!(diagnostics(&answers, FILE).len(), 0, "and it goes on");
}

#[test]
fn a_stream_out_of_step_ends_the_session() {
    let serve = |input: &[u8]| serve(Catalog::builtin(), input, &mut Vec::new(), shelf());
    assert!(matches!(serve(b""), Ok(Ending::Abrupt)));
    assert!(matches!(serve(b"GET / HTTP/1.1\r\n\r\n"), Err(WireError::Headers)));
    assert!(matches!(serve(b"Content-Length: 99999999999999\r\n\r\n"), Err(WireError::Headers)));
    assert!(matches!(serve(b"Content-Length: 20\r\n\r\n{}"), Err(WireError::Stream(_))));
    assert!(matches!(serve(&vec![b'x'; 1 << 20]), Err(WireError::Headers)));
}

#[test]
fn the_server_ends_with_its_editor_though_its_input_stays_open() {
    let mut editor = std::process::Command::new("sleep").arg("600").spawn().unwrap();
    let session = Session::with(&json!({ "capabilities": {}, "processId": editor.id() }));
    let mut server = command().arg("lsp").stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    server.stdin.as_mut().unwrap().write_all(&session.input).unwrap();
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert!(server.try_wait().unwrap().is_none(), "the editor runs");
    editor.kill().unwrap();
    editor.wait().unwrap();
    let begun = std::time::Instant::now();
    while server.try_wait().unwrap().is_none() {
        assert!(begun.elapsed().as_secs() < 30, "it runs on without its editor");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
}

#[test]
fn a_huge_file_gets_one_mistake_and_quick_answers() {
    let text = format!("edition 1\n{}", "reward r { on touch => 1 }\n".repeat(240_000));
    let mut session = Session::new();
    session.open(FILE, &text);
    let hover = session.ask(
        "textDocument/hover",
        json!({ "textDocument": { "uri": FILE }, "position": { "line": 200_000, "character": 1 } }),
    );
    let answers = session.hold();
    assert_eq!(diagnostics(&answers, FILE)[0]["code"], "too-large");
    assert!(result(&answers, hover)["contents"]["value"].as_str().unwrap().contains("paid"));
}

#[test]
fn every_place_of_a_file_can_be_asked_about() {
    let text = &SCENARIO[..SCENARIO.len().min(420)];
    let mut session = Session::new();
    session.open(FILE, text);
    for line in 0..12 {
        for character in (0..60).step_by(3) {
            let at = json!({ "textDocument": { "uri": FILE }, "position": { "line": line, "character": character } });
            for method in ["hover", "completion", "definition"] {
                session.ask(&format!("textDocument/{method}"), at.clone());
            }
        }
    }
    assert!(session.hold().iter().all(|message| message.get("error").is_none()));
}

#[test]
fn the_program_serves_on_its_standard_streams() {
    let mut session = Session::new();
    session.ask("shutdown", Value::Null);
    session.tell("exit", Value::Null);
    let mut child = command()
        .args(["lsp", "--stdio"])
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(&session.input).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let answers = messages(&output.stdout);
    assert_eq!(answers[0]["result"]["serverInfo"]["name"], "falsify");
    assert_eq!(answers.len(), 2);
}

const NAMED: &str = "edition 1
import suicidal, near_you from \"part.scn\"
import \"std/paper.scn\"
/// How far.
param far: length = 30 m
param who: body = suicidal
param lit: boolean = true
spawn s { distance: 7 m .. far }
reward r { on step => distance / far }
campaign c {
  body: who
  matrix { far: [20 m, far] }
}
";

/// A folder with `part.scn`, and the name of another file in that folder.
fn with_part() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let part = "edition 1\n/// Near.\nparam near_you: length = 7 m\n/// Someone.\nbody suicidal {}\n";
    std::fs::write(folder.path().join("part.scn"), part).unwrap();
    let uri = format!("file://{}/whole.scn", folder.path().display());
    (folder, uri)
}

#[test]
fn parameters_and_imported_names_are_explained_and_found() {
    let (_folder, uri) = with_part();
    let mut session = Session::new();
    session.open(&uri, NAMED);
    let mut wanted = Vec::new();
    for (mark, part, line) in [
        ("far: length", "param far: length = 30 m", Some(4)),
        ("length =", "`m`", None),
        ("body =", "The pedestrian that attacks", None),
        ("suicidal, near", "Someone.", Some(4)),
        ("near_you from", "param near_you: length = 7 m", Some(2)),
        ("suicidal\nparam", "Someone.", Some(4)),
        ("far }\nreward", "How far.", Some(4)),
        ("far }\ncampaign", "How far.", Some(4)),
        ("who\n  matrix", "param who: body = suicidal", Some(5)),
        ("far: [", "How far.", Some(4)),
        ("far] }", "How far.", Some(4)),
    ] {
        let hover = session.ask_at("textDocument/hover", &uri, NAMED, mark);
        wanted.push((mark, part, line, hover, session.ask_at("textDocument/definition", &uri, NAMED, mark)));
    }
    let symbols = session.ask("textDocument/documentSymbol", json!({ "textDocument": { "uri": uri } }));
    let answers = session.hold();
    for (mark, part, line, hover, definition) in wanted {
        let text = result(&answers, hover)["contents"]["value"].as_str().unwrap_or_default();
        assert!(text.contains(part), "{mark}: {text}");
        assert_eq!(result(&answers, definition)["range"]["start"]["line"], json!(line), "{mark}");
    }
    let names: Vec<&str> =
        result(&answers, symbols).as_array().unwrap().iter().map(|each| each["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["far", "who", "lit", "s", "r", "c"]);
}

#[test]
fn parameters_types_and_imported_names_are_offered() {
    let (_folder, uri) = with_part();
    let mut session = Session::new();
    let mut wanted = Vec::new();
    for (after, some, not) in [
        ("param far: ", "turn_rate", "far"),
        ("param x: ", "body", "far"),
        ("param x: length = ", "far", "who"),
        ("param x: body = ", "suicidal", "far"),
        ("param x: boolean = ", "true", "far"),
        ("param wide: length = 3 m\nparam x: length = ", "wide", "x"),
        ("param x: length = 3 ", "km", "far"),
        ("param x: length = 3 m\n", "param", "far"),
        ("import ", "near_you", "far"),
        ("import suicidal, ", "near_you", "far"),
        ("import suicidal from \"", "std/towns.scn", "far"),
        ("spawn t { distance: ", "truncated", "who"),
        ("spawn t { distance: truncated(", "normal", "who"),
        ("spawn t { distance: 7 m .. ", "far", "who"),
        ("reward q { on step => distance / ", "far", "who"),
        ("campaign d {\n  body: ", "who", "far"),
        ("episode e { traffic_lights: ", "lit", "far"),
        ("campaign d {\n  ", "matrix", "far"),
        ("episode e {\n  ", "ticks", "matrix"),
        ("campaign d {\n  matrix { ", "far", "body"),
        ("campaign d {\n  matrix { who: [", "suicidal", "far"),
        ("campaign d {\n  matrix { far: 3 m  ", "lit", "body"),
    ] {
        // The text that is being typed is in the middle of a file.
        let head = NAMED.split_once("spawn s").unwrap().0;
        let rest = if after.contains("import") { " from \"part.scn\"\n" } else { "" };
        let text = format!("{head}{after}{rest}");
        session.open(&uri, &text);
        let (line, column) = base::diagnostic::Lines::new(&text).utf16(head.len() + after.len());
        let position = json!({ "line": line, "character": column });
        let params = json!({ "textDocument": { "uri": uri }, "position": position });
        wanted.push((after, some, not, session.ask("textDocument/completion", params)));
    }
    let answers = session.hold();
    for (after, some, not, id) in wanted {
        let labels = labels(&answers, id);
        assert!(labels.iter().any(|label| label == some), "{after:?} lacks {some}: {labels:?}");
        assert!(!labels.iter().any(|label| label == not), "{after:?} has {not}: {labels:?}");
    }
}

/// A file that declares `mine` and two that import it; only the second is open.
fn three_files(folder: &Path) -> (impl Fn(&str) -> String, String) {
    let part = "edition 1\nvehicle mine = generic()\nparam far: length = 30 m\n";
    std::fs::write(folder.join("part.scn"), part).unwrap();
    let other = "edition 1\n// mine\nimport mine from \"part.scn\"\ndriver mine = idm()\n";
    std::fs::write(folder.join("other.scn"), other).unwrap();
    let text = SCENARIO.replace("vehicle: model3", "vehicle: mine").replace("campaign mine", "campaign everything");
    let text = text.replace("edition 1\n", "edition 1\nimport \"part.scn\"\n");
    let root = format!("file://{}", folder.display());
    (move |name: &str| format!("{root}/{name}"), text)
}

/// The places of an answer as `file:line:column`.
pub fn at_places(answer: &Value) -> Vec<String> {
    let place = |each: &Value| {
        let (uri, start) = (each["uri"].as_str().unwrap(), &each["range"]["start"]);
        format!("{}:{}:{}", uri.rsplit('/').next().unwrap(), start["line"], start["character"])
    };
    answer.as_array().unwrap().iter().map(place).collect()
}

#[test]
fn all_places_of_a_name_are_found_in_the_files_that_see_it() {
    let folder = tempfile::tempdir().unwrap();
    let (uri, text) = three_files(folder.path());
    let mut session = Session::new();
    session.open(&uri("whole.scn"), &text);
    let mut ask = |mark: &str, declaration: bool| {
        let (line, column) = base::diagnostic::Lines::new(&text).utf16(text.find(mark).unwrap());
        let params = json!({ "textDocument": { "uri": uri("whole.scn") }, "position": { "line": line, "character": column },
            "context": { "includeDeclaration": declaration } });
        session.ask("textDocument/references", params)
    };
    let (all, uses, own, nothing) =
        (ask("mine\n", true), ask("mine\n", false), ask("hurried =", true), ask("0.8", true));
    let answers = session.hold();
    // A policy of the same name, and a comment, are others.
    let uses_of_mine = ["other.scn:2:7", "whole.scn:10:11"];
    assert_eq!(at_places(result(&answers, uses)), uses_of_mine);
    assert_eq!(at_places(result(&answers, all)), [uses_of_mine[0], "part.scn:1:8", uses_of_mine[1]]);
    assert_eq!(at_places(result(&answers, own)), ["whole.scn:6:7", "whole.scn:15:38"]);
    assert_eq!(*result(&answers, nothing), Value::Null);
}

#[test]
fn a_new_name_is_written_in_all_files_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (uri, text) = three_files(folder.path());
    let mut session = Session::new();
    session.open(&uri("whole.scn"), &text);
    let mut ask = |mark: &str, new: &str| {
        let (line, column) = base::diagnostic::Lines::new(&text).utf16(text.find(mark).unwrap());
        let position = json!({ "line": line, "character": column });
        let params = json!({ "textDocument": { "uri": uri("whole.scn") }, "position": position, "newName": new });
        session.ask("textDocument/rename", params)
    };
    let good = ask("mine\n", "yours");
    let refused = [
        (ask("mine\n", "model3"), "is taken"),
        (ask("mine\n", "far"), "is taken"),
        (ask("mine\n", "on"), "is not a name"),
        (ask("mine\n", "a b"), "is not a name"),
        (ask("mine\n", ""), "is not a name"),
        (ask("harbour]", "port"), "standard library"),
        (ask("0.8", "other"), "no name that a file declares"),
    ];
    let answers = session.hold();
    let changes = &result(&answers, good)["changes"];
    for (file, line, column) in [("whole.scn", 10, 11), ("part.scn", 1, 8), ("other.scn", 2, 7)] {
        let edits = changes[uri(file)].as_array().unwrap();
        assert_eq!((edits.len(), &edits[0]["newText"]), (1, &json!("yours")), "{file}");
        let start = json!({ "line": line, "character": column });
        assert_eq!((&edits[0]["range"]["start"], &edits[0]["range"]["end"]["character"]), (&start, &json!(column + 4)));
    }
    for (id, reason) in refused {
        let answer = answers.iter().find(|answer| answer["id"] == id).unwrap();
        let said = answer["error"]["message"].as_str().unwrap_or_default();
        assert!(said.contains(reason), "{reason}: {answer}");
    }
}

#[test]
fn requirements_in_rewards_are_found_and_renamed() {
    const TEXT: &str = "edition 1
requirement rq = always(gap < 1 m implies ego_speed < 3 m/s)
reward rq2 { on violated( rq ) => 1 - robustness(rq) }
";
    let mut session = Session::new();
    session.open(FILE, TEXT);
    let declared = session.ask_at("textDocument/definition", FILE, TEXT, "rq) }");
    let position = json!({ "line": 2, "character": 26 });
    let at = json!({ "textDocument": { "uri": FILE }, "position": position, "newName": "better",
        "context": { "includeDeclaration": true } });
    let (all, renamed) = (session.ask("textDocument/references", at.clone()), session.ask("textDocument/rename", at));
    let answers = session.hold();
    assert_eq!(result(&answers, declared)["range"]["start"], json!({ "line": 1, "character": 12 }));
    let places: Vec<String> = at_places(result(&answers, all));
    let places: Vec<&str> = places.iter().map(|place| place.split_once(':').unwrap().1).collect();
    assert_eq!(places, ["1:12", "2:26", "2:49"]);
    assert_eq!(result(&answers, renamed)["changes"][FILE].as_array().unwrap().len(), 3);
}

#[test]
fn addresses_that_are_not_encoded_are_understood() {
    let mut session = Session::new();
    session.open("file:///nowhere/100%/[1]/c.scn", "edition 1\nrewrd a {}\n");
    let said = session.hold();
    assert!(!diagnostics(&said, "file:///nowhere/100%25/%5B1%5D/c.scn").is_empty());
}
