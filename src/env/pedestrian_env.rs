use std::sync::Arc;

use super::running::RunningEpisode;
use super::{Ending, Observation, Outcome, RewardRule, Scenario, Situation, Spawn, SpawnRule, Trail};
use crate::av::{DrivingMode, DrivingPolicy, Fault, Sensors};
use crate::geometry::{Pose, wrap_angle};
use crate::rl::{Env, Step};
use crate::seed::Seed;
use crate::sim::{ActorStart, Contact, Control, LightCycle, Start, WalkCommand, World};
use rand::RngExt;

/// A logical scenario made runnable: it draws concrete episodes from it, one after another.
///
/// Episode *k* depends on the seed and on *k* alone, so two pedestrians that are tried with one seed meet the same
/// beginnings and the same drivers.
pub struct PedestrianEnv {
    scenario: Arc<Scenario>,
    world: World,
    policy: Box<dyn DrivingPolicy>,
    sensors: Sensors,
    seed: Seed,
    next_episode: u64,
    episode: Episode,
    faults_in_a_row: u32,
    last_fault: Option<Fault>,
    /// The commands of the running episode so far. With the episode's number and width they are all that its state hangs on.
    decisions: Vec<WalkCommand>,
    /// How much of the spawn's distances the coming episodes are drawn from; 1 for all.
    width: f64,
    /// The spawn rule with as much of the distances, where that is not all.
    near: Option<SpawnRule>,
}

/// Episodes in a row in which a driver may fail before it is given up.
const MOST_FAULTS: u32 = 10;
/// Commands of an episode for which there is room from the start; longer episodes make more room once.
const MOST_ROOM: u32 = 4096;

/// The running episode's record.
#[derive(Debug, Clone, Copy)]
struct Episode {
    spawn: Spawn,
    /// The environment's width when it began.
    width: f64,
    command: WalkCommand,
    /// Ticks for which the command has been held.
    held: u32,
    contact: Option<Contact>,
    /// How far the command turned away from the one before (rad).
    turn: f64,
    reward: f64,
    least_gap: f64,
    mode: DrivingMode,
    /// What the driver did in the last tick.
    control: Control,
    digest: u64,
    trail: Trail,
    outcome: Option<Outcome>,
}

impl PedestrianEnv {
    /// The number of components of a state.
    pub const STATE_DIM: usize = 4;

    /// Makes an environment whose first episode is number 0 under the seed. The scenario's spawn rule must have been probed.
    pub fn new(scenario: Arc<Scenario>, seed: Seed) -> Self {
        let policy = (scenario.policy)();
        Self::with_policy(scenario, seed, policy)
    }

    fn with_policy(scenario: Arc<Scenario>, seed: Seed, policy: Box<dyn DrivingPolicy>) -> Self {
        let lights = scenario.episode.traffic_lights.then(LightCycle::default);
        // No tick is to wait for it.
        scenario.town.prepare();
        let world = World::new(
            scenario.town.clone(),
            scenario.obstacles.clone(),
            vec![scenario.vehicle.clone()],
            vec![scenario.adversary.body],
            lights,
            scenario.episode.tick,
        );
        let nowhere = Spawn { ego: Pose::default(), ego_speed: 0.0, pedestrian: Pose::default() };
        let episode = Episode {
            spawn: nowhere,
            width: 1.0,
            command: WalkCommand::default(),
            held: 0,
            contact: None,
            turn: 0.0,
            reward: 0.0,
            least_gap: f64::INFINITY,
            mode: DrivingMode::Cruise,
            control: Control::default(),
            digest: 0,
            trail: Trail::default(),
            outcome: None,
        };
        let rule = &scenario.episode;
        let decisions = Vec::with_capacity(rule.ticks.div_ceil(rule.hold).min(MOST_ROOM) as usize);
        Self {
            scenario,
            world,
            policy,
            sensors: Sensors::default(),
            seed,
            next_episode: 0,
            episode,
            faults_in_a_row: 0,
            last_fault: None,
            decisions,
            width: 1.0,
            near: None,
        }
    }

