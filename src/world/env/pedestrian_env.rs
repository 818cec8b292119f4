mod copies;
mod first_sight;
pub(super) mod requirements;
mod settle;
mod start;

use std::sync::Arc;

use super::motion::Motion;
use super::reward::is_about_motion;
use super::run_up::{self, RunUp};
use super::running::RunningEpisode;
use super::signal::{Wanted, is_measured};
use super::signal_meter::SignalMeter;
use super::spawn::{Pacing, Release};
use super::{
    Controller, Driven, Ending, LeftOut, Outcome, RewardRule, Scenario, Scene, Spawn, SpawnRule, StartBank,
    StateHashes, Trace,
};
use crate::av::{DrivingPolicy, Fault, Path, Perception, PerfectSensors};
use crate::geometry::{Point, Pose, wrap_angle};
use crate::requirement::Monitor;
use crate::sim::{ActorStart, Contact, Control, PedestrianState, WalkCommand, World};
use base::seed::Seed;
use learn::{Env, Step};
use requirements::Moment;

/// A runnable logical scenario: it draws concrete episodes, one after another.
///
/// Episode *k* depends only on the seed and on *k*. So two controllers that are evaluated with one seed have the same starts and the same
/// drivers.
///
/// Where the ego starts in its steady state ([`EgoSpeed::Steady`](super::EgoSpeed::Steady)), the driver first drives alone along a *run-up* that ends at the drawn
/// pose. Tick 0 of the episode is the tick in which it gets there: with its own speed, pose within the lane, and memory. Until then there are
/// no pedestrians; vehicles and traffic lights run. A driver that does not get there within 60 s (120 s where traffic lights work; at most 20,000 ticks) or touches
/// another vehicle starts at the drawn pose, at rest and without memory.
///
/// A decision is one command for each pedestrian of the cast, in the order of their numbers. As an [`Env`] its action is joint: the
/// numbers of all controlled pedestrians, one after another. So is its state.
pub struct PedestrianEnv {
    scenario: Arc<Scenario>,
    world: World,
    /// The drivers of the vehicles, in the order of their numbers.
    policies: Vec<Box<dyn DrivingPolicy>>,
    sensors: PerfectSensors,
    seed: Seed,
    /// The seed of what the drivers of the running episode draw.
    drivers: Seed,
    next_episode: u64,
    episode: Episode,
    /// The start of each vehicle and each pedestrian of the running episode.
    starts: (Vec<ActorStart>, Vec<ActorStart>),
    /// Time within the cycles of the traffic lights at the start (s).
    light_phase: f64,
    run_up: RunUp,
    /// The way ahead at the start of the run-up.
    path: Path,
    stage: Stage,
    /// The action of each vehicle's driver in the last tick.
    controls: Vec<Control>,
    /// The command that each pedestrian carries out.
    walks: Walks,
    /// The walk of the target in a test.
    release: Option<Release>,
    /// The share of its way from which the target starts.
    approach: f64,
    /// What the first command made of the path that is given.
    pacing: Option<Pacing>,
    /// The time for which the pedestrian stands at the start of that path (s).
    delay: f64,
    /// The speed limit that lets the driver of the ego hold the test speed (m/s).
    held_limit: Option<f64>,
    /// Bounds of a joint action.
    bounds: Vec<(f64, f64)>,
    faults_in_a_row: u32,
    last_fault: Option<Fault>,
    /// The commands of the running episode. Its state depends only on them, its number and its width.
    decisions: Vec<WalkCommand>,
    /// The part of the spawn's distances from which the next episodes are drawn; 1 for all.
    width: f64,
    /// The spawn rule with that part of the distances, if that is not all.
    near: Option<SpawnRule>,
    /// The starts that episodes from all distances begin with copies of; none for fresh starts.
    bank: Option<Arc<StartBank>>,
    /// The running episode so far, if the reward depends on the judgement of a hit.
    trace: Option<Trace>,
    /// The motion of each pedestrian with the ego; empty if nothing depends on it.
    motions: Vec<Motion>,
    /// The signals that formulas name; none if none does.
    signals: Option<SignalMeter>,
    /// The requirements of the scenario; none without any.
    monitor: Option<Monitor>,
    /// The requirements that the reward names; none without any.
    paid: Option<Monitor>,
    /// Their robustness over the samples up to the last decision, as plain numbers from -100 to 100.
    robustness: Vec<f64>,
    /// The moment of each sample; empty without a goal.
    moments: Vec<Moment>,
}

/// Number of episodes in a row that a driver may fail; then it is not asked again.
const MOST_FAULTS: u32 = 10;
/// Commands of an episode for which memory is reserved; longer episodes reserve more once.
const MOST_ROOM: u32 = 4096;

