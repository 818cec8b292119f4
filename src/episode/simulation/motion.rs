use crate::scenario::signal::HORIZON;
use road::geometry::{Vector, time_to_touch, wrap_angle};
use world::sim::World;

/// Below this speed a car stands, and a pedestrian has no direction of motion (m/s).
pub(super) const STANDING: f64 = 0.1;

/// The motions of the ego and of one pedestrian that rewards can depend on, measured tick by tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pedestrian: usize,
    ego_speed: f64,
    velocity: Vector,
    /// The pedestrian's last direction of motion (rad); `None` before it has moved.
    direction: Option<f64>,
    /// Least time to collision of the episode while the ego moved (s), at most [`HORIZON`].
    pub(super) min_ttc: f64,
    /// Greatest deceleration of the ego in the decision (m/s²).
    pub(super) ego_deceleration: f64,
    /// Greatest acceleration of the pedestrian in the decision (m/s²).
    pub(super) walking_acceleration: f64,
    /// Angle by which the pedestrian's motion turned in the decision (rad).
    pub(super) walking_turn: f64,
}

impl Motion {
    /// At the start of an episode.
    pub(super) fn new(world: &World, pedestrian: usize) -> Self {
        let mut motion = Self {
            pedestrian,
            ego_speed: world.ego().state.speed,
            velocity: world.pedestrians[pedestrian].state.velocity,
            direction: None,
            min_ttc: HORIZON,
            ego_deceleration: 0.0,
            walking_acceleration: 0.0,
            walking_turn: 0.0,
        };
        motion.direction = direction(motion.velocity);
        motion.measure_ttc(world);
        motion
    }

    /// Starts a decision.
    pub(super) fn begin_decision(&mut self) {
        (self.ego_deceleration, self.walking_acceleration, self.walking_turn) = (0.0, 0.0, 0.0);
    }

    /// Measures a tick that has just been simulated.
    pub(super) fn tick(&mut self, world: &World) {
        let speed = world.ego().state.speed;
        let velocity = world.pedestrians[self.pedestrian].state.velocity;
        self.ego_deceleration = self.ego_deceleration.max((self.ego_speed - speed) / world.dt);
        self.walking_acceleration = self.walking_acceleration.max((velocity - self.velocity).norm() / world.dt);
        if let Some(now) = direction(velocity) {
            let turned = self.direction.map_or(0.0, |before| wrap_angle(now - before));
            self.walking_turn = wrap_angle(self.walking_turn + turned);
            self.direction = Some(now);
        }
        (self.ego_speed, self.velocity) = (speed, velocity);
        self.measure_ttc(world);
    }

    fn measure_ttc(&mut self, world: &World) {
        let ego = world.ego();
        if ego.state.speed <= STANDING || !world.is_on_level(0, self.pedestrian) {
            return;
        }
        let walker = &world.pedestrians[self.pedestrian];
        let place = ego.state.pose.to_local(walker.state.pose.position());
        let velocity = self.velocity - ego.state.pose.forward() * ego.state.speed;
        let closing = Vector::new(velocity.dot(&ego.state.pose.forward()), velocity.dot(&ego.state.pose.left()));
        let half = Vector::new(ego.blueprint.half_length, ego.blueprint.half_width);
        let place = Vector::new(place.x, place.y);
        if let Some(time) = time_to_touch(place, closing, half, walker.body.radius, self.min_ttc) {
            self.min_ttc = time;
        }
    }
}

fn direction(velocity: Vector) -> Option<f64> {
    (velocity.norm_squared() > STANDING * STANDING).then(|| libm::atan2(velocity.y, velocity.x))
}
