//! The page of a report: one self-contained HTML file, without network or server.
//!
//! [`page`] is a function of [`Contents`]: small tables, a [`Tally`] that is gathered run by run, and the failures that can be played as
//! [`Replay`]s. Every figure is made once. The page colours it by the reader's system setting; its file has fixed colours. Names of a
//! scenario may contain any character; maud escapes them in HTML and SVG, [`json`](markup::json) in JSON.

mod markup;
mod head;
mod identity;
mod tally;
mod results;
mod verdicts;
mod severity;
mod spawns;
mod covers;
mod learning;
mod likelihood;
mod replay;
mod frames;
mod modes;
mod players;
mod worst;
mod first;
mod player_card;
mod closing;
mod contents;
mod make;
mod write;

pub use contents::Contents;
pub use head::{OWN_SCRIPTS, head};
pub use make::{document, page};
pub use markup::{count, json, paragraph, percent};
pub use modes::ModeCard;
pub use player_card::badge;
pub use players::Players;
pub use replay::Replay;
pub use tally::Tally;
pub use write::{page_examples, write_page};
