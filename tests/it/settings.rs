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
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [random]  episodes: 1 }
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

/// A requirement that decides before the end of an episode, and two on whose bound a sample lies.
const REQUIRED: &str = r#"edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/towns.scn"
requirement pulse = always(elapsed < 1 s or elapsed > 1.2 s, [0 s, 3 s])
requirement tie_3 = always(elapsed <= 0.15 s, [0 s, 0.15 s])
requirement tie_2 = always(elapsed <= 0.1 s, [0 s, 0.1 s])
spawn near { bearing: -60 deg .. 60 deg  distance: 60 m .. 90 m  ego_speed: 3 m/s }
episode short { ticks: 80  hold: 10 }
campaign c {
  vehicle: model3  body: plausible  spawn: near  episode: short
  requirements: [pulse, tie_3, tie_2]
  evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [random]  episodes: 2 }
}
"#;

#[test]
fn violations_have_the_length_of_their_episode_and_samples_the_times_of_their_ticks() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("c.scn"), REQUIRED).unwrap();
    assert!(falsify(&["run", "c.scn"], folder.path()).status.success());
    let list = |name: &str| {
        let words = ["failures", "reports/c", "--requirement", name, "--format", "csv"];
        String::from_utf8(falsify(&words, folder.path()).stdout).unwrap()
    };
    let found = list("pulse");
    let mut rows = found.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let place = rows.next().unwrap().iter().position(|name| *name == "episode_length_s").unwrap();
    let lengths: Vec<_> = rows.map(|row| row[place].to_owned()).collect();
    assert_eq!(lengths, ["4.0", "4.0"], "{found}");
    for name in ["tie_3", "tie_2"] {
        assert!(list(name).lines().count() <= 1, "{}", list(name));
    }
}

#[test]
fn nothing_advises_to_read_a_report_without_parquet() {
    let folder = folder_with("formats = [\"csv\"]\n");
    std::fs::write(folder.path().join("c.scn"), CAMPAIGN.replace("episodes: 1", "episodes: 60")).unwrap();
    let output = falsify(&["run", "c.scn"], folder.path());
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("the tables are CSV only"), "{said}");
    for name in ["report.html", "summary.md"] {
        let page = std::fs::read_to_string(folder.path().join("reports/c").join(name)).unwrap();
        assert!(!page.contains("falsify replay"), "{name}");
    }
    for words in [["failures", "reports/c", "--top=1"], ["replay", "--all", "reports/c"]] {
        let output = falsify(&words, folder.path());
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(String::from_utf8(output.stderr).unwrap().contains("there is no `reports/c/episodes.parquet`"));
    }
}
