use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use polars::prelude::DataFrame;

use super::comparison::Changed;
use super::matching::Side;
use crate::falsifier::StartSet;
use crate::judge::Label;
use crate::record::columns::{POLICY, TOWN};
use crate::record::{Column, Entry, Interval, Table, TableReference};
use crate::report::aggregate::{BUDGET, FALSIFIER, SEARCH_BLOCK};
use crate::report::infer::most_unseen;
use crate::report::read::StoredSearch;
use crate::report::{FailureOrder, ListedFailure, ReadError};
use crate::statistics::{holm, mcnemar, mean_interval, mean_p};

/// A falsifier in a town on both sides: what its searches found from the starts that both tried.
#[derive(Debug, Clone)]
pub struct ComparedSearch {
    /// Name of the falsifier.
    pub falsifier: String,
    /// The town.
    pub town: String,
    /// The driving policy of either side.
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
    /// The same for attributable failures.
    pub attributable: Changed,
    /// Share of the common starts with an attributable failure on either side, mean over runs.
    pub shares: [f64; 2],
    /// 95 % interval of second less first: Student's over runs, and Clopper and Pearson's where no start differs; none for a single run.
    pub interval: Option<(f64, f64)>,
    /// Probability of such a difference by chance: McNemar's exact test for one run, Student's paired test over several.
    pub p: Option<f64>,
    /// The same, adjusted by Holm's method for all searches.
    pub holm: Option<f64>,
    /// The common starts from which at least one side found a failure.
    pub changes: Vec<StartChange>,
}

/// A common start from which at least one side found a failure.
#[derive(Debug, Clone)]
pub struct StartChange {
    /// The number of the run.
    pub run: u64,
    /// The number of the start.
    pub start: u64,
    /// What counts most against the driver of what either side found.
    pub sides: [Option<ListedFailure>; 2],
}

impl StartChange {
    /// `fixed`, `new` or `same`, by the failures that a test lets through.
    pub fn word(&self, is: impl Fn(&ListedFailure) -> bool) -> Option<&'static str> {
        match self.sides.each_ref().map(|side| side.as_ref().is_some_and(&is)) {
            [true, true] => Some("same"),
            [true, false] => Some("fixed"),
            [false, true] => Some("new"),
            [false, false] => None,
        }
    }
}

