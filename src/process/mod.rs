//! Drivers as child processes: the only code that starts programs.
//!
//! A child reads questions from its standard input and answers on its standard output. It shares our standard error. It leads its own
//! process group. So Ctrl-C on the terminal lets it finish its current work with us, and it ends together with all processes that it has
//! started.

#[cfg(unix)]
mod child;
mod find;
mod opener;

#[cfg(unix)]
pub use child::end_all;
pub use opener::ProcessOpener;

#[cfg(not(unix))]
/// Ends all children at once; there are none on this system.
pub fn end_all() {}
