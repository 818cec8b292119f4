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

pub mod tokens;
pub mod ast;
pub mod library;
pub mod diagnostics;
pub mod hir;
mod names;
mod temporal;
mod formula;
mod value;
mod brackets;
mod parse;
mod load;
mod defaults;
mod settings;
mod params;
mod check;

pub mod error_index;
pub mod keywords;
mod format;
mod inline;

pub use check::{Checked, check, once};
pub use diagnostics::reason;
pub use format::format;
pub use formula::functions;
pub use inline::{declare_inline, declare_inline_axes};
pub use load::{Loaded, Reader, Unreadable, load, normal};
pub use params::{DIMENSIONS, OTHER_TYPES};
pub use parse::parse;
pub use settings::{Matrix, Setting, apply, matrices, settings};
pub use temporal::temporal_operators;
pub use value::distributions;
