use std::collections::BTreeMap;
use std::path::PathBuf;

use polars::prelude::{DataFrame, IntoLazy, PolarsResult, lit};

use super::caveat::{Caveat, caveats};
use super::episodes::{DIFFERS, SideEpisodes, run_pairs};
use super::matching::{Incomparable, Matched, Side, lone_drivers, matched};
use super::paired_rate::{CountedEvent, PairedRate};
use super::searches::{ComparedSearch, MatchedSearches, compared_searches};
use crate::record::{CellKey, RunKey};
use crate::report::grouped::grouped;
use crate::report::infer::{EvaluatedRun, MAX_KEPT, compare_pair};
use crate::report::price::DriverPrice;
use crate::report::read::{ReadError, StoredRun};
use crate::report::{FailureChange, SideCollision};
use crate::tables::pairs::{ROW, START, sides, starts, sums};
use crate::tables::{Changed, Metric};

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
    /// What the driver after costs beside the driver before, and whether that is surely more, for each pair of drivers.
    pub prices: Vec<(String, bool)>,
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
    let known = [SideEpisodes::new(before)?, SideEpisodes::new(after)?];
    let events = CountedEvent::all(known[0].common_requirements(&known[1]).iter());
    let mut found = Found::default();
    for cell in grouped(pairs, |pair| pair[0].key.cell.clone()) {
        found.add(&known, &cell, &events)?;
    }
    let compared = found.adjusted(&events);
    let Found { changes, episodes, unpaired, errors, .. } = found;
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
        notes.push(Caveat::Unpaired { episodes: unpaired, all: episodes });
    }
    if let (episodes, Some(first)) = errors {
        notes.push(Caveat::Errors { episodes, first });
    }
    if apart > 0 {
        notes.push(Caveat::SearchStarts { searches: apart });
    }
    let folders = [before, after].map(|side| side.report.folder().to_path_buf());
    let prices = prices([before, after], &compared)?;
    Ok(ReportComparison { folders, caveats: notes, events, cells: compared, changes, prices, searches })
}

