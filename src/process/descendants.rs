//! The processes that a driver has started and that have left its process group, as daemons do: by a mark in their environment, or without it, once their
//! parent has ended, as children of this process.

use std::fs;
#[cfg(target_os = "linux")]
use std::sync::OnceLock;

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

/// Whether processes below this one that lose their parent become its children.
#[cfg(target_os = "linux")]
static ADOPTS: OnceLock<bool> = OnceLock::new();

/// From now on processes below this one that lose their parent become its children, unless it has others already. For a program, not for a library.
#[cfg(target_os = "linux")]
pub(super) fn adopt() {
    ADOPTS.get_or_init(|| children().is_empty() && nix::sys::prctl::set_child_subreaper(true).is_ok());
}

/// Ends the children of this process, and theirs, if it has [adopted](adopt) some.
#[cfg(target_os = "linux")]
pub(super) fn end_children() {
    // Each round shows the children of those that ended in the last.
    for _ in 0..16 * ROUNDS {
        let children = if ADOPTS.get() == Some(&true) { children() } else { Vec::new() };
        if children.is_empty() {
            return;
        }
        for child in children {
            let _ = kill(child, Signal::SIGKILL);
            let _ = nix::sys::wait::waitpid(child, Some(nix::sys::wait::WaitPidFlag::WNOHANG));
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// The children of this process, those that have ended and were not waited for included.
#[cfg(target_os = "linux")]
fn children() -> Vec<Pid> {
    let tasks = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let listed = tasks.filter_map(|task| fs::read_to_string(task.path().join("children")).ok());
    listed
        .flat_map(|ids| ids.split_whitespace().filter_map(|id| id.parse().ok().map(Pid::from_raw)).collect::<Vec<_>>())
        .collect()
}
