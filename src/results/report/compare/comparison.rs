use std::collections::BTreeMap;
use std::path::PathBuf;

use polars::prelude::{DataFrame, PolarsResult};

use super::caveat::{Caveat, caveats};
use super::matching::{Incomparable, Matched, Side, lone_drivers, matched};
use super::paired_rate::{Changed, CountedEvent, PairedRate, PooledStarts, VIOLATIONS};
use super::searches::{ComparedSearch, MatchedSearches, compared_searches};
use crate::failure::Failure;
use crate::record::columns::START;
use crate::record::{CellKey, EPISODES, EpisodeTable};
use crate::report::grouped::grouped;
use crate::report::infer::{EvaluatedRun, MAX_KEPT, compare_pair};
use crate::report::repeats::{Repeats, start_bits};
use crate::report::{FailureChange, ReadError, SideCollision, SideEnd};
use crate::tables::{Metric, metrics};

/// Two sides, compared over the starts that they share.
#[derive(Debug, Clone)]
pub struct ReportComparison {
    /// The folders of the reports.
    pub folders: [PathBuf; 2],
    /// What differs besides the drivers.
    pub caveats: Vec<Caveat>,
    /// What is counted: collisions, violations of the requirements that both reports have and that applied in one of them, and at last the collisions of
    /// both sides that are worse on one.
    pub events: Vec<CountedEvent>,
    /// One for each place, driver and controller, in the order of the first report; then those about all untrained controllers of a driver that has several.
    pub cells: Vec<ComparedCell>,
    /// The common starts from which at least one side has a collision. Cell by cell, in the order of the first report.
    pub changes: Vec<FailureChange>,
    /// One for each falsifier, town and driver, in the order of the first report.
    pub searches: Vec<ComparedSearch>,
}

/// A place, a driver and a controller on both sides, or all untrained controllers together.
#[derive(Debug, Clone, Default)]
pub struct ComparedCell {
    /// The key on the first side and on the second; its controller is `all untrained` where they are pooled.
    pub keys: [CellKey; 2],
    /// The number of matched runs.
    pub runs: u64,
    /// Pairs of episodes with equal starts, over all runs; of all untrained controllers the different starts.
    pub starts: u64,
    /// The number of pairs of episodes that are not the same byte for byte.
    pub differing: u64,
    /// The rates of [`ReportComparison::events`], `None` for a requirement that never applied here; empty without a common start.
    pub rates: Vec<Option<PairedRate>>,
}

/// The controller of a row about all untrained controllers of a driver. No controller of a scenario has such a name.
pub const ALL_UNTRAINED: &str = "all untrained";

impl ReportComparison {
    /// The starts of single controllers with an event on one side or on both.
    pub fn changed(&self, event: &CountedEvent) -> Changed {
        let place = self.events.iter().position(|each| each == event);
        let cells = self.cells.iter().filter(|cell| !cell.is_pooled());
        let mut sum = Changed::default();
        cells.filter_map(|cell| cell.rates.get(place?)?.as_ref()).for_each(|rate| sum.add(rate.changed));
        sum
    }

    /// The collisions of either side by a word about each: those of one side alone, and those of both.
    pub fn counts(&self, of: impl Fn(&SideCollision) -> String) -> BTreeMap<String, Changed> {
        let mut counts: BTreeMap<String, Changed> = BTreeMap::new();
        for change in &self.changes {
            let [before, after] = change.sides.each_ref().map(|side| side.collision.as_ref().map(&of));
            match (before, after) {
                (Some(before), Some(after)) if before == after => counts.entry(before).or_default().same += 1,
                (before, after) => {
                    before.into_iter().for_each(|kind| counts.entry(kind).or_default().fixed += 1);
                    after.into_iter().for_each(|kind| counts.entry(kind).or_default().new += 1);
                }
            }
        }
        counts
    }
}

