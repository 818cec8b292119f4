use crate::geometry::{Obstacles, Point, Pose, Vector};

/// Size and gait of a pedestrian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PedestrianBody {
    /// Radius of its disc (m).
    pub radius: f64,
    /// Half of its height (m).
    pub half_height: f64,
    /// Time from rest to any commanded speed (s); 0 for immediately.
    pub ramp: f64,
    /// Rate at which the velocity turns to a new direction (1/s); infinite for immediately.
    pub turning: f64,
    /// Deceleration when the command is slower (m/s²); infinite for immediately.
    pub stopping: f64,
}

impl PedestrianBody {
    /// CARLA's adult walkers.
    ///
    /// # Source
    /// Dumps of the capsule. Gait: Unreal's character movement, whose acceleration CARLA scales with the commanded speed
    /// (`Walker/WalkerController.cpp`, pull request #9826), with the engine's defaults 20.48 m/s² and friction 8.
    pub fn adult() -> Self {
        Self { radius: 0.187_679, half_height: 0.93, ramp: 2.0, turning: 8.0, stopping: 20.48 }
    }

    /// CARLA's child walkers.
    pub fn child() -> Self {
        Self { radius: 0.25, half_height: 0.55, ..Self::adult() }
    }

    /// Reaches every commanded velocity immediately.
    pub fn nimble(self) -> Self {
        Self { ramp: 0.0, turning: f64::INFINITY, stopping: f64::INFINITY, ..self }
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
}

impl PedestrianState {
    /// Stands at a pose.
    pub fn standing(pose: Pose) -> Self {
        Self { pose, velocity: Vector::zeros() }
    }

    /// Speed (m/s).
    pub fn speed(&self) -> f64 {
        self.velocity.norm()
    }

    /// Simulates one tick; the pedestrian slides along obstacles.
    pub fn step(&self, command: WalkCommand, body: &PedestrianBody, obstacles: &Obstacles, dt: f64) -> Self {
        let wanted = Vector::new(libm::cos(command.heading), libm::sin(command.heading));
        let velocity = body.velocity(self.velocity, wanted, command.speed, dt);
        // Steps are shorter than the body, so that no pedestrian walks through a thin wall.
        let steps = (velocity.norm() * dt / body.radius).ceil().max(1.0);
        let (from, part) = (self.pose.position(), velocity * (dt / steps));
        let place = (0..steps as u32).fold(from, |place: Point, _| obstacles.push_out(place + part, body.radius));
        let straight = from + velocity * dt;
        let velocity = if (place - straight).norm_squared() > 1e-12 { (place - from) / dt } else { velocity };
        let yaw = if velocity.norm_squared() > 1e-6 { libm::atan2(velocity.y, velocity.x) } else { command.heading };
        Self { pose: Pose::new(place.x, place.y, yaw), velocity }
    }
}

impl PedestrianBody {
    fn velocity(&self, before: Vector, wanted: Vector, speed: f64, dt: f64) -> Vector {
        if speed <= 0.0 {
            let present = before.norm();
            let left = (present - self.stopping * dt).max(0.0);
            return if left > 0.0 { before * (left / present) } else { Vector::zeros() };
        }
        let present = before.norm();
        let turned = before + (wanted * present - before) * (self.turning * dt).min(1.0);
        let pushed = match turned.norm() {
            _ if self.ramp > 0.0 => turned + wanted * (speed * dt / self.ramp),
            slow if slow > 1e-9 => turned * (speed / slow),
            _ => wanted * speed,
        };
        let reached = pushed.norm();
        if reached <= speed {
            return pushed;
        }
        // Faster than the command: it slows down, limited by its deceleration.
        let allowed = speed.max(present - self.stopping * dt);
        if reached > allowed { pushed * (allowed / reached) } else { pushed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::OrientedBox;

    fn walk(state: PedestrianState, command: WalkCommand, body: PedestrianBody, ticks: u32) -> PedestrianState {
        let free = Obstacles::new(&[]);
        (0..ticks).fold(state, |state, _| state.step(command, &body, &free, 0.05))
    }

    #[test]
    fn an_adult_needs_two_seconds_to_any_speed() {
        for speed in [1.0, 3.5] {
            let command = WalkCommand { heading: 1.0, speed };
            let half = walk(PedestrianState::default(), command, PedestrianBody::adult(), 20);
            assert!((half.speed() - speed / 2.0).abs() < 1e-9);
            let full = walk(half, command, PedestrianBody::adult(), 40);
            assert!((full.speed() - speed).abs() < 1e-9 && (full.pose.yaw - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_nimble_one_is_at_once_where_it_wants() {
        let body = PedestrianBody::adult().nimble();
        let east = walk(PedestrianState::default(), WalkCommand { heading: 0.0, speed: 3.5 }, body, 20);
        assert!((east.pose.x - 3.5).abs() < 1e-12 && east.pose.y.abs() < 1e-12);
        let back = walk(east, WalkCommand { heading: std::f64::consts::PI, speed: 1.0 }, body, 20);
        assert!((back.pose.x - 2.5).abs() < 1e-9);
        assert_eq!(walk(back, WalkCommand { heading: 0.0, speed: 0.0 }, body, 1).speed(), 0.0);
    }

    #[test]
    fn a_wall_stops_whoever_walks_into_it() {
        let wall = OrientedBox::new(Pose::new(5.0, 0.0, 0.0), 0.5, 50.0);
        let obstacles = Obstacles::new(&[wall]);
        for (body, far) in [(PedestrianBody::adult().nimble(), 7.0), (PedestrianBody::adult(), 1.5)] {
            let mut state = PedestrianState::default();
            for _ in 0..200 {
                state = state.step(WalkCommand { heading: 0.3, speed: 3.0 }, &body, &obstacles, 0.05);
                assert!(wall.distance_to(state.pose.position()) > body.radius - 1e-3);
            }
            assert!(state.pose.y > far, "it slides along the wall: {}", state.pose.y);
            assert!(state.velocity.x.abs() < 1e-6 && state.velocity.y > 0.0, "its velocity is that of its motion");
        }
    }

    #[test]
    fn nobody_walks_through_a_thin_wall() {
        let wall = OrientedBox::new(Pose::new(5.0, 0.0, 0.0), 0.01, 10.0);
        let obstacles = Obstacles::new(&[wall]);
        let body = PedestrianBody::adult().nimble();
        let mut state = PedestrianState::default();
        for _ in 0..100 {
            state = state.step(WalkCommand { heading: 0.0, speed: 20.0 }, &body, &obstacles, 0.1);
        }
        assert!(state.pose.x < 5.0, "{}", state.pose.x);
    }
}
