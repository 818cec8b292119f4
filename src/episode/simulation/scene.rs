use std::borrow::Cow;

use super::pursuit::{meeting_heading, walking_heading};
use super::trace::Driven;
use crate::{
    ActionSpec, Actions, Cast, Controller, Destination, Observation, ObservationSpec, PedestrianRole, ReferenceFrame,
    Scenario, SeenActor,
};
use road::geometry::{Point, Pose, Vector};
use world::sim::{ActorId, Contact, WalkCommand, World, time_of};

/// What a policy of pedestrians sees: time, roads, lights and all actors as they are now.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    pub scenario: &'a Scenario,
    pub world: &'a World,
    pub actions: &'a Actions,
    /// The pedestrian that the policy moves; `None` for all that are left to the user of the environment.
    pub(super) only: Option<usize>,
}

impl<'a> Scene<'a> {
    /// What a policy sees that moves all pedestrians that are left to the user of the environment.
    pub fn new(scenario: &'a Scenario, world: &'a World, actions: &'a Actions) -> Self {
        Self { scenario, world, actions, only: None }
    }

    /// The pedestrians that the policy moves, with their numbers.
    pub fn controlled(&self) -> impl Iterator<Item = (usize, &'a PedestrianRole)> + use<'a> {
        let only = self.only;
        let is_moved = move |number: usize, role: &PedestrianRole| match only {
            None => role.controller == Controller::External,
            Some(only) => number == only,
        };
        let all = self.scenario.cast.pedestrians.iter().enumerate();
        all.filter(move |(number, role)| is_moved(*number, role))
    }

    /// The numbers of the joint state of [`Scene::controlled`].
    pub fn obs_dim(&self) -> usize {
        self.controlled().map(|(_, role)| role.observation.dim()).sum()
    }

    /// The command that each pedestrian carries out now.
    pub fn commands(&self) -> &'a [WalkCommand] {
        &self.actions.commands
    }