/// Compares two sides.
///
/// # Errors
/// Nothing can be compared, or a table cannot be read.
pub fn compare_reports(before: Side<'_>, after: Side<'_>) -> Result<ReportComparison, Incomparable> {
    let MatchedSearches { searches, apart } = compared_searches(before, after)?;
    let Matched { pairs, unmatched } = match matched(before, after) {
        Err(Incomparable::NoRun { .. } | Incomparable::NoEpisode { .. } | Incomparable::NoSuch { .. })
            if !searches.is_empty() =>
        {
            Matched { pairs: Vec::new(), unmatched: [0; 2] }
        }
        other => other?,
    };
    let mut notes = caveats(before.report.manifest(), after.report.manifest());
    // A copy has its wall times, too.
    let is_one_report = before.report.manifest() == after.report.manifest();
    if is_one_report && (before.driver, before.world) == (after.driver, after.world) {
        notes.push(Caveat::Same);
    }
    let failures = [before.report.failures()?, after.report.failures()?];
    let collided = failures.each_ref().map(|all| collisions(all));
    let violated = [violations(before, &failures[0])?, violations(after, &failures[1])?];
    let applied = [before.report.applied_requirements()?, after.report.applied_requirements()?];
    let is_compared =
        |name: &&String| violated[1].contains_key(*name) && applied.iter().any(|all| all.contains_key(*name));
    let requirements: Vec<&String> = violated[0].keys().filter(is_compared).collect();
    let events = CountedEvent::all(requirements.iter().copied());
    let of_collisions: Vec<&'static Metric> = metrics::compared().collect();
    let kinds: Vec<&[&'static Metric]> =
        std::iter::once(&of_collisions[..]).chain(requirements.iter().map(|_| &VIOLATIONS[..])).collect();
    let touches = [before.report.touches()?, after.report.touches()?];
    let cells = grouped(pairs, |pair| pair[0].key.cell.clone());
    let (mut compared, mut changes) = (Vec::<ComparedCell>::new(), Vec::new());
    let mut pools: Vec<Pool> = Vec::new();
    let (mut unpaired, mut all, mut errors) = (0, 0, (0, None::<String>));
    for cell in &cells {
        let mut found = ComparedCell {
            keys: cell[0].each_ref().map(|run| run.key.cell.clone()),
            runs: cell.len() as u64,
            ..ComparedCell::default()
        };
        let pool = match pools.iter().position(|pool| pool.cell.has_drivers_and_place_of(&found)) {
            Some(place) => &mut pools[place],
            None => pools.push_mut(Pool { cell: found.pooled(), ..Pool::default() }),
        };
        // Trainings differ from each other, which pairs of starts do not show.
        let is_pooled = !found.keys[0].is_of_reward();
        pool.controllers += usize::from(is_pooled);
        pool.cell.runs += if is_pooled { found.runs } else { 0 };
        // Collisions always can be.
        let applies: Vec<bool> = std::iter::once(true)
            .chain(requirements.iter().map(|name| {
                let runs = |side: usize| applied[side].get(*name).into_iter().flatten();
                cell.iter().any(|pair| (0..2).any(|side| runs(side).any(|run| *run == pair[side].key.id)))
            }))
            .zip(&kinds)
            .flat_map(|(applies, metrics)| std::iter::repeat_n(applies, metrics.len()))
            .chain([true])
            .collect();
        pool.applies.resize(events.len(), false);
        pool.applies.iter_mut().zip(&applies).for_each(|(pooled, own)| *pooled |= is_pooled && *own);
        let mut counts = vec![Changed::default(); events.len()];
        // Collisions and each requirement apart.
        let mut evaluated = vec![[Vec::new(), Vec::new()]; 1 + requirements.len()];
        // The share of the starts of each run with a collision of both that is worse on either side.
        let mut worse_by_run: Vec<[f64; 2]> = Vec::new();
        for [first, second] in cell {
            let (a, b) = (before.report.rows_of(first)?, after.report.rows_of(second)?);
            let broken = |side: &Side<'_>| {
                let path = side.report.folder().join(format!("{EPISODES}.parquet"));
                move |source| Incomparable::Read(ReadError::Table { path: path.clone(), source })
            };
            let tables =
                [EpisodeTable::new(&a).map_err(broken(&before))?, EpisodeTable::new(&b).map_err(broken(&after))?];
            for (table, run) in tables.iter().zip([first, second]) {
                for (row, error) in table.rows().filter_map(|row| Some((row, table.error(row)?))) {
                    let name = || format!("{}:{}: {error}", run.key.id, table.episode(row));
                    (errors.0, errors.1) = (errors.0 + 1, errors.1.or_else(|| Some(name())));
                }
            }
            let counted = [
                touches[0].counted(first.key.id, &a, &of_collisions).map_err(broken(&before))?,
                touches[1].counted(second.key.id, &b, &of_collisions).map_err(broken(&after))?,
            ];
            let mut rows = common(&tables, [&a, &b]).map_err(broken(&before))?;
            all += (a.height() + b.height()) as u64;
            unpaired += (a.height() + b.height() - 2 * rows.len()) as u64;
            // Repeating a pair to the bit says nothing more, unless a driver draws.
            let start = |row: usize| start_bits(tables[0].spawn(row));
            let mut repeats = Repeats::default();
            for (row, other) in &rows {
                repeats.add(start(*row), &[tables[0].digest(*row), tables[1].digest(*other)].concat());
            }
            rows.retain(|(row, _)| !repeats.repeats(start(*row)));
            found.starts += rows.len() as u64;
            let keys = [&first.key, &second.key];
            let mut runs: Vec<[EvaluatedRun; 2]> =
                evaluated.iter().map(|_| keys.map(|key| EvaluatedRun::new(key.clone(), MAX_KEPT))).collect();
            let mut worse_here = [0.0_f64; 2];
            for (row, partner) in &rows {
                let ends = [(0, *row, first), (1, *partner, second)].map(|(side, row, run)| {
                    let name = format!("{}:{}", run.key.id, tables[side].episode(row));
                    let failure = collided[side].get(&name).copied();
                    (name, failure)
                });
                let start = tables[0].episode(*row);
                found.differing += u64::from(tables[0].digest(*row) != tables[1].digest(*partner));
                let mut here: Vec<[bool; 2]> = Vec::with_capacity(events.len());
                for (kind, runs) in runs.iter_mut().enumerate() {
                    let of = |side: usize| -> Vec<bool> {
                        let row = [*row, *partner][side];
                        match kind.checked_sub(1) {
                            None => counted[side].iter().map(|rows| rows[row]).collect(),
                            Some(place) => violated[side][requirements[place]]
                                .get(&ends[side].0)
                                .copied()
                                .unwrap_or_default()
                                .to_vec(),
                        }
                    };
                    let sides = [of(0), of(1)];
                    for (side, run) in runs.iter_mut().enumerate() {
                        run.add_events(start, kinds[kind].iter().copied().zip(sides[side].iter().copied()));
                    }
                    here.extend((0..kinds[kind].len()).map(|event| [sides[0][event], sides[1][event]]));
                }
                let worse = match ends.each_ref().map(|(_, failure)| failure.map(SideCollision::from)) {
                    [Some(before), Some(after)] => [before.is_worse_than(&after), after.is_worse_than(&before)],
                    _ => [false; 2],
                };
                (0..2).for_each(|side| worse_here[side] += f64::from(u8::from(worse[side])));
                here.push(worse);
                counts.iter_mut().zip(&here).for_each(|(count, [was, now])| count.count(*was, *now));
                if is_pooled {
                    pool.starts.count(start, &here);
                }
                if ends.iter().any(|(_, failure)| failure.is_some()) {
                    let sides = ends.map(|(name, failure)| SideEnd::of_report(name, failure));
                    changes.push(FailureChange { place: found.title(), sides });
                }
            }
            worse_by_run.extend((!rows.is_empty()).then(|| worse_here.map(|count| count / rows.len() as f64)));
            for (of_kind, runs) in evaluated.iter_mut().zip(runs).filter(|_| !rows.is_empty()) {
                of_kind.iter_mut().zip(runs).for_each(|(side, run)| side.push(run));
            }
        }
        pool.cell.differing += if is_pooled { found.differing } else { 0 };
        if found.starts > 0 {
            let figures = evaluated.into_iter().zip(&kinds).flat_map(|(runs, metrics)| compare_pair(runs, metrics));
            let worse = PairedRate::of_runs(&worse_by_run, *counts.last().expect("it is the last event"), found.starts);
            let rates = figures.zip(counts).map(|(figure, count)| PairedRate::of_cell(figure, count));
            found.rates = rates.chain([worse]).zip(applies).map(|(rate, applies)| applies.then_some(rate)).collect();
        }
        compared.push(found);
    }
    compared.extend(pools.into_iter().filter(|pool| pool.controllers > 1).map(
        |Pool { cell, starts, applies, .. }| {
            let events = 0..if starts.count_all() > 0 { events.len() } else { 0 };
            let rates = events.map(|event| applies[event].then(|| starts.rate(event))).collect();
            ComparedCell { starts: starts.count_all(), rates, ..cell }
        },
    ));
    for cell in &mut compared {
        cell.rates
            .iter_mut()
            .flatten()
            .for_each(|rate| rate.is_unchanged = cell.differing == 0 && rate.changed.is_same());
    }
    // A gate is about one rate, of single controllers or of all of them.
    for (event, is_pooled) in (0..events.len()).flat_map(|event| [(event, false), (event, true)]) {
        let cells = compared.iter_mut().filter(|cell| cell.is_pooled() == is_pooled);
        PairedRate::adjust(cells.filter_map(|cell| cell.rates.get_mut(event)?.as_mut()));
    }
    if compared.iter().all(|cell| cell.starts == 0) && searches.iter().all(|search| search.starts == 0) {
        let because = notes.iter().find(|note| !matches!(note, Caveat::Trainings { .. })).map(ToString::to_string);
        return Err(Incomparable::NoStart { because });
    }
    let drivers = lone_drivers(before, after)?.concat();
    if !drivers.is_empty() {
        notes.push(Caveat::LoneDrivers { drivers });
    }
    if unmatched != [0, 0] {
        notes.push(Caveat::Unmatched { before: unmatched[0], after: unmatched[1] });
    }
    if unpaired > 0 {
        notes.push(Caveat::Unpaired { episodes: unpaired, all });
    }
    if let (episodes, Some(first)) = errors {
        notes.push(Caveat::Errors { episodes, first });
    }
    if apart > 0 {
        notes.push(Caveat::SearchStarts { searches: apart });
    }
    let folders = [before, after].map(|side| side.report.folder().to_path_buf());
    Ok(ReportComparison { folders, caveats: notes, events, cells: compared, changes, searches })
}

