//! Requirements: the worked traces of the book, the signals of episodes against what else is known of these, and reports with requirements.

use std::ops::ControlFlow;
use std::path::Path;

use base::diagnostic::Sources;
use base::seed::Seed;
use base::signature::VariableId;
use compile::{Catalog, Plan, compile};
use results::campaign::watch;
use world::env::{Outcome, Trace as EpisodeTrace};
use world::judge::{LaneDeparture, NearMiss};
use world::requirement::Trace;

/// The plan of a campaign in the harbour with these requirements.
fn plan(declared: &str, names: &str, policies: &str) -> Plan {
    let text = format!(
        "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
         import \"std/requirements.scn\"\n{declared}\n\
         spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m }}\n\
         episode until_passed {{ ticks: 240  hold: 10  end_when: ahead < -6 m }}\n\
         campaign mine {{\n  vehicle: model3  adversary: plausible  spawn: near  episode: until_passed\n  requirements: [{names}]\n\
         evaluate {{ towns: [harbour]  policies: [{policies}]  pedestrians: [intercept]  episodes: 100 }}\n}}\n"
    );
    let read = |path: &Path| if path == Path::new("my.scn") { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(&["my.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{text}\n{:?}", compiled.diagnostics))
}

#[test]
fn the_worked_traces_of_the_book_are_true() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/reference/requirements.md");
    let page = std::fs::read_to_string(page).unwrap();
    let (_, table) = page.split_once("## Worked traces").unwrap();
    let (table, _) = table.split_once("\n## ").unwrap();
    let variables = Catalog::builtin().vocabulary.variables;
    let x = VariableId(variables.iter().position(|variable| variable.name == "ahead").unwrap());
    let mut lines = 0;
    for line in table.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [formula, samples, robustness, decided] = cells[..] else { panic!("{line}") };
        let formula = formula.trim_matches('`').replace('x', "ahead");
        let plan = plan(&format!("requirement worked = {formula}"), "worked", "idm");
        let requirement = &plan.campaigns[0].requirements[0].requirement;
        let mut trace = Trace::new(requirement, 8);
        for sample in samples.split(", ") {
            let value: f64 = sample.parse().unwrap();
            trace.push(requirement, &|id| if id == x { value } else { f64::NAN });
        }
        let found = trace.degree(requirement, 1.0);
        let wanted = match robustness.replace('−', "-").replace('∞', "inf").parse::<f64>() {
            Ok(wanted) => wanted,
            Err(error) => panic!("{line}: {error}"),
        };
        assert_eq!(found.robustness.to_bits(), wanted.to_bits(), "{line}: {found:?}");
        assert_eq!(found.sample.to_string(), decided, "{line}");
        lines += 1;
    }
    assert!(lines > 12, "{lines}");
}

#[test]
fn signals_agree_with_what_is_known_of_an_episode() {
    let declared = "
        requirement near = always(gap > 1000 m)
        requirement soon = always(ttc > 20 s)
        requirement encroached = always(pet > 20 s)
        requirement on_road = always(not left_road)
        requirement braked = always(ego_acceleration > -100 m/s^2)
        requirement closer = always(closing_speed < 200 m/s)
        requirement walked = always(pedestrian_acceleration < 100 m/s^2)
        requirement seen = always(in_sight)";
    let names = "no_collision, near, soon, encroached, keeps_lane, on_road, braked, closer, walked, seen";
    let plan = plan(declared, names, "behavior, blind");
    let (mut collisions, mut met, mut left, mut hidden) = (0, 0, 0, 0);
    for evaluation in &plan.campaigns[0].evaluations {
        let scenario = &evaluation.scenario;
        let mut note = |outcome: &Outcome, trace: &EpisodeTrace| {
            let pair = trace.main_pair(scenario);
            let near_miss = NearMiss::new(&pair);
            let lane = LaneDeparture::new(&pair).unwrap();
            let degrees = trace.degrees();
            assert_eq!(degrees.len(), scenario.requirements.len());
            let of = |name: &str| degrees[scenario.requirements.iter().position(|each| &*each.name == name).unwrap()];
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b} {outcome:?}");
            assert_eq!(of("no_collision").is_violated(), outcome.is_collision());
            close(of("near").robustness + 1000.0, outcome.least_gap);
            let frames: Vec<_> = pair.frames().collect();
            if !outcome.is_touch() {
                close(of("soon").robustness + 20.0, near_miss.min_ttc.unwrap_or(10.0));
                close(of("encroached").robustness + 20.0, near_miss.pet.map_or(10.0, |pet| pet.min(10.0)));
                let speeds = frames.windows(2).map(|pair| (pair[1].ego.speed - pair[0].ego.speed) / 0.05);
                close(of("braked").robustness - 100.0, speeds.fold(0.0, f64::min));
                let changes = frames
                    .windows(2)
                    .map(|two| (two[1].pedestrian.velocity - two[0].pedestrian.velocity).norm() / 0.05);
                close(100.0 - of("walked").robustness, changes.fold(0.0, f64::max));
                let sample = of("closer").sample as usize;
                let apart =
                    |frame: &world::env::Frame| (frame.pedestrian.pose.position() - frame.ego.pose.position()).norm();
                if sample > 0 && sample + 1 < frames.len() {
                    let rate = (apart(&frames[sample]) - apart(&frames[sample + 1])) / 0.05;
                    assert!((200.0 - of("closer").robustness - rate).abs() < 0.6, "{rate} {:?}", of("closer"));
                }
                met += u32::from(near_miss.pet.is_some());
            }
            assert_eq!(of("keeps_lane").is_violated(), lane.left_lane > 0.0, "{lane:?}");
            assert_eq!(of("on_road").is_violated(), lane.left_road, "{lane:?}");
            let unseen = frames.iter().position(|frame| !pair.in_sight(frame));
            assert_eq!(of("seen").is_violated(), unseen.is_some());
            if let Some(unseen) = unseen {
                assert_eq!(of("seen").sample as usize, unseen);
            }
            collisions += u32::from(outcome.is_collision());
            left += u32::from(lane.left_lane > 0.0);
            hidden += u32::from(unseen.is_some());
        };
        watch(evaluation, None, 0..100, &Seed::root(3), &mut note, &mut |_| ControlFlow::Continue(()));
    }
    assert!(collisions > 5 && met > 5 && hidden > 5, "{collisions} {met} {left} {hidden}");
}

#[test]
fn requirements_change_no_episode() {
    let with = plan("", "no_collision, safe_passing, comfort, yields_at_crosswalk, stops_at_red", "idm");
    let mut without = with.campaigns[0].evaluations[0].clone();
    without.scenario = std::sync::Arc::new(world::env::Scenario {
        requirements: [].into(),
        ..world::env::Scenario::clone(&without.scenario)
    });
    let digests = |evaluation: &compile::Evaluation| {
        let mut note = |outcome: &Outcome, _: &EpisodeTrace| (outcome.digest, outcome.reward.to_bits());
        watch(evaluation, None, 0..40, &Seed::root(3), &mut note, &mut |_| ControlFlow::Continue(()))
    };
    assert_eq!(digests(&with.campaigns[0].evaluations[0]), digests(&without));
}
