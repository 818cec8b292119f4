use std::sync::Arc;

use super::wheel::{ACTION_BOUNDS, ACTION_SCALES, Seat, inputs};
use super::{DriveReward, DriveRule, Pupil};
use base::seed::Seed;
use episode::walker::{Controller, FaultStreak, WalkPolicy};
use episode::{Draw, MOVING_ABOVE, Phase, Placement, Scenario, Simulation, VehicleRole, advance};
use learn::{Env, Inputs, Step};
use road::geometry::Pose;
use world::av::view::View;
use world::sim::{ActorId, ActorStart, Contact, LightColour, WalkCommand, World};

/// An environment whose agent drives the ego.
///
/// An episode is that of a [`Simulation`] with its run-up. A decision is acceleration and steer, divided by [`ACTION_SCALES`], for the ticks that the
/// rule says; while a teacher is there, for one tick. The observation are the numbers of a learnt driver's network, squashed as [`inputs`] says.
///
/// An episode ends with a touch, 3 m from the route, when the pedestrian's episode ends, or when the car does not reach the place of the encounter in time.
pub struct DriveEnv {
    simulation: Box<dyn Simulation>,
    seat: Seat,
    rule: Arc<DriveRule>,
    inputs: Inputs,
    /// Those who walk, in turns.
    walkers: Vec<Box<dyn WalkPolicy>>,
    commands: Vec<WalkCommand>,
    seed: Seed,
    /// The number of the next episode.
    next: u64,
    /// The actions of the running episode.
    actions: Vec<[f32; 2]>,
    /// Whether the pedestrian has begun to walk.
    met: bool,
    last: Last,
    is_collision: bool,
    /// Ticks for which an action is kept.
    hold: u32,
    faults: FaultStreak,
}

/// What the reward of a tick compares with.
#[derive(Debug, Clone, Copy, Default)]
struct Last {
    speed: f64,
    acceleration: f64,
    steer: f64,
    /// The distance to a red light ahead (m).
    red: Option<f64>,
}

/// How far beside its route a car ends its episode (m).
const LOST: f64 = 3.0;
/// The measures at which discomfort is 1: jerk (m/s³), lateral acceleration and braking (m/s²), turns of the wheel (1/s).
const JERK: f64 = 40.0;
const LATERAL: f64 = 3.0;
const BRAKING: f64 = 6.0;
const TURNING: f64 = 2.0;
/// What passing a red light costs, once.
const RED_LIGHT: f64 = 3.0;
/// A car that is slower stands (m/s); a road user or a light so far ahead (m) and so far aside (m) is a reason.
const STANDING: f64 = 0.5;
const AHEAD: f64 = 20.0;
const ASIDE: f64 = 5.0;
/// The distance between two other cars at the start (m), and the number of attempts to find a place.
const APART: f64 = 15.0;
const ATTEMPTS: usize = 100;
/// Ticks after which cars have sorted themselves out.
const SETTLED: u32 = 20;

impl DriveEnv {
    /// Makes an environment whose first episode is number 0 under the seed. The scenario's driver gives way to the learner.
    pub fn new(scenario: &Arc<Scenario>, rule: &Arc<DriveRule>, seed: &Seed) -> Self {
        let seat = Seat::default();
        let mut scenario = (**scenario).clone();
        scenario.cast.vehicles[0].policy = seat.policy();
        let others = traffic(&scenario, rule, seed);
        scenario.cast.vehicles.extend(others);
        let commands = vec![WalkCommand::default(); scenario.cast.pedestrians.len()];
        Self {
            simulation: Arc::new(scenario).simulation(),
            seat,
            walkers: rule.walkers.iter().map(Controller::walk_policy).collect(),
            rule: rule.clone(),
            inputs: inputs(),
            commands,
            seed: *seed,
            next: 0,
            actions: Vec::new(),
            met: false,
            last: Last::default(),
            is_collision: false,
            hold: rule.hold,
            faults: FaultStreak::default(),
        }
    }

    /// The simulation of the running episode.
    pub fn simulation(&self) -> &dyn Simulation {
        &*self.simulation
    }

    /// The episodes in a row in which the driver of another car failed.
    pub fn faults(&self) -> &FaultStreak {
        &self.faults
    }

    fn world(&self) -> &World {
        self.simulation.scene().world
    }

    /// The numbers of a learnt driver's inputs for the present state, in the order of [`inputs`].
    pub fn numbers(&self) -> Vec<f32> {
        self.seat.wheel().numbers.clone()
    }

