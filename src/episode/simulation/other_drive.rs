use super::signal_meter::SignalMeter;
use crate::requirement::{Degree, Trace as Margins};
use crate::scenario::actor_signal;
use crate::scenario::signal::{Wanted, is_measured, is_silent};
use crate::{Pair, Situation};
use base::signature::{Requirement, VariableId};
use road::geometry::{Point, Pose, wrap_angle};
use world::sim::{ActorId, ActorStart, Contact, PedestrianState, Start, World, time_of};

/// The samples of a requirement in an episode in which the ego drives otherwise from a tick on, while all others do what they did.
///
/// The tick is the start of an episode of its own: signals that say what was "so far" count from there. Time counts from the start of the recorded
/// episode.
pub struct OtherDrive<'a> {
    pair: Pair<'a>,
    requirement: &'a Requirement,
    /// The tick at which it starts.
    first: usize,
    world: World,
    meter: SignalMeter,
    margins: Margins,
    samples: usize,
    least_gap: f64,
}

impl<'a> OtherDrive<'a> {
    /// Starts at a tick of an episode.
    pub fn new(pair: Pair<'a>, requirement: &'a Requirement, first: usize) -> Self {
        let scenario = pair.scenario;
        let cast = &scenario.cast;
        let count = pair.trace.pedestrian_count();
        let bodies: Vec<_> = cast.pedestrians.iter().take(count).map(|role| role.body).collect();
        let lights = pair.trace.lights();
        let cycle = lights.is_some().then_some(scenario.episode.light_cycle());
        let (town, obstacles) = (scenario.town.clone(), pair.obstacles().clone());
        let starts = vec![ActorStart::default(); bodies.len()];
        let cars = cast.vehicles.iter().take(pair.trace.vehicle_count()).skip(1).map(|role| role.blueprint.clone());
        let cars: Vec<_> = std::iter::once(pair.blueprint.clone()).chain(cars).collect();
        let places = vec![ActorStart::default(); cars.len()];
        let mut world = World::new(town, obstacles, cars, bodies, cycle, pair.dt());
        let light_phase = lights.map_or(0.0, |clock| clock.time() + first as f64 * pair.dt());
        world.begin(&Start { vehicles: &places, pedestrians: &starts, light_phase });
        let wanted = Wanted::new(|id| is_measured(id) && requirement.mentions(&|other| other == id));
        let room = pair.len() - first;
        let is_silent = |id| is_silent(id, scenario);
        Self {
            pair,
            requirement,
            first,
            meter: SignalMeter::new(wanted, &world, room),
            world,
            margins: Margins::new(requirement, room, &is_silent),
            samples: 0,
            least_gap: f64::INFINITY,
        }
    }

    /// The degree of a requirement in a recorded episode.
    pub fn recorded(pair: Pair<'a>, requirement: &'a Requirement) -> Degree {
        let mut samples = Self::new(pair, requirement, 0);
        let last = pair.len() - 1;
        for (tick, frame) in pair.frames().enumerate() {
            let touch = pair.contact.filter(|_| tick == last);
            let speed = touch.map_or(frame.ego.speed, |touch| touch.impact_speed);
            samples.push(frame.ego.pose, speed, frame.pedestrian.pose.position(), touch);
        }
        samples.degree()
    }

