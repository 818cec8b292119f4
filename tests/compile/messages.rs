//! What mistakes look like on the screen: short scenarios with all messages about them, each compared with a file of `tests/suite/messages`.
//!
//! `INSTA_UPDATE=always` writes the files again; then read the difference.

use std::collections::BTreeSet;
use std::path::Path;

use base::diagnostic::{Colour, Sources, render};
use compile::{Catalog, compile};
use lang::error_index::mistakes;

/// Mistakes beside those on the page of mistakes.
const OTHERS: &[(&str, &str)] = &[
    ("an unknown property", "edition 1\nspawn s { with_wind: 5 }\n"),
    ("an undeclared parameter", "edition 1\nparam far: length = 30 m\nspawn s { distance: 7 m .. fra }\n"),
    ("a forgotten comma", "edition 1\ndriver p = idm(limit_share: 1 margin: 1 m)\n"),
    ("a forgotten value", "edition 1\nspawn s { distance: 7 m ..\n  clearance: 1 m }\n"),
    ("an emoji in a formula", "edition 1\nreward r { on touch => 1 🚗🚗 }\n"),
    ("an import that is being typed", "edition 1\nimport \"lib/\nreward r { on touch => 1 }\n"),
    ("a model that is not there", "edition 1\ndriver p = onnx(model: \"nowhere.onnx\")\n"),
    ("curly quotes", "edition 1\nimport “std/drivers.scn”\n"),
    ("a long dash", "edition 1\nspawn s { bearing: −60 deg .. 60 deg }\n"),
    (
        "decimal commas",
        "edition 1\nspawn s { distance: 7,5 m .. 40 m }\ndriver p = idm(margin: 0,5 m)\nparam s: number = 0,2\n",
    ),
    ("numbers with commas", "edition 1\ntraining t = ppo(steps: 40,000)\n"),
    ("names of stable-baselines3", "edition 1\ntraining t = ppo(n_steps: 64, clip_range: 0.2, vf_coef: 0.5)\n"),
    ("a name that is cut off", "edition 1\nreward hit { on touch => 1 }\nmethod m = cma(reward: hit)\n"),
    (
        "bearings beyond half a turn",
        "edition 1\nspawn s { bearing: 170 deg .. 190 deg }\nspawn r { bearing: 0 deg .. 360 deg }\n",
    ),
    ("a range of most directions", "edition 1\nspawn s { bearing: 60 deg .. -60 deg }\n"),
    ("a text with an escape", "edition 1\ndriver p = external(command: \"python3 \\\"my av.py\\\"\")\n"),
    ("a typo beside the key that it resembles", "edition 1\ndriver p = idm(time_hedway: 1 s, time_headway: 2 s)\n"),
    ("two typos of one key", "edition 1\ndriver p = idm(time_hedway: 1 s, time_headwy: 2 s)\n"),
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

/// Pedestrians behind the car: each half of the range has its share of the draws.
#[test]
fn a_range_of_bearings_may_go_across_180_degrees() {
    let text = "edition 1\nspawn s { bearing: 170 deg .. -160 deg }\nspawn r { bearing: 180 deg .. -170 deg }\n";
    assert_eq!(drawn(text), "no mistake");
}

#[test]
fn an_import_is_offered_where_it_can_stand() {
    let ahead = "import ahead from \"std/paper.scn\"\n";
    let spawn = "campaign c { spawn: ahead }\n";
    for (before, after) in [
        ("", ahead.to_string()),
        ("edition 1\n", format!("edition 1\n{ahead}")),
        ("edition 1 // the first\n", format!("edition 1 // the first\n{ahead}")),
        (
            "edition 1\nimport idm from \"std/drivers.scn\"\n",
            format!("edition 1\nimport idm from \"std/drivers.scn\"\n{ahead}"),
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
    let short =
        |text: &str| !text.starts_with("falsify ") && !text.contains('…') && text.lines().all(|line| line.len() < 120);
    let all = mistakes();
    let coded = all.iter().filter(|mistake| short(mistake.bad)).map(|mistake| (mistake.code, mistake.bad));
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../suite/messages");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    let mut shown = BTreeSet::new();
    for (name, text) in OTHERS.iter().copied().chain(coded) {
        let name = name.replace(' ', "_");
        settings.bind(|| insta::assert_snapshot!(name.as_str(), drawn(text)));
        assert!(shown.insert(name.clone()), "{name} is shown twice");
    }
    assert!(shown.len() > 50, "{}", shown.len());
    let files = std::fs::read_dir(crate::repository().join("tests/suite/messages")).unwrap();
    let files = files.map(|file| file.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned());
    assert_eq!(files.collect::<BTreeSet<_>>(), shown, "each file is compared");
}
