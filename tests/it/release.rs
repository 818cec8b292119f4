//! The files of a release: an archive holds a program that runs, its checksum is right, and the extension of the editor has the grammar.

use std::path::Path;
use std::process::Command;

use needs::needs;
use serde_json::Value;

use crate::program::said;

fn repository(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

#[cfg(target_os = "linux")]
#[needs(python)]
#[test]
fn an_archive_holds_a_program_that_runs() {
    let out = tempfile::tempdir().unwrap();
    let packed = Command::new("sh")
        .arg(repository(".ci/release"))
        .args(["pack", env!("CARGO_BIN_EXE_falsify"), "x86_64-unknown-linux-gnu"])
        .arg(out.path())
        .env("COMPRESSION", "1")
        .output()
        .unwrap();
    assert!(packed.status.success(), "{packed:?}");
    let name = format!("falsify-{}-x86_64-unknown-linux-gnu", env!("CARGO_PKG_VERSION"));
    let in_folder = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).current_dir(out.path()).output().unwrap();
        assert!(output.status.success(), "{program} {arguments:?}: {output:?}");
        said(&output)
    };
    assert_eq!(in_folder("sha256sum", &["--check", "SHA256SUMS"]), format!("{name}.tar.gz: OK\n"));
    in_folder("tar", &["-xzf", &format!("{name}.tar.gz")]);
    for file in [
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "LICENSE-DEPENDENCIES.txt",
        "LICENSE-RUST-LIBRARY.html",
        "README.md",
        "completions/_falsify",
        "completions/falsify.bash",
        "completions/falsify.fish",
        "scenarios/first_look.scn",
    ] {
        assert!(std::fs::metadata(out.path().join(&name).join(file)).is_ok_and(|data| data.len() > 100), "{file}");
    }
    let program = out.path().join(&name).join("falsify");
    let version = in_folder(program.to_str().unwrap(), &["--version"]);
    assert_eq!(version.trim(), concat!("falsify ", env!("CARGO_PKG_VERSION")));
    in_folder(program.to_str().unwrap(), &["check", &format!("{name}/scenarios/first_look.scn")]);
}

#[test]
fn a_release_of_changed_files_is_refused_and_the_usage_is_shown() {
    let usage = Command::new("sh").arg(repository(".ci/release")).output().unwrap();
    assert_eq!(usage.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&usage.stderr).contains(".ci/release pack BINARY TARGET OUT"));
    let workflow = std::fs::read_to_string(repository(".github/workflows/release.yml")).unwrap();
    assert!(workflow.contains("run: .ci/release build "), "the hosted workflow calls the script");
}

#[needs(program = "node")]
#[test]
fn the_extension_starts_the_language_server_and_reports_a_missing_program() {
    let output = Command::new("node")
        .arg(repository("tests/external/extension.js"))
        .arg(repository("grammar/vscode/extension.js"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = said(&output);
    let (started, message) = text.split_once('\n').unwrap();
    let started: Value = serde_json::from_str(started).unwrap();
    assert_eq!(started["server"], serde_json::json!({ "command": "falsify", "args": ["lsp"] }));
    assert_eq!(started["client"]["documentSelector"][0]["language"], "falsify");
    assert!(message.contains("cannot start `falsify lsp`: no such program"), "{message}");
}
