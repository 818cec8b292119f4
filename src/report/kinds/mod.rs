//! Kinds of failure: samples of a campaign's episodes go to [`analysis`](crate::analysis), and tables, pictures and words come back.
//!
//! Episodes arrive one run at a time. A cell is analysed when the last of its runs is there, and then forgotten but for the results,
//! so memory does not grow with the episodes. How the pedestrian came to the car is not in the tables: a bounded number of collisions
//! of each kind is repeated to see it.

mod sample;
mod beginning;
mod repeat;
mod cell;
mod tables;
mod mode_panels;
mod curves;
mod rule_bars;
mod words;
mod campaign_kinds;

pub use campaign_kinds::Kinds;
