//! A trial of bytes that are not trusted: this program, started again, reads them within limits of memory and time.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use base::files::MAX_BYTES;

/// Maximum memory that a trial may address (MiB): twice of what the largest network file needs, which is 900. The smallest one needs 100.
const MAX_MEMORY: u64 = 2048;
/// Maximum time of the processor (s) for a small network, of which nearly all is a tick, and for the largest file, which needs 1.5 s. Other work of the machine
/// does not count.
const MAX_SECONDS: [u64; 2] = [1, 10];
/// Maximum time of the clock, for a child that waits, and for systems without the other limits.
const MAX_WAIT: Duration = Duration::from_secs(30);
/// A time of a decision from which on it is told (s).
const LONG: f64 = 0.1;
/// Time between two looks at the child.
const PAUSE: Duration = Duration::from_millis(1);

/// The time of a decision (s) where it is long, or why a trial did not reach its end.
type Answer = Result<Option<f64>, String>;

/// The answers of all trials, by digests of their bytes.
static REMEMBERED: Mutex<BTreeMap<[u8; 32], Answer>> = Mutex::new(BTreeMap::new());

/// Starts this program again with these words, and gives it bytes on its standard input. It should call [`limit_trial`], do with the bytes
/// what may take the machine, write how long that took (s), and end with exit code 0 whatever the result is. The same bytes are tried once. Returns the
/// time if it is long.
///
/// # Errors
/// Why the trial did not reach its end, as a part of a sentence.
pub fn trial(words: &[&str], bytes: &[u8]) -> Result<Option<f64>, String> {
    let mut remembered = REMEMBERED.lock().unwrap_or_else(PoisonError::into_inner);
    remembered.entry(*blake3::hash(bytes).as_bytes()).or_insert_with(|| started(words, bytes)).clone()
}

fn started(words: &[&str], bytes: &[u8]) -> Result<Option<f64>, String> {
    let mut command = Command::new(this_program().map_err(|error| not_tried(&error))?);
    command.args(words).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // Every thread reserves addresses, so one on each core could be beyond the limit.
    command.envs([("RTEN_NUM_THREADS", "1"), ("RAYON_NUM_THREADS", "1"), ("RUST_MIN_STACK", "1048576")]);
    // Ctrl-C is for us.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command.spawn().map_err(|error| not_tried(&error))?;
    let mut input = child.stdin.take();
    let status = std::thread::scope(|scope| {
        // A child that ends early does not read all.
        scope.spawn(move || input.as_mut().map(|input| input.write_all(bytes)));
        wait(&mut child)
    });
    let mut said = String::new();
    let _ = child.stderr.take().map(|messages| messages.take(1 << 16).read_to_string(&mut said));
    match status.map_err(|error| not_tried(&error))? {
        Some(status) if status.success() => {
            let mut took = String::new();
            let _ = child.stdout.take().map(|stdout| stdout.take(1 << 10).read_to_string(&mut took));
            Ok(took.trim().parse().ok().filter(|seconds| *seconds > LONG))
        }
        Some(_) if said.contains("memory allocation") => {
            Err(format!("loading and running it once needs more than {} MiB of memory", max_memory()))
        }
        Some(status) if !is_late(status) => Err(format!("loading or running it ends the program ({status})")),
        _ => Err(format!("loading and running it once takes more than {} s", max_seconds(bytes.len()))),
    }
}

fn not_tried(error: &std::io::Error) -> String {
    format!("it cannot be tried in a process of its own: {error}")
}

/// The file of this program; on Linux also after it was replaced by a new version.
fn this_program() -> std::io::Result<PathBuf> {
    let own = PathBuf::from("/proc/self/exe");
    if own.exists() { Ok(own) } else { std::env::current_exe() }
}

/// Waits for the end of a child; `None` if it had to be ended.
fn wait(child: &mut Child) -> std::io::Result<Option<ExitStatus>> {
    let deadline = Instant::now() + MAX_WAIT;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if Instant::now() >= deadline {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(PAUSE);
    }
}

#[cfg(unix)]
fn is_late(status: ExitStatus) -> bool {
    std::os::unix::process::ExitStatusExt::signal(&status) == Some(nix::sys::signal::Signal::SIGXCPU as i32)
}

#[cfg(not(unix))]
fn is_late(_: ExitStatus) -> bool {
    false
}

/// Maximum memory of a trial (MiB): at most half of what this process may have beside the program itself, since it loads afterwards what has passed.
#[cfg(unix)]
fn max_memory() -> u64 {
    use nix::sys::resource::{Resource, getrlimit};
    // Its fourth field: the pages of code, of 4 KiB. Linux has the file.
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let program = pages.split_whitespace().nth(3).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or_default() >> 8;
    let most = |soft: u64| ((soft >> 20).saturating_sub(program)) / 2 + program;
    getrlimit(Resource::RLIMIT_AS).map_or(MAX_MEMORY, |(soft, _)| MAX_MEMORY.min(most(soft)))
}

#[cfg(not(unix))]
fn max_memory() -> u64 {
    MAX_MEMORY
}

/// Maximum time of the processor (s) for a file of this number of bytes.
fn max_seconds(bytes: usize) -> u64 {
    let [least, greatest] = MAX_SECONDS;
    least + (greatest - least) * bytes as u64 / MAX_BYTES
}

/// The time of the processor that this process has used, with programs that it started and that have ended (s); 0 on systems other than Unix.
pub fn used_seconds() -> f64 {
    #[cfg(unix)]
    {
        use nix::sys::resource::{UsageWho, getrusage};
        let used = [UsageWho::RUSAGE_SELF, UsageWho::RUSAGE_CHILDREN].into_iter().filter_map(|who| getrusage(who).ok());
        let times = used.flat_map(|usage| [usage.user_time(), usage.system_time()]);
        times.map(|time| time.tv_sec() as f64 + time.tv_usec() as f64 / 1e6).sum()
    }
    #[cfg(not(unix))]
    0.0
}

/// Sets the limits of a trial of this number of bytes for this process. Systems other than Unix have none, and others may refuse some.
#[cfg_attr(not(unix), expect(unused_variables, reason = "there are no limits"))]
pub fn limit_trial(bytes: usize) {
    #[cfg(unix)]
    {
        use nix::sys::resource::{Resource, setrlimit};
        let _ = setrlimit(Resource::RLIMIT_AS, max_memory() << 20, max_memory() << 20);
        let _ = setrlimit(Resource::RLIMIT_CPU, max_seconds(bytes), max_seconds(bytes) + 1);
        let _ = setrlimit(Resource::RLIMIT_CORE, 0, 0);
    }
}
