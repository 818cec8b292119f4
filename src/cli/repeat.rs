//! A report → the same plan again → an episode of it, and whether it is the same.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::args::GivenOptions;
use super::repeat_args::{Name, NameOptions, RepeatOptions};
use super::{ExitCode, front};
use crate::campaign::{self, SearchResult, watch};
use crate::compile::{Campaign, Evaluation, Pedestrian, Search};
use crate::env::{Outcome, Scenario, Trace};
use crate::falsifier::{Failure, Spent, follow};
use crate::judge::{NearMiss, Verdict, judge};
use crate::record::{self, EpisodeRow, RunKey};
use crate::report::{self, Difference, FileRecord, Manifest, ReadError, StoredReport};
use crate::rl::ActorCritic;
use crate::seed::Seed;
use crate::store::{CODE, vector_instructions};

/// A report with the campaign that it came from, compiled again.
pub struct Source {
    /// The report.
    pub report: StoredReport,
    /// The campaign.
    pub campaign: Campaign,
    /// The user's seed.
    pub seed: Seed,
}

/// An episode that was repeated.
pub struct Repeated {
    /// Its name.
    pub name: Name,
    /// Who was tried where, in words.
    pub title: String,
    /// What it was tried in.
    pub scenario: Arc<Scenario>,
    /// What became of it now.
    pub outcome: Outcome,
    /// What happened in it now.
    pub trace: Trace,
    /// What reference drivers make of it.
    pub verdict: Option<Verdict>,
    /// The cells of its row that came out differently.
    pub differences: Vec<Difference>,
    /// Where it parted from the stored one, in words, when it did.
    pub parting: Option<String>,
}

/// Prints why a report cannot be read.
pub fn unreadable(error: &ReadError) -> ExitCode {
    front::fail(&error.to_string());
    ExitCode::Usage
}

/// Finds the report that holds an episode; complete ones go before partial ones and trials of the machinery.
pub fn find(options: &NameOptions) -> Result<StoredReport, ExitCode> {
    let (name, place) = (options.name, options.report.display());
    let folders = StoredReport::find(&options.report);
    if folders.is_empty() {
        front::fail(&format!("there is no report in `{place}`; say where with --report"));
        return Err(ExitCode::Usage);
    }
    let mut holding = Vec::new();
    for folder in &folders {
        let report = match StoredReport::open(folder) {
            Ok(report) => report,
            Err(error) if folders.len() == 1 => return Err(unreadable(&error)),
            Err(error) => {
                front::warn(&error.to_string());
                continue;
            }
        };
        if report.holds(name.run).map_err(|error| unreadable(&error))? {
            holding.push(report);
        }
    }
    holding.sort_by_key(|report| (report.manifest().smoke, !report.manifest().complete));
    if holding.is_empty() {
        front::fail(&format!("no report in `{place}` has a run `{}`; say where with --report", name.run));
        return Err(ExitCode::Usage);
    }
    Ok(holding.swap_remove(0))
}

/// Compiles the campaign of a report again, from the files and settings that its manifest names.
pub fn open(report: StoredReport, options: &RepeatOptions) -> Result<Source, ExitCode> {
    let manifest = report.manifest();
    let call = &manifest.call;
    if manifest.version != env!("CARGO_PKG_VERSION") {
        front::warn(&format!(
            "the report is of version {}, this is {}; episodes may come out differently",
            manifest.version,
            env!("CARGO_PKG_VERSION")
        ));
    }
    let root = root(options, Path::new(&call.folder));
    let place = |path: &str| root.as_ref().map_or_else(|| PathBuf::from(path), |root| root.join(path));
    let maps = call.maps.iter().filter_map(|map| map.split_once('='));
    let given = GivenOptions {
        map: maps.map(|(town, file)| (town.to_string(), place(file))).collect(),
        set: call.set.clone(),
        allow_external: options.allow_external,
    };
    if call.allow_external && !options.allow_external {
        front::warn("scenarios might start programs in that run; give --allow-external if they may again");
    }
    let files: Vec<PathBuf> = call.scenarios.iter().map(|path| place(path)).collect();
    let (plan, records) = front::compile_files(&files, &given)?;
    let changed = changed(manifest, &records, root.as_deref());
    if !changed.is_empty() {
        let say = if options.anyway { front::warn } else { front::fail };
        changed.iter().for_each(|change| say(change));
        if !options.anyway {
            front::fail("so this is not what was run; --anyway goes on nevertheless");
            return Err(ExitCode::Differs);
        }
    }
    let Some(mut campaign) = plan.campaigns.into_iter().find(|campaign| campaign.name == manifest.campaign) else {
        front::fail(&format!("the files hold no campaign `{}` any more", manifest.campaign));
        return Err(ExitCode::Differs);
    };
    if manifest.smoke {
        campaign::smoke(&mut campaign);
    }
    let seed = Seed::root(manifest.seed);
    Ok(Source { report, campaign, seed })
}

