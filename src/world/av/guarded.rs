use super::crosswalks::CrosswalkKeys;
use super::lane_follower::{Intent, LaneFollower, LaneKeys};
use super::route_trace::RouteTrace;
use super::{DrivingMode, DrivingPolicy, Perception};
use crate::sim::Control;
use base::seed::Stream;

/// A rule for other road users, in front of a driver that ignores them.
pub trait LaneGuard: Clone + Send + 'static {
    /// Forgets the last episode.
    fn reset(&mut self) {}

    /// Chooses pedals and wheel for a driver with this intention on this way, and names the manoeuvre.
    fn drive(&mut self, intent: &Intent, trace: &RouteTrace, perception: &Perception<'_>) -> (Control, DrivingMode);
}

/// A driver that keeps its lane, with a rule for other road users.
#[derive(Debug, Clone)]
pub struct Guarded<G> {
    guard: G,
    driver: LaneFollower,
    mode: DrivingMode,
}

impl<G: LaneGuard> Guarded<G> {
    pub fn new(guard: G, lane: LaneKeys, at_crosswalks: CrosswalkKeys) -> Self {
        Self { guard, driver: LaneFollower::new(lane, at_crosswalks), mode: DrivingMode::Cruise }
    }
}

impl<G: LaneGuard> DrivingPolicy for Guarded<G> {
    fn speed_limit_for(&self, speed: f64) -> f64 {
        self.driver.speed_limit_for(speed)
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.driver.reset(perception, stream);
        self.guard.reset();
        self.mode = DrivingMode::Cruise;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let intent = self.driver.intend(perception);
        let (control, mode) = self.guard.drive(&intent, &self.driver.trace, perception);
        self.mode = mode;
        control
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