impl ComparedSearch {
    /// Second less first.
    pub fn difference(&self) -> f64 {
        self.shares[1] - self.shares[0]
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
    let drivers = |all: &[StoredSearch]| all.iter().map(|each| each.policy.clone()).collect::<BTreeSet<_>>();
    let (named, other) = (drivers(&first), drivers(&second));
    let renamed = named != other && named.len() == 1 && other.len() == 1;
    let key = |search: &StoredSearch| {
        let policy = if renamed { String::new() } else { search.policy.clone() };
        let words = [&search.falsifier, &search.reward, &search.town, &policy].map(String::as_str).join("\0");
        (words, search.block, search.budget, search.run)
    };
    let mut partners: BTreeMap<_, StoredSearch> = BTreeMap::new();
    for search in second {
        partners.entry(key(&search)).or_insert(search);
    }
    let (mut cells, mut apart) = (Vec::<Vec<[StoredSearch; 2]>>::new(), 0);
    for search in first {
        let Some(partner) = partners.remove(&key(&search)) else { continue };
        if search.first_start.is_none() || search.first_start != partner.first_start {
            apart += 1;
            continue;
        }
        let is_of = |cell: &&mut Vec<[StoredSearch; 2]>| {
            let (words, block, budget, _) = key(&cell[0][0]);
            let (own, own_block, own_budget, _) = key(&search);
            (words, block, budget) == (own, own_block, own_budget)
        };
        match cells.iter_mut().find(is_of) {
            Some(cell) => cell.push([search, partner]),
            None => cells.push(vec![[search, partner]]),
        }
    }
    let mut searches: Vec<ComparedSearch> = cells.iter().map(|cell| compared(cell)).collect();
    let raw: Vec<f64> = searches.iter().filter_map(|search| search.p).collect();
    for (search, adjusted) in searches.iter_mut().filter(|search| search.p.is_some()).zip(holm(&raw)) {
        search.holm = Some(adjusted);
    }
    Ok(MatchedSearches { searches, apart })
}

fn of_side(side: Side<'_>) -> Result<Vec<StoredSearch>, ReadError> {
    let mut searches = side.report.searches()?;
    searches.retain(|search| side.driver.is_none_or(|driver| search.policy == driver));
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
        starts: 0,
        collisions: Changed::default(),
        preventable: Changed::default(),
        attributable: Changed::default(),
        shares: [0.0; 2],
        interval: None,
        p: None,
        holm: None,
        changes: Vec::new(),
    };
    let mut differences = Vec::new();
    for run in runs {
        let tried = run[0].starts.common(&run[1].starts);
        let common = tried.count();
        found.starts += common;
        let worst = run.each_ref().map(|side| worst_of_starts(side, &tried));
        let numbers: BTreeSet<u64> = worst.iter().flat_map(|side| side.keys().copied()).collect();
        let mut here = Changed::default();
        for start in numbers {
            let sides = worst.each_ref().map(|side| side.get(&start).copied().cloned());
            let is = |what: fn(&ListedFailure) -> bool| sides.each_ref().map(|side| side.as_ref().is_some_and(what));
            let [before, after] = is(|_| true);
            found.collisions.count(before, after);
            let [before, after] = is(|failure| failure.attributable || failure.verdict == Some(Label::Preventable));
            found.preventable.count(before, after);
            let [before, after] = is(|failure| failure.attributable);
            found.attributable.count(before, after);
            here.count(before, after);
            found.changes.push(StartChange { run: run[0].run, start, sides });
        }
        if common > 0 {
            let share = |count: u64| count as f64 / common as f64;
            found.shares[0] += share(here.fixed + here.same);
            found.shares[1] += share(here.new + here.same);
            differences.push(share(here.new) - share(here.fixed));
        }
    }
    let n = differences.len().max(1) as f64;
    found.shares = found.shares.map(|sum| sum / n);
    let attributable = found.attributable;
    (found.interval, found.p) = match differences.len() {
        0 => (None, None),
        // Without a start that differs the runs show no spread, but not that there is no difference.
        _ if attributable.new + attributable.fixed == 0 => {
            let most = most_unseen(found.starts);
            (Some((-most, most)), None)
        }
        1 => (None, Some(mcnemar(found.attributable.fixed, found.attributable.new))),
        _ => (mean_interval(&differences).1, mean_p(&differences)),
    };
    found
}

/// The failure of each of these starts that counts most against the driver.
fn worst_of_starts<'a>(search: &'a StoredSearch, tried: &StartSet) -> BTreeMap<u64, &'a ListedFailure> {
    let mut worst: BTreeMap<u64, &ListedFailure> = BTreeMap::new();
    for failure in search.failures.iter().filter(|failure| tried.contains(failure.start)) {
        let kept = worst.entry(failure.start).or_insert(failure);
        if FailureOrder::Severity.compare(failure, kept) == Ordering::Less {
            *kept = failure;
        }
    }
    worst
}

/// The searches of a comparison as a table, one row each.
pub fn compared_search_table(searches: &[ComparedSearch]) -> DataFrame {
    table().frame(searches)
}

/// The columns of [`compared_search_table`].
pub fn compared_search_reference() -> TableReference {
    table().reference()
}

