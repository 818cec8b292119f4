use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use polars::prelude::{DataFrame, PolarsError, PolarsResult, Schema};
use polars_io::SerWriter;
use polars_io::csv::write::{BatchedWriter as CsvPieces, CsvWriter};
use polars_io::parquet::write::{BatchedWriter as ParquetPieces, ParquetWriter};

use super::WriteError;

/// Number of rows that are written at once; in Parquet they are a row group.
const GROUP: usize = 1 << 16;

/// A table that is written part by part, as CSV, as Parquet or both, so that it need not fit in memory.
pub struct TableStream {
    waiting: DataFrame,
    csv: Option<Stream<CsvPieces<BufWriter<File>>>>,
    parquet: Option<Stream<ParquetPieces<BufWriter<File>>>>,
}

/// A file in one of the formats.
struct Stream<W> {
    path: PathBuf,
    pieces: W,
    /// The file once more, for the sync at the end.
    file: File,
}

impl<W> Stream<W> {
    fn begin(
        (path, writer): (PathBuf, BufWriter<File>),
        begin: impl FnOnce(BufWriter<File>) -> PolarsResult<W>,
    ) -> Result<Self, WriteError> {
        let again = writer.get_ref().try_clone();
        let file = again.map_err(|source| WriteError::File { path: path.clone(), source })?;
        let pieces = failed(&path, begin(writer))?;
        Ok(Self { path, pieces, file })
    }

    /// Syncs the whole file to the disk.
    fn settle(self) -> Result<(), WriteError> {
        // Dropping the writer flushes its buffers to the file, so that must come first.
        drop(self.pieces);
        self.file.sync_all().map_err(|source| WriteError::File { path: self.path, source })
    }
}

impl TableStream {
    pub(super) fn begin(
        schema: &Schema,
        csv: Option<(PathBuf, BufWriter<File>)>,
        parquet: Option<(PathBuf, BufWriter<File>)>,
    ) -> Result<Self, WriteError> {
        let csv = csv.map(|file| Stream::begin(file, |writer| CsvWriter::new(writer).batched(schema)));
        let parquet = parquet.map(|file| Stream::begin(file, |writer| ParquetWriter::new(writer).batched(schema)));
        let waiting = DataFrame::empty_with_schema(schema);
        Ok(Self { waiting, csv: csv.transpose()?, parquet: parquet.transpose()? })
    }

    /// Adds rows.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn add(&mut self, rows: &DataFrame) -> Result<(), WriteError> {
        self.waiting.vstack_mut(rows).expect("checked: pieces of a table have its columns");
        if self.waiting.height() >= GROUP { self.write() } else { Ok(()) }
    }

    fn write(&mut self) -> Result<(), WriteError> {
        let empty = self.waiting.clear();
        let mut rows = std::mem::replace(&mut self.waiting, empty);
        rows.rechunk_mut();
        if let Some(csv) = &mut self.csv {
            failed(&csv.path, csv.pieces.write_batch(&rows))?;
        }
        if let Some(parquet) = &mut self.parquet {
            failed(&parquet.path, parquet.pieces.write_batch(&rows))?;
        }
        Ok(())
    }

    /// Writes the remaining rows, and syncs the whole table to the disk.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(mut self) -> Result<(), WriteError> {
        self.write()?;
        if let Some(mut csv) = self.csv {
            failed(&csv.path, csv.pieces.finish())?;
            csv.settle()?;
        }
        if let Some(parquet) = self.parquet {
            failed(&parquet.path, parquet.pieces.finish())?;
            parquet.settle()?;
        }
        Ok(())
    }
}

fn failed<T>(path: &Path, result: PolarsResult<T>) -> Result<T, WriteError> {
    result.map_err(|error| {
        let source = match error {
            PolarsError::IO { error, .. } => io::Error::new(error.kind(), error.to_string()),
            other => io::Error::other(other.to_string()),
        };
        WriteError::File { path: path.to_path_buf(), source }
    })
}