    /// The scenario.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The world as it stands.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Begins the episode with this number.
    pub fn begin(&mut self, number: u64) {
        let seed = self.seed.index(number);
        let scenario = &self.scenario;
        let mut stream = seed.child("spawn").stream();
        let first = scenario.adversary.first_heading;
        let (town, obstacles) = (&scenario.town, &scenario.obstacles);
        let near = self.near.as_ref().and_then(|near| near.sample_if_easy(town, obstacles, first, &mut stream));
        let spawn = near.unwrap_or_else(|| scenario.spawn.sample(town, obstacles, first, &mut stream));
        // A whole number of cycles of groups with up to four turns.
        let light_phase = stream.random_range(0.0..12.0 * LightCycle::default().turn());
        let vehicles = &[ActorStart { pose: spawn.ego, speed: spawn.ego_speed }];
        self.world.begin(&Start { vehicles, pedestrians: &[ActorStart::standing(spawn.pedestrian)], light_phase });
        self.policy.reset(&self.sensors.perceive(&self.world, 0), seed.child("policy").stream());
        self.episode = Episode {
            spawn,
            width: self.width,
            command: WalkCommand { heading: spawn.pedestrian.yaw, speed: 0.0 },
            held: 0,
            contact: None,
            turn: 0.0,
            reward: 0.0,
            least_gap: self.world.gap(0, 0),
            mode: DrivingMode::Cruise,
            control: Control::default(),
            digest: 0,
            trail: Trail::default(),
            outcome: None,
        };
        self.next_episode = number + 1;
        self.decisions.clear();
    }

    /// Returns the episode in hand: its number and what the pedestrian has decided.
    fn running(&self) -> RunningEpisode {
        let digest = self.trace();
        let (next_episode, width) = (self.next_episode, self.episode.width);
        RunningEpisode { next_episode, width, decisions: self.decisions.clone(), digest }
    }

    /// Walks an episode again up to where it was, and tells whether it led there.
    ///
    /// Neither the world nor a driver can be copied; but an episode is determined by its number and the commands, and
    /// ticks are cheap.
    fn replay(&mut self, running: &RunningEpisode) -> bool {
        let Some(number) = running.next_episode.checked_sub(1) else {
            return self.next_episode == 0 && running.decisions.is_empty();
        };
        self.widen(running.width);
        self.begin(number);
        let (slowest, fastest) = self.scenario.adversary.speed;
        for command in &running.decisions {
            if self.episode.outcome.is_some() || !(slowest..=fastest).contains(&command.speed) {
                return false;
            }
            self.walk(*command);
        }
        self.trace() == running.digest
    }

    /// Hashes how the running episode began and all that has happened since.
    fn trace(&self) -> u64 {
        let Spawn { ego, ego_speed, pedestrian } = &self.episode.spawn;
        let begun = [ego.x, ego.y, ego.yaw, *ego_speed, pedestrian.x, pedestrian.y, pedestrian.yaw];
        begun.iter().fold(self.episode.digest, |digest, value| mix(digest, value.to_bits()))
    }

    /// What the pedestrian sees.
    pub fn observe(&self) -> Observation {
        let (pedestrian, ego) = (&self.world.pedestrians[0].state, &self.world.ego().state);
        let observed = self.scenario.adversary.observed_speed;
        Observation::new(&pedestrian.pose, pedestrian.speed(), &ego.pose, ego.speed, observed)
    }

