//! The limits that the system sets for this process.

use nix::sys::resource::{Resource, getrlimit};

/// The fewest open files with which a campaign can be run: libraries panic below about ten.
const FEWEST_FILES: u64 = 32;
/// The least address space with which a campaign can be run, and that of each further thread (bytes).
const MIN_MEMORY: (u64, u64) = (256 << 20, 16 << 20);

/// Why a limit of the system does not allow a run with this number of threads, and what to do; `None` if all do.
pub fn refusal(threads: usize) -> Option<String> {
    let limit = |resource| getrlimit(resource).map_or(u64::MAX, |(soft, _)| soft);
    let files = limit(Resource::RLIMIT_NOFILE);
    if files < FEWEST_FILES {
        return Some(format!(
            "at most {files} files may be open at once, and {FEWEST_FILES} are needed; raise the limit with `ulimit -n {FEWEST_FILES}`"
        ));
    }
    let wanted = MIN_MEMORY.0 + MIN_MEMORY.1 * threads as u64;
    let memory = limit(Resource::RLIMIT_AS);
    (memory < wanted).then(|| {
        format!(
            "at most {} MiB of memory may be addressed, and {} MiB are needed for {threads} threads; raise the limit with `ulimit -v {}` or \
             use fewer threads with --threads",
            memory >> 20,
            wanted >> 20,
            wanted >> 10
        )
    })
}
