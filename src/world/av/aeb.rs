use super::crosswalks::CrosswalkKeys;
use super::emergency_brake::{BrakeKeys, EmergencyBrake};
use super::lane_follower::{LaneFollower, LaneKeys};
use super::{DrivingMode, DrivingPolicy, Perception};
use crate::sim::Control;
use base::keys;
use base::seed::Stream;

keys! {
    /// A driver that sees no actors, with automatic emergency braking by time to collision. It trusts the positions that it is
    /// given: add sensors.
    pub struct AebKeys = "aeb" {
        ..lane: LaneKeys,
        ..brake: BrakeKeys,
        ..at_crosswalks: CrosswalkKeys,
    }
    .rising(&["full", "partial", "warning"])
}

/// A driver that ignores all road users, with an emergency brake for road users that will be in its way.
#[derive(Debug, Clone)]
pub struct Aeb {
    brake: EmergencyBrake,
    driver: LaneFollower,
    mode: DrivingMode,
}

impl Aeb {
    pub fn new(keys: AebKeys) -> Self {
        let driver = LaneFollower::new(keys.lane, keys.at_crosswalks);
        Self { brake: EmergencyBrake::new(keys.brake), driver, mode: DrivingMode::Cruise }
    }
}

impl DrivingPolicy for Aeb {
    fn speed_limit_for(&self, speed: f64) -> f64 {
        self.driver.speed_limit_for(speed)
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.driver.reset(perception, stream);
        self.brake.release();
        self.mode = DrivingMode::Cruise;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let intent = self.driver.intend(perception);
        let demand = self.brake.watch(&self.driver.trace, perception);
        self.mode = demand.map_or(intent.mode, |demand| demand.mode);
        let allowed = demand.map_or(f64::INFINITY, |demand| demand.allowed);
        intent.control(intent.acceleration.min(allowed), perception)
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn reseed(&mut self, stream: Stream) {
        self.driver.reseed(stream);
    }
}
