//! Ctrl-C: the first one asks for a clean end, the second one ends the program at once.

use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::Duration;

use super::console;
use crate::exit_code::ExitCode;
use crate::session::Stop;

/// How long a report may take once it is asked to stop.
const PATIENCE: Duration = Duration::from_millis(1500);

static STOP: LazyLock<Arc<Stop>> = LazyLock::new(Arc::default);

/// The flag that the first Ctrl-C raises.
pub fn stop() -> Arc<Stop> {
    STOP.clone()
}

/// Installs the handler.
pub fn listen() {
    // Without the handler Ctrl-C ends the program at once. That loses only unsaved work of the campaign.
    let _ = ctrlc::set_handler(|| {
        if STOP.ask() {
            // A second one waits while a report is moved to its place.
            if STOP.is_placing() {
                return;
            }
            end_at_once();
        }
        process::stop_waiting();
        console::note("\nstopping after the work in progress; press Ctrl-C again to stop at once");
        thread::spawn(leave_report);
    });
}

/// Ends the program once a report takes longer than people wait for it: its results are stored.
fn leave_report() {
    thread::sleep(PATIENCE);
    while !STOP.is_reporting() || STOP.is_placing() {
        thread::sleep(Duration::from_millis(20));
    }
    console::note("the report is not written; the results are stored, and the same command goes on from them");
    end_at_once();
}

/// Installs the handler for commands without unsaved work: the first Ctrl-C ends the program.
pub fn end_when_asked() {
    let _ = ctrlc::set_handler(|| end_at_once());
}

#[expect(clippy::exit, reason = "the handler of a signal has nothing to return to")]
fn end_at_once() -> ! {
    process::end_all();
    std::process::exit(ExitCode::Interrupted as i32)
}
