use super::{PedestrianState, VehicleState};
use road::geometry::Pose;

/// The start of an actor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ActorStart {
    pub pose: Pose,
    /// Its speed along the heading of the pose (m/s).
    pub speed: f64,
}

impl ActorStart {
    /// At rest at a pose.
    pub fn standing(pose: Pose) -> Self {
        Self { pose, speed: 0.0 }
    }

    /// A vehicle that starts here.
    pub(super) fn vehicle(&self) -> VehicleState {
        VehicleState { pose: self.pose, speed: self.speed, ..VehicleState::default() }
    }

    /// A pedestrian that starts here.
    pub(super) fn pedestrian(&self) -> PedestrianState {
        let standing = PedestrianState::standing(self.pose);
        if self.speed == 0.0 {
            return standing;
        }
        PedestrianState { velocity: self.pose.forward() * self.speed, ..standing }
    }
}

/// The initial state of a world: one start for each of its actors, in the order of their numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<'a> {
    /// The vehicles, the ego first.
    pub vehicles: &'a [ActorStart],
    pub pedestrians: &'a [ActorStart],
    /// Time within the cycles of the traffic lights (s).
    pub light_phase: f64,
}
