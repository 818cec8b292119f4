use crate::geometry::{Obstacles, OrientedBox, Pose, Vector};
use crate::road::Town;
use crate::sim::{Control, LightColour, VehicleBlueprint, World};

/// Another road user, or the ego itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Actor {
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
    /// The box that it fills.
    pub fn outline(&self) -> OrientedBox {
        OrientedBox { pose: self.pose, half: self.half }
    }

    /// Speed (m/s).
    pub fn speed(&self) -> f64 {
        self.velocity.norm()
    }
}

/// A traffic light as a driver knows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Middle of its trigger box.
    pub trigger: Pose,
    /// What it shows.
    pub colour: LightColour,
}

/// Everything that a driving policy may know at a tick.
#[derive(Debug, Clone, Copy)]
pub struct Perception<'a> {
    /// The road map.
    pub town: &'a Town,
    /// The model of the ego.
    pub blueprint: &'a VehicleBlueprint,
    /// Ticks since the episode began.
    pub tick: u32,
    /// Length of a tick (s).
    pub dt: f64,
    /// The ego.
    pub ego: Actor,
    /// The limit that holds for the ego (m/s).
    pub speed_limit: f64,
    /// All pedestrians; [`Perception::in_sight`] tells who is hidden.
    pub pedestrians: &'a [Actor],
    /// All other vehicles.
    pub vehicles: &'a [Actor],
    /// What blocks sight.
    pub obstacles: &'a Obstacles,
    /// All traffic lights.
    pub lights: &'a [Light],
    /// The light in whose trigger box the ego stands: its place in `lights`.
    pub affecting_light: Option<usize>,
}

impl Perception<'_> {
    /// Whether nothing stands between the middles of the ego and of an actor.
    ///
    /// CARLA's driver does not ask: it reads the world's list of actors.
    pub fn in_sight(&self, actor: &Actor) -> bool {
        !self.obstacles.blocks_sight(self.ego.pose.position(), actor.pose.position())
    }

    /// The pedals for an acceleration (m/s²), and the full brake for a car at rest that does not want to move.
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
pub struct Sensors {
    pedestrians: Vec<Actor>,
    lights: Vec<Light>,
}

impl Sensors {
    /// Perceives a world exactly and at once.
    pub fn perceive<'a>(&'a mut self, world: &'a World) -> Perception<'a> {
        let (ego, body) = (&world.ego, &world.body);
        self.pedestrians.clear();
        self.pedestrians.push(Actor {
            pose: world.pedestrian.pose,
            velocity: world.pedestrian.velocity,
            half: Vector::new(body.radius, body.radius),
            height: body.half_height,
        });
        self.lights.clear();
        if let Some(clock) = world.light_clock() {
            let lamps = world.town.traffic_lights.iter();
            self.lights.extend(lamps.map(|lamp| Light { trigger: lamp.stop, colour: clock.colour(lamp) }));
        }
        Perception {
            town: &world.town,
            blueprint: &world.blueprint,
            tick: world.ticks,
            dt: world.dt,
            ego: Actor {
                pose: ego.pose,
                velocity: ego.pose.forward() * ego.speed,
                half: Vector::new(world.blueprint.half_length, world.blueprint.half_width),
                height: 0.0,
            },
            speed_limit: world.speed_limit,
            pedestrians: &self.pedestrians,
            vehicles: &[],
            obstacles: &world.obstacles,
            lights: &self.lights,
            affecting_light: world.affecting_light(),
        }
    }
}
