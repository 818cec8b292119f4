//! The rebuilt drivers, compared with the originals.

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
#[path = "../common/streets.rs"]
mod streets;

mod behavior_agent;
mod behavior_agent_reference;
mod interfuser;
mod interfuser_reference;
mod lav;
mod lav_driving;
mod lav_reference;
mod pufferdrive;
mod pufferdrive_driving;
mod pufferdrive_reference;

use repository::repository;
