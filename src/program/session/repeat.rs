use std::sync::Arc;

use super::stored::Source;
use super::{EpisodeName, Error};
use compile::{Evaluation, Search};
use results::campaign::{repeat_episodes, repeat_failure};
use results::record::{self, EpisodeRow, RunKey};
use results::report::{self, Difference};
use world::env::{FailureCell, Outcome, Scenario, Trace};
use world::falsifier::Failure;
use world::judge::{Verdict, judge};
use world::requirement::Degree;

/// An episode that was repeated.
#[derive(Debug, Clone)]
pub struct Repeated {
    pub name: EpisodeName,
    /// The controller, the place and the driver, in words.
    pub title: String,
    /// The scenario it belongs to.
    pub scenario: Arc<Scenario>,
    /// Its outcome now.
    pub outcome: Outcome,
    /// Its trace now.
    pub trace: Trace,
    /// The verdict of the reference drivers; none without a collision.
    pub verdict: Option<Verdict>,
    /// The values of its row that differ from the report.
    pub differences: Vec<Difference>,
    /// Where it starts to differ from the stored one, in words, when that is known.
    pub divergence: Option<String>,
}

impl Source {
    /// Repeats an episode and compares it with the report.
    ///
    /// # Errors
    /// The report or the campaign does not have it, or a file of the report is damaged.
    pub fn repeat(&self, name: EpisodeName) -> Result<Repeated, Error> {
        if let Some((place, evaluation)) = self.evaluation(name) {
            return self.repeat_episode(name, place, evaluation);
        }
        match self.search(name) {
            Some(search) => self.repeat_failure(name, search),
            None => Err(self.run_gone(name.run)),
        }
    }

    fn repeat_episode(&self, name: EpisodeName, place: usize, evaluation: &Evaluation) -> Result<Repeated, Error> {
        let before: usize = self.campaign.evaluations[..place].iter().map(|other| other.episodes as usize).sum();
        let guess = before + name.number as usize;
        let stored = self.report.episode(name.run, name.number, guess)?;
        let Some(stored) = stored else { return Err(self.missing(name, "episode")) };
        let trained = self.trained(evaluation)?;
        let note = &mut |outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
        let seen = repeat_episodes(evaluation, trained.as_ref(), &[name.number], &self.seed, note);
        let (_, (outcome, trace)) = seen.into_iter().next().expect("an episode that is tried comes to an end");
        let pair = trace.main_pair(&evaluation.scenario);
        let key = Arc::new(RunKey::of(evaluation));
        let row = EpisodeRow::new(&key, name.number, &outcome, &pair);
        let verdict = row.verdict;
        let again = record::episodes(&[row]);
        let repeated = Repeated {
            name,
            title: key.to_string(),
            scenario: evaluation.scenario.clone(),
            outcome,
            trace,
            verdict,
            differences: Vec::new(),
            divergence: None,
        };
        self.compared(repeated, &stored, &again)
    }

    fn repeat_failure(&self, name: EpisodeName, search: &Search) -> Result<Repeated, Error> {
        let stored = self.report.search_failure(name.run, name.number)?;
        let Some(stored) = stored else { return Err(self.missing(name, "failure")) };
        let followed = report::failure(&stored).and_then(|failure| {
            let (outcome, trace) = repeat_failure(search, failure.start, &failure.commands, &self.seed)?;
            Some((failure, outcome, trace))
        });
        let Some((failure, outcome, trace)) = followed else {
            return Err(Error::Differs(format!(
                "the commands of {name} do not lead to the end of an episode any more"
            )));
        };
        let pair = trace.main_pair(&search.scenario);
        let verdict = judge(&pair);
        // If it is no failure now, there is no row to compare.
        let again = match FailureCell::of_pair(&pair, outcome.last_mode) {
            Some(cell) => {
                let (start, ticks, commands) = (failure.start, failure.ticks, failure.commands);
                let violation = search.scenario.goal.and_then(|goal| trace.degrees().get(goal).copied());
                // No column of a failure has the number of simulations.
                let failure = Failure { start, ticks, simulations: 0, commands, outcome, violation, cell };
                report::search_failure(&search.key, name.number.into(), &failure, verdict)
            }
            None => Default::default(),
        };
        let repeated = Repeated {
            name,
            title: format!("found by {}", search.key),
            scenario: search.scenario.clone(),
            outcome,
            trace,
            verdict,
            differences: Vec::new(),
            divergence: None,
        };
        self.compared(repeated, &stored, &again)
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
        let fails = match repeated.scenario.goal {
            None => repeated.outcome.is_collision(),
            Some(goal) => repeated.trace.degrees().get(goal).is_some_and(Degree::is_violated),
        };
        if !fails && self.search(name).is_some() {
            let failed = if repeated.scenario.goal.is_some() { "violation" } else { "collision" };
            let (column, stored, again) = ("outcome".into(), failed.into(), "none".into());
            repeated.differences.push(Difference { column, stored, again });
        }
        if !repeated.differences.is_empty() {
            let Repeated { scenario, outcome, trace, .. } = &repeated;
            let ticks = self.report.ticks(name.run, name.number)?;
            let now = report::ticks(name.run, name.number, scenario, trace);
            let ticks = ticks.as_ref().map(|then| (then, &now));
            repeated.divergence = report::divergence(stored, outcome, scenario, ticks);
        }
        Ok(repeated)
    }
}
