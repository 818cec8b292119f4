use std::f64::consts::PI;

use super::VehicleBlueprint;
use road::Place;
use road::geometry::{OrientedBox, Pose, wrap_angle};

/// Positions of the pedals and the steering wheel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Control {
    /// Accelerator, 0 to 1.
    pub throttle: f64,
    /// Brake, 0 to 1.
    pub brake: f64,
    /// Steering wheel, −1 to 1, positive to the left (CARLA's is positive to the right).
    pub steer: f64,
}

impl Control {
    /// Full stop with straight wheels.
    pub const FULL_BRAKE: Self = Self { throttle: 0.0, brake: 1.0, steer: 0.0 };
}

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

    /// The same motion of a car that is turned round: its rear is its front.
    pub fn reversed(self) -> Self {
        let pose = Pose { yaw: wrap_angle(self.pose.yaw + PI), ..self.pose };
        Self { pose, speed: -self.speed, ..self }
    }

    /// Simulates one tick: a kinematic bicycle about the middle of the wheelbase.
    ///
    /// With slip angle β = atan(tan δ / 2) the position moves along yaw + β and the yaw turns by `v sin β / (L / 2)`;
    /// position and yaw use the speed at the start of the tick. On a slippery road the grip of the tyres bounds the slip angle and the
    /// acceleration.
    ///
    /// # Source
    /// Kong et al., *Kinematic and dynamic vehicle models for autonomous driving control design*, IV 2015, eq. 1.
    pub fn step(&self, control: Control, blueprint: &VehicleBlueprint, dt: f64) -> Self {
        let wheel = blueprint.wheel_angle(control.steer, self.speed);
        let (slip, grip) = blueprint.slip(wheel, self.speed);
        let (sin, cos) = libm::sincos(self.pose.yaw + slip);
        let half_base = blueprint.wheelbase / 2.0;
        let travelled = self.speed * dt;
        let pose = Pose {
            x: self.pose.x + travelled * cos,
            y: self.pose.y + travelled * sin,
            yaw: wrap_angle(self.pose.yaw + travelled * libm::sin(slip) / half_base),
        };
        let in_gear = self.age >= blueprint.start_up_pause || self.speed > 0.0;
        let acceleration = if in_gear { blueprint.acceleration(control, self.speed) } else { 0.0 };
        let speed = (self.speed + acceleration.clamp(-grip, grip) * dt).max(0.0);
        // A car that has moved is in gear.
        let age = if self.speed > 0.0 { self.age.max(blueprint.start_up_pause) } else { self.age };
        Self { pose, speed, age: age + dt, ground: self.ground }
    }
}
