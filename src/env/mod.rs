//! The Markov decision process: what an episode is, how it begins, what the pedestrian sees, does and earns.
//!
//! | paper | here |
//! |---|---|
//! | state s = \[α, d, β, v\] | [`Observation`]: `bearing`, `distance`, `relative_heading`, `speed` |
//! | action (heading, speed), held for 20 ticks | [`Adversary::command`] → [`WalkCommand`](crate::sim::WalkCommand) |
//! | spawn sector −60°..60°, 7..30 m | [`SpawnRule`] |
//! | R1, R2 | [`RewardRule`], written as formulas in the scenario |
//! | 600 ticks, ends at a collision | [`EpisodeRule`] |
//!
//! # Source
//! Yang et al., *Suicidal Pedestrian*, ITSC 2023, section III.

mod scenario;
mod spawn;
mod observation;
mod action;
mod reward;
mod trail;
mod outcome;
mod recording;
mod running;
mod pedestrian_env;

pub use action::{Adversary, FirstHeading, Frame, Scaling};
pub use observation::{Observation, ObservedSpeed};
pub use outcome::{Ending, Outcome};
pub use pedestrian_env::PedestrianEnv;
pub use recording::{Moment, Recording};
pub use reward::{RewardRule, Situation, vocabulary};
pub use scenario::{EpisodeRule, PolicyMaker, Scenario};
pub use spawn::{Constraint, EgoStart, Ground, LanePiece, Measure, RoadShape, Spawn, SpawnError, SpawnRule, Survey};
pub use trail::Trail;
