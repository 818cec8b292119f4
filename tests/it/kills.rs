//! A campaign that is ended by signals, alone or with another process, has the same reports as an undisturbed one. No process panics, and
//! nothing is left over. `FALSIFY_TEST_KILLS` is the number of signals of each of the three modes, or three numbers (2, or 6 with `FALSIFY_LARGE_SAMPLES`); `FALSIFY_TEST_SEED` is a
//! seed of their times; `FALSIFY_TEST_PROGRAM` is another build.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::program;
use crate::samples::samples;

/// A campaign with all kinds of tasks that takes a moment.
const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
training quick = ppo(steps: 60, steps_per_update: 10, epochs: 1, environments: 2, hidden: [8])
reward shy { on touch => 1 }
method walk = random()
method strategy = cma_es(tries: 5)
campaign cut {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: quick
  train { towns: [harbour] drivers: [behavior] rewards: [r1, shy] runs: 1 }
  evaluate { towns: [village] drivers: [blind] pedestrians: [trained, random] episodes: 8 }
  search { towns: [village] drivers: [blind] methods: [walk, strategy] budget: 2000 runs: 1 episodes: 2 }
}
"#;

/// The most time that a process may take after a signal. It separates an end from a hang.
const PATIENCE: Duration = Duration::from_secs(300);

/// Which processes work on a campaign at the same time.
#[derive(Clone, Copy, Debug)]
enum Mode {
    OneProcess,
    TwoOnOneFolder,
    TwoFoldersOneCache,
}

impl Mode {
    /// The folders for reports, one for each process.
    fn folders(self) -> &'static [&'static str] {
        match self {
            Self::OneProcess => &["one"],
            Self::TwoOnOneFolder => &["one", "one"],
            Self::TwoFoldersOneCache => &["one", "two"],
        }
    }

    fn command(self, place: &Path, folder: &str) -> Command {
        let mut command = match std::env::var_os("FALSIFY_TEST_PROGRAM") {
            Some(program) => Command::new(program),
            None => program::command(),
        };
        command.args(["run", "cut.scn", "--out", folder, "--threads", "1", "--checkpoint", "0.001"]);
        if let Self::TwoFoldersOneCache = self {
            command.args(["--cache", "cache"]);
        }
        command.current_dir(place).stdout(Stdio::null());
        command
    }

    fn start(self, place: &Path, number: usize) -> Process {
        let errors = place.join(format!("errors-{number}"));
        let child =
            self.command(place, self.folders()[number]).stderr(fs::File::create(&errors).unwrap()).spawn().unwrap();
        Process { child, errors }
    }
}

/// A process whose errors go to a file, so that it never waits for a reader.
struct Process {
    child: Child,
    errors: PathBuf,
}

impl Process {
    /// Sends a signal. Returns whether the process was alive.
    fn signal(&mut self, name: &str) -> bool {
        let alive = self.child.try_wait().unwrap().is_none();
        if alive {
            assert!(Command::new("kill").args([name, &self.child.id().to_string()]).status().unwrap().success());
        }
        alive
    }

    fn end(mut self, signal: Option<&str>) -> bool {
        let begun = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            if begun.elapsed() > PATIENCE {
                let threads = threads(self.child.id());
                self.child.kill().unwrap();
                panic!(
                    "{signal:?}: no end after {PATIENCE:?}: {}\n{threads}",
                    fs::read_to_string(&self.errors).unwrap()
                );
            }
            std::thread::sleep(Duration::from_millis(2));
        };
        let text = fs::read_to_string(&self.errors).unwrap();
        assert!(!text.contains("panicked") && !text.contains("bug"), "{signal:?}: {text}");
        match (status.code(), signal) {
            (Some(0), _) => true,
            (Some(130), Some("-TERM" | "-INT")) => false,
            // A signal that comes before the program listens ends it as any program.
            (None, Some("-KILL" | "-TERM" | "-INT")) if status.signal().is_some() => false,
            _ => panic!("{signal:?}: {status:?}: {text}"),
        }
    }
}

/// What each thread of a process waits for, as far as the system says it.
fn threads(process: u32) -> String {
    let Ok(tasks) = fs::read_dir(format!("/proc/{process}/task")) else { return String::new() };
    let paths = tasks.flatten().map(|task| task.path());
    let about = |path: PathBuf| {
        let words = ["comm", "wchan", "syscall"].map(|file| fs::read_to_string(path.join(file)).unwrap_or_default());
        words.map(|word| word.trim().to_owned()).join(" ")
    };
    paths.map(about).collect::<Vec<_>>().join("\n")
}

/// The numbers of one mode.
#[derive(Debug, Default)]
struct Counts {
    signals: BTreeMap<&'static str, u32>,
    campaigns: u32,
    reports: u32,
}

