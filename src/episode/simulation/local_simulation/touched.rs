use crate::Actions;
use crate::simulation::observers::Observers;
use world::sim::World;

/// The touches of an episode with several pedestrians.
#[derive(Debug, Clone)]
pub(super) struct Touches {
    /// The last tick in which somebody else can be touched.
    pub until: u32,
    pub worst: Touched,
}

/// A touch of the car and a pedestrian, and the simulation in the tick in which it happened.
#[derive(Debug, Clone)]
pub(super) struct Touched {
    pub severity: Severity,
    pub world: World,
    pub actions: Actions,
    pub observers: Observers,
}

/// How much a touch counts against the driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Severity {
    Bump,
    Collision,
    Preventable,
    Fault,
}