/// The folder that paths are relative to; none for this one.
fn root(options: &RepeatOptions, recorded: &Path) -> Option<PathBuf> {
    match &options.files {
        Some(folder) => Some(folder.clone()),
        None if std::env::current_dir().is_ok_and(|here| here == recorded) => None,
        None => Some(recorded.to_path_buf()).filter(|folder| folder.is_dir()),
    }
}

/// What is not as it was when the report was made, in words.
fn changed(manifest: &Manifest, now: &[FileRecord], root: Option<&Path>) -> Vec<String> {
    let mut changed = Vec::new();
    let place = |path: &str| root.map_or_else(|| path.to_string(), |root| root.join(path).display().to_string());
    let known = |path: &str| manifest.files.iter().any(|file| file.path == path || place(&file.path) == path);
    for file in &manifest.files {
        let path = place(&file.path);
        match now.iter().find(|record| record.path == path || record.path == file.path) {
            None => changed.push(format!("`{path}` was read then, and is not now")),
            Some(record) if record.blake3 != file.blake3 => changed.push(format!(
                "`{path}` has changed since then: its hash was {}…, and is {}…",
                &file.blake3.get(..12).unwrap_or_default(),
                &record.blake3[..12]
            )),
            Some(_) => {}
        }
    }
    changed.extend(
        now.iter().filter(|file| !known(&file.path)).map(|file| format!("`{}` is read now, and was not", file.path)),
    );
    changed
}

impl Source {
    /// The evaluation of this name, and its place.
    pub fn evaluation(&self, name: Name) -> Option<(usize, &Evaluation)> {
        self.campaign.evaluations.iter().enumerate().find(|(_, evaluation)| evaluation.id == name.run)
    }

    /// The search of this name.
    pub fn search(&self, name: Name) -> Option<&Search> {
        self.campaign.searches.iter().find(|search| search.key.id == name.run)
    }

    /// The pedestrian of an evaluation, as the report has it; none for untrained ones.
    ///
    /// # Errors
    /// Its file cannot be read.
    pub fn trained(&self, evaluation: &Evaluation) -> Result<Option<ActorCritic>, ReadError> {
        match evaluation.pedestrian {
            Pedestrian::Trained(_) | Pedestrian::Sampled(_) => self.report.pedestrian(&evaluation.trained).map(Some),
            _ => Ok(None),
        }
    }

