//! Ctrl-C: the first one asks for a clean end, the second one ends at once.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::ExitCode;

static ASKED: AtomicUsize = AtomicUsize::new(0);

/// Begins to listen.
pub fn listen() {
    // Without the handler Ctrl-C ends the program at once, which loses the campaign in hand and nothing else.
    let _ = ctrlc::set_handler(|| {
        if ASKED.fetch_add(1, Ordering::Relaxed) > 0 {
            std::process::exit(ExitCode::Interrupted as i32);
        }
        anstream::eprintln!("\nstopping after the work in hand; once more to stop at once");
    });
}

/// Whether the user asked to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed) > 0
}
