//! The canonical layout of a file.
//!
//! The parser says only where statements and blocks begin and which words are names, numbers or signs ([`marks`]). All else is
//! read off the text itself as a row of tokens ([`tokens`]), comments included, and laid out anew ([`layout`], [`printer`]). So
//! a new form of expression needs no word here.

mod marks;
mod tokens;
mod tree;
mod layout;
mod printer;

pub use layout::format;
