//! Pictures and words on failure modes.

mod words;
mod mode_panels;
mod rule_bars;
mod curves;

pub use curves::accumulation_figure;
pub use mode_panels::mode_panels;
pub use rule_bars::rule_bars;
pub use words::{file_names, modes_summary};
