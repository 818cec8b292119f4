use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use polars::prelude::{DataFrame, PolarsError};
use polars_io::SerWriter;
use polars_io::csv::write::CsvWriter;
use polars_io::parquet::write::ParquetWriter;
use tempfile::TempDir;

/// The file whose presence marks a folder as a finished report.
const MARK: &str = "manifest.toml";

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder for reports cannot be made or written to.
    #[error("cannot write to the folder `{path}`: {source}", path = path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Something else stands where the report is to go.
    #[error("`{path}` holds files that are no report of this program; move it away or choose another folder with --out", path = path.display())]
    Occupied {
        /// The place.
        path: PathBuf,
    },
    /// A file cannot be written.
    #[error("cannot write `{path}`: {source}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A table cannot be made.
    #[error("cannot make the table `{name}`: {source}")]
    Table {
        /// The table.
        name: String,
        /// Why.
        source: PolarsError,
    },
}

/// A report in the making: files gather beside the place where it is to stand, and take it in one step when all are there.
#[derive(Debug)]
pub struct ReportFolder {
    place: PathBuf,
    draft: TempDir,
}

impl ReportFolder {
    /// Begins a report that is to stand at `out/name`. Fails at once when it never could.
    ///
    /// # Errors
    /// The folder cannot be written to, or something else stands there.
    pub fn begin(out: &Path, name: &str) -> Result<Self, WriteError> {
        let folder = |source| WriteError::Folder { path: out.to_path_buf(), source };
        fs::create_dir_all(out).map_err(folder)?;
        let place = out.join(name);
        if place.exists() && !is_report(&place) {
            return Err(WriteError::Occupied { path: place });
        }
        let draft = tempfile::Builder::new().prefix(&format!(".{name}-")).tempdir_in(out).map_err(folder)?;
        Ok(Self { place, draft })
    }

    /// Where the report will stand.
    pub fn place(&self) -> &Path {
        &self.place
    }

    /// Adds a file under a path relative to the report.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn file(&self, name: &str, bytes: &[u8]) -> Result<(), WriteError> {
        self.write(name, |writer| writer.write_all(bytes))
    }

    /// Adds a table as CSV and as Parquet.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn table(&self, name: &str, table: &DataFrame) -> Result<(), WriteError> {
        let mut table = table.clone();
        let failed = |error: PolarsError| io::Error::other(error.to_string());
        self.write(&format!("{name}.csv"), |writer| CsvWriter::new(writer).finish(&mut table).map_err(failed))?;
        self.write(&format!("{name}.parquet"), |writer| {
            ParquetWriter::new(writer).finish(&mut table).map(|_| ()).map_err(failed)
        })
    }

    fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut BufWriter<fs::File>) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        let path = self.draft.path().join(name);
        let failed = |source| WriteError::File { path: path.clone(), source };
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(failed)?;
        }
        let mut writer = BufWriter::new(fs::File::create(&path).map_err(failed)?);
        fill(&mut writer).map_err(failed)?;
        let file = writer.into_inner().map_err(|error| failed(error.into_error()))?;
        file.sync_all().map_err(failed)
    }

    /// Puts the report in its place; an earlier report there gives way.
    ///
    /// # Errors
    /// The folders cannot be moved. The files then stay where they were gathered.
    pub fn finish(self) -> Result<PathBuf, WriteError> {
        let Self { place, draft } = self;
        let draft = draft.keep();
        let failed = |source| WriteError::File { path: place.clone(), source };
        set_mode(&draft, 0o755).map_err(failed)?;
        let old = draft.with_extension("old");
        if place.exists() {
            if !is_report(&place) {
                return Err(WriteError::Occupied { path: place });
            }
            fs::rename(&place, &old).map_err(failed)?;
        }
        if let Err(error) = fs::rename(&draft, &place) {
            // The earlier report is better than none.
            if old.exists() {
                let _ = fs::rename(&old, &place);
            }
            return Err(failed(error));
        }
        if old.exists() {
            fs::remove_dir_all(&old).map_err(failed)?;
        }
        Ok(place)
    }
}

/// Writes a file that stands alone; it appears whole or not at all.
///
/// # Errors
/// The file cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let failed = |source| WriteError::File { path: path.to_path_buf(), source };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(failed)?;
    let mut draft = tempfile::NamedTempFile::new_in(folder).map_err(failed)?;
    draft.write_all(bytes).map_err(failed)?;
    set_mode(draft.path(), 0o644).map_err(failed)?;
    draft.persist(path).map(|_| ()).map_err(|error| failed(error.error))
}

/// Writes a table that stands alone as CSV.
///
/// # Errors
/// The file cannot be written.
pub fn write_csv(path: &Path, table: &DataFrame) -> Result<(), WriteError> {
    let mut bytes = Vec::new();
    let name = || path.display().to_string();
    CsvWriter::new(&mut bytes)
        .finish(&mut table.clone())
        .map_err(|source| WriteError::Table { name: name(), source })?;
    write_file(path, &bytes)
}

fn is_report(place: &Path) -> bool {
    place.join(MARK).is_file() || fs::read_dir(place).is_ok_and(|mut entries| entries.next().is_none())
}

/// What is made as temporary is for its owner alone; a report is for everyone who may read its parent.
#[cfg(unix)]
fn set_mode(path: &Path, mode: u32) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(mode))
}

#[cfg(not(unix))]
fn set_mode(_: &Path, _: u32) -> io::Result<()> {
    Ok(())
}
