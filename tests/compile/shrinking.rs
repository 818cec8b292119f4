//! Failures with fewer commands: 1-minimal, the same every time, and quick.

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use base::seed::Seed;
use compile::{Catalog, ControllerKind, compile};
use episode::walker::{WalkPolicy, log_likelihood};
use episode::{Criterion, Scenario, Trace, evaluate_observed, follow, recorded_commands};
use road::geometry::wrap_angle;
use verdict::cause::{FailureKind, Incident, Limit, Plan, Reruns, Segment, Shrunk, shrink};
use verdict::{Blame, Judged};
use world::sim::WalkCommand;

fn scenario(driver: &str) -> (Arc<Scenario>, Box<dyn WalkPolicy>) {
    let text = format!(
        "edition 1\nimport \"lib/pedestrians.scn\"\nimport \"lib/drivers.scn\"\nimport \"lib/towns.scn\"\ndriver tested = {driver}\n\
         spawn near {{ bearing: -40 deg .. 40 deg distance: 10 m .. 30 m }}\n\
         episode short {{ tick: 0.05 s hold: 10 ticks: 200 end_when: ahead < -6 m }}\n\
         campaign c {{ vehicle: model3 body: pursuer spawn: near episode: short\n\
         evaluate {{ towns: [village] drivers: [tested] pedestrians: [intercept] episodes: 1 }} }}"
    );
    let root = crate::repository().join("scenarios/test_of_shrinking.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    let evaluation = plan.campaigns[0].nth::<compile::Evaluation>(0);
    let ControllerKind::Untrained(controller) = &evaluation.controller else { panic!("it is not trained") };
    (evaluation.scenario.clone(), controller.walk_policy())
}

/// The first collisions of intercepting pedestrians.
fn incidents(driver: &str, count: usize) -> Vec<Incident> {
    let (scenario, mut walker) = scenario(driver);
    let seed = Seed::root(4);
    let mut found = Vec::new();
    let mut note = |start: u32, outcome: &episode::Outcome, trace: &Trace| {
        let judged = Judged::by(Criterion::Collision, outcome, &trace.main_pair(&scenario));
        if judged.is(Criterion::Collision, Blame::Any) && outcome.counts() {
            found.push((u64::from(start), recorded_commands(trace)));
        }
    };
    evaluate_observed(&mut *walker, &scenario, 0..200, &seed, &Seed::root(5), &mut note, &mut |_| {
        ControlFlow::Continue(())
    });
    assert!(found.len() >= count, "{} failures", found.len());
    let incident = |(start, commands)| Incident {
        scenario: scenario.clone(),
        seed,
        start,
        commands,
        criterion: Criterion::Collision,
    };
    found.into_iter().take(count).map(incident).collect()
}

/// All plans with one command less, or with one command a step away.
fn others(plan: &Plan, speeds: (f64, f64)) -> Vec<Plan> {
    let segments = &plan.pedestrians[0];
    let with = |segments: Vec<Segment>| Plan { pedestrians: vec![segments] };
    let mut all = Vec::new();
    for place in 0..segments.len() {
        for heir in [place.checked_sub(1), Some(place + 1)].into_iter().flatten().filter(|heir| *heir < segments.len())
        {
            let mut fewer = segments.clone();
            fewer[heir].decisions += segments[place].decisions;
            fewer.remove(place);
            all.push(with(fewer));
        }
        all.extend(plan.merged(0, place));
        let command = segments[place].command;
        for (turn, faster) in [(PI / 36.0, 0.0), (-PI / 36.0, 0.0), (0.0, 0.1), (0.0, -0.1)] {
            let speed = if faster == 0.0 { command.speed } else { (command.speed + faster).clamp(speeds.0, speeds.1) };
            all.push(plan.with(0, place, WalkCommand { heading: wrap_angle(command.heading + turn), speed }));
        }
    }
    all
}

#[test]
fn a_shrunk_failure_repeats_and_no_single_change_keeps_it() {
    let mut smaller = 0;
    for incident in incidents("idm()", 4) {
        let shrunk = shrink(&incident, 600).unwrap();
        let Incident { scenario, seed, start, commands, criterion } = &shrunk.incident;
        let (outcome, trace) = follow(scenario, *seed, *start, commands).expect("its commands end the episode");
        assert_eq!(outcome, shrunk.rerun.outcome, "bit for bit");
        let plan = Plan::new(commands, 1);
        assert_eq!(shrunk.counts[1], plan.count());
        assert!(shrunk.counts[1] <= shrunk.counts[0] && shrunk.limit == Limit::Minimal, "{shrunk:?}");
        smaller += usize::from(shrunk.counts[1] < shrunk.counts[0]);
        let likelihood = |trace: &Trace| {
            let pair = trace.pair(scenario, 0, 0);
            log_likelihood(&pair, pair.decisions)
        };
        let log = likelihood(&trace);
        let mut reruns = Reruns::new(&incident);
        for other in others(&plan, scenario.cast.pedestrian().action.speed) {
            let rerun = reruns.run(&other.commands()).unwrap();
            let kind = FailureKind::new(*criterion, &rerun.judged(*criterion, scenario));
            let keeps = kind.is_some_and(|kind| shrunk.kind.is_kept_by(&kind));
            let count = Plan::new(&rerun.commands, 1).count();
            let nearer = count < plan.count() || count == plan.count() && likelihood(&rerun.trace) > log + 1e-9;
            assert!(!(keeps && nearer), "{plan:?} is not minimal: {other:?}");
        }
    }
    assert!(smaller >= 3, "{smaller} of 4 have fewer commands");
}

#[test]
fn shrinking_is_the_same_every_time_and_ends_at_its_budget() {
    let incident = &incidents("idm()", 1)[0];
    let begun = Instant::now();
    let all: [Shrunk; 2] = std::array::from_fn(|_| shrink(incident, 600).unwrap());
    loud!("{} runs, {:?} for both", all[0].runs, begun.elapsed());
    assert_eq!(all[0].incident.commands, all[1].incident.commands);
    assert_eq!((all[0].runs, all[0].rerun.outcome.digest), (all[1].runs, all[1].rerun.outcome.digest));
    let cut = shrink(incident, 3).unwrap();
    assert_eq!((cut.limit, cut.runs), (Limit::Budget, 3));
    let mut other = incident.clone();
    other.commands = vec![WalkCommand { heading: 0.0, speed: 0.0 }];
    assert!(shrink(&other, 600).is_none_or(|shrunk| shrunk.counts[0] == 1), "it is shrunk only if it fails");
}
