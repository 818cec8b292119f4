//! Finds the ways a self-driving car hits a pedestrian.
//!
//! A scenario file says which towns, driving policies, spawn places and rewards there are, and which campaigns are to be
//! run with them; see `grammar/README.md` for the language.
#![doc = include_str!("ARCHITECTURE.md")]

// What pest writes for the grammar names it.
extern crate alloc;

pub mod diagnostic;
pub mod units;
pub mod signature;
pub mod seed;
pub mod statistics;
pub mod geometry;
pub mod lang;
pub mod road;
pub mod sim;
pub mod av;
pub mod rl;
pub mod env;
pub mod compile;
pub mod judge;
pub mod record;
pub mod falsifier;
pub mod campaign;
pub mod analysis;
pub mod report;
pub mod store;
pub mod process;
pub mod session;
pub mod lsp;
pub mod cli;
#[cfg(any(fuzzing, test))]
pub mod fuzzing;
