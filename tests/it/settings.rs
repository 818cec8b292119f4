//! `falsify.toml`: what it sets, what overrides it, and the messages about mistakes in it.

use std::path::Path;

use crate::program::{falsify, falsify_with};

fn folder_with(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("falsify.toml"), text).unwrap();
    folder
}

const CAMPAIGN: &str = r#"edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
campaign c {
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour]  policies: [blind]  pedestrians: [random]  episodes: 1 }
}
"#;

/// The manifest of a smoke run with these options and variables.
fn manifest(folder: &Path, options: &[&str], variables: &[(&str, &str)]) -> String {
    std::fs::write(folder.join("c.scn"), CAMPAIGN).unwrap();
    let output = falsify_with(&[&["run", "--smoke", "c.scn"], options].concat(), folder, variables);
    assert!(output.status.success(), "{output:?}");
    std::fs::read_to_string(folder.join("out/c-smoke/manifest.toml")).unwrap()
}

#[test]
fn flags_precede_the_environment_which_precedes_the_file() {
    let folder = folder_with("# ours\nseed = 5\nout = \"out\"\nformats = [\"csv\"]\n");
    assert!(manifest(folder.path(), &[], &[]).contains("seed = 5\n"));
    let variables = [("FALSIFY_SEED", "6")];
    assert!(manifest(folder.path(), &[], &variables).contains("seed = 6\n"));
    assert!(manifest(folder.path(), &["--seed", "7"], &variables).contains("seed = 7\n"));
    assert!(!folder.path().join("out/c-smoke/episodes.parquet").exists(), "the file names one format");
}

#[test]
fn paths_are_relative_to_the_file_and_the_nearest_file_counts() {
    let folder = folder_with("out = \"out\"\n");
    let below = folder.path().join("a/b");
    std::fs::create_dir_all(&below).unwrap();
    std::fs::write(below.join("c.scn"), CAMPAIGN).unwrap();
    assert!(falsify(&["run", "--smoke", "c.scn"], &below).status.success());
    assert!(folder.path().join("out/c-smoke/manifest.toml").exists());
    std::fs::write(below.join("falsify.toml"), "seed = 9\n").unwrap();
    assert!(falsify(&["run", "--smoke", "c.scn"], &below).status.success());
    let manifest = std::fs::read_to_string(below.join("reports/c-smoke/manifest.toml")).unwrap();
    assert!(manifest.contains("seed = 9\n"), "{manifest}");
}

#[test]
fn mistakes_are_drawn_all_at_once_and_only_where_settings_matter() {
    let folder = folder_with("thread = 2\nseed = -1\nformats = [\"xls\"]\nout = 1979-05-27\n[limits]\nticks = 3\n");
    let output = falsify(&["run", "x.scn"], folder.path());
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    for part in [
        "error[unknown-key]: there is no setting `thread`",
        "did you mean `threads`?",
        "error[out-of-range]: `seed` cannot be set to this",
        "this can be `csv`, `parquet`",
        "error[wrong-type]: `out` cannot be set to this",
        "there is no setting `limits`",
    ] {
        assert!(error.contains(part), "`{part}` is not in\n{error}");
    }
    assert_eq!(falsify(&["explain", "unknown-key"], folder.path()).status.code(), Some(0));
}

#[test]
fn what_is_no_toml_is_shown_where_it_breaks() {
    let folder = folder_with("seed = = 3\n");
    let output = falsify(&["run", "x.scn"], folder.path());
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(error.contains("error[syntax]: this is not TOML") && error.contains("falsify.toml:1:"), "{error}");
}
