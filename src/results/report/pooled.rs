//! Reports of one campaign at several seeds, pooled.

use super::overview::{Found, Overview, OverviewRow};
use super::{Method, Rate};
use crate::record::CellKey;
use crate::tables::Metric;
use crate::tables::metrics::{EPISODES, FAULT_RATE, compared};
use base::statistics::mean_p;

/// The setting that tells the seeds of a call apart.
pub const SEED: &str = "seed";

/// A controller or a falsifier in a town against a driver, over the seeds of a call.
#[derive(Debug, Clone)]
pub struct Pooled<'a> {
    /// The rows of the seeds, in the order in which they ran.
    pub rows: Vec<&'a OverviewRow<'a>>,
    /// The number of the first controller, or falsifier, in the same town against the same driver.
    pub first: usize,
    /// The place of the seed among the parameters.
    seed: usize,
}

impl<'a> Pooled<'a> {
    /// Pools the rows that differ in the seed alone; empty for a single seed.
    pub fn all(overview: &'a Overview<'a>) -> Vec<Self> {
        let Some(seed) = overview.parameters.iter().position(|name| *name == SEED) else { return Vec::new() };
        let place = |row: &OverviewRow<'a>| {
            let mut values = row.values.clone();
            let report = row.variant.report.replace(&format!("-seed-{}", values.remove(seed).unwrap_or_default()), "");
            let place = match row.found {
                Found::Searched(cell) => CellKey {
                    block: cell.key.block,
                    town: cell.key.town.clone(),
                    policy: cell.key.policy.clone(),
                    ..CellKey::default()
                },
                Found::Evaluated(cell) => CellKey {
                    controller: String::new(),
                    reward: String::new(),
                    train_town: String::new(),
                    train_policy: String::new(),
                    ..cell.key.clone()
                },
            };
            (report, values, place, matches!(row.found, Found::Searched(_)))
        };
        let mut groups: Vec<Vec<&OverviewRow<'a>>> = Vec::new();
        for row in &overview.rows {
            let is_same = |group: &&mut Vec<&OverviewRow<'a>>| {
                let first = group[0];
                place(first) == place(row) && first.who() == row.who()
            };
            match groups.iter_mut().find(is_same) {
                Some(group) => group.push(row),
                None => groups.push(vec![row]),
            }
        }
        let first = |group: &[&OverviewRow<'a>]| groups.iter().position(|other| place(other[0]) == place(group[0]));
        let pooled = groups.iter().filter_map(|rows| Some(Pooled { rows: rows.clone(), first: first(rows)?, seed }));
        pooled.collect()
    }

    /// The pairs of controllers, or falsifiers, in one town against one driver: a later one and an earlier one.
    pub fn pairs(all: &[Self]) -> Vec<(&Self, &Self)> {
        let mut pairs = Vec::new();
        for (number, own) in all.iter().enumerate() {
            pairs.extend(all[..number].iter().filter(|other| other.first == own.first).map(|other| (own, other)));
        }
        pairs
    }

    /// The controller with its reward, or the falsifier, with its report if another one of the same name is in the same place.
    pub fn who(&self, all: &[Self]) -> String {
        let name = |each: &Self| (each.rows[0].driver(), each.rows[0].town(), each.rows[0].who());
        let own = name(self);
        match all.iter().filter(|each| name(each) == own).count() {
            1 => own.2,
            _ => {
                let seed = self.rows[0].values[self.seed].as_deref().unwrap_or_default();
                format!("{} ({})", own.2, self.rows[0].block_in_words().replacen(&format!("-seed-{seed}"), "", 1))
            }
        }
    }

    /// A figure over the seeds, with Student's interval from four on.
    pub fn figure(&self, metric: &Metric) -> Rate {
        Rate::student(self.runs().iter().map(|row| of_row(row, metric)), 1.0)
    }

    /// The number of episodes of its controller over the seeds; `None` for a search.
    pub fn episodes(&self) -> Option<u32> {
        let episodes = |row: &&OverviewRow<'_>| match row.found {
            Found::Evaluated(cell) => Some(cell.count(&EPISODES)),
            Found::Searched(_) => None,
        };
        self.runs().iter().map(episodes).sum()
    }

    /// The rows that are runs of their own: fixed cases that end alike at every seed are one.
    pub fn runs(&self) -> &[&'a OverviewRow<'a>] {
        let figures = |row: &OverviewRow<'_>| compared().map(|metric| of_row(row, metric)).collect::<Vec<_>>();
        let is_fixed = |row: &OverviewRow<'_>| matches!(row.found, Found::Evaluated(cell) if cell.is_fixed_cases());
        let first = self.rows[0];
        let are_one = self.rows.iter().all(|row| is_fixed(row) && figures(row) == figures(first));
        if are_one { &self.rows[..1] } else { &self.rows }
    }

    /// The difference to another controller or falsifier there, seed by seed.
    pub fn difference(&self, beside: &Self, metric: &Metric) -> Rate {
        let same = |row: &&OverviewRow<'_>| {
            beside.rows.iter().find(|other| other.values[self.seed] == row.values[self.seed]).copied()
        };
        let runs = if beside.runs().len() < beside.rows.len() { self.runs() } else { &self.rows[..] };
        let pairs = runs.iter().filter_map(|row| Some([*row, same(row)?]));
        let difference = |[own, other]: [&OverviewRow<'_>; 2]| Some(of_row(own, metric)? - of_row(other, metric)?);
        let differences: Vec<f64> = pairs.filter_map(difference).collect();
        let interval = base::statistics::mean_interval(&differences).1;
        Rate::of_runs(differences).within(interval, Method::Student)
    }

    /// The probability of such differences if there is none in truth (Student's, two-sided); `None` for one seed and two.
    pub fn p(&self, beside: &Self, metric: &Metric) -> Option<f64> {
        mean_p(&self.difference(beside, metric).by_run)
    }
}

/// A metric in a row; of a search, the share of its starts with a fault stands for the share of episodes with one.
fn of_row(row: &OverviewRow<'_>, metric: &Metric) -> Option<f64> {
    match row.found {
        Found::Evaluated(cell) => cell.value(metric),
        Found::Searched(cell) => cell.fault_start_rate.value.filter(|_| *metric == FAULT_RATE),
    }
}
