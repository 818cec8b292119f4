//! Runs the encounters of a recheck.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::driver_pairs::{NewDriver, with_driver};
use crate::session::Source;
use base::seed::Seed;
use compile::{Evaluation, Search, episodes_seed};
use episode::{Criterion, Outcome, Scenario, Trace, evaluate_observed, recorded_commands, walk_again};
use learn::ActorCritic;
use results::failure::Failure;
use results::jobs::Repeatable;
use results::parallel;
use results::report::{Encounter, Encounters, RerunOutcome, WalkedBy};
use search::{Goal, evaluate_crossings};
use verdict::Judged;
use verdict::cause::{Incident, unseeing};
use world::sim::WalkCommand;

/// What became of a failure.
#[derive(Debug, Default)]
pub(super) struct MetAgain {
    /// Its encounters with the new driver.
    pub encounters: Vec<(WalkedBy, Encounter)>,
    /// Whether the old driver does not end it as in the report.
    pub is_other_now: bool,
    /// Whether the new driver has another start.
    pub has_other_start: bool,
    /// Whether its commands cannot be read.
    pub is_damaged: bool,
    /// Whether the user stopped before it was met.
    pub is_left: bool,
    /// Whether its controller cannot be repeated.
    pub has_no_controller: bool,
    /// What failed as a program, and why; `None` if nothing did, or if it was not run.
    pub error: Option<String>,
}

impl MetAgain {
    /// A failure that was not met again, since the user stopped.
    pub(super) fn left() -> Self {
        Self { is_left: true, ..Self::default() }
    }

    /// A failure that was not met again, since what is met had failed as a program over and over.
    pub(super) fn not_run(failure: &Failure, walked_by: &[WalkedBy]) -> Self {
        let left_out = |by: &WalkedBy| (*by, encounter(failure, None, RerunOutcome::error(), None));
        Self { encounters: walked_by.iter().map(left_out).collect(), ..Self::default() }
    }
}

type Played = (Outcome, Trace);

/// An episode of the new driver.
struct Meeting {
    played: Played,
    /// See [`RerunOutcome::is_missed`]. Of another simulator it is not known.
    is_missed: bool,
}

impl Meeting {
    /// Plays an episode with the new driver, and where nobody is touched once more with a driver that sees nobody.
    fn new(scenario: &Arc<Scenario>, play: impl Fn(&Arc<Scenario>) -> Option<Played>) -> Option<Self> {
        let played = play(scenario)?;
        let misses = |(outcome, _): &Played| !outcome.is_touch() && outcome.fault().is_none();
        let is_asked = misses(&played) && scenario.external_world.is_none();
        let is_missed = is_asked && play(&unseeing(scenario)).as_ref().is_some_and(misses);
        Some(Self { played, is_missed })
    }
}

impl Source {
    /// Meets a failure of an evaluation again. `old` says whether the old driver can be run.
    pub(super) fn meet_episode(
        &self,
        failure: &Failure,
        (evaluation, trained): (&Evaluation, Option<&[ActorCritic]>),
        new: NewDriver<'_>,
        old: bool,
    ) -> MetAgain {
        let number = failure.number as u32;
        let play = |scenario: &Arc<Scenario>| -> Option<Played> {
            let evaluation = &Evaluation { scenario: scenario.clone(), ..evaluation.clone() };
            let seen = Repeatable::Episode { evaluation, networks: trained, number }.repeat(&self.seed)?;
            Some((seen.judged.outcome, seen.trace))
        };
        let before = old.then(|| play(&evaluation.scenario)).flatten();
        let after = with_driver(&evaluation.scenario, new);
        // In another simulator a recorded walk says little: the car comes later or earlier.
        let commands = before.as_ref().filter(|_| new.world.is_none()).map(|(_, trace)| recorded_commands(trace));
        let starts = episodes_seed(&self.seed, &evaluation.town);
        let again = commands.and_then(|commands| {
            Meeting::new(&after, |scenario| walk_again(scenario, starts, number.into(), &commands))
        });
        let ends = [(WalkedBy::Pedestrian, Meeting::new(&after, play)), (WalkedBy::Commands, again)];
        met_again(failure, [&evaluation.scenario, &after], before, ends, (starts, number.into()))
    }

    /// Meets a failure of a search again. `old` says whether the old driver can be run.
    pub(super) fn meet_failure(&self, failure: &Failure, search: &Search, new: NewDriver<'_>, old: bool) -> MetAgain {
        if failure.commands.is_empty() {
            return MetAgain { is_damaged: true, ..MetAgain::default() };
        }
        let seed = search.starts(&self.seed);
        let after = with_driver(&search.scenario, new);
        let follow = |scenario: &Arc<Scenario>| walk_again(scenario, seed, failure.start, &failure.commands);
        let walker = || search.falsifier.walk_policy().zip(u32::try_from(failure.start).ok());
        let has_no_controller = walker().is_none();
        let walked = Meeting::new(&after, |scenario| {
            let (mut walker, start) = walker()?;
            let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
            let drawn = search.drawn(&self.seed);
            let go_on = &mut |_| ControlFlow::Continue(());
            let played = evaluate_observed(walker.as_mut(), scenario, start..start + 1, &seed, &drawn, note, go_on);
            played.into_iter().next()
        });
        let before = old.then(|| follow(&search.scenario)).flatten();
        let again = if walked.is_some() && new.world.is_some() { None } else { Meeting::new(&after, follow) };
        let ends = [(WalkedBy::Pedestrian, walked), (WalkedBy::Commands, again)];
        let start = (seed, failure.start);
        MetAgain { has_no_controller, ..met_again(failure, [&search.scenario, &after], before, ends, start) }
    }
}

