use super::{AgentConfig, AtDestination, BehaviorAgent, Profile, Release, WayFinding};
use base::{choice, keys};
use road::ForkRule;

choice! {
    /// Which way the agent takes.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Route {
        AnyBranch = "any_branch",
        CarlaWander = "carla_wander",
        Destination = "destination",
    }
}

keys! {
    /// CARLA's BehaviorAgent, with its accidents.
    pub struct BehaviorAgentKeys = "behavior_agent" {
        /// The release of CARLA; 0.9.10.1 drives as 0.9.11, 0.9.14 as 0.9.15.
        release: Release = "\"0.9.15\"",
        /// How boldly it drives.
        profile: Profile = "normal",
        /// Which way it takes: any at each fork; at each fork as CARLA's planner without a destination does, which in
        /// Town01 and Town02 is always the first; or to a destination drawn anywhere in the town, by the route that
        /// CARLA's planner finds.
        route: Route = "any_branch",
        /// With `route: destination`, whether it drives on to a next destination, as in CARLA's example scripts, or
        /// brakes and stays.
        at_destination: AtDestination = "next",
    }
    .made_for(0.05)
}

impl BehaviorAgent {
    pub fn from_keys(keys: BehaviorAgentKeys) -> Self {
        let BehaviorAgentKeys { release, profile, route, at_destination } = keys;
        let way = match route {
            Route::AnyBranch => WayFinding::Wander(ForkRule::AnyBranch),
            Route::CarlaWander => WayFinding::Wander(ForkRule::NamedTurn),
            Route::Destination => WayFinding::Destination(at_destination),
        };
        Self::new(AgentConfig { release, profile, way })
    }
}
