use std::io::{self, Write};

use polars::prelude::{DataFrame, PolarsError, PolarsResult};
use rayon::prelude::*;

use super::ticks::TICKS;
use super::{Episodes, ticks};
use crate::campaign::Finished;
use crate::jobs::{SearchResult, TrainingResult, networks, repeat_episodes};
use crate::record::EpisodeTable;
use crate::report::parquet::ParquetFile;
use crate::report::{ReportFolder, WriteError};
use base::seed::Seed;
use compile::{Campaign, Evaluation, Search};
use learn::ActorCritic;
use world::env::{Outcome, Trace};
use world::falsifier::Failure;

/// Most episodes that a thread repeats at once and holds in memory.
const MOST: usize = 100;
/// Approximate number of rows in a row group of the file.
const ROWS: usize = 1 << 17;

/// Episodes that are written tick by tick.
#[derive(Debug, Clone)]
pub struct Wanted<'a> {
    of: Repeatable<'a>,
    /// The numbers of the episodes, or of the failures of a search, in order.
    numbers: Vec<u32>,
}

/// What can be repeated.
#[derive(Debug, Clone, Copy)]
enum Repeatable<'a> {
    /// An evaluation, with the result of its training; none for untrained controllers.
    Evaluation(&'a Evaluation, Option<&'a ActorCritic>),
    /// A search with all failures that it found.
    Search(&'a Search, &'a [Failure]),
}

impl<'a> Wanted<'a> {
    /// The collisions of a campaign, or all of its episodes except those that were not run; then the failures that its searches found. Of
    /// the other episodes of a search nothing is stored.
    ///
    /// # Errors
    /// A table of episodes that is damaged.
    pub fn of(
        campaign: &'a Campaign,
        episodes: &Episodes<'a>,
        finished: &'a Finished,
        all: bool,
    ) -> Result<Vec<Self>, WriteError> {
        let mut wanted = Vec::new();
        for run in episodes.runs() {
            let evaluation = run.evaluation;
            let trained = networks(evaluation, finished.all::<TrainingResult>());
            let chosen = run.parts().map(|part| chosen(&part?, all)).collect::<PolarsResult<Vec<_>>>();
            let numbers = chosen.map_err(|source| WriteError::Table { name: TICKS.into(), source })?.concat();
            if !numbers.is_empty() {
                wanted.push(Self { of: Repeatable::Evaluation(evaluation, trained), numbers });
            }
        }
        for result in finished.all::<SearchResult>() {
            let failures = result.spent.failures.as_slice();
            if let Some(search) = campaign.all::<Search>().find(|search| search.key == result.key) {
                let numbers = (0..).zip(failures).map(|(number, _)| number).collect();
                wanted.push(Self { of: Repeatable::Search(search, failures), numbers });
            }
        }
        Ok(wanted)
    }

    /// Repeats some of the episodes.
    fn repeat(&self, numbers: &[u32], seed: &Seed) -> Vec<DataFrame> {
        match self.of {
            Repeatable::Evaluation(evaluation, trained) => {
                let note = &mut |_: &Outcome, trace: &Trace| trace.clone();
                let traces = repeat_episodes(evaluation, trained, numbers, seed, note).into_iter();
                traces.map(|(number, trace)| ticks(evaluation.id, number, &evaluation.scenario, &trace)).collect()
            }
            Repeatable::Search(search, failures) => {
                let table = |number: &u32| {
                    let failure = &failures[*number as usize];
                    let (start, commands) = (failure.start, &failure.commands);
                    let again = crate::jobs::Repeatable::Find { search, start, commands }.repeat(seed)?;
                    Some(ticks(search.key.id, *number, &search.scenario, &again.trace))
                };
                numbers.iter().filter_map(table).collect()
            }
        }
    }
}

/// The numbers of the collisions, or of all episodes that were run.
fn chosen(part: &DataFrame, all: bool) -> PolarsResult<Vec<u32>> {
    let table = EpisodeTable::new(part)?;
    let wanted = table
        .rows()
        .filter(|row| table.ticks(*row).is_some() && (all || table.counts(*row) && table.is_collision(*row)));
    Ok(wanted.map(|row| table.episode(row)).collect())
}

/// Repeats episodes and writes them tick by tick as `ticks.parquet`, in the given order. At most a few hundred are in memory at once.
///
/// # Errors
/// The file cannot be written.
pub fn write_ticks(folder: &ReportFolder, seed: &Seed, wanted: &[Wanted<'_>]) -> Result<(), WriteError> {
    let pieces: Vec<(&Wanted<'_>, &[u32])> =
        wanted.iter().flat_map(|wanted| wanted.numbers.chunks(MOST).map(move |piece| (wanted, piece))).collect();
    let mut tables = pieces.chunks(rayon::current_num_threads()).flat_map(|pieces| {
        let repeat = |(wanted, numbers): &(&Wanted<'_>, &[u32])| wanted.repeat(numbers, seed);
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
