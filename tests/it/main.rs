//! The integration tests, in one binary: one module for each boundary.

mod behavior_agent_reference;
mod command_line;
mod determinism;
mod layers;
mod learning;
mod road_reference;
mod routes_reference;
mod scenarios;
mod suite;
mod tidy;
