//! The Markov decision process: what an episode is, how it starts, what a pedestrian observes and does, and its reward.
//!
//! A [`Scenario`] has a [`Cast`]: the ego and other vehicles with their drivers, and pedestrians. A pedestrian has four parts: a body, an
//! [`ObservationSpec`], an [`ActionSpec`] and a [`Controller`]. A [`Simulation`] runs episodes of it; ours is [`LocalSimulation`], whose car may drive in an [`ExternalWorld`]. A [`Trace`] records an episode,
//! and a [`Pair`] is its view for one car and one pedestrian.
//!
//! | paper | here |
//! |---|---|
//! | state s = \[α, d, β, v\] | [`Observation`]: `bearing`, `distance`, `relative_heading`, `speed` |
//! | action (heading, speed), kept for 20 ticks | [`ActionSpec::command`] → [`WalkCommand`](crate::sim::WalkCommand) |
//! | spawn sector −60°..60°, 7..30 m | [`SpawnRule`] |
//! | R1, R2 | [`RewardRule`], written as formulas in the scenario |
//! | 600 ticks, ends at a collision | [`EpisodeRule`] |
//!
//! # Source
//! Yang et al., *Suicidal Pedestrian*, ITSC 2023, section III.

mod scenario;
mod cast;
mod driver_parts;
mod reference_frame;
mod observation;
mod action;
mod destination;
mod component;
mod spawn;
mod test_oracle;
mod signal;
mod actor_signal;
mod signal_meter;
mod lane_watch;
mod reward;
mod motion;
mod state_hashes;
mod outcome;
mod criterion;
mod failure_cell;
mod run_up;
pub(crate) mod pursuit;
mod scene;
mod actions;
mod own_walkers;
mod simulation;
mod drivers;
mod script;
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

pub use action::ActionSpec;
pub use actions::Actions;
pub use cast::{Cast, Controller, FirstHeading, PedestrianRole, PolicyMaker, VehicleRole};
pub use component::Component;
pub use criterion::Criterion;
pub use destination::Destination;
pub use driver_parts::{DriverParts, Setting};
pub use external_world::{
    Abilities, BridgeKeys, ExternalWorld, HERE, LaneMatch, MapWriter, PROTOCOL as WORLD_PROTOCOL,
};
pub use failure_cell::{Course, FailureCell, Zone};
pub(crate) use lane_watch::{LanePlace, LaneWatch};
pub use local_simulation::LocalSimulation;
pub use observation::{Observation, ObservationSpec, ObservedSpeed, SeenActor};
pub use other_actor::RecordedActor;
pub use other_drive::OtherDrive;
pub use outcome::{Ending, Impact, LeftOut, Outcome};
pub use pair::{Frame, Pair};
pub use reference_frame::{ReferenceFrame, Scaling};
pub use reward::{HitClass, RewardRule};
pub(crate) use scenario::MOVING_ABOVE;
pub use scenario::{EpisodeRule, Scenario};
pub use scene::Scene;
pub use signal::{
    MapPart, Situation, is_about_braking, is_about_map, is_about_pedestrian, robustness, robustness_of, vocabulary,
};
pub(crate) use simulation::tick;
pub use simulation::{Draw, Observer, Phase, Simulation, WrapDriver, carry_out};
pub use spawn::{
    CastSurvey, Constraint, DrawnParameter, EgoSpeed, EgoStart, GivenPath, Ground, LanePiece, Measure, PathPoint,
    Placement, RoadShape, Spawn, SpawnError, SpawnRule, StartParameter, Survey, TargetBox, TargetSide, TargetWalk,
    TestCase, TestCriterion, Unplaced, euro_ncap_bands,
};
pub use state_hashes::StateHashes;
pub use test_oracle::{Judgement, TestOracle};
pub use trace::{Driven, Trace, VehicleFrame};
