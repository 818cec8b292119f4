use crate::sim::{ActorId, Control, EYE, LightColour, Vehicle, VehicleBlueprint, World};
use road::geometry::{Obstacles, OrientedBox, Point, Pose, Vector, half_width_of};
use road::{LaneFilter, Place, Town, Waypoint};

/// Another road user, or the ego itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Actor {
    /// Its id, the same in every tick of an episode. A false alarm of a sensor has [`Actor::FALSE_ALARM`].
    pub id: ActorId,
    /// Middle of its box on the ground, and its heading.
    pub pose: Pose,
    /// Velocity (m/s).
    pub velocity: Vector,
    /// Half extents along its heading and across it (m).
    pub half: Vector,
    /// Height of its reference point above the ground (m): 0 for a vehicle, half its height for a walker, as in CARLA.
    pub height: f64,
}

impl Actor {
    /// The id of an actor that a sensor reports and that does not exist; no actor of a world has it.
    pub const FALSE_ALARM: ActorId = ActorId::Pedestrian(u8::MAX);

    /// A vehicle with this number.
    #[inline]
    fn of_vehicle(number: u8, vehicle: &Vehicle) -> Self {
        let (state, blueprint) = (&vehicle.state, &vehicle.blueprint);
        Self {
            id: ActorId::Vehicle(number),
            pose: state.pose,
            velocity: state.pose.forward() * state.speed,
            half: Vector::new(blueprint.half_length, blueprint.half_width),
            height: 0.0,
        }
    }

    /// The box that it covers.
    pub fn outline(&self) -> OrientedBox {
        OrientedBox { pose: self.pose, half: self.half }
    }

    /// Speed (m/s).
    pub fn speed(&self) -> f64 {
        self.velocity.norm()
    }

    /// What an eye looks at: its middle, and half its width as that eye sees it (m).
    pub fn target(&self, eye: Point) -> (Point, f64) {
        let half_width = match self.id {
            ActorId::Pedestrian(_) => self.half.x.max(self.half.y),
            ActorId::Vehicle(_) => half_width_of(&self.outline(), eye),
        };
        (self.pose.position(), half_width)
    }
}

/// A traffic light in a driver's perception.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Middle of its trigger box.
    pub trigger: Pose,
    pub colour: LightColour,
}

/// Everything that the driving policy of a vehicle may know at a tick. The *ego* is the vehicle that the policy drives; it may
/// be any vehicle of the world.
#[derive(Debug, Clone, Copy)]
pub struct Perception<'a> {
    /// The road map.
    pub town: &'a Town,
    /// The model of the ego.
    pub blueprint: &'a VehicleBlueprint,
    /// Ticks since the driver was reset. Those of a run-up count.
    pub tick: u32,
    /// Length of a tick (s).
    pub dt: f64,
    pub ego: Actor,
    /// Height of the ground under the ego (m) in a town with roads above each other. Nothing on another level is perceived.
    pub ground: f64,
    /// The speed limit where the ego is (m/s): that of its lane, or where the map gives the lane none, that of the last sign, or 30 km/h before the
    /// first sign. [`Perception::limit_at`] gives those ahead.
    pub speed_limit: f64,
    /// The limit of the last sign, or 30 km/h (m/s): what CARLA gives its drivers. None while the driver holds a test speed; then `speed_limit`
    /// is the limit everywhere.
    pub signed_limit: Option<f64>,
    /// The lanes that the ego is to take from its place on, in order, each as a place on it: the first one is the place of the ego, the last
    /// one the end of the route. Afterwards the driver finds its own way. Drivers read it when they are reset. Empty when every way is the
    /// driver's own.
    pub route: &'a [Waypoint],
    /// All pedestrians; [`Perception::in_sight`] is false for hidden ones.
    pub pedestrians: &'a [Actor],
    /// All other vehicles.
    pub vehicles: &'a [Actor],
    /// The obstacles that block sight.
    pub obstacles: &'a Obstacles,
    /// All traffic lights.
    pub lights: &'a [Light],
    /// The light in whose trigger box the ego stands, as an index into `lights`.
    pub affecting_light: Option<usize>,
}

