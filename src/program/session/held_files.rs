use std::io::{ErrorKind, Result};
use std::path::{Path, PathBuf};

use base::files;
use lang::{Reader, library};
use results::report::{ScenarioFile, StoredReport};

/// Reads the files of a scenario from its report. Files that the report does not hold come from another reader.
pub(super) struct HeldFiles<'a> {
    report: &'a StoredReport,
    /// The files of the manifest, each with the path by which it is asked for.
    files: Vec<(PathBuf, &'a ScenarioFile)>,
    others: &'a dyn Reader,
    /// Whether files of the other reader precede those of the report.
    others_first: bool,
}

impl<'a> HeldFiles<'a> {
    /// The files of a report. `place` maps a path of the manifest to the path by which the file is asked for.
    pub fn new(
        report: &'a StoredReport,
        place: &dyn Fn(&str) -> PathBuf,
        others: &'a dyn Reader,
        others_first: bool,
    ) -> Self {
        let files = report.manifest().files.iter().filter(|file| !library::holds(Path::new(&file.path)));
        Self { report, files: files.map(|file| (place(&file.path), file)).collect(), others, others_first }
    }

    /// A file that neither the report nor the other reader has; `None` if all are there, or the report holds no file at all, since it is
    /// of an earlier version.
    pub fn missing(&self) -> Option<&'a ScenarioFile> {
        let is_gone = |error: &std::io::Error| error.kind() == ErrorKind::NotFound;
        let is_missing = |path: &Path, file: &ScenarioFile| {
            self.report.held(file).is_none() && self.others.bytes(path).is_err_and(|error| is_gone(&error))
        };
        let missing = self.files.iter().find(|(path, file)| self.holds_any() && is_missing(path, file));
        missing.map(|(_, file)| *file)
    }

    fn holds_any(&self) -> bool {
        self.files.iter().any(|(_, file)| self.report.held(file).is_some())
    }

    /// Reads a file from the first place that has it.
    fn read<T>(&self, path: &Path, held: impl Fn(&Path) -> Result<T>, other: impl Fn(&Path) -> Result<T>) -> Result<T> {
        let file = self.files.iter().find(|(place, _)| place == path).map(|(_, file)| *file);
        let inside = file.and_then(|file| self.report.held(file));
        let found = if self.others_first { other(path) } else { Err(ErrorKind::NotFound.into()) };
        match (found, inside) {
            (Err(error), Some(inside)) if error.kind() == ErrorKind::NotFound => held(&inside),
            (Err(error), None) if error.kind() == ErrorKind::NotFound && !self.others_first => {
                // What the run did not read is not there, so that a file beside the original ones changes nothing.
                if file.is_some() || !self.holds_any() { other(path) } else { Err(error) }
            }
            (found, _) => found,
        }
    }
}

impl Reader for HeldFiles<'_> {
    fn text(&self, path: &Path) -> Result<String> {
        self.read(path, files::text, |path| self.others.text(path))
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>> {
        self.read(path, files::bytes, |path| self.others.bytes(path))
    }

    fn identity(&self, path: &Path) -> PathBuf {
        self.others.identity(path)
    }
}
