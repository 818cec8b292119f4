//! Manual pages, made from the same definitions as `--help`.

use std::path::PathBuf;

use clap::{Args, CommandFactory};

use super::Arguments;
use crate::cli::console;
use crate::cli::exit_code::{Ended, ExitCode};
use crate::cli::failure::unwritten;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify manual --out ~/.local/share/man/man1
  man falsify-run";

/// Options of `falsify manual`.
#[derive(Debug, Args)]
pub struct ManualArgs {
    /// Folder for the pages, one for each command: `falsify.1`, `falsify-run.1` and so on.
    #[arg(long, short, default_value = ".", value_name = "DIR")]
    pub out: PathBuf,
}

/// `falsify manual`
pub fn manual(options: &ManualArgs) -> Ended {
    let folder = &options.out;
    let written = std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(Arguments::command(), folder));
    written.map_err(|error| unwritten(format!("cannot write manual pages to `{}`: {error}", folder.display())))?;
    console::say(&format!("manual pages are in {}", folder.display()));
    Ok(ExitCode::Done)
}
