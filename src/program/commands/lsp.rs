use std::path::PathBuf;

use crate::cli::failure::misused;
use crate::cli::input::catalog;
use crate::exit_code::{Ended, ExitCode};
use crate::lsp::{Ending, serve};

pub const EXAMPLES: &str = "\
Examples (see docs/src/how-to/editor.md for editors' settings):
  falsify lsp                                an editor starts it and speaks to it";

/// The user's cache folder, for data that can be made again.
///
/// # Source
/// XDG Base Directory Specification 0.8.
fn cache() -> PathBuf {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|folder| folder.is_absolute());
    let own = folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache")));
    own.unwrap_or_else(std::env::temp_dir)
}

pub fn lsp() -> Ended {
    let shelf = cache().join("falsify").join(concat!("std-", env!("CARGO_PKG_VERSION")));
    // The server looks up the programs that scenarios name, and never starts them.
    match serve(catalog(), std::io::stdin().lock(), std::io::stdout().lock(), shelf).map_err(misused)? {
        Ending::Orderly => Ok(ExitCode::Done),
        Ending::Abrupt => Err(ExitCode::Internal),
    }
}
