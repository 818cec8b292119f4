use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;

use super::{Event, Notice, Observer};
use base::files;
use compile::{Training, TrainingKey};
use learn::UpdateLog;
use results::jobs::learning_curve_lines;

/// The learning curves of a campaign in files that grow while it trains, one CSV file a candidate of a training with a row for each update.
///
/// The rows are those that the report will have. They depend on nothing but the scenario and the seed, so a file has the same bytes at any
/// number of threads, and after an interruption the same as without.
pub(super) struct GrowingCurves {
    folder: PathBuf,
    /// The trainings and candidates whose files were begun and can be written to.
    growing: Mutex<BTreeSet<(TrainingKey, u32)>>,
    /// Whether the folder was named.
    named: AtomicBool,
    observer: Arc<dyn Observer>,
}

impl GrowingCurves {
    /// The curves of a folder, which is made with the first of them.
    pub fn new(folder: PathBuf, observer: Arc<dyn Observer>) -> Self {
        Self { folder, growing: Mutex::default(), named: AtomicBool::new(false), observer }
    }

    /// The folder, if this training is the first that has updates to make.
    pub fn first_of(&self, training: &Training, curve: &[UpdateLog]) -> Option<&Path> {
        let done = curve.last().map_or(0, |log| log.steps);
        let first = done < training.config.steps && !self.named.swap(true, Ordering::Relaxed);
        first.then_some(&self.folder)
    }

    /// Starts the file of a candidate of a training with the rows of the updates up to now. Equal rows that are there stay, others are removed.
    pub fn restart(&self, training: &Training, candidate: u32, curve: &[UpdateLog]) {
        let curve_of = (training.key.clone(), candidate);
        let begun = begin(&self.path(&curve_of), &learning_curve_lines(&training.key, curve, true));
        self.growing().insert(curve_of.clone());
        self.note(&curve_of, begun);
    }

    /// Appends the row of the newest update.
    pub fn grow(&self, training: &Training, candidate: u32, curve: &[UpdateLog]) {
        let curve_of = (training.key.clone(), candidate);
        if !self.growing().contains(&curve_of) {
            return;
        }
        let row = learning_curve_lines(&training.key, &curve[curve.len().saturating_sub(1)..], false);
        // The file is opened for each row, so that thousands of trainings have no file open. A row is one write, so a reader sees whole rows.
        let file = File::options().append(true).open(self.path(&curve_of));
        self.note(&curve_of, file.and_then(|mut file| file.write_all(&row)));
    }

    fn path(&self, (key, candidate): &(TrainingKey, u32)) -> PathBuf {
        self.folder.join(format!("{}.csv", curve_name(key, *candidate)))
    }

    /// Reports an error once for each of them.
    fn note(&self, curve_of: &(TrainingKey, u32), written: io::Result<()>) {
        if let Err(source) = written {
            self.growing().remove(curve_of);
            let path = self.path(curve_of);
            let text = format!("the learning curve `{}` cannot be written while it grows: {source}", path.display());
            self.observer.event(&Event::Notice(&Notice::Warning(text)));
        }
    }

    fn growing(&self) -> MutexGuard<'_, BTreeSet<(TrainingKey, u32)>> {
        self.growing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The newest row of a growing learning curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NewestUpdate {
    /// The training, as [`TrainingKey`] shows it.
    pub training: String,
    pub updates: u64,
    /// The number of decisions.
    pub steps: u64,
    /// The number of episodes that have ended.
    pub episodes: u64,
    /// The mean reward of the last episodes; `None` before the first has ended.
    pub mean_reward: Option<f64>,
    /// The share of them that ended in a collision.
    pub collision_rate: Option<f64>,
    /// The share of them that ended in a fault; `None` where the reward asks for no judgement.
    pub fault_rate: Option<f64>,
}

impl NewestUpdate {
    /// Reads the growing learning curve of a training, which it finds by its name in the texts of tasks. `None` without a file or a row.
    pub fn read(folder: &Path, training: &str) -> Option<Self> {
        let mut curves: Vec<PathBuf> = fs::read_dir(folder).ok()?.flatten().map(|curve| curve.path()).collect();
        curves.sort();
        curves
            .iter()
            .filter_map(|curve| Self::of(&files::text(curve).ok()?))
            .rfind(|newest| newest.training == training)
    }

