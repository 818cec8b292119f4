use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use polars::prelude::{DataFrame, PolarsError, Schema};
use polars_io::SerWriter;
use polars_io::csv::write::CsvWriter;
use tempfile::TempDir;

use super::parquet::write_parquet;
use super::scenario_files::SCENARIO;
use super::staging::staging_file;
use super::table_stream::{ErrorRecorder, cause};
use super::{FileRecord, Manifest, TableStream, catalogue};
use crate::jobs::KINDS;
use crate::record::said_rows;
use base::files;

/// The file whose presence marks a folder as a finished report.
pub(super) const MARK: &str = "manifest.toml";
/// The folder of a report with a folder for each program.
pub(super) const PROGRAMS: &str = "programs";
/// The dossier of a report that has one.
pub const DOSSIER: &str = "dossier.html";
/// The folder of the figures, as SVG.
pub const FIGURES: &str = "figures";
/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    #[error("cannot write to the folder `{path}`: {source}", path = path.display())]
    Folder { path: PathBuf, source: io::Error },
    #[error("`{path}` is in the way, which is not part of a report of this program; move it away or choose another folder with --out", path = path.display())]
    Occupied { path: PathBuf },
    #[error("cannot write `{path}`: {source}", path = path.display())]
    File { path: PathBuf, source: io::Error },
    #[error("`{path}` exists already and holds something else; remove it, or choose another folder with --out", path = path.display())]
    Exists { path: PathBuf },
    #[error("cannot make the table `{name}`: {source}")]
    Table { name: String, source: PolarsError },
}

/// A report that is being written. Its files are written to a draft folder, which is moved to the report's place in one step when all are
/// there.
#[derive(Debug)]
pub struct ReportFolder {
    out: PathBuf,
    name: String,
    draft: TempDir,
    formats: Formats,
}

/// The file formats of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Formats {
    /// Comma-separated values.
    pub csv: bool,
    /// Apache Parquet.
    pub parquet: bool,
}

impl ReportFolder {
    /// Starts a report whose place is `out/name`. Its files are written to a folder among `drafts`, which must be on the same file system.
    /// Fails immediately if the report could not be moved to its place.
    ///
    /// # Errors
    /// The folder cannot be written to, or another file or folder is at that place.
    pub fn begin(out: &Path, name: &str, drafts: &Path) -> Result<Self, WriteError> {
        let folder = |source| WriteError::Folder { path: out.to_path_buf(), source };
        fs::create_dir_all(out).map_err(folder)?;
        check_replaceable(&out.join(name))?;
        let draft = tempfile::Builder::new().prefix("report-").tempdir_in(drafts).map_err(folder)?;
        let formats = Formats { csv: true, parquet: true };
        Ok(Self { out: out.to_path_buf(), name: name.to_string(), draft, formats })
    }

    /// Writes tables in these formats only.
    pub fn in_formats(self, formats: Formats) -> Self {
        Self { formats, ..self }
    }

    /// Whether commands that read reports can read this one.
    pub const fn has_parquet(&self) -> bool {
        self.formats.parquet
    }