    fn begin(&mut self, number: u64) {
        self.next = number + 1;
        self.actions.clear();
        self.simulation.place(Draw::new(&self.seed, number));
        self.simulation.prepare();
        (self.met, self.is_collision) = (false, false);
        self.last = Last { speed: self.world().ego().state.speed, ..Last::default() };
        self.last.red = red_light(&self.seat.wheel().view);
    }

    fn observe(&self, obs: &mut [f64]) {
        self.inputs.observe(&self.seat.wheel().numbers, obs);
    }

    /// Drives a tick.
    fn drive(&mut self, action: [f32; 2]) -> Step {
        self.actions.push(action);
        self.seat.wheel().action = action;
        let (ended, contact) = if self.simulation.phase() == Phase::RunUp { self.run_up() } else { self.encounter() };
        if let Some(outcome) = self.simulation.outcome() {
            self.faults.count(outcome.fault());
        }
        self.simulation.prepare();
        let is_lost = self.aside().is_none_or(|aside| aside > LOST);
        let collided = contact.filter(|contact| contact.pair.0 == ActorId::EGO);
        let hit = collided.filter(|hit| hit.impact_speed > MOVING_ABOVE);
        let is_over = ended == Some(true) || is_lost;
        self.is_collision = hit.is_some();
        let DriveReward { collision, .. } = self.rule.reward;
        let fatal = match hit {
            Some(hit) => collision * (1.0 + hit.impact_speed / 10.0),
            // What touches a standing car is not its fault.
            None if collided.is_some() => 0.0,
            None if is_over => collision,
            None => 0.0,
        };
        Step { reward: self.reward() - fatal, terminated: is_over, truncated: ended == Some(false) }
    }

    /// A tick of the run-up; returns whether it ended the episode, and whether the car failed.
    fn run_up(&mut self) -> (Option<bool>, Option<Contact>) {
        self.simulation.tick();
        let restarted = self.simulation.phase() != Phase::RunUp && self.world().run_up == 0;
        // A car that was placed among others, that stood or that waited too long is cut off.
        let is_fast = self.last.speed > MOVING_ABOVE;
        let ticks = self.simulation.run_up_ticks();
        let touched = SETTLED < ticks && ticks < self.simulation.scenario().most_run_up();
        (restarted.then_some(is_fast && touched), None)
    }

    /// A tick with the pedestrian, as [`DriveEnv::run_up`].
    fn encounter(&mut self) -> (Option<bool>, Option<Contact>) {
        let number = self.next - 1;
        let turn = number as usize % self.walkers.len();
        let walker = &mut self.walkers[turn];
        if !self.met {
            walker.begin(self.seed.index(number).child("walker").stream());
            self.met = true;
        }
        if self.simulation.phase() == Phase::Decision {
            advance(&mut *self.simulation, walker.as_mut(), &mut self.commands, &mut ());
            if self.simulation.outcome().is_some() {
                return (Some(false), None);
            }
        }
        let step = self.simulation.tick();
        let contact = self.simulation.scene().contact().copied();
        let done = step.is_some_and(|step| step.done());
        (done.then(|| contact.is_some_and(|contact| contact.pair.0 == ActorId::EGO)), contact)
    }

    /// How far the ego is beside its route (m).
    fn aside(&self) -> Option<f64> {
        let wheel = self.seat.wheel();
        wheel.view.route.first().map(|abeam| abeam.to_local(wheel.view.ego.position()).y.abs())
    }