    /// The cast in which the user of the environment moves the same pedestrians.
    pub(crate) fn cast(&self) -> Cow<'a, Cast> {
        match self.only {
            None => Cow::Borrowed(&self.scenario.cast),
            Some(only) => Cow::Owned(self.scenario.cast.alone(only)),
        }
    }

    /// The bounds of a joint action of [`Scene::controlled`].
    pub fn bounds(&self) -> &'a [(f64, f64)] {
        match self.only {
            None => &self.actions.bounds,
            Some(only) => &self.actions.each_bounds[only * ActionSpec::DIM..(only + 1) * ActionSpec::DIM],
        }
    }

    /// The actors that touched in the last tick, and how; `None` without a touch.
    pub fn contact(&self) -> Option<&'a Contact> {
        self.actions.contact.as_ref()
    }

    /// The touch of the ego and a pedestrian in the last tick.
    pub(super) fn hit(&self) -> Option<&'a Contact> {
        self.contact().filter(|contact| contact.pedestrian_at_ego().is_some())
    }

    /// Time until now, or until a touch within the last tick (s).
    pub(super) fn elapsed(&self) -> f64 {
        let before = time_of(self.world.ticks.saturating_sub(1) as usize, self.world.dt);
        self.contact().map_or(self.world.elapsed(), |contact| before + contact.fraction * self.world.dt)
    }

    /// What the driver of a vehicle did in the last tick.
    #[inline]
    pub fn driven(&self, vehicle: usize) -> Driven {
        self.actions.driven(vehicle)
    }

    /// A pedestrian's observation of the ego.
    pub fn observe(&self, pedestrian: usize) -> Observation {
        let (state, ego) = (&self.world.pedestrians[pedestrian].state, &self.world.ego().state);
        let observed = self.scenario.cast.pedestrians[pedestrian].observation.speed;
        Observation::new(&state.pose, state.speed(), &ego.pose, ego.speed, observed)
    }

    /// Writes the joint state: what each controlled pedestrian observes, in the frame and units of its controller.
    pub fn write_state(&self, state: &mut [f64]) {
        let mut rest = state;
        for (number, role) in self.controlled() {
            let Some(part) = rest.split_off_mut(..role.observation.dim()) else { return };
            let (pedestrian, initial, ego) = self.viewpoint(number);
            let (of_the_ego, rest) = part.split_at_mut(ObservationSpec::DIM);
            let (road, rest) = rest.split_at_mut(role.observation.seen_road());
            let (rays, others) = rest.split_at_mut(role.observation.rays);
            of_the_ego.copy_from_slice(&role.observation.encode(&self.observe(number), pedestrian, initial, ego));
            if let Some(road) = road.as_mut_array() {
                let (car, place) = (&self.world.ego().state, self.world.pedestrians[number].state.place());
                let seen = self.world.town.frenet(&car.pose, car.ground, place);
                *road = role.observation.encode_road(seen, pedestrian, initial, ego);
            }
            role.observation.look(pedestrian, initial, ego, &self.world.obstacles, rays);
            let mut before = (-1.0, 0);
            for place in others.as_chunks_mut().0 {
                let next = self.others(number).filter(|(order, _)| *order > before);
                let nearest = next.min_by(|(one, _), (other, _)| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
                *place = nearest.map_or([0.0; ObservationSpec::OTHER_DIM], |(order, other)| {
                    before = order;
                    role.observation.encode_other(pedestrian, initial, ego, &other)
                });
            }
        }
    }

    /// The actors beside the ego and a pedestrian, each with its distance from that one (m) and its code, by which they are ordered.
    fn others(&self, pedestrian: usize) -> impl Iterator<Item = ((f64, usize), SeenActor)> {
        let own = self.world.pedestrians[pedestrian].state.place();
        let (town, here) = (&self.world.town, own.point);
        let order = move |pose: &Pose, actor: ActorId| ((pose.position() - here).norm(), actor.code());
        let vehicles = self.world.vehicles.iter().enumerate().skip(1).filter(|(_, each)| each.is_present);
        let vehicles = vehicles.filter(move |(_, each)| town.is_on_level(own, each.state.place()));
        let vehicles = vehicles.map(move |(number, each)| {
            let (pose, half) = (each.state.pose, each.outline().half);
            let velocity = pose.forward() * each.state.speed;
            let seen = SeenActor { pose, velocity, half, is_vehicle: true };
            (order(&pose, ActorId::Vehicle(number as u8)), seen)
        });
        let pedestrians = self.world.pedestrians.iter().enumerate();
        let pedestrians = pedestrians.filter(move |(number, each)| *number != pedestrian && each.is_present);
        let pedestrians = pedestrians.filter(move |(_, each)| town.is_on_level(own, each.state.place()));
        vehicles.chain(pedestrians.map(move |(number, each)| {
            let (pose, velocity) = (each.state.pose, each.state.velocity);
            let seen = SeenActor { pose, velocity, half: each.body.half(), is_vehicle: false };
            (order(&pose, ActorId::Pedestrian(number as u8)), seen)
        }))
    }

    /// Writes the present commands for a joint action; pedestrians that are not controlled keep theirs.
    pub fn write_commands(&self, action: &[f64], commands: &mut [WalkCommand]) {
        if self.only.is_none() {
            commands.copy_from_slice(self.commands());
        }
        for ((number, role), part) in self.controlled().zip(action.as_chunks().0) {
            commands[number] = role.action.command(*part, |speed| self.origin(number, role.action.frame, speed));
        }
    }

    /// Writes the joint action for commands of all pedestrians: the inverse of [`Scene::write_commands`], up to rounding. In the frame of the
    /// world and in natural units nothing is rounded.
    pub fn write_action(&self, commands: &[WalkCommand], action: &mut [f64]) {
        for ((number, role), part) in self.controlled().zip(action.as_chunks_mut().0) {
            *part = role.action.action_for(commands[number], |speed| self.origin(number, role.action.frame, speed));
        }
    }

    /// The direction from which a pedestrian's chosen heading is measured at a speed (m/s), in the world (rad).
    pub fn action_origin(&self, number: usize, speed: f64) -> f64 {
        self.origin(number, self.scenario.cast.pedestrians[number].action.frame, speed)
    }

    /// The place of a destination for a pedestrian; `None` in a town without any.
    pub fn place_of(&self, destination: Destination, pedestrian: usize) -> Option<Point> {
        destination.place(&self.scenario.town, self.actions.starts[pedestrian].pose.position())
    }

    fn origin(&self, pedestrian: usize, frame: ReferenceFrame, speed: f64) -> f64 {
        let (pose, initial, place) = self.viewpoint(pedestrian);
        match frame {
            ReferenceFrame::Destination => {
                let start = self.actions.starts[pedestrian].pose.position();
                let destination = self.scenario.cast.pedestrians[pedestrian].action.destination;
                let place = destination.and_then(|destination| self.place_of(destination, pedestrian));
                walking_heading(pose.position(), place, &self.actions.ego, start)
            }
            ReferenceFrame::Meeting => {
                let ego = self.world.ego();
                let bumper = ego.state.pose.to_world(Vector::new(ego.blueprint.half_length, 0.0));
                meeting_heading(pose.position(), &ego.state, bumper, speed, 1.0)
            }
            frame => frame.origin(pose, initial, place),
        }
    }

    /// The command of a homing pedestrian: straight at the ego, at its maximum speed.
    pub fn homing(&self, pedestrian: usize) -> WalkCommand {
        let (pose, _, ego) = self.viewpoint(pedestrian);
        let offset = ego - pose.position();
        WalkCommand { heading: libm::atan2(offset.y, offset.x), speed: self.max_speed(pedestrian) }
    }

    /// The command of an intercepting pedestrian: to the nearest place where it can meet an ego that keeps its velocity, or straight at
    /// the ego if it cannot.
    pub fn intercept(&self, pedestrian: usize) -> WalkCommand {
        self.meeting(pedestrian, self.world.ego().state.pose.position(), self.max_speed(pedestrian), 1.0)
    }

    /// The command of a pedestrian that meets a point of the ego at this speed (m/s), if the ego keeps its velocity; straight at the point
    /// if it cannot meet it. `lead` is the fraction of the ego's way until then by which it aims ahead of the point: 1 meets it, 0 walks
    /// straight at it.
    pub fn meeting(&self, pedestrian: usize, point: Point, speed: f64, lead: f64) -> WalkCommand {
        let pose = &self.world.pedestrians[pedestrian].state.pose;
        WalkCommand { heading: meeting_heading(pose.position(), &self.world.ego().state, point, speed, lead), speed }
    }

    fn max_speed(&self, pedestrian: usize) -> f64 {
        self.scenario.cast.pedestrians[pedestrian].action.speed.1
    }

    /// The pose of a pedestrian, its heading at the start (rad), and where the ego is.
    fn viewpoint(&self, pedestrian: usize) -> (&Pose, f64, Point) {
        let initial = self.actions.starts[pedestrian].pose.yaw;
        (&self.world.pedestrians[pedestrian].state.pose, initial, self.world.ego().state.pose.position())
    }
}
