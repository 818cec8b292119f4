//! The program as a user starts it.

use std::path::Path;
use std::process::{Command, Output};

/// Runs `falsify` in a folder, whatever the settings of whoever runs the tests.
pub fn falsify(arguments: &[&str], folder: &Path) -> Output {
    falsify_with(arguments, folder, &[])
}

/// The same with variables of the environment.
pub fn falsify_with(arguments: &[&str], folder: &Path, variables: &[(&str, &str)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_falsify"));
    command.args(arguments).current_dir(folder);
    for name in ["OUT", "CACHE", "THREADS", "SEED", "FORMATS", "FORMAT", "PROGRESS"] {
        command.env_remove(format!("FALSIFY_{name}"));
    }
    command.envs(variables.iter().copied()).output().unwrap()
}
