//! LAV (*Learning from All Vehicles*) as a car under test, faithful to its planner's rules and without its networks.
//!
//! The parts of LAV that are ordinary code are repeated number for number: the valid peaks of its detection map (`detection`), the
//! transformation of a vehicle's forecast into the ego's frame (`forecast`), the collision check of plan and forecasts
//! (`collision`), and the controller with its rules in their order ([`Controller`]). Its networks are replaced by surrogates made
//! from the simulator's perception: the plan (`plan`), the forecasts, and the brake classifier. The surrogate classifier is the rule
//! that labelled the training data ([`BrakeRules`]), followed by a filter (`classifier`). [`Lav`] combines them.
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
