use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::manifest::Times;
use super::other_report::{check_place, was_run_with};
use super::overview::write_overview;
use super::stored::Source;
use super::{
    CampaignOutcome, CampaignReport, EpisodeName, Error, Event, KeepError, Notice, Planned, RunOptions, RunReport,
    Session,
};
use base::seed::Seed;
use compile::{Campaign, Evaluation, ExternalProgram, Plan};
use results::campaign::{self, Finished, Task};
use results::jobs::SearchResult;
use results::report::{
    self, Aggregates, Episodes, FileRecord, Findings, Gate, Judged, Manifest, ReportFolder, Section, StoredReport,
    WriteError,
};
use results::store::{CampaignStore, Ids, Index, Note, Store, StoreError};

/// Which tasks are run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Work {
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
        let mut planned = self.campaigns(options)?;
        let Some(seeds) = options.seeds.clone() else { return self.run_plan(options, &planned, Work::All) };
        let of_seed = |seed: u64| RunOptions { seed, ..options.clone() };
        for seed in seeds.clone() {
            planned.plan.campaigns.iter_mut().for_each(|campaign| campaign.name_runs(seed));
            planned.plan.campaigns.iter().try_for_each(|each| check_place(each, &of_seed(seed), &planned.records))?;
        }
        let (mut run, all) =
            (RunReport { campaigns: Vec::new(), interrupted: false, overview: None }, seeds.clone().count());
        for (place, seed) in seeds.enumerate() {
            self.notice(&Notice::Note(format!("seed {seed}, {} of {all}", place + 1)));
            planned.plan.campaigns.iter_mut().for_each(|campaign| campaign.name_runs(seed));
            run.campaigns.extend(self.run_campaigns(&of_seed(seed), &planned, Work::All)?);
            run.interrupted = self.is_stopped();
            if run.interrupted {
                break;
            }
        }
        let overview = write_overview(options, &run)?;
        Ok(RunReport { overview, ..run })
    }

    /// The plan of a run, which has at least one campaign.
    pub(crate) fn campaigns(&self, options: &RunOptions) -> Result<Planned, Error> {
        let is_told = |plan: &Plan, files: &[FileRecord]| {
            plan.campaigns.iter().all(|campaign| was_run_with(campaign, options, files))
        };
        let mut planned = self.plan_unless_told(&options.input, &is_told)?;
        if planned.plan.campaigns.is_empty() {
            return Err(Error::NoCampaign { advice: planned.plan.without_campaigns() });
        }
        let known: Vec<String> = planned.plan.campaigns.iter().map(|campaign| campaign.name.clone()).collect();
        if let Some(name) = options.only.iter().find(|name| !known.contains(name)) {
            return Err(Error::Usage(format!("no campaign is called `{name}`; the files have {}", known.join(", "))));
        }
        if !options.only.is_empty() {
            planned.plan.campaigns.retain(|campaign| options.only.contains(&campaign.name));
        }
        planned.plan.settings.iter().for_each(|setting| self.notice(&Notice::Note(setting.to_string())));
        if options.smoke {
            planned.plan.campaigns.iter_mut().for_each(Campaign::shorten);
        }
        planned.plan.campaigns.iter_mut().for_each(|campaign| campaign.name_runs(options.seed));
        Ok(planned)
    }

    /// Passes notes of the store to the observer.
    pub(crate) fn note(&self) -> Note {
        let observer = self.observer.clone();
        Box::new(move |text| observer.event(&Event::Notice(&Notice::Warning(text.to_string()))))
    }

    pub(crate) fn run_plan(&self, options: &RunOptions, planned: &Planned, work: Work) -> Result<RunReport, Error> {
        let campaigns = self.run_campaigns(options, planned, work)?;
        let run = RunReport { campaigns, interrupted: self.is_stopped(), overview: None };
        let overview = write_overview(options, &run)?;
        Ok(RunReport { overview, ..run })
    }

    fn run_campaigns(
        &self,
        options: &RunOptions,
        planned: &Planned,
        work: Work,
    ) -> Result<Vec<CampaignOutcome>, Error> {
        for gate in &options.gates {
            gate.check(&planned.plan.campaigns)?;
        }
        let pool = pool(options.threads)?;
        for campaign in &planned.plan.campaigns {
            check_place(campaign, options, &planned.records)?;
        }
        let store = Store::open(&options.out, options.cache.as_deref(), self.note())?;
        if work == Work::All {
            self.tell(Event::Begun);
        }
        let mut campaigns = Vec::new();
        for campaign in &planned.plan.campaigns {
            let run = CampaignRun {
                session: self,
                options,
                planned,
                campaign,
                store: &store,
                work,
                name: options.report_name(campaign),
            };
            let outcome = pool.install(|| run.carry_out())?;
            self.tell(Event::Ended(&outcome));
            campaigns.push(outcome);
            if self.is_stopped() {
                break;
            }
        }
        Ok(campaigns)
    }
}