    /// The end of the lines of [`learning_curve_lines`].
    fn of(lines: &str) -> Option<Self> {
        let mut rows = lines.lines().map(|row| row.split(',').collect::<Vec<_>>());
        let head = rows.next()?;
        let place = |column: &str| head.iter().position(|name| *name == column);
        let rows: Vec<_> = rows.filter(|row| row.len() == head.len()).collect();
        let last = rows.last()?;
        let text = |column: &str| Some(last[place(column)?].to_string());
        let whole = |column: &str| last[place(column)?].parse().ok();
        let number = |column: &str| last[place(column)?].parse().ok();
        let key = TrainingKey {
            town: text("train_town")?,
            policy: text("train_driver")?,
            reward: text("reward")?,
            run: last[place("run")?].parse().ok()?,
        };
        let episodes = place("episodes")?;
        Some(Self {
            training: key.to_string(),
            updates: whole("update")?,
            steps: whole("steps")?,
            episodes: rows.iter().filter_map(|row| row[episodes].parse::<u64>().ok()).sum(),
            mean_reward: number("mean_reward"),
            collision_rate: number("collision_rate"),
            fault_rate: number("fault_rate"),
        })
    }
}

/// The name of a curve in files: `r1-harbour-idm-0-1`, that is reward, town, driver, run and candidate; the first candidate has no number.
fn curve_name(key: &TrainingKey, candidate: u32) -> String {
    let first = format!("{}-{}-{}-{}", key.reward, key.town, key.policy, key.run);
    if candidate == 0 { first } else { format!("{first}-{candidate}") }
}

/// Gives a file this content. What is equal at its start is not written again.
fn begin(path: &Path, content: &[u8]) -> io::Result<()> {
    fs::create_dir_all(path.parent().expect("a curve is in a folder"))?;
    let there = match files::bytes(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
        read => read?,
    };
    let mut file = File::options().write(true).create(true).truncate(false).open(path)?;
    let equal = there.iter().zip(content).take_while(|(one, other)| one == other).count();
    file.set_len(equal as u64)?;
    file.seek(SeekFrom::Start(equal as u64))?;
    file.write_all(&content[equal..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_update_is_the_last_whole_row_of_its_training() {
        let key = |run| TrainingKey { town: "harbour".into(), policy: "blind+idm".into(), reward: "r1".into(), run };
        let log = |update, mean_reward| UpdateLog {
            update,
            steps: 50 * update,
            episodes: 3,
            mean_reward,
            success_rate: mean_reward,
            ..UpdateLog::default()
        };
        let folder = tempfile::tempdir().unwrap();
        for (run, curve) in [(0, vec![log(1, None), log(2, Some(0.25))]), (1, vec![log(1, None)]), (2, Vec::new())] {
            let name = folder.path().join(format!("{}.csv", curve_name(&key(run), 0)));
            let mut lines = learning_curve_lines(&key(run), &curve, true);
            // A row that is not whole yet.
            lines.extend_from_slice(b"r1,harb");
            fs::write(name, lines).unwrap();
        }
        let read = |run| NewestUpdate::read(folder.path(), &key(run).to_string());
        let newest = |run, updates, episodes, rate| NewestUpdate {
            training: key(run).to_string(),
            updates,
            steps: 50 * updates,
            episodes,
            mean_reward: rate,
            collision_rate: rate,
            fault_rate: None,
        };
        assert_eq!(read(0), Some(newest(0, 2, 6, Some(0.25))));
        assert_eq!(read(1), Some(newest(1, 1, 3, None)));
        assert_eq!((read(2), read(3)), (None, None));
    }

    #[test]
    fn a_file_keeps_what_is_equal_and_loses_the_rest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a").join("curve.csv");
        let content = || fs::read_to_string(&path).unwrap();
        begin(&path, b"head\n1\n2\n3\n").unwrap();
        begin(&path, b"head\n1\n").unwrap();
        assert_eq!(content(), "head\n1\n");
        begin(&path, b"head\n9\n").unwrap();
        assert_eq!(content(), "head\n9\n");
    }
}
