//! A driver that leaves the road: a warning leads its report, and its episodes are in no rate unless the scenario asks for them.

use falsify::results::metrics::{
    ALL_EPISODES, COLLISION_RATE, COLLISIONS, EPISODES, FAULT_RATE, LEFT_OUT_EPISODES, LEFT_ROAD_EPISODES,
    PLACED_STARTS, ROAD_END_EPISODES,
};
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex};

use falsify::driving::{Control, DrivingMode, DrivingPolicy, Perception, Stream};
use falsify::language::{Catalog, PolicyKind, keys};
use falsify::session::{CampaignReport, Event, Input, Notice, Observer, RunOptions, Session};

keys! {
    /// Steers constantly, whatever its route.
    struct CirclingKeys = "circling" {
        /// Steer, 0 to 1 to the left.
        steer: f64 as share() = "0.3",
    }
}

struct Circling {
    steer: f64,
}

impl DrivingPolicy for Circling {
    fn reset(&mut self, _: &Perception<'_>, _: Stream) {}

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let throttle = if perception.ego.speed() < 5.0 { 0.5 } else { 0.0 };
        Control { throttle, brake: 0.0, steer: self.steer }
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::Cruise
    }
}

const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
driver lost = circling()
method home = homing()
episode brief { ticks: 200 traffic_lights: false KEYS }
spawn steady { distance: 15 m .. 25 m }
campaign lost {
  vehicle: model3  body: suicidal  spawn: steady  episode: brief
  evaluate { towns: [harbour]  drivers: [lost, blind]  pedestrians: [homing]  episodes: 20 }
  search { towns: [harbour]  drivers: [lost]  methods: [home]  budget: 8_000  runs: 1  episodes: 2 }
}
"#;

/// The warnings of a run.
#[derive(Default)]
struct Heard(Mutex<Vec<String>>);

impl Observer for Heard {
    fn event(&self, event: &Event<'_>) {
        if let Event::Notice(notice @ Notice::Caution { .. }) = event {
            self.0.lock().unwrap().push(notice.to_string());
        }
    }
}

/// Runs the scenario with further keys of its episode, and looks at the report.
fn run(keys: &'static str, look: impl FnOnce(&CampaignReport, &[String])) {
    run_text(SCENARIO.replace("KEYS", keys), look);
}

/// Runs a scenario with the driver that circles, and looks at the report.
fn run_text(text: String, look: impl FnOnce(&CampaignReport, &[String])) {
    let catalog = Catalog::builtin().with_policy(PolicyKind::new(|CirclingKeys { steer }| Circling { steer })).unwrap();
    let heard = Arc::new(Heard::default());
    let session =
        Session::new(catalog).with_observer(heard.clone()).with_reader(move |path: &Path| match path.to_str() {
            Some("lost.scn") => Ok(text.clone()),
            _ => Err(io::Error::from(io::ErrorKind::NotFound)),
        });
    let out = tempfile::tempdir().unwrap();
    let options =
        RunOptions { input: Input::file("lost.scn"), out: out.path().join("reports"), ..RunOptions::default() };
    let run = session.run(&options).unwrap();
    look(run.reports().next().unwrap(), &heard.0.lock().unwrap());
}

/// The values of some columns in a table of a report.
fn columns<const N: usize>(report: &CampaignReport, table: &str, names: [&str; N]) -> Vec<[String; N]> {
    let text = std::fs::read_to_string(report.folder.join(table)).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let places = names.map(|name| head.iter().position(|column| *column == name).unwrap());
    lines.map(|row| places.map(|place| row[place].trim_matches('"').to_string())).collect()
}

#[test]
fn a_driver_that_circles_has_a_warning_and_no_rate() {
    run("", |report, warnings| {
        let cell = |policy: &str| report.cells.iter().find(|cell| cell.key.policy == policy).unwrap();
        let lost = cell("lost");
        assert_eq!(
            (
                lost.count(&ALL_EPISODES),
                lost.count(&LEFT_OUT_EPISODES),
                lost.count(&PLACED_STARTS),
                lost.count(&EPISODES)
            ),
            (20, 20, 20, 0)
        );
        assert_eq!((lost.count(&COLLISIONS), lost.value(&COLLISION_RATE), lost.value(&FAULT_RATE)), (0, None, None));
        let blind = cell("blind");
        assert_eq!(
            (
                blind.count(&ALL_EPISODES),
                blind.count(&LEFT_OUT_EPISODES),
                blind.count(&LEFT_ROAD_EPISODES),
                blind.count(&EPISODES)
            ),
            (20, 0, 0, 20)
        );
        assert!(blind.count(&COLLISIONS) > 0);

        let [warning] = warnings else { panic!("{warnings:?}") };
        assert!(warning.starts_with("`lost` in harbour did not reach its start in 20 of 20 run-ups"), "{warning}");
        assert!(warning.contains("none of its episodes counts, so it has no rates there"), "{warning}");
        let summary = std::fs::read_to_string(report.folder.join("summary.md")).unwrap();
        let at = |text: &str| summary.find(text).unwrap_or_else(|| panic!("{text} is not in {summary}"));
        assert!(at(&format!("**{warning}.**")) < at("| driver"), "it leads the summary");
        let page = std::fs::read_to_string(report.folder.join("report.html")).unwrap();
        assert!(page.contains("did not reach its start in 20 of 20 run-ups"));

        let rows = columns(report, "episodes.csv", ["driver", "left_out"]);
        let of = |policy: &str, reason: &str| rows.iter().filter(|row| row[0] == policy && row[1] == reason).count();
        assert_eq!((of("lost", "run_up"), of("blind", ""), rows.len()), (20, 20, 40), "the table holds all rows");
        let [search] = &columns(report, "searches.csv", ["episodes", "left_out_episodes", "failures"])[..] else {
            panic!("there is one search")
        };
        assert_eq!([&search[0], &search[2]], ["0", "0"], "a search finds no failure of a lost driver");
        assert_ne!(search[1], "0");
    });
}