/// The commands that the pedestrians carry out, in the order of their numbers.
#[derive(Debug, Clone)]
struct Walks {
    commands: Vec<WalkCommand>,
    /// The angle from the previous command to each command (rad).
    turns: Vec<f64>,
    /// Memory for the commands of an action.
    scratch: Vec<WalkCommand>,
}

/// The stage of the running episode.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    /// The driver drives alone.
    RunUp,
    /// A driver failed in the run-up.
    Failed(Fault),
    /// The pedestrians are there.
    Encounter,
}

/// The record of the running episode.
#[derive(Debug, Clone, Copy)]
struct Episode {
    spawn: Spawn,
    /// The hash of the spawn as it was drawn.
    start: u64,
    run_up: u32,
    left_out: Option<LeftOut>,
    /// Whether no pedestrian has been in sight yet, and the road is watched.
    alone: bool,
    /// Where the car was when the road was last looked at, and how far it can go from there without crossing its edge (m).
    on_road: (Point, f64),
    /// The environment's width when it started.
    width: f64,
    /// Ticks for which the present commands have been carried out.
    held: u32,
    contact: Option<Contact>,
    reward: f64,
    /// Whether the hit that ended it is a fault of the driver.
    is_fault: bool,
    least_gap: f64,
    digest: u64,
    state_hashes: StateHashes,
    outcome: Option<Outcome>,
}

impl Episode {
    /// The record of an episode that has just started.
    fn new(spawn: Spawn, width: f64) -> Self {
        Self {
            spawn,
            start: hashed(0, &spawn),
            run_up: 0,
            left_out: None,
            alone: false,
            on_road: (Point::origin(), 0.0),
            width,
            held: 0,
            contact: None,
            reward: 0.0,
            is_fault: false,
            least_gap: f64::INFINITY,
            digest: 0,
            state_hashes: StateHashes::default(),
            outcome: None,
        }
    }
}

impl PedestrianEnv {
    /// Makes an environment whose first episode is number 0 under the seed. The scenario's spawn rule must have been probed.
    pub fn new(scenario: Arc<Scenario>, seed: Seed) -> Self {
        let policies = scenario.cast.vehicles().map(|role| (role.policy)()).collect();
        Self::with_policies(scenario, seed, policies)
    }

    fn with_policies(scenario: Arc<Scenario>, seed: Seed, policies: Vec<Box<dyn DrivingPolicy>>) -> Self {
        let cast = &scenario.cast;
        let lights = scenario.episode.traffic_lights.then_some(scenario.episode.light_cycle);
        // Prepared here, so that no tick waits for it.
        scenario.town.prepare();
        let world = World::new(
            scenario.town.clone(),
            scenario.obstacles.clone(),
            cast.vehicles().map(|role| role.blueprint.clone()).collect(),
            cast.pedestrians().map(|role| role.body).collect(),
            lights,
            scenario.episode.tick,
        );
        let spawned = || std::iter::once(ActorStart::default());
        let starts = (
            spawned().chain(cast.traffic.iter().map(|placed| placed.start)).collect(),
            spawned().chain(cast.others.iter().map(|placed| placed.start)).collect(),
        );
        let (vehicles, pedestrians) = (1 + cast.traffic.len(), cast.pedestrian_count());
        let none = vec![WalkCommand::default(); pedestrians];
        let walks = Walks { commands: none.clone(), turns: vec![0.0; pedestrians], scratch: none };
        let nowhere = Spawn { ego: Pose::default(), ego_speed: 0.0, pedestrian: Pose::default() };
        let rule = &scenario.episode;
        let decisions = rule.ticks.div_ceil(rule.hold).min(MOST_ROOM) as usize * pedestrians;
        let measured = scenario.reward.needs_motion() || rule.end_when.as_ref().is_some_and(is_about_motion);
        let motions = (0..pedestrians).filter(|_| measured).map(|number| Motion::new(&world, number)).collect();
        let monitor = requirements::monitor(&scenario);
        let wanted = requirements::wanted(&scenario);
        let samples = rule.ticks.min(MOST_ROOM) as usize + 1;
        Self {
            signals: wanted.map(|wanted| SignalMeter::new(wanted, rule.moving_above, &world, samples)),
            monitor,
            paid: requirements::paid(&scenario),
            robustness: Vec::with_capacity(scenario.reward.requirements.len()),
            moments: Vec::with_capacity(if scenario.criterion.requirement().is_some() { samples } else { 0 }),
            trace: scenario.oracle.is_some().then(|| Trace::new(&scenario)),
            motions,
            bounds: cast.action_bounds(),
            scenario,
            world,
            policies,
            sensors: PerfectSensors::default(),
            seed,
            drivers: seed,
            next_episode: 0,
            episode: Episode::new(nowhere, 1.0),
            starts,
            light_phase: 0.0,
            run_up: RunUp::new(run_up::LENGTH),
            release: None,
            approach: 1.0,
            pacing: None,
            delay: 0.0,
            held_limit: None,
            path: Path::default(),
            stage: Stage::Encounter,
            controls: vec![Control::default(); vehicles],
            walks,
            faults_in_a_row: 0,
            last_fault: None,
            decisions: Vec::with_capacity(decisions),
            width: 1.0,
            near: None,
            bank: None,
        }
    }

