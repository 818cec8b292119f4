use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use super::growing_curves::training_name;
use super::{Event, Notice, Observer};
use compile::{Training, TrainingKey};
use learn::{UpdateLog, event_file_start, event_of_update};

/// Ends the names of our event files, which are replaced when a training continues.
const SUFFIX: &str = ".falsify";

/// Event files for TensorBoard, a folder for each training. They hold the time at which a row was written.
pub(super) struct EventFiles {
    folder: PathBuf,
    observer: Arc<dyn Observer>,
}

impl EventFiles {
    /// The files of a campaign in a folder, which is made with the first of them.
    pub fn new(folder: PathBuf, observer: Arc<dyn Observer>) -> Self {
        Self { folder, observer }
    }

    /// Starts the file of a training with the updates up to now, in place of the file of an earlier run.
    pub fn restart(&self, training: &Training, curve: &[UpdateLog]) {
        let folder = self.folder.join(training_name(&training.key));
        let now = now();
        let updates = curve.iter().flat_map(|log| event_of_update(log, now));
        let content: Vec<u8> = event_file_start(now).into_iter().chain(updates).collect();
        let begun = fs::create_dir_all(&folder).and_then(|()| remove_ours(&folder)).and_then(|()| {
            // TensorBoard takes the files of a folder in the order of their names.
            fs::write(folder.join(format!("events.out.tfevents.{:010}{SUFFIX}", now as u64)), content)
        });
        self.note(&training.key, begun);
    }

    /// Appends the newest update.
    pub fn grow(&self, training: &Training, curve: &[UpdateLog]) {
        let Some(log) = curve.last() else { return };
        let folder = self.folder.join(training_name(&training.key));
        let Some(path) = ours(&folder).ok().and_then(|files| files.into_iter().next()) else { return };
        let file = File::options().append(true).open(path);
        self.note(&training.key, file.and_then(|mut file| file.write_all(&event_of_update(log, now()))));
    }

    fn note(&self, key: &TrainingKey, written: io::Result<()>) {
        if let Err(source) = written {
            let path = self.folder.join(training_name(key));
            self.observer.event(&Event::Notice(&Notice::LearningCurve { path, source }));
        }
    }
}

/// Seconds since 1970.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

/// Our event files in a folder.
fn ours(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let paths = fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<Vec<_>>>()?;
    let is_ours = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("events.out.tfevents.") && name.ends_with(SUFFIX)
    };
    Ok(paths.into_iter().filter(is_ours).collect())
}

fn remove_ours(folder: &Path) -> io::Result<()> {
    ours(folder)?.into_iter().try_for_each(fs::remove_file)
}
