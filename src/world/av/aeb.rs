use super::crosswalks::CrosswalkKeys;
use super::emergency_brake::{BrakeKeys, EmergencyBrake};
use super::guarded::{Guarded, LaneGuard};
use super::lane_follower::{Intent, LaneKeys};
use super::route_trace::RouteTrace;
use super::{DrivingMode, Perception};
use crate::sim::Control;
use base::keys;

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
}

impl Aeb {
    pub fn new(keys: AebKeys) -> Guarded<Self> {
        Guarded::new(Self { brake: EmergencyBrake::new(keys.brake) }, keys.lane, keys.at_crosswalks)
    }
}

impl LaneGuard for Aeb {
    fn reset(&mut self) {
        self.brake.release();
    }

    fn drive(&mut self, intent: &Intent, trace: &RouteTrace, perception: &Perception<'_>) -> (Control, DrivingMode) {
        let demand = self.brake.watch(trace, perception);
        let mode = demand.map_or(intent.mode, |demand| demand.mode);
        let allowed = demand.map_or(f64::INFINITY, |demand| demand.allowed);
        (intent.control(intent.acceleration.min(allowed), perception), mode)
    }
}
