//! A caller adds kinds of its own through the public facade: a town and a pedestrian. Scenarios name them as they name the built-in ones.

use std::io;
use std::path::Path;

use falsify::driving::Stream;
use falsify::language::{Catalog, TakenKind, TownKind, WalkerKind, keys};
use falsify::session::{Input, RunOptions, Session};
use falsify::towns::{Node, Point, Street, TownDesign, TownParts};
use falsify::walking::{PedestrianEnv, WalkCommand, WalkPolicy};

keys! {
    /// One straight street.
    struct AvenueKeys = "avenue" {
        /// How long it is.
        length: f64 as positive(LENGTH) = "200 m",
    }
}

fn avenue(AvenueKeys { length }: AvenueKeys) -> Result<TownParts, String> {
    let node = |x: f64| Node { name: format!("{x} m"), position: Point::new(x, 0.0), lights: false };
    let name = "the avenue".to_string();
    let street = Street { name, nodes: vec![0, 1], speed_limit: Some(10.0), carriageway: Default::default() };
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

    fn choose(&mut self, env: &PedestrianEnv, commands: &mut [WalkCommand]) {
        for (pedestrian, command) in env.world().pedestrians.iter().zip(commands) {
            *command = WalkCommand { heading: pedestrian.state.pose.yaw, speed: self.pace };
        }
    }
}

fn town() -> TownKind {
    TownKind::new(avenue)
}

fn walker() -> WalkerKind {
    WalkerKind::new(|StrollKeys { pace }| Stroll { pace })
}

fn session(length: &'static str) -> Session {
    let catalog = Catalog::builtin().with_town(town()).unwrap().with_walker(walker()).unwrap();
    Session::new(catalog).with_reader(move |path: &Path| match path.to_str() {
        Some("own.scn") => Ok(format!(
            r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
town broad = avenue(length: {length}) {{ tree {{ at: (50 m, 12 m) }} }}
falsifier hasty = stroll(pace: 3 m/s)
campaign own {{
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate {{ towns: [broad] policies: [blind] pedestrians: [stroll, random] episodes: 10 }}
  search {{ towns: [broad] policies: [blind] falsifiers: [hasty] budget: 2_000 runs: 1 episodes: 2 }}
}}
"#
        )),
        _ => Err(io::Error::from(io::ErrorKind::NotFound)),
    })
}

#[test]
fn a_town_and_a_pedestrian_of_the_caller_run_like_the_others() {
    let out = tempfile::tempdir().unwrap();
    let options =
        RunOptions { input: Input::file("own.scn"), out: out.path().join("reports"), ..RunOptions::default() };
    let run = session("300 m").run(&options).unwrap();
    let report = run.reports().next().unwrap();
    assert!(report.is_sound());
    let walked = |controller: &str| {
        let cell = report.cells.iter().find(|cell| cell.key.controller == controller).unwrap();
        assert_eq!((cell.key.town.as_str(), cell.episodes, cell.errors), ("broad", 10, 0));
    };
    walked("stroll");
    walked("random");
    let searches = std::fs::read_to_string(report.folder.join("searches.csv")).unwrap();
    assert!(searches.lines().nth(1).is_some_and(|row| row.contains("hasty")), "{searches}");
}

#[test]
fn a_town_that_cannot_be_built_says_why() {
    let checked = session("1 m").check(&Input::file("own.scn")).unwrap();
    let said: Vec<String> = checked.compiled.diagnostics.iter().map(|each| each.message.clone()).collect();
    assert!(said.iter().any(|message| message.contains("the avenue")), "{said:?}");
}

#[test]
fn a_name_has_one_kind() {
    let catalog = || Catalog::builtin().with_town(town()).unwrap().with_walker(walker()).unwrap();
    assert_eq!(catalog().with_town(town()).err(), Some(TakenKind { form: "town", kind: "avenue" }));
    assert_eq!(catalog().with_walker(walker()).err(), Some(TakenKind { form: "pedestrian", kind: "stroll" }));
}
