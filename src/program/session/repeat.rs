use std::collections::BTreeMap;
use std::sync::Arc;

use super::stored::Source;
use super::{EpisodeName, Error};
use compile::{Evaluation, Search};
use episode::{FailureCell, Scenario, Trace};
use results::jobs::{Repeatable, SearchFailure};
use results::record::{self, EpisodeRow, RunKey};
use results::report::{self, Difference};
use search::Failure;
use verdict::Judged;
use verdict::cause::{Cause, Incident, Questions, RunLimit, Shrunk, explain, shrink};

/// An episode that was repeated.
#[derive(Debug, Clone)]
pub struct Repeated {
    pub name: EpisodeName,
    /// The controller, the place and the driver, in words.
    pub title: String,
    /// The scenario it belongs to.
    pub scenario: Arc<Scenario>,
    /// Its trace now.
    pub trace: Trace,
    /// Its outcome and its verdicts now.
    pub judged: Judged,
    /// The values of its row that differ from the report.
    pub differences: Vec<Difference>,
    /// Where it starts to differ from the stored one, in words, when that is known.
    pub divergence: Option<String>,
    /// The failure, by what repeats it; `None` if it is not a failure.
    pub incident: Option<Incident>,
}

impl Repeated {
    fn new(name: EpisodeName, title: String, seen: results::jobs::Repeated) -> Self {
        let incident = seen.incident();
        let results::jobs::Repeated { scenario, trace, judged, .. } = seen;
        Self { name, title, scenario, trace, judged, differences: Vec::new(), divergence: None, incident }
    }

    /// The same failure with the fewest commands, with at most this number of runs.
    ///
    /// # Errors
    /// It is not a failure, it is not as in the report, or it does not fail again when its commands are repeated.
    pub fn shrink(&self, max_runs: u32) -> Result<Shrunk, Error> {
        let name = self.name;
        let Some(incident) = &self.incident else { return Err(Error::Usage(format!("{name} is not a failure"))) };
        if !self.differences.is_empty() {
            return Err(Error::Differs(format!("{name} differs from the report; `falsify replay {name}` shows where")));
        }
        let shrunk = shrink(incident, max_runs);
        shrunk.ok_or_else(|| Error::Differs(format!("{name} does not fail again when its commands are repeated")))
    }

    /// Why it failed; `None` if it is not a failure, if it is not as in the report, or if the questions leave out its driver.
    pub fn cause(&self, questions: Questions, limit: RunLimit<'_>) -> Option<Cause> {
        explain(self.as_in_report()?, questions, limit)
    }

    /// The failure, if it is as in the report.
    pub fn as_in_report(&self) -> Option<&Incident> {
        self.incident.as_ref().filter(|_| self.differences.is_empty())
    }

    /// The shrunk failure in place of the episode, under its name.
    pub fn replaced_by(self, shrunk: Shrunk) -> Self {
        let without = shrunk.without();
        let Shrunk { incident, rerun, counts: [before, now], .. } = shrunk;
        let title = format!("{}, shrunk from {before} commands to {now}{without}", self.title);
        let judged = Judged::new(&rerun.outcome, &rerun.trace.main_pair(&incident.scenario));
        let scenario = incident.scenario.clone();
        Self { title, scenario, trace: rerun.trace, judged, incident: Some(incident), ..self }
    }
}

impl Source {
    /// Repeats an episode and compares it with the report.
    ///
    /// # Errors
    /// The report or the campaign does not have it, or a file of the report is damaged.
    pub fn repeat(&self, name: EpisodeName) -> Result<Repeated, Error> {
        if let Some(evaluation) = self.evaluation(name) {
            return self.repeat_episode(name, evaluation);
        }
        match self.search(name) {
            Some(search) => self.repeat_failure(name, search),
            None => Err(self.run_gone(name.run)),
        }
    }

