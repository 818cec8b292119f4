//! Verdicts: closed forms and properties.

mod driven_path;
mod verdicts;
