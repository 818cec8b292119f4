//! Ctrl-C: the first one asks for a clean end, the second one ends at once.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::{ExitCode, front};

static ASKED: AtomicUsize = AtomicUsize::new(0);
static HELD: AtomicBool = AtomicBool::new(false);

/// While held, a second Ctrl-C waits: a report is being put in its place.
pub fn hold(held: bool) {
    HELD.store(held, Ordering::Relaxed);
}

/// Begins to listen.
pub fn listen() {
    // Without the handler Ctrl-C ends the program at once, which loses the campaign in hand and nothing else.
    let _ = ctrlc::set_handler(|| {
        if ASKED.fetch_add(1, Ordering::Relaxed) > 0 {
            if HELD.load(Ordering::Relaxed) {
                return;
            }
            end_at_once();
        }
        front::note("\nstopping after the work in hand; once more to stop at once");
    });
}

/// Begins to listen, for commands that have nothing to lose: the first Ctrl-C ends the program.
pub fn end_when_asked() {
    let _ = ctrlc::set_handler(|| end_at_once());
}

#[expect(clippy::exit, reason = "the handler of a signal has nothing to return to")]
fn end_at_once() -> ! {
    crate::process::end_all();
    std::process::exit(ExitCode::Interrupted as i32)
}

/// Whether the user asked to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed) > 0
}
