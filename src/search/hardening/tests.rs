use super::TrafficRule;
use verdict::Traffic;

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
    assert!(rule.excess(&traffic(960.0, 7), &before) < 1e-12);
    assert!((rule.excess(&traffic(900.0, 5), &before) - 0.05).abs() < 1e-12);
    assert!((rule.excess(&traffic(1000.0, 10), &before) - 0.03).abs() < 1e-12);
    assert_eq!(rule.excess(&Traffic::default(), &before), f64::INFINITY);
}
