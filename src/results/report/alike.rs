//! Failures that happened alike: clusters of what is known of each.

use smartcore::algorithm::neighbour::KNNAlgorithmName;
use smartcore::cluster::dbscan::{DBSCAN, DBSCANParameters};
use smartcore::linalg::basic::matrix::DenseMatrix;

use crate::failure::Failure;
use episode::Impact;
use world::av::DrivingMode;

/// Differences that make two failures unlike: of the speed at the touch (m/s), of the time in sight and of the latest reaction (s).
const SCALES: [f64; 3] = [2.0, 1.0, 0.5];
/// Values above this differ in nothing that a driver could use (s).
const LONG: f64 = 6.0;
/// The coordinate of another side, another action of the driver, or of somebody who came into sight late: more than one unit apart.
const OTHER: f64 = 2.0;

/// The cluster of each of these failures: the same side of the car, the same action of the driver, in sight early or late, and near in numbers. Each is reached
/// from another by steps of at most one unit (DBSCAN). One that is like no other has a number of its own.
pub fn clusters(failures: &[&Failure]) -> Vec<usize> {
    if failures.len() < 2 {
        return (0..failures.len()).collect();
    }
    let rows: Vec<Vec<f64>> = failures.iter().map(|failure| features(failure)).collect();
    let found = || {
        let rows = DenseMatrix::from_2d_vec(&rows)?;
        let parameters = DBSCANParameters::default()
            .with_eps(1.0)
            .with_min_samples(2)
            .with_algorithm(KNNAlgorithmName::LinearSearch);
        DBSCAN::<f64, u32, _, Vec<u32>, _>::fit(&rows, parameters)?.predict(&rows)
    };
    let labels = found().expect("all rows have as many finite values");
    let alone = |(place, label): (usize, u32)| if label == 0 { failures.len() + place } else { label as usize };
    labels.into_iter().enumerate().map(alone).collect()
}

/// What is known of a failure, in units of what makes two unlike.
fn features(failure: &Failure) -> Vec<f64> {
    let numbers = [
        failure.impact_speed,
        failure.in_sight.unwrap_or(LONG).min(LONG),
        failure.latest_reaction.unwrap_or_default().min(LONG),
    ];
    let mut all: Vec<f64> = numbers.iter().zip(SCALES).map(|(value, scale)| value / scale).collect();
    let is = |holds: bool| if holds { OTHER } else { 0.0 };
    all.extend(Impact::ALL.map(|side| is(failure.impact == Some(side))));
    all.extend(DrivingMode::ALL.map(|mode| is(failure.driving_mode == Some(mode))));
    all.push(is(failure.is_occluded()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::tests::failure;
    use verdict::Label;

    #[test]
    fn failures_that_differ_in_kind_or_clearly_in_a_number_are_not_alike() {
        let at = |speed: f64| failure(Some(Label::Preventable), true, speed);
        let side = Failure { impact: Some(Impact::Left), ..at(3.0) };
        let late = Failure { in_sight: Some(0.2), ..at(3.0) };
        // From 3 to 6 m/s in steps that are small, and one far away.
        let all = [at(3.0), at(4.5), at(6.0), at(12.0), side.clone(), late, side];
        let found = clusters(&all.each_ref());
        assert!(found[0] == found[1] && found[1] == found[2] && found[4] == found[6], "{found:?}");
        let different: std::collections::BTreeSet<usize> = found.iter().copied().collect();
        assert_eq!(different.len(), 4, "{found:?}");
        assert!(clusters(&[]).is_empty());
    }
}
