//! `falsify.toml`: what it sets, what overrides it, and the messages about mistakes in it.

use std::path::Path;

use crate::program::{falsify, falsify_with, said};

fn folder_with(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("falsify.toml"), text).unwrap();
    folder
}

/// The line of a setting in the output of `falsify config`.
fn line<'a>(text: &'a str, key: &str) -> &'a str {
    text.lines().find(|line| line.starts_with(&format!("{key} = "))).unwrap_or_else(|| panic!("no `{key}` in\n{text}"))
}

#[test]
fn flags_come_before_the_environment_before_the_file_before_defaults() {
    let folder = folder_with("# ours\nseed = 5\nthreads = 2\nformats = [\"csv\"]\n");
    let variables = [("FALSIFY_SEED", "6"), ("FALSIFY_THREADS", "3")];
    let text = said(&falsify_with(&["config", "--seed", "7"], folder.path(), &variables));
    assert!(line(&text, "seed").ends_with("# --seed") && line(&text, "seed").starts_with("seed = 7 "), "{text}");
    assert!(line(&text, "threads").starts_with("threads = 3 ") && text.contains("# FALSIFY_THREADS"), "{text}");
    assert!(line(&text, "formats").starts_with("formats = [\"csv\"] "), "{text}");
    assert!(line(&text, "formats").ends_with("# falsify.toml, line 4"), "{text}");
    assert!(
        line(&text, "out").starts_with("out = \"reports\" ") && line(&text, "out").ends_with("# default"),
        "{text}"
    );
}

#[test]
fn what_config_prints_is_a_file_of_the_same_settings() {
    let folder = folder_with("out = \"a folder\"\nseed = 5\n");
    let printed = said(&falsify(&["config", "--formats", "parquet"], folder.path()));
    let other = folder_with(&printed);
    let again = said(&falsify(&["config"], other.path()));
    let settings = |text: &str| -> Vec<String> {
        text.lines()
            .map(|line| line.split('#').next().unwrap().trim().to_string())
            .filter(|line| !line.is_empty())
            .collect()
    };
    assert_eq!(settings(&printed), settings(&again));
    assert!(settings(&printed).len() >= 5, "{printed}");
}

#[test]
fn paths_are_meant_from_the_file_which_folders_below_see_too() {
    let folder = folder_with("out = \"results\"\n");
    let below = folder.path().join("a/b");
    std::fs::create_dir_all(&below).unwrap();
    let text = said(&falsify(&["config"], &below));
    let wanted = folder.path().canonicalize().unwrap().join("results");
    assert!(line(&text, "out").contains(&format!("\"{}\"", wanted.display())), "{text}");
    std::fs::write(below.join("falsify.toml"), "seed = 9\n").unwrap();
    let text = said(&falsify(&["config"], &below));
    assert!(
        line(&text, "out").ends_with("# default") && line(&text, "seed").starts_with("seed = 9 "),
        "the nearest: {text}"
    );
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
    let output = falsify(&["config"], folder.path());
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(error.contains("error[syntax]: this is no TOML") && error.contains("falsify.toml:1:"), "{error}");
}

#[test]
fn every_setting_is_explained() {
    let page =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/reference/settings.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for line in said(&falsify(&["config"], folder.path())).lines().skip(1) {
        let key = line.trim_start_matches("# ").split(' ').next().unwrap();
        assert!(page.contains(&format!("`{key}`")), "docs/src/reference/settings.md does not explain `{key}`");
    }
}