    /// Repeats an episode and compares it with the report.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn repeat(&self, name: Name) -> Result<Repeated, ExitCode> {
        if let Some((place, evaluation)) = self.evaluation(name) {
            return self.repeat_episode(name, place, evaluation);
        }
        match self.search(name) {
            Some(search) => self.repeat_failure(name, search),
            None => {
                front::fail(&format!("the campaign `{}` has no run `{}` any more", self.campaign.name, name.run));
                Err(ExitCode::Differs)
            }
        }
    }

    fn repeat_episode(&self, name: Name, place: usize, evaluation: &Evaluation) -> Result<Repeated, ExitCode> {
        let before: usize = self.campaign.evaluations[..place].iter().map(|other| other.episodes as usize).sum();
        let guess = before + name.number as usize;
        let stored = self.report.episode(name.run, name.number, guess).map_err(|error| unreadable(&error))?;
        let Some(stored) = stored else { return Err(self.missing(name, "episode")) };
        let trained = self.trained(evaluation).map_err(|error| unreadable(&error))?;
        let note = &mut |outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
        let (episodes, go_on) = (name.number..name.number + 1, &mut |_| ControlFlow::Continue(()));
        let seen = watch(evaluation, trained.as_ref(), episodes, &self.seed, note, go_on);
        let (outcome, trace) = seen.into_iter().next().expect("an episode that is tried comes to an end");
        let pair = trace.main_pair(&evaluation.scenario);
        let (verdict, near_miss) = (judge(&pair), NearMiss::new(&pair));
        let again = record::episodes(&[EpisodeRow {
            key: RunKey::of(evaluation).into(),
            episode: name.number,
            outcome,
            verdict,
            near_miss,
        }]);
        let scenario = &evaluation.scenario;
        self.compared(name, who(evaluation), scenario, (outcome, trace, verdict), &stored, &again)
    }

    fn repeat_failure(&self, name: Name, search: &Search) -> Result<Repeated, ExitCode> {
        let stored = self.report.search_failure(name.run, name.number).map_err(|error| unreadable(&error))?;
        let Some(stored) = stored else { return Err(self.missing(name, "failure")) };
        let followed = report::failure(&stored).and_then(|failure| {
            let seed = search.beginnings(&self.seed);
            let (outcome, trace) = follow(&search.scenario, seed, failure.beginning, &failure.commands)?;
            Some((failure, outcome, trace))
        });
        let Some((failure, outcome, trace)) = followed else {
            front::fail(&format!("the commands of {name} do not lead to the end of an episode any more"));
            return Err(ExitCode::Differs);
        };
        let failure =
            Failure { beginning: failure.beginning, ticks: failure.ticks, commands: failure.commands, outcome };
        // A table of this failure alone would count it as the first.
        let again = if outcome.is_collision() { search_row(search, failure) } else { Default::default() };
        let key = &search.key;
        let title = format!("found by {} in {} against {}, run {}", key.falsifier, key.town, key.policy, key.run);
        let verdict = judge(&trace.main_pair(&search.scenario));
        self.compared(name, title, &search.scenario, (outcome, trace, verdict), &stored, &again)
    }

    fn missing(&self, name: Name, what: &str) -> ExitCode {
        front::fail(&format!("`{}` has no {what} {} of {}", self.report.folder().display(), name.number, name.run));
        ExitCode::Usage
    }

    fn compared(
        &self,
        name: Name,
        title: String,
        scenario: &Arc<Scenario>,
        (outcome, trace, verdict): (Outcome, Trace, Option<Verdict>),
        stored: &report::Row,
        again: &report::Row,
    ) -> Result<Repeated, ExitCode> {
        let damaged = |error: &dyn std::fmt::Display| {
            front::fail(&format!("the row of {name} cannot be compared: {error}"));
            ExitCode::Usage
        };
        let mut differences: Vec<Difference> = report::differences(stored, again)
            .map_err(|error| damaged(&error))?
            .into_iter()
            .map(|each| each.1)
            .collect();
        differences.retain(|difference| difference.column != "failure");
        if !outcome.is_collision() && self.search(name).is_some() {
            let (column, stored, again) = ("outcome".into(), "collision".into(), "none".into());
            differences.push(Difference { column, stored, again });
        }
        let parting = if differences.is_empty() {
            None
        } else {
            let ticks = self.report.ticks(name.run, name.number).map_err(|error| unreadable(&error))?;
            let now = report::ticks(name.run, name.number, scenario, &trace);
            report::parting(stored, &outcome, scenario, ticks.as_ref().map(|then| (then, &now)))
        };
        let scenario = scenario.clone();
        Ok(Repeated { name, title, scenario, outcome, trace, verdict, differences, parting })
    }
}

/// The row of a failure in the table of its search.
fn search_row(search: &Search, failure: Failure) -> report::Row {
    let spent = Spent { ticks: 0, episodes: 0, beginnings: 0, failures: vec![failure], stopped: false };
    let key = search.key.clone();
    report::search_failures(&[SearchResult { key, budget: search.budget, spent, tried: Vec::new(), error: None }])
}

/// Who is tried where, in words.
pub fn who(evaluation: &Evaluation) -> String {
    let key = &evaluation.trained;
    let trained = if key.town.is_empty() {
        format!("{} ({}, run {})", evaluation.pedestrian.name(), key.reward, key.run)
    } else {
        format!("{} {} ({}, {}), run {}", evaluation.pedestrian.name(), key.reward, key.town, key.policy, key.run)
    };
    format!(
        "{trained}, in {} against {}, {} and {}",
        evaluation.town, evaluation.policy, evaluation.vehicle, evaluation.adversary
    )
}

/// What may be the reason for a difference, in words.
pub fn reasons(manifest: &Manifest) -> Vec<String> {
    let mut reasons = Vec::new();
    if manifest.version != env!("CARGO_PKG_VERSION") {
        reasons.push(format!("another version: {} then, {} now", manifest.version, env!("CARGO_PKG_VERSION")));
    }
    let now = vector_instructions();
    if manifest.vector_instructions != now {
        let then = &manifest.vector_instructions;
        reasons.push(format!("another processor: `{then}` then, `{now}` now; it changes trainings alone"));
    }
    if manifest.call.allow_external {
        reasons
            .push("a driver from outside that does not drive the same way twice; try `falsify av check`".to_string());
    }
    if manifest.code != CODE {
        reasons.push("the program was built from other sources".to_string());
    }
    if reasons.is_empty() {
        reasons.push("this is a bug; the files, the program and the processor are the same".to_string());
    }
    reasons
}
