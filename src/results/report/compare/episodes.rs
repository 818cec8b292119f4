//! The episodes of matched runs of both sides, joined by their starts.

use std::collections::{BTreeMap, BTreeSet};

use polars::prelude::{
    Column as Values, DataFrame, DataType, Expr, IntoLazy, JoinArgs, JoinType, MaintainOrderJoin, NamedFrom,
    PolarsError, PolarsResult, Series, col, lit,
};

use super::matching::{Incomparable, Side};
use super::paired_rate::{CountedEvent, VIOLATIONS};
use crate::failure::Failure;
use crate::record::columns::{DIGEST, EPISODE, START};
use crate::record::{EPISODES, EpisodeTable};
use crate::report::read::{StoredRun, Touches};
use crate::report::repeats::{Repeats, start_bits};
use crate::report::{ReadError, SideEnd};
use crate::tables::metrics;
use crate::tables::pairs::{self, sides};
use compile::RunId;

/// The column that says whether both episodes of a pair differ in a byte.
pub(super) const DIFFERS: &str = "differs";

/// What is known of the episodes of one side besides their rows.
pub(super) struct SideEpisodes<'a> {
    side: Side<'a>,
    touches: Touches,
    /// The collisions of evaluations.
    collisions: BTreeMap<(RunId, u64), Failure>,
    /// Of each requirement the violations, each with the events that it is.
    violations: BTreeMap<String, BTreeMap<(RunId, u64), [bool; VIOLATIONS.len()]>>,
    /// The requirements that applied, each with the runs in which it did.
    applied: BTreeMap<String, BTreeSet<RunId>>,
}

/// The pairs of episodes of a matched run.
pub(super) struct RunPairs {
    /// The number of the start, whether the episodes differ, and the events of both.
    pub pairs: DataFrame,
    /// How both episodes of each pair end.
    pub ends: Vec<[SideEnd; 2]>,
    /// The number of episodes of both runs.
    pub episodes: u64,
    /// Those of them without an equal start.
    pub unpaired: u64,
    /// Episodes in error, and the first of them.
    pub errors: (u64, Option<String>),
}

impl<'a> SideEpisodes<'a> {
    pub fn new(side: Side<'a>) -> Result<Self, ReadError> {
        let report = side.report;
        let (mut collisions, mut violations) = (BTreeMap::new(), BTreeMap::new());
        report.requirements()?.into_iter().for_each(|name| drop(violations.insert(name, BTreeMap::new())));
        for failure in report.failures()?.into_iter().filter(|failure| !failure.is_of_search()) {
            let name = (failure.key.id, failure.number);
            if let Some(violation) = &failure.violation {
                let events = [true, violation.preventable == Some(true), failure.fault];
                violations.entry(violation.requirement.clone()).or_default().insert(name, events);
            } else if !failure.is_bump() {
                collisions.insert(name, failure);
            }
        }
        let (touches, applied) = (report.touches()?, report.applied_requirements()?);
        Ok(Self { side, touches, collisions, violations, applied })
    }

    /// The requirements that both sides have and that applied on one of them.
    pub fn common_requirements(&self, other: &Self) -> Vec<String> {
        let applied = |name: &&String| [self, other].iter().any(|side| side.applied.contains_key(*name));
        self.violations.keys().filter(|name| other.violations.contains_key(*name)).filter(applied).cloned().collect()
    }

    /// Whether what is counted can be in a run: not where its requirement never applied.
    pub fn applies(&self, event: &CountedEvent, run: RunId) -> bool {
        let applied = |name: &String| self.applied.get(name).is_some_and(|runs| runs.contains(&run));
        event.requirement.as_ref().is_none_or(applied)
    }

    /// The episodes of a run that count, with the events of one side of a pair: all columns of a report, and a column for each event.
    fn episodes(&self, place: usize, rows: &DataFrame, run: RunId, events: &[CountedEvent]) -> PolarsResult<DataFrame> {
        let name = |event: &CountedEvent| sides(&event.rate())[place].clone();
        let columns: Vec<Expr> = rows.get_column_names().iter().map(|name| col(name.as_str())).collect();
        let of_metrics = events.iter().filter(|event| event.requirement.is_none() && **event != CountedEvent::WORSE);
        let flags = of_metrics.map(|event| (event.figure.part)().fill_null(lit(false)).alias(name(event)));
        let counts = (metrics::EPISODES.part)().and(col(START.name).neq(lit("")));
        let touches = self.touches.beside(run, rows)?.filter(counts);
        let mut episodes = touches.select(columns.into_iter().chain(flags).collect::<Vec<_>>()).collect()?;
        if episodes.height() > rows.height() {
            return Err(PolarsError::Duplicate(
                format!("failures.parquet has two rows of an episode of run {run}").into(),
            ));
        }
        let numbers: Vec<u32> = EPISODE.read(&episodes)?.into_no_null_iter().collect();
        for event in events {
            let Some(violated) = event.requirement.as_ref().and_then(|name| self.violations.get(name)) else {
                continue;
            };
            let kind = VIOLATIONS.iter().position(|metric| *metric == event.figure).unwrap_or_default();
            let is = |number: &u32| violated.get(&(run, u64::from(*number))).is_some_and(|events| events[kind]);
            let flags: Vec<bool> = numbers.iter().map(is).collect();
            episodes.with_column(Values::from(Series::new(name(event).into(), flags)))?;
        }
        Ok(episodes)
    }

