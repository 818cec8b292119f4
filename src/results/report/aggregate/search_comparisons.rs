use std::collections::BTreeMap;

#[cfg(test)]
use super::search_figures::FAILED_STARTS;
use super::search_figures::{FAULT_START_RATE, Figures};
use crate::jobs::SearchResult;
use crate::report::grouped::grouped;
use base::statistics::{holm, mean_interval_at, mean_p};
use compile::SearchKey;

/// Two falsifiers against one driver, or one falsifier against two drivers, compared run by run: equal runs have equal starts.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchComparison {
    pub town: String,
    /// Falsifier and driver of either side.
    pub one: (String, String),
    pub other: (String, String),
    /// The number of the block in the campaign.
    pub block: u32,
    /// The column of `searches` that is compared.
    pub figure: &'static str,
    /// Runs with the figure on both sides.
    pub runs: u64,
    /// Means over these.
    pub values: [f64; 2],
    /// First less second, of each run.
    pub differences: Vec<f64>,
    pub difference: f64,
    /// In 95 % of campaigns those of all rows that are read together hold the truth.
    pub interval: Option<(f64, f64)>,
    p: Option<f64>,
    /// After Holm's correction for the rows that are read together.
    pub p_holm: Option<f64>,
}

impl SearchComparison {
    /// Two falsifiers against one driver in a town, by their failed starts.
    #[cfg(test)]
    pub fn of_failed_starts(town: &str, [one, other]: [&str; 2], differences: &[f64], p_holm: f64) -> Self {
        Self {
            town: town.into(),
            one: (one.into(), "driver".into()),
            other: (other.into(), "driver".into()),
            block: 0,
            figure: FAILED_STARTS,
            runs: differences.len() as u64,
            values: [0.0; 2],
            differences: differences.to_vec(),
            difference: differences.iter().sum::<f64>() / differences.len() as f64,
            interval: None,
            p: None,
            p_holm: Some(p_holm),
        }
    }

    /// Whether two falsifiers are compared, rather than two drivers.
    pub fn is_of_falsifiers(&self) -> bool {
        self.one.1 == self.other.1
    }

    /// Whether another one compares the same two searches, by another figure.
    pub fn is_of_same_pair(&self, other: &Self) -> bool {
        let pair = |of: &Self| (of.town.clone(), of.one.clone(), of.other.clone(), of.block);
        pair(self) == pair(other)
    }
}

/// All comparisons of the searches of a campaign, in the order of their first side.
///
/// Holm's correction, and Bonferroni's of the intervals, cover all rows that are read together: those of a figure for all pairs of falsifiers, or for all pairs of drivers, in all
/// towns and blocks.
pub fn search_comparisons(results: &[SearchResult]) -> Vec<SearchComparison> {
    compared(results.iter().map(|result| (&result.key, Figures::new(result).compared())))
}

/// The figures of a search, with their names.
type Named = [(&'static str, Option<f64>); 4];

/// Compares searches by their figures.
fn compared<'a>(searches: impl Iterator<Item = (&'a SearchKey, Named)>) -> Vec<SearchComparison> {
    let cells = grouped(searches, |search| search.0.cell());
    let mut all = Vec::new();
    for (place, one) in cells.iter().enumerate() {
        for other in &cells[place + 1..] {
            let (a, b) = (one[0].0, other[0].0);
            let one_differs = (a.falsifier == b.falsifier) != (a.policy == b.policy);
            if a.town == b.town && a.block == b.block && one_differs {
                all.extend(compare(one, other));
            }
        }
    }
    let mut families: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (place, each) in all.iter().enumerate() {
        families.entry((each.figure, each.is_of_falsifiers())).or_default().push(place);
    }
    for family in families.values() {
        let alpha = 0.05 / family.len() as f64;
        for place in family {
            let each: &mut SearchComparison = &mut all[*place];
            each.interval = mean_interval_at(&each.differences, alpha).map(|ends| cut(ends, each.figure));
        }
        let tested: Vec<usize> = family.iter().copied().filter(|place| all[*place].p.is_some()).collect();
        let p: Vec<f64> = tested.iter().filter_map(|place| all[*place].p).collect();
        for (place, adjusted) in tested.into_iter().zip(holm(&p)) {
            all[place].p_holm = Some(adjusted);
        }
    }
    all
}