    /// Adds a file under a path relative to the report.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn file(&self, name: &str, bytes: &[u8]) -> Result<(), WriteError> {
        self.write(name, |writer| writer.write_all(bytes))
    }

    /// Adds a table, in the formats of this report.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn table(&self, name: &str, table: &DataFrame) -> Result<(), WriteError> {
        let mut table = table.clone();
        let failed = |error: PolarsError| io::Error::other(error.to_string());
        if self.formats.csv {
            self.write(&format!("{name}.csv"), |writer| CsvWriter::new(writer).finish(&mut table).map_err(failed))?;
        }
        if self.formats.parquet {
            self.write(&format!("{name}.parquet"), |writer| write_parquet(writer, &table).map_err(failed))?;
        }
        Ok(())
    }

    /// Starts a table that is written part by part, in the formats of this report.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn stream(&self, name: &str, schema: &Schema) -> Result<TableStream, WriteError> {
        let open = |end: &str| -> Result<(PathBuf, ErrorRecorder), WriteError> {
            let path = self.draft.path().join(format!("{name}.{end}"));
            match fs::File::create(&path) {
                Ok(file) => Ok((path, ErrorRecorder::new(file))),
                Err(source) => Err(WriteError::File { path, source }),
            }
        };
        let open = |wanted: bool, end| wanted.then(|| open(end)).transpose();
        TableStream::begin(schema, open(self.formats.csv, "csv")?, open(self.formats.parquet, "parquet")?)
    }

    pub(super) fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut ErrorRecorder) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        let path = self.draft.path().join(name);
        let failed = |source| WriteError::File { path: path.clone(), source };
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(failed)?;
        }
        let mut writer = ErrorRecorder::new(fs::File::create(&path).map_err(failed)?);
        let filled = fill(&mut writer).and_then(|()| writer.flush());
        filled.map_err(|error| failed(cause(&writer.failure(), error)))?;
        writer.clone_file().and_then(|file| file.sync_all()).map_err(failed)
    }

    /// Adds the digests of all other files to the manifest.
    fn seal(&self) -> Result<(), WriteError> {
        let path = self.draft.path().join(MARK);
        let failed = |source| WriteError::File { path: path.clone(), source };
        let text = match files::text(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(failed(error)),
        };
        let mut manifest = Manifest::from_toml(&text).map_err(|reason| failed(io::Error::other(reason)))?;
        manifest.report_files = report_files(self.draft.path()).map_err(failed)?;
        self.file(MARK, sealed(&manifest.to_toml()).as_bytes())
    }

    /// The names of the files that are there, and of the figures in their folder, in order.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn names(&self) -> Result<Vec<String>, WriteError> {
        let draft = self.draft.path();
        let failed = |source| WriteError::Folder { path: draft.to_path_buf(), source };
        let mut names = Vec::new();
        for inner in [Path::new(""), Path::new(FIGURES)].into_iter().filter(|inner| draft.join(inner).exists()) {
            for entry in fs::read_dir(draft.join(inner)).map_err(failed)? {
                names.push(with_slashes(&inner.join(entry.map_err(failed)?.file_name())));
            }
        }
        names.sort();
        Ok(names)
    }

    /// Moves the report to its place, where it replaces an earlier report. An incomplete report has its own place, `name-partial`, so that
    /// it never replaces a complete one. A complete report removes the incomplete one.
    ///
    /// # Errors
    /// The folders cannot be moved.
    pub fn finish(self, complete: bool) -> Result<PathBuf, WriteError> {
        let (whole, partial) = (self.out.join(&self.name), self.out.join(format!("{}-partial", self.name)));
        let place = if complete { &whole } else { &partial };
        self.seal()?;
        Self::swap(self.draft.path(), place)?;
        if complete && partial.exists() && check_replaceable(&partial).is_ok() {
            let _ = fs::remove_dir_all(&partial);
        }
        Ok(place.clone())
    }

    fn swap(draft: &Path, place: &Path) -> Result<(), WriteError> {
        let failed = |source| WriteError::File { path: place.to_path_buf(), source };
        check_replaceable(place)?;
        set_mode(draft, 0o755).map_err(failed)?;
        let old = draft.with_extension("old");
        if place.exists() {
            fs::rename(place, &old).map_err(failed)?;
        }
        if let Err(error) = fs::rename(draft, place) {
            // Restores the earlier report, which is better than none.
            if old.exists() {
                let _ = fs::rename(&old, place);
            }
            return Err(failed(error));
        }
        // The new report is in its place; a remainder of the old one is not worth an error.
        let _ = fs::remove_dir_all(&old);
        Ok(())
    }
}

/// The digests of the files of a report except its manifest, by their paths in it.
pub(super) fn report_files(folder: &Path) -> io::Result<Vec<FileRecord>> {
    let (mut open, mut records) = (vec![PathBuf::new()], Vec::new());
    while let Some(inner) = open.pop() {
        for entry in fs::read_dir(folder.join(&inner))? {
            let entry = entry?;
            let path = inner.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                open.push(path);
            } else if path != Path::new(MARK) {
                // A report has no links, so one is no file that was written, whatever it leads to.
                let is_link = entry.file_type()?.is_symlink();
                let blake3 = if is_link { "a link".into() } else { digest(&folder.join(&path))? };
                let is_table = !is_link && path.extension().is_some_and(|extension| extension == "parquet");
                let rows = if is_table { said_rows(files::open(&folder.join(&path))?) } else { None };
                records.push(FileRecord { blake3, rows, path: with_slashes(&path) });
            }
        }
    }
    records.sort_by(|one, other| one.path.cmp(&other.path));
    Ok(records)
}

