use std::io::{self, Write};
use std::ops::ControlFlow;

use polars::prelude::{DataFrame, PolarsError, PolarsResult};
use rayon::prelude::*;

use super::ticks::TICKS;
use super::{Episodes, ticks};
use crate::campaign::{Finished, watch};
use crate::compile::{ControllerKind, Evaluation};
use crate::env::{Outcome, Trace};
use crate::record::EpisodeTable;
use crate::report::parquet::ParquetFile;
use crate::report::{ReportFolder, WriteError};
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// Most episodes that a thread repeats at once and holds in memory.
const MOST: usize = 100;
/// Approximate number of rows in a row group of the file.
const ROWS: usize = 1 << 17;

/// Episodes of an evaluation that are written tick by tick.
#[derive(Debug, Clone)]
pub struct Wanted<'a> {
    /// The evaluation.
    pub evaluation: &'a Evaluation,
    /// The result of its training; none for untrained controllers.
    pub trained: Option<&'a ActorCritic>,
    /// The numbers of the episodes, in order.
    pub episodes: Vec<u32>,
}

impl<'a> Wanted<'a> {
    /// The collisions of a campaign, or all of its episodes except those that were not run.
    ///
    /// # Errors
    /// A table of episodes that is damaged.
    pub fn of(episodes: &Episodes<'a>, finished: &'a Finished, all: bool) -> Result<Vec<Self>, WriteError> {
        let mut wanted = Vec::new();
        for run in episodes.runs() {
            let evaluation = run.evaluation;
            let trained = finished.trainings.iter().find(|training| training.key == *evaluation.trained);
            let trained =
                trained.and_then(|training| training.result.as_ref().ok()).map(|trained| &trained.actor_critic);
            let learnt = matches!(evaluation.controller, ControllerKind::Trained(_) | ControllerKind::Sampled(_));
            let chosen = run.parts().map(|part| chosen(&part?, all)).collect::<PolarsResult<Vec<_>>>();
            let episodes = chosen.map_err(|source| WriteError::Table { name: TICKS.into(), source })?.concat();
            if !episodes.is_empty() && (trained.is_some() || !learnt) {
                wanted.push(Self { evaluation, trained: trained.filter(|_| learnt), episodes });
            }
        }
        Ok(wanted)
    }

    /// Repeats some of the episodes.
    fn repeat(&self, episodes: &[u32], seed: &Seed) -> Vec<DataFrame> {
        let (evaluation, mut tables) = (self.evaluation, Vec::with_capacity(episodes.len()));
        // Consecutive episodes run together, which is faster for drivers with batches.
        for row in episodes.chunk_by(|one, next| one + 1 == *next) {
            let (Some(first), Some(last)) = (row.first(), row.last()) else { continue };
            let note = &mut |_: &Outcome, trace: &Trace| trace.clone();
            let go_on = &mut |_| ControlFlow::Continue(());
            let traces = watch(evaluation, self.trained, *first..*last + 1, seed, note, go_on);
            let table = |(episode, trace)| ticks(evaluation.id, episode, &evaluation.scenario, &trace);
            tables.extend((*first..).zip(traces).map(table));
        }
        tables
    }
}

/// The numbers of the collisions, or of all episodes that were run.
fn chosen(part: &DataFrame, all: bool) -> PolarsResult<Vec<u32>> {
    let table = EpisodeTable::new(part)?;
    let wanted = table.rows().filter(|row| table.ticks(*row).is_some() && (all || table.is_collision(*row)));
    Ok(wanted.map(|row| table.episode(row)).collect())
}

/// Repeats episodes and writes them tick by tick as `ticks.parquet`, in the given order. At most a few hundred are in memory at once.
///
/// # Errors
/// The file cannot be written.
pub fn write_ticks(folder: &ReportFolder, seed: &Seed, wanted: &[Wanted<'_>]) -> Result<(), WriteError> {
    let pieces: Vec<(&Wanted<'_>, &[u32])> =
        wanted.iter().flat_map(|wanted| wanted.episodes.chunks(MOST).map(move |piece| (wanted, piece))).collect();
    let mut tables = pieces.chunks(rayon::current_num_threads()).flat_map(|pieces| {
        let repeat = |(wanted, episodes): &(&Wanted<'_>, &[u32])| wanted.repeat(episodes, seed);
        let together: Vec<Vec<DataFrame>> = pieces.par_iter().with_max_len(1).map(repeat).collect();
        together.into_iter().flatten()
    });
    let Some(first) = tables.next() else { return Ok(()) };
    folder.write(&format!("{TICKS}.parquet"), |file| {
        stream(file, first, tables).map_err(|error| io::Error::other(error.to_string()))
    })
}

/// Writes tables of the same columns one after another.
fn stream(file: impl Write, first: DataFrame, others: impl Iterator<Item = DataFrame>) -> PolarsResult<()> {
    let mut writer = ParquetFile::new(file, first.schema())?;
    let mut gathered = first;
    for table in others {
        gathered.vstack_mut_owned(table)?;
        if gathered.height() >= ROWS {
            flush(&mut writer, &mut gathered)?;
        }
    }
    flush(&mut writer, &mut gathered)?;
    writer.finish()
}

fn flush<W: Write>(writer: &mut ParquetFile<W>, gathered: &mut DataFrame) -> Result<(), PolarsError> {
    gathered.align_chunks_par();
    writer.add(gathered)?;
    *gathered = gathered.clear();
    Ok(())
}
