use super::Findings;
use super::distinct::is_of_program;
use super::render::listed;
use super::replayed::played_failure;
use crate::failure::Failure;
use crate::jobs::{Repeated, SearchResult};
use crate::parallel;
use crate::record::columns::{NUMBER, RUN_ID};
use crate::record::{Table, columns, entries};
use base::seed::Seed;
use compile::{Evaluation, RunId};
use episode::Scenario;
use polars::prelude::DataFrame;
use verdict::cause::{Need, needs};
use world::sim::ActorId;

/// The stem of the files of the table of actors.
pub const ACTORS: &str = "actors";
columns! {
    /// name of the actor in the cast; the members of a group share it
    pub ROLE: Column<String> = "role";
    /// whether the failure does not happen without the actor, with the same random numbers; missing for the car under test
    pub NEEDED: Column<bool> = "needed";
}

/// A listed failure of a campaign with a cast, and which of the other actors it needs.
#[derive(Debug, Clone)]
pub struct CastFailure {
    pub failure: Failure,
    pub needs: Vec<Need>,
    actors: Vec<RecordedRole>,
}

/// An actor of a failure.
#[derive(Debug, Clone)]
struct RecordedRole {
    run: RunId,
    number: u64,
    actor: ActorId,
    name: String,
    touched: bool,
    needed: Option<bool>,
}

impl CastFailure {
    /// Whether two or more other actors are needed: the failure vanishes when any one of them is removed.
    pub fn needs_two(&self) -> bool {
        self.needs.iter().filter(|need| need.is_needed).count() >= 2
    }

    fn new(failure: &Failure, repeated: &Repeated) -> Option<Self> {
        let Repeated { scenario, trace, judged, .. } = repeated;
        let needs = needs(&repeated.incident()?);
        let touched = judged.outcome.touched();
        let pair = trace.main_pair(scenario);
        let recorded = scenario.cast.actors().map(|actor| RecordedRole {
            run: failure.key.id,
            number: failure.number,
            actor,
            name: pair.actor(actor).name.into(),
            touched: touched.is_some_and(|(one, other)| one == actor || other == actor),
            needed: needs.iter().find(|need| need.actor == actor).map(|need| need.is_needed),
        });
        Some(Self { failure: failure.clone(), actors: recorded.collect(), needs })
    }
}

/// The failures that a page lists, each episode once, run again without each of their actors; empty of a campaign without a cast. Those of a
/// program of the user are left out.
pub fn cast_failures(found: &Findings<'_>, seed: &Seed) -> Vec<CastFailure> {
    let evaluated = found.campaign.all::<Evaluation>().map(|evaluation| &*evaluation.scenario);
    let searched = found.finished.all::<SearchResult>().iter().map(|result| &*result.scenario);
    let has_others = |scenario: &Scenario| scenario.cast.actors().count() > 2;
    if !evaluated.chain(searched).any(has_others) {
        return Vec::new();
    }
    let mut all: Vec<&Failure> = Vec::new();
    for failure in listed(&found.drivers, &found.gathered.failures) {
        let is_same = |other: &&Failure| other.name() == failure.name();
        if !is_of_program(found, failure) && !all.iter().any(is_same) {
            all.push(failure);
        }
    }
    let of = |failure: &&Failure| CastFailure::new(failure, &played_failure(&failure.name(), found, seed)?.2);
    parallel::map(&all, of).into_iter().flatten().filter(|each| !each.needs.is_empty()).collect()
}

/// The actors of failures as a table.
pub fn actors(failures: &[CastFailure]) -> DataFrame {
    let rows: Vec<RecordedRole> = failures.iter().flat_map(|each| each.actors.clone()).collect();
    actor_table().frame(&rows)
}

/// The columns of [`actors`].
fn actor_table() -> Table<'static, RecordedRole> {
    let doc = "One row for each actor of each failure that the page lists, in a campaign with a `cast`. `run_id` and `number` name the failure.";
    let kind = |row: &RecordedRole| if matches!(row.actor, ActorId::Vehicle(_)) { "vehicle" } else { "pedestrian" };
    Table::new(ACTORS, doc).columns(entries! { row: &RecordedRole;
        RUN_ID = row.run.to_string();
        NUMBER = row.number;
        /// `vehicle` or `pedestrian`
        kind: String = kind(row);
        /// number among the actors of its kind; vehicle 0 is the car under test
        actor: u64 = row.actor.number() as u64;
        ROLE = row.name.clone();
        /// whether it is one of the two actors whose touch ended the episode
        touched: bool = row.touched;
        NEEDED = row.needed;
    })
}

/// The reference of its columns.
pub fn actor_reference() -> crate::record::TableReference {
    actor_table().reference()
}
