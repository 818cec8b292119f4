//! Roads and routes, compared with recordings of independent programs.
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

mod road_reference;
mod routes_reference;

use repository::repository;
