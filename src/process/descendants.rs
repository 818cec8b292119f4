//! The processes that a driver has started and that have left its process group, as daemons do.

use std::fs;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

/// The variable in the environment of a driver, which the processes that it starts inherit.
pub(super) const MARK: &str = "FALSIFY_DRIVER";
/// How often the processes are listed, since one may start another while it is ended.
const ROUNDS: usize = 4;

/// Ends all processes whose mark starts with a text. Systems without `/proc` have no list of them; there only the process group ends.
pub(super) fn end(mark: &str) {
    let wanted = format!("{MARK}={mark}");
    for _ in 0..ROUNDS {
        let marked = marked(wanted.as_bytes());
        if marked.is_empty() {
            return;
        }
        for id in marked {
            let _ = kill(Pid::from_raw(id), Signal::SIGKILL);
        }
    }
}

/// The processes with such a variable. Zombies have an empty environment.
fn marked(wanted: &[u8]) -> Vec<i32> {
    let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
    let ids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    let has_mark = |id: &i32| {
        let environment = fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
        environment.split(|byte| *byte == 0).any(|variable| variable.starts_with(wanted))
    };
    ids.filter(has_mark).collect()
}
