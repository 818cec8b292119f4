//! What a new user meets: the demonstration and the templates of `falsify new`.

use std::path::Path;

use needs::needs;

use crate::program::{command, error, falsify, said};
use crate::shipped::shipped;

/// The names of the templates, from the help of `falsify new`.
fn templates() -> Vec<String> {
    let help = said(&command().args(["new", "--help"]).output().unwrap());
    let (_, list) = help.split_once("--template <NAME>").unwrap();
    let listed = list
        .split("--color")
        .next()
        .unwrap()
        .lines()
        .filter_map(|line| line.trim().strip_prefix("- ")?.split(':').next());
    listed.map(str::to_string).collect()
}

/// Writes a template, checks it and returns the words of the command that runs it.
fn checked(name: &str, folder: &Path) -> Vec<String> {
    let written = falsify(&["new", "my.scn", "--template", name], folder);
    assert!(written.status.success(), "{name}: {written:?}");
    let text = said(&written);
    let next = text.lines().last().unwrap().strip_prefix("next: falsify ").unwrap();
    let checked = falsify(&["check", "--allow-external", "my.scn"], folder);
    assert!(checked.status.success() && checked.stderr.is_empty(), "{name}: {checked:?}");
    next.split(' ').chain(["--smoke"]).map(str::to_string).collect()
}

fn survives(name: &str, words: &[String], folder: &Path) {
    let run = command().args(words).current_dir(folder).output().unwrap();
    assert!(run.status.success(), "{name}: {}", error(&run));
    assert!(said(&run).contains("report.html"), "{name}");
}

#[test]
fn every_template_checks_and_survives_a_smoke_run() {
    let names = templates();
    let files = shipped("src/program/commands/templates");
    let stems: Vec<String> = files
        .iter()
        .map(|file| file.file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|name| name != "demo")
        .collect();
    let mut sorted = names.clone();
    sorted.sort();
    assert_eq!(sorted, stems, "each template has a file and each file is a template");
    // It needs Python, which makes it the slowest by far.
    for name in names.iter().filter(|name| *name != "own-driver") {
        let folder = tempfile::tempdir().unwrap();
        survives(name, &checked(name, folder.path()), folder.path());
    }
}

#[needs(python)]
#[test]
fn the_template_of_an_own_driver_checks() {
    checked("own-driver", tempfile::tempdir().unwrap().path());
}

#[test]
#[ignore = "a large sample, which `.ci/run` takes"]
fn the_template_of_an_own_driver_survives_a_smoke_run() {
    let folder = tempfile::tempdir().unwrap();
    survives("own-driver", &checked("own-driver", folder.path()), folder.path());
}

#[test]
fn a_template_replaces_no_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my_av.py"), "mine").unwrap();
    let written = falsify(&["new", "--template", "own-driver"], folder.path());
    assert!(written.status.success() && error(&written).contains("`my_av.py` exists already"), "{written:?}");
    assert_eq!(std::fs::read_to_string(folder.path().join("my_av.py")).unwrap(), "mine");
    let again = falsify(&["new"], folder.path());
    assert_eq!(again.status.code(), Some(2));
    assert!(error(&again).contains("`scenario.scn` exists already and was left alone"), "{again:?}");
    assert!(std::fs::read_to_string(folder.path().join("scenario.scn")).unwrap().contains("python3 my_av.py"));
}

#[test]
fn the_demonstration_needs_no_file_and_can_be_repeated() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let output = falsify(&["demo", "--smoke"], folder.path());
        assert!(output.status.success(), "{}", error(&output));
        let text = said(&output);
        let page = Path::new("falsify-demo/demo-smoke/report.html");
        assert!(text.contains(&format!("open {}", page.display())), "{text}");
        assert!(folder.path().join(page).exists());
    }
    // A file of the user at this place is not replaced.
    std::fs::write(folder.path().join("falsify-demo/demo.scn"), "mine").unwrap();
    let output = falsify(&["demo", "--smoke"], folder.path());
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert_eq!(std::fs::read_to_string(folder.path().join("falsify-demo/demo.scn")).unwrap(), "mine");
}
