use road::Place;
use road::geometry::{Obstacles, OrientedBox, Point, Pose, Vector};

/// A pedestrian that is slower (m/s) has no direction of motion.
const AT_REST: f64 = 1e-9;

/// Size and gait of a pedestrian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PedestrianBody {
    /// Radius of its disc (m). Obstacles, times to collision and reference drivers take the disc, also of a target that is a box.
    pub radius: f64,
    /// Half extents (m) of a target that is a box, along its facing direction and across it; `None` for a disc. Touches and gaps are those of
    /// the box.
    pub target_box: Option<Vector>,
    /// Half of its height (m).
    pub half_height: f64,
    /// How its velocity follows its commands.
    pub gait: Gait,
}

/// How the velocity of a pedestrian follows its commands.
///
/// A body that slides along a wall loses the blocked component of its velocity in any gait. That loss is a push of the wall, so no bound of
/// the gait limits it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gait {
    /// That of CARLA's walkers. The acceleration grows with the commanded speed, and turning is not limited by it.
    Carla {
        /// Time from rest to any commanded speed (s); 0 for immediately.
        ramp: f64,
        /// Rate at which the velocity turns to a new direction (1/s); infinite for immediately.
        turning: f64,
        /// Deceleration when the command is slower (m/s²); infinite for immediately.
        stopping: f64,
    },
    /// That of a body with inertia. In each tick the velocity goes straight towards the commanded velocity, as far as the bounds allow.
    ///
    /// The change of velocity of a tick, split into the part `p` along the present velocity and the part `q` across it, satisfies
    /// `(p / b)² + (q / acceleration)² ≤ dt²`, where b is `acceleration` for p ≥ 0 and `stopping` for p < 0. So the whole acceleration
    /// vector is at most the greater of the two, whatever the commands. The direction of the velocity turns by at most `turn_rate · dt`. A
    /// command beyond that angle is replaced by the nearest velocity within it. A reversed command therefore stops the body first. A body
    /// at rest starts in any direction. A commanded speed is never exceeded by a body that starts slower.
    ///
    /// A bound on jerk would need the last acceleration as a part of the pedestrian's state, and recorded walking gives no figure for it.
    Inertial {
        /// Greatest acceleration forwards and sideways (m/s²).
        acceleration: f64,
        /// Greatest acceleration against the present velocity (m/s²).
        stopping: f64,
        /// Greatest rate at which the direction of the velocity turns (rad/s).
        turn_rate: f64,
    },
}

impl PedestrianBody {
    /// CARLA's adult walkers.
    ///
    /// # Source
    /// Dumps of the capsule. Gait: Unreal's character movement, whose acceleration CARLA scales with the commanded speed
    /// (`Walker/WalkerController.cpp`, pull request #9826), with the engine's defaults 20.48 m/s² and friction 8.
    pub fn adult() -> Self {
        let gait = Gait::Carla { ramp: 2.0, turning: 8.0, stopping: Gait::CARLA_STOPPING };
        Self { radius: 0.187_679, target_box: None, half_height: 0.93, gait }
    }

    /// CARLA's child walkers.
    pub fn child() -> Self {
        Self { radius: 0.25, half_height: 0.55, ..Self::adult() }
    }

    /// Whether it is a child: less than 1.5 m tall.
    pub fn is_child(&self) -> bool {
        self.half_height < 0.75
    }

    /// A target with these half extents (m) along its facing direction and across it. Its disc has the greater of them as radius.
    pub fn boxed(half_length: f64, half_width: f64, half_height: f64) -> Self {
        let target_box = Some(Vector::new(half_length, half_width));
        Self { radius: half_length.max(half_width), target_box, half_height, ..Self::adult() }
    }

    /// Half extents (m) along its facing direction and across it; a disc has those of the square around it.
    pub fn half(&self) -> Vector {
        self.target_box.unwrap_or(Vector::new(self.radius, self.radius))
    }

    /// The greatest distance of a point of it from its middle (m).
    pub fn reach(&self) -> f64 {
        self.target_box.map_or(self.radius, |half| half.norm())
    }

    /// Reaches every commanded velocity immediately.
    pub fn nimble(self) -> Self {
        Self { gait: Gait::Carla { ramp: 0.0, turning: f64::INFINITY, stopping: f64::INFINITY }, ..self }
    }
}

/// A command of a pedestrian: a direction and a speed, in the world.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct WalkCommand {
    /// Direction (rad).
    pub heading: f64,
    /// Speed (m/s).
    pub speed: f64,
}

/// Position and motion of a pedestrian.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PedestrianState {
    /// Centre of its disc, and its facing direction: that of its motion, or of its command while it stands.
    pub pose: Pose,
    /// Velocity (m/s).
    pub velocity: Vector,
    /// Height of the ground under it (m) in a town with roads above each other, else 0.
    pub ground: f64,
}

