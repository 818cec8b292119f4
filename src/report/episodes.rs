use std::io::Cursor;
use std::ops::Range;

use polars::prelude::{Column, DataFrame, NamedFrom, PlSmallStr, PolarsResult, Scalar, SchemaExtPl, Series};
use polars_io::SerReader;
use polars_io::parquet::read::ParquetReader;
use polars_io::parquet::write::ParquetWriter;

use super::tables::{identity, outcomes};
use crate::campaign::{EpisodeRow, Tally};
use crate::compile::{Campaign, Evaluation};

/// Some episodes of an evaluation.
#[derive(Debug, Clone)]
pub struct Chunk {
    /// What became of the first of them, as [`encode`] wrote it.
    pub outcomes: DataFrame,
    /// Why there are no more; empty when they are all that was tried.
    pub error: String,
}

/// Where episodes are kept.
pub trait Chunks {
    /// A chunk of an evaluation; none when it was not tried.
    fn chunk(&self, evaluation: usize, chunk: u32) -> Option<Chunk>;
}

/// All episodes of a campaign, run by run, so that no more than one run need be in memory.
#[derive(Clone, Copy)]
pub struct Episodes<'a> {
    campaign: &'a Campaign,
    chunks: &'a dyn Chunks,
}

impl<'a> Episodes<'a> {
    /// Gets at the episodes of a campaign.
    pub fn new(campaign: &'a Campaign, chunks: &'a dyn Chunks) -> Self {
        Self { campaign, chunks }
    }

    /// The runs, in the plan's order: each one pedestrian of one training in one town against one policy.
    pub fn runs(&self) -> impl Iterator<Item = Run<'a>> {
        let chunks = self.chunks;
        let run = move |(index, evaluation)| Run { index, evaluation, chunks };
        self.campaign.evaluations.iter().enumerate().map(run)
    }
}

/// The episodes of an evaluation.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// Its place in the plan.
    pub index: usize,
    /// What was tried.
    pub evaluation: &'a Evaluation,
    chunks: &'a dyn Chunks,
}

impl Run<'_> {
    /// Its episodes as a table, at most [`CHUNK`](crate::campaign::CHUNK) rows at a time; those that came to nothing are in error.
    ///
    /// # Errors
    /// Those of polars; none for what [`encode`] wrote.
    pub fn parts(&self) -> impl Iterator<Item = PolarsResult<DataFrame>> {
        (0..self.evaluation.chunks()).filter_map(|number| {
            let wanted = self.evaluation.chunk(number);
            let chunk = self.chunks.chunk(self.index, number)?;
            let part = table(self.evaluation, wanted, chunk);
            part.map(|part| (part.height() > 0).then_some(part)).transpose()
        })
    }

    /// All its episodes as a table.
    ///
    /// # Errors
    /// As [`Run::parts`].
    pub fn frame(&self) -> PolarsResult<DataFrame> {
        let mut whole = table(self.evaluation, 0..0, Chunk { outcomes: outcomes(&[]), error: String::new() })?;
        for part in self.parts() {
            whole.vstack_mut(&part?)?;
        }
        // Sums must not hang on how many pieces there were.
        whole.rechunk_mut();
        Ok(whole)
    }
}

/// The rows of a chunk, with what tells them from other runs.
fn table(evaluation: &Evaluation, wanted: Range<u32>, chunk: Chunk) -> PolarsResult<DataFrame> {
    let mut rows = chunk.outcomes.head(Some(wanted.len()));
    let tried = rows.height() as u32;
    if !chunk.error.is_empty() {
        rows.vstack_mut(&failed(wanted.start + tried..wanted.end, &chunk.error)?)?;
        rows.rechunk_mut();
    }
    let mut columns = identity(evaluation, rows.height());
    columns.extend(rows.columns().iter().cloned());
    DataFrame::new(rows.height(), columns)
}

/// Episodes that were not tried, for this reason.
fn failed(episodes: Range<u32>, error: &str) -> PolarsResult<DataFrame> {
    let count = episodes.len();
    let column = |like: &Column| {
        let name = like.name().clone();
        match name.as_str() {
            "episode" => Series::new(name, episodes.clone().collect::<Vec<u32>>()).into(),
            "outcome" => Column::new_scalar(name, Scalar::from(PlSmallStr::from("error")), count),
            "error" => Column::new_scalar(name, Scalar::from(PlSmallStr::from(error)), count),
            "collision" | "front" | "moving" => Column::new_scalar(name, Scalar::from(false), count),
            _ => Column::full_null(name, count, like.dtype()),
        }
    };
    DataFrame::new(count, outcomes(&[]).columns().iter().map(column).collect())
}

/// Encodes episodes as Parquet, behind those of an earlier encoding if there is one; says how many they are together.
///
/// # Errors
/// Those of polars; none when `before` is an encoding.
pub fn encode(before: Option<&[u8]>, rows: &[EpisodeRow]) -> PolarsResult<(Vec<u8>, u64)> {
    let mut table = outcomes(rows);
    if let Some(before) = before {
        let mut all = decode(before)?;
        all.vstack_mut(&table)?;
        all.rechunk_mut();
        table = all;
    }
    let mut bytes = Vec::new();
    ParquetWriter::new(&mut bytes).finish(&mut table)?;
    Ok((bytes, table.height() as u64))
}

/// Counts the episodes that [`encode`] wrote.
///
/// # Errors
/// As [`decode`].
pub fn tally(bytes: &[u8]) -> PolarsResult<Tally> {
    let table = decode(bytes)?;
    let (outcomes, collisions) = (table.column("outcome")?.str()?, table.column("collision")?.bool()?);
    let errors = outcomes.iter().filter(|outcome| *outcome == Some("error")).count();
    Ok(Tally {
        episodes: table.height() as u32,
        valid: (table.height() - errors) as u64,
        collisions: u64::from(collisions.sum().unwrap_or_default()),
        enough: false,
    })
}

/// Decodes what [`encode`] wrote.
///
/// # Errors
/// It is no Parquet, or holds other columns.
pub fn decode(bytes: &[u8]) -> PolarsResult<DataFrame> {
    let table = ParquetReader::new(Cursor::new(bytes.to_vec())).finish()?;
    outcomes(&[]).schema().ensure_is_exact_match(table.schema())?;
    Ok(table)
}
