//! A quick check before a full run changes nothing of it, for every kind of job.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use base::diagnostic::Sources;
use compile::{Campaign, Catalog, Evaluation, compile};
use falsify::session::{Input, RunOptions, Session};
use results::campaign::tasks;
use results::jobs::{KINDS, work};
use results::store::Ids;

const SCENARIO: &str = r#"
edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/rewards.scn"
import "std/towns.scn"
driver hasty = idm(time_headway: 0.3 s)
driver patient = idm(time_headway: 4 s)
spawn moving { ego_speed: 20 km/h .. 50 km/h  bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m }
episode short { ticks: 60  hold: 10 }
training quick = ppo(steps: 240, steps_per_update: 40, epochs: 2, batch_size: 40, environments: 1, hidden: [8])
method meet = intercept()
method learner = ppo(reward: fault, training: quick)
campaign all {
  vehicle: model3  body: plausible  spawn: moving  episode: short  training: quick  price: 8
  train { towns: [village]  drivers: [idm]  rewards: [fault]  runs: 2 }
  drive { towns: [village]  imitates: idm  demonstrations: 1_500  runs: 2  cars: 1 }
  evaluate { towns: [village]  drivers: [idm]  pedestrians: [trained, stochastic, untrained, random, intercept]  episodes: 8 }
  search { towns: [village]  drivers: [idm]  methods: [meet, learner]  budget: 2_000  runs: 2  episodes: 7 }
  estimate { towns: [village]  drivers: [idm]  budget: 4_000  relative_error: 0.01  runs: 2 }
  cover { towns: [village]  drivers: [idm]  pedestrian: intercept  failure: collision  epsilon: 10 percent  budget: 90 }
  harden { towns: [village]  test_towns: [harbour]  driver: idm  from: hasty  to: patient  methods: [meet]  rivals: [meet]
    budget: 1_500  rounds: 2  candidates: 4  lessons: 3  traffic: 3  episodes: 6  runs: 2 }
}
"#;

fn read(path: &Path) -> io::Result<String> {
    if path == Path::new("all.scn") { Ok(SCENARIO.to_string()) } else { Err(io::ErrorKind::NotFound.into()) }
}

fn campaign() -> Campaign {
    let compiled = compile(&["all.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics)).campaigns.remove(0)
}

#[test]
fn shortened_jobs_have_other_names() {
    let full = campaign();
    let mut short = full.clone();
    short.shorten();
    let kinds: BTreeSet<&str> = full.jobs.iter().map(|job| work(job).kind().name).collect();
    assert_eq!(kinds, KINDS.iter().map(|kind| kind.name).collect(), "every kind has a job here");
    let named = |campaign: &Campaign| -> BTreeMap<String, String> {
        let ids = Ids::new(campaign, 1);
        let of = |task: results::campaign::Task| {
            let job = &campaign.jobs[task.job];
            // The first episodes of a pedestrian that was not trained are the same for any number.
            let is_prefix = job.of::<Evaluation>().is_some_and(|job| job.origin.needs.is_none());
            (!is_prefix).then(|| (ids.get(task).to_string(), work(job).what()))
        };
        tasks(campaign).filter_map(of).collect()
    };
    let (full, short) = (named(&full), named(&short));
    let same: Vec<&String> = short.iter().filter(|(id, _)| full.contains_key(*id)).map(|(_, what)| what).collect();
    assert!(short.len() >= KINDS.len() && same.is_empty(), "{same:?}");
}

/// The files of a report with what they hold, except the manifest, which has times.
fn files(report: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut open = vec![report.to_path_buf()];
    let mut all = BTreeMap::new();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(report).unwrap().to_string_lossy().into_owned();
            match path.is_dir() {
                true => open.push(path),
                false if name == "manifest.toml" || name == "report.html" => {}
                false => drop(all.insert(name, std::fs::read(&path).unwrap())),
            }
        }
    }
    all
}

#[test]
fn a_full_run_after_a_quick_check_is_a_full_run() {
    let folder = tempfile::tempdir().unwrap();
    let session = Session::default().with_reader(read);
    let run = |out: &str, smoke: bool| {
        let out = folder.path().join(out);
        let options =
            RunOptions { input: Input::file("all.scn"), out: out.clone(), smoke, threads: 2, ..RunOptions::default() };
        session.run(&options).unwrap();
        files(&out.join(if smoke { "all-smoke" } else { "all" }))
    };
    let alone = run("alone", false);
    assert!(alone.keys().any(|name| name.starts_with("drivers/")) && alone.contains_key("hardened.csv"));
    let short = run("after", true);
    assert!(short["covers.csv"] != alone["covers.csv"] && short["estimates.csv"] != alone["estimates.csv"]);
    // Twice, so that the second one replaces the report of the first.
    for after in [run("after", false), run("after", false)] {
        let differing: Vec<&String> = alone.keys().filter(|name| alone.get(*name) != after.get(*name)).collect();
        assert!(alone.len() == after.len() && differing.is_empty(), "{differing:?}");
    }
    let manifest = std::fs::read_to_string(folder.path().join("alone/all/manifest.toml")).unwrap();
    assert!(!manifest.contains("\"00000000\""), "a training is recorded as a run without a name");
    let page = std::fs::read_to_string(folder.path().join("alone/all/report.html")).unwrap();
    for sentence in ["With 95 % confidence no collision", "in an encounter with natural: "] {
        let said = manifest.lines().any(|line| line.contains(sentence));
        assert!(said && page.contains(sentence), "{sentence}: {manifest}");
    }
}
