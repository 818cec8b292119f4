//! What is said to a user about a file: sources, spans, diagnostics, and how they are drawn.
//!
//! A [`Diagnostic`] is plain data. [`render`] is the only code that draws source lines and carets; other forms (JSON,
//! SARIF, an editor) can be made from the same data.

mod source;
mod report;
mod render;

pub use render::{Colour, render};
pub use report::{Diagnostic, Label, Severity};
pub use source::{Source, SourceId, Sources, Span};