/// The comparisons of two cells, one for each figure that both have.
fn compare(one: &[(&SearchKey, Named)], other: &[(&SearchKey, Named)]) -> Vec<SearchComparison> {
    let (a, names) = &one[0];
    let b = other[0].0;
    let comparison = |figure: usize| {
        let pairs: Vec<(f64, f64)> = one
            .iter()
            .filter_map(|(key, figures)| {
                let same = other.iter().find(|(each, _)| each.run == key.run)?;
                figures[figure].1.zip(same.1[figure].1)
            })
            .collect();
        let n = pairs.len() as f64;
        let differences: Vec<f64> = pairs.iter().map(|(one, other)| one - other).collect();
        (!pairs.is_empty()).then(|| SearchComparison {
            town: a.town.clone(),
            one: (a.falsifier.clone(), a.policy.clone()),
            other: (b.falsifier.clone(), b.policy.clone()),
            block: a.block,
            figure: names[figure].0,
            runs: pairs.len() as u64,
            values: [
                pairs.iter().map(|pair| pair.0).sum::<f64>() / n,
                pairs.iter().map(|pair| pair.1).sum::<f64>() / n,
            ],
            difference: differences.iter().sum::<f64>() / n,
            interval: None,
            p: mean_p(&differences),
            differences,
            p_holm: None,
        })
    };
    (0..names.len()).filter_map(comparison).collect()
}

/// Cuts the interval of a difference of shares at -1 and 1.
fn cut((low, high): (f64, f64), figure: &str) -> (f64, f64) {
    if figure == FAULT_START_RATE { (low.max(-1.0), high.min(1.0)) } else { (low, high) }
}

#[cfg(test)]
mod tests {
    use rand::Rng;

    use super::*;
    use base::seed::{Seed, Stream};

    /// Drivers, towns and runs of the audited ranking.
    const CAMPAIGN: [u32; 3] = [11, 3, 10];

    /// A search with this figure `a`, and no other.
    fn search(driver: u32, town: u32, run: u32, figure: f64) -> (SearchKey, Named) {
        let key = SearchKey {
            falsifier: "f".into(),
            method: "archive",
            reward: String::new(),
            town: format!("town_{town}"),
            policy: format!("driver_{driver}"),
            block: 0,
            run,
        };
        (key, ["a", "b", "c", "d"].map(|name| (name, (name == "a").then_some(figure))))
    }

    /// A campaign whose drivers do not differ: each run of a town has its own difficulty, and each driver finds faults from 60 starts of it by
    /// chance alone. With `better`, the first driver finds none.
    fn campaign(stream: &mut Stream, better: bool) -> Vec<(SearchKey, Named)> {
        let [drivers, towns, runs] = CAMPAIGN;
        let mut uniform = || f64::from(stream.next_u32()) / 2_f64.powi(32);
        let mut all = Vec::new();
        for town in 0..towns {
            for run in 0..runs {
                let difficulty = 0.1 + 0.1 * f64::from(town) + 0.1 * uniform();
                for driver in 0..drivers {
                    let found = (0..60).filter(|_| uniform() < difficulty).count() as f64 / 60.0;
                    all.push(search(driver, town, run, if better && driver == 0 { 0.0 } else { found }));
                }
            }
        }
        all
    }

    /// The number of rows with a p below 0.05.
    fn findings(searches: &[(SearchKey, Named)], p: fn(&SearchComparison) -> Option<f64>) -> usize {
        let all = compared(searches.iter().map(|(key, figures)| (key, *figures)));
        assert_eq!(all.len(), 165, "55 pairs of drivers in 3 towns");
        all.iter().filter(|each| p(each).is_some_and(|p| p < 0.05)).count()
    }

    #[test]
    fn in_95_of_100_campaigns_without_a_difference_no_finding_is_false() {
        const CAMPAIGNS: u64 = 200;
        let (mut raw, mut adjusted) = (0, 0);
        for number in 0..CAMPAIGNS {
            let searches = campaign(&mut Seed::root(41).index(number).stream(), false);
            raw += u64::from(findings(&searches, |each| each.p) > 0);
            adjusted += u64::from(findings(&searches, |each| each.p_holm) > 0);
        }
        // Of 200 campaigns at 0.05 the share has a standard deviation of 0.015.
        let share = |number: u64| number as f64 / CAMPAIGNS as f64;
        assert!(share(adjusted) <= 0.09, "{}", share(adjusted));
        assert!(share(raw) > 0.9, "without the correction hardly a campaign is free of one: {}", share(raw));
    }

    #[test]
    fn a_driver_that_is_better_is_found_in_every_town() {
        let searches = campaign(&mut Seed::root(43).stream(), true);
        assert!(findings(&searches, |each| each.p_holm) >= 28, "of 30 rows with it");
    }
}