/// The controllers of a driver in a place.
#[derive(Debug, Default)]
struct Pool {
    cell: ComparedCell,
    controllers: usize,
    starts: PooledStarts,
    /// Whether each event can be: not where its requirement never applied.
    applies: Vec<bool>,
}

/// The collisions of evaluations, by their names.
fn collisions(failures: &[Failure]) -> BTreeMap<String, &Failure> {
    let is_collision =
        |failure: &&Failure| !failure.is_of_search() && failure.violation.is_none() && !failure.is_bump();
    failures.iter().filter(is_collision).map(|failure| (failure.name(), failure)).collect()
}

/// Of each requirement of a report the episodes that violate it, `RUN:EPISODE`, with the events that a violation is.
fn violations(
    side: Side<'_>,
    failures: &[Failure],
) -> Result<BTreeMap<String, BTreeMap<String, [bool; VIOLATIONS.len()]>>, ReadError> {
    let requirements = side.report.requirements()?;
    let mut violated: BTreeMap<String, BTreeMap<String, [bool; VIOLATIONS.len()]>> =
        requirements.into_iter().map(|name| (name, BTreeMap::new())).collect();
    for failure in failures.iter().filter(|failure| !failure.is_of_search()) {
        if let Some(violation) = &failure.violation {
            let events = [true, violation.preventable == Some(true), failure.fault];
            violated.entry(violation.requirement.clone()).or_default().insert(failure.name(), events);
        }
    }
    Ok(violated)
}

