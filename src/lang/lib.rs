//! The scenario language: text → AST → HIR.
//!
//! | phase | function | from → to |
//! |---|---|---|
//! | load | [`load`] | paths → [`ast::File`]s, imports followed, every file read once |
//! | parse | [`parse`] | text → [`ast::File`] |
//! | lay out | [`format()`] | text → the same text in its canonical layout |
//! | check | [`check`] | files, [`Form`](base::signature::Form)s, vocabulary → [`hir::Program`] |
//!
//! Every phase returns what it could build **and** all its diagnostics; no phase stops at the first mistake. The language
//! itself contains no form, kind or key: they are passed in as signatures.

// The code that pest generates for the grammar names this crate.
extern crate alloc;

mod load;
pub mod library;
pub mod tokens;
mod parse;
pub mod ast;
mod brackets;
mod names;
mod params;
mod settings;
mod defaults;
mod check;
mod formula;
mod requirement;
mod value;
pub mod diagnostics;
pub mod hir;

pub mod error_index;
pub mod keywords;
mod format;
mod inline;

pub use check::{Checked, check, once};
pub use format::format;
pub use formula::functions;
pub use inline::{declare_inline, declare_inline_axes};
pub use load::{Loaded, Reader, Unreadable, load, normal, reason};
pub use params::{DIMENSIONS, OTHER_TYPES};
pub use parse::parse;
pub use requirement::temporal_operators;
pub use settings::{Matrix, Setting, apply, matrices, settings};
pub use value::distributions;
