//! Drivers as child processes: the only code that starts programs.
//!
//! A child gets its questions on its standard input and answers on its standard output; its standard error is ours. It is the
//! leader of a process group of its own, so that Ctrl-C on the terminal lets it finish the work in hand with us, and so that
//! it ends with all that it has started.

#[cfg(unix)]
mod child;
mod find;
mod opener;

#[cfg(unix)]
pub use child::end_all;
pub use opener::ProcessOpener;

#[cfg(not(unix))]
/// Ends all children at once; there are none here.
pub fn end_all() {}
