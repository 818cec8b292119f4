//! Ctrl-C: the first one asks for a clean end, the second one ends at once.

use std::sync::{Arc, LazyLock};

use super::console;
use super::exit_code::ExitCode;
use crate::session::Stop;

static STOP: LazyLock<Arc<Stop>> = LazyLock::new(Arc::default);

/// The flag that the first Ctrl-C raises.
pub fn stop() -> Arc<Stop> {
    STOP.clone()
}

/// Starts to listen.
pub fn listen() {
    // Without the handler Ctrl-C ends the program at once, which loses unsaved work of the campaign and nothing else.
    let _ = ctrlc::set_handler(|| {
        if STOP.ask() {
            // A second one waits while a report is put in its place.
            if STOP.is_placing() {
                return;
            }
            end_at_once();
        }
        console::note("\nstopping after the work in progress; press Ctrl-C again to stop at once");
    });
}

/// Starts to listen, for commands that have nothing to lose: the first Ctrl-C ends the program.
pub fn end_when_asked() {
    let _ = ctrlc::set_handler(|| end_at_once());
}

#[expect(clippy::exit, reason = "the handler of a signal has nothing to return to")]
fn end_at_once() -> ! {
    crate::process::end_all();
    std::process::exit(ExitCode::Interrupted as i32)
}
