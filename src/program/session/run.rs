use std::sync::Arc;
use std::time::Instant;

use super::event_files::EventFiles;
use super::growing_curves::GrowingCurves;
use super::manifest::{Times, hold};
use super::other_report::check_place;
use super::overview::write_overview;
use super::{
    CampaignOutcome, CampaignReport, Error, KeepError, Notice, Planned, RunOptions, RunReport, Session, Stop, Ticks,
};
use base::seed::Seed;
use compile::{Campaign, Evaluation, Training};
use learn::UpdateLog;
use results::campaign::{self, Finished, SearchResult, Task, TaskError, TrainingResult};
use results::report::{self, Episodes, FailureModes, Findings, Gathered, ReportFolder, Wanted, WriteError};
use results::store::{CampaignStore, Ids, Index, Note, Store};

/// Which tasks are run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Work {
    /// All tasks that the store lacks.
    All,
    /// No task: reports are made from stored tasks.
    None,
}

impl Session {
    /// Runs the campaigns of scenario files and writes their reports. Stored work is not repeated.
    ///
    /// # Errors
    /// Files that cannot be read or have errors, and files or folders that cannot be written. A training, a search or an episode that
    /// fails is not an error; the report has it.
    pub fn run(&self, options: &RunOptions) -> Result<RunReport, Error> {
        let planned = self.campaigns(options)?;
        self.run_plan(options, &planned, Work::All)
    }

    /// The plan of a run, which has at least one campaign.
    pub(super) fn campaigns(&self, options: &RunOptions) -> Result<Planned, Error> {
        let mut planned = self.plan(&options.input)?;
        if planned.plan.campaigns.is_empty() {
            return Err(Error::NoCampaign { advice: planned.plan.without_campaigns() });
        }
        if options.smoke {
            planned.plan.campaigns.iter_mut().for_each(campaign::smoke);
        }
        planned.plan.campaigns.iter_mut().for_each(|campaign| campaign.name_runs(options.seed));
        Ok(planned)
    }

    /// Passes notes of the store to the observer.
    pub(super) fn note(&self) -> Note {
        let observer = self.observer.clone();
        Box::new(move |text| observer.notice(&Notice::Store { text: text.to_string() }))
    }

    pub(super) fn run_plan(&self, options: &RunOptions, planned: &Planned, work: Work) -> Result<RunReport, Error> {
        for gate in &options.gates {
            gate.check(&planned.plan.campaigns)?;
        }
        let pool = pool(options.threads)?;
        for campaign in &planned.plan.campaigns {
            check_place(campaign, options, &planned.records)?;
        }
        let store = Store::open(&options.out, options.cache.as_deref(), self.note())?;
        if work == Work::All {
            self.observer.begun();
        }
        let mut campaigns = Vec::new();
        for campaign in &planned.plan.campaigns {
            let outcome = pool.install(|| self.carry_out(campaign, options, planned, &store, work))?;
            self.observer.ended(&outcome);
            campaigns.push(outcome);
            if self.stop.is_asked() {
                break;
            }
        }
        let run = RunReport { campaigns, interrupted: self.stop.is_asked(), overview: None };
        let overview = write_overview(options, &run)?;
        Ok(RunReport { overview, ..run })
    }

