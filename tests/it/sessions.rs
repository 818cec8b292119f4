//! The program as a library: it starts no process and prints nothing.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use falsify::session::{
    CampaignOutcome, EpisodeName, Error, Event, Input, Observer, RepeatOptions, ReplayAllOptions, ReplayOptions,
    RunOptions, Session, Stop,
};

const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
campaign crossing {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [random, intercept]  episodes: 12 }
}
"#;

fn session() -> Session {
    Session::default().with_reader(|path: &Path| match path.to_str() {
        Some("crossing.scn") => Ok(SCENARIO.to_string()),
        Some("wrong.scn") => Ok(SCENARIO.replace("[blind]", "[blimd]")),
        Some("empty.scn") => Ok("edition 1\n".to_string()),
        _ => Err(io::Error::from(io::ErrorKind::NotFound)),
    })
}

fn options(out: &Path) -> RunOptions {
    RunOptions { input: Input::file("crossing.scn"), out: out.to_path_buf(), threads: 2, ..RunOptions::default() }
}

/// The first episode of a report.
fn first(report: &Path) -> EpisodeName {
    let table = std::fs::read_to_string(report.join("episodes.csv")).unwrap();
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let place = |name: &str| head.iter().position(|column| *column == name).unwrap();
    let row = lines.next().unwrap();
    format!("{}:{}", row[place("run_id")], row[place("episode")]).parse().unwrap()
}

/// Remembers the events that it receives.
#[derive(Default)]
struct Heard {
    diagnostics: Mutex<usize>,
    ended: Mutex<Vec<String>>,
}

impl Observer for Heard {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Diagnostics(diagnostics, _) => *self.diagnostics.lock().unwrap() += diagnostics.len(),
            Event::Ended(CampaignOutcome::Reported(report)) => self.ended.lock().unwrap().push(report.name.clone()),
            Event::Ended(CampaignOutcome::Empty { name, .. }) => {
                self.ended.lock().unwrap().push(format!("{name}, empty"));
            }
            _ => {}
        }
    }
}

#[test]
fn a_campaign_is_run_and_repeated_without_a_process() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("whole");
    let heard = Arc::new(Heard::default());
    let session = session().with_observer(heard.clone());
    let run = session.run(&options(&out)).unwrap();
    let report = run.reports().next().unwrap();
    assert!(report.is_sound() && report.passes() && !run.interrupted);
    assert_eq!((report.cells.len(), report.manifest.files[0].path.as_str()), (2, "crossing.scn"));
    assert_eq!(*heard.ended.lock().unwrap(), ["crossing"]);

    let name = first(&report.folder);
    let which = ReplayOptions { name, report: out.clone(), repeat: RepeatOptions::default() };
    let replay = session.replay(&which).unwrap();
    assert!(replay.episode.differences.is_empty() && replay.report.folder() == report.folder);
    let options_of_all = ReplayAllOptions { sample: std::num::NonZero::new(7), ..ReplayAllOptions::default() };
    let stored = replay.report.clone();
    let verified = session.replay_all(stored, &options_of_all, &RepeatOptions::default()).unwrap();
    assert!(verified.is_equal() && verified.repeated == 7);
}

#[test]
fn errors_are_facts_with_their_data() {
    let folder = tempfile::tempdir().unwrap();
    let heard = Arc::new(Heard::default());
    let session = session().with_observer(heard.clone());
    let run = |file: &str| session.run(&RunOptions { input: Input::file(file), ..options(folder.path()) });
    assert!(matches!(run("gone.scn"), Err(Error::Unreadable { files }) if files[0].path == Path::new("gone.scn")));
    assert!(matches!(run("wrong.scn"), Err(Error::Scenario { errors: 1 })));
    assert_eq!(*heard.diagnostics.lock().unwrap(), 1);
    assert!(matches!(run("empty.scn"), Err(Error::NoCampaign { .. })));
    let checked = session.check(&Input::file("wrong.scn"));
    assert_eq!(checked.unwrap().compiled.diagnostics.len(), 1);
    let maps = vec![("atlantis".to_string(), PathBuf::from("town.xodr"))];
    let mapped = session.plan(&Input { maps, ..Input::file("crossing.scn") });
    assert!(matches!(mapped, Err(Error::UnusedMap { town }) if town == "atlantis"));
    let name = "1a2b3c4d:17".parse().unwrap();
    let which = ReplayOptions { name, report: folder.path().join("none"), repeat: RepeatOptions::default() };
    assert!(matches!(session.replay(&which), Err(Error::NoReport { .. })));
}

#[test]
fn a_raised_flag_stops_a_session_before_its_next_task() {
    let folder = tempfile::tempdir().unwrap();
    let (stop, heard) = (Arc::new(Stop::new()), Arc::new(Heard::default()));
    assert!(!stop.ask() && stop.ask());
    let session = session().with_stop(stop).with_observer(heard.clone());
    let run = session.run(&options(folder.path())).unwrap();
    assert!(run.interrupted && run.reports().next().is_none());
    assert_eq!(*heard.ended.lock().unwrap(), ["crossing, empty"]);
}
