//! Pictures and tables of failure modes.

mod names;
mod section;
mod mode_panels;
mod rule_bars;

pub use mode_panels::mode_panels;
pub use names::file_names;
pub use rule_bars::rule_bars;
pub use section::modes_section;
