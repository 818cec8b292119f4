//! Verdicts: closed forms and properties.

mod driven_path;
mod recording_units;
mod verdicts;
