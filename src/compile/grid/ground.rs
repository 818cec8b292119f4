//! Where the episodes of a block happen, against which drivers, and how they start.

use std::sync::Arc;

use super::Nested;
use super::axis::{Axis, Usual};
use crate::campaign::{CampaignKeys, PlaceKeys, StartKeys};
use crate::lowering::{BuiltTown, Lowering, MadeDriver};
use crate::plan::NamedTown;
use crate::policy;
use crate::role::Roles;
use base::diagnostic::{Severity, Span};
use base::seed::Seed;
use base::signature::{DeclarationId, short};
use episode::requirement::NamedRequirement;
use episode::{
    CastSurvey, Controller, Criterion, EpisodeRule, FirstHeading, PedestrianRole, Placement, RewardRule, Scenario,
    SpawnRule, TargetBox, VehicleRole,
};
use lang::diagnostics;
use lang::hir::Block;
use verdict::ReferenceOracle;
use world::sim::VehicleBlueprint;

/// The acceleration of free fall (m/s²).
const GRAVITY: f64 = 9.81;

/// Where the episodes of a block happen, against which drivers, and how they start.
pub(crate) struct Ground {
    pub towns: Vec<Axis<BuiltTown>>,
    pub policies: Vec<Axis<MadeDriver>>,
    pub spawn: Axis<SpawnRule>,
    pub roles: Arc<Roles>,
}

impl Ground {
    /// Every town with every policy.
    pub fn places(&self) -> impl Iterator<Item = Place<'_>> {
        let place = |town, policy| Place { town, policy, spawn: &self.spawn, roles: &self.roles };
        self.towns.iter().flat_map(move |town| self.policies.iter().map(move |policy| place(town, policy)))
    }
}

/// A town with a policy.
#[derive(Clone, Copy)]
pub(crate) struct Place<'a> {
    pub town: &'a Axis<BuiltTown>,
    pub policy: &'a Axis<MadeDriver>,
    pub spawn: &'a Axis<SpawnRule>,
    pub roles: &'a Roles,
}

impl Place<'_> {
    /// The scenario with these bodies, rules, rewards and requirements.
    pub fn scenario(
        &self,
        car: &Axis<VehicleBlueprint>,
        walker: &Axis<PedestrianRole>,
        rule: &Axis<EpisodeRule>,
        reward: &RewardRule,
        requirements: &Arc<[NamedRequirement]>,
    ) -> Arc<Scenario> {
        let (car, walker, rule) = (&car.value, &walker.value, &rule.value);
        let grip = rule.friction.map_or(car.grip, |friction| friction * GRAVITY);
        let blueprint = VehicleBlueprint { grip, ..car.clone() };
        let MadeDriver { policy, parts } = self.policy.value.clone();
        Arc::new(Scenario {
            external_world: None,
            town: self.town.value.town.clone(),
            obstacles: self.town.value.obstacles.clone(),
            cast: self.roles.cast(
                VehicleRole {
                    name: "ego".into(),
                    blueprint,
                    policy,
                    parts,
                    is_parked: false,
                    is_absent: false,
                    place: Placement::Spawn,
                },
                walker,
                &self.spawn.value,
            ),
            spawn: for_car(&self.spawn.value, car),
            reward: RewardRule { requirements: self.roles.resolved(&reward.requirements), ..reward.clone() },
            oracle: Some(Arc::new(ReferenceOracle)),
            episode: rule.clone(),
            requirements: self.roles.resolved(requirements),
            criterion: Criterion::Collision,
        })
    }

    /// The declarations of a scenario.
    pub fn declarations(
        &self,
        car: &Axis<VehicleBlueprint>,
        walker: &Axis<PedestrianRole>,
        rule: &Axis<EpisodeRule>,
    ) -> Vec<DeclarationId> {
        [&[self.town.id, self.policy.id, self.spawn.id, car.id, walker.id, rule.id][..], &self.roles.ids].concat()
    }
}

impl Usual {
    /// The scenario of a place with this pedestrian, this reward and these requirements.
    pub fn scenario(
        &self,
        place: &Place<'_>,
        body: &Axis<PedestrianRole>,
        reward: &RewardRule,
        requirements: &Arc<[NamedRequirement]>,
    ) -> Arc<Scenario> {
        place.scenario(&self.car, body, &self.rule, reward, requirements)
    }

