//! Messages to a user about a file: sources, spans, diagnostics, and how they are drawn.
//!
//! A [`Diagnostic`] is plain data. Only [`render()`] draws source lines and carets; other forms (JSON,
//! an editor) are made from the same data.

mod source;
mod lines;
mod report;
mod render;
mod record;

pub use lines::Lines;
pub use record::{Place, PlacedText, Record, records};
pub use render::{Colour, render};
pub use report::{Diagnostic, Fix, Label, Severity};
pub use source::{Source, SourceId, Sources, Span};
