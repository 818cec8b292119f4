//! The page of a report: one self-contained HTML file, without network or server.
//!
//! It is made of what was found, the sections, and the failures that can be played as [`Replay`]s. Every figure is made once. The page colours it by the
//! reader's system setting; its file has fixed colours. Names of a scenario may contain any character; maud escapes them in HTML and SVG,
//! [`json`](markup::json) in JSON.

mod markup;
mod head;
mod identity;
mod tally;
mod results;
mod verdicts;
mod spawns;
mod replay;
mod frames;
mod players;
mod worst;
mod first;
mod player_card;
mod closing;
mod make;
mod write;

pub use head::{OWN_SCRIPTS, head};
pub use identity::named;
pub use make::{author_and_date, document};
pub use markup::{count, json, paragraph, percent};
pub use player_card::{PlayerCard, badge};
pub use players::Players;
pub use replay::{OtherTrack, Replay};
pub use results::results as results_picture;
pub use spawns::spawns;
pub use tally::Tally;
pub use verdicts::verdicts;
pub use worst::listed;
pub use write::{page_examples, write_page};