    /// The declarations of [`Usual::scenario`].
    pub fn declarations(&self, place: &Place<'_>, body: &Axis<PedestrianRole>) -> Vec<DeclarationId> {
        place.declarations(&self.car, body, &self.rule)
    }
}

/// The rule with room for a car on its lane.
fn for_car(spawn: &SpawnRule, car: &VehicleBlueprint) -> SpawnRule {
    SpawnRule { lane_width: 2.0 * car.half_width, ..spawn.clone() }
}

impl Lowering<'_> {
    /// The ground of a block, on which a pedestrian with each of these bodies can be placed; none after reporting what is wrong
    /// with the starts of episodes.
    pub(crate) fn ground(
        &mut self,
        Nested { campaign, block, .. }: Nested<'_>,
        places: &PlaceKeys,
        start: &StartKeys,
        bodies: &[(&Axis<VehicleBlueprint>, &Axis<PedestrianRole>)],
        usual: &Usual,
    ) -> Option<Ground> {
        let CampaignKeys { spawn, episode, .. } = campaign.keys();
        let spawn = self.spawn(start.spawn.unwrap_or(spawn))?;
        let (towns, policies) = (self.towns(&places.towns), self.policies(&places.drivers));
        let ground = Ground { towns, policies, spawn, roles: usual.roles.clone() };
        self.compare_ticks(episode, block, &places.drivers);
        if ground.spawn.value.target_walk.as_ref().is_some_and(|walk| walk.hidden) {
            self.warn_of_sight(block, &places.drivers, &ground.spawn.name);
        }
        if block.places.iter().all(|(key, _)| *key != "worlds") {
            let rule = self.program.get(episode).block.keys();
            self.worlds_fit(block, &[None], &ground, &rule);
        }
        let place = if start.spawn.is_some() { block.place("spawn") } else { campaign.place("spawn") };
        if self.probe(place, &ground.towns, &ground.spawn.value, bodies) {
            let EpisodeRule { tick, ticks, .. } = self.program.get(episode).block.keys();
            self.warn_of_far_starts(place, &ground, bodies, f64::from(ticks) * tick);
            self.probe_cast(campaign.place("cast"), &ground, bodies, usual);
        }
        Some(ground)
    }

    /// Reports the drivers of a block that are made for a tick of another length.
    fn compare_ticks(&mut self, episode: DeclarationId, block: &Block, policies: &[DeclarationId]) {
        let episode = self.program.get(episode);
        let EpisodeRule { tick, .. } = episode.block.keys();
        for (place, id) in policies.iter().enumerate() {
            let policy = self.program.get(*id);
            let made_for = self.catalog.signature_of(policy).and_then(|signature| signature.tick);
            if let Some(made_for) = made_for.filter(|made_for| *made_for != tick) {
                let span = block.members("drivers").get(place).copied().unwrap_or(block.head);
                let given = episode.block.place("tick");
                self.said.push(diagnostics::other_tick(span, &policy.name, made_for, tick, given));
            }
        }
    }

    /// Reports the drivers of a block that see a target behind parked cars.
    fn warn_of_sight(&mut self, block: &Block, drivers: &[DeclarationId], test: &str) {
        for (place, id) in drivers.iter().enumerate() {
            let driver = self.program.get(*id);
            if policy::sees_through(driver, self) {
                let span = block.members("drivers").get(place).copied().unwrap_or(block.head);
                self.said.push(diagnostics::sees_through(span, &driver.name, test));
            }
        }
    }

    /// Checks that the whole cast can be placed in every town.
    fn probe_cast(
        &mut self,
        span: Span,
        ground: &Ground,
        bodies: &[(&Axis<VehicleBlueprint>, &Axis<PedestrianRole>)],
        usual: &Usual,
    ) {
        if ground.roles.is_empty() {
            return;
        }
        if ground.roles.shares_spawn() && ground.spawn.value.scripted().is_some() {
            let message =
                format!("`{}` states a walk of one pedestrian, and it is to place several", ground.spawn.name);
            self.said.push(
                diagnostics::contradiction(span, message)
                    .help("give the others a place: `spawn`, `beside` or `ahead_of`"),
            );
            return;
        }
        // The first place of each town.
        for place in ground.places().step_by(ground.policies.len().max(1)) {
            for (car, walker) in bodies {
                let scenario = place.scenario(car, walker, &usual.rule, &RewardRule::default(), &[].into());
                for (number, role) in scenario.cast.pedestrians.iter().enumerate() {
                    let Controller::Own(controller) = &role.controller else { continue };
                    if let Err(reason) = controller.walk_policy().fits(&scenario.cast.alone(number), &scenario.episode)
                    {
                        let unfit = diagnostics::unfit_pedestrian(span, controller.name(), &role.name, reason);
                        self.said.push(unfit);
                    }
                }
                if let Err(crowded) = CastSurvey::new(&scenario, &Seed::root(0).child("probe")).check() {
                    self.said.push(diagnostics::unplaceable(span, &place.town.name, &crowded.to_string()));
                }
            }
        }
    }

    /// Checks that the car and a pedestrian can be placed in every town, and the pedestrian not inside any of the cars; false after reporting
    /// that they cannot.
    fn probe(
        &mut self,
        place: Span,
        towns: &[Axis<BuiltTown>],
        spawn: &SpawnRule,
        bodies: &[(&Axis<VehicleBlueprint>, &Axis<PedestrianRole>)],
    ) -> bool {
        for (Axis { name, value: car, .. }, Axis { value: walker, .. }) in bodies {
            let corner = (car.half_length * car.half_length + car.half_width * car.half_width).sqrt();
            let reach = corner + walker.body.reach();
            let nearest = spawn.distance.support().0;
            if nearest <= reach {
                let message = format!(
                    "a pedestrian {} m from the middle of `{name}` may stand inside it: its corners reach {reach:.2} m",
                    short(nearest)
                );
                self.said.push(diagnostics::contradiction(place, message));
                return false;
            }
        }
        if let Some(walk) = &spawn.target_walk {
            for (car, walker) in bodies {
                let target = if walk.target == TargetBox::CHILD { "child" } else { "adult" };
                if walker.value.body.is_child() != (walk.target == TargetBox::CHILD) {
                    let message = format!(
                        "`{}` is not the target of the test `{}`: that is a target of body `{target}`",
                        walker.name, spawn.name
                    );
                    let help = format!("name a `body` with `body: {target}` or `body: {target}_box`");
                    self.said.push(diagnostics::contradiction(place, message).help(help));
                    return false;
                }
                let is_in_sight = |town: &&Axis<BuiltTown>| walk.is_in_sight(&town.value.obstacles, &car.value);
                if let Some(town) = towns.iter().find(is_in_sight).filter(|_| walk.hidden) {
                    let message = format!(
                        "the test `{}` is one behind parked cars, and in `{}` nothing hides the target from the car",
                        spawn.name, town.name
                    );
                    let help = "take a town with the parked cars of the test, such as `test_track_parked`";
                    self.said.push(diagnostics::contradiction(place, message).help(help));
                    return false;
                }
            }
        }
        let looks = |first: &FirstHeading| bodies.iter().any(|(_, walker)| walker.value.first_heading == *first);
        let headings = [FirstHeading::Random, FirstHeading::TowardsEgo].into_iter().filter(looks);
        let widest =
            bodies.iter().max_by(|(one, _), (other, _)| one.value.half_width.total_cmp(&other.value.half_width));
        let spawn = widest.map_or_else(|| spawn.clone(), |(car, _)| for_car(spawn, &car.value));
        let mut can_start = true;
        for town in towns {
            let probe = |first: FirstHeading| {
                let mut stream = Seed::root(0).child("probe").stream();
                spawn.probe(&town.value.town, &town.value.obstacles, first, &mut stream)
            };
            for found in headings.clone().map(probe) {
                match found {
                    Ok(None) => {}
                    Ok(Some(rarity)) => {
                        self.said.push(diagnostics::rare_starts(place, &town.name, &rarity.to_string()));
                    }
                    Err(error) => {
                        self.said.push(diagnostics::unplaceable(place, &town.name, &error.to_string()));
                        can_start = false;
                        break;
                    }
                }
            }
        }
        can_start
    }
}