/// A number from 0 to 1.
fn draw(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("cut.scn"), SCENARIO).unwrap();
    place
}

/// The report, without the lines that name the folder of the report.
fn report(place: &Path, folder: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = program::report(&place.join(folder).join("cut"));
    for (name, bytes) in &mut files {
        if name.ends_with("manifest.toml") || name.ends_with("report.html") || name.ends_with("summary.md") {
            *bytes = String::from_utf8(std::mem::take(bytes)).unwrap().replace(folder, "FOLDER").into_bytes();
        }
    }
    files
}

fn same(found: &BTreeMap<PathBuf, Vec<u8>>, wanted: &BTreeMap<PathBuf, Vec<u8>>, mode: Mode) {
    assert_eq!(found.keys().collect::<Vec<_>>(), wanted.keys().collect::<Vec<_>>(), "{mode:?}");
    for (name, bytes) in wanted {
        // The manifest and the page have the command, which differs between modes.
        let command = ["manifest.toml", "report.html", "summary.md"].iter().any(|other| name.ends_with(other));
        assert!(command || found[name] == *bytes, "{mode:?}: {} differs", name.display());
    }
}

/// What a dead process may have left: its work folder, its claims, its partial report.
fn left_over(folder: &Path) -> Vec<PathBuf> {
    let (mut open, mut found) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if name.starts_with("work-") || name.ends_with("-partial") || next.ends_with("claims") {
                found.push(path);
            } else if path.is_dir() {
                open.push(path);
            }
        }
    }
    found
}

/// Ends processes of campaigns until there were this many signals.
fn attack(mode: Mode, signals: u32, seed: u64, counts: &mut Counts) {
    let undisturbed = place();
    let begun = Instant::now();
    let output = mode.command(undisturbed.path(), "one").output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let (time, wanted) = (begun.elapsed(), report(undisturbed.path(), "one"));
    let mut state = 0x2545_f491_4f6c_dd1d_u64 ^ mode.folders().len() as u64 ^ (seed << 8);
    let sent = |counts: &Counts| counts.signals.values().sum::<u32>();
    while sent(counts) < signals {
        let place = place();
        // Each campaign is disturbed a few times, and then it is left alone.
        for _ in 0..6 {
            if sent(counts) >= signals {
                break;
            }
            let mut processes: Vec<_> =
                (0..mode.folders().len()).map(|number| mode.start(place.path(), number)).collect();
            // The time of the signal is what this test varies. To wait for an event would let the program choose the time.
            std::thread::sleep(Duration::from_secs_f64(1.1 * time.as_secs_f64() * draw(&mut state)));
            let both = processes.len() > 1 && draw(&mut state) < 0.3;
            let victim = if draw(&mut state) < 0.5 { 0 } else { processes.len() - 1 };
            let mut received = vec![None; processes.len()];
            for number in (0..processes.len()).filter(|number| both || *number == victim) {
                let name = ["-KILL", "-TERM", "-INT"][(3.0 * draw(&mut state)) as usize];
                if processes[number].signal(name) {
                    received[number] = Some(name);
                    *counts.signals.entry(name).or_default() += 1;
                }
            }
            let ended: Vec<bool> =
                processes.into_iter().zip(received).map(|(process, signal)| process.end(signal)).collect();
            if ended.iter().all(|finished| *finished) {
                break;
            }
        }
        let folders: std::collections::BTreeSet<_> = mode.folders().iter().collect();
        for folder in folders {
            let output: Output = mode.command(place.path(), folder).output().unwrap();
            assert!(output.status.success(), "{mode:?}: {output:?}");
            same(&report(place.path(), folder), &wanted, mode);
            counts.reports += 1;
        }
        let left = left_over(place.path());
        assert!(left.is_empty(), "{mode:?}: {left:?}");
        counts.campaigns += 1;
    }
}

/// The value of a variable, or what it is by default.
fn variable(name: &str, default: &str) -> String {
    std::env::var(name).unwrap_or_else(|_| default.to_owned())
}

#[test]
fn signals_at_any_moment_change_no_report() {
    let signals = variable("FALSIFY_TEST_KILLS", &samples(2, 6).to_string());
    let signals: Vec<u32> = signals.split(',').map(|text| text.parse().expect("a number of signals")).collect();
    let seed = variable("FALSIFY_TEST_SEED", "0").parse().expect("a seed");
    for (number, mode) in [Mode::OneProcess, Mode::TwoOnOneFolder, Mode::TwoFoldersOneCache].into_iter().enumerate() {
        let (mut counts, begun) = (Counts::default(), Instant::now());
        attack(mode, signals[number % signals.len()], seed, &mut counts);
        println!("{mode:?}: {counts:?}, {:.0} s", begun.elapsed().as_secs_f64());
    }
}
