use super::bridge::{STANDING, millimetres};
use crate::av::Fault;
use crate::geometry::{Vector, wrap_angle};
use crate::sim::VehicleState;

/// How far from where its speed and heading lead a car may be after a tick: in m, if the world does not say how far, and beside that as a share of its way.
/// More is a jump. The first tick of MetaDrive's physics lacks a fifth.
const JUMP: f64 = 0.1;
const LAG: f64 = 0.25;
/// How much its way in an episode may differ from what its speeds make: as a share of the longer of both, beside that (m), and beside what a standing car creeps.
const BY_SPEED: f64 = 0.1;
const FREE: f64 = 0.5;
/// How far the motion of a car may differ from its heading (rad), on average over the last metres of its way.
const BESIDE: f64 = 0.3;
const MEMORY: f64 = 3.0;

/// Compares the motion of a car of another simulator with the speeds and headings that it states, tick by tick for an episode.
#[derive(Debug, Default)]
pub(super) struct Odometer {
    /// The way of the car, and the one that its speeds make (m).
    way: f64,
    by_speed: f64,
    /// The time of both (s).
    time: f64,
    /// The angle between motion and heading, on average over the last metres (rad).
    beside: f64,
}

impl Odometer {
    /// Adds a tick of a car with this wheelbase (m). `tolerance` is how far from where it is told the world may place an actor (m).
    ///
    /// # Errors
    /// The car is not where its speed and its heading lead.
    pub fn add(
        &mut self,
        [before, after]: [&VehicleState; 2],
        (dt, wheelbase, tolerance): (f64, f64, f64),
    ) -> Result<(), Fault> {
        let speed = (before.speed + after.speed) / 2.0;
        // Ahead, also of a car that reverses.
        let moved = (after.pose.position() - before.pose.position()) * speed.signum();
        let (way, by_speed) = (moved.norm(), speed.abs() * dt);
        (self.way, self.by_speed, self.time) = (self.way + way, self.by_speed + by_speed, self.time + dt);
        let turned = wrap_angle(after.pose.yaw - before.pose.yaw);
        // A car turns about a point beside its rear axle, so its middle slips; that of a car on rails does not.
        let slip = libm::asin((turned * wheelbase / 2.0 / way.max(1e-9)).clamp(-1.0, 1.0));
        let headings = [0.0, slip].map(|slip| before.pose.yaw + turned / 2.0 + slip);
        let off = headings.map(|heading| {
            let (sin, cos) = libm::sincos(heading);
            (moved - Vector::new(cos, sin) * by_speed).norm()
        });
        let off = off[0].min(off[1]);
        if off > tolerance.max(JUMP) + LAG * by_speed {
            return Err(Fault::Jumped { millimetres: millimetres(off) });
        }
        if (self.way - self.by_speed).abs() > BY_SPEED * self.way.max(self.by_speed) + FREE + STANDING * self.time {
            let [way, by_speed] = [self.way, self.by_speed].map(|way| (way * 10.0) as u32);
            return Err(Fault::Way { way, by_speed });
        }
        let direction = libm::atan2(moved.y, moved.x);
        let beside = headings.map(|heading| wrap_angle(direction - heading).abs());
        self.beside += (beside[0].min(beside[1]) - self.beside) * (way / MEMORY).min(1.0);
        if self.beside > BESIDE {
            return Err(Fault::Beside { degrees: self.beside.to_degrees() as u32 });
        }
        Ok(())
    }
}
