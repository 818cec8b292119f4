//! Reads reports back: the data to repeat an episode, and to check that the repetition is equal.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use polars::prelude::{Column, DataFrame, DataType, PolarsError, PolarsResult};
use polars_io::SerWriter;
use polars_io::csv::write::CsvWriter;

use crate::jobs::pedestrian_files;
use crate::record::columns::{EPISODE, NUMBER, OUTCOME, RUN_ID};
use crate::record::episodes::named;
use crate::record::{CellKey, EPISODES, RunKey, read_parquet};
use crate::report::aggregate::SEARCHES;
use crate::report::failure_table::FAILURES;
use crate::report::folder::{MARK, digest, is_sealed, report_files};
use crate::report::manifest::FileRecord;
use crate::report::scenario_files::held_path;
use crate::report::text_forms::without_formulas;
use crate::report::{Manifest, RunRecord, ScenarioFile};
use base::files;
use compile::{NoRunId, RunId, Training};
use learn::{ActorCritic, CheckpointError};

/// Why a report cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("cannot read `{path}`: {source}", path = path.display())]
    File { path: PathBuf, source: io::Error },
    #[error("`{path}` is a link; a report has none, and none is followed: take the report from where it is whole", path = path.display())]
    Link { path: PathBuf },
    #[error("`{path}` is not a manifest that episodes can be repeated from: {reason}", path = path.display())]
    Manifest { path: PathBuf, reason: String },
    #[error(
        "`{path}` is not a table of a report of this version: {source}; run its campaign again with this version",
        path = path.display()
    )]
    Table { path: PathBuf, source: PolarsError },
    #[error(
        "there is no `{path}`: the report has its tables as CSV only; run its campaign again with --formats csv,parquet",
        path = path.display()
    )]
    OnlyCsv { path: PathBuf },
    #[error("there is no `{path}`: the report is of an earlier version; run its campaign again", path = path.display())]
    Older { path: PathBuf },
    #[error("there is no `{path}`, which the report had when it was written; take the report from where it is whole", path = path.display())]
    Absent { path: PathBuf },
    #[error("`{path}` is not as it was written; take the report from where it is whole", path = path.display())]
    Changed { path: PathBuf },
    #[error("`{path}` holds no pedestrian: {source}", path = path.display())]
    Pedestrian { path: PathBuf, source: CheckpointError },
}

/// A report on the disk.
#[derive(Debug, Clone)]
pub struct StoredReport {
    folder: PathBuf,
    manifest: Manifest,
    /// The rows of failures by their names, once they are asked for.
    failures: OnceLock<BTreeMap<(RunId, u32), usize>>,
}

/// A run in the table of episodes.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredRun {
    pub key: RunKey,
    first: usize,
    count: usize,
}

/// A value of a table that differs in the repetition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    pub column: String,
    /// The value in the report.
    pub stored: String,
    /// The value of the repetition.
    pub again: String,
}

impl StoredReport {
    /// Opens the report in a folder.
    ///
    /// # Errors
    /// There is a link in it, or no manifest, or one that lacks necessary data.
    pub fn open(folder: &Path) -> Result<Self, ReadError> {
        let path = folder.join(MARK);
        let links = if folder.is_dir() { files::first_link(folder) } else { Ok(None) };
        if let Some(path) = links.map_err(|source| ReadError::File { path: folder.to_path_buf(), source })? {
            return Err(ReadError::Link { path });
        }
        let text = files::text(&path).map_err(|source| ReadError::File { path: path.clone(), source })?;
        let manifest = Manifest::from_toml(&text).map_err(|reason| ReadError::Manifest { path, reason })?;
        Ok(Self { folder: folder.to_path_buf(), manifest, failures: OnceLock::new() })
    }

    /// The folders with reports under a folder, itself included, in the order of their names.
    pub fn find(folder: &Path) -> Vec<PathBuf> {
        if folder.join(MARK).is_file() {
            return vec![folder.to_path_buf()];
        }
        let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let visible = |path: &PathBuf| !path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        let mut found: Vec<PathBuf> = entries.filter(|path| visible(path) && path.join(MARK).is_file()).collect();
        found.sort();
        found
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The files that are not as they were written: changed, missing or added ones, by their paths in the report. The manifest is
    /// changed when it has not the digest of its own lines; of one that lists no files nothing else is known.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn changed_files(&self) -> Result<Vec<String>, ReadError> {
        let written = &self.manifest.report_files;
        let failed = |source| ReadError::File { path: self.folder.clone(), source };
        let now = report_files(&self.folder).map_err(failed)?;
        let sealed = is_sealed(&files::text(&self.folder.join(MARK)).map_err(failed)?);
        let manifest = (!sealed).then(|| MARK.to_owned());
        if written.is_empty() {
            return Ok(manifest.into_iter().collect());
        }
        let missing = written.iter().filter(|file| !now.contains(file));
        let added = now.iter().filter(|file| written.iter().all(|other| other.path != file.path));
        Ok(manifest.into_iter().chain(missing.chain(added).map(|file| file.path.clone())).collect())
    }

