use std::f64::consts::PI;

use super::{Control, VehicleBlueprint};
use road::Place;
use road::geometry::{OrientedBox, Point, Pose, Vector, wrap_angle};

/// From the bumper back to the driver's eye, which is on the axis (m).
pub const EYE: f64 = 1.9;

/// Position and speed of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VehicleState {
    /// Centre of its box, half way between the axles, and its heading.
    pub pose: Pose,
    /// Speed along its heading (m/s). It is negative only in recordings of cars that reverse.
    pub speed: f64,
    /// Time since it was placed (s); a new vehicle stands until it is in gear.
    pub age: f64,
    /// Height of the ground under it (m) in a town with roads above each other, else 0.
    pub ground: f64,
}

impl VehicleState {
    /// Its place, on its level.
    pub fn place(&self) -> Place {
        Place::on(self.pose.position(), self.ground)
    }

    pub fn outline(&self, blueprint: &VehicleBlueprint) -> OrientedBox {
        OrientedBox::new(self.pose, blueprint.half_length, blueprint.half_width)
    }

    /// The position of the driver's eye.
    pub fn eye(&self, blueprint: &VehicleBlueprint) -> Point {
        self.pose.to_world(Vector::new(blueprint.half_length - EYE, 0.0))
    }

    /// The same motion of a car that is turned round: its rear is its front.
    pub fn reversed(self) -> Self {
        let pose = Pose { yaw: wrap_angle(self.pose.yaw + PI), ..self.pose };
        Self { pose, speed: -self.speed, ..self }
    }

    /// Simulates one tick: a kinematic bicycle about the middle of the wheelbase.
    ///
    /// With slip angle β = atan(tan δ / 2) the position moves along yaw + β and the yaw turns by `v sin β / (L / 2)`. It moves with the mean
    /// of the speeds at both ends of the tick ([`advance`]); the slip angle is that of the speed at the start of the tick. On a slippery road the grip of the tyres bounds the slip angle
    /// and the acceleration.
    ///
    /// # Source
    /// Kong et al., *Kinematic and dynamic vehicle models for autonomous driving control design*, IV 2015, eq. 1.
    pub fn step(&self, control: Control, blueprint: &VehicleBlueprint, dt: f64) -> Self {
        let wheel = blueprint.wheel_angle(control.steer, self.speed);
        let (slip, grip) = blueprint.slip(wheel, self.speed);
        let (sin, cos) = libm::sincos(self.pose.yaw + slip);
        let half_base = blueprint.wheelbase / 2.0;
        let in_gear = self.age >= blueprint.start_up_pause || self.speed > 0.0;
        let acceleration = if in_gear { blueprint.acceleration(control, self.speed) } else { 0.0 };
        let (travelled, speed) = advance(self.speed, acceleration.clamp(-grip, grip), dt);
        let pose = Pose {
            x: self.pose.x + travelled * cos,
            y: self.pose.y + travelled * sin,
            yaw: wrap_angle(self.pose.yaw + travelled * libm::sin(slip) / half_base),
        };
        // A car that has moved is in gear.
        let age = if self.speed > 0.0 { self.age.max(blueprint.start_up_pause) } else { self.age };
        Self { pose, speed, age: age + dt, ground: self.ground }
    }
}

/// The way (m) and the speed at the end (m/s) of a tick of `dt` (s) with this speed at its start (m/s, at least 0) and this acceleration (m/s²). It moves with the
/// mean of both speeds: exact for a constant acceleration, but for a stop within the tick, which is up to half a tick's way too long.
pub fn advance(speed: f64, acceleration: f64, dt: f64) -> (f64, f64) {
    let after = (speed + acceleration * dt).max(0.0);
    ((speed + after) / 2.0 * dt, after)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_is_as_long_as_with_constant_deceleration_at_any_tick() {
        for (from, braking, tick) in [(8.0, 10.7, 0.05), (8.0, 10.7, 0.1), (13.9, 7.593, 0.02), (0.3, 9.0, 0.05)] {
            let (mut speed, mut way) = (from, 0.0);
            while speed > 0.0 {
                let (travelled, after) = advance(speed, -braking, tick);
                (speed, way) = (after, way + travelled);
            }
            let (exact, most): (f64, f64) = (from * from / (2.0 * braking), braking * tick * tick / 2.0);
            assert!(
                (0.0..most).contains(&(way - exact)),
                "from {from} m/s with {braking} m/s²: {way} and not {exact} m"
            );
        }
        assert_eq!(advance(0.0, -5.0, 0.05), (0.0, 0.0));
        assert_eq!(advance(0.0, 2.0, 0.5), (0.25, 1.0));
    }
}
