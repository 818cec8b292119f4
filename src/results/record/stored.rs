//! Episodes as they are stored: the table without the key of their run, as Parquet.

use std::io::Cursor;
use std::ops::Range;

use polars::prelude::{Column as Values, DataFrame, NamedFrom, PlSmallStr, PolarsResult, Scalar, SchemaExtPl, Series};
use polars_io::parquet::write::{ParquetCompression, ParquetWriter};

use super::columns::{EPISODE, ERROR, FAULT, FRONT, OUTCOME};
use super::degrees::{self, append};
use super::episodes::{named, outcome_table, repeated_key};
use super::parquet_reader::read_parquet;
use super::{DEGREES, EpisodeRow, RunKey, with_degrees};
use crate::campaign::Task;
use compile::CHUNK;

/// Tables with fewer rows are not compressed.
const FEW: usize = 100;

/// Some episodes of a run.
#[derive(Debug, Clone)]
pub struct Chunk {
    /// The first of them, as [`encode`] wrote them.
    pub outcomes: DataFrame,
    /// Why there are no more; empty if there is no reason.
    pub error: String,
}

impl Chunk {
    /// No episodes, without a reason.
    pub fn empty() -> Self {
        Self { outcomes: outcome_table().frame(&[]), error: String::new() }
    }

    /// The episodes as rows of the table of episodes. `wanted` are the numbers of the episodes that the chunk should have. If the chunk
    /// has an error, the missing episodes become rows in error.
    ///
    /// # Errors
    /// Those of polars; none for what [`encode`] wrote.
    pub fn into_episodes(self, key: &RunKey, wanted: Range<u32>) -> PolarsResult<DataFrame> {
        let mut rows = self.outcomes.head(Some(wanted.len()));
        let done = rows.height() as u32;
        if !self.error.is_empty() {
            append(&mut rows, in_error(wanted.start + done..wanted.end, &self.error)?)?;
        }
        let mut columns = repeated_key(key, rows.height());
        columns.extend(rows.columns().iter().cloned());
        DataFrame::new(rows.height(), columns)
    }
}

/// The store of a campaign's episodes.
pub trait Chunks {
    /// The episodes of a part of an evaluation; `None` if it is not there.
    fn chunk(&self, task: Task) -> Option<Chunk>;
}

/// Episodes that were not run, for this reason.
fn in_error(episodes: Range<u32>, error: &str) -> PolarsResult<DataFrame> {
    let count = episodes.len();
    let text = |name, text| Values::new_scalar(name, Scalar::from(PlSmallStr::from(text)), count);
    let column = |like: &Values| {
        let name = like.name().clone();
        match name.as_str() {
            known if known == EPISODE.name => Series::new(name, episodes.clone().collect::<Vec<u32>>()).into(),
            known if known == OUTCOME.name => text(name, named::ERROR),
            known if known == ERROR.name => text(name, error),
            known if [FAULT.name, FRONT.name].contains(&known) => Values::new_scalar(name, Scalar::from(false), count),
            _ => Values::full_null(name, count, like.dtype()),
        }
    };
    DataFrame::new(count, outcome_table().frame(&[]).columns().iter().map(column).collect())
}

/// Encodes episodes as Parquet, after those of an earlier encoding if there is one; also returns the number of all of them.
///
/// # Errors
/// Those of polars, only if `before` is not an encoding.
pub fn encode(before: Option<&[u8]>, rows: &[EpisodeRow]) -> PolarsResult<(Vec<u8>, u64)> {
    let mut table = outcome_table().frame(rows);
    degrees::add(&mut table, rows)?;
    if let Some(before) = before {
        let mut all = decode(before)?;
        append(&mut all, table)?;
        table = all;
    }
    // A decompressor for each page costs more than a few rows.
    let compression =
        if table.height() < FEW { ParquetCompression::Uncompressed } else { ParquetCompression::default() };
    let mut bytes = Vec::new();
    ParquetWriter::new(&mut bytes).with_compression(compression).finish(&mut table)?;
    Ok((bytes, table.height() as u64))
}

/// Decodes what [`encode`] wrote.
///
/// # Errors
/// The bytes are not Parquet, or have other columns.
pub fn decode(bytes: &[u8]) -> PolarsResult<DataFrame> {
    let table = read_parquet(Cursor::new(bytes), CHUNK.into(), None, None)?;
    let mut known = outcome_table().frame(&[]);
    if table.get_column_index(DEGREES.name).is_some() {
        with_degrees(&mut known)?;
    }
    known.schema().ensure_is_exact_match(table.schema())?;
    Ok(table)
}
