//! The tests that start the program or use all packages. The tests of a package are in a folder of its name beside this one.
//!
//! Tests whose names contain `reference` compare with recordings of independent programs. The environment variable
//! `FALSIFY_REFERENCE_DIR` names their folder (default `../shared`). Without recordings a test is ignored, as `needs::needs` says.

#[macro_use]
#[path = "../common/loud.rs"]
mod loud;
#[path = "../common/reference.rs"]
mod reference;
#[path = "../common/repository.rs"]
mod repository;
#[path = "../common/samples.rs"]
mod samples;
#[path = "../common/shipped.rs"]
mod shipped;
#[path = "../common/straight_road.rs"]
mod straight_road;

mod beside_files;
mod book;
mod caches;
mod casts;
mod causes;
mod command_line;
mod comparing;
mod controllers;
mod determinism;
mod dossier;
mod doubts;
mod driving;
mod editor_folders;
mod every_key;
mod exports;
mod external;
mod first_steps;
mod house;
mod initial_networks;
mod interfaces;
mod interruptions;
mod kills;
mod language_server;
mod losses;
mod lost_drivers;
mod maps;
mod memory;
mod onnx;
mod onnx_file;
mod outputs;
mod own_kinds;
mod page;
mod prices;
mod program;
mod recheck;
mod recordings;
mod release;
mod replaying;
mod requirements;
mod scenarios;
mod sessions;
mod settings;
mod shards;
mod smoke;
mod stale;
mod structure;
mod tables_elsewhere;
mod together;
mod tools;
#[path = "../fuzz/targets.rs"]
mod targets;
mod unbreakable;
mod watching;
mod worlds;

use repository::repository;