    /// The rows of a run, those that count with their events, and the number of those in error with the first of them.
    fn read(&self, place: usize, run: &StoredRun, events: &[CountedEvent]) -> Result<SideRun, ReadError> {
        let path = self.side.report.folder().join(format!("{EPISODES}.parquet"));
        let rows = self.side.report.rows_of(run)?;
        let read = || {
            let table = EpisodeTable::new(&rows)?;
            let name = |row: usize| Some(format!("{}:{}: {}", run.key.id, table.episode(row), table.error(row)?));
            let mut errors = table.rows().filter_map(name);
            let first = errors.next();
            let episodes = self.episodes(place, &rows, run.key.id, events)?;
            Ok(SideRun {
                episodes,
                all: rows.height(),
                errors: u64::from(first.is_some()) + errors.count() as u64,
                first,
            })
        };
        read().map_err(|source| ReadError::Table { path, source })
    }
}

/// The episodes of a run of one side.
struct SideRun {
    /// Those that count, with their events.
    episodes: DataFrame,
    all: usize,
    errors: u64,
    /// The name and the reason of the first in error.
    first: Option<String>,
}

/// Joins the episodes of two matched runs by number and start. Only episodes that count are compared; of those that repeat a pair to the bit one.
pub(super) fn run_pairs(
    known: &[SideEpisodes<'_>; 2],
    runs: &[StoredRun; 2],
    events: &[CountedEvent],
) -> Result<RunPairs, Incomparable> {
    let (before, after) = (known[0].read(0, &runs[0], events)?, known[1].read(1, &runs[1], events)?);
    let errors = (before.errors + after.errors, before.first.or(after.first));
    let episodes = (before.all + after.all) as u64;
    let joined = joined(before.episodes, after.episodes, events).expect("both have these columns");
    let unpaired = episodes - 2 * joined.height() as u64;
    let joined = without_repeats(joined).expect("it has the columns of episodes");
    let ends = ends(known, runs.each_ref().map(|run| run.key.id), &joined);
    let pairs = counted(joined, &ends, events).expect("it has a column for each event");
    Ok(RunPairs { pairs, ends, episodes, unpaired, errors })
}

/// The column of the digest of the second side.
const OTHER_DIGEST: &str = "digest_after";

/// The episodes of the first side, with the events of those of the second that have the same number and start.
fn joined(before: DataFrame, after: DataFrame, events: &[CountedEvent]) -> PolarsResult<DataFrame> {
    const OTHER_START: &str = "start_after";
    let flags = events.iter().filter(|event| **event != CountedEvent::WORSE).map(|event| col(&sides(&event.rate())[1]));
    let own = [col(EPISODE.name), col(START.name).alias(OTHER_START), col(DIGEST.name).alias(OTHER_DIGEST)];
    let after = after.lazy().select(own.into_iter().chain(flags).collect::<Vec<_>>());
    let order = JoinArgs { maintain_order: MaintainOrderJoin::Left, ..JoinArgs::new(JoinType::Inner) };
    let pairs = before.lazy().join(after, [col(EPISODE.name)], [col(EPISODE.name)], order);
    pairs.filter(col(START.name).eq(col(OTHER_START))).collect()
}

/// Repeating a pair to the bit says nothing more, unless a driver draws.
fn without_repeats(pairs: DataFrame) -> PolarsResult<DataFrame> {
    let table = EpisodeTable::new(&pairs)?;
    let others = pairs.column(OTHER_DIGEST)?.str()?;
    let mut repeats = Repeats::default();
    let starts: Vec<_> = table.rows().map(|row| start_bits(table.spawn(row))).collect();
    for (row, start) in starts.iter().enumerate() {
        repeats.add(*start, &[table.digest(row), others.get(row).unwrap_or_default()].concat());
    }
    let is_new = starts.into_iter().map(|start| !repeats.repeats(start)).collect();
    pairs.filter(&is_new)
}

/// How both episodes of each pair end.
fn ends(known: &[SideEpisodes<'_>; 2], ids: [RunId; 2], pairs: &DataFrame) -> Vec<[SideEnd; 2]> {
    let numbers = EPISODE.read(pairs).expect("it has the columns of episodes");
    let end = |number: u32| {
        [0, 1].map(|side| {
            let failure = known[side].collisions.get(&(ids[side], number.into()));
            SideEnd::of_report(format!("{}:{number}", ids[side]), failure)
        })
    };
    numbers.into_no_null_iter().map(end).collect()
}

/// The columns that are counted: the number of the start, whether the pair differs, and its events.
fn counted(joined: DataFrame, ends: &[[SideEnd; 2]], events: &[CountedEvent]) -> PolarsResult<DataFrame> {
    let flags = events.iter().filter(|event| **event != CountedEvent::WORSE);
    let flags = flags.flat_map(|event| sides(&event.rate())).map(col);
    let own = [
        col(EPISODE.name).cast(DataType::UInt64).alias(pairs::START),
        col(DIGEST.name).neq(col(OTHER_DIGEST)).alias(DIFFERS),
    ];
    let mut counted = joined.lazy().select(own.into_iter().chain(flags).collect::<Vec<_>>()).collect()?;
    for (side, name) in sides(&CountedEvent::WORSE.rate()).into_iter().enumerate() {
        let is_worse = |ends: &[SideEnd; 2]| {
            let [own, other] = [side, 1 - side].map(|side| ends[side].collision.as_ref());
            own.zip(other).is_some_and(|(own, other)| own.is_worse_than(other))
        };
        let flags: Vec<bool> = ends.iter().map(is_worse).collect();
        counted.with_column(Values::from(Series::new(name.into(), flags)))?;
    }
    Ok(counted)
}
