//! Networks that imitate a controller.

use base::seed::Seed;
use learn::{ActorCritic, Fitted, PpoConfig, fit};

#[test]
fn a_network_learns_a_curve_until_it_is_stopped() {
    let seed = Seed::root(5);
    let config = PpoConfig { batch_size: 32, portable_bits: true, ..PpoConfig::paper() };
    let observations: Vec<f32> = (0..512).map(|i| i as f32 / 256.0 - 1.0).collect();
    let wanted = |x: f32| 0.8 * libm::sinf(3.0 * x);
    let targets: Vec<f32> = observations.iter().map(|x| wanted(*x)).collect();
    let mut networks = ActorCritic::new(1, 1, &[32, 32], 0.0, &mut seed.stream());
    let before = networks.clone();
    let data = (observations.as_slice(), targets.as_slice());
    fit(&mut networks, Fitted::Actor, data, (200, 3e-3), &config, &seed, &|| true);
    assert_eq!(networks, before);
    let error = fit(&mut networks, Fitted::Actor, data, (200, 3e-3), &config, &seed, &|| false);
    assert!(error < 1e-3, "{error}");
    let (mut out, mut scratch) = ([0.0], networks.scratch(1));
    for x in [-0.9, -0.3, 0.2, 0.7] {
        networks.act(&[f64::from(x)], &mut out, &mut scratch);
        assert!((out[0] - f64::from(wanted(x))).abs() < 0.1, "{x}: {out:?}");
    }
    assert_eq!(networks.value(&[0.3], &mut scratch), before.value(&[0.3], &mut scratch), "the critic keeps its own");
}