    /// Checks that the manifest is as it was written.
    ///
    /// # Errors
    /// It was changed, or cannot be read.
    pub fn check_manifest(&self) -> Result<(), ReadError> {
        let path = self.folder.join(MARK);
        let manifest = files::text(&path).map_err(|source| ReadError::File { path: path.clone(), source })?;
        if is_sealed(&manifest) { Ok(()) } else { Err(ReadError::Changed { path }) }
    }

    /// Checks that the tables which episodes and failures are read from are as they were written.
    ///
    /// # Errors
    /// A table was changed or removed, or cannot be read.
    pub fn check_tables(&self) -> Result<(), ReadError> {
        [EPISODES, SEARCHES, FAILURES]
            .into_iter()
            .filter_map(|table| self.written(table))
            .try_for_each(|file| self.check(file))
    }

    /// Checks that the tables and the pedestrians which episodes are repeated with are as they were written.
    ///
    /// # Errors
    /// A table or a pedestrian was changed or removed, or cannot be read.
    pub fn check_for_repetition(&self) -> Result<(), ReadError> {
        self.check_tables()?;
        let mut pedestrians = self.manifest.report_files.iter().filter(|file| file.path.ends_with(".safetensors"));
        pedestrians.try_for_each(|file| self.check(file))
    }

    /// Checks that its episodes and the failures of its searches can be read.
    ///
    /// # Errors
    /// The report has them as CSV only.
    pub fn check_readable(&self) -> Result<(), ReadError> {
        [EPISODES, FAILURES].into_iter().try_for_each(|table| self.parquet(table).map(drop))
    }

