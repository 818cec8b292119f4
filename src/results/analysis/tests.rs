use serde_json::Value;

use super::approach::Station;
use super::*;
use crate::failure::Failure;
use world::av::DrivingMode;
use world::env::Impact;
use world::judge::Label;

/// Recorded from scikit-learn by `tests/reference/failure_modes/record.py`.
pub(super) fn recorded() -> Value {
    serde_json::from_str(include_str!("../../../tests/reference/failure_modes/values.json")).unwrap()
}

pub(super) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

pub(super) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

/// The track of a pedestrian that comes from a side (positive: from the left), at this distance (m) three seconds before the touch.
fn from_the_side(side: f64) -> Approach {
    let station = |i: usize| {
        let left = i as f64 / 6.0;
        Station { ahead: 2.0 + 18.0 * (1.0 - left), left: side * (1.0 - left), speed: 6.0 }
    };
    Approach { stations: std::array::from_fn(station) }
}

fn failure(episode: u32, impact: Impact, approach: Option<Approach>) -> Failure {
    let found = crate::failure::tests::failure(Some(Label::Preventable), false, f64::from(episode % 10));
    let driving_mode = Some(DrivingMode::Cruise);
    Failure { number: episode.into(), impact: Some(impact), driving_mode, length: 4.0, approach, ..found }
}

#[test]
fn ways_from_both_sides_are_two_modes_of_one_kind() {
    let spread = |episode: u32| 0.5 * (f64::from(episode) * 0.618_034).fract();
    let mut failures: Vec<Failure> = (0..90)
        .map(|episode: u32| {
            let side = if episode.is_multiple_of(3) { -6.0 } else { 6.0 };
            failure(episode, Impact::Front, Some(from_the_side(side + spread(episode))))
        })
        .collect();
    failures.extend((90..100).map(|episode| failure(episode, Impact::Rear, None)));
    let modes = failure_modes(&failures);
    assert_eq!(modes.len(), 3);
    let [left, right, rear] = [&modes[0], &modes[1], &modes[2]];
    assert_eq!((left.failures, left.members.len(), left.cluster, left.clusters), (90, 60, 0, 2));
    assert_eq!((right.failures, right.members.len(), right.cluster), (90, 30, 1));
    assert!((left.share - 0.6).abs() < 1e-12 && (right.share - 0.3).abs() < 1e-12);
    assert!(!failures[left.medoid].number.is_multiple_of(3) && failures[right.medoid].number.is_multiple_of(3));
    assert!(left.spread.unwrap() < 0.5 && left.stability.unwrap().halves > 0.99);
    assert_eq!((rear.kind.impact, rear.members.len(), rear.spread, rear.stability), (Impact::Rear, 10, None, None));
    assert_eq!(rear.impact_speed, [0.9, 4.5, 8.1], "0 to 9 m/s");
    assert_eq!(failure_modes(&[]), []);
}

#[test]
fn the_medoid_is_the_way_nearest_to_all_others() {
    let failures: Vec<Failure> = [0.0, 1.0, 2.0, 9.0, 3.0]
        .into_iter()
        .enumerate()
        .map(|(episode, side)| failure(episode as u32, Impact::Left, Some(from_the_side(side))))
        .collect();
    let modes = failure_modes(&failures);
    assert_eq!((modes.len(), modes[0].medoid), (1, 2));
}

#[test]
fn distances_between_ways_are_root_means() {
    let (a, mut b) = (from_the_side(0.0), from_the_side(0.0));
    b.stations[6].speed += 7.0;
    assert!((a.distance(&b) - 7.0 / 7.0_f64.sqrt()).abs() < 1e-12, "one of seven stations");
}

#[test]
fn kinds_are_named_for_people() {
    let standing =
        Kind { impact: Impact::Rear, verdict: Label::Bump, occluded: true, mode: DrivingMode::EmergencyStop };
    assert_eq!(standing.to_string(), "rear, bump, occluded, emergency stop");
    let front = Kind::of(&failure(0, Impact::Front, None)).unwrap();
    assert_eq!(front.to_string(), "front, preventable, cruise");
}
