use super::Figure;
use super::comparison::{Comparison, compare};
use super::evaluated_run::EvaluatedRun;
use super::place::Place;

/// Compares the runs of one cell on two sides, such as two reports: second less first. Runs of a number belong together, and their episodes
/// of a number have equal starts. Figures without a value on a side are left out; p is not adjusted.
pub fn compare_pair([mut first, mut second]: [Vec<EvaluatedRun>; 2]) -> Vec<Comparison> {
    // Cells of a place differ in their keys, so the driver's name tells the sides apart.
    first.iter_mut().for_each(|run| run.key.policy = "first".into());
    second.iter_mut().for_each(|run| run.key.policy = "second".into());
    let place = Place::new([first, second].concat());
    if place.cells.len() < 2 {
        return Vec::new();
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
    Figure::COMPARED.into_iter().filter_map(compared).collect()
}