    /// The same environment, whose episodes begin with copies of the bank's starts while they are drawn from all distances.
    pub fn with_bank(self, bank: Option<Arc<StartBank>>) -> Self {
        Self { bank, ..self }
    }

    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// What pedestrians see now.
    #[inline]
    pub fn scene(&self) -> Scene<'_> {
        let Self { scenario, world, bounds, .. } = self;
        Scene { scenario, world, commands: &self.walks.commands, bounds, starts: &self.starts.1 }
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The running episode: its number and the decisions.
    fn running(&self) -> RunningEpisode {
        let digest = self.state_hash();
        let (next_episode, width) = (self.next_episode, self.episode.width);
        RunningEpisode { next_episode, width, decisions: self.decisions.clone(), digest }
    }

    /// Repeats an episode up to the recorded point, and returns whether it led to the same state.
    ///
    /// Neither the world nor a driver can be copied. But the episode's number and the commands determine it, and ticks are cheap.
    fn replay(&mut self, running: &RunningEpisode) -> bool {
        let Some(number) = running.next_episode.checked_sub(1) else {
            return self.next_episode == 0 && running.decisions.is_empty();
        };
        let pedestrians = self.world.pedestrians.len();
        if !running.decisions.len().is_multiple_of(pedestrians) {
            return false;
        }
        self.set_curriculum(running.width);
        self.begin(number);
        for commands in running.decisions.chunks(pedestrians) {
            let roles = || self.scenario.cast.pedestrians().zip(commands);
            let possible = roles().all(|(role, command)| match role.controller {
                Controller::External => (role.action.speed.0..=role.action.speed.1).contains(&command.speed),
                Controller::Fixed(fixed) => fixed == *command,
            });
            if self.episode.outcome.is_some() || !possible {
                return false;
            }
            self.carry_out(commands);
        }
        self.state_hash() == running.digest
    }

    /// Hashes the start of the running episode and all its states since.
    fn state_hash(&self) -> u64 {
        hashed(self.episode.digest, &self.episode.spawn)
    }

