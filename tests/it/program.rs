//! The program as a user starts it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program, without the settings of the environment that the tests run in.
pub fn command() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_falsify"));
    for name in ["OUT", "CACHE", "THREADS", "SEED", "FORMATS", "FORMAT", "PROGRESS"] {
        command.env_remove(format!("FALSIFY_{name}"));
    }
    command
}

/// Runs `falsify` in a folder.
pub fn falsify(arguments: &[&str], folder: &Path) -> Output {
    falsify_with(arguments, folder, &[])
}

/// The same with variables of the environment.
pub fn falsify_with(arguments: &[&str], folder: &Path, variables: &[(&str, &str)]) -> Output {
    command().args(arguments).current_dir(folder).envs(variables.iter().copied()).output().unwrap()
}

/// The text on the error stream.
pub fn error(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The text on the standard output.
pub fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The files below a folder. A manifest is reduced to what does not vary from run to run.
pub fn report(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let (mut open, mut files) = (vec![folder.to_path_buf()], BTreeMap::new());
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(&next).unwrap_or_else(|error| panic!("{}: {error}", next.display())) {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
                continue;
            }
            let mut bytes = std::fs::read(&path).unwrap();
            if path.ends_with("manifest.toml") {
                let text = String::from_utf8(bytes).unwrap();
                let timeless =
                    |line: &&str| !["wall_time_s", "threads", "# BLAKE3"].iter().any(|word| line.starts_with(word));
                bytes = text.lines().filter(timeless).collect::<Vec<_>>().join("\n").into_bytes();
            }
            files.insert(path.strip_prefix(folder).unwrap().to_path_buf(), bytes);
        }
    }
    files
}
