use std::fs::File;
use std::io::{self, BufWriter};
use std::path::PathBuf;

use polars::prelude::{DataFrame, PolarsError, PolarsResult, Schema};
use polars_io::SerWriter;
use polars_io::csv::write::{BatchedWriter as CsvPieces, CsvWriter};
use polars_io::parquet::write::{BatchedWriter as ParquetPieces, ParquetWriter};

use super::WriteError;

/// Rows that are written at once; in Parquet they are a row group.
const GROUP: usize = 1 << 16;

/// A table that is written piece by piece, as CSV and as Parquet, so that it need not fit in memory.
pub struct TableStream {
    waiting: DataFrame,
    csv: (PathBuf, CsvPieces<BufWriter<File>>),
    parquet: (PathBuf, ParquetPieces<BufWriter<File>>),
    /// The files once more, for the end.
    files: [File; 2],
}

impl TableStream {
    pub(super) fn begin(
        schema: &Schema,
        (csv_path, csv): (PathBuf, BufWriter<File>),
        (parquet_path, parquet): (PathBuf, BufWriter<File>),
    ) -> Result<Self, WriteError> {
        let again = |file: &BufWriter<File>, path: &PathBuf| {
            file.get_ref().try_clone().map_err(|source| WriteError::File { path: path.clone(), source })
        };
        let files = [again(&csv, &csv_path)?, again(&parquet, &parquet_path)?];
        let csv = failed(&csv_path, CsvWriter::new(csv).batched(schema))?;
        let parquet = failed(&parquet_path, ParquetWriter::new(parquet).batched(schema))?;
        let waiting = DataFrame::empty_with_schema(schema);
        Ok(Self { waiting, csv: (csv_path, csv), parquet: (parquet_path, parquet), files })
    }

    /// Adds rows.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn add(&mut self, rows: &DataFrame) -> Result<(), WriteError> {
        failed(&self.csv.0, self.waiting.vstack_mut(rows).map(|_| ()))?;
        if self.waiting.height() >= GROUP { self.write() } else { Ok(()) }
    }

    fn write(&mut self) -> Result<(), WriteError> {
        let empty = self.waiting.clear();
        let mut rows = std::mem::replace(&mut self.waiting, empty);
        rows.rechunk_mut();
        failed(&self.csv.0, self.csv.1.write_batch(&rows))?;
        failed(&self.parquet.0, self.parquet.1.write_batch(&rows))
    }

    /// Writes what is left, and makes sure that all of it is on the disk.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(mut self) -> Result<(), WriteError> {
        self.write()?;
        failed(&self.csv.0, self.csv.1.finish())?;
        failed(&self.parquet.0, self.parquet.1.finish())?;
        let paths = [self.csv.0, self.parquet.0];
        // What is still in the buffers goes to the files when the writers go, so that must be now.
        drop((self.csv.1, self.parquet.1));
        for (file, path) in self.files.iter().zip(paths) {
            file.sync_all().map_err(|source| WriteError::File { path, source })?;
        }
        Ok(())
    }
}

fn failed<T>(path: &PathBuf, result: PolarsResult<T>) -> Result<T, WriteError> {
    result.map_err(|error| {
        let source = match error {
            PolarsError::IO { error, .. } => io::Error::new(error.kind(), error.to_string()),
            other => io::Error::other(other.to_string()),
        };
        WriteError::File { path: path.clone(), source }
    })
}
