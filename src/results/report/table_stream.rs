use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use polars::prelude::{DataFrame, PolarsError, PolarsResult, Schema};
use polars_io::SerWriter;
use polars_io::csv::write::{BatchedWriter as CsvPieces, CsvWriter};

use super::WriteError;
use super::parquet::ParquetFile;

/// A file that remembers why it could not be written. Polars has other words for that, such as "transport error".
pub(super) struct ErrorRecorder {
    writer: BufWriter<File>,
    failure: Failure,
}

/// Why a file could not be written.
pub(super) type Failure = Arc<Mutex<Option<io::Error>>>;

impl ErrorRecorder {
    /// Writes to a file.
    pub fn new(file: File) -> Self {
        Self { writer: BufWriter::new(file), failure: Arc::default() }
    }

    /// Where the failure will be found.
    pub fn failure(&self) -> Failure {
        self.failure.clone()
    }

    /// The file once more.
    pub fn clone_file(&self) -> io::Result<File> {
        self.writer.get_ref().try_clone()
    }

    fn noted<T>(&self, result: io::Result<T>) -> io::Result<T> {
        result.inspect_err(|error| {
            let same = error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error);
            self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(same);
        })
    }
}

impl Write for ErrorRecorder {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.writer.write(bytes);
        self.noted(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = self.writer.flush();
        self.noted(flushed)
    }
}

/// The error of a file: the system's if there is one, else that of the library.
pub(super) fn cause(failure: &Failure, other: io::Error) -> io::Error {
    failure.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or(other)
}

/// Number of rows that are written at once; in Parquet they are a row group.
const GROUP: usize = 1 << 16;

/// A table that is written part by part, as CSV, as Parquet or both, so that it need not fit in memory.
pub struct TableStream {
    waiting: DataFrame,
    csv: Option<Stream<CsvPieces<ErrorRecorder>>>,
    parquet: Option<Stream<ParquetFile<ErrorRecorder>>>,
}

/// A file in one of the formats.
struct Stream<W> {
    path: PathBuf,
    failure: Failure,
    pieces: W,
    /// The file once more, for the sync at the end.
    file: File,
}

impl<W> Stream<W> {
    fn begin(
        (path, writer): (PathBuf, ErrorRecorder),
        begin: impl FnOnce(ErrorRecorder) -> PolarsResult<W>,
    ) -> Result<Self, WriteError> {
        let file = writer.clone_file().map_err(|source| WriteError::File { path: path.clone(), source })?;
        let failure = writer.failure();
        let pieces = begin(writer).map_err(|error| failed(&path, &failure, error))?;
        Ok(Self { path, failure, pieces, file })
    }

    /// Passes the pieces on, with the path and the cause of an error.
    fn write<T>(&mut self, write: impl FnOnce(&mut W) -> PolarsResult<T>) -> Result<T, WriteError> {
        write(&mut self.pieces).map_err(|error| failed(&self.path, &self.failure, error))
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
        csv: Option<(PathBuf, ErrorRecorder)>,
        parquet: Option<(PathBuf, ErrorRecorder)>,
    ) -> Result<Self, WriteError> {
        let csv = csv.map(|file| Stream::begin(file, |writer| CsvWriter::new(writer).batched(schema)));
        let parquet = parquet.map(|file| Stream::begin(file, |writer| ParquetFile::new(writer, schema)));
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
            csv.write(|pieces| pieces.write_batch(&rows))?;
        }
        if let Some(parquet) = &mut self.parquet {
            parquet.write(|file| file.add(&rows))?;
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
            csv.write(CsvPieces::finish)?;
            csv.settle()?;
        }
        if let Some(mut parquet) = self.parquet {
            parquet.write(ParquetFile::finish)?;
            parquet.settle()?;
        }
        Ok(())
    }
}

fn failed(path: &Path, failure: &Failure, error: PolarsError) -> WriteError {
    WriteError::File { path: path.to_path_buf(), source: cause(failure, io::Error::other(error.to_string())) }
}
