use super::{DrivingMode, DrivingPolicy, Path, Perception, lane_keeping};
use crate::sim::Control;
use base::keys;
use base::seed::Stream;

keys! {
    /// Keeps its lane and its speed. It sees neither pedestrians nor lights.
    pub struct CruiseKeys = "cruise" {
        /// Share of the speed limit that it drives.
        limit_share: f64 as share() = "0.9",
        /// Lateral acceleration that it takes in bends.
        lateral_acceleration: f64 as positive(ACCELERATION) = "2 m/s^2",
    }
}

/// The defaults of the keys.
impl Default for CruiseKeys {
    fn default() -> Self {
        Self { limit_share: 0.9, lateral_acceleration: 2.0 }
    }
}

/// Keeps its lane and its speed and ignores all road users. It is a lower bound, since every pedestrian can hit it.
#[derive(Debug, Clone)]
pub struct Cruise {
    keys: CruiseKeys,
    path: Path,
    mode: DrivingMode,
}

/// Comfortable braking before bends (m/s²).
const COMFORTABLE: f64 = 2.0;

impl Cruise {
    pub fn new(keys: CruiseKeys) -> Self {
        Self { keys, path: Path::default(), mode: DrivingMode::Cruise }
    }
}

impl DrivingPolicy for Cruise {
    fn speed_limit_for(&self, speed: f64) -> f64 {
        speed / self.keys.limit_share
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.path.reset(perception, stream);
        self.mode = DrivingMode::Cruise;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        self.path.advance(perception);
        let speed = perception.ego.speed();
        let wanted = lane_keeping::speed_for_limits(&self.path, perception, self.keys.limit_share, COMFORTABLE);
        let allowed = lane_keeping::speed_for_bends(&self.path, wanted, self.keys.lateral_acceleration, COMFORTABLE);
        self.mode = if allowed < 0.1 {
            DrivingMode::Arrived
        } else if allowed < wanted - 0.1 {
            DrivingMode::Turn
        } else {
            DrivingMode::Cruise
        };
        let lower = lane_keeping::lower_limit(&self.path, perception, self.keys.limit_share, COMFORTABLE);
        let before = lower.map_or(f64::INFINITY, |lower| lower.acceleration(speed, COMFORTABLE));
        let acceleration = ((allowed - speed) / 0.5).min(before).clamp(-2.0 * COMFORTABLE, 2.0);
        let pedals = perception.blueprint.pedals_for(acceleration, speed);
        Control { steer: lane_keeping::steer(&self.path, perception), ..pedals }
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn reseed(&mut self, stream: Stream) {
        self.path.reseed(stream);
    }
}
