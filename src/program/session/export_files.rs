use std::path::{Path, PathBuf};

use super::stored::Source;
use super::{EpisodeName, EpisodePath, Error, RepeatOptions, Repeated, Session};
use export::{Episode, Exporter, Variant};
use results::report;

/// Options of [`Session::export_files`].
#[derive(Clone)]
pub struct ExportOptions {
    pub episodes: Vec<EpisodePath>,
    /// A report, or a folder of reports, for episodes that do not name one.
    pub report: PathBuf,
    /// Options of the repetition. With `anyway` an episode that differs from its report is exported, too.
    pub repeat: RepeatOptions,
    /// The format.
    pub exporter: &'static dyn Exporter,
    /// The parts of the episode that are repeated.
    pub variant: Variant,
    /// The folder for the files; it is created.
    pub out: PathBuf,
}

/// An episode that was exported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exported {
    pub name: EpisodeName,
    /// The files, the one to open first.
    pub files: Vec<PathBuf>,
}

impl Session {
    /// Repeats episodes of reports and writes each in a format of another program. An episode that fails does not prevent the next one;
    /// `each` hears of every episode as soon as it is done.
    pub fn export_files(&self, options: &ExportOptions, each: &mut dyn FnMut(Result<Exported, Error>)) {
        let mut open: Option<Source> = None;
        for episode in &options.episodes {
            if self.stop.is_asked() {
                return;
            }
            each(self.export_one(options, episode, &mut open));
        }
    }

    /// Exports an episode. The campaign of the last episode stays compiled, since lists have many of one report.
    fn export_one(
        &self,
        options: &ExportOptions,
        EpisodePath { report, name }: &EpisodePath,
        open: &mut Option<Source>,
    ) -> Result<Exported, Error> {
        let same = |source: &Source| {
            let here = report.as_ref().is_none_or(|report| report == source.report.folder());
            here && (source.evaluation(*name).is_some() || source.search(*name).is_some())
        };
        let source = match open.take().filter(same) {
            Some(source) => source,
            None => {
                let found = self.find(report.as_ref().unwrap_or(&options.report), *name)?;
                found.check_for_repetition()?;
                self.reopen(found, &options.repeat)?
            }
        };
        let repeated = source.repeat(*name);
        *open = Some(source);
        let repeated = repeated?;
        if !repeated.differences.is_empty() && !options.repeat.anyway {
            let columns: Vec<&str> = repeated.differences.iter().map(|each| each.column.as_str()).collect();
            return Err(Error::Differs(format!(
                "{name} differs from its report in {}, so it is not exported; `falsify replay {name}` shows where, and --anyway exports it all the same",
                columns.join(", ")
            )));
        }
        let files = export_repeated(&repeated, options)?;
        Ok(Exported { name: *name, files })
    }
}

fn export_repeated(repeated: &Repeated, options: &ExportOptions) -> Result<Vec<PathBuf>, Error> {
    let name = repeated.name.to_string();
    let episode = Episode {
        name: &name,
        title: &repeated.title,
        scenario: &repeated.scenario,
        trace: &repeated.trace,
        outcome: &repeated.outcome,
        verdict: repeated.verdict.as_ref(),
    };
    let files = export::export(options.exporter, &episode, options.variant)
        .map_err(|source| Error::Export { name: repeated.name, source })?;
    let write = |file: &export::ExportFile| {
        let path = path(&options.out, &file.name);
        report::write_new_file(&path, &file.bytes)?;
        Ok(path)
    };
    files.iter().map(write).collect()
}

/// A file of the folder; in the current folder its name alone.
fn path(folder: &Path, name: &str) -> PathBuf {
    if folder == Path::new(".") { PathBuf::from(name) } else { folder.join(name) }
}