impl Perception<'_> {
    /// The place at which a route of the ego starts: that of the given route, or the nearest place on a driving lane.
    pub fn start_lane(&self) -> Option<Waypoint> {
        let given = self.route.first().copied();
        given.or_else(|| self.town.nearest_lane(self.place(), LaneFilter::Driving))
    }

    /// The place of the ego, on its level.
    pub fn place(&self) -> Place {
        Place::on(self.ego.pose.position(), self.ground)
    }

    /// The speed limit on a lane where the ego is or will be (m/s). Signs that it has not passed yet do not count.
    pub fn limit_at(&self, place: Waypoint) -> f64 {
        let Some(signed) = self.signed_limit else { return self.speed_limit };
        self.town.limit(place).unwrap_or(signed)
    }

    /// The speed limit as CARLA gives it to its drivers (m/s): limits of lanes and road types do not count.
    ///
    /// # Source
    /// CARLA `Traffic/SpeedLimitComponent.cpp`: signs alone set the limit of a vehicle.
    pub fn carla_limit(&self) -> f64 {
        self.signed_limit.unwrap_or(self.speed_limit)
    }

    /// Whether any of an actor can be seen from the driver's eye, as the verdict asks. Obstacles and other actors hide it.
    ///
    /// CARLA's driver does not check it: it reads the world's list of actors.
    pub fn in_sight(&self, actor: &Actor) -> bool {
        let eye = self.ego.pose.to_world(Vector::new(self.ego.half.x - EYE, 0.0));
        self.obstacles.shows(eye, actor.target(eye), self.outlines_but(actor))
    }

    /// The boxes of all others but one.
    pub(super) fn outlines_but(&self, actor: &Actor) -> impl Iterator<Item = OrientedBox> + Clone {
        let (id, all) = (actor.id, self.pedestrians.iter().chain(self.vehicles));
        all.filter(move |other| other.id != id).map(Actor::outline)
    }

    /// The pedals for an acceleration (m/s²), and the full brake for a car at rest that should not move.
    pub(super) fn pedals_or_hold(&self, acceleration: f64) -> Control {
        let speed = self.ego.speed();
        if acceleration <= 0.0 && speed < 0.05 {
            return Control::FULL_BRAKE;
        }
        self.blueprint.pedals_for(acceleration, speed)
    }
}

/// The memory that perceptions borrow from, so that a tick allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct PerfectSensors {
    /// All actors and lights of the world, and those that a driver perceives, which are all without levels.
    all_pedestrians: Vec<Actor>,
    pedestrians: Vec<Actor>,
    all: Vec<Actor>,
    vehicles: Vec<Actor>,
    all_lights: Vec<Light>,
    lights: Vec<Light>,
}

impl PerfectSensors {
    /// Perceives a world exactly and at once, as the driver of the vehicle with this number.
    pub fn perceive<'a>(&'a mut self, world: &'a World, vehicle: usize) -> Perception<'a> {
        self.look(world);
        self.seen_by(world, vehicle)
    }

    /// Looks at a world, for the drivers of all its vehicles.
    pub fn look(&mut self, world: &World) {
        self.all_pedestrians.clear();
        let present = (0..).zip(&world.pedestrians).filter(|(_, pedestrian)| pedestrian.is_present);
        self.all_pedestrians.extend(present.map(|(number, pedestrian)| Actor {
            id: ActorId::Pedestrian(number),
            pose: pedestrian.state.pose,
            velocity: pedestrian.state.velocity,
            half: pedestrian.body.half(),
            height: pedestrian.body.half_height,
        }));
        self.all.clear();
        self.all.extend((0..).zip(&world.vehicles).map(|(number, vehicle)| Actor::of_vehicle(number, vehicle)));
        self.all_lights.clear();
        if let Some(clock) = world.light_clock() {
            let lamps = world.town.traffic_lights.iter();
            self.all_lights.extend(lamps.map(|lamp| Light { trigger: lamp.stop, colour: clock.colour(lamp) }));
        }
    }

    /// What the driver of a vehicle perceives of the world that was last looked at.
    pub fn seen_by<'a>(&'a mut self, world: &'a World, vehicle: usize) -> Perception<'a> {
        self.vehicles.clone_from(&self.all);
        let is_seen = |number: usize| number != vehicle && world.vehicles[number].is_present;
        self.vehicles.retain(|actor| is_seen(actor.id.number()));
        let place = world.vehicles[vehicle].state.place();
        let mut affecting = world.affecting_light(vehicle);
        let has_levels = world.town.has_levels();
        if has_levels {
            self.pedestrians.clone_from(&self.all_pedestrians);
            self.lights.clone_from(&self.all_lights);
            let here = |other: Place| world.town.is_on_level(place, other);
            self.vehicles.retain(|actor| here(world.vehicles[actor.id.number()].state.place()));
            self.pedestrians.retain(|actor| here(world.pedestrians[actor.id.number()].state.place()));
            self.lights.retain(|light| here(world.town.place_of_car(&light.trigger)));
            let trigger = affecting.map(|place| self.all_lights[place].trigger);
            affecting = self.lights.iter().position(|light| Some(light.trigger) == trigger);
        }
        Perception {
            town: &world.town,
            blueprint: &world.vehicles[vehicle].blueprint,
            tick: world.run_up + world.ticks,
            dt: world.dt,
            ego: self.all[vehicle],
            ground: place.ground.unwrap_or_default(),
            speed_limit: world.speed_limit(vehicle),
            signed_limit: Some(world.vehicles[vehicle].speed_limit),
            route: &[],
            pedestrians: if has_levels { &self.pedestrians } else { &self.all_pedestrians },
            vehicles: &self.vehicles,
            obstacles: &world.obstacles,
            lights: if has_levels { &self.lights } else { &self.all_lights },
            affecting_light: affecting,
        }
    }
}
