//! LAV (*Learning from All Vehicles*) as a car under test, true to its planner's rules and without its networks.
//!
//! What LAV computes by hand is repeated number for number: which peaks of its detection map count (`detection`), how a
//! forecast of a vehicle comes into the ego's frame (`forecast`), when plan and forecasts collide (`collision`), and the
//! controller with its rules in their order ([`Controller`]). What its networks compute is a surrogate made of what the
//! simulator perceives: the plan (`plan`), the forecasts, and the classifier that says *brake*, which here is the rule that
//! labelled its training data ([`BrakeRules`]) behind a filter (`classifier`). [`Lav`] puts them together.
//!
//! Inside this folder a place is an [`EgoPoint`], to the right and **back**, and steer is positive to the right.
//!
//! # Source
//! Chen and Krähenbühl, *Learning from All Vehicles*, CVPR 2022; `dotchen/LAV`, `team_code/lav_agent.py` and
//! `team_code_v2/{lav_agent,lav_agent_fast}.py`, and the labels of its branch `data-collect`.

mod frame;
mod version;
mod command;
mod detection;
mod forecast;
mod collision;
mod pid;
mod controller;
mod brake_rules;
mod hazards;
mod classifier;
mod plan;
mod agent;

pub use agent::Lav;
pub use brake_rules::{BrakeRules, WalkerView};
pub use command::Command;
pub use controller::{Controller, Overruled, Pedals, Situation, Verdict};
pub use detection::{Blob, BlobKind, Detection, Detector};
pub use forecast::Forecast;
pub use frame::EgoPoint;
pub use version::Version;
