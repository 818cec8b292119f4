//! The page of a report: one file of HTML that needs no other, no network and no server.
//!
//! [`page`] is a function of what [`Contents`] holds: small tables, a [`Tally`] that is gathered run by run, and the examples
//! of failures as [`Replay`]s. Every figure is made once: the page colours it as the reader's system is set, its file in
//! fixed colours. Names of a scenario may hold anything; maud escapes them in HTML and SVG, [`json`](markup::json) in JSON.

mod markup;
mod identity;
mod tally;
mod results;
mod verdicts;
mod severity;
mod spawns;
mod learning;
mod replay;
mod frames;
mod modes;
mod examples;
mod closing;
mod contents;
mod make;
mod write;

pub use contents::Contents;
pub use make::page;
pub use markup::{count, paragraph, percent};
pub use modes::ModeCard;
pub use replay::Replay;
pub use tally::Tally;
pub use write::write_page;