    fn repeat_episode(&self, name: EpisodeName, evaluation: &Evaluation) -> Result<Repeated, Error> {
        let earlier = self.campaign.all::<Evaluation>().take_while(|other| other.origin.id != name.run);
        let before: usize = earlier.map(|other| other.episodes as usize).sum();
        let guess = before + name.number as usize;
        let stored = self.report.episode(name.run, name.number, guess)?;
        let Some(stored) = stored else { return Err(self.missing(name, "episode")) };
        let trained = self.trained(evaluation)?;
        let repeatable = Repeatable::Episode { evaluation, networks: trained.as_deref(), number: name.number };
        let seen = repeatable.repeat(&self.seed).expect("an episode that is tried comes to an end");
        let key = Arc::new(RunKey::of(evaluation));
        let row = EpisodeRow::new(&key, name.number, seen.judged.clone(), &seen.trace.main_pair(&seen.scenario));
        let again = record::episodes(&[row]);
        self.compared(Repeated::new(name, key.to_string(), seen), &stored, &again)
    }

    fn repeat_failure(&self, name: EpisodeName, search: &Search) -> Result<Repeated, Error> {
        let stored = self.report.failure(name.run, name.number)?;
        let Some(stored) = stored else { return Err(self.missing(name, "failure")) };
        let read = report::read_failures(&stored, &BTreeMap::new()).ok();
        let followed = read.and_then(|mut found| found.pop()).and_then(|failure| {
            let repeatable = Repeatable::SearchFailure { search, start: failure.start, commands: &failure.commands };
            Some((repeatable.repeat(&self.seed)?, failure))
        });
        let Some((seen, failure)) = followed else {
            return Err(Error::Differs(format!(
                "the commands of {name} do not lead to the end of an episode any more"
            )));
        };
        let outcome = seen.judged.outcome;
        let pair = seen.trace.main_pair(&seen.scenario);
        // If it is no failure now, there is no row to compare.
        let again = match FailureCell::of_pair(&pair, outcome.last_mode) {
            Some(cell) => {
                let (start, ticks, commands) = (failure.start, failure.found_after, failure.commands);
                let (id, key, scenario) = (search.origin.id, &search.key, &*search.scenario);
                let goal = scenario.criterion.requirement();
                let violation = goal.and_then(|goal| Some(seen.judged.degrees.get(goal)?.degree));
                // No column that is compared has the number of simulations.
                let failure = Failure { start, ticks, simulations: 0, commands, outcome, violation, cell };
                let (number, judged) = (name.number as usize, Some(&seen.judged));
                let find = SearchFailure { id, key, scenario, number, failure: &failure, judged };
                report::failure_table().frame(&[results::failure::Failure::from(&find)])
            }
            None => Default::default(),
        };
        self.compared(Repeated::new(name, format!("found by {}", search.key), seen), &stored, &again)
    }

    fn missing(&self, name: EpisodeName, what: &'static str) -> Error {
        let (report, EpisodeName { run, number }) = (self.report.folder().display(), name);
        Error::Usage(format!("`{report}` has no {what} {number} of {run}"))
    }

    /// Fills in what differs between the stored row of an episode and that of its repetition.
    fn compared(&self, mut repeated: Repeated, stored: &report::Row, again: &report::Row) -> Result<Repeated, Error> {
        let name = repeated.name;
        let differences = report::differences(stored, again);
        let differences = differences
            .map_err(|error| Error::Usage(format!("the row of {name} cannot be compared: {error}")))?
            .into_iter();
        repeated.differences = differences.map(|each| each.1).collect();
        let criterion = repeated.scenario.criterion;
        let fails = criterion.is_met(&repeated.judged.outcome, repeated.trace.degrees());
        if !fails && self.search(name).is_some() {
            let failed = if criterion.requirement().is_some() { "violation" } else { "collision" };
            let (column, stored, again) = ("outcome".into(), failed.into(), "none".into());
            repeated.differences.push(Difference { column, stored, again });
        }
        if !repeated.differences.is_empty() {
            repeated.divergence = report::divergence(stored, &repeated.judged.outcome, &repeated.scenario);
        }
        Ok(repeated)
    }
}
