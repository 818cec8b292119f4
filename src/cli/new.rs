use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use clap::Args;

use super::console;
use super::exit_code::ExitCode;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify new                                write scenario.scn
  falsify new night.scn && falsify run --smoke night.scn";

/// Options of `falsify new`.
#[derive(Debug, Args)]
pub struct NewOptions {
    /// The file; one that exists is never replaced.
    #[arg(default_value = "scenario.scn", value_name = "PATH")]
    pub path: PathBuf,
}

/// The text of a new scenario.
const STARTER: &str = include_str!("starter.scn");

/// `falsify new`
pub fn new(options: &NewOptions) -> ExitCode {
    let path = &options.path;
    // An existing file is never replaced.
    match File::create_new(path).and_then(|mut file| file.write_all(STARTER.as_bytes())) {
        Ok(()) => {
            console::say(&format!("{0} is written; next: falsify run {0}", path.display()));
            ExitCode::Done
        }
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            console::fail(&format!("`{}` is there already and was left alone", path.display()));
            ExitCode::Usage
        }
        Err(error) => {
            console::fail(&format!("cannot write `{}`: {error}", path.display()));
            ExitCode::WriteFailed
        }
    }
}
