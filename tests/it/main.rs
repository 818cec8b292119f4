//! The integration tests, in one binary: one module for each boundary.
//!
//! Tests whose names contain `reference` compare with recordings of independent programs. The environment variable
//! `FALSIFY_REFERENCE_DIR` names their folder (default `../shared`). Without recordings a test passes and reports that it was skipped.
#![expect(clippy::print_stderr, reason = "a comparison prints how close it came")]

/// Writes past the capture of test output, so that a skipped test is visible.
macro_rules! loud {
    ($($text:tt)*) => {{
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}

mod allocation;
mod behavior_agent_reference;
mod axioms;
mod beside_files;
mod book;
mod caches;
mod cast;
mod case_book;
mod comparing;
mod controllers;
mod covers;
mod estimates;
mod command_line;
mod determinism;
mod external;
mod interfaces;
mod interfuser_driving;
mod interfuser_reference;
mod interruptions;
mod judge;
mod lav_reference;
mod doubts;
mod drivers;
mod driving;
mod editor_folders;
mod editors;
mod explanations;
mod every_key;
mod exports;
mod first_steps;
mod format;
mod hardening;
mod hostile_input;
mod house;
mod initial_networks;
mod inline_kinds;
mod kills;
mod kinds;
mod language_server;
mod learning;
mod natural_walking;
mod onnx;
mod onnx_file;
mod outputs;
mod own_kinds;
mod losses;
mod map_facts;
mod lost_drivers;
mod maps;
mod memory;
mod messages;
mod page;
mod ped_world;
mod pedestrians;
mod ped_world_reference;
mod policies_elsewhere;
mod program;
mod protocols;
mod recheck;
mod recorded_update;
mod recordings;
mod reference;
mod release;
mod requirements;
mod replaying;
mod resuming;
mod road_reference;
mod routes_reference;
mod sb3_curves;
mod scenarios;
mod sensors;
mod sessions;
mod settings;
mod shaping;
mod searches;
mod shards;
mod shipped;
mod spawns;
mod stale;
mod start_bank;
mod steady_starts;
mod stepping;
mod streets;
mod suite;
mod tables_elsewhere;
mod tidy;
mod sarif;
mod together;
mod tools;
mod unbreakable;
mod watching;
