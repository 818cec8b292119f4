use std::sync::Arc;

use super::{
    ActorId, ActorStart, Contact, Control, LightClock, LightCycle, Pedestrian, PedestrianBody, Start, Vehicle,
    VehicleBlueprint, VehicleState, WalkCommand,
};
use road::geometry::{Obstacles, OrientedBox, Point, half_width_of};
use road::{LaneFilter, Place, Town};

/// A town with vehicles and pedestrians in it. Vehicle 0 is the ego, the car under test.
///
/// A tick loops over the two lists of actors and allocates nothing. A list without actors costs no time.
#[derive(Debug, Clone)]
pub struct World {
    /// The roads.
    pub town: Arc<Town>,
    /// What blocks pedestrians and sight: the obstacles of the town, and parked vehicles.
    pub obstacles: Arc<Obstacles>,
    /// The vehicles, the ego first.
    pub vehicles: Vec<Vehicle>,
    pub pedestrians: Vec<Pedestrian>,
    /// Ticks since the start of the episode.
    pub ticks: u32,
    /// Ticks before it, in which only the vehicles moved.
    pub run_up: u32,
    /// Length of a tick (s).
    pub dt: f64,
    /// The cycle of the traffic lights; `None` if they are switched off.
    pub lights: Option<LightCycle>,
    light_phase: f64,
}

impl World {
    /// Makes a world with all actors at the origin; [`World::begin`] places them.
    ///
    /// # Panics
    /// Without a vehicle, or with more than [`ActorId::MAX_COUNT`] vehicles or pedestrians.
    pub fn new(
        town: Arc<Town>,
        obstacles: Arc<Obstacles>,
        vehicles: Vec<VehicleBlueprint>,
        pedestrians: Vec<PedestrianBody>,
        lights: Option<LightCycle>,
        dt: f64,
    ) -> Self {
        assert!(!vehicles.is_empty(), "a world has an ego");
        assert!(
            vehicles.len().max(pedestrians.len()) <= ActorId::MAX_COUNT,
            "a world has at most 255 actors of a kind"
        );
        Self {
            town,
            obstacles,
            vehicles: vehicles.into_iter().map(Vehicle::new).collect(),
            pedestrians: pedestrians.into_iter().map(Pedestrian::new).collect(),
            ticks: 0,
            run_up: 0,
            dt,
            lights,
            light_phase: 0.0,
        }
    }

    /// Places the actors and starts the clock.
    ///
    /// # Panics
    /// When the start does not have one place for each actor.
    pub fn begin(&mut self, start: &Start<'_>) {
        assert_eq!(start.vehicles.len(), self.vehicles.len(), "each vehicle has a start");
        assert_eq!(start.pedestrians.len(), self.pedestrians.len(), "each pedestrian has a start");
        for (vehicle, start) in self.vehicles.iter_mut().zip(start.vehicles) {
            vehicle.begin(start.vehicle(), &self.town);
        }
        for (pedestrian, start) in self.pedestrians.iter_mut().zip(start.pedestrians) {
            pedestrian.begin(start.pedestrian());
        }
        self.put_on_ground();
        if self.vehicles.iter().any(|vehicle| vehicle.is_parked) {
            let parked = self.vehicles.iter().filter(|vehicle| vehicle.is_parked && vehicle.is_present);
            Arc::make_mut(&mut self.obstacles).park(parked.map(Vehicle::outline));
        }
        (self.ticks, self.run_up) = (0, 0);
        self.light_phase = start.light_phase;
    }

    /// Puts the pedestrians, who have just been placed, on the ground, on the level of the ego where roads lie above each other.
    pub fn put_on_ground(&mut self) {
        let (town, ego) = (&self.town, self.vehicles[0].state.place());
        for pedestrian in self.pedestrians.iter_mut().filter(|_| town.has_levels()) {
            pedestrian.state.ground = town.ground_beside(ego, pedestrian.state.pose.position());
            pedestrian.before = pedestrian.state;
        }
    }

    /// Whether a vehicle and a pedestrian are on one level. Otherwise they neither meet nor see each other.
    pub fn is_on_level(&self, vehicle: usize, pedestrian: usize) -> bool {
        self.town.is_on_level(self.vehicles[vehicle].state.place(), self.pedestrians[pedestrian].state.place())
    }

