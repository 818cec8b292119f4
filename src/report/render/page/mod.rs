//! The page of a report: one file of HTML that needs no other, no network and no server.
//!
//! [`page`] is a function of what [`Contents`] holds: small tables, a [`Tally`] that is gathered run by run, and the examples
//! of failures as [`Replay`]s. Every figure is made once: the page colours it as the reader's system is set, its file in
//! fixed colours. Names of a scenario may hold anything; they pass through [`markup`] on their way into HTML, SVG or JSON.

mod markup;
mod palette;
mod figure;
mod chart;
mod identity;
mod tally;
mod results;
mod published;
mod verdicts;
mod severity;
mod spawns;
mod learning;
mod replay;
mod frames;
mod modes;
mod examples;
mod searches;
mod extras;
mod closing;
mod contents;
mod make;
mod write;

pub use contents::{ComparisonSection, Contents};
pub use figure::Figure;
pub use make::page;
pub use modes::ModeCard;
pub use replay::Replay;
pub use tally::Tally;
pub use write::write_page;
