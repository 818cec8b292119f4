//! The start of an episode: a logical scene (distributions and constraints) becomes a concrete one.
//!
//! The ego's pose, the sector around it and the headings are sampled directly. Some [`Constraint`]s cannot be turned into sampling; they
//! reject the draws that violate them. The compiler has narrowed the distributions by all constraints that allow it.
//!
//! | what | measure |
//! |---|---|
//! | ego anywhere, or on stretches of lanes | uniform in length of lane |
//! | ego on listed poses | equal probability |
//! | pedestrian, [`Measure::Range`] | bearing and distance from their distributions, independent |
//! | pedestrian, [`Measure::Area`] | uniform over the ground of the sector |
//!
//! A pose of the ego is kept until a pedestrian can be placed around it. So crowded places are as likely as open ones.

mod ego_start;
mod constraint;
mod rule;
mod target_walk;
mod given_path;
mod survey;
mod reach;
mod parameter;
mod placement;
mod error;

pub use constraint::{Constraint, Ground};
pub use ego_start::{EgoSpeed, EgoStart, LanePiece, RoadShape, Spawn};
pub use error::{Rarity, SpawnError};
pub(crate) use given_path::Pacing;
pub use given_path::{GivenPath, PathPoint};
pub use parameter::{DrawnParameter, StartParameter};
pub use placement::{CastSurvey, Placement, Unplaced};
pub(crate) use placement::{Placing, behind};
pub use rule::{Measure, SpawnRule};
pub use survey::Survey;
pub(crate) use target_walk::Release;
pub use target_walk::{TargetBox, TargetSide, TargetWalk, TestCase, TestCriterion, euro_ncap_bands};
