//! The Markov decision process: what an episode is, how it starts, what a pedestrian observes and does, and its reward.
//!
//! A [`Scenario`] has a [`Cast`]: the ego and other vehicles with their drivers, and pedestrians. A pedestrian has four parts: a body, an
//! [`ObservationSpec`], an [`ActionSpec`] and a [`Controller`]. A [`Simulation`] runs episodes of it; ours is [`LocalSimulation`], whose car may drive in an [`ExternalWorld`]. A [`Trace`] records an episode,
//! and a [`Pair`] is its view for one car and one pedestrian.
//!
//! | paper | here |
//! |---|---|
//! | state s = \[α, d, β, v\] | [`Observation`]: `bearing`, `distance`, `relative_heading`, `speed` |
//! | action (heading, speed), kept for 20 ticks | [`ActionSpec::command`] → [`WalkCommand`](world::sim::WalkCommand) |
//! | spawn sector −60°..60°, 7..30 m | [`SpawnRule`] |
//! | R1, R2 | [`RewardRule`], written as formulas in the scenario |
//! | 600 ticks, ends at a collision | [`EpisodeRule`] |
//!
//! # Source
//! Yang et al., *Suicidal Pedestrian*, ITSC 2023, section III.

pub mod requirement;
mod scenario;
mod simulation;
pub mod walker;
mod play;
mod evaluate;
mod unbraked;
mod recorded;

pub use evaluate::{Policies, evaluate, evaluate_in_batch, evaluate_observed};
pub use play::{advance, place, play};
pub use recorded::{Recorded, follow, recorded_commands, walk_again};
pub use scenario::{
    ActionSpec, Cast, CastSurvey, Component, Constraint, Controller, Criterion, Destination, DrawnParameter,
    DriverParts, EgoSpeed, EgoStart, Ending, EpisodeRule, FirstHeading, GivenPath, Ground, HitClass, Impact, Judgement,
    LanePiece, LeftOut, MOVING_ABOVE, MapPart, Measure, Observation, ObservationSpec, ObservedSpeed, Outcome,
    PathPoint, PedestrianRole, Placement, PolicyMaker, ReferenceFrame, RewardRule, RoadShape, Scaling, Scenario,
    SeenActor, Setting, Situation, Spawn, SpawnError, SpawnRule, StartParameter, StateHashes, Survey, TargetBox,
    TargetSide, TargetWalk, TestCase, TestCriterion, TestOracle, Unplaced, VehicleRole, euro_ncap_bands,
    is_about_braking, is_about_map, is_about_pedestrian, robustness, robustness_of, vocabulary,
};
pub(crate) use simulation::tick;
pub use simulation::{
    Abilities, Actions, BridgeKeys, Course, Draw, Driven, ExternalWorld, FailureCell, Frame, HERE, LaneMatch,
    LanePlace, LaneWatch, LocalSimulation, MapWriter, Observer, OtherDrive, Pair, Phase, RecordedActor, Scene,
    Simulation, Trace, VehicleFrame, WORLD_PROTOCOL, WrapDriver, Zone, carry_out,
};