    /// What became of the episode; none while it runs.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.episode.outcome.as_ref()
    }

    /// How pedestrian and ego touched in the last tick; none when they did not.
    pub fn contact(&self) -> Option<&Contact> {
        self.episode.contact.as_ref()
    }

    /// What the driver did in the last tick: its mode, its pedals and its wheel.
    pub fn driven(&self) -> (DrivingMode, Control) {
        (self.policy.mode(), self.episode.control)
    }

    /// Carries a command out for as many ticks as the scenario holds it.
    pub fn walk(&mut self, command: WalkCommand) -> Step {
        self.set_out(command);
        loop {
            if let Some(step) = self.tick() {
                return step;
            }
        }
    }

    /// Takes a command, to be carried out by [`PedestrianEnv::tick`].
    pub fn set_out(&mut self, command: WalkCommand) {
        self.episode.turn = wrap_angle(command.heading - self.episode.command.heading);
        self.episode.command = command;
        self.episode.held = 0;
        self.decisions.push(command);
    }

    /// Lets the driver prepare for the coming tick, so that drivers of many environments can be asked at once.
    pub fn prepare(&mut self) {
        self.policy.prepare(&self.sensors.perceive(&self.world, 0));
    }

    /// Moves on by one tick; gives the decision's step when the command has been held long enough or the episode is over.
    pub fn tick(&mut self) -> Option<Step> {
        let rule = &self.scenario.episode;
        let (limit, hold) = (rule.ticks, rule.hold);
        let perception = self.sensors.perceive(&self.world, 0);
        let control = self.policy.drive(&perception);
        if let Some(fault) = self.policy.fault() {
            return Some(self.give_up(fault));
        }
        if self.episode.held == 0 {
            self.episode.mode = self.policy.mode();
        }
        self.episode.held += 1;
        let contact = self.world.tick(&[control], &[self.episode.command]);
        self.episode.contact = contact;
        self.episode.control = control;
        self.record();
        let over = contact.is_some() || self.world.ticks >= limit || self.episode.held >= hold;
        over.then(|| self.settle(contact))
    }

    /// Ends an episode that says nothing, since the driver failed: no reward for the decision, and what would have followed
    /// is unknown.
    fn give_up(&mut self, fault: Fault) -> Step {
        self.finish(Ending::Error(fault), None);
        self.faults_in_a_row += 1;
        self.last_fault = Some(fault);
        Step { reward: 0.0, terminated: false, truncated: true }
    }

    /// The driver's fault, when it failed in so many episodes in a row that there is no use in going on.
    pub fn hopeless(&self) -> Option<Fault> {
        self.last_fault.filter(|_| self.faults_in_a_row >= MOST_FAULTS)
    }

    /// Another environment of the same scenario and seed, when its driver and this one's gain from driving at once.
    pub fn clone_for_batch(&self) -> Option<Self> {
        self.policy.clone_for_batch().map(|policy| Self::with_policy(self.scenario.clone(), self.seed, policy))
    }

    /// How many twins should drive at once.
    pub fn batch_size(&self) -> usize {
        self.policy.batch_size()
    }

    /// Pays for the decision and ends the episode when it is over.
    fn settle(&mut self, contact: Option<Contact>) -> Step {
        self.episode.trail.mark(self.episode.digest);
        let (rule, reward) = (&self.scenario.episode, &self.scenario.reward);
        let situation = self.situation(contact.as_ref());
        let lost = || rule.end_when.as_ref().is_some_and(|condition| situation.satisfies(condition));
        let worth = |formula| RewardRule::worth(formula, &situation);
        let (earned, ending) = match contact {
            Some(contact) => {
                let front = contact.is_front(rule.front_half_angle);
                let earned = worth(if front { reward.hit_front.as_ref() } else { reward.hit_other.as_ref() });
                let ending = Ending::Collision {
                    front,
                    moving: contact.impact_speed > rule.moving_above,
                    impact_speed: contact.impact_speed,
                    bearing: contact.bearing,
                };
                (earned, Some(ending))
            }
            None if lost() => (worth(reward.step.as_ref()) + worth(reward.lost.as_ref()), Some(Ending::Lost)),
            None if self.world.ticks >= rule.ticks => {
                (worth(reward.step.as_ref()) + worth(reward.timeout.as_ref()), Some(Ending::Timeout))
            }
            None => (worth(reward.step.as_ref()), None),
        };
        self.episode.reward += earned;
        if let Some(ending) = ending {
            self.finish(ending, contact.as_ref());
            self.faults_in_a_row = 0;
        }
        let truncated = ending == Some(Ending::Timeout);
        Step { reward: earned, terminated: ending.is_some() && !truncated, truncated }
    }

    /// Writes down what became of the episode.
    fn finish(&mut self, ending: Ending, contact: Option<&Contact>) {
        self.episode.outcome = Some(Outcome {
            spawn: self.episode.spawn,
            ending,
            reward: self.episode.reward,
            ticks: self.world.ticks,
            duration: self.elapsed(contact),
            least_gap: if contact.is_some() { 0.0 } else { self.episode.least_gap },
            last_mode: self.episode.mode,
            digest: self.episode.digest,
            trail: self.episode.trail,
        });
    }

    fn situation(&self, contact: Option<&Contact>) -> Situation {
        let (ego, pedestrian) = (&self.world.ego().state, &self.world.pedestrians[0].state);
        let local = ego.pose.to_local(pedestrian.pose.position());
        let (ahead, aside) = contact.map_or((local.x, local.y), |contact| (contact.ahead, contact.aside));
        Situation {
            v_c: contact.map_or(0.0, |contact| contact.impact_speed),
            bearing: contact.map_or_else(|| libm::atan2(aside, ahead), |contact| contact.bearing),
            distance: (ahead * ahead + aside * aside).sqrt(),
            ahead,
            aside,
            ego_speed: contact.map_or(ego.speed, |contact| contact.impact_speed),
            walking_speed: pedestrian.speed(),
            elapsed: self.elapsed(contact),
            facing: {
                let seen = pedestrian.pose.to_local(ego.pose.position());
                libm::atan2(seen.y, seen.x)
            },
            turn: self.episode.turn,
            pace: self.episode.command.speed,
            miss_distance: if contact.is_some() { 0.0 } else { self.episode.least_gap },
        }
    }

    /// Time until now, or until a touch within the last tick (s).
    fn elapsed(&self, contact: Option<&Contact>) -> f64 {
        let before = f64::from(self.world.ticks.saturating_sub(1)) * self.world.dt;
        contact.map_or(self.world.elapsed(), |contact| before + contact.fraction * self.world.dt)
    }

    fn record(&mut self) {
        let (ego, pedestrian) = (&self.world.ego().state, &self.world.pedestrians[0].state);
        for value in [ego.pose.x, ego.pose.y, ego.pose.yaw, ego.speed, pedestrian.pose.x, pedestrian.pose.y] {
            self.episode.digest = mix(self.episode.digest, value.to_bits());
        }
        // The distance of the centres bounds the gap from below; most ticks need no more.
        let blueprint = &self.world.ego().blueprint;
        let reach = self.episode.least_gap
            + blueprint.half_length
            + blueprint.half_width
            + self.world.pedestrians[0].body.radius;
        let apart = (ego.pose.position() - pedestrian.pose.position()).norm_squared();
        if apart < reach * reach {
            self.episode.least_gap = self.episode.least_gap.min(self.world.gap(0, 0));
        }
    }

    /// The learner's state: what the pedestrian sees, in the adversary's frame and units.
    pub fn state(&self) -> [f64; Self::STATE_DIM] {
        let (pedestrian, ego) = (&self.world.pedestrians[0].state.pose, self.world.ego().state.pose.position());
        let initial = self.episode.spawn.pedestrian.yaw;
        self.scenario.adversary.encode(&self.observe(), pedestrian, initial, ego)
    }

    /// The command for a learner's action, now.
    pub fn command(&self, action: [f64; 2]) -> WalkCommand {
        let (pedestrian, ego) = (&self.world.pedestrians[0].state.pose, self.world.ego().state.pose.position());
        self.scenario.adversary.command(action, pedestrian, self.episode.spawn.pedestrian.yaw, ego)
    }

    /// Where a homing pedestrian would walk: straight at the ego, as fast as it can.
    pub fn homing(&self) -> WalkCommand {
        let offset = self.world.ego().state.pose.position() - self.world.pedestrians[0].state.pose.position();
        WalkCommand { heading: libm::atan2(offset.y, offset.x), speed: self.scenario.adversary.speed.1 }
    }

    /// Where an intercepting pedestrian would walk: to the nearest place where it can meet an ego that keeps its
    /// velocity, or straight at the ego when there is none.
    pub fn intercept(&self) -> WalkCommand {
        let (pedestrian, ego) = (&self.world.pedestrians[0].state.pose, &self.world.ego().state);
        let speed = self.scenario.adversary.speed.1;
        let offset = ego.pose.position() - pedestrian.position();
        let velocity = ego.pose.forward() * ego.speed;
        let meeting = offset + velocity * meeting_time(offset, velocity, speed).unwrap_or(0.0);
        WalkCommand { heading: wrap_angle(libm::atan2(meeting.y, meeting.x)), speed }
    }
}

