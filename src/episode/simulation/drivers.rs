use super::run_up::RunUp;
use crate::{Actions, Cast};
use base::seed::{Seed, Stream};
use rand::Rng;
use world::av::{DrivingPolicy, Fault, Path, Perception, PerfectSensors, cruising_speed};
use world::sim::World;

/// The drivers of all vehicles, in the order of their numbers, and their sensors.
pub(super) struct Drivers {
    pub(super) policies: Vec<Box<dyn DrivingPolicy>>,
    sensors: PerfectSensors,
    /// The seed of what they draw in the running episode.
    pub(super) seed: Seed,
    /// The way ahead of the ego at the start of its run-up.
    path: Path,
    /// The speed limit that lets the driver of the ego hold a test speed (m/s).
    held_limit: Option<f64>,
}

impl Drivers {
    pub(super) fn new(policies: Vec<Box<dyn DrivingPolicy>>) -> Self {
        Self {
            policies,
            sensors: PerfectSensors::default(),
            seed: Seed::root(0),
            path: Path::default(),
            held_limit: None,
        }
    }

    /// Fresh drivers of a cast.
    pub(super) fn of(cast: &Cast) -> Self {
        Self::new(cast.vehicles.iter().map(|role| (role.policy)()).collect())
    }

    /// Lets the ego hold a test speed (m/s).
    pub(super) fn hold(&mut self, test_speed: f64) {
        self.held_limit = Some(self.policies[0].speed_limit_for(test_speed));
    }

    /// The speed at which an average driver would be at the start of the run-up (m/s).
    pub(super) fn cruising_speed(&mut self, world: &World, run_up: &RunUp, stream: Stream) -> f64 {
        self.sensors.look(world);
        let perception = perceive(&mut self.sensors, self.held_limit, world, run_up, 0);
        self.path.reset(&perception, stream);
        cruising_speed(&self.path, &perception).min(run_up.speed)
    }

    /// Lets all drivers begin anew.
    pub(super) fn reset(&mut self, world: &World, run_up: &RunUp, actions: &mut Actions) {
        for vehicle in (0..self.policies.len()).filter(|vehicle| world.vehicles[*vehicle].is_driven()) {
            self.reset_one(vehicle, world, run_up, actions);
        }
    }

    /// Lets the driver of a vehicle begin anew.
    pub(super) fn reset_one(&mut self, vehicle: usize, world: &World, run_up: &RunUp, actions: &mut Actions) {
        self.sensors.look(world);
        let perception = perceive(&mut self.sensors, self.held_limit, world, run_up, vehicle);
        let policy = &mut self.policies[vehicle];
        policy.reset(&perception, of_driver(&self.seed, vehicle).stream());
        actions.modes[vehicle] = policy.mode();
    }

    /// Lets all drivers draw from below another seed from now on, each from a stream of its own.
    pub(super) fn reseed(&mut self, seed: &Seed) {
        for (vehicle, policy) in self.policies.iter_mut().enumerate() {
            policy.reseed(of_driver(seed, vehicle).stream());
        }
    }

    pub(super) fn prepare(&mut self, world: &World, run_up: &RunUp) {
        self.sensors.look(world);
        for (vehicle, policy) in
            self.policies.iter_mut().enumerate().filter(|(own, _)| world.vehicles[*own].is_driven())
        {
            policy.prepare(&perceive(&mut self.sensors, self.held_limit, world, run_up, vehicle));
        }
    }

    /// Asks every driver for the next tick; returns the fault of the first that fails.
    #[inline]
    pub(super) fn drive(&mut self, world: &World, run_up: &RunUp, actions: &mut Actions) -> Option<Fault> {
        self.sensors.look(world);
        let chosen = actions.controls.iter_mut().zip(&mut actions.modes);
        let all = self.policies.iter_mut().zip(chosen).enumerate();
        for (vehicle, (policy, (control, mode))) in all.filter(|(own, _)| world.vehicles[*own].is_driven()) {
            let driven = policy.drive(&perceive(&mut self.sensors, self.held_limit, world, run_up, vehicle));
            *mode = policy.mode();
            if let Some(fault) = policy.fault() {
                return Some(fault);
            }
            *control = driven;
        }
        None
    }

    /// What another simulator draws from in the running episode: numbers in every language represent 53 bits exactly.
    pub(super) fn world_seed(&self) -> u64 {
        self.seed.child("world").stream().next_u64() >> 11
    }

    /// A copy in their present state; `None` if one of them cannot be copied.
    pub(super) fn snapshot(&self) -> Option<Self> {
        let policies = self.policies.iter().map(|policy| policy.snapshot()).collect::<Option<_>>()?;
        Some(Self { policies, sensors: self.sensors.clone(), path: self.path.clone(), ..*self })
    }

    /// Other drivers of a cast, if that of the ego is faster in a batch.
    pub(super) fn clone_for_batch(&self, cast: &Cast) -> Option<Self> {
        let ego = self.policies[0].clone_for_batch()?;
        let traffic = self.policies.iter().zip(cast.vehicles.iter()).skip(1);
        let traffic = traffic.map(|(policy, role)| policy.clone_for_batch().unwrap_or_else(|| (role.policy)()));
        Some(Self::new(std::iter::once(ego).chain(traffic).collect()))
    }
}

/// What the driver of a vehicle perceives of the world that was last looked at: in the run-up the ego has the way to take, afterwards the stated turns.
#[inline]
fn perceive<'a>(
    sensors: &'a mut PerfectSensors,
    held_limit: Option<f64>,
    world: &'a World,
    run_up: &'a RunUp,
    vehicle: usize,
) -> Perception<'a> {
    let mut perception = sensors.seen_by(world, vehicle);
    if let Some(limit) = held_limit.filter(|_| vehicle == 0) {
        (perception.speed_limit, perception.signed_limit) = (limit, None);
    }
    perception.route = if vehicle == 0 { run_up.route() } else { &[] };
    perception
}

/// The seed of what a vehicle's driver draws. That of the ego does not depend on whether there is other traffic.
fn of_driver(seed: &Seed, vehicle: usize) -> Seed {
    if vehicle == 0 { seed.child("policy") } else { seed.child("traffic").index(vehicle as u64) }
}
