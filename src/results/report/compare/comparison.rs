use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use polars::prelude::{DataFrame, PolarsResult};

use super::caveat::{Caveat, caveats};
use super::matching::{Incomparable, Matched, Side, matched};
use super::searches::{ComparedSearch, MatchedSearches, compared_searches};
use crate::failure::Failure;
use crate::record::columns::START;
use crate::record::{CellKey, EPISODES, EpisodeTable};
use crate::report::grouped::grouped;
use crate::report::infer::{Comparison, EvaluatedRun, Figure, MAX_KEPT, adjust, compare_pair};
use crate::report::{FailureChange, ReadError, SideCollision, SideEnd};
use world::judge::Label;

/// Two sides, compared over the starts that they share.
#[derive(Debug, Clone)]
pub struct ReportComparison {
    /// The folders of the reports.
    pub folders: [PathBuf; 2],
    /// What differs besides the drivers.
    pub caveats: Vec<Caveat>,
    /// One for each place, driver and controller, in the order of the first report.
    pub cells: Vec<ComparedCell>,
    /// The common starts from which at least one side has a collision. Cell by cell, in the order of the first report.
    pub changes: Vec<FailureChange>,
    /// One for each falsifier, town and driver, in the order of the first report.
    pub searches: Vec<ComparedSearch>,
}

/// A place, a driver and a controller on both sides.
#[derive(Debug, Clone, Default)]
pub struct ComparedCell {
    /// The key on the first side and on the second.
    pub keys: [CellKey; 2],
    /// The number of matched runs.
    pub runs: u64,
    /// Pairs of episodes with equal starts, over all runs.
    pub starts: u64,
    /// Figures as second less first; `None` without a common start.
    pub figures: Vec<Comparison>,
    /// Collisions of the first side only, of the second only, and of both.
    pub collisions: Changed,
    /// The same for preventable collisions.
    pub preventable: Changed,
    /// The same for faults.
    pub fault: Changed,
    /// Violations of each requirement that both reports have, by its name.
    pub violations: BTreeMap<String, Changed>,
}

/// The number of common starts with a failure on one side or on both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Changed {
    /// On the first side only.
    pub fixed: u64,
    /// On the second side only.
    pub new: u64,
    /// On both sides.
    pub same: u64,
}

impl Changed {
    /// Adds other starts.
    fn add(&mut self, other: Self) {
        self.fixed += other.fixed;
        self.new += other.new;
        self.same += other.same;
    }

    /// Counts a start.
    pub fn count(&mut self, before: bool, after: bool) {
        match (before, after) {
            (true, true) => self.same += 1,
            (true, false) => self.fixed += 1,
            (false, true) => self.new += 1,
            (false, false) => {}
        }
    }
}

