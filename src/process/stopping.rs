//! How long programs are waited for after the user has asked to stop, and the end with another process.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use nix::errno::Errno;
use nix::sys::signal::kill;
use nix::unistd::Pid;

/// Time that a program has for its answer after the user has asked to stop.
const GRACE: Duration = Duration::from_millis(500);
/// Time between two looks whether the user has asked.
pub(super) const GLANCE: Duration = Duration::from_millis(50);

/// Whether waits may end early, and when the user asked.
static STATE: Mutex<(bool, Option<Instant>)> = Mutex::new((false, None));

/// Whether waits for programs end when the user asks to stop: only while what they give up can be done again later.
pub fn allow_to_stop(allowed: bool) {
    STATE.lock().unwrap_or_else(PoisonError::into_inner).0 = allowed;
}

/// The user asks to stop: waits for programs end soon, where that is allowed.
pub fn stop_waiting() {
    STATE.lock().unwrap_or_else(PoisonError::into_inner).1.get_or_insert_with(Instant::now);
}

/// Whether programs are not waited for any more.
pub(super) fn is_over() -> bool {
    let (allowed, asked) = *STATE.lock().unwrap_or_else(PoisonError::into_inner);
    allowed && asked.is_some_and(|asked| asked.elapsed() >= GRACE)
}

/// Time between two looks whether another process has ended.
const WATCH: Duration = Duration::from_secs(1);

/// Ends this process at once when another one has ended. One that is not seen now, as from a container, is not waited for.
#[expect(clippy::exit, reason = "nobody is there who could ask for an end in order")]
pub fn end_with(id: i32) {
    let runs = move || id > 0 && kill(Pid::from_raw(id), None) != Err(Errno::ESRCH);
    let watch = move || {
        while runs() {
            std::thread::sleep(WATCH);
        }
        std::process::exit(1)
    };
    if runs() {
        std::thread::spawn(watch);
    }
}
