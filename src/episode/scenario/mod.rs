//! What an episode is: its cast, what a pedestrian observes and does, how an episode starts, its signals, its reward, its outcome.

#[expect(clippy::module_inception, reason = "a scenario is the noun of its file")]
mod scenario;
mod cast;
mod driver_parts;
mod reference_frame;
mod observation;
mod action;
mod destination;
mod component;
pub(crate) mod spawn;
mod test_oracle;
pub(crate) mod signal;
pub(crate) mod actor_signal;
pub(crate) mod reward;
mod state_hashes;
mod outcome;
mod criterion;

pub use action::ActionSpec;
pub use cast::{Cast, Controller, FirstHeading, PedestrianRole, VehicleRole};
pub use component::Component;
pub use criterion::Criterion;
pub use destination::Destination;
pub use driver_parts::{DriverParts, PolicyMaker, Setting};
pub use observation::{Observation, ObservationSpec, ObservedSpeed, SeenActor};
pub use outcome::{Ending, Impact, LeftOut, Outcome};
pub use reference_frame::{ReferenceFrame, Scaling};
pub use reward::{HitClass, RewardRule};
pub use scenario::{EpisodeRule, MOVING_ABOVE, Scenario};
pub use signal::{
    MapPart, Situation, is_about_braking, is_about_map, is_about_pedestrian, robustness, robustness_of, vocabulary,
};
pub use spawn::{
    CastSurvey, Constraint, DrawnParameter, EgoSpeed, EgoStart, GivenPath, Ground, LanePiece, Measure, PathPoint,
    Placement, RoadShape, Spawn, SpawnError, SpawnRule, StartParameter, Survey, TargetBox, TargetSide, TargetWalk,
    TestCase, TestCriterion, Unplaced, euro_ncap_bands,
};
pub use state_hashes::StateHashes;
pub use test_oracle::{Judgement, TestOracle};