impl Lowering<'_> {
    /// Whether a test of a ground can fail in all its towns, as its own target walks: a car that never brakes does not pass all its cases. Reports the
    /// cases that it passes. A file with errors is not tried.
    pub(crate) fn can_fail(
        &mut self,
        at: Nested<'_>,
        ground: &Ground,
        bodies: &[(&Axis<VehicleBlueprint>, &Axis<PedestrianRole>)],
        rule: &Axis<EpisodeRule>,
    ) -> bool {
        if self.said.iter().any(|each| each.severity == Severity::Error) {
            return true;
        }
        // The driver makes no difference.
        let places = ground.places().step_by(ground.policies.len().max(1));
        for (place, (car, walker)) in places.flat_map(|place| bodies.iter().map(move |body| (place, body))) {
            let scenario = place.scenario(car, walker, rule, &RewardRule::default(), &[].into());
            let cases = scenario.decisive_cases();
            let passed = cases.iter().filter(|fails| !**fails).count();
            if passed > 0 {
                let span = at.campaign.place("episode");
                self.said.push(diagnostics::idle_test(span, &ground.spawn.name, passed, cases.len()));
                return passed < cases.len();
            }
        }
        true
    }

    /// Whether these bodies can walk the test of a ground in all its towns: as it states if `states` it, otherwise at their highest speed. Reports it
    /// otherwise.
    pub(crate) fn walks_test(
        &mut self,
        at: Nested<'_>,
        ground: &Ground,
        bodies: &[(&Axis<VehicleBlueprint>, &Axis<PedestrianRole>)],
        states: bool,
        tick: f64,
    ) -> bool {
        let Some(walk) = &ground.spawn.value.target_walk else { return true };
        let kmh = |speed: f64| short((speed * 36.0).round() / 10.0);
        for ((car, walker), town) in bodies.iter().flat_map(|body| ground.towns.iter().map(move |town| (body, town))) {
            let (low, high) = walker.value.action.speed;
            let speed = if states { walk.speed } else { high };
            let reason = if states && !(low - 1e-9..=high + 1e-9).contains(&speed) {
                let (low, high) = (kmh(low), kmh(high));
                format!("its `speed` is {low} to {high} km/h, and the target walks at {} km/h", kmh(speed))
            } else {
                let (body, obstacles) = (&walker.value.body, &town.value.obstacles);
                let Some(missed) = walk.missed(speed, body, &car.value, obstacles, tick) else { continue };
                let (case, apart, reached) = missed;
                let test_speed = kmh(walk.cases[case].test_speed);
                format!(
                    "with the car at {test_speed} km/h in `{}`, it reaches only {} of {} km/h, {apart:.2} m from the place where both meet",
                    town.name,
                    kmh(reached),
                    kmh(speed)
                )
            };
            let own = ["bodies", "body"].into_iter().find(|key| at.block.places.iter().any(|(name, _)| name == key));
            let place = own.map_or_else(|| at.campaign.place("body"), |key| at.block.place(key));
            let message = format!("`{}` cannot walk as the target of `{}`: {reason}", walker.name, ground.spawn.name);
            let help = "a target has `ramp: 0 s`, holds the test's speed in its `speed`, and nothing stands in its way";
            self.said.push(diagnostics::contradiction(place, message).help(help));
            return false;
        }
        true
    }

    /// Warns of towns in which no pedestrian can meet the car within an episode of this length (s).
    fn warn_of_far_starts(
        &mut self,
        place: Span,
        ground: &Ground,
        bodies: &[(&Axis<VehicleBlueprint>, &Axis<PedestrianRole>)],
        time: f64,
    ) {
        let Some((_, fastest)) =
            bodies.iter().max_by(|(_, a), (_, b)| a.value.action.speed.1.total_cmp(&b.value.action.speed.1))
        else {
            return;
        };
        let walker = &fastest.value;
        for town in &ground.towns {
            let mut stream = Seed::root(0).child("reach").stream();
            let (streets, obstacles) = (&town.value.town, &town.value.obstacles);
            let (walking, first) = (walker.action.speed.1, walker.first_heading);
            if ground.spawn.value.is_out_of_reach(streets, obstacles, first, (walking, time), &mut stream) {
                self.said.push(diagnostics::unreachable(place, &town.name, walking, time));
            }
        }
    }
}

/// Records towns, each once.
pub(crate) fn note_towns(noted: &mut Vec<NamedTown>, towns: &[Axis<BuiltTown>]) {
    for town in towns {
        if noted.iter().all(|known| known.name != *town.name) {
            noted.push(NamedTown { name: town.name.to_string(), town: town.value.town.clone() });
        }
    }
}