fn with_slashes(path: &Path) -> String {
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// What precedes the digest in the last line of a manifest.
const SEAL: &str = "# BLAKE3 of the lines above: ";

/// A manifest with the digest of its lines.
fn sealed(manifest: &str) -> String {
    format!("{manifest}{SEAL}{}\n", blake3::hash(manifest.as_bytes()).to_hex())
}

/// Whether a manifest ends in the digest of its lines.
pub(super) fn is_sealed(text: &str) -> bool {
    text.rfind(SEAL).is_some_and(|end| sealed(&text[..end]) == text)
}

/// BLAKE3 of a file, which need not fit in memory.
pub(super) fn digest(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(files::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Writes a file whole, as [`write_file`] does, and replaces none with other contents.
///
/// # Errors
/// The file cannot be written, or there is one with other contents.
pub fn write_new_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    match fs::read(path) {
        Ok(known) if known == bytes => Ok(()),
        Ok(_) if path.is_file() => Err(WriteError::Exists { path: path.to_path_buf() }),
        _ => write_file(path, bytes),
    }
}

/// Writes a single file; it appears whole or not at all. A device or a pipe is written to, not replaced. A link to a file is refused: it may
/// lead out of the folder that was named, and to replace it would leave the file behind it as it was.
///
/// # Errors
/// The file cannot be written, or it is a link.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let failed = |source| WriteError::File { path: path.to_path_buf(), source };
    if fs::metadata(path).is_ok_and(|known| !known.is_file() && !known.is_dir()) {
        let mut stream = fs::OpenOptions::new().write(true).open(path).map_err(failed)?;
        return stream.write_all(bytes).map_err(failed);
    }
    if path.is_symlink() {
        let to = fs::read_link(path).map_err(failed)?;
        let reason = format!("it is a link to `{}`; name that file, or remove the link", to.display());
        return Err(failed(io::Error::new(io::ErrorKind::AlreadyExists, reason)));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if let Some(report) = report_of(path, folder) {
        let reason = format!("it is a file of the report `{}`; choose another name", report.display());
        return Err(failed(io::Error::new(io::ErrorKind::AlreadyExists, reason)));
    }
    if folder.exists() && !folder.is_dir() {
        let reason = format!("`{}` is not a folder", folder.display());
        return Err(failed(io::Error::new(io::ErrorKind::NotADirectory, reason)));
    }
    fs::create_dir_all(folder).map_err(failed)?;
    let mut draft = staging_file(folder).map_err(failed)?;
    draft.write_all(bytes).map_err(failed)?;
    set_mode(draft.path(), 0o644).map_err(failed)?;
    draft.persist(path).map(|_| ()).map_err(|error| failed(error.error))
}

/// The report whose file a path in this folder is, by the manifest beside it or one folder above.
fn report_of(path: &Path, folder: &Path) -> Option<PathBuf> {
    let inner = Path::new(folder.file_name().unwrap_or_default()).join(path.file_name()?);
    let places = [(folder, PathBuf::from(path.file_name()?)), (folder.parent()?, inner)];
    let listed = |(report, file): &(&Path, PathBuf)| {
        let manifest = fs::read_to_string(report.join(MARK)).ok().and_then(|text| Manifest::from_toml(&text).ok());
        let is_it = |name: &str| Path::new(name) == file;
        manifest.is_some_and(|manifest| is_it(MARK) || manifest.report_files.iter().any(|each| is_it(&each.path)))
    };
    places.into_iter().find(listed).map(|(report, _)| report.to_path_buf())
}

/// Writes a single table as CSV.
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

/// Writes a single table, as Parquet if its name ends in `.parquet`, else as CSV.
///
/// # Errors
/// The file cannot be written.
pub fn write_table(path: &Path, table: &DataFrame) -> Result<(), WriteError> {
    if path.extension().is_none_or(|extension| extension != "parquet") {
        return write_csv(path, table);
    }
    let (mut bytes, name) = (Vec::new(), path.display().to_string());
    write_parquet(&mut bytes, table).map_err(|source| WriteError::Table { name, source })?;
    write_file(path, &bytes)
}

/// Checks that a place holds no other data: it is empty, or holds a report and nothing else.
fn check_replaceable(place: &Path) -> Result<(), WriteError> {
    let Ok(kind) = fs::symlink_metadata(place) else { return Ok(()) };
    let occupied = |path: &Path| Err(WriteError::Occupied { path: path.to_path_buf() });
    if !kind.is_dir() {
        return occupied(place);
    }
    let failed = |source| WriteError::Folder { path: place.to_path_buf(), source };
    let mut entries = fs::read_dir(place).map_err(failed)?.collect::<Result<Vec<_>, _>>().map_err(failed)?;
    entries.sort_by_key(fs::DirEntry::file_name);
    match entries.iter().find(|entry| !is_ours(&entry.file_name().to_string_lossy())) {
        Some(foreign) => occupied(&foreign.path()),
        None if entries.is_empty() || place.join(MARK).is_file() => Ok(()),
        None => occupied(place),
    }
}

/// Whether a report has a file or folder of this name.
fn is_ours(name: &str) -> bool {
    let (stem, extension) = name.split_once('.').unwrap_or((name, ""));
    match extension {
        "csv" | "parquet" => catalogue().iter().any(|table| table.name == stem),
        _ => {
            let mut folders = KINDS.iter().flat_map(|kind| kind.folders);
            [MARK, "summary.md", "report.html", DOSSIER, SCENARIO, PROGRAMS, FIGURES].contains(&name)
                || folders.any(|folder| *folder == name)
        }
    }
}

/// Temporary files are for their owner alone. A report is for all who may read its parent.
#[cfg(unix)]
fn set_mode(path: &Path, mode: u32) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(mode))
}

#[cfg(not(unix))]
fn set_mode(_: &Path, _: u32) -> io::Result<()> {
    Ok(())
}