    /// Whether one actor sees any of another: a driver from its eye, a pedestrian from its middle. Obstacles and other actors hide it. An actor that is not in the
    /// world, or is on another level, is not seen.
    pub fn sees(&self, from: ActorId, of: ActorId) -> bool {
        let (Some((here, eye, _)), Some((there, _, outline))) = (self.seen(from), self.seen(of)) else { return false };
        let half_width = match of {
            ActorId::Pedestrian(number) => self.pedestrians[usize::from(number)].body.radius,
            ActorId::Vehicle(_) => half_width_of(&outline, eye),
        };
        let others = self.actors().filter(|id| ![from, of].contains(id)).filter_map(|id| Some(self.seen(id)?.2));
        self.town.is_on_level(here, there) && self.obstacles.shows(eye, (outline.pose.position(), half_width), others)
    }

    /// All actors, also those that are not in the world.
    fn actors(&self) -> impl Iterator<Item = ActorId> + Clone + use<> {
        let (vehicles, pedestrians) = (self.vehicles.len() as u8, self.pedestrians.len() as u8);
        (0..vehicles).map(ActorId::Vehicle).chain((0..pedestrians).map(ActorId::Pedestrian))
    }

    /// The place, the eye and the box of an actor; `None` if it is not in the world.
    fn seen(&self, id: ActorId) -> Option<(Place, Point, OrientedBox)> {
        match id {
            ActorId::Vehicle(number) => {
                let Vehicle { state, blueprint, is_present, .. } = &self.vehicles[usize::from(number)];
                is_present.then(|| (state.place(), state.eye(blueprint), state.outline(blueprint)))
            }
            ActorId::Pedestrian(number) => {
                let Pedestrian { state, body, is_present, .. } = &self.pedestrians[usize::from(number)];
                let place = state.place();
                is_present.then(|| (place, place.point, OrientedBox { pose: state.pose, half: body.half() }))
            }
        }
    }

    /// Lets a vehicle appear at a start, in an episode that runs.
    pub fn appear(&mut self, vehicle: usize, start: &ActorStart) {
        self.vehicles[vehicle].begin(start.vehicle(), &self.town);
        self.vehicles[vehicle].is_present = true;
    }

    /// The car under test.
    pub fn ego(&self) -> &Vehicle {
        &self.vehicles[0]
    }

    /// The speed limit of a vehicle (m/s): that of its lane where the map has limits, else that of the last sign, or 30 km/h.
    pub fn speed_limit(&self, vehicle: usize) -> f64 {
        let (town, vehicle) = (&self.town, &self.vehicles[vehicle]);
        let place = vehicle.state.place();
        let lane = town.has_limits().then(|| town.nearest_lane(place, LaneFilter::Driving)).flatten();
        lane.and_then(|lane| town.limit(lane)).unwrap_or(vehicle.speed_limit)
    }

    /// Time since the start (s).
    pub fn elapsed(&self) -> f64 {
        time_of(self.ticks as usize, self.dt)
    }

    /// The clock of the traffic lights; `None` if they are switched off.
    pub fn light_clock(&self) -> Option<LightClock> {
        self.lights.map(|cycle| cycle.clock(self.light_phase + f64::from(self.run_up + self.ticks) * self.dt))
    }

    /// The traffic light in whose trigger box a vehicle stands: its place among the town's lights. `None` if lights are
    /// switched off.
    pub fn affecting_light(&self, vehicle: usize) -> Option<usize> {
        self.lights?;
        self.vehicles[vehicle].affecting_light(&self.town)
    }

    /// Distance from a pedestrian to a vehicle's box (m); 0 when they touch, and infinite if one of them is not in the world, or on another level.
    pub fn gap(&self, vehicle: usize, pedestrian: usize) -> f64 {
        if !self.is_on_level(vehicle, pedestrian) {
            return f64::INFINITY;
        }
        let (vehicle, pedestrian) = (&self.vehicles[vehicle], &self.pedestrians[pedestrian]);
        if !vehicle.is_present || !pedestrian.is_present {
            return f64::INFINITY;
        }
        pedestrian.state.gap_to(&vehicle.outline(), &pedestrian.body)
    }

