//! The commands of the language: fmt, explain, new, check for programs, and the standard library inside the program.

use std::io::Write;
use std::path::Path;
use std::process::{Output, Stdio};

use serde_json::Value;

use crate::program::{command, falsify};

fn said(output: &Output) -> (String, String) {
    (String::from_utf8(output.stdout.clone()).unwrap(), String::from_utf8(output.stderr.clone()).unwrap())
}

#[test]
fn a_file_is_laid_out_in_place_and_one_with_mistakes_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("a.scn"), "edition 1 reward r{on touch=>1}").unwrap();
    std::fs::write(path("bad.scn"), "edition 1 reward r{on touch=>}").unwrap();
    let check = falsify(&["fmt", "--check", "a.scn"], folder.path());
    assert_eq!((check.status.code(), said(&check).0.as_str()), (Some(3), "a.scn\n"));
    assert_eq!(falsify(&["fmt", "a.scn"], folder.path()).status.code(), Some(0));
    assert_eq!(std::fs::read_to_string(path("a.scn")).unwrap(), "edition 1\nreward r { on touch => 1 }\n");
    assert_eq!(falsify(&["fmt", "--check", "a.scn"], folder.path()).status.code(), Some(0));
    let bad = falsify(&["fmt", "bad.scn", "a.scn"], folder.path());
    assert_eq!(bad.status.code(), Some(3));
    assert!(said(&bad).1.contains("error[syntax]") && said(&bad).1.contains("was left alone"));
    assert_eq!(std::fs::read_to_string(path("bad.scn")).unwrap(), "edition 1 reward r{on touch=>}");
    assert_eq!(falsify(&["fmt", "none.scn"], folder.path()).status.code(), Some(2));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing else is left behind");
}

#[test]
fn an_editor_can_lay_out_what_it_has() {
    let mut child = command().args(["fmt", "--stdin"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(b"edition 1\r\n\r\n\r\n\r\nreward r{on touch=>1}").unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(said(&output).0, "edition 1\n\nreward r { on touch => 1 }\n");
}

#[test]
fn a_new_file_checks_runs_and_is_never_written_over_another() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(falsify(&["new", "a.scn"], folder.path()).status.code(), Some(0));
    let check = falsify(&["check", "a.scn"], folder.path());
    assert_eq!(check.status.code(), Some(0));
    assert!(said(&check).1.is_empty(), "{check:?}");
    let run = falsify(&["run", "--smoke", "a.scn"], folder.path());
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let manifest = std::fs::read_to_string(folder.path().join("reports/crossing-smoke/manifest.toml")).unwrap();
    assert!(manifest.contains("<std>/towns.scn"), "the manifest names what came out of the program: {manifest}");
    std::fs::write(folder.path().join("a.scn"), "mine").unwrap();
    assert_eq!(falsify(&["new", "a.scn"], folder.path()).status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(folder.path().join("a.scn")).unwrap(), "mine");
    assert_eq!(falsify(&["new", "no/such/folder/a.scn"], folder.path()).status.code(), Some(2));
}

#[test]
fn a_file_of_ones_own_goes_before_the_librarys() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), "edition 1\nimport \"std/towns.scn\"\nimport \"std/nothing.scn\"\n")
        .unwrap();
    let output = falsify(&["check", "a.scn"], folder.path());
    assert_eq!(output.status.code(), Some(3));
    assert!(said(&output).1.contains("the standard library holds `std/carla_towns.scn`"), "{output:?}");
    std::fs::create_dir(folder.path().join("std")).unwrap();
    std::fs::write(folder.path().join("std/towns.scn"), "edition 1\nrewrd\n").unwrap();
    let output = falsify(&["check", "a.scn"], folder.path());
    assert!(said(&output).1.contains("std/towns.scn:2"), "{output:?}");
}

#[test]
fn mistakes_are_told_to_programs() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("a b.scn"),
        "edition 1\n/* é */ rewrd a {}\nreward r { on touch => max(3, v_c) }\n",
    )
    .unwrap();
    let output = falsify(&["check", "--format", "json", "a b.scn"], folder.path());
    assert_eq!(output.status.code(), Some(3));
    assert!(said(&output).1.is_empty());
    let lines: Vec<Value> = said(&output).0.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 2);
    let first = &lines[0];
    assert_eq!(first["code"], "unknown-form");
    assert_eq!(first["file"], "a b.scn");
    assert_eq!((&first["line"], &first["column"], &first["end_column"]), (&2.into(), &9.into(), &14.into()));
    assert_eq!((&first["byte_start"], &first["byte_end"]), (&19.into(), &24.into()));
    assert_eq!(first["fixes"][0]["text"], "reward");
    assert_eq!(lines[1]["labels"][0]["text"], "this is a plain number");
    assert!(lines[1]["help"][0].as_str().unwrap().contains("in m/s"));
}