pub(crate) struct CampaignRun<'a> {
    pub session: &'a Session,
    pub options: &'a RunOptions,
    pub planned: &'a Planned,
    pub campaign: &'a Campaign,
    pub store: &'a Store,
    pub work: Work,
    /// The name of its report.
    pub name: String,
}

impl<'a> CampaignRun<'a> {
    /// Runs the campaign and writes its report.
    fn carry_out(&self) -> Result<CampaignOutcome, Error> {
        let draft = self.begin_report()?;
        let began = Instant::now();
        let mut index = self.begin_index(&[])?;
        let results = self.results(&index);
        let finished = self.finish_tasks(&mut index, &results)?;
        self.session.stop.while_reporting(|| self.report(draft, &results, &finished, began))
    }

    /// Makes the report of what is finished.
    fn report(
        &self,
        draft: ReportFolder,
        results: &CampaignStore<'_>,
        finished: &Finished,
        began: Instant,
    ) -> Result<CampaignOutcome, Error> {
        let Some(found) = self.find(&draft, results, finished)? else {
            return Ok(CampaignOutcome::Empty { name: self.name.clone(), interrupted: finished.interrupted });
        };
        let times = Times { jobs: results.seconds(), run: began.elapsed().as_secs_f64() };
        let sections = report::sections(&found);
        let manifest = self.write(&draft, &found, &sections, &times)?;
        let replaced = StoredReport::open(&self.options.out.join(&self.name)).ok();
        let since = replaced.map(|earlier| since(earlier.manifest(), &manifest));
        let folder = self.publish(draft, &manifest)?;
        if self.work == Work::All && results.reused() < campaign::tasks(self.campaign).count() {
            self.repeat_elsewhere(&folder);
        }
        let gates = self.judge_gates(&found);
        let few_errors = found.gathered.errors_are_few();
        let Findings { cells, drivers, searches, doubts, .. } = found;
        Ok(CampaignOutcome::Reported(Box::new(CampaignReport {
            name: self.name.clone(),
            folder,
            manifest,
            cells,
            since,
            drivers,
            searches,
            sections,
            doubts,
            gates,
            reused: results.reused(),
            tasks: campaign::tasks(self.campaign).count(),
            failed: finished.has_failed || !few_errors,
        })))
    }

    /// Makes the folder in which the report is written before it is moved to its place.
    fn begin_report(&self) -> Result<ReportFolder, Error> {
        let drafts = self.store.drafts().map_err(|error| self.options.keep(error))?;
        let folder = ReportFolder::begin(&self.options.out, &self.name, &drafts)?;
        Ok(folder.in_formats(self.options.formats()))
    }

    /// Records in the store what the campaign wants, and forgets what is to be done again. `own` are the tasks of a shard; all without any.
    pub fn begin_index(&self, own: &[Task]) -> Result<Index, Error> {
        let Self { options, store, campaign, .. } = self;
        let begun = || {
            let mut index = Index::read(store, &self.name)?;
            if self.work == Work::All {
                let ids = Ids::new(campaign, options.seed);
                index.command.clone_from(&options.command);
                index.own = own.iter().map(|task| ids.get(*task).to_string()).collect();
            }
            if options.fresh {
                store.forget(&Ids::new(campaign, options.seed), campaign)?;
            }
            index.write(store, &self.name, campaign, options.seed)?;
            Ok(index)
        };
        begun().map_err(|error: StoreError| options.keep(error))
    }

