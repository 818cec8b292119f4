//! Guesses at what is missing in a statement of no known shape, or foreign to it: a repair is believed when the statement can be read
//! with it.

mod commas;
mod heads;
mod left_over;
mod slips;

pub(super) use commas::{decimal_comma, missing_commas, unbracketed};
pub(super) use heads::{
    dotted_key, ends_open, headless, imports, open_end, split_words, type_of, unbraced, untyped_param,
};
pub(super) use left_over::left_over;
pub(super) use slips::{missing_colon, slips, without};
