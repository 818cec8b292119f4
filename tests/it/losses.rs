//! No file of a user is lost, and no damaged one is trusted: repairs leave other files and comments alone, and changed tables or manifests of a
//! report are reported.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::program::{error, falsify, said};

/// A campaign that takes a moment, with an evaluation and a search.
const SCENARIO: &str = r#"edition 1
import "std/paper.scn"
import "std/rewards.scn"
import "std/drivers.scn"
import "std/towns.scn"
method meet = intercept()
campaign small {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [village]  drivers: [blind]  pedestrians: [random, intercept]  episodes: 12 }
  search { towns: [village]  drivers: [blind]  methods: [meet]  budget: 3_000  runs: 1 }
}
"#;

/// A folder with the report `out/small`.
fn report() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("small.scn"), SCENARIO).unwrap();
    let ran = falsify(&["run", "small.scn", "--out", "out", "--threads", "1"], place.path());
    assert!(ran.status.success(), "{ran:?}");
    place
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
fn repairs_keep_comments_and_leave_other_files_alone() {
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name);
    fs::write(path("a.scn"), "// why\n\n// licence\nimport \"std/towns.scn\"\n").unwrap();
    fs::write(path("b.scn"), "edition 1\nspwan s { } // why\n").unwrap();
    falsify(&["check", "--fix", "a.scn", "b.scn"], place.path());
    assert_eq!(
        fs::read_to_string(path("a.scn")).unwrap(),
        "edition 1\n// why\n\n// licence\nimport \"std/towns.scn\"\n"
    );
    assert_eq!(fs::read_to_string(path("b.scn")).unwrap(), "edition 1\nspawn s { } // why\n");
    let program = "# A driver.\nimport sys\nif a || b { x = 5 % 2 }\ndriver p = $PATH\n";
    fs::write(path("driver.py"), program).unwrap();
    let refused = falsify(&["check", "--fix", "driver.py"], place.path());
    assert_eq!(refused.status.code(), Some(3));
    assert!(error(&refused).contains("driver.py was left alone: "), "{}", error(&refused));
    assert_eq!(fs::read_to_string(path("driver.py")).unwrap(), program);
    let later = "edition 2\nspawn s { distance: 7 .. 30 m }\n";
    fs::write(path("later.scn"), later).unwrap();
    let refused = falsify(&["check", "--fix", "later.scn"], place.path());
    assert!(error(&refused).contains("later.scn was left alone: this program does not know its edition"));
    assert_eq!(fs::read_to_string(path("later.scn")).unwrap(), later);
    fs::write(path("fixed.scn"), "episode e { }\n").unwrap();
    fs::set_permissions(path("fixed.scn"), fs::Permissions::from_mode(0o444)).unwrap();
    let refused = falsify(&["check", "--fix", "fixed.scn"], place.path());
    assert_eq!(refused.status.code(), Some(6), "{refused:?}");
    assert_eq!(fs::read_to_string(path("fixed.scn")).unwrap(), "episode e { }\n");
}

#[test]
fn a_gate_does_not_pass_for_want_of_a_table() {
    let place = report();
    let (whole, lost) = (place.path().join("out/small"), place.path().join("lost"));
    for table in ["episodes", "failures", "searches"] {
        let _ = fs::remove_dir_all(&lost);
        copy(&whole, &lost);
        for ending in ["csv", "parquet"] {
            fs::remove_file(lost.join(format!("{table}.{ending}"))).unwrap();
        }
        let gate = ["compare", "out/small", "lost", "--fail-if", "fault_starts_new > 0"];
        let compared = falsify(&gate, place.path());
        assert_eq!(compared.status.code(), Some(2), "{table}: {compared:?}");
        assert!(error(&compared).contains("which the report had when it was written"), "{}", error(&compared));
        assert_eq!(falsify(&["failures", "lost"], place.path()).status.code(), Some(2), "{table}");
    }
}

