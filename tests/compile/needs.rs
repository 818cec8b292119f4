//! Removing one actor after the other names those that were planted as the causes of a failure.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use rand::RngExt;

use crate::cast::{ahead, away, two_and_two};
use crate::samples::samples;
use base::seed::{Seed, Stream};
use episode::{Controller, Criterion, PedestrianRole, Placement, Scenario, follow};
use road::geometry::Pose;
use verdict::cause::{Incident, Limit, Reruns, needs, shrink};
use world::sim::{ActorId, ActorStart, WalkCommand};

const STANDING: WalkCommand = WalkCommand { heading: 0.0, speed: 0.0 };

/// A case, and the actors that were planted.
type Built = (Scenario, Vec<ActorId>);

fn add(scenario: &mut Scenario, place: Pose, command: WalkCommand) -> ActorId {
    let place = Placement::Fixed(ActorStart::standing(place));
    let role = PedestrianRole { place, controller: Controller::Fixed(command), ..scenario.cast.pedestrian().clone() };
    scenario.cast.pedestrians.push(role);
    ActorId::Pedestrian(scenario.cast.pedestrians.len() as u8 - 1)
}

/// Up to four people who walk along the street, far beside it.
fn add_bystanders(scenario: &mut Scenario, stream: &mut Stream) {
    for _ in 0..stream.random_range(0..5) {
        let side = if stream.random_bool(0.5) { 12.0 } else { -14.0 };
        let heading = stream.random_range(-0.1..0.1);
        let place = Pose::new(stream.random_range(60.0..120.0), side, heading);
        add(scenario, place, WalkCommand { heading, speed: stream.random_range(0.0..1.5) });
    }
}

/// Somebody stands in the lane of a driver that does not look; a car drives far ahead of it.
fn one_culprit(stream: &mut Stream) -> Built {
    let mut scenario = two_and_two("blind", ("blind", ahead(150.0)), (away(), Controller::Fixed(STANDING)));
    add_bystanders(&mut scenario, stream);
    let culprit = add(&mut scenario, Pose::new(stream.random_range(85.0..110.0), -1.75, 0.0), STANDING);
    add_bystanders(&mut scenario, stream);
    (scenario, vec![culprit])
}

/// Somebody walks out from behind a parked van.
fn two_culprits(stream: &mut Stream) -> Built {
    let van = stream.random_range(68.0..93.0);
    let parked = ActorStart::standing(Pose::new(van, -4.6, 0.0));
    let mut scenario = two_and_two("seeing", ("blind", parked), (away(), Controller::Fixed(STANDING)));
    scenario.cast.vehicles[1].is_parked = true;
    add_bystanders(&mut scenario, stream);
    let place = Pose::new(van + stream.random_range(2.7..3.1), stream.random_range(-7.8..-6.4), FRAC_PI_2);
    let walks = WalkCommand { heading: FRAC_PI_2, speed: stream.random_range(1.4..2.0) };
    let culprit = add(&mut scenario, place, walks);
    (scenario, vec![ActorId::Vehicle(1), culprit])
}

/// The share of built failures of which removal names the planted actors and nobody else.
fn share_named(name: &str, count: usize, build: impl Fn(&mut Stream) -> Built) -> f64 {
    let (mut failures, mut named) = (0, 0);
    for number in 0.. {
        assert!(number < 400 * count as u64, "{name}: {failures} failures");
        let (scenario, planted) = build(&mut Seed::root(5).child(name).index(number).stream());
        let pedestrians = scenario.cast.pedestrians.len();
        let commands = vec![STANDING; pedestrians];
        let scenario = Arc::new(scenario);
        let incident = Incident { scenario, seed: Seed::root(1), start: 0, commands, criterion: Criterion::Collision };
        let hits = |incident: &Incident| {
            Reruns::new(incident).run(&incident.commands).is_some_and(|rerun| rerun.outcome.is_collision())
        };
        // A van is a cause if the driver stops in a street that never had one.
        let mut street = Scenario::clone(&incident.scenario);
        street.cast.vehicles.truncate(1);
        let without = Incident { scenario: Arc::new(street), ..incident.clone() };
        if hits(&incident) && (!planted.contains(&ActorId::Vehicle(1)) || !hits(&without)) {
            failures += 1;
            let found = needs(&incident).into_iter().filter(|need| need.is_needed).map(|need| need.actor);
            let found: Vec<ActorId> = found.collect();
            named += usize::from(found == planted);
        }
        if failures == count {
            break;
        }
    }
    loud!("{name}: {named} of {failures}");
    named as f64 / failures as f64
}

/// Failures of a cast that shrink to the planted actors: nobody else is left, and no single one of these can be taken away.
#[test]
fn a_failure_of_a_cast_shrinks_to_the_actors_that_it_needs() {
    let (mut shrunken, mut fewest) = (0, 0);
    for number in 0..samples(8, 60) as u64 {
        let (scenario, planted) = one_culprit(&mut Seed::root(6).index(number).stream());
        let commands = vec![STANDING; scenario.cast.pedestrians.len()];
        let scenario = Arc::new(scenario);
        let incident = Incident { scenario, seed: Seed::root(1), start: 0, commands, criterion: Criterion::Collision };
        let Some(shrunk) = shrink(&incident, 600) else { continue };
        let there = |incident: &Incident| {
            let cast = &incident.scenario.cast;
            cast.actors().filter(|actor| !cast.is_absent(*actor)).collect::<Vec<_>>()
        };
        let (before, now) = (there(&incident), there(&shrunk.incident));
        assert_eq!(shrunk.without.len(), before.len() - now.len(), "{}", shrunk.without());
        let Incident { scenario, seed, start, commands, .. } = &shrunk.incident;
        let (outcome, _) = follow(scenario, *seed, *start, commands).expect("its commands end the episode");
        assert_eq!(outcome, shrunk.rerun.outcome, "bit for bit");
        shrunken += 1;
        fewest += usize::from(now == [ActorId::EGO, planted[0]]);
        let cut = shrink(&incident, 3).unwrap();
        assert!(cut.limit == Limit::Budget && cut.runs == 3, "{} runs", cut.runs);
    }
    loud!("{fewest} of {shrunken}");
    assert!(shrunken >= 4 && fewest == shrunken, "{fewest} of {shrunken}");
}

/// At least 95 % of 200.
#[test]
fn removal_names_the_planted_culprits() {
    let count = samples(10, 100);
    let shares = [share_named("one", count, one_culprit), share_named("two", count, two_culprits)];
    assert!(shares.iter().sum::<f64>() / 2.0 >= 0.95, "{shares:?}");
}
