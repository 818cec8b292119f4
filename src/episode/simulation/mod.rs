//! Running an episode: the interface of a simulation and ours, what watches it, and what is recorded of it.

mod signal_meter;
mod lane_watch;
mod motion;
mod failure_cell;
pub(crate) mod pursuit;
mod scene;
mod actions;
mod own_walkers;
#[expect(clippy::module_inception, reason = "a simulation is the noun of its file")]
mod simulation;
mod drivers;
mod script;
mod run_up;
mod tally;
mod road_watch;
mod requirement_watch;
mod observers;
mod external_world;
mod local_simulation;
mod trace;
mod pair;
mod other_actor;
mod other_drive;

pub use actions::Actions;
pub use external_world::{
    Abilities, BridgeKeys, ExternalWorld, HERE, LaneMatch, MapWriter, PROTOCOL as WORLD_PROTOCOL,
};
pub use failure_cell::{Course, FailureCell, Zone};
pub use lane_watch::{LanePlace, LaneWatch};
pub use local_simulation::LocalSimulation;
pub use other_actor::RecordedActor;
pub use other_drive::OtherDrive;
pub use pair::{Frame, Pair};
pub use scene::Scene;
pub(crate) use simulation::tick;
pub use simulation::{Draw, Observer, Phase, Simulation, WrapDriver, carry_out};
pub use trace::{Driven, Trace, VehicleFrame};