const CROWDED: &str = "edition 1
import \"std/paper.scn\"
import \"std/drivers.scn\"
import harbour, village from \"std/towns.scn\"
param least: angle = 1 deg
spawn there { require: [facing > least and facing < 1.01 deg] }
campaign c {
  vehicle: model3 body: suicidal spawn: there episode: thirty_seconds training: ppo_paper
  train { towns: [harbour] drivers: [behavior] rewards: [r1] runs: 1 }
}
";

#[test]
fn starts_are_sampled_for_programs_too_and_where_no_pedestrian_can_be_placed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), CROWDED).unwrap();
    let wide = ["--set", "least=-100 deg", "--sample", "50", "a.scn"];
    let output = falsify(&[&["check", "--format", "json"], &wide[..]].concat(), folder.path());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let sample: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&sample["campaign"], &sample["spawn"], &sample["town"]),
        (&"c".into(), &"there".into(), &"harbour".into())
    );
    assert_eq!((&sample["tried"], sample["constraints"].as_array().unwrap().len()), (&50.into(), 2));
    assert!(
        sample["accepted"].as_u64().unwrap() > 5 && folder.path().join(sample["picture"].as_str().unwrap()).exists()
    );
    // No start can be placed. This is an error, and the picture shows the cause.
    let output = falsify(&["check", "--sample", "50", "a.scn"], folder.path());
    let (text, errors) = said(&output);
    assert_eq!(output.status.code(), Some(3));
    assert!(errors.contains("error[unplaceable]") && errors.contains("1 error found"), "{errors}");
    assert!(text.contains("there in harbour: ") && text.contains("%  require: facing"), "{text}");
    let output = falsify(&["check", "--format", "json", "--sample", "50", "a.scn"], folder.path());
    let lines: Vec<Value> = said(&output).0.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(
        (output.status.code(), &lines[0]["code"], &lines[1]["tried"]),
        (Some(3), &"unplaceable".into(), &50.into())
    );
}

#[test]
fn towns_are_shown_where_no_pedestrian_can_be_placed_and_what_is_given_outside_is_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), CROWDED).unwrap();
    let output = falsify(&["preview", "a.scn", "--once"], folder.path());
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let page = std::fs::read_to_string(folder.path().join("a.preview.html")).unwrap();
    assert!(page.contains("harbour") && page.contains("<svg"), "the town of the campaign is drawn");
    let shown = |setting: &str| falsify(&["check", "--set", setting, "a.scn"], folder.path()).status.code();
    assert_eq!(shown("nobody=1"), Some(3));
}

#[test]
fn explanations_are_printed() {
    let folder = tempfile::tempdir().unwrap();
    let output = falsify(&["explain", "driver", "idm", "margin"], folder.path());
    assert!(said(&output).0.contains("default `0.5 m`"), "{output:?}");
    for (word, text) in [("std/pedestrians.scn", "It declares `plausible`"), ("judge", "`falsify judge --help`")] {
        assert!(said(&falsify(&["explain", word], folder.path())).0.contains(text), "{word}");
    }
    let output = falsify(&["explain", "drivr"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).1.contains("did you mean `driver`?"));
}

#[test]
fn every_command_shows_examples_and_is_completed() {
    let folder = tempfile::tempdir().unwrap();
    let script = said(&falsify(&["completions", "bash"], folder.path())).0;
    for command in ["run", "check", "fmt", "explain", "new", "lsp", "preview", "merge", "status", "completions"] {
        let (help, _) = said(&falsify(&[command, "--help"], folder.path()));
        assert!(help.contains("Examples") && help.contains(&format!("falsify {command}")), "{command}: {help}");
        assert!(
            script.contains(&format!("falsify__subcmd__{command}")) || script.contains(&format!("falsify__{command}")),
            "{command}"
        );
    }
}

#[test]
fn the_library_inside_the_program_holds_every_file_of_the_folder() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/lib");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".scn"))
        .collect();
    files.sort();
    assert_eq!(lang::library::names().collect::<Vec<_>>(), files);
}