/// The least time (s) after which a walker at the origin can be where a car at `offset` with `velocity` is.
fn meeting_time(offset: crate::geometry::Vector, velocity: crate::geometry::Vector, speed: f64) -> Option<f64> {
    // |offset + velocity t| = speed t
    let a = velocity.norm_squared() - speed * speed;
    let b = offset.dot(&velocity);
    let c = offset.norm_squared();
    if a.abs() < 1e-9 {
        return (b < 0.0).then(|| -c / (2.0 * b));
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let (t1, t2) = ((-b - root) / a, (-b + root) / a);
    let earliest = t1.min(t2);
    let latest = t1.max(t2);
    if earliest > 0.0 { Some(earliest) } else { (latest > 0.0).then_some(latest) }
}

/// One round of a multiply-rotate hash.
fn mix(digest: u64, word: u64) -> u64 {
    (digest.rotate_left(5) ^ word).wrapping_mul(0x517c_c1b7_2722_0a95)
}

impl Env for PedestrianEnv {
    fn obs_dim(&self) -> usize {
        Self::STATE_DIM
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.scenario.adversary.action_bounds().to_vec()
    }

    fn reset(&mut self, state: &mut [f64]) {
        self.begin(self.next_episode);
        state.copy_from_slice(&self.state());
    }

    fn step(&mut self, action: &[f64], state: &mut [f64]) -> Step {
        // A driver that has been given up is not asked any more; the training ends with the update in hand.
        let step = match self.hopeless() {
            Some(_) => Step { reward: 0.0, terminated: false, truncated: true },
            None => self.walk(self.command([action[0], action[1]])),
        };
        state.copy_from_slice(&self.state());
        step
    }

    fn potential(&self) -> f64 {
        match &self.scenario.reward.potential {
            Some(formula) => RewardRule::worth(Some(formula), &self.situation(self.contact())),
            None => 0.0,
        }
    }

    fn widen(&mut self, share: f64) {
        if self.width.to_bits() != share.to_bits() {
            self.width = share;
            self.near = self.scenario.spawn.nearest(share);
        }
    }

    fn save(&self) -> Option<Vec<u8>> {
        Some(self.running().to_bytes())
    }

    fn load(&mut self, state: &[u8]) -> bool {
        RunningEpisode::from_bytes(state).is_some_and(|running| self.replay(&running))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    #[test]
    fn the_meeting_point_is_reached_by_both_at_once() {
        let (offset, velocity) = (Vector::new(-20.0, 5.0), Vector::new(7.0, 0.0));
        let t = meeting_time(offset, velocity, 3.5).unwrap();
        assert!(((offset + velocity * t).norm() - 3.5 * t).abs() < 1e-9);
        assert_eq!(meeting_time(Vector::new(20.0, 0.0), Vector::new(7.0, 0.0), 3.5), None, "it drives away, faster");
        let same = meeting_time(Vector::new(-10.0, 0.0), Vector::new(3.5, 0.0), 3.5).unwrap();
        assert!((same - 10.0 / 7.0).abs() < 1e-9);
    }
}
