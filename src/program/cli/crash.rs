//! What happens when the program or a library panics: a message, and the end of the process.
//!
//! A panic of a thread that a library has started, such as one of the table library, would leave all others waiting for it. So every panic
//! ends the process at once, unless [`contained`](base::contained) makes it an error.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::panic::PanicHookInfo;
use std::sync::atomic::{AtomicBool, Ordering};

use super::console;
use crate::exit_code::ExitCode;
use base::contained;

/// Whether a thread already ends the process.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Installs the handler of panics.
pub fn listen() {
    std::panic::set_hook(Box::new(|panic| {
        let message = contained::message(panic.payload()).to_owned();
        let no_thread = is_about_threads(&message);
        if contained::is_active() && !no_thread {
            return;
        }
        end(panic, &message, no_thread);
    }));
}

#[expect(clippy::exit, reason = "other threads may wait for the one that panicked")]
fn end(panic: &PanicHookInfo, message: &str, no_thread: bool) {
    if ENDING.swap(true, Ordering::Relaxed) {
        wait_for_the_end();
    }
    process::end_all();
    if no_thread {
        console::fail(&format!(
            "the system refused to start a thread: {message}\n  raise the limit of processes (`ulimit -u`) or of memory (`ulimit -v`), or use \
             fewer threads with --threads; what was finished before is not lost"
        ));
    } else {
        let place = panic.location().map_or(String::new(), |place| format!(" at {place}"));
        console::note(&format!("panic{place}: {message}"));
        let trace = Backtrace::capture();
        if trace.status() == BacktraceStatus::Captured {
            console::note(&trace.to_string());
        }
        console::fail("this is a bug in falsify; what was finished before is not lost");
    }
    std::process::exit(ExitCode::Internal as i32)
}

/// Waits until another thread, which reports its own panic, has ended the process.
fn wait_for_the_end() -> ! {
    loop {
        std::thread::park();
    }
}

/// Whether the message of a panic says that a thread could not be started, as std, rayon and tokio word it.
fn is_about_threads(message: &str) -> bool {
    let message = message.to_lowercase();
    message.contains("thread")
        && ["spawn", "resource temporarily unavailable"].iter().any(|words| message.contains(words))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_about_threads_are_known() {
        for message in [
            "OS can't spawn worker thread: Resource temporarily unavailable (os error 11)",
            "failed to spawn thread: Os { code: 11, kind: WouldBlock, message: \"Resource temporarily unavailable\" }",
            "could not spawn threads",
            "The global thread pool has not been initialized.: ThreadPoolBuildError { kind: IOError(Os { code: 11, kind: WouldBlock, \
             message: \"Resource temporarily unavailable\" }) }",
        ] {
            assert!(is_about_threads(message), "{message}");
        }
        assert!(!is_about_threads("index out of bounds: the len is 0 but the index is 7"));
    }
}