impl ComparedCell {
    /// The drivers, the town and the controller.
    pub fn title(&self) -> String {
        let before = &self.keys[0];
        let drivers = drivers(&self.keys.each_ref().map(|key| key.policy.clone()));
        let who = if before.is_of_reward() { before.who() } else { before.controller.clone() };
        let [here, there] = self.keys.each_ref().map(CellKey::simulator);
        let worlds = if here == there { String::new() } else { format!(" ({here} and {there})") };
        format!("{drivers} in {}{worlds}, {who}", before.town)
    }

    /// Whether it is about all untrained controllers.
    pub fn is_pooled(&self) -> bool {
        self.keys[0].controller == ALL_UNTRAINED
    }

    /// The row of the same drivers in the same place, before any controller.
    fn pooled(&self) -> Self {
        let keys = self.keys.each_ref().map(|key| CellKey {
            controller: ALL_UNTRAINED.into(),
            reward: String::new(),
            train_town: String::new(),
            train_policy: String::new(),
            ..key.clone()
        });
        Self { keys, ..Self::default() }
    }

    fn has_drivers_and_place_of(&self, other: &Self) -> bool {
        let mut sides = self.keys.iter().zip(&other.keys);
        sides.all(|(own, other)| own.is_beside(other) && own.policy == other.policy)
    }
}

/// The driver of both sides, or both drivers.
pub fn drivers([before, after]: &[String; 2]) -> String {
    if before == after { before.clone() } else { format!("{before} and {after}") }
}

/// The rows of episodes with the same number and the same start in two runs. Only episodes that count are compared.
fn common([a, b]: &[EpisodeTable<'_>; 2], [before, after]: [&DataFrame; 2]) -> PolarsResult<Vec<(usize, usize)>> {
    let (starts, others) = (START.read(before)?, START.read(after)?);
    let numbered: BTreeMap<u32, usize> =
        b.rows().filter(|row| b.counts(*row)).map(|row| (b.episode(row), row)).collect();
    let partner = |row: usize| {
        let other = *numbered.get(&a.episode(row))?;
        let start = starts.get(row).filter(|start| !start.is_empty())?;
        (others.get(other) == Some(start)).then_some((row, other))
    };
    Ok(a.rows().filter(|row| a.counts(*row)).filter_map(partner).collect())
}
