//! Roads and geometry: closed forms, properties, and recordings of independent programs.
#![expect(clippy::print_stderr, reason = "a comparison prints how close it came")]

#[macro_use]
#[path = "../common/loud.rs"]
mod loud;
#[path = "../common/gzip.rs"]
mod gzip;
#[path = "../common/reference.rs"]
mod reference;
#[path = "../common/repository.rs"]
mod repository;
#[path = "../common/streets.rs"]
mod streets;

mod geometry;
mod reference_lines;
mod lanes_around;
mod frenet;
mod levels;
mod random_walks;
mod route_planner;
mod opendrive;
mod town_design;
mod road_reference;
mod routes_reference;

use repository::repository;