    fn check(&self, file: &FileRecord) -> Result<(), ReadError> {
        let path = self.folder.join(&file.path);
        match digest(&path) {
            Ok(now) if now == file.blake3 => Ok(()),
            Ok(_) => Err(ReadError::Changed { path }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Err(ReadError::Absent { path }),
            Err(source) => Err(ReadError::File { path, source }),
        }
    }

    /// The Parquet file of a table, if the manifest lists it.
    pub(in crate::report) fn written(&self, table: &str) -> Option<&FileRecord> {
        let name = format!("{table}.parquet");
        self.manifest.report_files.iter().find(|file| file.path == name)
    }

    /// The file of the report that holds the contents of a scenario file; `None` if it does not hold them.
    pub fn held(&self, file: &ScenarioFile) -> Option<PathBuf> {
        held_path(&self.folder, &file.held)
    }

    /// Whether it has a run or a search of this name.
    ///
    /// # Errors
    /// The report has its tables as CSV only.
    pub fn holds(&self, run: RunId) -> Result<bool, ReadError> {
        [EPISODES, FAILURES].into_iter().try_for_each(|table| self.parquet(table).map(|_| ()))?;
        Ok(self.manifest.runs.iter().any(|record| record.id == run.to_string()))
    }

    /// The row of an episode, with what `failures` has of its touch; `None` if the report has no such episode. `guess` is its probable index.
    ///
    /// # Errors
    /// A table that is damaged.
    pub fn episode(&self, run: RunId, episode: u32, guess: usize) -> Result<Option<DataFrame>, ReadError> {
        let wanted = (run, episode);
        let guessed = match self.rows(EPISODES, guess, 1)? {
            Some(row) if self.names(EPISODES, &row, EPISODE.name)?.contains(&wanted) => Some(row),
            _ => match self.index()?.iter().position(|name| *name == wanted) {
                Some(row) => self.rows(EPISODES, row, 1)?,
                None => None,
            },
        };
        let Some(mut row) = guessed else { return Ok(None) };
        let outcome = OUTCOME.value(&row, 0).map_err(|source| self.damaged(EPISODES, source))?;
        if outcome.is_some_and(|outcome| named::is_touch(&outcome))
            && let Some(failure) = self.failure(run, episode)?
        {
            let is_new = |column: &&Column| row.get_column_index(column.name()).is_none();
            let more: Vec<Column> = failure.columns().iter().filter(is_new).cloned().collect();
            row.hstack_mut(&more).map_err(|source| self.damaged(FAILURES, source))?;
        }
        Ok(Some(row))
    }

    /// The names of all episodes, run and number, in the order of the table.
    ///
    /// # Errors
    /// A table that is damaged.
    pub fn index(&self) -> Result<Vec<(RunId, u32)>, ReadError> {
        self.all_names(EPISODES, EPISODE.name)
    }

    /// The row of a failure that a search found, or of the touch of an episode.
    ///
    /// # Errors
    /// A table that is damaged.
    pub fn failure(&self, run: RunId, number: u32) -> Result<Option<DataFrame>, ReadError> {
        if self.failures.get().is_none() {
            // A violation comes after the touch of its episode.
            let names = self.all_names(FAILURES, NUMBER.name)?.into_iter().enumerate();
            let _ = self.failures.set(names.rev().map(|(row, name)| (name, row)).collect());
        }
        let row = self.failures.get().and_then(|rows| rows.get(&(run, number)));
        row.map_or(Ok(None), |row| self.rows(FAILURES, *row, 1))
    }

    /// The names of all failures of searches, search and number, in the order of the table.
    ///
    /// # Errors
    /// A table that is damaged.
    pub fn search_failures(&self) -> Result<Vec<(RunId, u32)>, ReadError> {
        let Some(searches) = self.read(SEARCHES, Some(&[RUN_ID.name]), None)? else { return Ok(Vec::new()) };
        let searches = self.ids(SEARCHES, &searches)?;
        let names = self.all_names(FAILURES, NUMBER.name)?;
        Ok(names.into_iter().filter(|(run, _)| searches.contains(run)).collect())
    }

    /// The networks of each policy of a training of pedestrians.
    ///
    /// # Errors
    /// A file that is missing or damaged.
    pub fn pedestrian(&self, training: &Training) -> Result<Vec<ActorCritic>, ReadError> {
        let read = |file: String| {
            let path = self.folder.join(file);
            let bytes = files::bytes(&path).map_err(|source| ReadError::File { path: path.clone(), source })?;
            let read = ActorCritic::from_safetensors(&bytes);
            Ok(read.map_err(|source| ReadError::Pedestrian { path, source })?.0)
        };
        pedestrian_files(training, "safetensors").into_iter().map(read).collect()
    }

    /// The runs of the table of episodes, in its order.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn run_rows(&self) -> Result<Vec<StoredRun>, ReadError> {
        let mut ids: Vec<(RunId, usize, usize)> = Vec::new();
        let path = self.parquet(EPISODES)?;
        let Some(table) = self.read(EPISODES, Some(&[RUN_ID.name]), None)? else { return Ok(Vec::new()) };
        for (row, id) in self.ids(EPISODES, &table)?.into_iter().enumerate() {
            match ids.last_mut() {
                Some((last, _, count)) if *last == id => *count += 1,
                _ => ids.push((id, row, 1)),
            }
        }
        let mut runs = Vec::new();
        for (_, first, count) in ids {
            let Some(row) = self.rows(EPISODES, first, 1)? else { continue };
            let failed = |source| ReadError::Table { path: path.clone(), source };
            let mut key = RunKey::read(&row, 0).map_err(failed)?;
            let id = key.id.to_string();
            if let Some(RunRecord { block, vehicle, body: adversary, .. }) =
                self.manifest.runs.iter().find(|run| run.id == id)
            {
                let (vehicle, adversary) = (vehicle.clone(), adversary.clone());
                key.cell = CellKey { block: *block, vehicle, adversary, ..key.cell };
            }
            runs.push(StoredRun { key, first, count });
        }
        Ok(runs)
    }

    /// The episodes of a run.
    ///
    /// # Errors
    /// A table that is damaged.
    pub fn rows_of(&self, run: &StoredRun) -> Result<DataFrame, ReadError> {
        Ok(self.rows(EPISODES, run.first, run.count)?.unwrap_or_default())
    }

