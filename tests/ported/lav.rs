//! LAV's rules, with numbers that its code computes.

use ported::lav::{Blob, BlobKind, BrakeRules, Detector, EgoPoint, Version, WalkerView};

fn body(kind: BlobKind, right: f64, back: f64, half: (f64, f64)) -> Blob {
    Blob::of_body(kind, EgoPoint::new(right, back), 0.0, half.0, half.1, 0.9)
}

#[test]
fn adults_are_too_narrow_and_children_are_not() {
    for (half, seen) in [(0.187_679, false), (0.25, true)] {
        let blob = body(BlobKind::Pedestrian, 1.0, -8.0, (half, half));
        assert_eq!(Detector::new(Version::V2).detect(&[blob]).len(), usize::from(seen), "{half} m");
        assert_eq!(Detector::new(Version::V2Fast).detect(&[blob]).len(), 1, "the fast variant sees both");
    }
}

#[test]
fn places_are_known_to_a_pixel() {
    let blob = body(BlobKind::Vehicle, 3.1, -9.05, (2.4, 1.0));
    assert_eq!(Detector::new(Version::V1).detect(&[blob])[0].place, EgoPoint::new(3.0, -9.0));
}

#[test]
fn the_map_ends_ten_metres_behind() {
    let mut detector = Detector::new(Version::V2);
    assert_eq!(detector.detect(&[body(BlobKind::Vehicle, 0.0, 10.2, (2.4, 1.0))]), []);
    assert_eq!(detector.detect(&[body(BlobKind::Vehicle, 0.0, 9.5, (2.4, 1.0))]).len(), 1);
}

#[test]
fn only_the_strongest_of_a_map_are_looked_at() {
    let row: Vec<Blob> = (0..30)
        .map(|i| Blob {
            score: 0.3 + 0.01 * f64::from(i),
            ..body(BlobKind::Vehicle, -37.0 + 2.5 * f64::from(i), -20.0, (2.0, 1.0))
        })
        .collect();
    let mut detector = Detector::new(Version::V2);
    let found = detector.detect(&row);
    assert_eq!(found.len(), 15);
    assert!(found[0].blob.score > 0.589 && found[14].blob.score > 0.449);
}

#[test]
fn the_foot_of_a_strong_bell_hides_a_weak_one() {
    let strong = body(BlobKind::Vehicle, 0.0, -20.0, (2.0, 1.0));
    let weak = Blob { score: 0.15, column: strong.column + 4.0, ..strong };
    assert_eq!(Detector::new(Version::V2).detect(&[strong, weak]).len(), 1);
    let farther = Blob { column: strong.column + 6.0, ..weak };
    assert_eq!(Detector::new(Version::V2).detect(&[strong, farther]).len(), 2);
}

const RULES: BrakeRules = BrakeRules { ego_half_length: 2.450_842, speed_limit: 30.0 / 3.6 };

fn walker(ahead: f64, right: f64, in_lane: bool) -> WalkerView {
    let place = EgoPoint::new(right, -ahead);
    let from_lane_point = place.distance(EgoPoint::default());
    WalkerView { place, half: 0.187_679, on_sidewalk: false, in_lane, from_lane_point }
}

/// The farthest place ahead at which a rule brakes (m), to a centimetre.
fn farthest(rule: impl Fn(f64) -> bool) -> f64 {
    (0..2000).rev().map(|i| f64::from(i) * 0.01).find(|ahead| rule(*ahead)).unwrap()
}

#[test]
fn distances_are_the_documented_ones() {
    let on_axis = farthest(|ahead| RULES.brake(&walker(ahead, 0.0, true)));
    assert!((on_axis - 6.09).abs() < 0.015, "dead ahead only the map brakes: {on_axis}");
    let in_lane = farthest(|ahead| RULES.brake(&walker(ahead, 0.1, true)));
    assert!((in_lane - 8.64).abs() < 0.015, "{in_lane}");
    assert!(!RULES.brake(&walker(-1.1, 0.0, true)), "behind the ego no wedge reaches");
    let aside = farthest(|right| RULES.brake(&walker(5.0, right, false)));
    assert!((2.5..2.6).contains(&aside), "{aside}");
    assert!((RULES.reach(0.187_679) - 8.64).abs() < 0.015);
}

#[test]
fn the_wedge_narrows_with_the_distance() {
    for (distance, degrees) in [(2.0_f64, 70.4_f64), (4.0, 37.7), (5.0, 30.6)] {
        let at = |bearing: f64| {
            let (sin, cos) = libm::sincos(bearing.to_radians());
            RULES.on_map(&walker(distance * cos, distance * sin, false))
        };
        assert!(at(degrees - 0.3) && !at(degrees + 0.3), "{distance} m");
    }
}
