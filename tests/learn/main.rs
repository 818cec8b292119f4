//! The tests of the learner.
#![expect(clippy::print_stderr, reason = "a comparison prints how close it came")]

#[path = "../common/reference.rs"]
mod reference;
#[path = "../common/repository.rs"]
mod repository;
#[path = "../common/samples.rs"]
mod samples;

mod checkpoints;
mod imitation;
mod observations;
mod ppo;
mod trainer;
mod ped_world;
mod ped_world_reference;
mod policies_elsewhere;
mod recorded_update;
mod sb3_curves;

use repository::repository;
