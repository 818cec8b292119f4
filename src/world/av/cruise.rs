use super::{DrivingMode, DrivingPolicy, Path, Perception, lane_keeping};
use crate::sim::Control;
use base::seed::Stream;
use base::signature::{Arguments, Param, Signature, Type};
use base::units::Dimension;

/// Keeps its lane and its speed and ignores all road users. It is a lower bound, since every pedestrian can hit it.
#[derive(Debug, Clone)]
pub struct Cruise {
    /// Share of the speed limit that it drives.
    limit_share: f64,
    /// Its greatest lateral acceleration in bends (m/s²).
    lateral: f64,
    path: Path,
    mode: DrivingMode,
}

/// Comfortable braking before bends (m/s²).
const COMFORTABLE: f64 = 2.0;

impl Cruise {
    pub const KIND: &'static str = "cruise";

    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        Signature::new(
            Self::KIND,
            "Keeps its lane and its speed. It sees neither pedestrians nor lights.",
            vec![
                Param::with_default("limit_share", Type::share(), "0.9", "Share of the speed limit that it drives."),
                Param::with_default(
                    "lateral_acceleration",
                    Type::positive(Dimension::ACCELERATION),
                    "2 m/s^2",
                    "Lateral acceleration that it takes in bends.",
                ),
            ],
        )
    }

    /// Makes one from checked arguments.
    pub fn new(arguments: &Arguments) -> Self {
        Self {
            limit_share: arguments.number("limit_share"),
            lateral: arguments.number("lateral_acceleration"),
            path: Path::default(),
            mode: DrivingMode::Cruise,
        }
    }
}

impl DrivingPolicy for Cruise {
    fn speed_limit_for(&self, speed: f64) -> f64 {
        speed / self.limit_share
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.path.reset(perception, stream);
        self.mode = DrivingMode::Cruise;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        self.path.advance(perception);
        let speed = perception.ego.speed();
        let wanted = self.limit_share * perception.speed_limit;
        let allowed = lane_keeping::speed_for_bends(&self.path, wanted, self.lateral, COMFORTABLE);
        self.mode = if allowed < 0.1 {
            DrivingMode::Arrived
        } else if allowed < wanted - 0.1 {
            DrivingMode::Turn
        } else {
            DrivingMode::Cruise
        };
        let acceleration = ((allowed - speed) / 0.5).clamp(-2.0 * COMFORTABLE, 2.0);
        let pedals = perception.blueprint.pedals_for(acceleration, speed);
        Control { steer: lane_keeping::steer(&self.path, perception), ..pedals }
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }
}