impl PedestrianState {
    /// Stands at a pose.
    pub fn standing(pose: Pose) -> Self {
        Self { pose, ..Self::default() }
    }

    /// Moves at a speed (m/s) in the direction that it faces.
    pub fn moving(pose: Pose, speed: f64) -> Self {
        Self { velocity: Vector::new(libm::cos(pose.yaw), libm::sin(pose.yaw)) * speed, ..Self::standing(pose) }
    }

    /// Its place, on its level.
    pub fn place(&self) -> Place {
        Place::on(self.pose.position(), self.ground)
    }

    /// Speed (m/s).
    pub fn speed(&self) -> f64 {
        self.velocity.norm()
    }

    /// The distance of a body in this state from a box (m); 0 when they touch.
    pub fn gap_to(&self, other: &OrientedBox, body: &PedestrianBody) -> f64 {
        match body.target_box {
            Some(half) => OrientedBox { pose: self.pose, half }.separation(other).norm(),
            None => (other.distance_to(self.pose.position()) - body.radius).max(0.0),
        }
    }

    /// Simulates one tick; the pedestrian slides along obstacles.
    pub fn step(&self, command: WalkCommand, body: &PedestrianBody, obstacles: &Obstacles, dt: f64) -> Self {
        let (sin, cos) = libm::sincos(command.heading);
        let velocity = body.gait.velocity(self.velocity, Vector::new(cos, sin), command.speed, dt);
        // Steps are shorter than the body, so that no pedestrian walks through a thin wall.
        let steps = (velocity.norm() * dt / body.radius).ceil().max(1.0);
        let (from, part) = (self.pose.position(), velocity * (dt / steps));
        let place = (0..steps as u32).fold(from, |place: Point, _| obstacles.push_out(place + part, body.radius));
        let straight = from + velocity * dt;
        let velocity = if (place - straight).norm_squared() > 1e-12 { (place - from) / dt } else { velocity };
        let yaw = if velocity.norm_squared() > 1e-6 { libm::atan2(velocity.y, velocity.x) } else { command.heading };
        Self { pose: Pose::new(place.x, place.y, yaw), velocity, ..*self }
    }
}

impl Gait {
    /// Deceleration of CARLA's walkers (m/s²), Unreal's default.
    pub const CARLA_STOPPING: f64 = 20.48;

    /// The velocity after a tick, from the velocity before it and the commanded direction and speed.
    #[inline]
    fn velocity(&self, before: Vector, wanted: Vector, speed: f64, dt: f64) -> Vector {
        match *self {
            Self::Carla { ramp, turning, stopping } => {
                carla_velocity(before, wanted, speed, dt, (ramp, turning, stopping))
            }
            Self::Inertial { acceleration, stopping, turn_rate } => {
                let target = wanted * speed.max(0.0);
                let present = before.try_normalize(AT_REST);
                let target = present.map_or(target, |present| within_turn(present, target, turn_rate * dt));
                let (change, ahead) = (target - before, present.unwrap_or(wanted));
                let (along, across) = (change.dot(&ahead), ahead.perp(&change));
                let bound = if along < 0.0 { stopping } else { acceleration };
                let effort = Vector::new(along / bound, across / acceleration).norm() / dt;
                if effort > 1.0 { before + change / effort } else { target }
            }
        }
    }
}

/// The velocity nearest to `target` whose direction differs from the unit vector `present` by at most `turn` (rad).
fn within_turn(present: Vector, target: Vector, turn: f64) -> Vector {
    let angle = libm::atan2(present.perp(&target), present.dot(&target));
    if angle.abs() <= turn {
        return target;
    }
    let (sin, cos) = libm::sincos(turn.copysign(angle));
    let edge = Vector::new(cos * present.x - sin * present.y, sin * present.x + cos * present.y);
    edge * target.dot(&edge).max(0.0)
}

fn carla_velocity(
    before: Vector,
    wanted: Vector,
    speed: f64,
    dt: f64,
    (ramp, turning, stopping): (f64, f64, f64),
) -> Vector {
    if speed <= 0.0 {
        let present = before.norm();
        let left = (present - stopping * dt).max(0.0);
        return if left > 0.0 { before * (left / present) } else { Vector::zeros() };
    }
    let present = before.norm();
    let turned = before + (wanted * present - before) * (turning * dt).min(1.0);
    let pushed = match turned.norm() {
        _ if ramp > 0.0 => turned + wanted * (speed * dt / ramp),
        slow if slow > 1e-9 => turned * (speed / slow),
        _ => wanted * speed,
    };
    let reached = pushed.norm();
    if reached <= speed {
        return pushed;
    }
    // Faster than the command: it slows down, limited by its deceleration.
    let allowed = speed.max(present - stopping * dt);
    if reached > allowed { pushed * (allowed / reached) } else { pushed }
}
