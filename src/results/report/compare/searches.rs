use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use super::comparison::drivers;
use super::matching::{Matched, Side, is_renamed, paired};
use super::paired_rate::PairedRate;
use super::table::{MATCHED_RUNS, OTHER_DRIVER};
use crate::failure::Failure;
use crate::record::columns::{DRIVER, TOWN};
use crate::record::{Entry, Role, Table, columns, entries, interval};
use crate::report::aggregate::{BUDGET, METHOD, SEARCH_BLOCK};
use crate::report::grouped::grouped;
use crate::report::read::StoredSearch;
use crate::report::{FailureChange, ReadError, SideEnd};
use crate::tables::Changed;
use compile::HERE;
use search::StartSet;
use verdict::Label;

/// A falsifier in a town on both sides: what its searches found from the starts that both tried.
#[derive(Debug, Clone, Default)]
pub struct ComparedSearch {
    pub falsifier: String,
    pub town: String,
    /// The driver of either side.
    pub policies: [String; 2],
    /// Number of its block in the campaign, from 0.
    pub block: u64,
    /// Simulator ticks that each run might use.
    pub budget: u64,
    /// Matched runs.
    pub runs: u64,
    /// Starts that both sides tried, over all runs.
    pub starts: u64,
    /// Of these, those with a failure on the first side only, on the second only, and on both.
    pub collisions: Changed,
    /// The same for preventable failures.
    pub preventable: Changed,
    /// The share of the common starts with a fault.
    pub found: PairedRate,
    /// The common starts from which at least one side found a failure.
    pub changes: Vec<FailureChange>,
}

impl ComparedSearch {
    /// The method, the drivers and the town.
    pub fn title(&self) -> String {
        format!("{}, {}, {}", self.falsifier, drivers(&self.policies), self.town)
    }
}

/// The searches of both sides, and the number of those that are left out because their starts differ.
pub(super) struct MatchedSearches {
    pub searches: Vec<ComparedSearch>,
    pub apart: u64,
}

/// Compares the searches of both sides: the same falsifier in the same town with the same budget and the same starts.
///
/// # Errors
/// A table cannot be read.
pub(super) fn compared_searches(before: Side<'_>, after: Side<'_>) -> Result<MatchedSearches, ReadError> {
    let (first, second) = (of_side(before)?, of_side(after)?);
    let renamed = is_renamed(&first, &second, |search| &search.policy);
    let cell = |search: &StoredSearch| {
        let policy = if renamed { "" } else { &search.policy };
        let words = [&search.falsifier, &search.reward, &search.town, policy].join("\0");
        (words, search.block, search.budget)
    };
    let Matched { mut pairs, .. } = paired(first, second, |search| (cell(search), search.run));
    let all = pairs.len();
    pairs.retain(|[one, other]| one.first_start.is_some() && one.first_start == other.first_start);
    let apart = (all - pairs.len()) as u64;
    let cells = grouped(pairs, |pair| cell(&pair[0]));
    let mut searches: Vec<ComparedSearch> = cells.iter().map(|cell| compared(cell)).collect();
    PairedRate::adjust(searches.iter_mut().map(|search| &mut search.found));
    Ok(MatchedSearches { searches, apart })
}

fn of_side(side: Side<'_>) -> Result<Vec<StoredSearch>, ReadError> {
    let mut searches = side.report.searches()?;
    let is_here = side.world.is_none_or(|world| world == HERE);
    searches.retain(|search| is_here && side.driver.is_none_or(|driver| search.policy == driver));
    Ok(searches)
}

/// Compares the runs of a falsifier in a town.
fn compared(runs: &[[StoredSearch; 2]]) -> ComparedSearch {
    let [one, other] = &runs[0];
    let mut found = ComparedSearch {
        falsifier: one.falsifier.clone(),
        town: one.town.clone(),
        policies: [one.policy.clone(), other.policy.clone()],
        block: one.block,
        budget: one.budget,
        runs: runs.len() as u64,
        ..ComparedSearch::default()
    };
    let (mut fault, mut shares) = (Changed::default(), Vec::new());
    for run in runs {
        let tried = run[0].starts.common(&run[1].starts);
        let common = tried.count();
        found.starts += common;
        let worst = run.each_ref().map(|side| worst_of_starts(side, &tried));
        let numbers: BTreeSet<u64> = worst.iter().flat_map(|side| side.keys().copied()).collect();
        let mut here = Changed::default();
        for start in numbers {
            let sides = worst.each_ref().map(|side| side.get(&start).copied().cloned());
            let is = |what: fn(&Failure) -> bool| sides.each_ref().map(|side| side.as_ref().is_some_and(what));
            let [before, after] = is(|_| true);
            found.collisions.count(before, after);
            let [before, after] = is(|failure| failure.fault || failure.verdict == Some(Label::Preventable));
            found.preventable.count(before, after);
            let [before, after] = is(|failure| failure.fault);
            here.count(before, after);
            let place = found.title();
            let sides = sides.each_ref().map(|side| match side {
                Some(failure) => SideEnd::of_report(failure.name(), Some(failure)),
                None => SideEnd::of_report(format!("start {start}"), None),
            });
            found.changes.push(FailureChange { place, sides });
        }
        if common > 0 {
            let share = |count: u64| count as f64 / common as f64;
            shares.push([share(here.fixed + here.same), share(here.new + here.same)]);
        }
        fault.add(here);
    }
    found.found = PairedRate::of_runs(&shares, fault, found.starts);
    found
}

