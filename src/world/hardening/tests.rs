use super::drive::{Traffic, TrafficRule};

#[test]
fn limits_are_about_speed_and_hard_braking() {
    let rule = TrafficRule { progress: 0.05, comfort: 0.02 };
    let traffic = |distance: f64, hard_braking: u64| Traffic {
        episodes: 100,
        hard_braking,
        distance,
        time: 100.0,
        ..Traffic::default()
    };
    let before = traffic(1000.0, 5);
    assert!(traffic(960.0, 7).excess(&before, &rule) < 1e-12);
    assert!((traffic(900.0, 5).excess(&before, &rule) - 0.05).abs() < 1e-12);
    assert!((traffic(1000.0, 10).excess(&before, &rule) - 0.03).abs() < 1e-12);
    assert_eq!(Traffic::default().excess(&before, &rule), f64::INFINITY);
}
