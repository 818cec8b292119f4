use polars::prelude::{DataFrame, PolarsResult};

use super::Figure;
use super::comparison::{Comparison, compare};
use super::place::Place;
use super::tried::{KEPT, Tried};
use crate::seed::Seed;

/// Compares the runs of one cell on two sides, such as two reports: second less first. Runs of a number belong together, and their episodes
/// of a number have equal starts. Figures without a value on a side are left out; p is not adjusted.
///
/// # Errors
/// Those of polars; none for tables made by [`episodes`](crate::record::episodes).
pub fn sides(first: &[DataFrame], second: &[DataFrame], seed: &Seed) -> PolarsResult<Vec<Comparison>> {
    let of_side = |name: &'static str| {
        move |run: &DataFrame| {
            // Cells of a place differ in their keys, so the driver's name tells the sides apart.
            Tried::of(run, KEPT).map(|mut tried| {
                tried.key.policy = name.into();
                tried
            })
        }
    };
    let filled = |runs: &[DataFrame], name| -> PolarsResult<Vec<Tried>> {
        runs.iter().filter(|run| run.height() > 0).map(of_side(name)).collect()
    };
    let place = Place::new([filled(first, "first")?, filled(second, "second")?].concat());
    if place.cells.len() < 2 {
        return Ok(Vec::new());
    }
    let agree = |figure| {
        let partner = |run: &Tried| place.runs(0).iter().find(|other| other.run == run.run);
        let mut pairs = place.runs(1).iter().filter_map(|run| Some((run, partner(run)?)));
        pairs.all(|(run, other)| run.discordant(other, figure) == (0, 0))
    };
    let compared = |figure| {
        let mut found = compare(&place, &place.measure(figure), (1, 0), seed)?;
        if agree(figure) {
            // Without a pair that disagrees the samples show no spread, but not that there is no difference.
            let most = most_unseen(found.episodes);
            (found.bootstrap, found.student) = ((-most, most), None);
        }
        Some(found)
    };
    Ok(Figure::COMPARED.into_iter().filter_map(compared).collect())
}

/// The greatest share of pairs that may disagree in one direction when none of this number does: the high end of Clopper and Pearson's 95 %
/// interval for 0 of n.
pub fn most_unseen(pairs: u64) -> f64 {
    1.0 - libm::pow(0.025, 1.0 / pairs.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::most_unseen;

    #[test]
    fn no_pair_that_disagrees_leaves_room_for_a_difference() {
        // scipy.stats.binomtest(0, n).proportion_ci(method="exact").high
        for (pairs, wanted) in [(1, 0.975), (10, 0.308_497_1), (400, 0.009_179_8)] {
            assert!((most_unseen(pairs) - wanted).abs() < 1e-6, "{pairs}: {}", most_unseen(pairs));
        }
    }
}
