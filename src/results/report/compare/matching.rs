use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use crate::record::RunKey;
use crate::report::read::StoredRun;
use crate::report::{ReadError, StoredReport};

/// One side of a comparison: a report, or one driver, or one simulator, of it.
#[derive(Debug, Clone, Copy)]
pub struct Side<'a> {
    pub report: &'a StoredReport,
    /// The driver; all of them without it.
    pub driver: Option<&'a str>,
    /// The simulator; all of them without it.
    pub world: Option<&'a str>,
}

/// Why two sides cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum Incomparable {
    /// A table cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error("`{report}` has no evaluated episodes {of} `{name}`; it has {}", if known.is_empty() { "none at all".into() } else { known.join(", ") }, report = report.display())]
    NoSuch {
        report: PathBuf,
        /// `of a driver`, or `in a simulator`.
        of: &'static str,
        name: String,
        known: Vec<String>,
    },
    #[error(
        "nothing can be compared: `{}` has no evaluated episodes, and none of its searches has the method, town, budget, run and seed of one of the other report",
        report.display()
    )]
    NoEpisode { report: PathBuf },
    #[error(
        "nothing can be compared: no run of `{}` has the place, pedestrian and driver of a run of `{}`\n  the first has, for example: {}\n  the second: {}",
        folders.0.display(), folders.1.display(), examples.0, examples.1
    )]
    NoRun { folders: (PathBuf, PathBuf), examples: (String, String) },
    #[error("nothing can be compared: no episode of one side has the start of an episode of the other{}", because.as_ref().map_or(String::new(), |reason| format!(", since {reason}")))]
    NoStart { because: Option<String> },
}

/// What has the same key on both sides: runs with the same place, controller and number.
pub(super) struct Matched<T> {
    pub pairs: Vec<[T; 2]>,
    /// The numbers of those without a partner.
    pub unmatched: [usize; 2],
}

/// Finds the runs of both sides that belong together.
pub(super) fn matched(before: Side<'_>, after: Side<'_>) -> Result<Matched<StoredRun>, Incomparable> {
    let one_report = before.report.folder() == after.report.folder();
    let (first, second) = (before.runs()?, after.runs()?);
    if let Some((side, _)) = [(before, &first), (after, &second)].into_iter().find(|(_, runs)| runs.is_empty()) {
        return Err(Incomparable::NoEpisode { report: side.report.folder().to_path_buf() });
    }
    let renamed = is_renamed(&first, &second, |run| &run.key.cell.policy);
    let moved = is_renamed(&first, &second, |run| &run.key.cell.world);
    let example = |runs: &[StoredRun]| runs.first().map_or(String::new(), |run| run.key.to_string());
    let names = |run: &StoredRun| names(&run.key, (renamed, moved), one_report);
    let last = second.iter().min_by_key(|run| names(run)).map_or(String::new(), |run| run.key.to_string());
    let examples = (example(&first), last);
    let found = paired(first, second, names);
    if found.pairs.is_empty() {
        let folders = (before.report.folder().to_path_buf(), after.report.folder().to_path_buf());
        return Err(Incomparable::NoRun { folders, examples });
    }
    Ok(found)
}

/// The drivers of one side of which no run has a partner, and those of the other. A driver of a single one on either side is not alone.
pub(super) fn lone_drivers(before: Side<'_>, after: Side<'_>) -> Result<[Vec<String>; 2], Incomparable> {
    let (first, second) = (before.runs()?, after.runs()?);
    if is_renamed(&first, &second, |run| &run.key.cell.policy) {
        return Ok(Default::default());
    }
    let drivers = |runs: &[StoredRun]| runs.iter().map(|run| run.key.cell.policy.clone()).collect::<BTreeSet<_>>();
    let (named, other) = (drivers(&first), drivers(&second));
    Ok([named.difference(&other).cloned().collect(), other.difference(&named).cloned().collect()])
}

/// Whether each side has one driver, or one simulator, and they differ: it is the same one under two names, or two that the user compares.
pub(super) fn is_renamed<T>(first: &[T], second: &[T], driver: impl Fn(&T) -> &String) -> bool {
    let drivers = |all: &[T]| all.iter().map(|each| driver(each).clone()).collect::<BTreeSet<_>>();
    let (named, other) = (drivers(first), drivers(second));
    named != other && named.len() == 1 && other.len() == 1
}

/// Pairs what has the same key on both sides. Of several with one key on a side the first counts.
pub(super) fn paired<T, K: Ord>(first: Vec<T>, second: Vec<T>, key: impl Fn(&T) -> K) -> Matched<T> {
    let mut partners: BTreeMap<K, T> = BTreeMap::new();
    for each in second {
        partners.entry(key(&each)).or_insert(each);
    }
    let (mut pairs, mut seen, mut alone) = (Vec::new(), BTreeSet::new(), 0);
    for each in first {
        if !seen.insert(key(&each)) {
            continue;
        }
        match partners.remove(&key(&each)) {
            Some(partner) => pairs.push([each, partner]),
            None => alone += 1,
        }
    }
    Matched { pairs, unmatched: [alone, partners.len()] }
}

/// What two runs that belong together have in common. An untrained controller is the same for all rewards.
fn names(key: &RunKey, (renamed, moved): (bool, bool), one_report: bool) -> String {
    let cell = &key.cell;
    let policy: &str = if renamed { "" } else { &cell.policy };
    // In two reports a renamed driver has pedestrians that were trained against it; in one report the pedestrian must be the same.
    let own = renamed && !one_report && cell.train_policy == cell.policy;
    let train_policy: &str = if own { "" } else { &cell.train_policy };
    let reward: &str = if cell.is_of_reward() { &cell.reward } else { "" };
    let words: [&str; 9] = [
        &cell.town,
        policy,
        &cell.vehicle,
        &cell.adversary,
        if moved { "" } else { &cell.world },
        &cell.controller,
        reward,
        &cell.train_town,
        train_policy,
    ];
    format!("{}\0{}\0{}", words.join("\0"), cell.block, key.run)
}

impl Side<'_> {
    fn runs(&self) -> Result<Vec<StoredRun>, Incomparable> {
        let mut runs = self.report.run_rows()?;
        let driver = |run: &StoredRun| run.key.cell.policy.clone();
        let world = |run: &StoredRun| run.key.cell.simulator().to_string();
        type NameOf<'f> = &'f dyn Fn(&StoredRun) -> String;
        let chosen: [(Option<&str>, &str, NameOf<'_>); 2] =
            [(self.driver, "of a driver", &driver), (self.world, "in a simulator", &world)];
        for (name, of, name_of) in chosen {
            let Some(name) = name else { continue };
            let known: BTreeSet<String> = runs.iter().map(name_of).collect();
            runs.retain(|run| name_of(run) == name);
            if runs.is_empty() {
                let (report, name) = (self.report.folder().to_path_buf(), name.to_string());
                return Err(Incomparable::NoSuch { report, of, name, known: known.into_iter().collect() });
            }
        }
        Ok(runs)
    }
}