    /// Runs a campaign and writes its report.
    fn carry_out(
        &self,
        campaign: &Campaign,
        options: &RunOptions,
        planned: &Planned,
        store: &Store,
        work: Work,
    ) -> Result<CampaignOutcome, Error> {
        let (name, seed) = (options.report_name(campaign), Seed::root(options.seed));
        let drafts = store.drafts().map_err(|error| options.keep(error))?;
        let folder = ReportFolder::begin(&options.out, &name, &drafts)?.in_formats(options.formats);
        let began = Instant::now();
        let mut index = Index::read(store, &name).map_err(|error| options.keep(error))?;
        if work == Work::All {
            index.command.clone_from(&options.command);
        }
        if options.fresh {
            store.forget(&Ids::new(campaign, options.seed), campaign).map_err(|error| options.keep(error))?;
        }
        index.write(store, &name, campaign, options.seed).map_err(|error| options.keep(error))?;
        let results = CampaignStore::new(store, campaign, options.seed, options.limits);
        let results = if options.fresh { results } else { results.continuing(&index, options.seed) };
        let finished = match work {
            Work::All => {
                let tasks: Vec<Task> = campaign::tasks(campaign).collect();
                campaign::run(campaign, &seed, &results, &self.listener(campaign, &tasks, store, options))
            }
            Work::None => campaign::collect(campaign, &results),
        };
        if let Some(error) = results.take_failure() {
            return Err(options.keep(error));
        }
        index.write(store, &name, campaign, options.seed).map_err(|error| options.keep(error))?;
        let written = |error: WriteError| options.keep(error);
        let finished = match finished.interrupted {
            true => campaign::complete(finished, campaign, &results),
            false => finished,
        };
        let mut modes = FailureModes::new(campaign, &finished.trainings, &seed);
        let episodes = Episodes::new(campaign, &results);
        let gathered = report::gather(&folder, &episodes, &mut modes, &finished.searches).map_err(written)?;
        if let Some(error) = results.take_failure() {
            return Err(options.keep(error));
        }
        if gathered.episodes == 0
            && finished.searches.is_empty()
            && finished.trainings.iter().all(|training| training.result.is_err())
        {
            return Ok(CampaignOutcome::Empty { name, interrupted: finished.interrupted });
        }
        self.notice_errors(&gathered, &name);
        let times = Times { trainings: results.training_seconds(), run: began.elapsed().as_secs_f64() };
        let files = hold(&folder, planned).map_err(written)?;
        let manifest = self.manifest(campaign, options, files, &finished, &gathered, &times);
        let failed = |source| options.keep(WriteError::Table { name: "cells".into(), source });
        let found = Findings::new(campaign, &finished, gathered, modes, options.smoke).map_err(failed)?;
        for doubt in &found.doubts {
            self.observer.notice(&Notice::DoubtfulTraining { campaign: name.clone(), doubt: Box::new(doubt.clone()) });
        }
        report::write(&folder, &found, &manifest).map_err(written)?;
        if options.ticks != Ticks::None {
            let all = options.ticks == Ticks::All;
            let wanted = Wanted::of(campaign, &Episodes::new(campaign, &results), &finished, all).map_err(written)?;
            report::write_ticks(&folder, &seed, &wanted).map_err(written)?;
        }
        // Another process may have finished another report of this name meanwhile.
        check_place(campaign, options, &planned.records)?;
        let folder = self.stop.while_placing(|| {
            let _door = store.door();
            folder.finish(manifest.complete)
        });
        let folder = folder.map_err(written)?;
        let searched = report::search_cell_table(&found.searches);
        let table = |gate: &report::Gate| if gate.is_about_searches() { &searched } else { &found.cell_table };
        let gates = options.gates.iter().map(|gate| (gate.clone(), gate.judge(table(gate)))).collect();
        let Findings { cells, drivers, searches, doubts, gathered, layers, .. } = found;
        Ok(CampaignOutcome::Reported(Box::new(CampaignReport {
            name,
            folder,
            manifest,
            cells,
            drivers,
            searches,
            protocol: (gathered.protocol, layers),
            doubts,
            gates,
            failed: has_failed(&finished),
        })))
    }