#[test]
fn a_scenario_can_count_the_episodes_of_a_lost_driver() {
    run("count_all: true", |report, warnings| {
        let lost = report.cells.iter().find(|cell| cell.key.policy == "lost").unwrap();
        assert_eq!(
            (
                lost.count(&ALL_EPISODES),
                lost.count(&LEFT_OUT_EPISODES),
                lost.count(&PLACED_STARTS),
                lost.count(&EPISODES)
            ),
            (20, 0, 20, 20)
        );
        assert!(lost.value(&COLLISION_RATE).is_some() && lost.count(&LEFT_ROAD_EPISODES) > 0);
        assert!(warnings.iter().any(|warning| warning.contains("its figures there say little")), "{warnings:?}");
    });
}

#[test]
fn what_happens_past_the_end_of_a_map_counts_for_nothing() {
    let short = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
driver straight = circling(steer: 0)
town strip { street only { through: [(0 m, 0 m), (90 m, 0 m)] } }
episode brief { ticks: 400 traffic_lights: false }
campaign lost {
  vehicle: model3  body: suicidal  spawn: ahead  episode: brief
  evaluate { towns: [strip]  drivers: [straight, blind]  pedestrians: [homing]  episodes: 40 }
}
"#;
    run_text(short.to_owned(), |report, warnings| {
        let rows = columns(report, "episodes.csv", ["driver", "left_out", "fault", "left_road"]);
        let past = rows.iter().filter(|row| row[1] == "road_end").count();
        assert!(past >= 10, "{past} of {}", rows.len());
        assert!(rows.iter().all(|row| row[0] == "straight" || row[1].is_empty()), "our own drivers stop at the end");
        let straight = report.cells.iter().find(|cell| cell.key.policy == "straight").unwrap();
        assert_eq!(
            (straight.count(&ROAD_END_EPISODES) as usize, straight.count(&LEFT_OUT_EPISODES) as usize),
            (past, past)
        );
        let [warning] = warnings else { panic!("{warnings:?}") };
        assert!(warning.starts_with("`straight` in strip drove past the end of the road in"), "{warning}");
        assert!(warning.contains("make the road longer"), "{warning}");
    });
}

#[test]
fn drivers_slow_down_for_a_corner_in_a_junction_but_for_the_two_that_the_explanation_of_fast_bend_names() {
    let town = |limit: &str| -> String {
        let ways = ["(-400 m, 0 m), (0 m, 0 m), (0 m, 400 m)", "(0 m, -400 m), (0 m, 0 m)", "(0 m, 0 m), (400 m, 0 m)"];
        let street = |(name, way)| format!("street {name} {{ through: [{way}]  speed_limit: {limit} km/h }}\n");
        ["a", "b", "c"].into_iter().zip(ways).map(street).collect()
    };
    let drivers = [
        ("agent", "behavior_agent()"),
        ("lav", "lav()"),
        ("idm", "idm()"),
        ("guard", "rss_guarded()"),
        ("blind", "cruise()"),
    ];
    for (limit, lost) in [("30", &[][..]), ("50", &["p_agent", "p_lav"])] {
        let policies: String = drivers.iter().map(|(name, kind)| format!("driver p_{name} = {kind}\n")).collect();
        let text = format!(
            "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\n{policies}town corner {{\n{}}}\n\
             spawn near {{ ego_lane {{ from: (-60 m, -1.75 m, 0 deg)  length: 5 m }}\n  bearing: -60 deg .. 60 deg  distance: 25 m .. 60 m }}\n\
             episode e {{ hold: 10  ticks: 300 }}\ncampaign c {{\n  vehicle: model3  body: plausible  spawn: near  episode: e\n\
             evaluate {{ towns: [corner]  drivers: [p_agent, p_lav, p_idm, p_guard, p_blind]  pedestrians: [random]  episodes: 20 }}\n}}\n",
            town(limit)
        );
        run_text(text, |report, _| {
            let rates = columns(report, "metrics.csv", ["driver", "metric", "value"]);
            for [policy, _, rate] in rates.iter().filter(|[_, metric, _]| metric == "left_road_rate") {
                let is_lost = rate.parse::<f64>().unwrap() > 0.1;
                assert_eq!(is_lost, lost.contains(&policy.as_str()), "{policy} at {limit} km/h: {rate}");
            }
        });
    }
}
