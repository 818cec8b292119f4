use super::common_starts::CommonStarts;
use super::comparison::{Comparison, compare};
use super::evaluated_run::EvaluatedRun;
use crate::tables::Metric;

/// Compares the runs of one cell on two sides, such as two reports: second less first. Runs of a number belong together, and their episodes
/// of a number have equal starts. Metrics without a value on a side are left out; p is not adjusted.
pub fn compare_pair([mut first, mut second]: [Vec<EvaluatedRun>; 2], metrics: &[&'static Metric]) -> Vec<Comparison> {
    // Cells of a place differ in their keys, so the driver's name tells the sides apart.
    first.iter_mut().for_each(|run| run.key.policy = "first".into());
    second.iter_mut().for_each(|run| run.key.policy = "second".into());
    let place = CommonStarts::new([first, second].concat());
    if place.cells.len() < 2 {
        return Vec::new();
    }
    let agree = |metric: &Metric| {
        let partner = |run: &EvaluatedRun| place.runs(0).iter().find(|other| other.run == run.run);
        let mut pairs = place.runs(1).iter().filter_map(|run| Some((run, partner(run)?)));
        pairs.all(|(run, other)| run.discordant(other, metric) == (0, 0))
    };
    let compared = |metric: &'static Metric| {
        let mut found = compare(&place, &place.measure(metric), (1, 0))?;
        if agree(metric) {
            // Without a pair that disagrees the samples show no spread, but not that there is no difference.
            found.discordant = Some((0, 0));
        }
        Some(found)
    };
    metrics.iter().copied().filter_map(compared).collect()
}