    /// The observer of a campaign's tasks, which the stop flag stops.
    pub(super) fn listener<'a>(
        &self,
        campaign: &'a Campaign,
        tasks: &[Task],
        store: &Store,
        options: &RunOptions,
    ) -> Listener<'a> {
        let name = options.report_name(campaign);
        let event_files = options.tensorboard.as_ref().map(|folder| folder.join(&name));
        Listener {
            inner: self.observer.campaign(campaign, tasks),
            curves: GrowingCurves::new(store.learning(&name), self.observer.clone()),
            event_files: event_files.map(|folder| EventFiles::new(folder, self.observer.clone())),
            stop: self.stop.clone(),
        }
    }

    /// Reports errors of episodes to the observer.
    fn notice_errors(&self, gathered: &Gathered, name: &str) {
        let campaign = || name.to_string();
        if let Some(first) = gathered.first_unpaid.clone() {
            self.observer.notice(&Notice::Unpaid { campaign: campaign(), episodes: gathered.unpaid, first });
        }
        if let Some(first) = gathered.first_error.clone() {
            let Gathered { errors, untried, episodes, .. } = *gathered;
            self.observer.notice(&Notice::EpisodesInError { campaign: campaign(), errors, episodes, untried, first });
        }
    }
}

impl RunOptions {
    /// The name of a campaign's report. A smoke run never replaces results.
    pub(super) fn report_name(&self, campaign: &Campaign) -> String {
        if self.smoke { format!("{}-smoke", campaign.name) } else { campaign.name.clone() }
    }

    /// The error for something that could not be written during a run.
    pub(super) fn keep(&self, source: impl Into<KeepError>) -> Error {
        Error::Keep { out: self.out.clone(), source: source.into() }
    }
}

/// Starts this number of threads; 0 means one for each core.
pub(super) fn pool(threads: u16) -> Result<rayon::ThreadPool, Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build();
    pool.map_err(|source| Error::Threads { threads, source })
}

fn has_failed(finished: &Finished) -> bool {
    finished.trainings.iter().any(|training| training.result.is_err())
        || finished.searches.iter().any(|search| search.error.is_some())
}

/// Passes all events to the observer of a campaign and to the growing learning curves, and stops when the flag is raised.
pub(super) struct Listener<'a> {
    inner: Box<dyn campaign::Observer + 'a>,
    curves: GrowingCurves,
    event_files: Option<EventFiles>,
    stop: Arc<Stop>,
}

impl campaign::Observer for Listener<'_> {
    fn training_begun(&self, training: usize) {
        self.inner.training_begun(training);
    }

    fn curve_before(&self, training: usize, plan: &Training, curve: &[UpdateLog]) {
        if let Some(folder) = self.curves.first_of(plan, curve) {
            self.inner.curves_grow(folder);
        }
        self.curves.restart(plan, curve);
        if let Some(files) = &self.event_files {
            files.restart(plan, curve);
        }
        self.inner.curve_before(training, plan, curve);
    }

    fn deciding(&self, training: usize, decisions: u64) {
        self.inner.deciding(training, decisions);
    }

    fn trained(&self, training: usize, plan: &Training, curve: &[UpdateLog]) {
        self.curves.grow(plan, curve);
        if let Some(files) = &self.event_files {
            files.grow(plan, curve);
        }
        self.inner.trained(training, plan, curve);
    }

    fn training_ended(&self, training: usize, result: &TrainingResult) {
        self.inner.training_ended(training, result);
    }

    fn tried(&self, evaluation: usize, plan: &Evaluation) {
        self.inner.tried(evaluation, plan);
    }

    fn chunk_ended(&self, evaluation: usize, chunk: u32, error: Option<&TaskError>) {
        self.inner.chunk_ended(evaluation, chunk, error);
    }

    fn reused(&self, task: Task) {
        self.inner.reused(task);
    }

    fn continued(&self, task: Task, units: u64) {
        self.inner.continued(task, units);
    }

    fn search_begun(&self, search: usize) {
        self.inner.search_begun(search);
    }

    fn searching(&self, search: usize, ticks: u64) {
        self.inner.searching(search, ticks);
    }

    fn searched(&self, search: usize, result: &SearchResult) {
        self.inner.searched(search, result);
    }

    fn stop(&self) -> bool {
        self.stop.is_asked() || self.inner.stop()
    }
}
