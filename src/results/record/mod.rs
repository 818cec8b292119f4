//! An episode in a table: its key, its row, and the catalogue of columns, from which writing, reading and the reference follow.
//!
//! A [`Column`] has a name, a unit and a meaning, and is the only place where these are spelt. A [`Table`] pairs each column with a
//! function that reads it from a row; [`tables`](crate::tables) have what runs and cells make of the columns of episodes. [`EpisodeTable`] reads the table of
//! episodes back by type. Tables of other modules have the same parts, defined beside the type of their rows.

mod key;
mod row;
mod column;
pub mod columns;
pub(crate) mod episodes;
mod read;
mod stored;
mod degrees;
mod parquet_reader;
#[cfg(test)]
pub(crate) mod tests;

pub use column::{Cell, Column, ColumnReference, Entry, Family, Kind, Role, Signed, Table, TableReference, interval};
pub(crate) use column::{columns, entries};
pub use degrees::{DEGREES, parse as parse_degrees, with_degrees};
pub use episodes::{EPISODES, IN_ERROR, cell_key, episode_references, episode_table, episodes};
pub use key::{CellKey, RunKey, in_block, in_world};
pub use parquet_reader::{read_parquet, said_rows};
pub use read::EpisodeTable;
pub use row::EpisodeRow;
pub use stored::{Chunk, Chunks, decode, encode};
