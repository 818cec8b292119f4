//! A campaign that was stopped in any way ends in the same bytes when it is run again, and repeats no finished work.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::program::{self, error};
use crate::samples::samples;

/// A campaign with all kinds of tasks that takes a short time.
const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
training quick = ppo(steps: 120, steps_per_update: 10, epochs: 1, environments: 2, hidden: [8])
reward shy { on touch => 1 }
method walk = random()
campaign cut {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: quick  price: 4
  train { towns: [harbour] drivers: [behavior] rewards: [r1, shy] runs: 2 }
  evaluate { towns: [village] drivers: [blind] pedestrians: [trained, random] episodes: 12 }
  search { towns: [village] drivers: [blind] methods: [walk] budget: 6000 runs: 1 episodes: 2 }
}
"#;

/// A folder with the campaign, changed as requested.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        place.write(SCENARIO);
        place
    }

    fn write(&self, scenario: &str) {
        let lib = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/lib");
        let text = scenario.replace("lib/", &format!("{}/", lib.display()));
        std::fs::write(self.folder.path().join("cut.scn"), text).unwrap();
    }

    fn command(&self, more: &[&str]) -> Command {
        let mut command = program::command();
        command.args(["run", "cut.scn", "--out", "out"]).args(more);
        command.current_dir(self.folder.path()).env("FALSIFY_THREADS", "2");
        command
    }

    fn run(&self, more: &[&str]) -> Output {
        self.command(more).output().unwrap()
    }

    fn begin(&self, more: &[&str]) -> Child {
        self.command(more).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn list(&self) -> String {
        String::from_utf8(self.run(&["--list"]).stdout).unwrap()
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// All files of the report; the manifest is without times, number of threads and working folder.
    fn report(&self) -> BTreeMap<String, Vec<u8>> {
        let report = self.out().join("cut");
        let read = |path: PathBuf| {
            let mut bytes = std::fs::read(&path).unwrap();
            if path.ends_with("manifest.toml") {
                let text = String::from_utf8(bytes).unwrap();
                let varies = |line: &&str| {
                    ["wall_time_s", "threads", "folder", "# BLAKE3"].iter().any(|key| line.starts_with(key))
                };
                let kept = text.lines().filter(|line| !varies(line));
                bytes = kept.collect::<Vec<_>>().join("\n").into_bytes();
            }
            (path.strip_prefix(&report).unwrap().display().to_string(), bytes)
        };
        files(&report).into_iter().map(read).collect()
    }

    /// The files of all tasks.
    fn tasks(&self) -> Vec<PathBuf> {
        files(&self.out().join(".falsify/tasks"))
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let (mut open, mut found) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.unwrap().path();
            if path.is_dir() { open.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    found
}

/// Asserts that two reports are equal, byte for byte.
fn same(found: &BTreeMap<String, Vec<u8>>, wanted: &BTreeMap<String, Vec<u8>>, what: &str) {
    assert_eq!(found.keys().collect::<Vec<_>>(), wanted.keys().collect::<Vec<_>>(), "{what}");
    for (name, bytes) in wanted {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let differs = || {
            let (found, wanted) = (text(&found[name]), text(bytes));
            let line = found.lines().zip(wanted.lines()).find(|(found, wanted)| found != wanted);
            format!("{what}: {name} differs, first in {line:?}")
        };
        assert!(found[name] == *bytes, "{}", differs());
    }
}

/// An undisturbed run, and its duration.
fn undisturbed() -> (BTreeMap<String, Vec<u8>>, Duration) {
    let place = Place::new();
    let begun = Instant::now();
    let output = place.run(&[]);
    assert!(output.status.success(), "{output:?}");
    (place.report(), begun.elapsed())
}

#[test]
fn a_campaign_that_is_killed_at_any_moment_ends_in_the_same_bytes() {
    let last = samples(6, 24);
    let (wanted, time) = undisturbed();
    let (mut kills, mut state) = (0, 0x2545_f491_4f6c_dd1d_u64);
    let mut share = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    while kills < last {
        let place = Place::new();
        loop {
            let mut child = place.begin(&["--checkpoint", "0.001"]);
            // The time of the kill is what this test varies. To wait for an event would let the program choose the time.
            std::thread::sleep(time.mul_f64(0.9 * share()));
            let done = child.try_wait().unwrap().is_some();
            let _ = child.kill();
            // The program may have ended just before the kill.
            let ended = child.wait().unwrap().success();
            assert!(ended || !done);
            if ended {
                break;
            }
            kills += 1;
            if kills >= last {
                let output = place.run(&[]);
                assert!(output.status.success(), "{output:?}");
                break;
            }
        }
        same(&place.report(), &wanted, &format!("after {kills} kills"));
        let left: Vec<_> = std::fs::read_dir(place.out()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left.len(), 2, "the report and the tasks: {left:?}");
        let output = place.run(&[]);
        assert!(error(&output).contains("14 of 14 tasks were there already"), "{output:?}");
        let work = std::fs::read_dir(place.out().join(".falsify")).unwrap().map(|entry| entry.unwrap().file_name());
        let dead: Vec<_> = work.filter(|name| name.to_string_lossy().starts_with("work-")).collect();
        assert!(dead.is_empty(), "{dead:?}");
    }
}

#[test]
#[cfg(unix)]
fn ctrl_c_saves_what_is_under_way() {
    let place = Place::new();
    let long = SCENARIO.replace("steps: 120", "steps: 10800");
    place.write(&long);
    let mut child = place.begin(&["--checkpoint", "3600"]);
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let named = lines.next().unwrap().unwrap();
    assert!(named.starts_with("the learning curves grow in "), "{named}");
    let first = lines.next().unwrap().unwrap();
    assert!(["trained", "tried", "searched"].iter().any(|word| first.contains(word)), "{first}");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let rest: Vec<String> = lines.map(Result::unwrap).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest:?}");
    // On a very busy machine the report takes longer than it may.
    let is_reported = place.out().join("cut-partial/manifest.toml").exists();
    assert!(is_reported || rest.iter().any(|line| line.contains("the report is not written")), "{rest:?}");
    assert!(!place.out().join("cut").exists());
    assert!(place.list().contains("run: unfinished, "), "{}", place.list());
    assert!(place.run(&[]).status.success());
    assert!(!place.out().join("cut-partial").exists(), "it has done its duty");
    let other = Place::new();
    other.write(&long);
    assert!(other.run(&["--threads", "1"]).status.success());
    same(&place.report(), &other.report(), "after Ctrl-C");
}

#[test]
fn damaged_and_foreign_files_are_told_apart_from_cells() {
    let place = Place::new();
    assert!(place.run(&[]).status.success());
    let wanted = place.report();
    let tasks = place.tasks();
    assert_eq!(tasks.len(), 14);
    let mut bytes = std::fs::read(&tasks[0]).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&tasks[0], &bytes).unwrap();
    std::fs::write(&tasks[1], &std::fs::read(&tasks[1]).unwrap()[..100]).unwrap();
    std::fs::write(&tasks[2], "").unwrap();
    std::fs::remove_file(&tasks[3]).unwrap();
    let foreign = [tasks[4].with_file_name("thesis.txt"), place.out().join(".falsify/notes.txt")];
    foreign.iter().for_each(|path| std::fs::write(path, "mine").unwrap());
    let list = place.list();
    assert!(list.contains("[run: damaged]") && list.contains("[run: gone]"), "{list}");
    let output = place.run(&[]);
    assert!(output.status.success(), "{output:?}");
    assert_eq!(error(&output).matches("is damaged; its task is done again").count(), 3, "{}", error(&output));
    assert!(error(&output).contains("10 of 14 tasks were there already"), "{}", error(&output));
    same(&place.report(), &wanted, "after damage");
    assert!(foreign.iter().all(|path| std::fs::read_to_string(path).unwrap() == "mine"));
    // A folder that disappears during a run is created again or reported. The next run succeeds in both cases.
    let child = place.begin(&["--fresh"]);
    let _ = std::fs::remove_dir_all(place.out());
    let ended = child.wait_with_output().unwrap();
    assert!(matches!(ended.status.code(), Some(0 | 6)), "{ended:?}");
    assert!(place.run(&[]).status.success());
    same(&place.report(), &wanted, "after the folder had gone");
}

#[test]
fn two_processes_on_one_folder_share_the_work() {
    let (wanted, _) = undisturbed();
    let place = Place::new();
    let both = [place.begin(&[]), place.begin(&["--threads", "1"])].map(|child| child.wait_with_output().unwrap());
    assert!(both.iter().all(|output| output.status.success()), "{both:?}");
    same(&place.report(), &wanted, "after two at once");
    let trained: usize = both.iter().map(|output| error(output).matches("] trained ").count()).sum();
    assert_eq!(trained, 4, "each training was done once: {both:?}");
}

#[test]
fn an_edit_reruns_what_it_changes_and_nothing_else() {
    let place = Place::new();
    assert!(place.run(&[]).status.success());
    let lines = |list: &str, state: &str| list.lines().filter(|line| line.contains(state)).count();
    place.write(&SCENARIO.replace("on touch => 1", "on touch => 2"));
    let list = place.list();
    // The trainings of the reward, and its trained and random controllers.
    assert_eq!((lines(&list, "[reuse]"), lines(&list, "changed]")), (8, 6), "{list}");
    assert!(list.lines().filter(|line| line.contains("changed]")).all(|line| line.contains("shy")), "{list}");
    assert!(list.contains("train    shy in harbour against behavior, run 0: 120 decisions [run: scenario changed]"));
    place.write(&format!(
        "// A comment.\n{}",
        SCENARIO.replace("on touch => 1", "on touch   => 1.0").replace("reward shy", "/// Hits.\nreward shy")
    ));
    assert_eq!(lines(&place.list(), "[reuse]"), 14, "{}", place.list());
    place.write(
        &SCENARIO
            .replace("runs: 2", "runs: 3")
            .replace("[village] drivers: [blind] ped", "[village, harbour] drivers: [blind] ped"),
    );
    let list = place.list();
    assert_eq!((lines(&list, "[reuse]"), lines(&list, "[run: new]")), (14, 19), "{list}");
    place.write(&SCENARIO.replace("episodes: 12", "episodes: 20"));
    assert_eq!(lines(&place.list(), "[run: unfinished, 12 of 20 episodes]"), 8, "{}", place.list());
    assert!(place.run(&[]).status.success());
    let longer = place.report();
    let fresh = place.run(&["--fresh", "--threads", "1"]);
    assert!(!error(&fresh).contains("there already"), "{}", error(&fresh));
    same(&place.report(), &longer, "anew on one thread");
    place.write(SCENARIO);
    assert_eq!(lines(&place.list(), "[reuse]"), 14, "{}", place.list());
    let other_seed = String::from_utf8(place.run(&["--list", "--seed", "2"]).stdout).unwrap();
    assert_eq!(lines(&other_seed, "[run: seed changed]"), 14, "{other_seed}");
}

#[test]
fn a_cell_beyond_its_limit_is_an_error_and_goes_on_another_time() {
    let (wanted, _) = undisturbed();
    let place = Place::new();
    let limited = place.run(&["--max-ticks", "1500"]);
    assert_eq!(limited.status.code(), Some(5), "{limited:?}");
    let said = error(&limited);
    assert!(said.contains("not finished within the 1500 ticks that a task may use"), "{said}");
    let partial = |name: &str| std::fs::read_to_string(place.out().join("cut-partial").join(name)).unwrap();
    let episodes = partial("episodes.csv");
    assert_eq!(episodes.lines().count(), 1 + 8 * 12, "every episode has a row");
    assert!(episodes.contains(",error,its training failed: not finished within the 1500 ticks"), "{episodes}");
    assert!(partial("manifest.toml").contains("error = \"not finished within the 1500 ticks"));
    assert!(place.run(&[]).status.success());
    same(&place.report(), &wanted, "after a limit");
}

#[test]
fn a_cell_that_gets_an_instant_at_a_time_gets_on_and_says_why_it_is_not_there() {
    let (wanted, _) = undisturbed();
    let place = Place::new();
    for turn in 1..=3 {
        let limited = place.run(&["--task-time", "0"]);
        assert_eq!(limited.status.code(), Some(5), "{limited:?}");
        assert!(error(&limited).contains("not finished within the 0 s that a task may take"), "{}", error(&limited));
        let list = place.list();
        assert_eq!(list.matches(&format!("[run: unfinished, {} of 120 decisions]", 20 * turn)).count(), 4, "{list}");
        assert_eq!(list.matches(&format!("[run: unfinished, {turn} of 12 episodes]")).count(), 4, "{list}");
    }
    let partial = place.out().join("cut-partial");
    let episodes = std::fs::read_to_string(partial.join("episodes.csv")).unwrap();
    assert_eq!(episodes.lines().count(), 1 + 8 * 12, "every episode has a row");
    let in_error = |why: &str| episodes.lines().filter(|line| line.contains(&format!(",error,{why}"))).count();
    assert_eq!(in_error("its training failed: not finished within the 0 s that a task may take"), 4 * 12, "{episodes}");
    assert_eq!(in_error("not finished within the 0 s that a task may take"), 4 * (12 - 3), "{episodes}");
    assert!(place.run(&[]).status.success());
    same(&place.report(), &wanted, "after three instants");
}

/// Runs on a file system that is too small, then on the same one after it has grown.
const FULL: &str = r#"
set -u
mount -t tmpfs -o size=96k none small || exit 99
"$FALSIFY" run cut.scn --threads 2 --checkpoint 3600 --out small/out >first.txt 2>&1
echo $? >first.code
mount -o remount,size=64m small || exit 99
"$FALSIFY" run cut.scn --threads 2 --checkpoint 3600 --out small/out >second.txt 2>&1
echo $? >second.code
cp -r small/out out
"#;

/// The same on a machine where no file system can be mounted: no file may be longer than a few blocks.
const SHORT: &str = r#"
trap '' XFSZ
mkdir -p small
(ulimit -f 32; "$FALSIFY" run cut.scn --threads 2 --checkpoint 3600 --out small/out >first.txt 2>&1; echo $? >first.code)
"$FALSIFY" run cut.scn --threads 2 --checkpoint 3600 --out small/out >second.txt 2>&1
echo $? >second.code
cp -r small/out out
"#;

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_told_of_and_loses_nothing() {
    let (wanted, _) = undisturbed();
    let place = Place::new();
    std::fs::create_dir(place.folder.path().join("small")).unwrap();
    let script = |words: &[&str], script: &str| {
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).args(["sh", "-c", script]).env("FALSIFY", env!("CARGO_BIN_EXE_falsify"));
        command.current_dir(place.folder.path()).status().is_ok_and(|status| status.success())
    };
    if !script(&["unshare", "--mount"], FULL) && !script(&["unshare", "--map-root-user", "--mount"], FULL) {
        loud!(
            "skipped: no file system can be mounted here, so a limit on the length of files stands in for a full disk"
        );
        assert!(script(&["env"], SHORT));
    }
    let text = |name: &str| std::fs::read_to_string(place.folder.path().join(name)).unwrap();
    assert_eq!(text("first.code").trim(), "6", "{}", text("first.txt"));
    assert!(text("first.txt").contains("what was finished before is kept"), "{}", text("first.txt"));
    assert_eq!(text("second.code").trim(), "0", "{}", text("second.txt"));
    assert!(text("second.txt").contains("tasks were there already"), "{}", text("second.txt"));
    same(&place.report(), &wanted, "after a full disk");
}
