use rand::RngExt;

use super::{Episode, LocalSimulation};
use crate::scenario::spawn::behind;
use crate::simulation::run_up::Stage;
use crate::simulation::script::Script;
use crate::{Draw, EgoSpeed, Placement, Scene};
use base::seed::Stream;
use road::geometry::Pose;
use world::sim::{ActorStart, Control, Start};

/// The start of an episode: the draw, the run-up of the ego alone, and the moment at which the pedestrians appear.
impl LocalSimulation {
    /// Draws the start of an episode and places the actors.
    pub(super) fn place_drawn(&mut self, Draw { number, start: mut stream, drivers: seed }: Draw) {
        self.drivers.seed = seed;
        let scenario = &self.scenario;
        let (script, stated) = Script::draw(scenario, number, &mut stream);
        let places = seed.child("place");
        let spawn = self.placing.sample(scenario, stated, &mut stream, &places).0;
        let spawn = spawn.expect("checked: the cast can be placed");
        self.script = script;
        if let Some(test_speed) = scenario.spawn.test_speed(number) {
            self.drivers.hold(test_speed);
        }
        // A whole number of cycles of groups with up to four turns.
        let drawn = stream.random_range(0.0..12.0 * scenario.episode.light_cycle().turn());
        let phase = scenario.episode.light_phase.as_ref().map(|phase| phase.quantile(stream.random()));
        self.light_phase = phase.unwrap_or(drawn);
        self.episode = Episode::new(number, spawn, &self.placing);
        self.observers.clear(scenario);
        self.actions.starts.copy_from_slice(&self.placing.pedestrians);
        self.actions.contact = None;
        (self.failed_walker, self.touches, self.ticks_beyond) = (None, None, 0);
        self.walkers.begin(&seed);
        self.run_up.clear();
        match &scenario.spawn.ego_speed {
            EgoSpeed::Steady => self.place_before(&spawn.ego, seed.child("run_up").stream()),
            EgoSpeed::Drawn(_) => {
                self.run_up.lead_on(&scenario.town, &spawn.ego, &scenario.spawn.ego_route);
                self.place_vehicles(ActorStart { pose: spawn.ego, speed: spawn.ego_speed });
                self.meet();
            }
        }
        self.drivers.reset(&self.world, &self.run_up, &mut self.actions);
        self.meet_at_goal();
    }

    /// Places the ego at the start of the run-up to a goal, at the speed at which an average driver would be there.
    fn place_before(&mut self, goal: &Pose, mut stream: Stream) {
        let scenario = &self.scenario;
        let town = &scenario.town;
        self.run_up.plan(town, *goal, &scenario.cast.ego().blueprint, &mut stream);
        self.run_up.lead_on(town, goal, &scenario.spawn.ego_route);
        let start = ActorStart::standing(self.run_up.start(town));
        let test_speed = scenario.spawn.test_speed(self.episode.number);
        self.place_vehicles(start);
        if let Some(limit) = self.run_up.limit {
            self.world.vehicles[0].speed_limit = limit;
        }
        let cruising = self.drivers.cruising_speed(&self.world, &self.run_up, stream);
        self.world.vehicles[0].state.speed = test_speed.unwrap_or(cruising);
    }

    /// Places all actors, with this start of the ego. Pedestrians, and cars that follow the ego, are not in the world yet.
    fn place_vehicles(&mut self, ego: ActorStart) {
        self.placing.vehicles[0] = ego;
        for (vehicle, role) in self.world.vehicles.iter_mut().zip(&self.scenario.cast.vehicles) {
            vehicle.is_present = !role.is_absent && !matches!(role.place, Placement::Behind { .. });
        }
        self.world.pedestrians.iter_mut().for_each(|pedestrian| pedestrian.is_present = false);
        let (vehicles, pedestrians) = (&self.placing.vehicles, &self.actions.starts);
        self.world.begin(&Start { vehicles, pedestrians, light_phase: self.light_phase });
        self.actions.controls.fill(Control::default());
    }

    /// Simulates one tick of the run-up.
    pub(super) fn tick_run_up(&mut self) {
        if let Some(fault) = self.drivers.drive(&self.world, &self.run_up, &mut self.actions) {
            self.run_up.stage = Stage::Failed(fault);
            return;
        }
        let touched = self.world.run_up(&self.actions.controls);
        self.run_up.ticks += 1;
        self.meet_at_goal();
        let over = touched || self.run_up.ticks >= self.scenario.most_run_up();
        if self.run_up.is_running() && over {
            self.place_vehicles(ActorStart::standing(self.run_up.goal));
            self.observers.road.miss_start();
            self.meet();
            self.drivers.reset(&self.world, &self.run_up, &mut self.actions);
        }
    }

    /// Ends the run-up if the ego has reached its goal.
    fn meet_at_goal(&mut self) {
        let ego = &self.world.ego().state;
        if self.run_up.is_running() && self.run_up.is_reached(ego, self.world.dt) {
            let spawn = &mut self.episode.spawn;
            (spawn.ego, spawn.ego_speed) = (ego.pose, ego.speed);
            self.meet();
        }
    }

    /// The pedestrians appear, and the cars that follow the ego: tick 0 of the episode.
    fn meet(&mut self) {
        self.run_up.stage = Stage::Encounter;
        self.actions.begin(self.world.ego().state.pose);
        let Self { scenario, world, actions, .. } = self;
        for (pedestrian, role) in world.pedestrians.iter_mut().zip(&scenario.cast.pedestrians) {
            pedestrian.is_present = !role.is_absent;
        }
        world.put_on_ground();
        for (number, role) in scenario.cast.vehicles.iter().enumerate().filter(|(_, role)| !role.is_absent) {
            let Placement::Behind { .. } = role.place else { continue };
            let ego = world.ego();
            let leader = ActorStart { pose: ego.state.pose, speed: ego.state.speed };
            let lengths = ego.blueprint.half_length + role.blueprint.half_length;
            let start = behind(&scenario.town, &leader, lengths, self.placing.vehicles[number].speed);
            world.appear(number, &start);
            self.drivers.reset_one(number, world, &self.run_up, actions);
        }
        self.observers.begin(&Scene::new(scenario, world, actions));
    }
}
