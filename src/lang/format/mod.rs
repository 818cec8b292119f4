//! The canonical layout of a file.
//!
//! The parser gives only the starts of statements and blocks and the kinds of words: names, numbers or signs ([`marks`]).
//! Everything else is read from the text itself as a sequence of tokens ([`tokens`]), including comments, and laid out anew
//! ([`layout`], [`printer`]). A new form of expression therefore needs no change here.

mod marks;
mod tokens;
mod tree;
mod layout;
mod printer;

pub use layout::format;