/// The failure of each of these starts that counts most against the driver.
fn worst_of_starts<'a>(search: &'a StoredSearch, tried: &StartSet) -> BTreeMap<u64, &'a Failure> {
    let mut worst: BTreeMap<u64, &Failure> = BTreeMap::new();
    for failure in search.failures.iter().filter(|failure| tried.contains(failure.start)) {
        let kept = worst.entry(failure.start).or_insert(failure);
        if failure.counts_more(kept) == Ordering::Less {
            *kept = failure;
        }
    }
    worst
}

columns! {
    /// starts that both sides tried, over all runs
    pub TRIED_STARTS: Column<u64> = "tried_starts";
    /// probability of such a difference by chance (McNemar's exact test for one run, Student's paired test over several), adjusted by Holm's method for all rows,
    /// so that in 95 % of comparisons no finding below 0.05 is false. Rows without a start that differs count in no correction, and have 1
    P_HOLM: Column<f64> = "found_p_holm";
}
/// The figure that is tested.
const DIFFERENCE: &str = "found_difference";

/// The searches of a comparison as a table, one row each.
pub fn compared_search_table() -> Table<'static, ComparedSearch> {
    Table::new("compared_searches", "One row for each search, town and driver that both sides have.")
        .columns(entries! { row: &ComparedSearch;
            METHOD = row.falsifier.clone();
            TOWN = row.town.clone();
            DRIVER = row.policies[0].clone();
            OTHER_DRIVER = row.policies[1].clone();
            SEARCH_BLOCK = row.block;
            BUDGET = row.budget;
            MATCHED_RUNS = row.runs;
            TRIED_STARTS = row.starts;
            /// share of these from which the first side found a fault, mean over runs
            found_before: f64 as Share = row.found.values[0];
            /// the same of the second side
            found_after: f64 as Share = row.found.values[1];
            /// second less first
            named(DIFFERENCE): f64 as ShareDifference = row.found.difference();
        })
        .columns(interval(
            DIFFERENCE,
            DIFFERENCE,
            "in 95 % of comparisons the intervals of all rows hold the truth (Bonferroni): Student's over runs, about further runs in this town; Bonett \
             and Price's for a single run, Clopper and Pearson's where no start differs; missing for two and three runs",
            |row: &ComparedSearch| row.found.interval,
        ))
        .columns([P_HOLM.of(|row: &ComparedSearch| row.found.holm).of_figure(DIFFERENCE, Role::AdjustedP)])
        .columns(changed("failed_starts", "failure", |row| row.collisions))
        .columns(changed("preventable_starts", "preventable failure", |row| row.preventable))
        .columns(changed("fault_starts", "fault", |row| row.found.changed))
        .columns(entries! { row: &ComparedSearch;
            /// tried starts with a found failure on both sides, of which the worst is worse on the second (as `collisions_worse`)
            failed_starts_worse: u64 = FailureChange::of_word(&row.changes, "worse").len() as u64;
            /// the same on the first side, and not on the second
            failed_starts_better: u64 = FailureChange::of_word(&row.changes, "better").len() as u64;
        })
}

/// Three columns: the starts with such a failure on the second side only, on the first side only, and on both.
fn changed(name: &str, of: &str, changed: fn(&ComparedSearch) -> Changed) -> Vec<Entry<'static, ComparedSearch>> {
    type Part = (&'static str, &'static str, fn(Changed) -> u64);
    let parts: [Part; 3] = [
        ("new", "on the second side only", |all| all.new),
        ("fixed", "on the first side only", |all| all.fixed),
        ("same", "on both sides", |all| all.same),
    ];
    let entry = |(word, sides, part): Part| {
        let doc = format!("tried starts with a found {of} {sides}");
        Entry::new::<u64, _>(format!("{name}_{word}").into(), "".into(), doc.into(), move |row: &ComparedSearch| {
            part(changed(row))
        })
    };
    parts.map(entry).into()
}

#[cfg(test)]
mod tests {
    use rand::Rng;

    use super::*;
    use base::seed::{Seed, Stream};

    fn failure(start: u64, fault: bool, speed: f64) -> Failure {
        let label = if fault { Label::Preventable } else { Label::Bump };
        Failure { start, ..crate::failure::tests::failure(Some(label), fault, speed) }
    }

    fn search(run: u64, starts: std::ops::Range<u64>, failures: Vec<Failure>) -> StoredSearch {
        StoredSearch {
            falsifier: "walks".into(),
            reward: String::new(),
            town: "harbour".into(),
            policy: "behavior".into(),
            block: 0,
            run,
            budget: 1_000,
            starts: starts.collect(),
            first_start: Some("0:1".into()),
            failures,
        }
    }

