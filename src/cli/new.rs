use std::fs::File;
use std::io::{ErrorKind, Write};

use super::args::NewOptions;
use super::{ExitCode, front};

/// What a new scenario begins as.
const STARTER: &str = include_str!("starter.scn");

/// `falsify new`
pub fn new(options: &NewOptions) -> ExitCode {
    let path = &options.path;
    // Never over a file that is there.
    match File::create_new(path).and_then(|mut file| file.write_all(STARTER.as_bytes())) {
        Ok(()) => {
            front::say(&format!("{0} is written; next: falsify run {0}", path.display()));
            ExitCode::Done
        }
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            front::fail(&format!("`{}` is there already and was left alone", path.display()));
            ExitCode::Usage
        }
        Err(error) => {
            front::fail(&format!("cannot write `{}`: {error}", path.display()));
            ExitCode::WriteFailed
        }
    }
}