    /// Simulates one tick of all actors and finds their first touch. There is one control for each vehicle and one command for each
    /// pedestrian.
    ///
    /// Vehicles touch pedestrians and each other. Pedestrians pass through each other, and slide along parked vehicles. Of two touches at the same time the one with a
    /// pedestrian counts, then the one with the smaller numbers. After a touch the actors are where the tick ends; the [`Contact`] has the
    /// touch itself.
    ///
    /// # Panics
    /// When the number of controls or commands is not that of the vehicles or pedestrians.
    pub fn tick(&mut self, controls: &[Control], commands: &[WalkCommand]) -> Option<Contact> {
        assert_eq!(controls.len(), self.vehicles.len(), "each vehicle has a control");
        for (vehicle, control) in self.vehicles.iter_mut().zip(controls) {
            vehicle.step(*control, &self.town, self.dt);
        }
        self.walk(commands);
        self.ticks += 1;
        self.first_contact()
    }

    /// Lets the pedestrians walk for the next tick, which [`World::follow`] ends.
    ///
    /// # Panics
    /// When the number of commands is not that of the pedestrians.
    pub fn walk(&mut self, commands: &[WalkCommand]) {
        assert_eq!(commands.len(), self.pedestrians.len(), "each pedestrian has a command");
        for (pedestrian, command) in self.pedestrians.iter_mut().zip(commands) {
            pedestrian.step(*command, &self.obstacles, &self.town, self.dt);
        }
    }

    /// Ends a tick in which the pedestrians have walked and another simulator has moved the ego, and finds the first touch as [`World::tick`]
    /// does.
    pub fn follow(&mut self, ego: VehicleState) -> Option<Contact> {
        self.vehicles[0].follow(ego, &self.town);
        self.ticks += 1;
        self.first_contact()
    }

    /// Simulates one tick of all vehicles before the episode starts, and returns whether two of them touched. Pedestrians are not there yet;
    /// traffic lights change.
    ///
    /// # Panics
    /// When the number of controls is not that of the vehicles, and after the first [`World::tick`].
    pub fn run_up(&mut self, controls: &[Control]) -> bool {
        assert_eq!(controls.len(), self.vehicles.len(), "each vehicle has a control");
        assert_eq!(self.ticks, 0, "the episode has not started");
        for (vehicle, control) in self.vehicles.iter_mut().zip(controls) {
            vehicle.step(*control, &self.town, self.dt);
        }
        self.run_up += 1;
        let mut touched = false;
        self.vehicle_contacts(|_| touched = true);
        touched
    }

    /// Finds the first touch of the last tick between actors that are in the world.
    #[inline]
    pub fn first_contact(&self) -> Option<Contact> {
        let mut first: Option<Contact> = None;
        let mut note = |found: Contact| {
            if first.is_none_or(|first| found.fraction < first.fraction) {
                first = Some(found);
            }
        };
        for (number, vehicle) in self.vehicles.iter().enumerate().filter(|(_, vehicle)| vehicle.is_driven()) {
            for (other, pedestrian) in self.pedestrians.iter().enumerate().filter(|(_, each)| each.is_present) {
                if Contact::is_pedestrian_near(vehicle, pedestrian, self.dt) {
                    let pair = (ActorId::Vehicle(number as u8), ActorId::Pedestrian(other as u8));
                    Contact::with_pedestrian(pair, vehicle, pedestrian).into_iter().for_each(&mut note);
                }
            }
        }
        self.vehicle_contacts(&mut note);
        first
    }

    /// Passes on the touches of two vehicles in the last tick.
    #[inline]
    fn vehicle_contacts(&self, mut note: impl FnMut(Contact)) {
        let present = || self.vehicles.iter().enumerate().filter(|(_, vehicle)| vehicle.is_present);
        for (number, vehicle) in present() {
            for (other, second) in present().filter(|(other, _)| *other > number) {
                if Contact::is_vehicle_near(vehicle, second, self.dt) {
                    let pair = (ActorId::Vehicle(number as u8), ActorId::Vehicle(other as u8));
                    Contact::with_vehicle(pair, vehicle, second).into_iter().for_each(&mut note);
                }
            }
        }
    }
}

/// The time (s) after a number of ticks of `dt` (s): exactly the decimal number that people write. Three ticks of 0.05 s are 0.15 s and not a bit more.
pub fn time_of(ticks: usize, dt: f64) -> f64 {
    (ticks as f64 * dt * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_the_numbers_that_people_write() {
        for (ticks, dt, time) in [(3, 0.05, 0.15), (7, 0.1, 0.7), (3, 0.1, 0.3), (599, 0.05, 29.95), (1, 0.001, 0.001)]
        {
            assert_eq!(time_of(ticks, dt), time, "{ticks} ticks of {dt} s");
        }
    }
}
