use rand::RngExt;

use super::{Episode, PedestrianEnv, Stage, perceive};
use crate::av::cruising_speed;
use crate::env::motion::Motion;
use crate::env::{EgoSpeed, LeftOut};
use crate::geometry::Pose;
use crate::sim::{ActorStart, Control, Start, WalkCommand};
use base::seed::{Seed, Stream};

/// The start of an episode: the draw, the run-up of the ego alone, and the moment at which the pedestrians appear.
impl PedestrianEnv {
    /// Starts the episode with this number, and drives its run-up.
    pub fn begin(&mut self, number: u64) {
        self.place(number);
        self.drive_run_up();
    }

    /// Starts the episode with this number as [`PedestrianEnv::begin`] does, but from other random numbers: the start is drawn from `start`, and all
    /// that drivers draw, the way to the start included, comes from below `drivers`.
    pub fn begin_drawn(&mut self, number: u64, start: Stream, drivers: Seed) {
        self.place_drawn(number, start, drivers);
        self.drive_run_up();
    }

    fn drive_run_up(&mut self) {
        while self.is_running_up() {
            self.tick_run_up();
        }
    }

    /// Draws the start of the episode with this number and places the actors. Where that is at the start of a run-up,
    /// [`PedestrianEnv::tick_run_up`] drives it.
    pub fn place(&mut self, number: u64) {
        let seed = self.seed.index(number);
        self.place_drawn(number, seed.child("spawn").stream(), seed);
    }

    fn place_drawn(&mut self, number: u64, mut stream: Stream, seed: Seed) {
        self.drivers = seed;
        let scenario = &self.scenario;
        let first = scenario.cast.pedestrian.first_heading;
        let (town, obstacles) = (&scenario.town, &scenario.obstacles);
        let test = scenario.spawn.target_walk.as_ref();
        let target = test.map(|walk| {
            let approach = walk.approach.quantile(stream.random());
            (approach, walk.spawn(number, approach, &scenario.cast.ego.blueprint))
        });
        let delay = scenario.spawn.given_path.as_ref().map(|path| path.delay.quantile(stream.random()));
        let near = self.near.as_ref().and_then(|near| near.sample_if_easy(town, obstacles, first, &mut stream));
        let drawn = || near.unwrap_or_else(|| scenario.spawn.sample(town, obstacles, first, &mut stream));
        let spawn = target.map_or_else(drawn, |(_, spawn)| spawn);
        (self.release, self.pacing) = (None, None);
        self.approach = target.map_or(1.0, |(approach, _)| approach);
        self.delay = delay.unwrap_or(0.0);
        if let Some(test_speed) = scenario.spawn.test_speed(number) {
            self.held_limit = Some(self.policies[0].speed_limit_for(test_speed));
        }
        // A whole number of cycles of groups with up to four turns.
        let drawn = stream.random_range(0.0..12.0 * scenario.episode.light_cycle.turn());
        let phase = scenario.episode.light_phase.as_ref().map(|phase| phase.quantile(stream.random()));
        self.light_phase = phase.unwrap_or(drawn);
        self.episode = Episode::new(spawn, self.width);
        self.next_episode = number + 1;
        self.decisions.clear();
        self.starts.1[0] = ActorStart::standing(spawn.pedestrian);
        match &scenario.spawn.ego_speed {
            EgoSpeed::Steady => {
                self.stage = Stage::RunUp;
                self.place_before(&spawn.ego, &mut seed.child("run_up").stream());
            }
            EgoSpeed::Drawn(_) => {
                self.run_up.clear();
                self.run_up.lead_on(&scenario.town, &spawn.ego, &scenario.spawn.ego_route);
                self.place_vehicles(ActorStart { pose: spawn.ego, speed: spawn.ego_speed });
                self.meet();
            }
        }
        self.reset_policies();
        self.meet_at_goal();
    }

