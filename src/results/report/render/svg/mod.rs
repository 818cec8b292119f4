//! Drawing: numbers, lines, charts, figures, colours. Every picture of a report is made of these.
//!
//! Pictures are written with maud, which escapes names. A [`Figure`] is made once. The page colours it by the reader's system setting; its
//! file has fixed colours.

mod number;
mod line;
mod palette;
mod document;
mod figure;
mod chart;

pub use chart::{Chart, Curve, short, thousands};
pub use document::Document;
pub use figure::{Figure, Panel};
pub use line::{line, outline};
pub use number::{Digits, fine, px};
pub use palette::{FIGURE_CSS, properties};