    /// What the store has of the campaign, and where the rest goes.
    pub fn results(&self, index: &Index) -> CampaignStore<'a> {
        let results = CampaignStore::new(self.store, self.campaign, self.options.seed, self.options.limits());
        let results = if self.options.fresh { results } else { results.continuing(index, self.options.seed) };
        if self.work == Work::None {
            return results;
        }
        let results = results.renewing();
        if results.renewed() > 0 {
            let unknown = self.campaign.programs().into_iter().find(|each| each.is_unknown());
            let tasks = if results.renewed() == 1 { "task is" } else { "tasks are" };
            let renewed = |each: &Arc<ExternalProgram>| {
                format!(
                    "{} stored {tasks} run again: `{}` declares no `files`, so it may have changed; with `files: […]` or `version: \"…\"` in the \
                     scenario they are used again",
                    results.renewed(),
                    each.name
                )
            };
            unknown.map(renewed).into_iter().for_each(|text| self.session.notice(&Notice::Warning(text)));
        }
        results
    }

    /// Runs all tasks, or takes those that are stored.
    fn finish_tasks(&self, index: &mut Index, results: &CampaignStore<'_>) -> Result<Finished, Error> {
        let Self { options, store, campaign, .. } = *self;
        let finished = match self.work {
            Work::All => {
                let tasks: Vec<Task> = campaign::tasks(campaign).collect();
                self.run_tasks(&tasks, results)
            }
            Work::None => campaign::collect(campaign, &Seed::root(options.seed), results),
        };
        self.check(results)?;
        index.write(store, &self.name, campaign, options.seed).map_err(|error| options.keep(error))?;
        Ok(finished)
    }

    /// Checks that nothing failed in the store.
    pub fn check(&self, results: &CampaignStore<'_>) -> Result<(), Error> {
        results.take_failure().map_or(Ok(()), |error| Err(self.options.keep(error)))
    }

    /// Gathers the episodes, which are written meanwhile, and works out what the report has; `None` if nothing was finished. The observer
    /// is called with what is wrong with the results.
    fn find<'f>(
        &self,
        draft: &ReportFolder,
        results: &CampaignStore<'_>,
        finished: &'f Finished,
    ) -> Result<Option<Findings<'f>>, Error>
    where
        'a: 'f,
    {
        let campaign = self.campaign;
        let seed = Seed::root(self.options.seed);
        let episodes = Episodes::new(campaign, results);
        let gathered = report::aggregate_episodes(draft, &episodes, finished.all::<SearchResult>());
        let gathered = gathered.map_err(|error| self.options.keep(error))?;
        self.check(results)?;
        if gathered.episodes == 0 && finished.is_empty {
            return Ok(None);
        }
        self.notice_errors(&gathered);
        let found = Findings::new(campaign, finished, gathered, &seed, self.options.smoke);
        for caution in &found.cautions {
            let caution = Box::new(caution.clone());
            self.session.notice(&Notice::Caution { campaign: self.name.clone(), caution });
        }
        for doubt in &found.doubts {
            let doubt = Box::new(doubt.clone());
            self.session.notice(&Notice::DoubtfulTraining { campaign: self.name.clone(), doubt });
        }
        Ok(Some(found))
    }

    /// Writes the files of the report; returns its manifest.
    fn write(
        &self,
        draft: &ReportFolder,
        found: &Findings<'_>,
        sections: &[Section],
        times: &Times,
    ) -> Result<Manifest, Error> {
        let Self { session, options, .. } = *self;
        let written = || {
            let held = session.hold(draft, self.planned, self.campaign)?;
            let manifest = session.manifest(options, held, found, times);
            // A report that has a dossier keeps one.
            let has_dossier =
                options.dossier || options.out.join(options.report_name(self.campaign)).join(report::DOSSIER).is_file();
            report::write(draft, found, sections, &manifest, has_dossier)?;
            Ok(manifest)
        };
        written().map_err(|error: WriteError| options.keep(error))
    }

    /// Moves the report to its place.
    fn publish(&self, draft: ReportFolder, manifest: &Manifest) -> Result<PathBuf, Error> {
        // Another process may have finished another report of this name meanwhile.
        check_place(self.campaign, self.options, &self.planned.records)?;
        let placed = self.session.stop.while_placing(|| {
            let _door = self.store.door();
            draft.finish(manifest.complete)
        });
        placed.map_err(|error| self.options.keep(error))
    }

    /// Repeats the first episode of each run in another simulator which says that all that it draws follows the seed, and reports one that is another.
    fn repeat_elsewhere(&self, folder: &Path) {
        let seeded = |each: &Evaluation| {
            let world = each.scenario.external_world.as_ref();
            world.is_some_and(|world| world.abilities.as_ref().is_some_and(|abilities| abilities.seeds))
        };
        if !self.campaign.all::<Evaluation>().any(seeded) {
            return;
        }
        let Ok(report) = StoredReport::open(folder) else { return };
        let source = Source::new(report, self.campaign.clone());
        for evaluation in source.campaign.all::<Evaluation>().filter(|each| seeded(each)) {
            if self.session.is_stopped() {
                return;
            }
            let name = EpisodeName { run: evaluation.origin.id, number: 0 };
            let Ok(repeated) = source.repeat(name) else { continue };
            let in_error = repeated.differences.iter().any(|each| each.column == "error");
            if !repeated.differences.is_empty() && !in_error {
                let text = format!(
                    "`{}` says of itself `seeds: true`, and {name} is another episode when it is repeated: its results are not those of the seed; let all \
                     that it draws follow `seed` of `begin`, or let it say `seeds: false`",
                    evaluation.world
                );
                self.session.notice(&Notice::Warning(text));
            }
        }
    }

    /// The gates, each with its judgement of each row of the table that it is about.
    fn judge_gates(&self, found: &Findings<'_>) -> Vec<(Gate, Vec<Judged>)> {
        self.options.gates.iter().map(|gate| (gate.clone(), gate.judge_campaign(found))).collect()
    }

    /// Reports errors of episodes to the observer.
    fn notice_errors(&self, gathered: &Aggregates) {
        let campaign = || self.name.clone();
        if let Some(first) = gathered.first_unpaid.clone() {
            self.session.notice(&Notice::Unpaid { campaign: campaign(), episodes: gathered.unpaid, first });
        }
        if let Some(first) = gathered.first_error.clone() {
            let Aggregates { errors, untried, episodes, .. } = *gathered;
            let (campaign, are_few) = (campaign(), gathered.errors_are_few());
            self.session.notice(&Notice::EpisodesInError { campaign, errors, episodes, untried, first, are_few });
        }
    }
}