    /// The reward of the last tick, without that of its end.
    fn reward(&mut self) -> f64 {
        let wheel = self.seat.wheel();
        let (view, dt) = (&wheel.view, self.world().dt);
        let Last { speed: before, acceleration: last_acceleration, steer: last_steer, red } = self.last;
        let (speed, limit) = (view.speed, view.speed_limit.max(1.0));
        let acceleration = (speed - before) / dt;
        let steer = f64::from(wheel.action[1]);
        let (along, aside) = view.route.first().map_or((0.0, LOST), |abeam| {
            let heading = libm::cos(view.ego.yaw - abeam.yaw);
            (speed * heading, abeam.to_local(view.ego.position()).y)
        });
        let blueprint = &self.world().ego().blueprint;
        let (slip, _) = blueprint.slip(blueprint.wheel_angle(steer, speed), speed);
        let lateral = speed * speed * libm::sin(slip) / (blueprint.wheelbase / 2.0);
        let bounded = |value: f64, one: f64| (value / one * (value / one)).min(1.0);
        let discomfort = bounded((acceleration - last_acceleration) / dt, JERK)
            + bounded(lateral, LATERAL)
            + bounded(acceleration.min(0.0), BRAKING)
            + bounded((steer - last_steer) / dt, TURNING);
        let has_reason = view.light.is_some_and(|light| light.colour != LightColour::Green)
            || view.actors.iter().any(|seen| {
                let place = view.ego.to_local(seen.pose.position());
                (0.0..AHEAD).contains(&place.x) && place.y.abs() < ASIDE
            });
        let now = red_light(view);
        let passed = red.is_some_and(|distance| distance < 2.0 * speed * dt + 0.1) && view.light.is_none();
        let rule = &self.rule.reward;
        let each_second = rule.progress * (along.min(limit) / limit - 5.0 * (speed / limit - 1.0).max(0.0))
            - rule.comfort * discomfort
            - rule.lane * bounded(aside, 1.0)
            - rule.standing * f64::from(speed < STANDING && !has_reason);
        let reward = each_second * dt - if passed { RED_LIGHT } else { 0.0 };
        self.last = Last { speed, acceleration, steer, red: now };
        reward
    }
}

impl Env for DriveEnv {
    fn obs_dim(&self) -> usize {
        self.inputs.observed()
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        let scaled = |((low, high), scale): ((f64, f64), f64)| (low / scale, high / scale);
        ACTION_BOUNDS.into_iter().zip(ACTION_SCALES).map(scaled).collect()
    }

    fn reset(&mut self, obs: &mut [f64]) {
        self.begin(self.next);
        self.observe(obs);
    }

    fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
        let action = std::array::from_fn(|i| (action[i] * ACTION_SCALES[i]) as f32);
        let mut step = self.drive(action);
        for _ in 1..self.hold {
            if step.done() {
                break;
            }
            let next = self.drive(action);
            step = Step { reward: step.reward + next.reward, ..next };
        }
        self.observe(obs);
        step
    }

    /// Whether the episode ended in a collision.
    fn is_success(&self) -> bool {
        self.is_collision
    }

    /// The number of the next episode and the actions of the running one.
    fn save(&self) -> Option<Vec<u8>> {
        serde_json::to_vec(&(self.next, &self.actions)).ok()
    }

    fn load(&mut self, state: &[u8]) -> bool {
        let Ok((next, actions)) = serde_json::from_slice::<(u64, Vec<[f32; 2]>)>(state) else { return false };
        let Some(number) = next.checked_sub(1) else { return actions.is_empty() };
        self.begin(number);
        actions.into_iter().all(|action| {
            !self.is_over() && {
                self.drive(action);
                true
            }
        })
    }
}

impl Pupil for DriveEnv {
    fn teach(&mut self, teaches: bool) {
        self.seat.wheel().teacher = teaches.then(|| (self.rule.teacher)());
        self.hold = if teaches { 1 } else { self.rule.hold };
    }

    fn shown(&mut self) -> [f64; 2] {
        let shown = self.seat.wheel().shown;
        std::array::from_fn(|i| shown[i] / ACTION_SCALES[i])
    }
}

impl DriveEnv {
    fn is_over(&self) -> bool {
        self.simulation.outcome().is_some()
    }
}

/// The distance to a red light ahead (m).
fn red_light(view: &View) -> Option<f64> {
    view.light.filter(|light| light.colour == LightColour::Red).map(|light| light.distance)
}

/// The other cars, each where the spawn rule would place the ego.
fn traffic(scenario: &Scenario, rule: &DriveRule, seed: &Seed) -> Vec<VehicleRole> {
    let mut stream = seed.child("traffic").stream();
    let first = scenario.cast.pedestrian().first_heading;
    let (mut poses, mut others): (Vec<Pose>, Vec<VehicleRole>) = Default::default();
    for _ in 0..ATTEMPTS * rule.cars {
        if others.len() == rule.cars {
            break;
        }
        let pose = scenario.spawn.sample(&scenario.town, &scenario.obstacles, first, &mut stream).ego;
        if poses.iter().all(|other| (other.position() - pose.position()).norm() > APART) {
            let (policy, place) = (rule.teacher.clone(), Placement::Fixed(ActorStart::standing(pose)));
            others.push(VehicleRole { policy, place, ..scenario.cast.ego().clone() });
            poses.push(pose);
        }
    }
    others
}
