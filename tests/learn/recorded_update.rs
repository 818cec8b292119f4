//! One update of the learner compared with the same update by stable-baselines3.
//!
//! `tests/reference/sb3_update` holds the recording and the script that made it.

use std::path::PathBuf;

use learn::{ADAM_EPS, ActorCritic, PpoConfig, RecordedRollout, update_on_recorded};
use safetensors::SafeTensors;
use serde_json::Value;

/// The recording computes values and advantages in single precision.
const SINGLE: f64 = 2e-5;
/// The tolerance of a weight: five times the rounding error of single precision.
///
/// The update moves weights by up to 8·10⁻³.
const WEIGHT: f64 = 1e-6;

fn file(name: &str) -> PathBuf {
    crate::repository().join("tests/reference/sb3_update").join(name)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// The numbers as recorded, in single precision.
fn singles(value: &Value) -> Vec<f64> {
    numbers(value).iter().map(|x| f64::from(*x as f32)).collect()
}

fn largest_difference(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    ours.iter().zip(theirs).map(|(ours, theirs)| (ours - theirs).abs()).fold(0.0, f64::max)
}

/// All tensors of a file under their names.
fn weights(bytes: &[u8]) -> Vec<(String, Vec<f64>)> {
    let tensors = SafeTensors::deserialize(bytes).unwrap();
    let decode = |data: &[u8]| data.as_chunks().0.iter().map(|x| f64::from(f32::from_le_bytes(*x))).collect();
    let mut found: Vec<_> = tensors.iter().map(|(name, view)| (name.to_owned(), decode(view.data()))).collect();
    found.sort_by(|(a, _), (b, _)| a.cmp(b));
    found
}

/// The largest difference between equally named tensors.
fn worst(ours: &[(String, Vec<f64>)], theirs: &[(String, Vec<f64>)]) -> f64 {
    assert!(ours.iter().map(|(name, _)| name).eq(theirs.iter().map(|(name, _)| name)));
    ours.iter().zip(theirs).map(|((_, ours), (_, theirs))| largest_difference(ours, theirs)).fold(0.0, f64::max)
}

#[test]
fn an_update_agrees_with_stable_baselines3() {
    let recording: Value = serde_json::from_str(&std::fs::read_to_string(file("rollout.json")).unwrap()).unwrap();
    let (before, _) = ActorCritic::from_safetensors(&std::fs::read(file("before.safetensors")).unwrap()).unwrap();
    let column = |name: &str| singles(&recording[name]);
    let rollout = RecordedRollout {
        obs: column("observations").iter().map(|x| *x as f32).collect(),
        actions: column("actions"),
        rewards: column("rewards"),
        episode_starts: recording["episode_starts"].as_array().unwrap().iter().map(|x| x == true).collect(),
        last_obs: column("last_obs"),
        last_done: recording["last_done"] == true,
    };
    let index = |x: f64| x as usize;
    let order: Vec<Vec<usize>> = recording["order"]
        .as_array()
        .unwrap()
        .iter()
        .map(|epoch| numbers(epoch).into_iter().map(index).collect())
        .collect();

    // The recording was made with our settings.
    let config = PpoConfig::paper();
    let setting = |name: &str| recording["settings"][name].as_f64().unwrap();
    assert_eq!(
        [
            config.learning_rate,
            config.gamma,
            config.gae_lambda,
            config.clip,
            config.value_coefficient,
            config.entropy_coefficient
        ],
        ["learning_rate", "gamma", "gae_lambda", "clip_range", "vf_coef", "ent_coef"].map(setting)
    );
    assert_eq!([config.max_gradient_norm, ADAM_EPS], ["max_grad_norm", "adam_eps"].map(setting));
    let sizes = ["n_steps", "batch_size", "n_epochs"].map(|name| index(setting(name)));
    assert_eq!([config.steps_per_update, config.batch_size, config.epochs], sizes);

    let update = update_on_recorded(before.clone(), &rollout, &order, &config).unwrap();
    for (name, ours) in [
        ("values", &update.values),
        ("log_probs", &update.log_probs),
        ("advantages", &update.advantages),
        ("returns", &update.returns),
    ] {
        let difference = largest_difference(ours, &column(name));
        eprintln!("{name}: the largest difference is {difference:.1e}");
        assert!(difference < SINGLE, "{name} differ by {difference}");
    }
    for (name, ours) in [
        ("policy_gradient_loss", update.policy_loss),
        ("value_loss", update.value_loss),
        ("entropy_loss", -update.entropy),
        ("approx_kl", update.approx_kl),
        ("clip_fraction", update.clip_fraction),
    ] {
        let theirs = recording["logged"][name].as_f64().unwrap();
        eprintln!("{name}: {ours:.9} and {theirs:.9}");
        assert!((ours - theirs).abs() < SINGLE, "{name}: {ours} is not {theirs}");
    }
    // Otherwise the recording would not show whether clipping is right.
    assert!(update.clip_fraction > 0.01);

    let bytes = |policy: &ActorCritic| policy.to_safetensors(&std::collections::BTreeMap::new());
    let recorded = weights(&std::fs::read(file("after.safetensors")).unwrap());
    let (start, end) = (weights(&bytes(&before)), weights(&bytes(&update.actor_critic)));
    for (((name, ours), (_, theirs)), (_, start)) in end.iter().zip(&recorded).zip(&start) {
        let (difference, movement) = (largest_difference(ours, theirs), largest_difference(start, theirs));
        eprintln!("{name}: moved by up to {movement:.1e}, the largest difference is {difference:.1e}");
        assert!(movement > 100.0 * WEIGHT, "{name} hardly moves, which proves nothing");
    }
    let (worst_weight, noise) = (worst(&end, &recorded), recording["noise"].as_f64().unwrap());
    eprintln!("all weights: {worst_weight:.2e}; rounding to single precision alone is worth {noise:.1e}");
    assert!(worst_weight < WEIGHT, "a weight is off by {worst_weight}");

    // Every setting affects the weights: a wrong setting would be noticed.
    for (name, other) in [
        ("learning rate", PpoConfig { learning_rate: 3.01e-4, ..config.clone() }),
        ("discount", PpoConfig { gamma: 0.981, ..config.clone() }),
        ("decay", PpoConfig { gae_lambda: 0.951, ..config.clone() }),
        ("clip interval", PpoConfig { clip: 0.25, ..config.clone() }),
        ("value coefficient", PpoConfig { value_coefficient: 0.51, ..config.clone() }),
        ("entropy coefficient", PpoConfig { entropy_coefficient: 0.011, ..config.clone() }),
        ("gradient norm", PpoConfig { max_gradient_norm: 0.51, ..config.clone() }),
        ("batch size", PpoConfig { batch_size: 65, ..config.clone() }),
        ("standardised advantages", PpoConfig { normalize_advantages: false, ..config.clone() }),
    ] {
        let changed = update_on_recorded(before.clone(), &rollout, &order, &other).unwrap();
        let difference = worst(&weights(&bytes(&changed.actor_critic)), &recorded);
        eprintln!("with another {name}: {difference:.1e}");
        assert!(difference > 10.0 * WEIGHT, "the {name} does not show: {difference}");
    }
}
