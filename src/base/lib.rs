//! What every package needs and no package owns: named random streams, units, signatures of kinds, diagnostics with their source line, statistics, files that appear whole.

pub mod diagnostic;
pub mod contained;
pub mod files;
pub mod printable;
pub mod units;
pub mod seed;
pub mod statistics;
pub mod signature;
pub mod suggest;
mod messages;