impl RunOptions {
    /// The name of a campaign's report. A smoke run never replaces results.
    pub(crate) fn report_name(&self, campaign: &Campaign) -> String {
        let seed = self.seeds.as_ref().map_or_else(String::new, |_| format!("-seed-{}", self.seed));
        let smoke = if self.smoke { "-smoke" } else { "" };
        format!("{}{seed}{smoke}", campaign.name)
    }

    /// The error for something that could not be written during a run.
    pub(crate) fn keep(&self, source: impl Into<KeepError>) -> Error {
        Error::Keep { out: self.out.clone(), source: source.into() }
    }
}

/// Starts this number of threads; 0 means one for each core.
pub(crate) fn pool(threads: u16) -> Result<rayon::ThreadPool, Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build();
    pool.map_err(|source| Error::Usage(format!("cannot start {threads} threads: {source}")))
}

/// What changed since the report that this one replaces: its sentences about drivers that are no longer the same.
fn since(earlier: &Manifest, now: &Manifest) -> String {
    let gone = earlier.answer.iter().filter(|sentence| !now.answer.contains(sentence));
    let gone: Vec<&str> = gone.map(String::as_str).collect();
    let of = if earlier.seed == now.seed { String::new() } else { format!(" (seed {})", earlier.seed) };
    match gone.as_slice() {
        [] if earlier.answer == now.answer => format!("the report that this one replaces{of} had the same answer"),
        [] => format!("the report that this one replaces{of} knew fewer drivers"),
        gone => format!("the report that this one replaces{of} said: {}", gone.join(". ")),
    }
}
