//! A caller adds kinds of its own through the public facade: a driver, a town and a pedestrian. Scenarios name them as they name the built-in ones.

use falsify::results::metrics::{EPISODES, ERRORS};
use std::collections::BTreeSet;
use std::io;
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex};

use falsify::driving::{Control, DrivingMode, DrivingPolicy, Perception, Stream};
use falsify::language::{Catalog, PolicyKind, TakenKind, TownKind, WalkerKind, keys};
use falsify::session::{Input, RepeatOptions, Repeated, ReplayOptions, RunOptions, Session};
use falsify::towns::{Carriageway, Node, Point, Street, TownDesign, TownParts};
use falsify::walking::{Scene, WalkCommand, WalkPolicy};
use program::cli::ExitCode;

keys! {
    /// Brakes all the time.
    struct BrakingKeys = "braking" {
        /// Brake, 0 to 1.
        force: f64 as share() = "1",
    }
}

/// Always brakes with the same force.
struct Braking {
    force: f64,
}

impl DrivingPolicy for Braking {
    fn reset(&mut self, _: &Perception<'_>, _: Stream) {}

    fn drive(&mut self, _: &Perception<'_>) -> Control {
        Control { throttle: 0.0, brake: self.force, steer: 0.0 }
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::EmergencyStop
    }
}

keys! {
    /// One straight street.
    struct AvenueKeys = "avenue" {
        /// How long it is.
        length: f64 as positive(LENGTH) = "200 m",
    }
}

fn avenue(AvenueKeys { length }: AvenueKeys) -> Result<TownParts, String> {
    let node = |x: f64| Node { name: format!("{x} m"), position: Point::new(x, 0.0), lights: false };
    let (name, carriageway) = ("the avenue".to_string(), Carriageway::default());
    let street = Street { name, nodes: vec![0, 1], speed_limit: Some(10.0), carriageway };
    let design = TownDesign { nodes: vec![node(0.0), node(length)], streets: vec![street], ..TownDesign::default() };
    design.build().map_err(|faults| faults[0].to_string())
}

keys! {
    /// Strolls in the direction in which it looks.
    struct StrollKeys = "stroll" {
        /// How fast it walks.
        pace: f64 as non_negative(SPEED) = "1 m/s",
    }
}

#[derive(Debug, Clone)]
struct Stroll {
    pace: f64,
}

impl Default for Stroll {
    fn default() -> Self {
        Self { pace: 1.0 }
    }
}

impl WalkPolicy for Stroll {
    fn begin(&mut self, _: Stream) {}

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        for (pedestrian, command) in scene.world.pedestrians.iter().zip(commands) {
            *command = WalkCommand { heading: pedestrian.state.pose.yaw, speed: self.pace };
        }
    }
}

/// The forces of the drivers that were made, in percent.
type Made = Arc<Mutex<BTreeSet<i64>>>;

fn braking(made: &Made) -> PolicyKind {
    let made = made.clone();
    PolicyKind::new(move |BrakingKeys { force }| {
        made.lock().unwrap().insert((100.0 * force) as i64);
        Braking { force }
    })
}

fn stroll() -> WalkerKind {
    WalkerKind::new(|StrollKeys { pace }| Stroll { pace })
}

/// A catalogue with all three kinds.
fn catalog(made: &Made) -> Catalog {
    let with_policy = Catalog::builtin().with_policy(braking(made)).unwrap();
    with_policy.with_town(TownKind::new(avenue)).unwrap().with_walker(stroll()).unwrap()
}

fn session(catalog: Catalog, length: &'static str) -> Session {
    Session::new(catalog).with_reader(move |path: &Path| match path.to_str() {
        Some("own.scn") => Ok(format!(
            r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/sensors.scn"
driver firm = braking()
driver soft = braking(force: 0.25, sensors: perfect)
town broad = avenue(length: {length}) {{ tree {{ at: (50 m, 12 m) }} }}
method hasty = stroll(pace: 3 m/s)
campaign own {{
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate {{ towns: [broad] drivers: [firm, soft] pedestrians: [stroll, random] episodes: 10 }}
  search {{ towns: [broad] drivers: [soft] methods: [hasty] budget: 2_000 runs: 1 episodes: 2 }}
}}
"#
        )),
        _ => Err(io::Error::from(io::ErrorKind::NotFound)),
    })
}

