//! Failures repeated with reference drivers.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use base::seed::Seed;
use compile::{Catalog, compile};
use episode::walker::Intercept;
use episode::{Actions, Draw, Ending, Observer, Outcome, Scenario, Scene, Trace, VehicleFrame, evaluate_observed};
use road::geometry::{Obstacles, OrientedBox, Pose, Vector};
use verdict::{
    ContactSide, Encounter, FalseAlarms, Inquiry, Label, Recording, Reference, Sight, Trial, judge, share_of_drivers,
};
use world::av::reference_drivers::{OwnMotion, ReferenceDriver, Threat};
use world::sim::{ActorId, Contact, PedestrianState, VehicleState, World};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
campaign judged {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [harbour] drivers: [behavior] rewards: [r1] runs: 1 }
  evaluate { towns: [harbour] drivers: [behavior, blind] pedestrians: [intercept] episodes: 1 }
}
"#;

fn scenario(policy: &str) -> Arc<Scenario> {
    let root = crate::repository().join("scenarios/judged.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.unwrap();
    let evaluation = plan.campaigns[0].all::<compile::Evaluation>().find(|each| *each.policy == *policy).unwrap();
    evaluation.scenario.clone()
}

/// The episodes of an intercepting controller.
fn episodes(scenario: &Arc<Scenario>, count: u32) -> Vec<(Outcome, Trace)> {
    let seed = Seed::root(5);
    let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
    evaluate_observed(&mut Intercept, scenario, 0..count, &seed, &seed.child("walker"), note, &mut |_| {
        ControlFlow::Continue(())
    })
}

/// A driver that never brakes.
struct Never;

impl ReferenceDriver for Never {
    fn begin(&mut self) {}

    fn has_noticed(&self) -> bool {
        false
    }

    fn brake(&mut self, _: &OwnMotion, _: Option<&Threat>, _: f64) -> Option<f64> {
        None
    }
}

#[test]
fn a_recording_repeats_its_episode_bit_by_bit() {
    let scenario = scenario("behavior");
    for (episode, (outcome, trace)) in episodes(&scenario, 60).into_iter().enumerate() {
        let mut env = scenario.simulation();
        env.start(Draw::new(&Seed::root(5), episode as u64));
        for command in trace.decisions(0) {
            env.carry_out(&[*command]);
        }
        assert_eq!(env.outcome(), Some(&outcome));
        assert_eq!(trace.main_pair(&scenario).len(), outcome.ticks as usize + 1);
        assert_eq!(trace.contact().is_some(), outcome.is_touch());
    }
}

/// What another simulator would have recorded of an episode: poses and speeds.
fn recorded(scenario: &Scenario, trace: &Trace) -> Recording {
    let car = |frame: &VehicleFrame| VehicleState {
        pose: frame.state.pose,
        speed: frame.state.speed,
        age: 0.0,
        ..VehicleState::default()
    };
    let walker = |state: &PedestrianState| PedestrianState::moving(state.pose, state.speed());
    let ego = trace.vehicle(0).iter().map(car).collect();
    Recording::new(scenario.episode.tick, ego, trace.pedestrian(0).iter().map(walker).collect()).unwrap()
}

#[test]
fn a_recording_of_an_episode_has_its_verdict() {
    for policy in ["behavior", "blind"] {
        let scenario = scenario(policy);
        let mut labels = BTreeSet::new();
        for (outcome, trace) in episodes(&scenario, 100) {
            let pair = trace.main_pair(&scenario);
            let found = recorded(&scenario, &trace).judged(&scenario, scenario.obstacles.clone());
            assert_eq!(found.touch.is_some(), outcome.is_touch());
            let (Some(touch), Some(verdict), Some(wanted)) = (found.touch, found.verdict, judge(&pair)) else {
                continue;
            };
            assert!((touch - outcome.duration).abs() < 1e-9, "{touch} s, {} s", outcome.duration);
            assert_eq!(
                (verdict.label, verdict.side, verdict.foreseeable),
                (wanted.label, wanted.side, wanted.foreseeable)
            );
            assert_eq!(verdict.impact_speed, wanted.impact_speed);
            assert!((verdict.warning - wanted.warning).abs() < 1e-9);
            for reference in Reference::ALL {
                let (trial, other) = (verdict.trial(reference), wanted.trial(reference));
                assert_eq!(trial.is_avoided(), other.is_avoided());
                assert!((trial.least_gap - other.least_gap).abs() < 1e-6, "{trial:?}, {other:?}");
            }
            labels.insert(verdict.label);
        }
        assert!(labels.len() > 1, "{labels:?}");
    }
}

#[test]
fn a_driver_that_does_nothing_hits_when_the_recorded_one_did() {
    let scenario = scenario("blind");
    let mut compared = 0;
    for (outcome, trace) in episodes(&scenario, 150) {
        let pair = trace.main_pair(&scenario);
        let Some(mut encounter) = Encounter::new(&pair) else { continue };
        let begun = pair.len() - encounter.speeds.len();
        let speeds = pair.frames().skip(begun).map(|frame| frame.ego.speed);
        assert!(speeds.zip(&encounter.speeds).all(|(speed, same)| speed == *same));
        compared += 1;
        let trial = Trial::new(&mut encounter, &mut Never);
        let ticks = |time: f64| ((time - 1e-9) / scenario.episode.tick).floor();
        assert_eq!(ticks(trial.time), ticks(encounter.warning), "{trial:?}, {} s", encounter.warning);
        let Ending::Touch { impact_speed, .. } = outcome.ending else { unreachable!("there is an encounter") };
        assert!((trial.impact_speed.unwrap_or(0.0) - impact_speed).abs() < 0.25, "{trial:?}, {impact_speed} m/s");
    }
    assert!(compared > 20, "only {compared} runs could be compared");
}

#[test]
fn verdicts_are_given_for_failures_alone_and_agree_with_their_trials() {
    let scenario = scenario("behavior");
    let mut labels = Vec::new();
    for (outcome, trace) in episodes(&scenario, 200) {
        let verdict = judge(&trace.main_pair(&scenario));
        assert_eq!(verdict.is_some(), outcome.is_touch());
        let Some(verdict) = verdict else { continue };
        let Ending::Touch { impact_speed, .. } = outcome.ending else { unreachable!("it is a collision") };
        assert_eq!(verdict.label == Label::Bump, impact_speed <= 0.1);
        assert!(verdict.warning > 0.0 && verdict.warning <= outcome.duration + 1e-9);
        if verdict.label == Label::Unpreventable {
            assert!(!verdict.trial(Reference::Bound).is_avoided());
        }
        for reference in Reference::ALL {
            let trial = verdict.trial(reference);
            assert!(trial.least_gap >= 0.0 && verdict.reduction(reference) <= impact_speed);
            assert!(trial.is_avoided() || trial.least_gap == 0.0);
        }
        assert!(!verdict.foreseeable || verdict.fast, "at 3.5 m/s at once");
        labels.push(verdict.label);
    }
    assert!(labels.contains(&Label::Bump) && labels.iter().any(|label| *label != Label::Bump), "{labels:?}");
}

/// A car drives east at 10 m/s for three seconds and then touches the pedestrian, who comes from the left.
fn run_out(obstacles: &[OrientedBox], speed: impl Fn(f64) -> f64) -> (Scenario, Trace) {
    let mut scenario = Scenario::clone(&scenario("blind"));
    scenario.obstacles = Arc::new(Obstacles::new(obstacles));
    let (town, obstacles, body) = (scenario.town.clone(), scenario.obstacles.clone(), scenario.cast.pedestrian().body);
    let mut world = World::new(town, obstacles, vec![scenario.cast.ego().blueprint.clone()], vec![body], None, 0.05);
    let mut trace = Trace::new(&scenario);
    // After 3 s the bumper is at 30 m and the pedestrian in the middle of it.
    let walked = |time: f64| (0..(time * 1000.0) as u32).map(|i| speed(f64::from(i) / 1000.0) / 1000.0).sum::<f64>();
    let end = walked(3.0);
    let mut actions = Actions::new(&scenario.cast);
    for tick in 0..=60 {
        let time = f64::from(tick) * 0.05;
        world.vehicles[0].state.pose = Pose::new(10.0 * time - scenario.cast.ego().blueprint.half_length, 0.0, 0.0);
        world.vehicles[0].state.speed = 10.0;
        let aside = end - walked(time);
        world.pedestrians[0].state.pose = Pose::new(30.0 + body.radius, aside, -std::f64::consts::FRAC_PI_2);
        world.pedestrians[0].state.velocity = Vector::new(0.0, -speed(time));
        let ahead = scenario.cast.ego().blueprint.half_length + body.radius;
        let contact = Contact {
            pair: (ActorId::EGO, ActorId::Pedestrian(0)),
            fraction: 1.0,
            bearing: 0.0,
            ahead,
            aside: 0.0,
            impact_speed: 10.0,
        };
        actions.contact = (tick == 60).then_some(contact);
        let scene = Scene::new(&scenario, &world, &actions);
        if tick == 0 { trace.begin(&scene) } else { trace.tick(&scene) }
    }
    (scenario, trace)
}

#[test]
fn the_danger_begins_when_the_pedestrian_can_be_seen() {
    let (scenario, open) = run_out(&[], |_| 1.39);
    let verdict = judge(&open.main_pair(&scenario)).unwrap();
    // The gate opens 24.6 m before the touch. The careful human needs 21.3 m from 10 m/s with the brake of this car, the attentive one 17.3 m.
    assert!((verdict.warning - 3.0).abs() < 1e-9 && verdict.label == Label::Preventable, "{verdict:?}");
    assert!((verdict.margin(Reference::CarefulHuman) - 3.3).abs() < 0.1, "{verdict:?}");
    // Without any reaction time it needs 9.9 m, so 1.47 s are left.
    let latest = verdict.latest_reaction.unwrap();
    assert!((latest - 1.47).abs() < 0.03, "{latest}");
    assert_eq!(verdict.preventable_probability(), share_of_drivers(latest));
    assert_eq!((verdict.side, verdict.walked_into), (ContactSide::Front, false));
    // A wall along the lane, 1.9 m from the middle, that ends a metre before the pedestrian's path.
    let wall = OrientedBox::new(Pose::new(4.0, 2.4, 0.0), 25.0, 0.5);
    let (scenario, hidden) = run_out(&[wall], |_| 1.39);
    let hidden = judge(&hidden.main_pair(&scenario)).unwrap();
    // It is seen when its front edge appears: about 1.9 m to the side, 1.4 s before the touch.
    assert!((1.3..1.7).contains(&hidden.warning), "{hidden:?}");
    assert!(!hidden.trial(Reference::CarefulHuman).is_avoided() && hidden.trial(Reference::IdealBrake).is_avoided());
    assert!(hidden.latest_reaction.unwrap() < 0.6, "{hidden:?}");
    assert!(!hidden.foreseeable || verdict.foreseeable);
}

#[test]
fn an_inquiry_gives_the_answers_of_the_verdict_in_any_order() {
    let scenario = scenario("behavior");
    for (_, trace) in episodes(&scenario, 100) {
        let pair = trace.main_pair(&scenario);
        let Some(verdict) = judge(&pair) else { continue };
        let mut inquiry = Inquiry::new(&pair).unwrap();
        assert_eq!(inquiry.is_preventable(), verdict.is_preventable());
        assert_eq!(inquiry.latest_reaction(), verdict.latest_reaction);
        for reference in Reference::ALL.into_iter().rev() {
            assert_eq!(inquiry.trial(reference), *verdict.trial(reference), "{reference:?}");
            assert_eq!(inquiry.reduction(reference), verdict.reduction(reference));
        }
        assert_eq!(inquiry.label(), verdict.label);
        // The two humans are two points of the distribution.
        if let Some(latest) = verdict.latest_reaction {
            assert!(!verdict.is_preventable() || latest >= 1.15, "{verdict:?}");
            assert_eq!(latest >= 0.75, verdict.trial(Reference::AttentiveHuman).is_avoided(), "{verdict:?}");
        }
    }
}

#[test]
fn false_alarms_are_those_of_episodes_that_end_well() {
    let scenario = scenario("behavior");
    let (mut looked_at, mut stops) = (0, [0; Reference::COUNT]);
    for (outcome, trace) in episodes(&scenario, 200) {
        let alarms = FalseAlarms::new(&trace.main_pair(&scenario));
        assert_eq!(alarms.is_none(), outcome.is_touch());
        let Some(alarms) = alarms else { continue };
        looked_at += 1;
        for (count, reference) in stops.iter_mut().zip(Reference::ALL) {
            assert!(alarms.braked(reference) || !alarms.stopped(reference), "{reference:?}");
            *count += u32::from(alarms.stopped(reference));
        }
    }
    assert!(looked_at > 20, "only {looked_at} episodes");
    assert!(stops[Reference::CarefulHuman as usize] <= stops[Reference::Bound as usize], "{stops:?}");
}

/// Of a recording without a touch: the car drives past a pedestrian who stands this far from its axis (m), or who walks away.
fn pass(aside: f64, speed: f64) -> FalseAlarms {
    let (scenario, _) = run_out(&[], |_| 0.0);
    let (town, body) = (scenario.town.clone(), scenario.cast.pedestrian().body);
    let blueprint = scenario.cast.ego().blueprint.clone();
    let mut world = World::new(town, scenario.obstacles.clone(), vec![blueprint.clone()], vec![body], None, 0.05);
    let mut trace = Trace::new(&scenario);
    let actions = Actions::new(&scenario.cast);
    for tick in 0..=120 {
        let time = f64::from(tick) * 0.05;
        world.vehicles[0].state.pose = Pose::new(8.0 * time - blueprint.half_length, 0.0, 0.0);
        world.vehicles[0].state.speed = 8.0;
        world.pedestrians[0].state.pose = Pose::new(30.0, aside - speed * time, 0.0);
        world.pedestrians[0].state.velocity = Vector::new(0.0, -speed);
        let scene = Scene::new(&scenario, &world, &actions);
        if tick == 0 { trace.begin(&scene) } else { trace.tick(&scene) }
    }
    FalseAlarms::new(&trace.main_pair(&scenario)).unwrap()
}

#[test]
fn a_careful_human_lets_those_pass_who_do_not_come() {
    let [human, bound] = [Reference::CarefulHuman, Reference::Bound];
    let stands = pass(3.0, 0.0);
    assert!(!stands.braked(human) && !stands.braked(bound), "{stands:?}");
    // It crosses after the car: the bound, which has no gate, stops.
    let late = pass(9.0, 1.0);
    assert!(!late.braked(human) && late.stopped(bound), "{late:?}");
    // It is some 0.3 m beside the path when the rear passes: the human stops needlessly.
    let near = pass(1.5 + 4.4, 1.0);
    assert!(near.stopped(human), "{near:?}");
}

#[test]
fn pedestrians_behind_a_wall_are_hidden_until_they_come_out() {
    let sight = |walls: &[OrientedBox]| {
        let (scenario, trace) = run_out(walls, |_| 1.39);
        judge(&trace.main_pair(&scenario)).unwrap().sight
    };
    let open = sight(&[]);
    assert_eq!((open.seen, open.is_occluded()), (Sight::WINDOW, false));
    // It walks at 1.39 m/s. Its front edge passes the end of a wall at 1.9 m about 1.4 s before the touch, and at 1.2 m about 0.9 s before.
    for (edge, seconds, occluded) in [(1.9, 1.4, false), (1.2, 0.9, true)] {
        let found = sight(&[OrientedBox::new(Pose::new(4.0, edge + 0.5, 0.0), 25.0, 0.5)]);
        assert!((found.seen - seconds).abs() < 0.3, "{edge}: {found:?}");
        assert_eq!(found.is_occluded(), occluded, "{found:?}");
    }
    // A post hides it for a short time.
    let post = sight(&[OrientedBox::new(Pose::new(24.0, 1.0, 0.0), 0.3, 0.3)]);
    assert!(post.seen < 2.0, "{post:?}");
}

#[test]
fn an_earlier_approach_is_not_this_danger() {
    // It walks towards the path, stands for more than a second, and walks towards the path again.
    let (scenario, paused) = run_out(&[], |time| if (0.5..=2.0).contains(&time) { 0.0 } else { 1.39 });
    assert!((judge(&paused.main_pair(&scenario)).unwrap().warning - 1.0).abs() < 0.11);
    let (scenario, short) = run_out(&[], |time| if !(0.5..1.0).contains(&time) { 1.39 } else { 0.0 });
    assert!((judge(&short.main_pair(&scenario)).unwrap().warning - 3.0).abs() < 1e-9);
}