    /// Places the ego at the start of the run-up to a goal, at the speed at which an average driver would be there.
    fn place_before(&mut self, goal: &Pose, stream: &mut Stream) {
        let town = &self.scenario.town;
        self.run_up.plan(town, *goal, &self.scenario.cast.ego.blueprint, stream);
        self.run_up.lead_on(town, goal, &self.scenario.spawn.ego_route);
        let start = ActorStart::standing(self.run_up.start(town));
        self.place_vehicles(start);
        if let Some(limit) = self.run_up.limit() {
            self.world.vehicles[0].speed_limit = limit;
        }
        let perception = perceive(&mut self.sensors, &self.world, self.stage, &self.run_up, self.held_limit, 0);
        self.path.reset(&perception, stream.clone());
        let cruising = cruising_speed(&self.path, &perception).min(self.run_up.speed());
        let test_speed = self.scenario.spawn.test_speed(self.next_episode - 1);
        self.world.vehicles[0].state.speed = test_speed.unwrap_or(cruising);
    }

    /// Places all actors, with this start of the ego.
    fn place_vehicles(&mut self, ego: ActorStart) {
        let (vehicles, pedestrians) = &mut self.starts;
        vehicles[0] = ego;
        self.world.begin(&Start { vehicles, pedestrians, light_phase: self.light_phase });
        self.controls.fill(Control::default());
    }

    fn reset_policies(&mut self) {
        for (number, policy) in self.policies.iter_mut().enumerate() {
            let seed = driver_seed(&self.drivers, number);
            let perception =
                perceive(&mut self.sensors, &self.world, self.stage, &self.run_up, self.held_limit, number);
            policy.reset(&perception, seed.stream());
        }
    }

    /// Lets all drivers draw from below another seed from now on, each from a stream of its own.
    pub fn reseed(&mut self, drivers: Seed) {
        for (number, policy) in self.policies.iter_mut().enumerate() {
            policy.reseed(driver_seed(&drivers, number).stream());
        }
    }

    /// Whether the run-up of the episode is not over yet.
    pub fn is_running_up(&self) -> bool {
        self.stage == Stage::RunUp
    }

    /// Simulates one tick of the run-up.
    pub fn tick_run_up(&mut self) {
        if let Some(fault) = self.drive() {
            self.stage = Stage::Failed(fault);
            return;
        }
        let touched = self.world.run_up(&self.controls);
        self.episode.run_up += 1;
        self.meet_at_goal();
        let over = touched || self.episode.run_up >= self.scenario.most_run_up();
        if self.is_running_up() && over {
            self.place_vehicles(ActorStart::standing(*self.run_up.goal()));
            self.episode.left_out = Some(LeftOut::RunUp).filter(|_| !self.scenario.episode.count_all);
            self.meet();
            self.reset_policies();
        }
    }

    /// Ends the run-up if the ego has reached its goal.
    fn meet_at_goal(&mut self) {
        let ego = &self.world.ego().state;
        if self.is_running_up() && self.run_up.is_reached(ego, self.world.dt) {
            let spawn = &mut self.episode.spawn;
            (spawn.ego, spawn.ego_speed) = (ego.pose, ego.speed);
            self.meet();
        }
    }

    /// The ticks of this episode's run-up up to now.
    pub fn run_up_ticks(&self) -> u32 {
        self.episode.run_up
    }

    /// The pedestrians appear: tick 0 of the episode.
    fn meet(&mut self) {
        self.stage = Stage::Encounter;
        for (command, start) in self.walks.commands.iter_mut().zip(&self.starts.1) {
            *command = WalkCommand { heading: start.pose.yaw, speed: 0.0 };
        }
        self.walks.turns.fill(0.0);
        for pedestrian in 0..self.world.pedestrians.len() {
            self.episode.least_gap = self.episode.least_gap.min(self.world.gap(0, pedestrian));
        }
        for (pedestrian, motion) in self.motions.iter_mut().enumerate() {
            *motion = Motion::new(&self.world, pedestrian);
        }
        if let Some(trace) = &mut self.trace {
            trace.begin(&self.world);
        }
        self.begin_samples();
        self.begin_watch();
    }
}

/// The seed of what a vehicle's driver draws. That of the ego does not depend on whether there is other traffic.
fn driver_seed(drivers: &Seed, number: usize) -> Seed {
    if number == 0 { drivers.child("policy") } else { drivers.child("traffic").index(number as u64) }
}
