//! What an episode is in a table: its key, its row, and the catalogue of columns that writing, reading and the reference follow from.
//!
//! A [`Column`] has a name, a unit and a meaning, and is the only place where these are spelt. A [`Table`] pairs columns with
//! what they are read from in a row, and with the [`Metric`]s that runs and cells make of them. [`EpisodeTable`] reads the table of
//! episodes back by type. Tables of other modules are built of the same parts, beside the type of their rows.

mod key;
mod row;
mod column;
pub mod columns;
pub mod metric;
mod episodes;
mod read;
mod tally;
mod stored;
#[cfg(test)]
mod tests;

pub use column::{Cell, Column, ColumnReference, Entry, Family, Interval, Kind, Table, TableReference};
pub use episodes::{
    EPISODES, IN_ERROR, cell_key, cell_key_names, cell_key_references, episode_table, episodes, metrics, run_key_names,
    run_key_references,
};
pub use key::{CellKey, RunKey};
pub use metric::Metric;
pub use read::EpisodeTable;
pub use row::EpisodeRow;
pub use stored::{Chunk, Chunks, decode, encode, tally};
pub use tally::Tally;