    /// The outcome of the episode; none while it runs.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.episode.outcome.as_ref()
    }

    /// The actors that touched in the last tick, and how; none when there was no touch.
    pub fn contact(&self) -> Option<&Contact> {
        self.episode.contact.as_ref()
    }

    /// The action of a vehicle's driver in the last tick.
    #[inline]
    pub fn driven(&self, vehicle: usize) -> Driven {
        Driven { mode: self.policies[vehicle].mode(), control: self.controls[vehicle] }
    }

    /// Carries out one command for each pedestrian, for the number of ticks that the scenario keeps a command.
    pub fn carry_out(&mut self, commands: &[WalkCommand]) -> Step {
        self.begin_decision(commands);
        loop {
            if let Some(step) = self.tick() {
                return step;
            }
        }
    }

    /// Takes one command for each pedestrian; [`PedestrianEnv::tick`] carries them out.
    ///
    /// # Panics
    /// When the number of commands is not that of the pedestrians.
    pub fn begin_decision(&mut self, commands: &[WalkCommand]) {
        assert_eq!(commands.len(), self.walks.commands.len(), "each pedestrian has a command");
        let Walks { commands: last, turns, .. } = &mut self.walks;
        let first = self.world.ticks == 0;
        let target = &mut self.release;
        if first && let Some(walk) = &self.scenario.spawn.target_walk {
            let ego = self.world.ego();
            let (number, approach) = (self.next_episode.saturating_sub(1), self.approach);
            let release = walk.release(number, approach, &ego.state, &ego.blueprint, commands[0], self.world.dt);
            self.starts.1[0].pose = release.start;
            self.world.pedestrians[0].state = PedestrianState::standing(release.start);
            *target = Some(release);
        }
        if first && let Some(path) = &self.scenario.spawn.given_path {
            self.pacing = Some(path.pacing(commands[0], self.delay));
        }
        for (((last, turn), command), role) in
            last.iter_mut().zip(turns).zip(commands).zip(self.scenario.cast.pedestrians())
        {
            let command = match role.controller {
                Controller::External => *command,
                Controller::Fixed(fixed) => fixed,
            };
            *turn = wrap_angle(command.heading - last.heading);
            *last = command;
        }
        self.motions.iter_mut().for_each(Motion::begin_decision);
        if let Some(trace) = &mut self.trace {
            trace.decide(&self.world, last);
        }
        self.episode.held = 0;
        self.decisions.extend_from_slice(last);
        if first {
            self.begin_samples();
        }
    }

    /// Lets the drivers prepare for the next tick, so that drivers of many environments can be queried at once.
    pub fn prepare(&mut self) {
        if self.failed_run_up().is_some() {
            return;
        }
        for (vehicle, policy) in self.policies.iter_mut().enumerate() {
            policy.prepare(&perceive(
                &mut self.sensors,
                &self.world,
                self.stage,
                &self.run_up,
                self.held_limit,
                vehicle,
            ));
        }
    }

    /// Simulates one tick. Returns the decision's step when the commands have been carried out for their time or the episode is over.
    pub fn tick(&mut self) -> Option<Step> {
        let rule = &self.scenario.episode;
        let (limit, hold) = (rule.ticks, rule.hold);
        if let Some(fault) = self.failed_run_up().or_else(|| self.drive()) {
            return Some(self.give_up(fault));
        }
        self.episode.held += 1;
        let contact = match self.stated_command() {
            None => self.world.tick(&self.controls, &self.walks.commands),
            Some(stated) => {
                let Walks { commands, scratch, .. } = &mut self.walks;
                scratch.copy_from_slice(commands);
                scratch[0] = stated;
                self.world.tick(&self.controls, scratch)
            }
        };
        self.episode.contact = contact;
        self.motions.iter_mut().for_each(|motion| motion.tick(&self.world));
        self.record();
        self.take_sample(contact.as_ref());
        if self.episode.alone {
            self.watch_road();
        } else {
            self.watch_end();
        }
        if let Some(mut trace) = self.trace.take() {
            trace.watch(&self.world, contact.as_ref(), |vehicle| self.driven(vehicle));
            self.trace = Some(trace);
        }
        let over = contact.is_some() || self.world.ticks >= limit || self.episode.held >= hold || self.is_test_over();
        over.then(|| self.settle(contact))
    }

    /// The command that the test or the path of the spawn rule states for this tick.
    #[inline]
    fn stated_command(&self) -> Option<WalkCommand> {
        let (world, spawn) = (&self.world, &self.scenario.spawn);
        if let Some(release) = &self.release {
            return Some(release.command(world.ticks, world.dt));
        }
        let (path, pacing) = spawn.given_path.as_ref().zip(self.pacing.as_ref())?;
        Some(path.tick_command(pacing, &world.pedestrians[0].state.pose, world.ticks, world.dt))
    }

    #[inline]
    pub(super) fn failed_run_up(&self) -> Option<Fault> {
        match self.stage {
            Stage::Failed(fault) => Some(fault),
            Stage::RunUp | Stage::Encounter => None,
        }
    }

    /// Queries every driver for the next tick; returns the fault of the first that fails.
    #[inline]
    fn drive(&mut self) -> Option<Fault> {
        for (vehicle, (policy, control)) in self.policies.iter_mut().zip(&mut self.controls).enumerate() {
            let chosen = policy.drive(&perceive(
                &mut self.sensors,
                &self.world,
                self.stage,
                &self.run_up,
                self.held_limit,
                vehicle,
            ));
            if let Some(fault) = policy.fault() {
                return Some(fault);
            }
            *control = chosen;
        }
        None
    }

    /// Ends an episode whose driver failed: the decision has no reward, and the rest of the episode is unknown.
    fn give_up(&mut self, fault: Fault) -> Step {
        self.finish(Ending::Error(fault), None);
        self.faults_in_a_row += 1;
        self.last_fault = Some(fault);
        Step { reward: 0.0, terminated: false, truncated: true }
    }

    /// Ends an episode whose pedestrians have no further commands, since their controller failed as a program.
    pub fn abandon(&mut self, fault: Fault) {
        self.finish(Ending::ControllerError(fault), None);
    }

    /// Whether the user asked to stop while a driver or a controller was waited for. Nothing is concluded from the episodes since then.
    pub fn is_stopped(&self) -> bool {
        let ended = self.outcome().and_then(Outcome::fault);
        self.last_fault == Some(Fault::Stopped) || ended == Some(Fault::Stopped)
    }

    /// The driver's last fault, if it failed in ten episodes in a row.
    pub fn hopeless(&self) -> Option<Fault> {
        self.last_fault.filter(|_| self.faults_in_a_row >= MOST_FAULTS)
    }

    /// Adds a tick to the digest, vehicles first, in the order of their numbers, and updates the least gap.
    #[inline]
    fn record(&mut self) {
        let mut digest = self.episode.digest;
        for vehicle in &self.world.vehicles {
            let Pose { x, y, yaw } = vehicle.state.pose;
            for value in [x, y, yaw, vehicle.state.speed] {
                digest = mix(digest, value.to_bits());
            }
        }
        let ego = self.world.ego();
        let (middle, size) = (ego.state.pose.position(), ego.blueprint.half_length + ego.blueprint.half_width);
        for (number, pedestrian) in self.world.pedestrians.iter().enumerate() {
            let place = pedestrian.state.pose.position();
            for value in [place.x, place.y] {
                digest = mix(digest, value.to_bits());
            }
            // The distance of the centres bounds the gap from below; most ticks need no more.
            let reach = self.episode.least_gap + size + pedestrian.body.reach();
            if (middle - place).norm_squared() < reach * reach {
                self.episode.least_gap = self.episode.least_gap.min(self.world.gap(0, number));
            }
        }
        self.episode.digest = digest;
    }

    /// Draws the next episodes by another spawn rule. It is not probed: it must be a part of the present one around whose poses of the car a
    /// pedestrian can be placed.
    pub fn respawn(&mut self, rule: SpawnRule) {
        Arc::make_mut(&mut self.scenario).spawn = rule;
    }
}

