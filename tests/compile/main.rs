//! Tests of scenarios that are compiled and simulated. They need no tables and no program.

#[macro_use]
#[path = "../common/loud.rs"]
mod loud;
#[path = "../common/gzip.rs"]
mod gzip;
#[path = "../common/reference.rs"]
mod reference;
#[path = "../common/repository.rs"]
mod repository;
#[path = "../common/samples.rs"]
mod samples;
#[path = "../common/straight_road.rs"]
mod straight_road;

mod allocation;
mod axioms;
mod case_book;
mod cast;
mod causes;
mod drivers;
mod editors;
mod explanations;
mod hostile_input;
mod idm_corridor;
mod inline_kinds;
mod interfuser_driving;
mod judge;
mod language_reference;
mod learning;
mod map_facts;
mod messages;
mod natural_walking;
mod needs;
mod pedestrians;
mod protocols;
mod published;
mod recordings;
mod resuming;
mod sensors;
mod shaping;
mod shrinking;
mod social_forces;
mod spawns;
mod start_bank;
mod steady_starts;
mod stepping;
mod streets;
mod suite;
mod training;
mod worlds;

use repository::repository;