fn table() -> Table<'static, ComparedSearch> {
    type Row = ComparedSearch;
    let (text, count, number) = (Column::<String>::new, Column::<u64>::new, Column::<f64>::new);
    Table::new("compared_searches", "One row for each falsifier, town and driver that both sides have.")
        .column(FALSIFIER.of(|row: &Row| row.falsifier.clone()))
        .column(TOWN.of(|row: &Row| row.town.clone()))
        .column(POLICY.of(|row: &Row| row.policies[0].clone()))
        .column(
            text("other_policy", "", "name of the driving policy on the second side")
                .of(|row: &Row| row.policies[1].clone()),
        )
        .column(SEARCH_BLOCK.of(|row: &Row| row.block))
        .column(BUDGET.of(|row: &Row| row.budget))
        .column(count("runs", "", "matched runs").of(|row: &Row| row.runs))
        .column(count("tried_starts", "", "starts that both sides tried, over all runs").of(|row: &Row| row.starts))
        .column(
            number("found_before", "", "share of these from which the first side found an attributable failure, mean over runs")
                .of(|row: &Row| row.shares[0]),
        )
        .column(number("found_after", "", "the same of the second side").of(|row: &Row| row.shares[1]))
        .column(number("found_difference", "", "second less first").of(ComparedSearch::difference))
        .columns(
            Interval::new("found_difference", "", "95 % interval: Student's over runs, Clopper and Pearson's where no start differs; missing for a single run")
                .of(|row: &Row| row.interval),
        )
        .column(
            number("found_p", "", "probability of such a difference by chance: McNemar's exact test for one run, Student's paired test over several")
                .of(|row: &Row| row.p),
        )
        .column(number("found_p_holm", "", "the same, adjusted by Holm's method for all searches").of(|row: &Row| row.holm))
        .columns(changed("failed_starts", "failure", |row| row.collisions))
        .columns(changed("preventable_starts", "preventable failure", |row| row.preventable))
        .columns(changed("attributable_starts", "attributable failure", |row| row.attributable))
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
    use super::*;

    fn failure(start: u64, attributable: bool, speed: f64) -> ListedFailure {
        ListedFailure {
            run: "1a2b3c4d".into(),
            number: 0,
            start,
            controller: "walks".into(),
            searched: true,
            reward: String::new(),
            train_town: String::new(),
            train_policy: String::new(),
            town: "harbour".into(),
            policy: "behavior".into(),
            verdict: Some(if attributable { Label::Preventable } else { Label::Standing }),
            foreseeable: attributable,
            attributable,
            narrow: false,
            impact: "front".into(),
            moving: attributable,
            occluded: false,
            driving_mode: "cruise".into(),
            impact_speed: speed,
            length: 1.0,
        }
    }

    fn search(run: u64, starts: std::ops::Range<u64>, failures: Vec<ListedFailure>) -> StoredSearch {
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
        assert_eq!(found.attributable, Changed { fixed: 0, new: 1, same: 1 });
        assert_eq!(found.collisions, Changed { fixed: 1, new: 1, same: 1 });
        assert_eq!(found.shares, [0.25, 0.5]);
        assert_eq!((found.interval, found.p), (None, Some(1.0)), "one pair of starts differs: exact p is 1");
        let worst = found.changes.iter().find(|change| change.start == 0).unwrap();
        assert_eq!(worst.sides[1].as_ref().unwrap().impact_speed, 5.0);
        assert_eq!(worst.word(|failure| failure.attributable), Some("same"));
    }

    #[test]
    fn several_runs_are_the_sample() {
        let pair = |run, new: u64| {
            let after = (0..new).map(|start| failure(start, true, 3.0)).collect();
            [search(run, 0..10, Vec::new()), search(run, 0..10, after)]
        };
        let found = compared(&[pair(0, 1), pair(1, 2), pair(2, 3)]);
        assert_eq!((found.runs, found.starts, found.attributable.new), (3, 30, 6));
        // By hand: mean 0.2, standard deviation 0.1, t = 4.302653.
        let half = 4.302_652_729_696 * 0.1 / 3_f64.sqrt();
        let (low, high) = found.interval.unwrap();
        assert!(
            (found.difference() - 0.2).abs() < 1e-12
                && (low - 0.2 + half).abs() < 1e-9
                && (high - 0.2 - half).abs() < 1e-9
        );
        assert!(found.p.is_some_and(|p| (p - 0.074_18).abs() < 1e-4), "{:?}", found.p);
    }
}
