//! What mistakes look like on the screen: short scenarios with all messages about them, compared with `tests/suite/messages.snap`.
//!
//! `INSTA_UPDATE=always` writes the file again; then read the difference.

use std::path::Path;

use base::diagnostic::{Colour, Sources, render};
use compile::{Catalog, compile};
use lang::error_index::mistakes;

/// Mistakes of authors who know other languages, and the messages for them.
const TRAPS: &[(&str, &str)] = &[
    ("a misspelt form", "edition 1\nspwan s { clearance: 2 m }\n"),
    ("a misspelt kind", "edition 1\npolicy p = behaviour_agent()\n"),
    ("a misspelt property", "edition 1\npolicy p = idm(time_hedway: 2 s)\n"),
    ("an unknown property", "edition 1\nspawn s { with_wind: 5 }\n"),
    ("a forgotten deg", "edition 1\nspawn s { bearing: -60 .. 60 }\n"),
    ("a unit spelt out", "edition 1\nspawn s { distance: 7 meters .. 30 m }\n"),
    ("a forgotten comma in a list", "edition 1\nspawn s { ego_poses: [(1 m, 2 m, 3 deg) (4 m, 5 m, 6 deg)] }\n"),
    (
        "a condition that contradicts the rest",
        "edition 1\nspawn s { distance: 7 m .. 30 m  require: distance > 40 m }\n",
    ),
    ("a condition that is never true", "edition 1\nspawn s { require: 7 m > 30 m }\n"),
    ("an undeclared parameter", "edition 1\nparam far: length = 30 m\nspawn s { distance: 7 m .. fra }\n"),
    ("a unit in another's place", "edition 1\nepisode e { tick: 0.05 m }\n"),
    ("a reversed range", "edition 1\nspawn s { distance: 30 m .. 7 m }\n"),
    ("a trailing comma", "edition 1\nspawn s { distance: 7 m .. 30 m, }\nreward r { on hit => max(1, 2,) }\n"),
    ("a forgotten comma", "edition 1\npolicy p = idm(limit_share: 1 margin: 1 m)\n"),
    ("a condition that is never met", "edition 1\nepisode e { end_when: 7 > 30 m }\n"),
    ("a reward that is a speed", "edition 1\nreward r { on hit => v_c }\n"),
    ("two dimensions in one formula", "edition 1\nreward r { on hit => max(3, 1.5 * v_c) }\n"),
    ("a map that is not there", "edition 1\ntown t = opendrive(file: \"Town99.xodr\")\n"),
    ("an equals sign for a colon", "edition 1\nepisode e { ticks = 600 }\n"),
    ("an emoji in a formula", "edition 1\nreward r { on hit => 1 🚗🚗 }\n"),
    ("a name with a letter beyond a to z", "edition 1\npolicy größe = idm()\n"),
    ("an import that is being typed", "edition 1\nimport \"lib/\nreward r { on hit => 1 }\n"),
    ("an import without its closing quote", "edition 1\nimport \"std/rewards.scn\n"),
    ("a model that is no network", "edition 1\npolicy p = onnx(model: \"odd.xodr\")\n"),
    ("a model that is not there", "edition 1\npolicy p = onnx(model: \"nowhere.onnx\")\n"),
    (
        "several mistakes at once",
        "edition 1\nrewrd r {}\nepisode e { tiks: 1.5  hold: 0 }\nspawn s { clearance: 2 s }\n",
    ),
];

fn drawn(text: &str) -> String {
    // An example on the page of mistakes imports itself under this name.
    let root = Path::new(if text.contains("import \"mistake.scn\"") { "mistake.scn" } else { "my.scn" });
    let maps = crate::repository().join("tests/suite/files");
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { std::fs::read_to_string(maps.join(path)) };
    let mut sources = Sources::default();
    let compiled = compile(&[root.to_path_buf()], &Catalog::builtin(), &read, &mut sources).unwrap();
    let said: Vec<String> = compiled.diagnostics.iter().map(|each| render(each, &sources, Colour::Never)).collect();
    if said.is_empty() { "no mistake".into() } else { said.join("\n\n") }
}

/// The number of diagnostics of a file, and the file after the first offered import is added.
fn mended(text: &str) -> (usize, String) {
    let root = Path::new("my.scn");
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { std::fs::read_to_string(path) };
    let mut sources = Sources::default();
    let compiled = compile(&[root.to_path_buf()], &Catalog::builtin(), &read, &mut sources).unwrap();
    let mut mended = text.to_string();
    if let Some(fix) = compiled.diagnostics.iter().flat_map(|each| &each.fixes).find(|fix| fix.text.contains("import"))
    {
        mended.replace_range(fix.span.start..fix.span.end, &fix.text);
    }
    (compiled.diagnostics.len(), mended)
}

#[test]
fn an_import_is_offered_where_it_can_stand() {
    let paper = "edition 1\nimport \"std/paper.scn\"\n";
    let spawn = "campaign c { spawn: ahead }\n";
    for (before, after) in [
        ("", "import \"std/paper.scn\"\n"),
        ("edition 1\n", paper),
        ("edition 1 // the first\n", "edition 1 // the first\nimport \"std/paper.scn\"\n"),
        ("edition 1 /* the\nfirst */\n", "edition 1\nimport \"std/paper.scn\" /* the\nfirst */\n"),
        (
            "edition 1\nimport idm from \"std/drivers.scn\" // drivers\n",
            "edition 1\nimport idm from \"std/drivers.scn\" // drivers\nimport \"std/paper.scn\"\n",
        ),
    ] {
        let text = format!("{before}{spawn}");
        let (told, mended) = mended(&text);
        assert_eq!(mended, format!("{after}{spawn}"));
        assert_eq!(self::mended(&mended).0, told - 1, "{mended}");
    }
}

#[test]
fn messages_look_as_they_did() {
    let mut page = String::new();
    let mut shown = 0;
    let short =
        |text: &str| !text.starts_with("falsify ") && !text.contains('…') && text.lines().all(|line| line.len() < 120);
    let all = mistakes();
    let coded = all.iter().filter(|mistake| short(mistake.bad)).map(|mistake| (mistake.code, mistake.bad));
    for (name, text) in TRAPS.iter().copied().chain(coded) {
        page.push_str(&format!("# {name}\n\n{text}\n{}\n\n\n", drawn(text)));
        shown += 1;
    }
    assert!(shown > 55, "{shown}");
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../suite");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!("messages", page));
}
