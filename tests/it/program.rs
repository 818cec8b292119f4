//! The program as a user starts it.

use std::path::Path;
use std::process::{Command, Output};

/// Runs `falsify` in a folder, whatever the settings of whoever runs the tests.
pub fn falsify(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_falsify"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("FALSIFY_OUT")
        .env_remove("FALSIFY_THREADS")
        .output()
        .unwrap()
}
