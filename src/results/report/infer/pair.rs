use polars::prelude::{DataFrame, PolarsResult};

use super::Figure;
use super::comparison::{Comparison, compare};
use super::evaluated_run::{EvaluatedRun, MAX_KEPT};
use super::place::Place;

/// Compares the runs of one cell on two sides, such as two reports: second less first. Runs of a number belong together, and their episodes
/// of a number have equal starts. Figures without a value on a side are left out; p is not adjusted.
///
/// # Errors
/// Those of polars; none for tables made by [`episodes`](crate::record::episodes).
pub fn compare_pair(first: &[DataFrame], second: &[DataFrame]) -> PolarsResult<Vec<Comparison>> {
    let of_side = |name: &'static str| {
        move |run: &DataFrame| {
            // Cells of a place differ in their keys, so the driver's name tells the sides apart.
            EvaluatedRun::of(run, MAX_KEPT).map(|mut evaluated| {
                evaluated.key.policy = name.into();
                evaluated
            })
        }
    };
    let filled = |runs: &[DataFrame], name| -> PolarsResult<Vec<EvaluatedRun>> {
        runs.iter().filter(|run| run.height() > 0).map(of_side(name)).collect()
    };
    let place = Place::new([filled(first, "first")?, filled(second, "second")?].concat());
    if place.cells.len() < 2 {
        return Ok(Vec::new());
    }
    let agree = |figure| {
        let partner = |run: &EvaluatedRun| place.runs(0).iter().find(|other| other.run == run.run);
        let mut pairs = place.runs(1).iter().filter_map(|run| Some((run, partner(run)?)));
        pairs.all(|(run, other)| run.discordant(other, figure) == (0, 0))
    };
    let compared = |figure| {
        let mut found = compare(&place, &place.measure(figure), (1, 0))?;
        if agree(figure) {
            // Without a pair that disagrees the samples show no spread, but not that there is no difference.
            found.discordant = Some((0, 0));
        }
        Some(found)
    };
    Ok(Figure::COMPARED.into_iter().filter_map(compared).collect())
}