/// What each driver costs beside the one that it is compared with, as far as both reports have it.
fn prices(sides: [Side<'_>; 2], cells: &[ComparedCell]) -> Result<Vec<(String, bool)>, ReadError> {
    let [before, after] = [DriverPrice::stored(sides[0].report)?, DriverPrice::stored(sides[1].report)?];
    let mut pairs: Vec<[&String; 2]> = cells.iter().map(|cell| cell.keys.each_ref().map(|key| &key.policy)).collect();
    pairs.dedup();
    let of = |prices: &[(String, DriverPrice)], name: &str| {
        prices.iter().find(|(known, _)| known == name).map(|(_, price)| *price)
    };
    let price = |pair: [&String; 2]| {
        let [before, after] = [of(&before, pair[0])?, of(&after, pair[1])?];
        let text = format!("Price of {}: {}", drivers(&pair.map(Clone::clone)), before.beside(&after));
        Some((text, before.is_below(&after)))
    };
    Ok(grouped(pairs, |pair| pair.map(Clone::clone)).into_iter().filter_map(|pairs| price(pairs[0])).collect())
}

/// What is found cell by cell.
#[derive(Debug, Default)]
struct Found {
    cells: Vec<ComparedCell>,
    pools: Vec<Pool>,
    changes: Vec<FailureChange>,
    /// All episodes of the matched runs of both sides, and those without an equal start.
    episodes: u64,
    unpaired: u64,
    /// Episodes in error, and the first of them.
    errors: (u64, Option<String>),
}

/// The controllers of a driver in a place.
#[derive(Debug, Default)]
struct Pool {
    cell: ComparedCell,
    controllers: usize,
    /// The pairs of each controller.
    pairs: Vec<DataFrame>,
    /// Whether each event can be: not where its requirement never applied.
    applies: Vec<bool>,
}

impl Found {
    /// Adds the runs of a cell.
    fn add(
        &mut self,
        known: &[SideEpisodes<'_>; 2],
        runs: &[[StoredRun; 2]],
        events: &[CountedEvent],
    ) -> Result<(), Incomparable> {
        let keys = runs[0].each_ref().map(|run| run.key.cell.clone());
        let mut cell = ComparedCell { keys, runs: runs.len() as u64, ..ComparedCell::default() };
        let applies = |event: &CountedEvent| {
            runs.iter().any(|run| known.iter().zip(run).any(|(side, run)| side.applies(event, run.key.id)))
        };
        let applies: Vec<bool> = events.iter().map(applies).collect();
        let mut by_run = Vec::new();
        for run in runs {
            let found = run_pairs(known, run, events)?;
            self.episodes += found.episodes;
            self.unpaired += found.unpaired;
            self.errors.0 += found.errors.0;
            self.errors.1 = self.errors.1.take().or(found.errors.1);
            let ends = found.ends.into_iter().filter(|sides| sides.iter().any(|side| side.collision.is_some()));
            self.changes.extend(ends.map(|sides| FailureChange { place: cell.title(), sides }));
            by_run.push(found.pairs);
        }
        let pairs = stacked(&by_run);
        cell.starts = pairs.height() as u64;
        cell.differing = sum(&pairs, DIFFERS);
        if cell.starts > 0 {
            cell.rates = rates(runs, &by_run, &pairs, events);
            cell.rates.iter_mut().zip(&applies).for_each(|(rate, applies)| drop(rate.take_if(|_| !applies)));
        }
        let pool = match self.pools.iter().position(|pool| pool.cell.has_drivers_and_place_of(&cell)) {
            Some(place) => &mut self.pools[place],
            None => self.pools.push_mut(Pool { cell: cell.pooled(), ..Pool::default() }),
        };
        // Trainings differ from each other, which pairs of starts do not show.
        if !cell.keys[0].is_of_reward() {
            pool.controllers += 1;
            pool.cell.runs += cell.runs;
            pool.cell.differing += cell.differing;
            pool.applies.resize(events.len(), false);
            pool.applies.iter_mut().zip(&applies).for_each(|(pooled, own)| *pooled |= own);
            pool.pairs.push(pairs);
        }
        self.cells.push(cell);
        Ok(())
    }

    /// The cells, then those of several controllers, with the probabilities and intervals of all rates that are tested together.
    fn adjusted(&mut self, events: &[CountedEvent]) -> Vec<ComparedCell> {
        let mut cells = std::mem::take(&mut self.cells);
        let pools = std::mem::take(&mut self.pools);
        cells.extend(pools.into_iter().filter(|pool| pool.controllers > 1).map(|pool| pool.compared(events)));
        for cell in &mut cells {
            let is_unchanged = cell.differing == 0;
            let rates = cell.rates.iter_mut().flatten();
            rates.for_each(|rate| rate.is_unchanged = is_unchanged && rate.changed.is_same());
        }
        // A gate is about one rate, of single controllers or of all of them.
        for (event, is_pooled) in (0..events.len()).flat_map(|event| [(event, false), (event, true)]) {
            let cells = cells.iter_mut().filter(|cell| cell.is_pooled() == is_pooled);
            PairedRate::adjust(cells.filter_map(|cell| cell.rates.get_mut(event)?.as_mut()));
        }
        cells
    }
}

impl Pool {
    /// The row of all controllers: a start counts once, with the pairs of all of them.
    fn compared(self, events: &[CountedEvent]) -> ComparedCell {
        let names: Vec<String> = events.iter().map(CountedEvent::rate).collect();
        let pairs = stacked(&self.pairs).lazy().with_column(lit(0).alias(ROW));
        let found = || {
            let starts = starts(pairs, names.iter().flat_map(|name| sums(name))).collect()?;
            let changed = Changed::of(&starts, &names)?.into_iter().zip(self.applies).zip(&names);
            let rate = |((changed, applies), name): ((Changed, bool), &String)| {
                applies.then(|| PairedRate::of_starts(&starts, name, changed)).transpose()
            };
            let rates = if starts.height() > 0 { changed.map(rate).collect::<PolarsResult<_>>()? } else { Vec::new() };
            Ok(ComparedCell { starts: starts.height() as u64, rates, ..self.cell })
        };
        let found: PolarsResult<ComparedCell> = found();
        found.expect(HAS_EVENTS)
    }
}

const HAS_EVENTS: &str = "a table of pairs has a column for each event";

/// The pairs of several runs.
fn stacked(tables: &[DataFrame]) -> DataFrame {
    let (first, others) = tables.split_first().expect("there is a run");
    let mut all = first.clone();
    for table in others {
        all.vstack_mut(table).expect("the columns are those of the first");
    }
    all
}

fn sum(pairs: &DataFrame, column: &str) -> u64 {
    let flags = pairs.column(column).and_then(|column| column.bool());
    flags.expect(HAS_EVENTS).sum().unwrap_or_default().into()
}

/// The rates of a cell from the pairs of its runs.
fn rates(
    runs: &[[StoredRun; 2]],
    by_run: &[DataFrame],
    pairs: &DataFrame,
    events: &[CountedEvent],
) -> Vec<Option<PairedRate>> {
    let names: Vec<String> = events.iter().map(CountedEvent::rate).collect();
    let counts = Changed::of(pairs, &names).expect(HAS_EVENTS);
    let runs: Vec<_> = runs.iter().zip(by_run).filter(|(_, pairs)| pairs.height() > 0).collect();
    // Collisions, and each requirement apart.
    let kinds = events[..events.len() - 1].chunk_by(|one, other| one.requirement == other.requirement);
    let figures = kinds.flat_map(|kind| {
        let side = |side: usize| runs.iter().map(|(run, pairs)| evaluated(&run[side].key, side, pairs, kind)).collect();
        let metrics: Vec<&'static Metric> = kind.iter().map(|event| event.figure).collect();
        compare_pair([side(0), side(1)], &metrics)
    });
    // The share of the starts of each run with a collision of both that is worse on either side.
    let share = |(_, pairs): &(_, &DataFrame)| {
        sides(&CountedEvent::WORSE.rate()).map(|name| sum(pairs, &name) as f64 / pairs.height() as f64)
    };
    let worse_by_run: Vec<[f64; 2]> = runs.iter().map(share).collect();
    let worse = PairedRate::of_runs(&worse_by_run, *counts.last().expect("it is the last"), pairs.height() as u64);
    let rates = figures.zip(counts).map(|(figure, changed)| PairedRate::of_cell(figure, changed));
    rates.chain([worse]).map(Some).collect()
}

/// The episodes of one side of the pairs of a run, with events of one kind.
fn evaluated(key: &RunKey, side: usize, pairs: &DataFrame, events: &[CountedEvent]) -> EvaluatedRun {
    let mut run = EvaluatedRun::new(key.clone(), MAX_KEPT);
    let numbers = pairs.column(START).and_then(|numbers| numbers.u64()).expect(HAS_EVENTS);
    let column = |event: &CountedEvent| {
        let column = pairs.column(&sides(&event.rate())[side]);
        column.and_then(|column| column.bool()).expect(HAS_EVENTS).clone()
    };
    let columns: Vec<_> = events.iter().map(|event| (event.figure, column(event))).collect();
    for (row, number) in numbers.into_no_null_iter().enumerate() {
        run.add_events(number as u32, columns.iter().map(|(metric, column)| (*metric, column.get(row) == Some(true))));
    }
    run
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
