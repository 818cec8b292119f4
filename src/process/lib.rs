//! Drivers as child processes, and this program again for trials: the only code that starts programs.
//!
//! A child reads questions from its standard input and answers on its standard output. Its standard error is passed on to ours, up to a
//! limit. It leads its own process group. So Ctrl-C on the terminal lets it finish its current work with us, and it ends together with all
//! processes that it has started: on Linux also those that have left the group, which are known by a variable of their environment, or at the end of the program
//! as its children.

#[cfg(unix)]
mod descendants;
#[cfg(unix)]
mod limits;
#[cfg(unix)]
mod stopping;
mod find;
mod digests;
mod notes;
#[cfg(unix)]
mod messages;
#[cfg(unix)]
mod child;
mod opener;
mod trial;

#[cfg(unix)]
pub use child::{end_all, failures};
pub use find::missing_package;
#[cfg(unix)]
pub use limits::refusal;
pub use opener::ProcessOpener;
#[cfg(unix)]
pub use stopping::{allow_to_stop, end_with, stop_waiting};
pub use trial::{limit_trial, trial, used_seconds};

#[cfg(not(unix))]
/// Ends all children at once; there are none on this system.
pub fn end_all() {}

#[cfg(not(unix))]
/// No program runs on this system, so none fails.
pub fn failures() -> u64 {
    0
}

#[cfg(not(unix))]
/// No program runs on this system, so none is waited for.
pub fn allow_to_stop(_: bool) {}

#[cfg(not(unix))]
/// No program runs on this system, so none is waited for.
pub fn stop_waiting() {}

#[cfg(not(unix))]
/// Why a limit of the system does not allow a run; other systems have no such limits.
pub fn refusal(_: usize) -> Option<String> {
    None
}

#[cfg(not(unix))]
/// Only a Unix system tells whether another process runs.
pub fn end_with(_: i32) {}
