use std::ops::ControlFlow;
use std::sync::Arc;

use super::watch;
use base::seed::Seed;
use compile::{Evaluation, Search, episodes_seed};
use episode::{Criterion, Outcome, Scenario, Trace, follow, recorded_commands};
use learn::ActorCritic;
use verdict::Judged;
use verdict::cause::Incident;
use world::sim::WalkCommand;

/// What repeats an episode of a campaign: the only way to see it again.
#[derive(Debug, Clone, Copy)]
pub enum Repeatable<'a> {
    /// An episode of an evaluation. A trained pedestrian needs its networks.
    Episode { evaluation: &'a Evaluation, networks: Option<&'a [ActorCritic]>, number: u32 },
    /// A failure that a search found from a start.
    SearchFailure { search: &'a Search, start: u64, commands: &'a [WalkCommand] },
}

/// An episode that was repeated.
#[derive(Debug, Clone)]
pub struct Repeated {
    pub scenario: Arc<Scenario>,
    pub trace: Trace,
    pub judged: Judged,
    pub start: (Seed, u64),
}

impl Repeated {
    /// The failure, by what repeats it: what its search looked for, else the collision, else the violation of the most important requirement. `None` if
    /// it is not a failure.
    pub fn incident(&self) -> Option<Incident> {
        let Self { scenario, trace, judged, start: (seed, start) } = self;
        let ranked = scenario.requirements.iter().enumerate().map(|(place, named)| (named.priority, place));
        let mut ranked: Vec<_> = ranked.collect();
        ranked.sort_unstable();
        let violations = ranked.into_iter().map(|(_, place)| Criterion::Violation(place));
        let mut criteria = [scenario.criterion, Criterion::Collision].into_iter().chain(violations);
        let is_met = |criterion: &Criterion| criterion.is_met(&judged.outcome, trace.degrees());
        let criterion = criteria.find(is_met).filter(|_| judged.outcome.counts())?;
        let commands = recorded_commands(trace);
        Some(Incident { scenario: scenario.clone(), seed: *seed, start: *start, commands, criterion })
    }
}

impl Repeatable<'_> {
    /// Repeats it by the seed of the user. `None` if a pedestrian was to be trained and there are no networks, or if the commands do not end the
    /// episode, as may be with a driver that is not deterministic.
    pub fn repeat(&self, seed: &Seed) -> Option<Repeated> {
        let (scenario, start, (outcome, trace)) = match *self {
            Self::Episode { evaluation, networks, number } => {
                if evaluation.origin.needs.is_some() && networks.is_none() {
                    return None;
                }
                let note = &mut |outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
                let go_on = &mut |_| ControlFlow::Continue(());
                let start = (episodes_seed(seed, &evaluation.town), number.into());
                let seen = watch(evaluation, networks, number..number + 1, seed, note, go_on).pop()?;
                (&evaluation.scenario, start, seen)
            }
            Self::SearchFailure { search, start, commands } => {
                let starts = search.starts(seed);
                (&search.scenario, (starts, start), follow(&search.scenario, starts, start, commands)?)
            }
        };
        let judged = Judged::new(&outcome, &trace.main_pair(scenario));
        Some(Repeated { scenario: scenario.clone(), trace, judged, start })
    }
}