    /// Passes a table on in parts of this number of rows; nothing if the report has no such table.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub(in crate::report) fn each_part(
        &self,
        table: &str,
        count: usize,
        mut take: impl FnMut(&DataFrame) -> PolarsResult<()>,
    ) -> Result<(), ReadError> {
        let path = self.parquet(table)?;
        for first in (0..).step_by(count) {
            let Some(rows) = self.rows(table, first, count)? else { break };
            take(&rows).map_err(|source| ReadError::Table { path: path.clone(), source })?;
            if rows.height() < count {
                break;
            }
        }
        Ok(())
    }

    fn parquet(&self, table: &str) -> Result<PathBuf, ReadError> {
        let path = self.folder.join(format!("{table}.parquet"));
        if table == FAILURES && self.written(EPISODES).is_some() && self.written(FAILURES).is_none() {
            return Err(ReadError::Older { path });
        }
        let is_csv = !path.exists() && self.written(table).is_none() && path.with_extension("csv").exists();
        if is_csv { Err(ReadError::OnlyCsv { path }) } else { Ok(path) }
    }

    /// Some rows of a table; `None` if the report has no such table or it ends before them.
    fn rows(&self, table: &str, first: usize, count: usize) -> Result<Option<DataFrame>, ReadError> {
        Ok(self.read(table, None, Some((first, count)))?.filter(|rows| rows.height() > 0))
    }

    /// Reads a table, some of its columns, some of its rows; `None` if the report has no such table.
    fn read(
        &self,
        table: &str,
        columns: Option<&[&str]>,
        rows: Option<(usize, usize)>,
    ) -> Result<Option<DataFrame>, ReadError> {
        let path = self.folder.join(format!("{table}.parquet"));
        let file = match files::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return if self.written(table).is_some() { Err(ReadError::Absent { path }) } else { Ok(None) };
            }
            Err(source) => return Err(ReadError::File { path, source }),
        };
        let most = self.written(table).and_then(|written| written.rows).unwrap_or(u64::MAX);
        let table = read_parquet(file, most, columns, rows).and_then(without_formulas);
        table.map(Some).map_err(|source| ReadError::Table { path, source })
    }

    /// The names of all rows of a table.
    fn all_names(&self, table: &str, number: &str) -> Result<Vec<(RunId, u32)>, ReadError> {
        let rows = self.read(table, Some(&[RUN_ID.name, number]), None)?;
        rows.map_or(Ok(Vec::new()), |rows| self.names(table, &rows, number))
    }

    fn ids(&self, table: &str, rows: &DataFrame) -> Result<Vec<RunId>, ReadError> {
        let ids = RUN_ID.read(rows).map_err(|source| self.damaged(table, source))?;
        let no_run = |error: NoRunId| self.damaged(table, PolarsError::ComputeError(error.to_string().into()));
        ids.iter().map(|id| id.unwrap_or_default().parse().map_err(no_run)).collect()
    }

    fn names(&self, table: &str, rows: &DataFrame, number: &str) -> Result<Vec<(RunId, u32)>, ReadError> {
        let numbers = rows.column(number).and_then(|column| column.cast(&DataType::UInt32));
        let numbers = numbers.map_err(|source| self.damaged(table, source))?;
        let numbers = numbers.u32().map_err(|source| self.damaged(table, source))?;
        Ok(self.ids(table, rows)?.into_iter().zip(numbers.iter().map(Option::unwrap_or_default)).collect())
    }

    fn damaged(&self, table: &str, source: PolarsError) -> ReadError {
        ReadError::Table { path: self.folder.join(format!("{table}.parquet")), source }
    }
}

/// The values of the only column of a table, as in CSV, with all digits that are needed to read the same number back.
fn values(column: &DataFrame) -> PolarsResult<Vec<String>> {
    let mut bytes = Vec::new();
    CsvWriter::new(&mut bytes).include_header(false).finish(&mut column.clone())?;
    Ok(String::from_utf8_lossy(&bytes).lines().map(str::to_string).collect())
}

/// The values in which two tables with the same rows differ, in the order of the rows, each with the number of its row. Columns that one
/// of them lacks are ignored.
///
/// # Errors
/// Those of polars.
pub fn differences(stored: &DataFrame, again: &DataFrame) -> PolarsResult<Vec<(usize, Difference)>> {
    let mut found = Vec::new();
    for name in again.get_column_names() {
        let Ok(stored) = stored.select([name.clone()]) else { continue };
        let (before, now) = (values(&stored)?, values(&again.select([name.clone()])?)?);
        for row in 0..before.len().max(now.len()) {
            let cell = |values: &[String]| values.get(row).cloned().unwrap_or_else(|| "no such row".to_string());
            if before.get(row) != now.get(row) {
                let difference = Difference { column: name.to_string(), stored: cell(&before), again: cell(&now) };
                found.push((row, difference));
            }
        }
    }
    found.sort_by_key(|(row, _)| *row);
    Ok(found)
}
