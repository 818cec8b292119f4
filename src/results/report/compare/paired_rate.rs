use polars::prelude::{DataFrame, PolarsError, PolarsResult};

use crate::report::infer::Comparison;
use crate::tables::metrics::{COLLISION_RATE, FAULT_RATE, IMPACT_SPEED, PREVENTABLE_RATE, compared};
use crate::tables::pairs::{self, PAIRS};
use crate::tables::{Changed, Metric};
use base::statistics::{disagreement, holm, mcnemar, mean_disagreement, mean_interval_at, mean_p, sign_flip};

/// What is counted of the violations of a requirement: all, the preventable ones and the faults. The metric of collisions stands for all of them.
pub const VIOLATIONS: [&Metric; 3] = [&COLLISION_RATE, &PREVENTABLE_RATE, &FAULT_RATE];

/// What is counted in a pair of episodes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CountedEvent {
    /// Collisions, the preventable ones, or the faults; the impact speed in [`CountedEvent::WORSE`].
    pub figure: &'static Metric,
    /// The requirement whose violations are counted; `None` for collisions.
    pub requirement: Option<String>,
}

impl CountedEvent {
    /// A collision of both sides that is worse on one.
    pub const WORSE: Self = Self { figure: &IMPACT_SPEED, requirement: None };

    /// Those of episodes, then those of each requirement, then [`CountedEvent::WORSE`].
    pub fn all<'a>(requirements: impl Iterator<Item = &'a String>) -> Vec<Self> {
        let of_collisions = compared().map(|figure| Self { figure, requirement: None });
        let of = |name: String| VIOLATIONS.map(|figure| Self { figure, requirement: Some(name.clone()) });
        of_collisions.chain(requirements.cloned().flat_map(of)).chain([Self::WORSE]).collect()
    }

    /// The start of the columns of its rate.
    pub fn rate(&self) -> String {
        match &self.requirement {
            None if *self.figure == IMPACT_SPEED => "worse_rate".into(),
            None => self.figure.name.into(),
            Some(name) if *self.figure == COLLISION_RATE => format!("violation_rate({name})"),
            Some(name) => format!("{}({name})", self.figure.name),
        }
    }

    /// The start of the columns of its number.
    pub fn number(&self) -> String {
        let is_of_any = [COLLISION_RATE, IMPACT_SPEED].contains(self.figure);
        let word = match &self.requirement {
            None if is_of_any => "collisions",
            Some(_) if is_of_any => "",
            _ => self.figure.name.trim_end_matches("_rate"),
        };
        match &self.requirement {
            None => word.into(),
            Some(name) if word.is_empty() => format!("violations({name})"),
            Some(name) => format!("{word}_violations({name})"),
        }
    }

    /// Whether it is of violations of any kind.
    pub fn is_violation(&self) -> bool {
        self.requirement.is_some() && *self.figure == COLLISION_RATE
    }
}

/// How often an event is on both sides, over pairs with equal starts, and whether the difference is beyond chance.
#[derive(Debug, Clone, Default)]
pub struct PairedRate {
    /// Before and after: mean over runs.
    pub values: [f64; 2],
    pub changed: Changed,
    /// Second less first, of each run.
    pub by_run: Vec<f64>,
    /// Whether all pairs are the same byte for byte: the driver did not change, and there is nothing to test.
    pub is_unchanged: bool,
    /// Probability of such a difference by chance; `None` without a pair.
    pub p: Option<f64>,
    /// The same, adjusted by Holm's method for all rates that are tested together.
    pub holm: Option<f64>,
    /// An interval of second less first such that, in 95 % of comparisons, those of all rates that are tested together hold the truth (Bonferroni).
    /// `None` for two and three runs.
    pub interval: Option<(f64, f64)>,
    spread: Spread,
}

/// What tells how much of a difference is chance.
#[derive(Debug, Clone, Default)]
enum Spread {
    /// The runs, or where there is one or none differs, their common starts.
    Runs { starts: u64 },
    /// Runs with the starts that they share.
    Cell(Box<Comparison>),
    /// Starts, over which several controllers are pooled: second less first of each, as a share of the mean number of pairs of a start.
    Starts(Vec<f64>),
    #[default]
    None,
}

impl PairedRate {
    /// Of the runs of a cell.
    pub fn of_cell(compared: Comparison, changed: Changed) -> Self {
        Self {
            values: [compared.values[1], compared.values[0]],
            changed,
            by_run: compared.by_run[0].clone(),
            p: if changed.is_same() { Some(1.0) } else { compared.p },
            spread: Spread::Cell(Box::new(compared)),
            ..Self::default()
        }
    }

    /// Of runs with a rate on either side, over this number of starts.
    pub fn of_runs(values: &[[f64; 2]], changed: Changed, starts: u64) -> Self {
        let by_run: Vec<f64> = values.iter().map(|[before, after]| after - before).collect();
        let n = by_run.len().max(1) as f64;
        let p = match by_run.len() {
            0 => None,
            _ if changed.is_same() => Some(1.0),
            1 => Some(mcnemar(changed.fixed, changed.new)),
            _ => mean_p(&by_run),
        };
        let mean = |side: usize| values.iter().map(|each| each[side]).sum::<f64>() / n;
        Self { values: [mean(0), mean(1)], changed, by_run, p, spread: Spread::Runs { starts }, ..Self::default() }
    }