impl ReportComparison {
    /// The violations of each requirement that both reports have, over all cells.
    pub fn violations(&self) -> BTreeMap<&str, Changed> {
        let mut sums: BTreeMap<&str, Changed> = BTreeMap::new();
        for (name, changed) in self.cells.iter().flat_map(|cell| &cell.violations) {
            sums.entry(name).or_default().add(*changed);
        }
        sums
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
        Err(Incomparable::NoRun { .. } | Incomparable::NoDriver { .. }) if !searches.is_empty() => {
            Matched { pairs: Vec::new(), unmatched: [0; 2] }
        }
        other => other?,
    };
    let mut notes = caveats(before.report.manifest(), after.report.manifest());
    let violated = [violations(before)?, violations(after)?];
    let requirements: Vec<&String> = violated[0].keys().filter(|name| violated[1].contains_key(*name)).collect();
    let cells = grouped(pairs, |one, other| one[0].key.cell == other[0].key.cell);
    let (mut compared, mut changes) = (Vec::new(), Vec::new());
    let (mut unpaired, mut all) = (0, 0);
    for cell in &cells {
        let mut evaluated = [Vec::new(), Vec::new()];
        let mut found = ComparedCell {
            keys: cell[0].each_ref().map(|run| run.key.cell.clone()),
            runs: cell.len() as u64,
            violations: requirements.iter().map(|name| ((*name).clone(), Changed::default())).collect(),
            ..ComparedCell::default()
        };
        for [first, second] in cell {
            let (a, b) = (before.report.rows_of(first)?, after.report.rows_of(second)?);
            let broken = |side: &Side<'_>| {
                let path = side.report.folder().join(format!("{EPISODES}.parquet"));
                move |source| Incomparable::Read(ReadError::Table { path: path.clone(), source })
            };
            let tables =
                [EpisodeTable::new(&a).map_err(broken(&before))?, EpisodeTable::new(&b).map_err(broken(&after))?];
            let rows = common(&tables, [&a, &b]).map_err(broken(&before))?;
            all += (a.height() + b.height()) as u64;
            unpaired += (a.height() + b.height() - 2 * rows.len()) as u64;
            found.starts += rows.len() as u64;
            for (row, partner) in &rows {
                let ends = [(0, *row, first), (1, *partner, second)].map(|(side, row, run)| {
                    let table = &tables[side];
                    let name = format!("{}:{}", run.key.id, table.episode(row));
                    (name, Failure::of_collision(table, row, &run.key))
                });
                let is =
                    |what: fn(&Failure) -> bool| ends.each_ref().map(|(_, failure)| failure.as_ref().is_some_and(what));
                let [before, after] = is(|_| true);
                found.collisions.count(before, after);
                let [was, now] = is(|failure| failure.verdict == Some(Label::Preventable));
                found.preventable.count(was, now);
                let [was, now] = is(|failure| failure.fault);
                found.fault.count(was, now);
                for (name, changed) in &mut found.violations {
                    let [was, now] = [0, 1].map(|side| violated[side][name].contains(&ends[side].0));
                    changed.count(was, now);
                }
                if before || after {
                    let sides = ends.map(|(name, failure)| SideEnd::of_report(name, failure.as_ref()));
                    changes.push(FailureChange { place: found.title(), sides });
                }
            }
            let (own, others): (Vec<usize>, Vec<usize>) = rows.iter().copied().unzip();
            for (side, mut kept) in [own, others].into_iter().enumerate().filter(|(_, kept)| !kept.is_empty()) {
                kept.sort_unstable();
                let mut run = EvaluatedRun::new([first, second][side].key.clone(), MAX_KEPT);
                run.add(&tables[side], &kept);
                evaluated[side].push(run);
            }
        }
        found.figures = compare_pair(evaluated);
        compared.push(found);
    }
    if compared.iter().all(|cell| cell.starts == 0) && searches.iter().all(|search| search.starts == 0) {
        let because = notes.iter().find(|note| !matches!(note, Caveat::Trainings { .. })).map(ToString::to_string);
        return Err(Incomparable::NoStart { because });
    }
    // All comparisons of both sides are one family of tests.
    let mut family: Vec<Comparison> = compared.iter().flat_map(|cell| cell.figures.iter().cloned()).collect();
    adjust(&mut family);
    let mut family = family.into_iter();
    for cell in &mut compared {
        cell.figures.iter_mut().zip(&mut family).for_each(|(figure, adjusted)| *figure = adjusted);
    }
    if unmatched != [0, 0] {
        notes.push(Caveat::Unmatched { before: unmatched[0], after: unmatched[1] });
    }
    if unpaired > 0 {
        notes.push(Caveat::Unpaired { episodes: unpaired, all });
    }
    if apart > 0 {
        notes.push(Caveat::SearchStarts { searches: apart });
    }
    let folders = [before, after].map(|side| side.report.folder().to_path_buf());
    Ok(ReportComparison { folders, caveats: notes, cells: compared, changes, searches })
}

/// The names of the episodes that violate each requirement of a report, `RUN:EPISODE`.
fn violations(side: Side<'_>) -> Result<BTreeMap<String, BTreeSet<String>>, ReadError> {
    let requirements = side.report.requirements()?;
    let mut violated: BTreeMap<String, BTreeSet<String>> =
        requirements.into_iter().map(|name| (name, BTreeSet::new())).collect();
    if violated.is_empty() {
        return Ok(violated);
    }
    for failure in side.report.failures()?.into_iter().filter(|failure| !failure.is_of_search()) {
        let name = failure.name();
        if let Some(violation) = failure.violation {
            violated.entry(violation.requirement).or_default().insert(name);
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
        format!("{drivers} in {}, {who}", before.town)
    }

    /// A figure, if both sides have it.
    pub fn figure(&self, figure: Figure) -> Option<&Comparison> {
        self.figures.iter().find(|each| each.figure == figure)
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