/// What the driver of a vehicle perceives: in the run-up no pedestrians, and the ego has the way to take; afterwards the stated turns.
#[inline]
fn perceive<'a>(
    sensors: &'a mut PerfectSensors,
    world: &'a World,
    stage: Stage,
    run_up: &'a RunUp,
    held_limit: Option<f64>,
    vehicle: usize,
) -> Perception<'a> {
    let mut perception = sensors.perceive(world, vehicle);
    if let Some(limit) = held_limit.filter(|_| vehicle == 0) {
        (perception.speed_limit, perception.signed_limit) = (limit, None);
    }
    if stage == Stage::RunUp {
        let route = if vehicle == 0 { run_up.lanes() } else { &[] };
        return Perception { pedestrians: &[], route, ..perception };
    }
    perception.route = if vehicle == 0 { run_up.lanes_after_goal() } else { &[] };
    perception
}

/// Adds a start to a hash.
fn hashed(digest: u64, spawn: &Spawn) -> u64 {
    let Spawn { ego, ego_speed, pedestrian } = spawn;
    let values = [ego.x, ego.y, ego.yaw, *ego_speed, pedestrian.x, pedestrian.y, pedestrian.yaw];
    values.iter().fold(digest, |digest, value| mix(digest, value.to_bits()))
}

/// One round of a multiply-rotate hash.
fn mix(digest: u64, word: u64) -> u64 {
    (digest.rotate_left(5) ^ word).wrapping_mul(0x517c_c1b7_2722_0a95)
}

impl Env for PedestrianEnv {
    fn obs_dim(&self) -> usize {
        self.scenario.cast.obs_dim()
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.bounds.clone()
    }

    fn reset(&mut self, state: &mut [f64]) {
        self.begin(self.next_episode);
        self.scene().write_state(state);
    }

    fn step(&mut self, action: &[f64], state: &mut [f64]) -> Step {
        // A driver that failed too often is not asked any more; the training ends with the current update.
        let step = match self.hopeless() {
            Some(_) => Step { reward: 0.0, terminated: false, truncated: true },
            None => {
                let mut commands = std::mem::take(&mut self.walks.scratch);
                self.scene().write_commands(action, &mut commands);
                let step = self.carry_out(&commands);
                self.walks.scratch = commands;
                step
            }
        };
        self.scene().write_state(state);
        step
    }

    /// Whether the episode ended in a failure of the driver.
    fn is_success(&self) -> bool {
        self.is_failure()
    }

    /// Whether the driver is to blame; none where the reward asks for no judgement.
    fn is_fault(&self) -> Option<bool> {
        self.scenario.oracle.is_some().then_some(self.episode.is_fault)
    }

    fn potential(&self) -> f64 {
        match &self.scenario.reward.potential {
            Some(formula) => RewardRule::worth(Some(formula), &self.situation(self.contact()), &self.robustness),
            None => 0.0,
        }
    }

    fn set_curriculum(&mut self, share: f64) {
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