#[test]
fn changed_tables_are_not_read_and_a_changed_manifest_is_reported() {
    let place = report();
    let (whole, other) = (place.path().join("out/small"), place.path().join("other"));
    assert!(falsify(&["replay", "--all", "out/small"], place.path()).status.success());
    copy(&whole, &other);
    let copied = falsify(&["compare", "out/small", "other", "--fail-if", "fault_rate_p_holm < 0.05"], place.path());
    assert!(copied.status.code() == Some(2) && error(&copied).contains("which show nothing"), "{copied:?}");
    let table = other.join("episodes.parquet");
    let mut bytes = fs::read(&table).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&table, bytes).unwrap();
    let name = said(&falsify(&["failures", "--names", "--top", "1", "out/small"], place.path()));
    let name = name.trim().rsplit('/').next().unwrap().to_owned();
    for arguments in [
        vec!["failures", "other"],
        vec!["compare", "out/small", "other"],
        vec!["replay", &name, "--report", "other"],
        vec!["export", "--as", "animation", &name, "--report", "other"],
    ] {
        let output = falsify(&arguments, place.path());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {output:?}");
        assert!(error(&output).contains("is not as it was written"), "{}", error(&output));
    }
    let _ = fs::remove_dir_all(&other);
    copy(&whole, &other);
    let manifest = fs::read_to_string(other.join("manifest.toml")).unwrap();
    let cut = manifest.find("[[report_files]]").unwrap();
    for text in
        [&manifest[..cut], &manifest.replace("wall_time_s = ", "wall_time_s = 1"), &format!("{manifest}# more\n")]
    {
        fs::write(other.join("manifest.toml"), text).unwrap();
        let output = falsify(&["replay", "--all", "other"], place.path());
        assert_eq!(output.status.code(), Some(8), "{output:?}");
        let text = format!("{}{}", error(&output), said(&output));
        assert_eq!(text.matches("is not as it was written").count(), 1, "{text}");
        assert!(text.contains("`manifest.toml` is not as it was written"), "{text}");
    }
}

#[test]
fn links_lead_neither_out_of_a_report_nor_out_of_the_folder_that_is_named() {
    let place = report();
    let here = place.path();
    fs::write(here.join("secret"), "a line that nobody should quote\n").unwrap();
    let (whole, other) = (here.join("out/small"), here.join("other"));
    copy(&whole, &other);
    fs::remove_file(other.join("scenario/small.scn")).unwrap();
    std::os::unix::fs::symlink(here.join("secret"), other.join("scenario/small.scn")).unwrap();
    fs::remove_file(here.join("small.scn")).unwrap();
    let output = falsify(&["replay", "--anyway", "--all", "other"], here);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(error(&output).contains("`other/scenario/small.scn` is a link"), "{}", error(&output));
    assert!(!error(&output).contains("nobody should quote"), "{}", error(&output));

    std::os::unix::fs::symlink(here.join("secret"), here.join("page.html")).unwrap();
    let onto = falsify(&["compare", "out/small", "out/small", "--page", "out/small/results.csv"], here);
    assert!(onto.status.code() == Some(6) && error(&onto).contains("a file of the report"), "{onto:?}");
    let output = falsify(&["compare", "out/small", "out/small", "--page", "page.html"], here);
    assert_eq!(output.status.code(), Some(6), "{output:?}");
    assert!(error(&output).contains("it is a link to `"), "{}", error(&output));
    assert!(here.join("page.html").is_symlink());
    assert!(fs::read_to_string(here.join("secret")).unwrap().starts_with("a line"));
}

#[test]
fn names_do_not_command_the_terminal() {
    let place = tempfile::tempdir().unwrap();
    let name = "a\u{1b}]0;title\u{7}\u{9b}31m\u{202e}.scn";
    fs::write(place.path().join(name), "edition 1\nspwan s {}\n").unwrap();
    for arguments in [["check", name], ["run", name]] {
        let output = falsify(&arguments, place.path());
        let text = error(&output) + &said(&output);
        assert!(!text.contains(['\u{1b}', '\u{7}', '\u{9b}', '\u{202e}']), "{text:?}");
        assert!(text.contains("spwan"), "{text}");
    }
}

#[test]
fn programs_get_a_bounded_list_of_mistakes() {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("a.scn"), "edition 1\n".repeat(3_000)).unwrap();
    let output = falsify(&["check", "--format", "json", "a.scn"], place.path());
    assert_eq!((output.status.code(), said(&output).lines().count()), (Some(3), 1_000));
    assert!(error(&output).contains("the first 1000 of 2999 mistakes are listed"), "{}", error(&output));
}