    /// Takes the next sample, one tick after the last one: the ego, and the place of the pair's pedestrian, and the touch that ends the drive.
    pub fn push(&mut self, ego: Pose, speed: f64, walker: Point, touch: Option<&Contact>) {
        let number = self.pair.pedestrian_number();
        let tick = self.first + self.samples;
        for (other, pedestrian) in self.world.pedestrians.iter_mut().enumerate() {
            let states = self.pair.trace.pedestrian(other);
            if let Some(state) = states.get(tick).or(states.last()) {
                pedestrian.state = *state;
            }
        }
        for (other, vehicle) in self.world.vehicles.iter_mut().enumerate().skip(1) {
            let states = self.pair.trace.vehicle(other);
            if let Some(frame) = states.get(tick).or(states.last()) {
                vehicle.state = frame.state;
            }
        }
        let state = &mut self.world.pedestrians[number].state;
        (state.pose.x, state.pose.y) = (walker.x, walker.y);
        self.world.vehicles[0].state.pose = ego;
        self.world.vehicles[0].state.ground = self.pair.frame(tick.min(self.pair.len() - 1)).ego.ground;
        self.world.vehicles[0].state.speed = speed;
        self.world.ticks = self.samples as u32;
        match self.samples {
            0 => self.meter.begin(&self.world),
            _ => self.meter.tick(&self.world, touch),
        }
        let situation = self.situation(tick, touch);
        let value = |id: VariableId| match id.of_actor() {
            Some(signal) => actor_signal::value(&self.world, signal, touch),
            None => situation.value(id),
        };
        self.margins.push(self.requirement, &value);
        self.samples += 1;
    }

    /// The touch of the ego and the pair's pedestrian, this share of a tick after the last sample.
    pub fn touch(&self, ego: &Pose, speed: f64, walker: Point, fraction: f64) -> Contact {
        let local = ego.to_local(walker);
        let pair = (ActorId::EGO, ActorId::Pedestrian(self.pair.pedestrian_number() as u8));
        let bearing = libm::atan2(local.y, local.x);
        Contact { pair, fraction, bearing, ahead: local.x, aside: local.y, impact_speed: speed }
    }

    /// The degree of the requirement, at the first sample.
    pub fn degree(&mut self) -> Degree {
        self.margins.degree(self.requirement, self.pair.dt())
    }

    /// The variables that requirements name.
    fn situation(&mut self, tick: usize, touch: Option<&Contact>) -> Situation {
        let dt = self.pair.dt();
        let number = SignalMeter::pedestrian(&self.world, touch);
        let (ego, walker): (_, &PedestrianState) = (&self.world.ego().state, &self.world.pedestrians[number].state);
        let local = ego.pose.to_local(walker.pose.position());
        let (ahead, aside) = touch.map_or((local.x, local.y), |touch| (touch.ahead, touch.aside));
        let seen = walker.pose.to_local(ego.pose.position());
        let gap = if touch.is_some() { 0.0 } else { self.world.gap(0, number) };
        self.least_gap = self.least_gap.min(gap);
        let (turn, pace) = self.command(number, tick);
        let before = time_of(tick.saturating_sub(1), dt);
        Situation {
            bearing: touch.map_or_else(|| libm::atan2(aside, ahead), |touch| touch.bearing),
            distance: (ahead * ahead + aside * aside).sqrt(),
            ahead,
            aside,
            facing: libm::atan2(seen.y, seen.x),
            ego_speed: ego.speed,
            walking_speed: walker.speed(),
            elapsed: touch.map_or(time_of(tick, dt), |touch| before + touch.fraction * dt),
            turn,
            pace,
            miss_distance: self.least_gap,
            ..*self.meter.now()
        }
    }

    /// The turn (rad) and the pace (m/s) of the command that a pedestrian had carried out before a tick; `None` at the start.
    fn command(&self, pedestrian: usize, tick: usize) -> (f64, f64) {
        let trace = self.pair.trace;
        let decisions = trace.decisions(pedestrian);
        let hold = self.pair.scenario.episode.hold as usize;
        let (Some(before), Some(last)) = (tick.checked_sub(1), decisions.len().checked_sub(1)) else {
            return (0.0, 0.0);
        };
        let index = (before / hold).min(last);
        let earlier = match index.checked_sub(1) {
            Some(earlier) => decisions[earlier].heading,
            None => trace.pedestrian(pedestrian).first().map_or(0.0, |first| first.pose.yaw),
        };
        (wrap_angle(decisions[index].heading - earlier), decisions[index].speed)
    }
}