    #[test]
    fn starts_that_one_side_did_not_reach_are_left_out_and_the_worst_of_a_start_counts() {
        let before = vec![failure(0, true, 3.0), failure(1, false, 0.0), failure(7, true, 9.0)];
        let after = vec![failure(0, true, 2.0), failure(0, true, 5.0), failure(2, true, 4.0)];
        let found = compared(&[[search(0, 0..8, before), search(0, 0..4, after)]]);
        assert_eq!(found.starts, 4);
        assert_eq!(found.found.changed, Changed { fixed: 0, new: 1, same: 1 });
        assert_eq!(found.collisions, Changed { fixed: 1, new: 1, same: 1 });
        assert_eq!(found.found.values, [0.25, 0.5]);
        assert_eq!(found.found.p, Some(1.0), "one pair of starts differs: exact p is 1");
        // Shares of (1 + 1) / (4 + 2) and (0 + 1) / (4 + 2).
        let (low, high) = found.found.interval_at(0.05).unwrap();
        let (middle, half) = (1.0 / 6.0, 1.959_964 * libm::sqrt((0.5 - 1.0 / 36.0) / 6.0));
        assert!((low - middle + half).abs() < 1e-6 && (high - middle - half).abs() < 1e-6, "{low}..{high}");
        let worst = &found.changes[0];
        assert_eq!(worst.sides[1].collision.as_ref().unwrap().impact_speed, 5.0);
        assert_eq!(worst.word(), "worse", "3 m/s before");
    }

    /// A comparison of two sides that do not differ: 12 searches with these runs of 60 starts. Each start has its own chance of a fault.
    fn same_driver(stream: &mut Stream, runs: u64) -> Vec<ComparedSearch> {
        let mut uniform = || f64::from(stream.next_u32()) / 2_f64.powi(32);
        let mut side = |run, chances: &[f64]| {
            let failed = (0..60).filter(|start| uniform() < chances[*start as usize]);
            search(run, 0..60, failed.map(|start| failure(start, true, 3.0)).collect())
        };
        let chances: Vec<f64> = (0..60).map(|start| if start % 3 == 0 { 0.5 } else { 0.1 }).collect();
        let mut one = || compared(&(0..runs).map(|run| [side(run, &chances), side(run, &chances)]).collect::<Vec<_>>());
        let mut searches: Vec<ComparedSearch> = (0..12).map(|_| one()).collect();
        PairedRate::adjust(searches.iter_mut().map(|search| &mut search.found));
        searches
    }

    #[test]
    fn a_gate_on_an_adjusted_column_seldom_fires_on_the_same_driver() {
        const COMPARISONS: u64 = 200;
        for runs in [1, 3, 5] {
            let mut fired = [0_u64; 4];
            for number in 0..COMPARISONS {
                let searches = same_driver(&mut Seed::root(47).index(runs).index(number).stream(), runs);
                let any = |is: fn(&ComparedSearch) -> bool| u64::from(searches.iter().any(is));
                let gates: [u64; 4] = [
                    any(|each| each.found.holm.is_some_and(|p| p < 0.05) && each.found.difference() > 0.0),
                    any(|each| each.found.interval.is_some_and(|(low, _)| low > 0.0)),
                    any(|each| each.found.p.is_some_and(|p| p < 0.05) && each.found.difference() > 0.0),
                    any(|each| each.found.changed.new > 0),
                ];
                fired.iter_mut().zip(gates).for_each(|(sum, fired)| *sum += fired);
            }
            let [holm, interval, raw, new] = fired.map(|fired| fired as f64 / COMPARISONS as f64);
            // At most 0.025 is said, since one side of 0.05 counts; of 200 comparisons the share has a standard deviation of 0.011.
            assert!(holm <= 0.06 && interval <= 0.06, "{runs}: {holm} {interval}");
            assert!(raw > 2.0 * holm && new == 1.0, "what is not adjusted fires often: {raw} {new}");
        }
    }

    #[test]
    fn several_runs_are_the_sample() {
        let pair = |run, new: u64| {
            let after = (0..new).map(|start| failure(start, true, 3.0)).collect();
            [search(run, 0..10, Vec::new()), search(run, 0..10, after)]
        };
        let found = compared(&[pair(0, 1), pair(1, 2), pair(2, 3)]);
        assert_eq!(
            (found.runs, found.starts, found.found.changed.new, found.found.interval_at(0.05)),
            (3, 30, 6, None)
        );
        assert!(found.found.p.is_some_and(|p| (p - 0.074_18).abs() < 1e-4), "{:?}", found.found.p);
        let found = compared(&[pair(0, 1), pair(1, 2), pair(2, 2), pair(3, 3)]);
        // By hand: mean 0.2, variance 0.02 / 3, t = 3.182446.
        let half = 3.182_446_305_284 * (0.02_f64 / 12.0).sqrt();
        let (low, high) = found.found.interval_at(0.05).unwrap();
        assert!(
            (found.found.difference() - 0.2).abs() < 1e-12
                && (low - 0.2 + half).abs() < 1e-9
                && (high - 0.2 - half).abs() < 1e-9
        );
    }
}