#[test]
fn kinds_of_the_caller_are_checked_and_run_like_the_others() {
    let (made, out) = (Made::default(), tempfile::tempdir().unwrap());
    let options =
        RunOptions { input: Input::file("own.scn"), out: out.path().join("reports"), ..RunOptions::default() };
    let run = session(catalog(&made), "300 m").run(&options).unwrap();
    let report = run.reports().next().unwrap();
    assert!(report.is_sound());
    for (policy, controller) in [("firm", "stroll"), ("firm", "random"), ("soft", "stroll"), ("soft", "random")] {
        let is_it = |key: &&falsify::results::Cell| (&*key.key.policy, &*key.key.controller) == (policy, controller);
        let cell = report.cells.iter().find(is_it).unwrap();
        assert_eq!((cell.key.town.as_str(), cell.count(&EPISODES), cell.count(&ERRORS)), ("broad", 10, 0));
    }
    assert_eq!(*made.lock().unwrap(), [25, 100].into(), "the default and the value of the key reach the driver");
    let table = |name: &str| std::fs::read_to_string(report.folder.join(name)).unwrap();
    let episodes = table("episodes.csv");
    let run = episodes.lines().nth(1).and_then(|row| row.split(',').next()).unwrap();
    let replayed = ReplayOptions {
        name: format!("{run}:0").parse().unwrap(),
        report: report.folder.clone(),
        repeat: RepeatOptions::default(),
    };
    let Repeated { scenario, trace, .. } = session(catalog(&made), "300 m").replay(&replayed).unwrap().episode;
    let pair = trace.main_pair(&scenario);
    assert!(pair.frames().len() > 1 && pair.frames().skip(1).all(|frame| frame.mode == DrivingMode::EmergencyStop));
    assert!(table("searches.csv").lines().nth(1).is_some_and(|row| row.contains("hasty")));
}

#[test]
fn a_town_that_cannot_be_built_says_why() {
    let checked = session(catalog(&Made::default()), "1 m").check(&Input::file("own.scn")).unwrap();
    let said: Vec<String> = checked.compiled.diagnostics.iter().map(|each| each.message.clone()).collect();
    assert!(said.iter().any(|message| message.contains("the avenue")), "{said:?}");
}

#[test]
fn a_kind_that_the_catalogue_lacks_is_an_error_and_so_is_one_that_it_has() {
    assert!(session(Catalog::builtin(), "300 m").check(&Input::file("own.scn")).unwrap().plan().is_err());
    let (made, taken) = (Made::default(), |form, kind| Some(TakenKind { form, kind }));
    assert_eq!(catalog(&made).with_policy(braking(&made)).err(), taken("driver", "braking"));
    assert_eq!(catalog(&made).with_town(TownKind::new(avenue)).err(), taken("town", "avenue"));
    assert_eq!(catalog(&made).with_walker(stroll()).err(), taken("pedestrian", "stroll"));
}

fn own_language() -> Catalog {
    catalog(&Made::default())
}

/// A program of the caller, which [`the_command_line_knows_the_kinds_of_the_caller`] starts: the command line takes over its process, so that a
/// panic of a neighbour would end the tests.
#[test]
#[ignore = "a process of its own runs it"]
fn commands_with_own_kinds() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
driver soft = braking(force: 0.25)
campaign own {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour] drivers: [soft] pedestrians: [stroll, intercept] episodes: 10 }
}
"#;
    let (file, out) = (folder.path().join("own.scn"), folder.path().join("reports"));
    std::fs::write(&file, scenario).unwrap();
    let [file, out] = [file, out].map(|path| path.to_str().unwrap().to_owned());
    let command = |language, arguments: &[&str]| {
        let given = std::iter::once("falsify").chain(arguments.iter().copied()).map(Into::into);
        program::cli::command_line(language, given)
    };
    assert_eq!(command(own_language, &["check", &file]), ExitCode::Done);
    assert_eq!(command(own_language, &["run", &file, "--out", &out]), ExitCode::Done);
    let table = std::fs::read_to_string(Path::new(&out).join("own/episodes.csv")).unwrap();
    let row: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
    let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let value = |name: &str| row[head.iter().position(|column| *column == name).unwrap()];
    let name = format!("{}:{}", value("run_id"), value("episode"));
    assert_eq!(command(own_language, &["replay", &name, "--report", &out]), ExitCode::Done);
    assert_eq!(command(own_language, &["explain", "driver", "braking"]), ExitCode::Done);
    assert_eq!(command(Catalog::builtin, &["check", &file]), ExitCode::Scenario);
}

#[test]
fn the_command_line_knows_the_kinds_of_the_caller() {
    let mut program = Command::new(std::env::current_exe().unwrap());
    let output = program.args(["own_kinds::commands_with_own_kinds", "--exact", "--ignored"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("1 passed"), "{output:?}");
}