fn end(scenario: &Scenario, outcome: &Outcome, trace: &Trace) -> RerunOutcome {
    RerunOutcome::new(&Judged::by(Criterion::Collision, outcome, &trace.main_pair(scenario)))
}

/// What repeats an episode that is a fault, and did not happen in another simulator.
fn incident(
    scenario: &Arc<Scenario>,
    met: RerunOutcome,
    commands: Vec<WalkCommand>,
    (seed, start): (Seed, u64),
) -> Option<Incident> {
    let incident = Incident { scenario: scenario.clone(), seed, start, commands, criterion: Criterion::Collision };
    (met.fault && scenario.external_world.is_none()).then_some(incident)
}

/// A failure that is met again in the scenario of its report and in that of the new driver, from a start.
fn met_again(
    failure: &Failure,
    [scenario, with_new]: [&Arc<Scenario>; 2],
    before: Option<Played>,
    ends: [(WalkedBy, Option<Meeting>); 2],
    start: (Seed, u64),
) -> MetAgain {
    let stored = RerunOutcome::stored(failure);
    let old = before.as_ref().map(|(outcome, trace)| (outcome.start, end(scenario, outcome, trace)));
    let is_other_now =
        old.is_some_and(|(_, old)| (old.fault, old.is_collision()) != (stored.fault, stored.is_collision()));
    let error = before.as_ref().and_then(|(outcome, _)| outcome.error());
    let mut met = MetAgain { is_other_now, error, ..MetAgain::default() };
    for (walked_by, meeting) in ends {
        let Some(Meeting { played: (outcome, trace), is_missed }) = meeting else { continue };
        met.error = met.error.or_else(|| outcome.error());
        if old.is_some_and(|(start, _)| start != outcome.start) {
            met.has_other_start = true;
            continue;
        }
        let after = end(scenario, &outcome, &trace);
        let after = RerunOutcome { is_missed: is_missed || after.is_missed, ..after };
        let incident = incident(with_new, after, recorded_commands(&trace), start);
        met.encounters.push((walked_by, encounter(failure, old.map(|(_, old)| old), after, incident)));
    }
    met
}

/// A failure, met again. `before` is how it ended for the old driver now; `None` if that was not run.
fn encounter(
    failure: &Failure,
    before: Option<RerunOutcome>,
    after: RerunOutcome,
    incident: Option<Incident>,
) -> Encounter {
    let before = Some(before.unwrap_or_else(|| RerunOutcome::stored(failure)));
    Encounter { name: failure.name(), start: failure.start, crossing: 0, before, after, incident }
}

/// Both drivers in all of these crossings from the first starts; without `before` the new driver alone. `played` is called after each episode, and
/// may break; then the others are in error.
pub(super) fn cross(
    goals: &[Goal],
    before: Option<&Arc<Scenario>>,
    after: &Arc<Scenario>,
    starts: u32,
    seed: Seed,
    played: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Encounters {
    let count = starts.min(rayon::current_num_threads() as u32);
    let parts: Vec<u32> = (0..count).collect();
    let of_part = |scenario: &Arc<Scenario>, part: u32| -> Vec<(u64, RerunOutcome, Vec<WalkCommand>)> {
        // Products of starts and parts may exceed 32 bits.
        let edge = |part: u32| (u64::from(part) * u64::from(starts) / u64::from(count)) as u32;
        let note = &mut |outcome: &Outcome, trace: &Trace| {
            let met = end(scenario, outcome, trace);
            (outcome.start, met, if met.fault { recorded_commands(trace) } else { Vec::new() })
        };
        let ends = evaluate_crossings(goals, scenario, edge(part)..edge(part + 1), seed, note, &mut || played());
        ends.into_iter().map(|end| end.unwrap_or((0, RerunOutcome::error(), Vec::new()))).collect()
    };
    let all = |scenario: &Arc<Scenario>| -> Vec<(u64, RerunOutcome, Vec<WalkCommand>)> {
        parallel::map(&parts, |part| of_part(scenario, *part)).concat()
    };
    let old = before.map(all);
    let encounter = |(place, (hash, met, commands)): (usize, (u64, RerunOutcome, Vec<WalkCommand>))| {
        let before = old.as_ref().map(|old| &old[place]);
        // An error has no start.
        let is_same = before.is_none_or(|(other, before, _)| *other == hash || before.error || met.error);
        let start = (place / goals.len()) as u64;
        is_same.then(|| Encounter {
            name: String::new(),
            start,
            crossing: (place % goals.len()) as u64,
            before: before.map(|(_, before, _)| *before),
            after: met,
            incident: incident(after, met, commands, (seed, start)),
        })
    };
    Encounters(all(after).into_iter().enumerate().filter_map(encounter).collect())
}