    /// Of starts with their pairs of episodes (see [`pairs::starts`]). Starts are independent of each other, and the episodes of a start are not: the sum
    /// over starts is tested, whose sign is that of the difference.
    ///
    /// # Errors
    /// Those of polars; none for a table with the event.
    pub fn of_starts(starts: &DataFrame, event: &str, changed: Changed) -> PolarsResult<Self> {
        let counts = |name: &str| Ok::<_, PolarsError>(starts.column(name)?.u32()?.into_no_null_iter().map(i64::from));
        let [before, after] = pairs::sides(event);
        let differences: Vec<i64> =
            counts(&after)?.zip(counts(&before)?).map(|(after, before)| after - before).collect();
        let pairs = counts(PAIRS)?.sum::<i64>().max(1) as f64;
        let rate = |name: &str| Ok::<_, PolarsError>(counts(name)?.sum::<i64>() as f64 / pairs);
        let each = differences.len() as f64 / pairs;
        Ok(Self {
            values: [rate(&before)?, rate(&after)?],
            changed,
            p: (!differences.is_empty()).then(|| sign_flip(&differences)),
            spread: Spread::Starts(differences.iter().map(|difference| *difference as f64 * each).collect()),
            ..Self::default()
        })
    }

    /// Second less first.
    pub fn difference(&self) -> f64 {
        self.values[1] - self.values[0]
    }

    /// An interval that misses the difference with a probability of at most `alpha`.
    pub fn interval_at(&self, alpha: f64) -> Option<(f64, f64)> {
        let Changed { fixed, new, .. } = self.changed;
        match &self.spread {
            _ if self.is_unchanged => Some((0.0, 0.0)),
            Spread::None => None,
            Spread::Cell(compared) => compared.interval_at(alpha),
            Spread::Starts(differences) => Some(mean_disagreement(differences, self.p?, alpha)),
            Spread::Runs { .. } if self.by_run.is_empty() => None,
            // Without a start that differs the runs show no spread, but not that there is no difference.
            Spread::Runs { starts } if self.by_run.len() == 1 || self.changed.is_same() => {
                Some(disagreement(fixed, new, *starts, alpha))
            }
            Spread::Runs { .. } => {
                mean_interval_at(&self.by_run, alpha).map(|(low, high)| (low.max(-1.0), high.min(1.0)))
            }
        }
    }

    /// Adjusts p and the intervals of rates that are tested together. One that could not be significant, since no pair differs in it, costs the others
    /// nothing; neither does an unchanged driver.
    pub fn adjust<'a>(rates: impl Iterator<Item = &'a mut Self>) {
        let mut rates: Vec<&mut Self> = rates.collect();
        let is_tested = |rate: &Self| rate.p.is_some() && !rate.changed.is_same();
        let raw: Vec<f64> = rates.iter().filter(|rate| is_tested(rate)).filter_map(|rate| rate.p).collect();
        let mut adjusted = holm(&raw).into_iter();
        let alpha = 0.05 / rates.iter().filter(|rate| !rate.is_unchanged).count().max(1) as f64;
        for rate in &mut rates {
            rate.holm = if is_tested(rate) { adjusted.next() } else { rate.p };
            rate.interval = rate.interval_at(alpha);
        }
    }
}

#[cfg(test)]
mod tests {
    use polars::prelude::Column;

    use super::*;

    /// Starts with their number of pairs, and the number of faults on either side.
    fn of_starts(starts: &[(u32, [u32; 2])]) -> PairedRate {
        let column = |name: &str, of: fn(&(u32, [u32; 2])) -> u32| {
            Column::new(name.into(), starts.iter().map(of).collect::<Vec<u32>>())
        };
        let [before, after] = pairs::sides("fault");
        let columns = vec![
            column(PAIRS, |start| start.0),
            column(&before, |start| start.1[0]),
            column(&after, |start| start.1[1]),
        ];
        let table = DataFrame::new(starts.len(), columns).unwrap();
        let changed = Changed::of(&table, &["fault".into()]).unwrap()[0];
        PairedRate::of_starts(&table, "fault", changed).unwrap()
    }

    /// A driver with two controllers, 100 starts; on the second side so many starts have a fault with one of them.
    fn worse_from(starts: u32) -> PairedRate {
        let starts: Vec<(u32, [u32; 2])> = (0..100).map(|start| (2, [0, u32::from(start < starts)])).collect();
        of_starts(&starts)
    }

    #[test]
    fn six_new_faults_over_two_controllers_show_and_an_unchanged_driver_costs_nothing() {
        let mut rates = [worse_from(6), worse_from(0), worse_from(0)];
        rates[1].is_unchanged = true;
        PairedRate::adjust(rates.iter_mut());
        let [changed, unchanged, equal] = &rates;
        assert_eq!((changed.values, changed.changed.new), ([0.0, 0.03], 6));
        assert!((changed.holm.unwrap() - 1.0 / 32.0).abs() < 1e-12, "{:?}", changed.holm);
        assert_eq!((unchanged.holm, unchanged.interval), (Some(1.0), Some((0.0, 0.0))));
        // Equal in all starts, but not the same: its interval counts.
        assert_eq!((equal.holm, equal.interval), (Some(1.0), Some(disagreement(0, 0, 100, 0.025))));
        assert_eq!(changed.interval, changed.interval_at(0.025));
    }

    #[test]
    fn the_sign_of_what_is_tested_over_starts_is_that_of_the_difference() {
        // Ten starts lose a fault each, and two gain eight: there are more faults after.
        let mut starts = vec![(8, [1, 0]); 10];
        starts.extend([(8, [0, 8]); 2]);
        let rate = of_starts(&starts);
        assert_eq!(rate.changed, Changed { fixed: 10, new: 2, same: 0 });
        assert!(rate.difference() > 0.0 && mcnemar(10, 2) < 0.05);
        assert!(rate.p.unwrap() > 0.4, "no more than chance: {:?}", rate.p);
        let (low, high) = rate.interval_at(0.05).unwrap();
        assert!(low < 0.0 && high > 0.0, "{low}..{high}");
    }
}
