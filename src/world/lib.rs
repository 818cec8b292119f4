//! The simulated world: roads, cars and pedestrians that move on them, driving policies, episodes, verdicts and searches.

pub mod geometry;
pub mod road;
pub mod sim;
pub mod av;
pub mod requirement;
pub mod env;
pub mod judge;
pub mod falsifier;
pub mod driving;
pub mod likelihood;
pub mod hardening;
pub mod cause;
pub mod classification_tree;
