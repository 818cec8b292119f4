use base::choice;
use road::ForkRule;

/// How the agent finds its way without a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WayFinding {
    /// Without an end, with a choice at each fork.
    Wander(ForkRule),
    /// To a destination drawn uniformly among the waypoints on driving lanes outside junctions, where CARLA's spawn points
    /// are, too. The route is that of CARLA's planner.
    Destination(AtDestination),
}

impl Default for WayFinding {
    fn default() -> Self {
        Self::Wander(ForkRule::default())
    }
}

choice! {
    /// What the agent does at the end of its route.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum AtDestination {
        /// Draws the next destination after one tick of full brake, as CARLA's example scripts do. The planner of 0.9.11 gets
        /// the next route as soon as the last five points are in its buffer, and does not brake.
        #[default]
        Next = "next",
        /// Brakes and stays, as CARLA's agent does without further commands.
        Stop = "stop",
    }
}
